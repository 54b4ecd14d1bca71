(* The points and weights of the unscented transformation have the mean x and the covariance P: (8.12),
   with gamma_0 = (alpha - n) / alpha, where (8.11) has n in the denominator. And where the dynamics are
   linear the unscented filter (8.13)-(8.24) is the Kalman filter (8.5)-(8.7), if its points are drawn
   anew from P^- after Q is added; with the points of (8.22) the gain knows nothing of Q. *)
From Compensators.foundations Require Import MathComp.
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

(* The weighted sum of what a function makes of the points. *)
Definition weighted a b (f : 'cV[R]_n -> 'M[R]_(a, b)) := centre_weight *: f x
  + \sum_i point_weight *: f (point_above i) + \sum_i point_weight *: f (point_below i).

(* (8.23), (8.14): the mean of an affine image. *)
Theorem mean_of_affine m (M : 'M[R]_(m, n)) (g : 'cV[R]_m) : weighted (fun X => M *m X + g) = M *m x + g.
Proof.
have one : centre_weight + (\sum_(i < n) point_weight + \sum_(i < n) point_weight) = 1.
  rewrite -big_split /= sumr_const card_ord /centre_weight /point_weight.
  by rewrite -mulr_natl; field; rewrite nz_alpha two.
have split_sum (f : 'I_n -> 'cV[R]_n) : \sum_i point_weight *: (M *m f i + g)
    = M *m (\sum_i point_weight *: f i) + (\sum_(i < n) point_weight) *: g.
  rewrite mulmx_sumr scaler_suml -big_split /=; apply: eq_bigr => i _.
  by rewrite scalerDr scalemxAr.
rewrite /weighted !split_sum scalerDr scalemxAr.
transitivity (M *m (centre_weight *: x + \sum_i point_weight *: point_above i
    + \sum_i point_weight *: point_below i)
  + (centre_weight + (\sum_(i < n) point_weight + \sum_(i < n) point_weight)) *: g).
  rewrite !mulmxDr !scalerDl; move: (_ *: g) (_ *: g) (M *m (_ *: x)) => e d a.
  by rewrite [a + d + _]addrACA [LHS]addrACA !addrA.
by rewrite one scale1r mean_8_12.
Qed.

(* (8.18), (8.19), (8.24): the covariance of two affine images. *)
Theorem covariance_of_affine a b (M : 'M[R]_(a, n)) (N : 'M[R]_(b, n)) g h :
  weighted (fun X => (M *m X + g - (M *m x + g)) *m (N *m X + h - (N *m x + h))^T) = M *m P *m N^T.
Proof.
have image c (L : 'M[R]_(c, n)) l X : L *m X + l - (L *m x + l) = L *m (X - x).
  by rewrite opprD addrACA subrr addr0 mulmxBr.
have covariance := covariance_8_12.
have [f Ef] : exists f, forall X, f X = (X - x) *m (X - x)^T by exists (fun X => (X - x) *m (X - x)^T).
have term X : (M *m X + g - (M *m x + g)) *m (N *m X + h - (N *m x + h))^T = M *m f X *m N^T.
  by rewrite !image Ef trmx_mul !mulmxA.
have under (d : 'I_n -> 'cV[R]_n) : \sum_i point_weight *: ((M *m d i + g - (M *m x + g))
    *m (N *m d i + h - (N *m x + h))^T) = M *m (\sum_i point_weight *: f (d i)) *m N^T.
  rewrite mulmx_sumr mulmx_suml; apply: eq_bigr => i _.
  by rewrite term -scalemxAr -scalemxAl.
rewrite /weighted term !under -covariance -Ef.
have back (d : 'I_n -> 'cV[R]_n) : \sum_i point_weight *: ((d i - x) *m (d i - x)^T)
    = \sum_i point_weight *: f (d i) by apply: eq_bigr => i _; rewrite Ef.
by rewrite !back !mulmxDr !mulmxDl -scalemxAr -scalemxAl.
Qed.
End UnscentedTransformation.

(* One step of the Kalman filter, (8.5)-(8.7), from the mean x and the covariance P after the last
   measurement, and the unscented one, whose points of the forecast are those of (x, S) and whose points
   of the data assimilation those of a square root S' of the forecast's covariance. *)
Section Filter.
Variables (R : fieldType) (n p : nat).
Variables (A P S S' V : 'M[R]_n) (C : 'M[R]_(p, n)) (W : 'M[R]_p) (x g : 'cV[R]_n) (y : 'cV[R]_p).
Variables (root alpha : R).
Hypotheses (two : 2%:R != 0 :> R) (nz_alpha : alpha != 0) (root_alpha : root ^+ 2 = alpha).

Definition kalman_gain := (A *m P *m A^T + V) *m C^T *m invmx (C *m (A *m P *m A^T + V) *m C^T + W).
Definition kalman_state := A *m x + g + kalman_gain *m (y - C *m (A *m x + g)).
Definition kalman_covariance := (1%:M - kalman_gain *m C) *m (A *m P *m A^T + V).

(* (8.22)-(8.24), with + Q_k where (8.24) has = Q_k. *)
Definition forecast_state := weighted x S root alpha (fun X => A *m X + g).
Definition forecast_covariance := weighted x S root alpha
  (fun X => (A *m X + g - forecast_state) *m (A *m X + g - forecast_state)^T) + V.

(* (8.13)-(8.20), h(x) = C x, with the points of the covariance S' S'^T around z. *)
Definition measured z := weighted z S' root alpha (fun X => C *m X).
Definition P_xy z := weighted z S' root alpha (fun X => (X - z) *m (C *m X - measured z)^T).
Definition P_yy z := weighted z S' root alpha
  (fun X => (C *m X - measured z) *m (C *m X - measured z)^T) + W.
Definition unscented_gain z := P_xy z *m invmx (P_yy z).
Definition unscented_state z := z + unscented_gain z *m (y - measured z).
Definition unscented_covariance z :=
  S' *m S'^T - unscented_gain z *m P_yy z *m (unscented_gain z)^T.

Hypothesis square_root : S *m S^T = P.

Theorem unscented_forecast :
  forecast_state = A *m x + g /\ forecast_covariance = A *m P *m A^T + V.
Proof.
have mean : forecast_state = A *m x + g by apply: mean_of_affine.
by split=> //; rewrite /forecast_covariance mean (covariance_of_affine _ square_root).
Qed.

(* What is measured of points with the covariance S' S'^T. *)
Lemma unscented_moments z : [/\ measured z = C *m z, P_xy z = S' *m S'^T *m C^T
  & P_yy z = C *m (S' *m S'^T) *m C^T + W].
Proof.
have mean : measured z = C *m z.
  rewrite -[RHS]addr0 -(mean_of_affine z S' root two nz_alpha C 0) /measured /weighted addr0.
  by congr (_ + _ + _); apply: eq_bigr => i _; rewrite addr0.
split=> //.
- rewrite /P_xy mean -[X in X *m C^T]mul1mx.
  rewrite -(covariance_of_affine z (erefl (S' *m S'^T)) two nz_alpha root_alpha 1%:M C 0 0).
  by rewrite /weighted !addr0 !mul1mx; congr (_ + _ + _); apply: eq_bigr => i _; rewrite !addr0 !mul1mx.
rewrite /P_yy mean; congr (_ + _).
rewrite -(covariance_of_affine z (erefl (S' *m S'^T)) two nz_alpha root_alpha C C 0 0).
by rewrite /weighted !addr0; congr (_ + _ + _); apply: eq_bigr => i _; rewrite !addr0.
Qed.

(* Drawn anew from the forecast's covariance, Q included. *)
Theorem unscented_is_kalman : P^T = P -> V^T = V -> W^T = W ->
  C *m (A *m P *m A^T + V) *m C^T + W \in unitmx -> S' *m S'^T = forecast_covariance ->
  unscented_state forecast_state = kalman_state /\
  unscented_covariance forecast_state = kalman_covariance.
Proof.
move=> P_T V_T W_T unit_W anew; have [mean covariance] := unscented_forecast.
have [m_E xy_E yy_E] := unscented_moments forecast_state.
rewrite anew covariance in xy_E yy_E; set M := A *m P *m A^T + V in xy_E yy_E covariance unit_W *.
have M_T : M^T = M by rewrite /M linearD /= !trmx_mul trmxK P_T V_T mulmxA.
have gain : unscented_gain forecast_state = kalman_gain by rewrite /unscented_gain xy_E yy_E.
split; first by rewrite /unscented_state gain m_E mean.
rewrite /unscented_covariance gain yy_E anew covariance /kalman_covariance -/M.
rewrite mulmxBl mul1mx; congr (_ - _); set Y := C *m M *m C^T + W in unit_W *.
have Y_T : Y^T = Y by rewrite /Y linearD /= !trmx_mul trmxK M_T W_T mulmxA.
rewrite {1}/kalman_gain -/M -/Y mulmxKV // -[RHS]mulmxA.
by rewrite /kalman_gain -/M -/Y !trmx_mul trmxK trmx_inv Y_T M_T !mulmxA.
Qed.

(* As printed, the points X^- = A X^+ + g of (8.22) serve again, S' = A S: their gain is that of Q = 0. *)
Theorem printed_gain_ignores_Q z : S' = A *m S ->
  unscented_gain z = A *m P *m A^T *m C^T *m invmx (C *m (A *m P *m A^T) *m C^T + W).
Proof.
move=> ES; have [_ xy_E yy_E] := unscented_moments z; rewrite /unscented_gain xy_E yy_E ES.
by rewrite trmx_mul -square_root !mulmxA.
Qed.
End Filter.
