(* What a certificate of small gain says of the transfer function: where the matrix of the bounded real lemma is
   positive semidefinite, T(z)* W T(z) <= S on the circle |z|^2 = r, with T(z) = C (zI - A)^-1 B + D. The easy half
   of the lemma, for every realisation: no inverse and no minimality are asked. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import Lyapunov SmallGain.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section GainOnTheCircle.
Variables (R : rcfType) (n m p : nat).
Variables (P A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) (D : 'M[R]_(p, m)).
Variables (S : 'M[R]_m) (W : 'M[R]_p) (r : R).
Local Notation toC := (real_complex R).
Local Notation over M := (map_mx toC M).

Lemma hermitian_value_scaled k (M : 'M[R[i]]_k) a x : hermitian_value (a *: M) x = a * hermitian_value M x.
Proof. by rewrite /hermitian_value -scalemxAr -scalemxAl mxE. Qed.

Lemma hermitian_value_diagonal (M : 'M[R[i]]_n) (N : 'M[R[i]]_m) x v :
  hermitian_value (block_mx M 0 0 N) (col_mx x v) = hermitian_value M x + hermitian_value N v.
Proof.
by rewrite /hermitian_value adjoint_col mul_row_block !mulmx0 addr0 add0r mul_row_col mxE.
Qed.

(* x is the response to v at z, C x + D v the output. *)
Theorem bounded_real_bounds_the_gain (z : R[i]) (x : 'cV[R[i]]_n) (v : 'cV[R[i]]_m) :
  bounded_real P A B C D S W r -> `|z| ^+ 2 = toC r -> z *: x = over A *m x + over B *m v ->
  hermitian_value (over W) (over C *m x + over D *m v) <= hermitian_value (over S) v.
Proof.
move=> /semidefinite_complex[_ /(_ (col_mx x v))] gain circle response.
have E : over (dissipation P A B C D S W r) = block_mx (toC r *: over P) 0 0 (over S)
    + (-1) *: (adjoint (row_mx (over A) (over B)) *m over P *m row_mx (over A) (over B))
    + (-1) *: (adjoint (row_mx (over C) (over D)) *m over W *m row_mx (over C) (over D)).
  rewrite -!map_row_mx !adjoint_real !scaleN1r /dissipation !map_mxB !map_mxM map_block_mx map_mxZ.
  by rewrite !map_mx0.
move: gain; rewrite E !hermitian_value_add !hermitian_value_scaled !hermitian_value_congruence !mul_row_col.
rewrite -response hermitian_value_diagonal hermitian_value_scaled.
have -> : hermitian_value (over P) (z *: x) = toC r * hermitian_value (over P) x.
  rewrite /hermitian_value adjoint_scale -!scalemxAl -scalemxAr !mxE mulrA -circle normCK.
  by rewrite [z^* * z]mulrC.
rewrite -subr_ge0 => nonneg; rewrite -subr_ge0; apply: le_trans nonneg _.
move: (toC r * _) (hermitian_value (over S) v) (hermitian_value (over W) _) => a b c.
by rewrite !mulN1r [a + b]addrC addrK subr0.
Qed.
End GainOnTheCircle.
