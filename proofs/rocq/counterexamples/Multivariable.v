(* More than one signal: "every full-order compensator is observer-based for even n" is false, even
   for minimal compensators over the reals. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* T = [p q; r s] solves T A + T C_c T = A_c T + B_c: four equations, and what they imply. *)
Section Elimination.
Variables (K : comRingType) (p q r s : K).
Let e_1 := 2%:R * p * q + p * r - 2%:R * p + q * r + 2%:R * q + r.
Let e_2 := p * s - p + 2%:R * q ^+ 2 + q * s - q + s + 1.
Let e_3 := 2%:R * p * s - 2%:R * p + r ^+ 2 + r * s - r + 2%:R * s + 2%:R.
Let e_4 := 2%:R * q * s - 2%:R * q + r * s - r + s ^+ 2 - 1.
Hypotheses (e_1_0 : e_1 = 0) (e_2_0 : e_2 = 0) (e_3_0 : e_3 = 0) (e_4_0 : e_4 = 0).

Lemma combination (x a b c d : K) : x = a * e_1 + b * e_2 + c * e_3 + d * e_4 -> x = 0.
Proof. by move=> ->; rewrite e_1_0 e_2_0 e_3_0 e_4_0 !mulr0 !addr0. Qed.

Lemma s_is_1_or_minus_1 : 10%:R * ((s - 1) * (s + 1)) = 0.
Proof.
apply: (@combination _ (2%:R * s ^+ 2 - 4%:R * s + 2%:R)
  (- 2%:R * r * s + 2%:R * r + 2%:R * s - 2%:R) (- 2%:R * q * s + 2%:R * q + s - 1)
  (2%:R * q * r - 2%:R * q - r + 6%:R)).
by rewrite /e_1 /e_2 /e_3 /e_4; ring.
Qed.

Lemma q_is_0 : 20%:R * (q * (s - 1)) = 0.
Proof.
apply: (@combination _ (- s ^+ 2 + 2%:R * s - 1) (r * s - r - 6%:R * s + 6%:R)
  (q * s - q + 2%:R * s - 2%:R) (- q * r + 6%:R * q - 2%:R * r + 2%:R)).
by rewrite /e_1 /e_2 /e_3 /e_4; ring.
Qed.

Lemma p_is_0 : 40%:R * (p * (s - 1)) = 0.
Proof.
apply: (@combination _ (s ^+ 2 - 12%:R * s + 11%:R) (- r * s + r - 4%:R * s + 4%:R)
  (- q * s + q - 2%:R * s + 2%:R) (10%:R * p + q * r + 4%:R * q + 2%:R * r + 8%:R)).
by rewrite /e_1 /e_2 /e_3 /e_4; ring.
Qed.

Lemma q_is_imaginary : 40%:R * (2%:R * q ^+ 2 + s + 1) = 0.
Proof.
apply: (@combination _ (s ^+ 2 + 8%:R * s - 9%:R) (- r * s + r + 16%:R * s + 24%:R)
  (- q * s + q - 2%:R * s + 2%:R) (- 10%:R * p + q * r - 16%:R * q + 2%:R * r - 12%:R)).
by rewrite /e_1 /e_2 /e_3 /e_4; ring.
Qed.
End Elimination.

Section Factors.
Variable K : comRingType.
Lemma factor_1 : 'X^2 - (0 + 0)%:P * 'X + (0 * 0 - - 2%:R * 2%:R)%:P = 'X^2 + 4%:R :> {poly K}.
Proof. by rewrite !(polyCD, polyCN, polyCM); ring. Qed.
Lemma factor_2 : 'X^2 - (- 2%:R - 2%:R)%:P * 'X + (- 2%:R * - 2%:R - 2%:R * - 2%:R)%:P
  = 'X^2 + 4%:R * 'X + 8%:R :> {poly K}.
Proof. by rewrite !(polyCD, polyCN, polyCM); ring. Qed.
End Factors.

(* Two planes, the columns of V; W is twice the inverse of V. *)
Local Notation V K := (block_mx (matrix_2 0 0 0 1) (matrix_2 1 0 0 (- 1)) 1%:M (matrix_2 0 0 0 1) : 'M[K]_(2 + 2)).
Local Notation W K := (block_mx (matrix_2 0 0 0 1) (matrix_2 2%:R 0 0 1) (matrix_2 2%:R 0 0 (- 1)) (matrix_2 0 0 0 1)
  : 'M[K]_(2 + 2)).

Section Planes.
Variable K : comRingType.
Let scalar (a : K) : a%:M = matrix_2 a 0 0 a.
Proof. by entry_by_entry. Qed.

Lemma planes_independent : W K *m V K = (2%:R)%:M.
Proof.
rewrite scalar_mx_block mulmx_block.
by congr block_mx; rewrite ?zero_2 ?scalar !matrix_2_mul !matrix_2_add; congr matrix_2; ring.
Qed.

Lemma planes_invariant :
  V K *m block_mx (matrix_2 0 (- 2%:R) 2%:R 0) 0 0 (matrix_2 (- 2%:R) 2%:R (- 2%:R) (- 2%:R))
  = closed_loop (matrix_2 (- 2%:R) (- 1) 2%:R (- 1)) 1%:M 1%:M
    (matrix_2 0 (- 1) 2%:R (- 1)) (matrix_2 0 (- 1) (- 2%:R) 1) (matrix_2 0 1 2%:R 1) *m V K.
Proof.
rewrite /closed_loop mul1mx mulmx1 !mulmx_block.
by congr block_mx; rewrite ?zero_2 ?scalar !matrix_2_mul !matrix_2_add; congr matrix_2; ring.
Qed.
End Planes.

Section Multivariable.
Variable R : realFieldType.

(* The condition of controllableP and observableP, for any number of signals. *)
Definition controllable_inputs n m (A : 'M[R]_n.+1) (B : 'M[R]_(n.+1, m)) :=
  forall k (eta : 'M[R]_(k, n.+1)), (forall i, eta *m A ^+ i *m B = 0) -> eta = 0.
Definition observable_outputs n p (A : 'M[R]_n.+1) (C : 'M[R]_(p, n.+1)) :=
  forall k (x : 'M[R]_(n.+1, k)), (forall i, C *m A ^+ i *m x = 0) -> x = 0.

Lemma invertible_input_matrix n (A B : 'M[R]_n.+1) : B \in unitmx -> controllable_inputs A B.
Proof.
move=> unit_B k eta /(_ 0%N); rewrite expr0 mulmx1 => zero.
by rewrite -(mulmxK unit_B eta) zero mul0mx.
Qed.

Lemma invertible_output_matrix n (A C : 'M[R]_n.+1) : C \in unitmx -> observable_outputs A C.
Proof.
move=> unit_C k x /(_ 0%N); rewrite expr0 mulmx1 => zero.
by rewrite -(mulKmx unit_C x) zero mulmx0.
Qed.

(* The two invariant planes are the columns of V. *)
Lemma multivariable_spectrum :
  char_poly (closed_loop (matrix_2 (- 2%:R) (- 1) 2%:R (- 1)) 1%:M 1%:M
    (matrix_2 0 (- 1) 2%:R (- 1)) (matrix_2 0 (- 1) (- 2%:R) 1) (matrix_2 0 1 2%:R 1))
  = char_poly (matrix_2 0 (- 2%:R) 2%:R 0 : 'M[R]_2)
    * char_poly (matrix_2 (- 2%:R) 2%:R (- 2%:R) (- 2%:R)).
Proof.
have nz_V : \det (V R) != 0.
  have : \det (W R *m V R) != 0 by rewrite planes_independent det_scalar expf_eq0 pnatr_eq0.
  by rewrite det_mulmx mulf_eq0 negb_or => /andP[].
by rewrite -(char_poly_upper _ 0); apply/esym/(char_poly_similar nz_V)/planes_invariant.
Qed.

(* Refuted: for n even every minimal full-order compensator of a minimal plant is, in some basis,
   observer-based, if u and y may have two components. n = 2, B = C = I, and the closed-loop poles
   are +-2j and -2 +- 2j: over the reals the two invariant planes are the only candidates, and
   neither is the graph of an invertible T. *)
Theorem multivariable_compensator_is_not_observer_based :
  let A : 'M[R]_2 := matrix_2 (- 2%:R) (- 1) 2%:R (- 1) in
  let B : 'M[R]_2 := 1%:M in let C : 'M[R]_2 := 1%:M in
  let A_c : 'M[R]_2 := matrix_2 0 (- 1) 2%:R (- 1) in
  let B_c : 'M[R]_2 := matrix_2 0 (- 1) (- 2%:R) 1 in
  let C_c : 'M[R]_2 := matrix_2 0 1 2%:R 1 in
  [/\ controllable_inputs A B /\ observable_outputs A C,
      controllable_inputs A_c B_c /\ observable_outputs A_c C_c,
      char_poly (closed_loop A B C A_c B_c C_c) = ('X^2 + 4%:R) * ('X^2 + 4%:R * 'X + 8%:R)
    & ~ exists T K F : 'M[R]_2, [/\ T \in unitmx, C_c *m T = K, T *m F = B_c
        & A_c *m T = T *m observer_matrix A B C K F]].
Proof.
move=> A B C A_c B_c C_c; have nz (k : nat) : k.+1%:R != 0 :> R by rewrite pnatr_eq0.
split.
- by split; [apply: invertible_input_matrix | apply: invertible_output_matrix]; apply: unitmx1.
- split; [apply: invertible_input_matrix | apply: invertible_output_matrix];
    by rewrite unitmxE unitfE det_2 mul0r sub0r ?mulN1r ?mul1r ?opprK ?oppr_eq0.
- by rewrite multivariable_spectrum !char_poly_2 factor_1 factor_2.
case=> T [K [F [unit_T outputs inputs similar]]].
have [p [q [r [s ET]]]] := matrix_2_entries T.
have equation : T *m A + T *m C_c *m T - A_c *m T - B_c = 0.
  rewrite similar /observer_matrix mul1mx mulmx1 mulmxBr mulmxDr -outputs inputs mulmxA.
  by rewrite subKr subrr.
move: equation unit_T; rewrite ET !matrix_2_mul !matrix_2_opp !matrix_2_add.
move/matrixP=> equation.
have := equation 0 0; have := equation 0 1; have := equation 1 0; have := equation 1 1.
rewrite !mxE /= => e_4 e_3 e_2 e_1.
have E_1 : 2%:R * p * q + p * r - 2%:R * p + q * r + 2%:R * q + r = 0 by rewrite -e_1; ring.
have E_2 : p * s - p + 2%:R * q ^+ 2 + q * s - q + s + 1 = 0 by rewrite -e_2; ring.
have E_3 : 2%:R * p * s - 2%:R * p + r ^+ 2 + r * s - r + 2%:R * s + 2%:R = 0.
  by rewrite -e_3; ring.
have E_4 : 2%:R * q * s - 2%:R * q + r * s - r + s ^+ 2 - 1 = 0 by rewrite -e_4; ring.
rewrite unitmxE unitfE det_2.
have /eqP := s_is_1_or_minus_1 E_1 E_2 E_3 E_4; rewrite !mulf_eq0 (negPf (nz 9%N)) /=.
case/orP=> [s_1|]; last rewrite addr_eq0 => /eqP s_minus_1.
  (* 2 q^2 + 2 = 0 *)
  have /eqP := q_is_imaginary E_1 E_2 E_3 E_4; rewrite mulf_eq0 (negPf (nz 39%N)) /=.
  move: s_1; rewrite subr_eq0 => /eqP-> => imaginary _.
  have positive : 0 < 2%:R * q ^+ 2 + 1 + 1.
    by rewrite ltr_spaddr ?ltr01 // addr_ge0 ?ler01 // mulr_ge0 ?ler0n ?sqr_ge0.
  by move: (lt0r_neq0 positive); rewrite (eqP imaginary) eqxx.
(* the first row of T is 0 *)
have nz_s1 : s - 1 != 0 by rewrite s_minus_1 -opprD oppr_eq0 (nz 1%N).
have /eqP := q_is_0 E_1 E_2 E_3 E_4; rewrite !mulf_eq0 (negPf (nz 19%N)) (negPf nz_s1) orbF /=.
have /eqP := p_is_0 E_1 E_2 E_3 E_4; rewrite !mulf_eq0 (negPf (nz 39%N)) (negPf nz_s1) orbF /=.
by move=> /eqP-> /eqP->; rewrite !mul0r subrr eqxx.
Qed.
End Multivariable.
