(* Witnesses of the theorems on target models, on the least squares of RCMR, on the limit of (8.96) and on
   the unscented filter. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import fingroup perm all_real_closed.
From Compensators.foundations Require Import Vocabulary PositiveDefinite.
From Compensators.theorems Require Import HighAuthorityPoles.
From Compensators.theorems Require ForwardConvergence TargetPoles TargetDirections SubsystemRecursion.
From Compensators.theorems Require UnscentedTransformation MinimalLoops ControllerForms ClosedLoop.
From Compensators.theorems Require ExtendedPerformance.
From Compensators.witnesses Require Import Satisfiable Placement Circle.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Local Notation o := (number (0 : Q)).
Local Notation e := (number (1 : Q)).

(* x+ = u with R_1 = 0. *)
Lemma forward_riccati_converges : ltac:(can_be_met (@ForwardConvergence.forward_riccati_converges)).
Proof.
move=> absurd; apply: (absurd [rcfType of realalg] 0%N 1%N (number 0) 0 (number 1) 1%:M).
- exact: zero_semidefinite.
- exact: one_definite.
- by exists 0; rewrite mulmx0 addr0; apply: inside_O.
by exists 0; rewrite mulmx0 addr0; apply: inside_O.
Qed.

(* G_zu = 1 and D_p = 1, or D_p = q. *)
Lemma remaining_poles : ltac:(can_be_met (@TargetPoles.remaining_poles)).
Proof.
by move=> absurd; apply: (absurd Q 0%N 0%N 0%N 0%N 0%N 1 1 1 1 1); rewrite ?monic1 ?size_poly1 ?oner_neq0.
Qed.

Lemma degree_of_matched_loop : ltac:(can_be_met (@TargetPoles.degree_of_matched_loop)).
Proof.
by move=> absurd; apply: (absurd Q 0%N 0%N 0%N 0%N 0%N 1 1 1 1 1);
  rewrite ?monic1 ?size_poly1 ?oner_neq0 // /TargetPoles.matches_target !mul1r !mulr1.
Qed.

Lemma too_many_poles : ltac:(can_be_met (@TargetPoles.too_many_poles)).
Proof.
by move=> absurd; apply: (absurd Q 0%N 1%N 0%N 0%N 0%N 1 1 1 'X 1);
  rewrite ?monic1 ?size_poly1 ?oner_neq0 ?monicX ?size_polyX // /TargetPoles.matches_target
    !mulr1 !scale1r mul1r.
Qed.

Lemma hidden_zeros : ltac:(can_be_met (@TargetPoles.hidden_zeros)).
Proof.
by move=> absurd; apply: (absurd Q 0%N 0%N 0%N 0%N 0%N 1 1 1 1 1 _ _ _ _ _ _ _ 1 1 0);
  rewrite ?monic1 ?size_poly1 ?oner_neq0 ?coprimep1 ?mulr0 ?subr0 ?mulr1 //
    /TargetPoles.matches_target !mul1r !mulr1.
Qed.

Lemma direction_is_kept : ltac:(can_be_met (@TargetDirections.direction_is_kept)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 1%N 0%N 1 1 0 0 0 1%:M 0 0 0).
- by rewrite /TargetDirections.matches_target_matrix scaler0 mul0mx.
- by rewrite mul0mx.
rewrite /TargetDirections.loop_matrix mul0mx subr0 scale1r /TargetDirections.at_point map_mx1.
exact: unitmx1.
Qed.

Lemma lost_direction_is_a_pole : ltac:(can_be_met (@TargetDirections.lost_direction_is_a_pole)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 1%N 0%N 1 1 0 1%:M 0 0 0 0 1%:M).
- by rewrite /TargetDirections.matches_target_matrix /TargetDirections.loop_matrix scaler0 mul1mx
    scaler0 mul0mx subr0.
- by rewrite mul1mx /TargetDirections.at_point map_mx0.
by rewrite mul1mx /TargetDirections.at_point map_mx1 one_is_not_zero.
Qed.

Lemma gain_8_62 : ltac:(can_be_met (@SubsystemRecursion.gain_8_62)).
Proof.
by move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1 ltr01 1%:M 0); apply: one_definite.
Qed.

Lemma subsystem_recursion_minimises : ltac:(can_be_met (@SubsystemRecursion.subsystem_recursion_minimises)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] 1%N 1%N 1 (fun=> 0) (fun=> 0) 1%:M 0 ltr01 _ 0%N 1%:M).
  exact: one_definite.
exact: one_is_not_zero.
Qed.

Lemma unscented_forecast : ltac:(can_be_met (@UnscentedTransformation.unscented_forecast)).
Proof. by move=> absurd; apply: (absurd Q 1%N 0 0 0 0 0 0 1 1); rewrite ?mul0mx ?expr1n. Qed.

Lemma unscented_is_kalman : ltac:(can_be_met (@UnscentedTransformation.unscented_is_kalman)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 0 0 0 0 0 0 1%:M 0 0 0 1 1); rewrite ?trmx0 ?trmx1 ?mul0mx ?expr1n //.
  by rewrite ?mulmx0 ?mul0mx add0r unitmx1.
have two : 2%:R != 0 :> Q by []. have one : 1 != 0 :> Q by [].
have square : (0 : 'M[Q]_1) *m (0 : 'M[Q]_1)^T = 0 by rewrite trmx0 mulmx0.
have [_ ->] := UnscentedTransformation.unscented_forecast 0 0 0 0 two one (expr1n _ 2) square.
by rewrite !mul0mx addr0.
Qed.

Lemma printed_gain_ignores_Q : ltac:(can_be_met (@UnscentedTransformation.printed_gain_ignores_Q)).
Proof.
by move=> absurd; apply: (absurd Q 1%N 1%N 0 0 0 0 0 0 1 1 _ _ _ _ 0); rewrite ?mul0mx ?expr1n.
Qed.

Lemma minimal_loop_is_nonderogatory :
  ltac:(can_be_met (@MinimalLoops.minimal_loop_is_nonderogatory)).
Proof.
move=> absurd; apply: (absurd Q Q [rmorphism of idfun] 0%N 0%N o e e o e e 1 1%N e e (integrator_is_minimal Q) sees).
by rewrite (map_mx_id _) // integrator_loop mulmx1 scale1r.
Qed.

(* Controllers whose signals are 0. *)
Lemma controller_2_32 : ltac:(can_be_met (@ControllerForms.controller_2_32)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1 1%N 1%N 0%N _ (fun=> 0) (fun=> 0) 0 0 1%N) => //.
by rewrite !big_geq // addr0.
Qed.

Lemma fir_controller_2_35 : ltac:(can_be_met (@ControllerForms.fir_controller_2_35)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1 1%N 1%N 0%N _ (fun=> 0) 0 0 1%N) => //.
by rewrite big_geq.
Qed.

Lemma quasi_fir_controller_6_1 : ltac:(can_be_met (@ControllerForms.quasi_fir_controller_6_1)).
Proof. by move=> absurd; apply: (absurd [comUnitRingType of rat] 1 1%N 2%N _ (fun=> 0)). Qed.

Lemma integrator_controller_6_4 : ltac:(can_be_met (@ControllerForms.integrator_controller_6_4)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1 1%N 1%N 0%N _ (fun=> 0) 0 0 1%N 0 0 0) => //.
  by rewrite scaler0 mulmx0 addr0.
by rewrite big_geq // mulmx0 addr0.
Qed.

Lemma pid_controller_2_58 : ltac:(can_be_met (@ControllerForms.pid_controller_2_58)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1 1%N 1%N _ 0 0 0 0 0 0) => //.
  by rewrite !scaler0 addr0.
by rewrite !mul0mx !addr0.
Qed.

Lemma fir_target_poles : ltac:(can_be_met (@TargetPoles.fir_target_poles)).
Proof.
by move=> absurd; apply: (absurd Q 0%N 0%N 0%N 0%N 1 1 1 1); rewrite ?monic1 ?size_poly1 ?oner_neq0.
Qed.

Lemma compensator_7_24 : ltac:(can_be_met (@ClosedLoop.compensator_7_24)).
Proof. by move=> absurd; apply: (absurd Q 1 0); rewrite ?mulr0 ?addr0 oner_neq0. Qed.

Lemma performance_8_39 : ltac:(can_be_met (@ExtendedPerformance.performance_8_39)).
Proof.
by move=> absurd; apply: (absurd [comRingType of rat] 1%N 0%N 0%N (1%g : {perm _}) 0 0 0 0); rewrite mul0mx addr0.
Qed.

Lemma extended_8_45 : ltac:(can_be_met (@ExtendedPerformance.extended_8_45)).
Proof.
move=> absurd; apply: (absurd [comRingType of rat] 1%N 0%N 0%N (fun=> 0%N) (fun=> 0) (fun=> 0) (fun=> 0)
  (fun=> 0) 0).
by case.
Qed.
