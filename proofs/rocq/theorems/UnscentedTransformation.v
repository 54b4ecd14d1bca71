(* The points and weights of the unscented transformation have the mean x and the covariance P: (8.12),
   with gamma_0 = (alpha - n) / alpha, where (8.11) has n in the denominator. *)
From mathcomp Require Import all_ssreflect all_algebra zify ring.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section UnscentedTransformation.
Variables (R : fieldType) (n : nat).
Variables (x : 'cV[R]_n) (P S : 'M[R]_n) (root alpha : R).
Hypothesis square_root : S *m S^T = P.
Hypotheses (two : 2%:R != 0 :> R) (nz_alpha : alpha != 0) (root_alpha : root ^+ 2 = alpha).

(* (8.10): x, then x + root S_i and x - root S_i; the weights of the last two are 1 / (2 alpha). *)
Definition point_above i := x + root *: col i S.
Definition point_below i := x - root *: col i S.
Definition centre_weight := (alpha - n%:R) / alpha.
Definition point_weight := (2%:R * alpha)^-1.

Lemma outer_products : \sum_i col i S *m (col i S)^T = P.
Proof.
rewrite -square_root; apply/matrixP=> i j; rewrite summxE mxE; apply: eq_bigr => k _.
by rewrite mxE big_ord1 !mxE.
Qed.

Theorem mean_8_12 :
  centre_weight *: x + \sum_i point_weight *: point_above i + \sum_i point_weight *: point_below i = x.
Proof.
rewrite -addrA -big_split /=.
have term i : point_weight *: point_above i + point_weight *: point_below i = alpha^-1 *: x.
  rewrite -scalerDr /point_above /point_below addrACA subrr addr0 -mulr2n -scaler_nat scalerA.
  by congr (_ *: _); rewrite /point_weight; field; rewrite nz_alpha two.
rewrite (eq_bigr _ (fun i _ => term i)) sumr_const card_ord -scaler_nat scalerA -scalerDl.
by rewrite /centre_weight -mulrDl subrK mulfV // scale1r.
Qed.

Theorem covariance_8_12 : centre_weight *: ((x - x) *m (x - x)^T)
  + \sum_i point_weight *: ((point_above i - x) *m (point_above i - x)^T)
  + \sum_i point_weight *: ((point_below i - x) *m (point_below i - x)^T) = P.
Proof.
rewrite subrr mul0mx scaler0 add0r -big_split /= -outer_products; apply: eq_bigr => i _.
have above : point_above i - x = root *: col i S by rewrite /point_above addrC addKr.
have below : point_below i - x = - (root *: col i S) by rewrite /point_below addrC addKr.
rewrite above below [(- _)^T]linearN mulNmx mulmxN opprK /= -scalerDl linearZ /=.
rewrite -scalemxAl -scalemxAr !scalerA -mulrA -expr2 root_alpha.
by rewrite -[RHS]scale1r; congr (_ *: _); rewrite /point_weight; field; rewrite nz_alpha two.
Qed.
End UnscentedTransformation.
