(* Which directions a target model must keep, section 9.2.1, for any number of signals: where
   eta' G_zu(z_0) = 0, an intercalated transfer matrix has the same zero in the same direction, unless
   the loop has a pole at z_0. G_zu = N_zu / D, G_yu = N_yu / D, G_f = N_f / D_f, all matrices of
   polynomials over scalar denominators, and q^n_c G_zu = G_f (D_c - N_c G_yu) is the exact match. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section TargetDirections.
Variables (R : fieldType) (l_u l_y l_z n_c : nat).
Variables (D D_f : {poly R}) (N_zu N_f : 'M[{poly R}]_(l_z, l_u)) (N_yu : 'M[{poly R}]_(l_y, l_u)).
Variables (D_c : 'M[{poly R}]_l_u) (N_c : 'M[{poly R}]_(l_u, l_y)).
Variables (z_0 : R) (eta : 'rV[R]_l_z).

(* The value of a matrix of polynomials at z_0. *)
Definition at_point m n (M : 'M[{poly R}]_(m, n)) : 'M[R]_(m, n) := map_mx (horner_eval z_0) M.

(* The match, multiplied by D D_f; and the loop's matrix D D_c - N_c N_yu, singular at its poles. *)
Definition loop_matrix := D *: D_c - N_c *m N_yu.
Definition matches_target_matrix := (D_f * 'X^n_c) *: N_zu = N_f *m loop_matrix.

Lemma at_point_mul m n p (M : 'M[{poly R}]_(m, n)) (N : 'M[{poly R}]_(n, p)) :
  at_point (M *m N) = at_point M *m at_point N.
Proof. exact: map_mxM. Qed.

Lemma at_point_scale m n q (M : 'M[{poly R}]_(m, n)) : at_point (q *: M) = q.[z_0] *: at_point M.
Proof. by apply/matrixP=> i j; rewrite !mxE /= /horner_eval hornerM. Qed.

Hypothesis matches : matches_target_matrix.
Hypothesis zero : eta *m at_point N_zu = 0.

Lemma direction_in_the_loop : eta *m at_point N_f *m at_point loop_matrix = 0.
Proof.
by rewrite -mulmxA -at_point_mul -matches at_point_scale -scalemxAr zero scaler0.
Qed.

Theorem direction_is_kept : at_point loop_matrix \in unitmx -> eta *m at_point N_f = 0.
Proof. by move=> unit_L; rewrite -[LHS](mulmxK unit_L) direction_in_the_loop mul0mx. Qed.

Theorem lost_direction_is_a_pole : eta *m at_point N_f != 0 -> root (\det loop_matrix) z_0.
Proof.
apply: contraR => pole; apply/eqP/direction_is_kept; rewrite unitmxE unitfE.
by move: pole; rewrite rootE -[_.[z_0]]/(horner_eval z_0 _) -det_map_mx.
Qed.

(* The same of G_f itself, whichever numerator and denominator it is written with: v is its value at z_0 if
   some fraction of it, N / D with D(z_0) not 0, has that value. *)
Hypotheses (exists_f : D_f != 0) (regular : at_point loop_matrix \in unitmx).

Definition value_of_target (v : 'M[R]_(l_z, l_u)) := exists (D' : {poly R}) (N' : 'M[{poly R}]_(l_z, l_u)),
  [/\ D_f *: N' = D' *: N_f, D'.[z_0] != 0 & v = (D'.[z_0])^-1 *: at_point N'].

Lemma cancel_denominator (M M' : 'M[{poly R}]_(l_z, l_u)) : D_f *: M = D_f *: M' -> M = M'.
Proof. by move/matrixP=> E; apply/matrixP=> i j; have := E i j; rewrite !mxE; apply: mulfI. Qed.

(* G_f has one value at z_0, whether or not D_f vanishes there. *)
Theorem target_has_a_value : exists! v, value_of_target v.
Proof.
pose N_1 := 'X^n_c *: (N_zu *m \adj loop_matrix); pose D_1 := \det loop_matrix.
have nz_1 : D_1.[z_0] != 0 by move: regular; rewrite unitmxE unitfE det_map_mx.
have same_1 : D_f *: N_1 = D_1 *: N_f.
  have := congr1 (mulmxr (\adj loop_matrix)) matches => /=.
  by rewrite -scalemxAl -mulmxA mul_mx_adj mul_mx_scalar scalerA.
clearbody D_1 N_1; exists ((D_1.[z_0])^-1 *: at_point N_1); split=> [|_ [D_2 [N_2 [same_2 nz_2 ->]]]].
  by exists D_1, N_1.
have : D_2 *: N_1 = D_1 *: N_2.
  by apply: cancel_denominator; rewrite !scalerA ![D_f * _]mulrC -!scalerA same_1 same_2 !scalerA mulrC.
move/(congr1 (@at_point l_z l_u)); rewrite !at_point_scale => /(congr1 ( *:%R (D_1.[z_0] * D_2.[z_0])^-1)).
by rewrite !scalerA invfM divfK // mulrAC mulVf // mul1r => ->.
Qed.

Theorem direction_of_the_function v : value_of_target v -> eta *m v = 0.
Proof.
case=> D' [N' [same nz_D' ->]]; rewrite -scalemxAr.
suff zero' : eta *m at_point N' *m at_point loop_matrix = 0.
  by rewrite -[eta *m _](mulmxK regular) zero' mul0mx scaler0.
have -> : eta *m at_point N' *m at_point loop_matrix = eta *m at_point (N' *m loop_matrix).
  by rewrite -mulmxA at_point_mul.
have -> : N' *m loop_matrix = (D' * 'X^n_c) *: N_zu; last by rewrite at_point_scale -scalemxAr zero scaler0.
by apply: cancel_denominator; rewrite scalerA mulrCA -scalerA (matches : _ *: _ = _) !scalemxAl same.
Qed.
End TargetDirections.
