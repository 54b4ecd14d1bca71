(* Witnesses of the theorems of Chapter 8 and Appendix A and of the updates. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems PositiveDefinite.
From Compensators.theorems Require ForwardRiccati ExactMatch MinimalLoops Lyapunov.
From Compensators.theorems Require StabilisingSolution MarkovParameters UnscentedTransformation.
From Compensators.theorems Require ClosedLoopOrder UdUpdate RetrospectiveInput.
From Compensators.theorems Require Import Kalman ReturnDifference HighAuthorityPoles Stein Riccati.
From Compensators.theorems Require Import HighAuthorityLqg.
From Compensators.counterexamples Require Realisations.
From Compensators.witnesses Require Import Satisfiable Placement.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Local Notation o := (number (0 : Q)).
Local Notation e := (number (1 : Q)).
Local Notation RR := [rcfType of realalg].
Local Notation O := (number (0 : [fieldType of realalg])).
Local Notation E := (number (1 : [fieldType of realalg])).

(* The plant z = x, x+ = u without a cost of u: P = 1, K = 0, and the pole is at 0. *)
Lemma inside_X (R : rcfType) : inside ('X : {poly R}).
Proof. by move=> z; rewrite map_polyX rootX => /eqP->; rewrite normr0 ltr01. Qed.

Lemma inside_1 (R : rcfType) : inside (1 : {poly R}).
Proof. by move=> z; rewrite rmorph1 (negPf (root1 z)). Qed.

Lemma outside_1 (R : rcfType) : outside (1 : {poly R}).
Proof. by move=> z; rewrite rmorph1 (negPf (root1 z)). Qed.

Lemma inside_O : inside (char_poly O). Proof. by rewrite integrator_denominator; apply: inside_X. Qed.

Lemma full_numerator_1 : full_numerator O E E 0 = 1 *: (1 * 1).
Proof. by rewrite /full_numerator polyC0 mul0r addr0 numerator_1 !mul1r scale1r polyC1. Qed.

Lemma split_1 : split_by_circle (full_numerator O E E 0) 1 1 1 0 0.
Proof.
split; [exact: full_numerator_1 | exact: oner_neq0 | split | split]; rewrite ?monic1 ?size_poly1 //.
  exact: inside_1.
exact: outside_1.
Qed.

Lemma optimal_1 : optimal_regulator O E E 0 E 0.
Proof.
have EO : E^T = E by apply: tr_scalar_mx.
have OT : O^T = O by apply: tr_scalar_mx.
split; rewrite ?EO ?OT //.
- by rewrite scaler0 scale0r add0r /number mulmx1 raddf0 mulmx0 oppr0.
- by rewrite /number raddf0 !mulmx0 mulmx1 add0r scaler0 subr0.
by rewrite mulmx0 addr0; apply: inside_O.
Qed.

Lemma poles_of_high_authority_lqg : ltac:(can_be_met (@HighAuthorityPoles.poles_of_high_authority_lqg)).
Proof.
have [P_T gain riccati in_K] := optimal_1.
have [N nz [ms ds ins] [mu du outu]] := split_1.
move=> absurd; exact: (absurd RR 1%N O E E E 0 0 1 0%N 0%N 1%N 1 1 P_T gain riccati in_K N nz
  (erefl _) ms ds ins mu du outu).
Qed.

Lemma poles_of_high_authority_observer :
  ltac:(can_be_met (@HighAuthorityPoles.poles_of_high_authority_observer)).
Proof.
have [N nz [ms ds ins] [mu du outu]] := split_1.
have ET : E^T = E by apply: tr_scalar_mx.
have OT : O^T = O by apply: tr_scalar_mx.
move=> absurd; apply: (absurd RR 1%N O E E E 0 0 1 0%N 0%N 1%N 1 1); rewrite ?ET ?OT //.
- by rewrite scaler0 scale0r add0r /number raddf0 !mul0mx.
- by rewrite /number raddf0 !mul0mx mulmx1 add0r scaler0 subr0.
by rewrite mul0mx subr0; apply: inside_O.
Qed.

Lemma spectral_factorisation : ltac:(can_be_met (@ReturnDifference.spectral_factorisation)).
Proof.
have [P_T gain riccati _] := optimal_1.
by move=> absurd; apply: (absurd [fieldType of realalg] 1%N O E E E 0 0 P_T gain riccati 1 1); rewrite mulr1.
Qed.

Lemma return_difference : ltac:(can_be_met (@ReturnDifference.return_difference)).
Proof.
move=> absurd; apply: (absurd [comRingType of rat] 1%N 1%N 0 0 0 0 0 0 0 0 _ _ _ _ _ 0%N 0%N 1 1 0 0 0 0);
  by rewrite ?trmx0 ?mulmx0 ?mul0mx ?addr0 ?subr0 ?oppr0 ?mulr1 ?scaler0.
Qed.

Lemma difference_of_solutions : ltac:(can_be_met (@Riccati.difference_of_solutions)).
Proof.
by move=> absurd; apply: (absurd [comRingType of rat] 1%N 1%N 0 0 0 0 0 _ 0 0 0 0);
  rewrite ?trmx0 //; split; rewrite ?trmx0 ?mulmx0 ?mul0mx ?addr0 ?subr0 ?oppr0.
Qed.

Lemma stabilising_solution_is_unique : ltac:(can_be_met (@Riccati.stabilising_solution_is_unique)).
Proof.
have S := optimal_is_stabilising optimal_1.
by move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ _ S S); rewrite tr_scalar_mx.
Qed.

Lemma reaches_E : controllable O E. Proof. by case: (integrator_is_minimal [fieldType of realalg]). Qed.
Lemma sees_E : observable O E. Proof. by case: (integrator_is_minimal [fieldType of realalg]). Qed.

Lemma stabilising_solution_exists : ltac:(can_be_met (@Riccati.stabilising_solution_exists)).
Proof.
have [N nz [ms ds ins] [mu du outu]] := split_1.
move=> absurd; exact: (absurd RR 0%N O E E 0 1 0%N 0%N 1%N 1 1 reaches_E N (erefl _) ms ds ins mu du outu).
Qed.

Lemma optimal_regulator_is_unique : ltac:(can_be_met (@HighAuthorityLqg.optimal_regulator_is_unique)).
Proof. by move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ optimal_1 optimal_1). Qed.

Lemma high_authority_regulator : ltac:(can_be_met (@HighAuthorityLqg.high_authority_regulator)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O E E 0 1 0%N 0%N 1%N 1 1 reaches_E split_1).
Qed.

Lemma high_authority_observer : ltac:(can_be_met (@HighAuthorityLqg.high_authority_observer)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O E E 0 1 0%N 0%N 1%N 1 1 sees_E split_1).
Qed.

Lemma poles_A_17 : ltac:(can_be_met (@HighAuthorityLqg.poles_A_17)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O E E E E 0 0 0 1 1 0%N 0%N 1%N 0%N 0%N 1%N 1 1 1 1
  reaches_E sees_E split_1 split_1).
Qed.

Lemma target_4_24 : ltac:(can_be_met (@HighAuthorityLqg.target_4_24)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O E E 0 1 0%N 0%N 1%N 0%N 1%N 1 1 1 1 split_1).
Qed.

Lemma stein_zero : ltac:(can_be_met (@Stein.stein_zero)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O O 0 inside_O inside_O); rewrite mulmx0 mul0mx.
Qed.

Lemma stein_solvable : ltac:(can_be_met (@Stein.stein_solvable)).
Proof. by move=> absurd; apply: (absurd RR 0%N O O 0 inside_O inside_O). Qed.

Lemma stein_unique : ltac:(can_be_met (@Stein.stein_unique)).
Proof.
by move=> absurd; apply: (absurd RR 0%N O O 0 0 0 inside_O inside_O); rewrite mulmx0 mul0mx addr0.
Qed.

Lemma lyapunov_4_23 : ltac:(can_be_met (@Stein.lyapunov_4_23)).
Proof. by move=> absurd; apply: (absurd RR 0%N O 0 inside_O); rewrite trmx0. Qed.

Lemma forward_step_with_gain : ltac:(can_be_met (@ForwardRiccati.forward_step_with_gain)).
Proof.
by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 0 0 0 0 1%:M);
  [exact: zero_semidefinite | exact: one_definite].
Qed.

Lemma forward_step_is_semidefinite : ltac:(can_be_met (@ForwardRiccati.forward_step_is_semidefinite)).
Proof.
by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 0 0 0 0 1%:M);
  [exact: zero_semidefinite | exact: zero_semidefinite | exact: one_definite].
Qed.

Lemma forward_riccati_is_semidefinite :
  ltac:(can_be_met (@ForwardRiccati.forward_riccati_is_semidefinite)).
Proof.
by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 0 0 0 0 1%:M 0%N);
  [exact: zero_semidefinite | exact: zero_semidefinite | exact: one_definite].
Qed.

Lemma exact_match_bound : ltac:(can_be_met (@ExactMatch.exact_match_bound)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 1 (fun=> 0) (fun=> 1%:M) (fun=> 0)
  (fun=> 0) (fun=> 0) 1%:M 0 _ _ _ _ 0%N 0) => // *; try exact: one_definite.
by rewrite mulmx0 addr0 subr0.
Qed.

Lemma minimal_loop_has_one_eigenvector :
  ltac:(can_be_met (@MinimalLoops.minimal_loop_has_one_eigenvector)).
Proof.
move=> absurd; apply: (absurd Q 0%N 0%N o e e o e e 1 1%N e e (integrator_is_minimal Q) sees).
by rewrite integrator_loop mulmx1 scale1r.
Qed.

Lemma closed_loop_order : ltac:(can_be_met (@ClosedLoopOrder.closed_loop_order)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e 0 1%N 'X 0); rewrite ?monicX ?size_polyX //.
by rewrite size_poly0.
Qed.

Lemma ud_update_stays_positive : ltac:(can_be_met (@UdUpdate.ud_update_stays_positive)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1 1 1%:M (const_mx 1) 0 _ _ _ 0) => //.
by move=> k; rewrite mxE.
Qed.

Lemma ud_update_stays_triangular : ltac:(can_be_met (@UdUpdate.ud_update_stays_triangular)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1 1%:M (const_mx 1) 0) => i j _.
by rewrite mxE.
Qed.

Lemma ud_update_is_covariance_update :
  ltac:(can_be_met (@UdUpdate.ud_update_is_covariance_update)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1 1 1%:M (const_mx 1) 0) => //.
by move=> k; rewrite mxE.
Qed.

Lemma hidden_mode_is_double_pole : ltac:(can_be_met (@Realisations.hidden_mode_is_double_pole)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e o 0 0 e 0 0 0 e e); rewrite ?scale0r ?mul0mx ?mulmx0 //.
- split; rewrite ?unitmx1 ?mulmx0 ?mul0mx // /observer_matrix mulmx0 mul0mx addr0 subr0.
  by rewrite /number mulmx1 mul1mx.
- by rewrite /number raddf0 mul0mx.
- exact: one_is_not_zero.
- by rewrite /number raddf0 mulmx0.
exact: one_is_not_zero.
Qed.

Lemma quadratic_form_8_52 : ltac:(can_be_met (@RetrospectiveInput.quadratic_form_8_52)).
Proof. by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 0 0 0 0 0 _ 0); rewrite trmx0. Qed.

Lemma retrospective_input_minimises :
  ltac:(can_be_met (@RetrospectiveInput.retrospective_input_minimises)).
Proof.
move=> absurd; suff anywhere (K : realFieldType) : Logic.False by exact: (anywhere [realFieldType of rat]).
apply: (absurd K 1%N 1%N 0 0 1 0 0 _ 1%:M); rewrite ?trmx0 //.
  by rewrite /RetrospectiveInput.quadratic_part mulmx0 add0r; apply: one_definite.
rewrite /RetrospectiveInput.retrospective_input /RetrospectiveInput.linear_part !(mulmx0, mul0mx) scaler0.
by rewrite mulmx0 scaler0 oppr0; apply: one_is_not_zero.
Qed.

Lemma lyapunov_semidefinite : ltac:(can_be_met (@Lyapunov.lyapunov_semidefinite)).
Proof.
move=> absurd; apply: (absurd RR 1%N O 0 0 inside_O); rewrite ?trmx0 //.
  exact: zero_semidefinite.
by rewrite mulmx0 mul0mx addr0.
Qed.

(* x+ = u with the cost of u alone. *)
Lemma stabilising_solution : ltac:(can_be_met (@StabilisingSolution.stabilising_solution)).
Proof.
move=> absurd; apply: (absurd RR 0%N 1%N O 0 E 0 1%:M); last exact: one_definite.
- by exists 0; rewrite mulmx0 addr0; apply: inside_O.
- move=> z x u circle state _; rewrite trmx0 map_mx0 mul0mx add0r map_mx1 mul1mx => u0.
  move: state; rewrite u0 mulmx0 addr0 /number raddf0 map_mx0 mul0mx => /esym/eqP.
  by rewrite scaler_eq0 -normr_eq0 circle oner_eq0 => /eqP.
pose Phi : 'M[[rcfType of realalg]]_(1, 1 + 1) := row_mx (0 : 'M_1) 1%:M.
have -> : block_mx 0 0 0^T 1%:M = Phi^T *m 1%:M *m Phi.
  by rewrite /Phi tr_row_mx !trmx0 trmx1 mulmx1 mul_col_row !mul0mx mulmx0 mulmx1.
exact/semidefinite_congruence/definite_semidefinite/one_definite.
Qed.

Lemma predictor_gain_is_dual : ltac:(can_be_met (@ForwardRiccati.predictor_gain_is_dual)).
Proof.
by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 0 0 0 0 (trmx0 _ _ _) (trmx0 _ _ _)).
Qed.

Lemma state_8_36 : ltac:(can_be_met (@MarkovParameters.state_8_36)).
Proof.
move=> absurd; apply: (absurd [ringType of rat] 1%N 1%N 1%N 0 0 0 (fun=> 0) (fun=> 0) (fun=> 0) _ 0%N 0%N).
by move=> k; rewrite !mulmx0 !addr0.
Qed.

Lemma performance_8_37 : ltac:(can_be_met (@MarkovParameters.performance_8_37)).
Proof.
move=> absurd; apply: (absurd [ringType of rat] 1%N 1%N 1%N 1%N 0 0 0 0 (fun=> 0) (fun=> 0) (fun=> 0)
  (fun=> 0) _ 0%N 0%N).
by move=> k; rewrite !mulmx0 !addr0.
Qed.

Lemma mean_8_12 : ltac:(can_be_met (@UnscentedTransformation.mean_8_12)).
Proof. by move=> absurd; apply: (absurd Q 1%N 0 0 1 1). Qed.

Lemma covariance_8_12 : ltac:(can_be_met (@UnscentedTransformation.covariance_8_12)).
Proof. by move=> absurd; apply: (absurd Q 1%N 0 0 0 1 1); rewrite ?mul0mx ?expr1n. Qed.
