(* Positive definite matrices over an ordered field. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section PositiveDefinite.
Variable R : realFieldType.

(* b' M a, and the value of the quadratic form M at x. *)
Definition bilinear n (M : 'M[R]_n) (b a : 'cV[R]_n) : R := (b^T *m M *m a) 0 0.
Definition value n (M : 'M[R]_n) (x : 'cV[R]_n) : R := bilinear M x x.

Definition positive_semidefinite n (M : 'M[R]_n) := M^T = M /\ forall x, 0 <= value M x.
Definition positive_definite n (M : 'M[R]_n) := M^T = M /\ forall x, x != 0 -> 0 < value M x.

Lemma definite_semidefinite n (M : 'M[R]_n) : positive_definite M -> positive_semidefinite M.
Proof.
case=> symmetric positive; split=> // x; have [->|nz] := eqVneq x 0; last exact/ltW/positive.
by rewrite /value /bilinear mulmx0 mxE.
Qed.

Lemma bilinear_congruence m n (M : 'M[R]_n) (Phi : 'M[R]_(n, m)) b a :
  bilinear (Phi^T *m M *m Phi) b a = bilinear M (Phi *m b) (Phi *m a).
Proof. by rewrite /bilinear trmx_mul !mulmxA. Qed.

Lemma value_add n (M N : 'M[R]_n) x : value (M + N) x = value M x + value N x.
Proof. by rewrite /value /bilinear mulmxDr mulmxDl mxE. Qed.

Lemma value_scale n c (M : 'M[R]_n) x : value (c *: M) x = c * value M x.
Proof. by rewrite /value /bilinear -scalemxAr -scalemxAl mxE. Qed.

Lemma definite_invertible n (M : 'M[R]_n) : positive_definite M -> M \in unitmx.
Proof.
case=> _ positive; rewrite -row_free_unit -kermx_eq0; apply: contraT => /rowV0Pn[v].
move/sub_kermxP=> zero nz; have := positive v^T.
rewrite /value /bilinear trmxK zero mul0mx mxE ltxx; apply.
by rewrite -(inj_eq (can_inj (@trmxK _ _ _))) trmxK trmx0.
Qed.

Lemma definite_inverse n (M : 'M[R]_n) : positive_definite M -> positive_definite (invmx M).
Proof.
move=> definite; have unit_M := definite_invertible definite; have [symmetric positive] := definite.
split=> [|x nz]; first by rewrite trmx_inv symmetric.
have [y Ex] : exists y, x = M *m y by exists (invmx M *m x); rewrite mulKVmx.
have nz_y : y != 0 by apply: contraNneq nz => y0; rewrite Ex y0 mulmx0.
have := positive y nz_y; rewrite /value /bilinear Ex trmx_mul symmetric.
by rewrite -[_ *m invmx M *m _]mulmxA mulKmx.
Qed.

Lemma definite_add n (M N : 'M[R]_n) :
  positive_definite M -> positive_semidefinite N -> positive_definite (M + N).
Proof.
case=> M_sym M_pos [N_sym N_pos]; split=> [|x nz]; first by rewrite linearD /= M_sym N_sym.
by rewrite value_add ltr_paddr ?M_pos.
Qed.

Lemma definite_scale n c (M : 'M[R]_n) :
  0 < c -> positive_definite M -> positive_definite (c *: M).
Proof.
move=> pos_c [symmetric positive]; split=> [|x nz]; first by rewrite linearZ /= symmetric.
by rewrite value_scale mulr_gt0 ?positive.
Qed.

Lemma semidefinite_congruence m n (M : 'M[R]_n) (Phi : 'M[R]_(n, m)) :
  positive_semidefinite M -> positive_semidefinite (Phi^T *m M *m Phi).
Proof.
case=> symmetric positive; split=> [|x]; first by rewrite !trmx_mul trmxK symmetric mulmxA.
by rewrite /value bilinear_congruence positive.
Qed.

(* (x + d)' M (x + d). *)
Lemma value_shift n (M : 'M[R]_n) x d : M^T = M ->
  value M (x + d) = value M x + 2%:R * bilinear M d x + value M d.
Proof.
move=> symmetric; rewrite /value /bilinear.
have -> : (x + d)^T = x^T + d^T by rewrite linearD.
rewrite !mulmxDl !mulmxDr.
have -> : x^T *m M *m d = d^T *m M *m x.
  have tr (N : 'M[R]_1) : N^T = N by apply/matrixP=> i j; rewrite !ord1 mxE.
  by rewrite -[LHS]tr !trmx_mul trmxK symmetric mulmxA.
move: (x^T *m M *m x) (d^T *m M *m x) (d^T *m M *m d) => a b c.
by rewrite !mxE mulr_natl mulr2n !addrA.
Qed.
End PositiveDefinite.
