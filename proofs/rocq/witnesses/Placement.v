(* Witnesses of the theorems of Chapters 2, 4 and 7 and of Appendix B. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems PositiveDefinite.
From Compensators.theorems Require RecursiveLeastSquares Intercalation PolePlacement.
From Compensators.theorems Require RecordedSignals StateFeedback.
From Compensators.theorems Require MinimalRealisations CanonicalForm ObserverBasedPairs RealFactors.
From Compensators.theorems Require Forms InvariantSubspaces CountOfForms HiddenModes Diophantine.
From Compensators.theorems Require Resultants.
From Compensators.theorems Require Import Kalman.
From Compensators.counterexamples Require Realisations UnobservableModes TransferFunction.
From Compensators.counterexamples Require Appendices.
From Compensators.witnesses Require Import Satisfiable.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Local Notation o := (number (0 : Q)).
Local Notation e := (number (1 : Q)).
Local Notation RR := [rcfType of realalg].
Local Notation O := (number (0 : [fieldType of realalg])).
Local Notation E := (number (1 : [fieldType of realalg])).

Lemma one_definite (R : realFieldType) : positive_definite (1%:M : 'M[R]_1).
Proof.
split=> [|x nz]; first exact: trmx1.
rewrite /value /bilinear mulmx1 mxE big_ord1 mxE -expr2 lt_def sqr_ge0 andbT sqrf_eq0.
by apply: contra nz => /eqP x0; apply/eqP/matrixP=> i j; rewrite !ord1 x0 mxE.
Qed.

Lemma zero_semidefinite (R : realFieldType) n : positive_semidefinite (0 : 'M[R]_n).
Proof. by split=> [|x]; rewrite ?trmx0 // /value /bilinear mulmx0 mul0mx mxE. Qed.

Lemma one_is_not_zero (R : ringType) : (1%:M : 'M[R]_1) != 0.
Proof. by apply/negP=> /eqP/matrixP/(_ 0 0)/eqP; rewrite !mxE eqxx oner_eq0. Qed.

Lemma recursive_least_squares : ltac:(can_be_met (@RecursiveLeastSquares.recursive_least_squares)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 1 (fun=> 0) (fun=> 1%:M) (fun=> 0)
  (fun=> 0) (fun=> 0) 1%:M 0 _ _ _ _ _ 0%N 1%:M) => // *; rewrite ?trmx1 ?trmx0 ?addr0 //;
  try exact: one_definite.
exact: one_is_not_zero.
Qed.

Lemma intercalation : ltac:(can_be_met (@Intercalation.intercalation)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1%N 1%N 1%N 1%N 0%N 1 0 0 0 0 1%:M 0 _ _
  0 0 0 0 0); rewrite ?mulmx0 ?mul0mx ?subr0 ?unitmx1 // ?addr0 ?mulmx0 ?scaler0 ?subrr //.
Qed.

Lemma compact_form : ltac:(can_be_met (@Intercalation.compact_form)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1%N 1%N 1%N 0%N 1 0 0 1%:M 0);
  by rewrite ?mul0mx ?subr0 ?unitmx1.
Qed.

Lemma scalar_form_4_18 : ltac:(can_be_met (@Intercalation.scalar_form_4_18)).
Proof. by move=> absurd; apply: (absurd Q 1%N 1 1 1 0 1 0). Qed.

Lemma external_perturbation_4_19 : ltac:(can_be_met (@Intercalation.external_perturbation_4_19)).
Proof. by move=> absurd; apply: (absurd Q 1 1 0 1 0 _ _ _ 0 0). Qed.

Lemma reaches : controllable o e. Proof. by case: (integrator_is_minimal Q). Qed.
Lemma sees : observable o e. Proof. by case: (integrator_is_minimal Q). Qed.

Lemma ackermann_places : ltac:(can_be_met (@PolePlacement.ackermann_places)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e 'X reaches (monicX _) (size_polyX _)). Qed.

Lemma regulator_gain : ltac:(can_be_met (@PolePlacement.regulator_gain)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e 'X reaches (monicX _) (size_polyX _)). Qed.

Lemma observer_gain : ltac:(can_be_met (@PolePlacement.observer_gain)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e 'X sees (monicX _) (size_polyX _)). Qed.

Lemma regulator_gain_is_unique : ltac:(can_be_met (@MinimalRealisations.regulator_gain_is_unique)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e 0 0 reaches). Qed.

Lemma observer_gain_is_unique : ltac:(can_be_met (@MinimalRealisations.observer_gain_is_unique)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e 0 0 sees). Qed.

Lemma canonical_form : ltac:(can_be_met (@CanonicalForm.canonical_form)).
Proof.
move=> absurd; apply: (absurd Q 0%N 'X 1 (monicX _) (size_polyX _)).
by rewrite size_poly1.
Qed.

Lemma similar_realisations : ltac:(can_be_met (@MinimalRealisations.similar_realisations)).
Proof. by move=> absurd; apply: (absurd Q 0%N o o e e e e (integrator_is_minimal Q)). Qed.

Lemma proposition_1 : ltac:(can_be_met (@ObserverBasedPairs.proposition_1)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e e (integrator_is_minimal Q) 0 0 0 0). Qed.

Lemma theorem_1 : ltac:(can_be_met (@ObserverBasedPairs.theorem_1)).
Proof.
move=> absurd; apply: (absurd RR 0%N O E E (integrator_is_minimal _) 'X 0 (monicX _) (size_polyX _)).
by rewrite size_poly0.
Qed.

Lemma pair_is_observer_based_iff :
  ltac:(can_be_met (@ObserverBasedPairs.pair_is_observer_based_iff)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e (integrator_is_minimal _) 'X 0).
by rewrite size_poly0.
Qed.

Lemma parity : ltac:(can_be_met (@RealFactors.parity)).
Proof. by move=> absurd; apply: (absurd RR 1%N 'X^2 (monicXn _ _) (size_polyXn _ _)). Qed.

Lemma theorem_1_transfer_functions :
  ltac:(can_be_met (@ObserverBasedPairs.theorem_1_transfer_functions)).
Proof.
move=> absurd; apply: (absurd RR 0%N O E E (integrator_is_minimal _) 1%N 'X 1); rewrite ?monicX //.
- by rewrite coprimep1.
- by rewrite size_polyX.
by rewrite size_poly1.
Qed.

Lemma one_root_is_enough : ltac:(can_be_met (@RealFactors.one_root_is_enough)).
Proof. by move=> absurd; apply: (absurd RR 1%N 'X^2 (size_polyXn _ _)). Qed.

Lemma theorem_1_realisations : ltac:(can_be_met (@Forms.theorem_1_realisations)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O E E O E E); apply: integrator_is_minimal.
Qed.

Lemma form_needs_real_roots : ltac:(can_be_met (@Forms.form_needs_real_roots)).
Proof.
move=> absurd; apply: (absurd RR 0%N O E E O E E); exists E, E, E.
exact: (integrator_form [fieldType of realalg]).
Qed.

Lemma real_roots_and_no_form : ltac:(can_be_met (@UnobservableModes.real_roots_and_no_form)).
Proof.
move=> absurd; have [[A [B [C [_ D N]]]] _] :=
  TransferFunction.theorem_1_is_not_about_transfer_functions RR.
exact: (absurd RR A B C D N).
Qed.

Lemma invariant_subspace_gives_form :
  ltac:(can_be_met (@InvariantSubspaces.invariant_subspace_gives_form)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e o e e e e e);
  by [exact: integrator_is_minimal | exact: integrator_rank | exact: integrator_loop].
Qed.

Lemma invariant_subspace_is_a_graph :
  ltac:(can_be_met (@InvariantSubspaces.invariant_subspace_is_a_graph)).
Proof.
move=> absurd; apply: (absurd Q 0%N 0%N o e e o e e e e e);
  by [exact: integrator_is_minimal | exact: integrator_rank | exact: integrator_loop].
Qed.

Lemma form_gives_invariant_subspace :
  ltac:(can_be_met (@InvariantSubspaces.form_gives_invariant_subspace)).
Proof. by move=> absurd; apply: (absurd Q 0%N o e e o e e e e e (integrator_form _)). Qed.

Lemma upper_part_is_injective : ltac:(can_be_met (@InvariantSubspaces.upper_part_is_injective)).
Proof.
have := integrator_loop Q; rewrite /closed_loop mul_block_col mul_col_mx => /eq_col_mx[up low].
move=> absurd; apply: (absurd Q 0%N 0%N 0%N o e e o e e e e e _ up low reaches sees) => //.
exact: integrator_rank.
Qed.

Lemma forms_are_divisors : ltac:(can_be_met (@Forms.forms_are_divisors)).
Proof.
by move=> absurd; apply: (absurd Q 0%N o e e o e e _ _ 'X (monicX _) (size_polyX _));
  apply: integrator_is_minimal.
Qed.

Lemma form_is_unique : ltac:(can_be_met (@Forms.form_is_unique)).
Proof.
by move=> absurd; apply: (absurd Q 0%N o e e o e e _ _ e e e e e e (integrator_form _)
  (integrator_form _) (erefl _)); apply: integrator_is_minimal.
Qed.

Lemma lemma_1 : ltac:(can_be_met (@Diophantine.lemma_1)).
Proof. by move=> absurd; apply: (absurd Q 0 0 0 1); rewrite ?size_poly0 ?size_poly1. Qed.

Lemma proposition_2 : ltac:(can_be_met (@Diophantine.proposition_2)).
Proof.
move=> absurd; apply: (absurd Q 'X 1 0 0 0 0) => //; first by rewrite coprimep1.
- by rewrite polyX_eq0.
- by rewrite size_poly0 size_polyX.
by rewrite size_poly0 size_polyX.
Qed.

Lemma M_1_multiplies : ltac:(can_be_met (@Resultants.M_1_multiplies)).
Proof. by move=> absurd; apply: (absurd Q 1%N 1%N 0 0 0 0); rewrite size_poly0. Qed.

Lemma proposition_3 : ltac:(can_be_met (@Resultants.proposition_3)).
Proof. by move=> absurd; apply: (absurd Q 1%N 1%N 0%N 'X 1); rewrite ?size_poly1. Qed.

Lemma proposition_4 : ltac:(can_be_met (@Resultants.proposition_4)).
Proof. by move=> absurd; apply: (absurd Q 1%N 0%N 'X 1); rewrite ?size_poly1. Qed.

Lemma proposition_5 : ltac:(can_be_met (@Diophantine.proposition_5)).
Proof.
move=> absurd; apply: (absurd Q 1%N 0%N 'X 1 'X); rewrite ?monicX ?size_polyX ?size_poly1 //.
by rewrite coprimep1.
Qed.

Lemma M_is_nonsingular : ltac:(can_be_met (@Resultants.M_is_nonsingular)).
Proof.
move=> absurd; apply: (absurd Q 1%N 0%N 'X 1); rewrite ?size_polyX ?size_poly1 //.
by rewrite coprimep1.
Qed.

Lemma theorem_A1 : ltac:(can_be_met (@Resultants.theorem_A1)).
Proof. by move=> absurd; apply: (absurd Q 1%N 0%N 'X 1); rewrite ?size_polyX ?size_poly1. Qed.

Lemma theorem_A2 : ltac:(can_be_met (@Resultants.theorem_A2)).
Proof. by move=> absurd; apply: (absurd Q 1%N 'X 1); rewrite ?size_polyX ?size_poly1. Qed.

Lemma recorded_signals : ltac:(can_be_met (@RecordedSignals.recorded_signals)).
Proof.
have zero : @RecordedSignals.trajectory [comUnitRingType of rat] 1 1 1 1 1 1 0 0 0 0 0 0 0 0 0
    (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0).
  by move=> k; split; rewrite ?mulmx0 ?addr0 // !big1 ?addr0 // => i _; rewrite mulmx0.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1%N 1%N 1%N 1%N 1%N 1%N 0 0 0 0 0 0 0 0 0
  (fun=> 0) (fun=> 0) _
  (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0)
  (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0)
  (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0)
  zero zero _ _ zero _ _ zero _ _ 0%N) => //.
by rewrite mul0mx subr0 unitmx1.
Qed.

Lemma theorem_A1_needs_a_k : ltac:(can_be_met (@Appendices.theorem_A1_needs_a_k)).
Proof. by move=> absurd; apply: (absurd Q). Qed.

Lemma heymann : ltac:(can_be_met (@StateFeedback.heymann)).
Proof.
move=> absurd; apply: (absurd Q 0%N 1%N o e 1%:M);
  first by rewrite StateFeedback.controllable_pair_1 reaches.
by rewrite mulmx1; apply: one_is_not_zero.
Qed.

Lemma output_injection_places : ltac:(can_be_met (@StateFeedback.output_injection_places)).
Proof.
move=> absurd; apply: (absurd Q 0%N 1%N o e 'X _ (monicX _) (size_polyX _)).
by rewrite StateFeedback.pair_duality StateFeedback.controllable_pair_1 -duality sees.
Qed.

Lemma residual_4_6 : ltac:(can_be_met (@Intercalation.residual_4_6)).
Proof.
move=> absurd; apply: (absurd [zmodType of rat] [zmodType of rat] [additive of idfun] 0 0 0 0).
by rewrite subr0.
Qed.
