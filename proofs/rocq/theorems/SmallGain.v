(* Small gain for every motion: x' = A x + B w, z = C x + D w, where w is small against z, however it comes
   about: it may be nonlinear and vary in time. With w = Delta z this is a loop whose parameters move in an
   ellipsoid, Delta' S Delta <= W, in any way: an adapting controller in the loop of theta_0, whatever adapts
   it. P and the weights are a certificate, the matrix of the bounded real lemma; that there is one where the
   gain is below 1 is not asked and not shown. Over any ordered field. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import ForwardConvergence Contraction.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section BoundedReal.
Variables (R : realFieldType) (n m p : nat).
Variables (P A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) (D : 'M[R]_(p, m)).
Variables (S : 'M[R]_m) (W : 'M[R]_p).
Implicit Types (v : 'cV[R]_n) (w : 'cV[R]_m) (r : R).

(* x'' P x' <= r x' P x + w' S w - z' W z for all x and w; r is the square of the rate. *)
Definition dissipation r := block_mx (r *: P) 0 0 S
  - (row_mx A B)^T *m P *m row_mx A B - (row_mx C D)^T *m W *m row_mx C D.
Definition bounded_real r := positive_semidefinite (dissipation r).

Lemma value_diagonal (M : 'M[R]_n) v w : value (block_mx M 0 0 S) (col_mx v w) = value M v + value S w.
Proof.
by rewrite /value /bilinear tr_col_mx mul_row_block !mulmx0 addr0 add0r mul_row_col [LHS]mxE.
Qed.

Lemma bounded_realE r v w : bounded_real r ->
  value P (A *m v + B *m w) <= r * value P v + (value S w - value W (C *m v + D *m w)).
Proof.
case=> _ /(_ (col_mx v w)); rewrite !value_sub value_diagonal value_scale !value_congruence.
rewrite !mul_row_col -subr_ge0 => nonneg; rewrite -subr_ge0.
by apply: le_trans nonneg _; rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
Qed.

Theorem robust_motion r (x : nat -> 'cV[R]_n) (w : nat -> 'cV[R]_m) : 0 <= r -> bounded_real r ->
  (forall k, x k.+1 = A *m x k + B *m w k) ->
  (forall k, value S (w k) <= value W (C *m x k + D *m w k)) ->
  forall k, value P (x k) <= r ^+ k * value P (x 0%N).
Proof.
move=> r_ge0 gain moves small; elim=> [|k IH]; first by rewrite expr0 mul1r.
rewrite moves exprS -mulrA; apply: le_trans (bounded_realE _ _ gain) _.
by apply: le_trans (_ : r * value P (x k) <= _); rewrite ?ler_wpmul2l // ger_addl subr_le0.
Qed.

(* The strict inequality has a rate. *)
Theorem strict_bounded_real_has_rate : P^T = P -> positive_definite (dissipation 1) ->
  exists2 r, 0 <= r < 1 & bounded_real r.
Proof.
move=> symmetric definite; pose G : 'M[R]_(n + m) := block_mx P 0 0 0.
have [t t_ge1 below] := definite_dominates G definite.
have t_gt0 : 0 < t := lt_le_trans ltr01 t_ge1.
exists (1 - t^-1); first by rewrite subr_ge0 invf_le1 // t_ge1 ltr_subl_addr ltr_addl invr_gt0.
have E : dissipation (1 - t^-1) = dissipation 1 - t^-1 *: G.
  have -> : dissipation (1 - t^-1) = block_mx (1 *: P) 0 0 S - t^-1 *: G
      - (row_mx A B)^T *m P *m row_mx A B - (row_mx C D)^T *m W *m row_mx C D.
    rewrite scale_block_mx opp_block_mx add_block_mx !scaler0 !oppr0 !addr0.
    by rewrite /dissipation scalerBl.
  by rewrite /dissipation -!addrA; congr (_ + _); rewrite addrC -addrA.
rewrite /bounded_real E; have [sym_1 _] := definite; split=> [|y].
  by rewrite linearB linearZ /= sym_1 tr_block_mx !trmx0 symmetric.
by rewrite value_sub value_scale subr_ge0 ler_pdivr_mull.
Qed.
End BoundedReal.

(* The loop of theta_0, A, and a change of theta, Delta, between what the controller measures, C x, and what
   it moves, B u: Delta' S Delta <= W. *)
Section Ellipsoid.
Variables (R : realFieldType) (n m p : nat).
Variables (P A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) (S : 'M[R]_m) (W : 'M[R]_p).
Implicit Types (Delta : 'M[R]_(m, p)).

Definition in_ellipsoid Delta := positive_semidefinite (W - Delta^T *m S *m Delta).
Hypothesis symmetric : P^T = P.

Theorem ellipsoid_contracts r Delta : bounded_real P A B C 0 S W r -> in_ellipsoid Delta ->
  contracts P r (A + B *m Delta *m C).
Proof.
move=> gain [_ nonneg]; apply/contractsP=> // v; rewrite mulmxDl -!mulmxA.
apply: le_trans (bounded_realE _ _ gain) _; rewrite mul0mx addr0 ger_addl subr_le0.
by have := nonneg (C *m v); rewrite value_sub value_congruence subr_ge0.
Qed.

(* Delta moves within the ellipsoid in any way. *)
Theorem ellipsoid_motion r (Delta : nat -> 'M[R]_(m, p)) (x : nat -> 'cV[R]_n) : 0 <= r ->
  bounded_real P A B C 0 S W r -> (forall k, in_ellipsoid (Delta k)) ->
  (forall k, x k.+1 = (A + B *m Delta k *m C) *m x k) ->
  forall k, value P (x k) <= r ^+ k * value P (x 0%N).
Proof.
move=> r_ge0 gain inside.
apply: (motion_contracts (A := fun k => A + B *m Delta k *m C)) => // k; exact: ellipsoid_contracts.
Qed.

(* One certificate, one rate for all motions, and a bound on every coordinate. *)
Theorem certified_ellipsoid : positive_definite P ->
  positive_definite (dissipation P A B C 0 S W 1) -> exists2 r, 0 <= r < 1 &
  forall (Delta : nat -> 'M[R]_(m, p)) (x : nat -> 'cV[R]_n), (forall k, in_ellipsoid (Delta k)) ->
  (forall k, x k.+1 = (A + B *m Delta k *m C) *m x k) ->
  forall k i, x k i 0 ^+ 2 <= invmx P i i * (r ^+ k * value P (x 0%N)).
Proof.
move=> definite strict; have [r r_range gain] := strict_bounded_real_has_rate symmetric strict.
exists r => // Delta x inside; have /andP[r_ge0 _] := r_range.
apply: (motion_decays (A := fun k => A + B *m Delta k *m C)) => // k; exact: ellipsoid_contracts.
Qed.
End Ellipsoid.

(* One input: d' M^-1 d <= 1 is the ellipsoid d d' <= M. *)
Lemma in_ellipsoid_of_one_input (R : realFieldType) p (M : 'M[R]_p) (d : 'cV[R]_p) :
  positive_definite M -> value (invmx M) d <= 1 -> in_ellipsoid 1%:M M d^T.
Proof.
move=> definite small; have [symmetric _] := definite; have unit_M := definite_invertible definite.
have [_ nonneg] := definite_semidefinite definite.
split=> [|y]; first by rewrite linearB /= symmetric !trmx_mul !trmxK trmx1 mulmxA.
rewrite value_sub value_congruence subr_ge0 {1}/value /bilinear mulmx1 mxE big_ord1 mxE -expr2.
apply: le_trans (cauchy_schwarz d y (definite_inverse definite)) _; rewrite invmxK.
by rewrite -[X in _ <= X]mul1r ler_wpmul2r.
Qed.
