(* Theorem 1 read as a statement about transfer functions: one transfer function, two answers.
   theorem_1_transfer_functions of ObserverBasedPairs.v is the true statement. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import PolePlacement Coprimeness ObserverBasedPairs.
From Compensators.theorems Require Import CanonicalForm.
From Compensators.counterexamples Require Import Theorem1.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Identities.
Variable K : comRingType.
(* D (s + 1) + 2 = (s^2 + 1)(s^2 + 2s + 2) *)
Lemma closed_loop_factors (x g h : K) :
  (x ^+ 3 + x ^+ 2 + 2%:R * x) * ((x + 1) * (g * h)) + 1 * (2%:R * (g * h))
  = g * (x ^+ 2 + 1) * (h * (x ^+ 2 + 2%:R * x + 2%:R)).
Proof. by ring. Qed.
Lemma closed_loop_values (x : K) :
  (x ^+ 3 + x ^+ 2 + 2%:R * x) * ((x + 1) * (x ^+ 2 + 4%:R * x + 5%:R))
    + 1 * (2%:R * (x ^+ 2 + 4%:R * x + 5%:R))
  = ((x + 2%:R) ^+ 2 + 1) * ((x ^+ 2 + 1) * ((x + 1) ^+ 2 + 1)).
Proof. by ring. Qed.
Lemma same_fraction (x g h : K) : 2%:R * g * ((x + 1) * h) = 2%:R * h * ((x + 1) * g).
Proof. by ring. Qed.
End Identities.

Section OneTransferFunctionTwoAnswers.
Variable R : rcfType.

(* The plant G = 1 / (s^3 + s^2 + 2s), n = 3. *)
Definition plant_D : {poly R} := 'X^3 + 'X^2 + 2%:R * 'X.
Definition plant_N : {poly R} := 1.

(* G_c = 2 / (s + 1), negative feedback, with the factor g not cancelled. *)
Definition written_D_c (g : {poly R}) := ('X + 1) * g.
Definition written_N_c (g : {poly R}) := 2%:R * g.
Definition real_factor : {poly R} := ('X + 3%:R) * ('X + 4%:R).
Definition complex_factor : {poly R} := 'X^2 + 4%:R * 'X + 5%:R.

(* D_c and N_c are those of a full-order strictly proper compensator of the plant. *)
Definition full_order_strictly_proper (D_c N_c : {poly R}) :=
  [/\ D_c \is monic, degree_is D_c 3 & degree_below N_c 3].

Lemma written_is_full_order (g : {poly R}) : g \is monic /\ degree_is g 2 ->
  full_order_strictly_proper (written_D_c g) (written_N_c g).
Proof.
move=> quadratic; have linear : ('X + 1 : {poly R}) \is monic /\ degree_is ('X + 1 : {poly R}) 1.
  by apply: monic_linear; rewrite size_poly1.
have [monic_p deg_p] := monic_product linear quadratic; split=> //.
rewrite (leq_trans (size_mul_leq _ _)) // quadratic.2.
by move: (size_natural R 2); move: (size _); lia.
Qed.

Lemma plant_exists : exists (A : 'M[R]_3) B C,
  [/\ minimal A B C, denominator A = plant_D & numerator A B C = plant_N].
Proof.
have size_1 : (size plant_N <= 3)%N by rewrite size_poly1.
have [monic_D deg_D] : plant_D \is monic /\ degree_is plant_D 3.
  have low : (size ('X^2 + 2%:R * 'X : {poly R})%R < 4)%N.
    rewrite (leq_ltn_trans (size_add _ _)) // gtn_max size_polyXn.
    rewrite (leq_ltn_trans (size_mul_leq _ _)) // size_polyX addn2 /=.
    by move: (size_natural R 2); move: (size _); lia.
  by rewrite /plant_D -addrA monicE lead_coefDl ?size_polyXn // lead_coefXn size_addl ?size_polyXn.
have [Den Num] := canonical_form monic_D deg_D size_1.
exists (companion 3 plant_D), (canonical_input _ _), (canonical_output _ plant_N); split=> //.
by apply/canonical_form_is_minimal; rewrite ?coprimep1.
Qed.

(* Refuted: "G_c = N_c / D_c is observer-based if and only if ... DD_c + NN_c has at least two real
   roots" for a transfer function. For G = 1 / (s^3 + s^2 + 2s) the compensator G_c = 2 / (s + 1)
   is that of a full-order pair with two real closed-loop poles, -3 and -4, which is observer-based,
   and of one without real poles, which is not. *)
Theorem theorem_1_is_not_about_transfer_functions :
  (exists (A : 'M[R]_3) B C,
     [/\ minimal A B C, denominator A = plant_D & numerator A B C = plant_N]) /\
  forall (A : 'M[R]_3) (B : 'cV[R]_3) (C : 'rV[R]_3),
    denominator A = plant_D -> numerator A B C = plant_N ->
  let D_1 := written_D_c real_factor in let N_1 := written_N_c real_factor in
  let D_2 := written_D_c complex_factor in let N_2 := written_N_c complex_factor in
  [/\ full_order_strictly_proper D_1 N_1, full_order_strictly_proper D_2 N_2,
      N_1 * D_2 = N_2 * D_1,
      pair_is_observer_based A B C D_1 N_1
    & ~ pair_is_observer_based A B C D_2 N_2].
Proof.
split=> [|A B C Den Num D_1 N_1 D_2 N_2]; first exact: plant_exists.
have minimal_plant : minimal A B C by apply/minimal_iff_coprime; rewrite Num coprimep1.
have linear (b : {poly R}) : (size b <= 1)%N -> 'X + b \is monic /\ degree_is ('X + b : {poly R}) 1.
  exact: monic_linear.
have number k : (size (k%:R%R : {poly R}) <= 1)%N by apply: size_natural.
have full_1 : full_order_strictly_proper D_1 N_1.
  by apply: written_is_full_order; apply: monic_product (linear _ _) (linear _ _).
have full_2 : full_order_strictly_proper D_2 N_2.
  by apply: written_is_full_order; apply: monic_quadratic.
have [monic_1 deg_1 low_1] := full_1; have [monic_2 deg_2 low_2] := full_2.
split=> //; first exact: same_fraction.
  have [_ based] := pair_is_observer_based_iff minimal_plant D_1 low_1.
  have [monic_R deg_R] := monic_product (linear _ (number 3%N)) (monic_square (number 1%N)).
  have [monic_O deg_O] := monic_product (linear _ (number 4%N))
    (monic_quadratic (number 2%N) (number 2%N)).
  apply: based; exists (('X + 3%:R) * ('X^2 + 1)), (('X + 4%:R) * ('X^2 + 2%:R * 'X + 2%:R)).
  by split=> //; rewrite Den Num; apply: closed_loop_factors.
have [needed _] := theorem_1 minimal_plant monic_2 deg_2 low_2.
move/needed; case=> // -[_ [x [y [q factored]]]].
have : root (closed_loop_polynomial (denominator A) (numerator A B C) D_2 N_2) x.
  by rewrite factored !rootM !root_XsubC eqxx orbT.
rewrite Den Num /closed_loop_polynomial /D_2 /N_2 /plant_D /plant_N closed_loop_values !rootM.
have shifted k : root (('X + k%:R) ^+ 2 + 1) x = ((x + k%:R) ^+ 2 + 1 == 0).
  by rewrite rootE !(hornerE, hornerMn) -expr2.
have := shifted 0%N; rewrite !addr0 => ->; rewrite (shifted 2%N) (shifted 1%N).
by rewrite !(negPf (sum_of_squares_neq0 _)).
Qed.
End OneTransferFunctionTwoAnswers.
