(* Chapter 7, polynomials: wordings of Propositions 1 and 2 and of Theorem 1 that are false, each
   with the example that refutes it. ObserverBasedPairs.v has the true statements. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary SmallSystems.
From Compensators.theorems Require Import PolePlacement ClosedLoop Coprimeness Diophantine.
From Compensators.theorems Require Import ObserverBasedPairs CanonicalForm.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Identities.
Variable K : comRingType.
Lemma same_closed_loop (x : K) :
  (x + 1) * (x + 2%:R) * x ^+ 2 + (x + 1) * 0
  = (x + 1) * (x + 2%:R) * (x ^+ 2 - 1) + (x + 1) * (x + 2%:R).
Proof. by ring. Qed.
End Identities.

Section Degrees.
Variable R : idomainType.
Implicit Types a b : {poly R}.

Lemma size_natural k : (size (k%:R%R : {poly R}) <= 1)%N.
Proof. by rewrite -polyCMn size_polyC_leq1. Qed.

Lemma monic_linear b : (size b <= 1)%N -> 'X + b \is monic /\ degree_is ('X + b) 1.
Proof.
move=> deg_b; have small : (size b < size ('X : {poly R}))%N by rewrite size_polyX ltnS.
by rewrite monicE lead_coefDl // lead_coefX size_addl // size_polyX.
Qed.

Lemma monic_quadratic a b : (size a <= 1)%N -> (size b <= 1)%N ->
  'X^2 + a * 'X + b \is monic /\ degree_is ('X^2 + a * 'X + b) 2.
Proof.
move=> deg_a deg_b; have small : (size (a * 'X + b)%R < size ('X^2 : {poly R}))%N.
  rewrite size_polyXn (leq_ltn_trans (size_add _ _)) // gtn_max (leq_trans _ (_ : 2 < 3)%N) //.
    by rewrite (leq_ltn_trans deg_b).
  rewrite ltnS (leq_trans (size_mul_leq _ _)) // size_polyX addn2 /=.
  by move: (size a) deg_a; lia.
by rewrite -addrA monicE lead_coefDl // lead_coefXn size_addl // size_polyXn.
Qed.

Lemma monic_square b : (size b <= 1)%N -> 'X^2 + b \is monic /\ degree_is ('X^2 + b) 2.
Proof.
move=> deg_b; have -> : 'X^2 + b = 'X^2 + 0 * 'X + b by rewrite mul0r addr0.
by apply: monic_quadratic; rewrite ?size_poly0.
Qed.

Lemma monic_product a b i j : a \is monic /\ degree_is a i -> b \is monic /\ degree_is b j ->
  a * b \is monic /\ degree_is (a * b) (i + j).
Proof.
case=> monic_a deg_a [monic_b deg_b]; rewrite monicMl // size_monicM ?monic_neq0 //.
by rewrite deg_a deg_b addSn addnS.
Qed.
End Degrees.

Section Orders.
Variable R : realFieldType.
Implicit Type x : R.

Lemma sum_of_squares_neq0 x : x ^+ 2 + 1 != 0.
Proof. by apply: lt0r_neq0; rewrite ltr_paddl ?ltr01 ?sqr_ge0. Qed.

(* n = 1, A = 0, B = C = 1. *)
Definition integrator_A : 'M[R]_1 := 0%:M.
Definition integrator_B : 'cV[R]_1 := 1%:M.
Definition integrator_C : 'rV[R]_1 := 1%:M.

Lemma integrator_is_minimal : minimal integrator_A integrator_B integrator_C.
Proof. by apply/minimal_iff_coprime; rewrite numerator_1 mulr1 coprimep1. Qed.

(* Refuted: Theorem 1 with G_c = N_c / D_c the transfer function K (sI - A_c)^-1 F of the
   compensator (7.11)-(7.12) itself. For the integrator with K = F = 1, n is odd and
   DD_c + NN_c = s^2 + 1 has no real root. (7.23) needs G_c = -K (sI - A_c)^-1 F. *)
Theorem theorem_1_needs_the_minus_sign :
  let K : 'rV[R]_1 := 1%:M in let F : 'cV[R]_1 := 1%:M in
  let A_c := observer_matrix integrator_A integrator_B integrator_C K F in
  let Dtilde := closed_loop_polynomial (denominator integrator_A)
    (numerator integrator_A integrator_B integrator_C) (denominator A_c) (numerator A_c F K) in
  [/\ minimal integrator_A integrator_B integrator_C, Dtilde = 'X^2 + 1,
      forall x, ~~ root Dtilde x & ~ two_roots Dtilde].
Proof.
move=> K F A_c Dtilde.
have EA_c : A_c = 0%:M by rewrite /A_c /observer_matrix /integrator_A -scalar_mxM addrK.
have EDtilde : Dtilde = 'X^2 + 1.
  rewrite /Dtilde /closed_loop_polynomial EA_c /denominator !char_poly_1 !numerator_1.
  by rewrite subr0 !mulr1 expr2.
have no_root x : ~~ root Dtilde x.
  by rewrite EDtilde rootE !hornerE -expr2 sum_of_squares_neq0.
split=> //; first exact: integrator_is_minimal.
case=> x [y [q factored]]; case/negP: (no_root x).
by rewrite factored !rootM !root_XsubC eqxx orbT.
Qed.

(* Refuted: "at least two real roots" of Theorem 1 as two different roots, for n = 1. The integrator
   with K = -1, F = 1 is an observer-based loop with DD_c + NN_c = (s + 1)^2. *)
Theorem theorem_1_counts_multiplicity : exists D_c N_c,
  let Dtilde := closed_loop_polynomial (denominator integrator_A)
    (numerator integrator_A integrator_B integrator_C) D_c N_c in
  [/\ minimal integrator_A integrator_B integrator_C,
      pair_is_observer_based integrator_A integrator_B integrator_C D_c N_c,
      Dtilde = ('X + 1) ^+ 2 & forall x, root Dtilde x <-> x = -1].
Proof.
pose K : 'rV[R]_1 := (-1)%:M; pose F : 'cV[R]_1 := 1%:M.
pose A_c := observer_matrix integrator_A integrator_B integrator_C K F.
exists (denominator A_c), (- numerator A_c F K) => Dtilde.
have EDtilde : Dtilde = ('X + 1) ^+ 2.
  rewrite /Dtilde separation_7_23 /integrator_A /integrator_B /integrator_C.
  by rewrite -!scalar_mxM -!raddfN -!raddfD /= !char_poly_1 !mulr1 !mul1r !add0r polyCN opprK.
split=> //; [exact: integrator_is_minimal | by exists K, F |].
move=> x; rewrite EDtilde rootE !hornerE mulf_eq0 orbb addr_eq0.
by split=> [/eqP|->].
Qed.

(* Refuted: the same for n = 3. A loop whose polynomial is (s + 1)^2 (s^2 + 1)^2 is observer-based,
   and a count of different real roots gives one. *)
Theorem theorem_1_counts_multiplicity_n_3 :
  exists (A : 'M[R]_3) (B : 'cV[R]_3) (C : 'rV[R]_3) (D_c N_c : {poly R}),
  let Dtilde := closed_loop_polynomial (denominator A) (numerator A B C) D_c N_c in
  [/\ minimal A B C, [/\ D_c \is monic, degree_is D_c 3 & degree_below N_c 3],
      pair_is_observer_based A B C D_c N_c,
      Dtilde = ('X + 1) ^+ 2 * ('X^2 + 1) ^+ 2 & forall x, root Dtilde x <-> x = -1].
Proof.
have deg_1 : (size (1%R : {poly R}) <= 3)%N by rewrite size_poly1.
have [Den Num] := canonical_form (monicXn R 3) (size_polyXn R 3) deg_1.
set A := companion 3 _ in Den Num; set B := canonical_input _ _ in Num.
set C := canonical_output _ _ in Num.
have coprime_DN : coprimep ('X^3 : {poly R}) 1 by rewrite coprimep1.
have minimal_plant : minimal A B C by apply/minimal_iff_coprime; rewrite Den Num.
have quadratic : ('X^2 + 1 : {poly R}) \is monic /\ degree_is ('X^2 + 1 : {poly R}) 2.
  by apply: monic_square; rewrite size_poly1.
have linear : ('X + 1 : {poly R}) \is monic /\ degree_is ('X + 1 : {poly R}) 1.
  by apply: monic_linear; rewrite size_poly1.
have [monic_p deg_p] := monic_product linear quadratic.
set p := ('X + 1) * _ in monic_p deg_p.
have [monic_pp deg_pp] := monic_product (conj monic_p deg_p) (conj monic_p deg_p).
have [|D_c [N_c [monic_Dc deg_Dc deg_Nc placed _]]] := @proposition_5 R 3 3 _ _ _ coprime_DN
  (monicXn R 3) (size_polyXn R 3) deg_1 isT monic_pp deg_pp; first by [].
exists A, B, C, D_c, N_c => Dtilde.
have EDtilde : Dtilde = p * p by rewrite /Dtilde Den Num.
split=> //.
  have [_ based] := pair_is_observer_based_iff minimal_plant D_c deg_Nc.
  by apply: based; exists p, p.
  by rewrite EDtilde /p mulrACA -!expr2.
move=> x; rewrite EDtilde rootM orbb /p rootM !rootE !hornerE -expr2.
rewrite (negPf (sum_of_squares_neq0 x)) orbF addr_eq0.
by split=> [/eqP|->].
Qed.

(* Refuted: Proposition 1's proof, "deg(N_c) = n - 1" for an observer-based compensator. Here n = 2,
   KF = 0 and the numerator is a constant. True, and enough, is deg(N_c) <= n - 1. *)
Theorem proposition_1_degree_of_the_numerator :
  let A : 'M[R]_2 := matrix_2 0 1 (- 2%:R) (- 3%:R) in
  let B := column_2 0 1 in let C := row_2 1 0 in let K := row_2 1 0 in let F := column_2 0 1 in
  [/\ minimal A B C, K *m F = 0 & degree_is (numerator (observer_matrix A B C K F) F K) 0].
Proof.
move=> A B C K F.
have same : observer_matrix A B C K F = A by rewrite /observer_matrix addrK.
have Num : numerator A B C = 1.
  by rewrite numerator_2; transitivity (0%:P * 'X + 1%:P : {poly R}); [congr (_%:P * _ + _%:P) | ];
    rewrite ?mul0r ?add0r //; ring.
split.
- by apply/minimal_iff_coprime; rewrite Num coprimep1.
- by entry_by_entry; rewrite mulr0 mul0r !addr0.
by rewrite same -/B -/C Num size_poly1.
Qed.
End Orders.

(* Refuted: Proposition 2 without the standing assumption that N and D are coprime. For
   D = (s + 1)(s + 2), N = s + 1 the pairs (0, s^2) and (s + 2, s^2 - 1) satisfy every hypothesis
   that the proposition states, and give the same DD_c + NN_c. *)
Theorem proposition_2_needs_coprimeness (R : fieldType) :
  let D : {poly R} := ('X + 1) * ('X + 2%:R) in let N : {poly R} := 'X + 1 in
  exists D_1 N_1 D_2 N_2,
  [/\ [/\ D \is monic, degree_is D 2 & degree_below N 2],
      [/\ D_1 \is monic, degree_is D_1 2 & degree_below N_1 2],
      [/\ D_2 \is monic, degree_is D_2 2 & degree_below N_2 2],
      closed_loop_polynomial D N D_1 N_1 = closed_loop_polynomial D N D_2 N_2
    & D_1 <> D_2 /\ N_1 <> N_2].
Proof.
move=> D N; exists 'X^2, 0, ('X^2 - 1), ('X + 2%:R).
have linear (b : {poly R}) : (size b <= 1)%N -> 'X + b \is monic /\ degree_is ('X + b : {poly R}) 1.
  exact: monic_linear.
have one : (size (1%R : {poly R}) <= 1)%N by rewrite size_poly1.
have two := size_natural R 2.
have [monic_D deg_D] := monic_product (linear _ one) (linear _ two).
have [monic_2 deg_2] : ('X^2 - 1 : {poly R}) \is monic /\ degree_is ('X^2 - 1 : {poly R}) 2.
  by apply: monic_square; rewrite size_opp.
split; first by split; rewrite // (linear _ one).2.
- by split; rewrite ?monicXn ?size_polyXn ?size_poly0.
- by split; rewrite // (linear _ two).2.
- exact: same_closed_loop.
split=> /eqP; first by rewrite eq_sym -subr_eq0 addrAC subrr add0r oppr_eq0 oner_eq0.
by rewrite eq_sym => /eqP zero; have := (linear _ two).2; rewrite zero size_poly0.
Qed.
