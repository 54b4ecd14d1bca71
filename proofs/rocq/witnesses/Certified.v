(* Witnesses of the theorems on gains that move beside theta, on bounds of peaks, on one compensator for two
   plants, on all compensators of a plant with several signals and on semidefinite matrices. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed all_field.
From Compensators.foundations Require Import Vocabulary PositiveDefinite SmallSystems.
From Compensators.theorems Require ForwardConvergence SmallGain MovingGains PeakBounds YoulaKucera.
From Compensators.theorems Require StableProperFunctions SimultaneousStabilisation StabilisingMatrices.
From Compensators.theorems Require Lyapunov SemidefiniteMatrices GainOnTheCircle.
From Compensators.theorems Require Import HighAuthorityPoles.
From Compensators.witnesses Require Import Satisfiable Placement Circle Stability.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [realFieldType of rat].
Local Notation F := [fieldType of rat].

(* Where a witness computes with zeros and ones it does so over any field K, and rat is put in at the end:
   comparing two expressions of rational numbers unfolds their construction. *)

Lemma one_semidefinite (R : realFieldType) n : positive_semidefinite (1%:M : 'M[R]_n).
Proof. exact/definite_semidefinite/identity_definite. Qed.

Lemma block_semidefinite (R : realFieldType) m n (M : 'M[R]_m) (N : 'M[R]_n) :
  positive_semidefinite M -> positive_semidefinite N -> positive_semidefinite (block_mx M 0 0 N).
Proof.
move=> [sym_M M_ge0] [sym_N N_ge0]; split=> [|y]; first by rewrite tr_block_mx !trmx0 sym_M sym_N.
by rewrite -[y]vsubmxK SmallGain.value_diagonal addr_ge0.
Qed.

(* x' = 0 and z = 0: every P and S that are not negative are a certificate. *)
Lemma nothing_dissipates (R : realFieldType) n m p (S : 'M[R]_m) (W : 'M[R]_p) :
  positive_semidefinite S -> SmallGain.bounded_real (1%:M : 'M_n) 0 (0 : 'M_(n, m)) (0 : 'M_(p, n)) 0 S W 0.
Proof.
move=> S_ge0; rewrite /SmallGain.bounded_real /SmallGain.dissipation !row_mx0 !mulmx0 !subr0 scale0r.
apply: block_semidefinite => //; split=> [|x]; first exact: trmx0.
by rewrite /value /bilinear mulmx0 mul0mx mxE.
Qed.

Lemma in_ellipsoid_of_factors : ltac:(can_be_met (@MovingGains.in_ellipsoid_of_factors)).
Proof.
move=> absurd; suff anywhere (K : realFieldType) : Logic.False by exact: (anywhere Q).
apply: (absurd K 1%N 1%N 1%:M 1%:M 1%:M 0 (trmx1 _ _)); first by rewrite trmx1 !mulmx1.
by rewrite big_ord1 big_ord1 mxE expr0n ler01.
Qed.

Lemma gains_beside_theta : ltac:(can_be_met (@MovingGains.gains_beside_theta)).
Proof.
move=> absurd; suff anywhere (K : realFieldType) : Logic.False by exact: (anywhere Q).
apply: (absurd K 1%N 1%N 1%N 1%N 1%:M 0 0 0 0 0 0 1%:M 1%:M (const_mx 1) 0
  (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0) (lexx 0) _ _ _ _ _ _ 0%N).
- by move=> i; rewrite mxE ler01.
- rewrite /MovingGains.scaled_small_gain !col_mx0; apply: nothing_dissipates.
  by rewrite /MovingGains.scaled_inputs diag_const_mx; apply: block_semidefinite; apply: one_semidefinite.
- by move=> k; apply: zero_in_ellipsoid.
- by move=> k i; rewrite mxE expr0n ler01.
- by move=> k; rewrite /MovingGains.moved_by !mulmx0 addr0 !mulmx0 col_mx0.
by move=> k; rewrite !mulmx0 addr0.
Qed.

Lemma limit_is_a_share : ltac:(can_be_met (@MovingGains.limit_is_a_share)).
Proof. by move=> absurd; apply: (absurd Q 0 1 1 ltr01 (lexx _)); rewrite normr0 ler01. Qed.

Lemma dependent_directions_keep_the_poles : ltac:(can_be_met (@MovingGains.dependent_directions_keep_the_poles)).
Proof.
move=> absurd; apply: (absurd [idomainType of rat] 1%N 1%N 1%N 0 0 0 0).
by rewrite mulmx0 map_mx0 !mul0mx.
Qed.

Section Peaks.
Variable K : realFieldType.
Let P : 'M[K]_1 := 1%:M.

Lemma nothing_is_supplied : PeakBounds.supplied P 0 (0 : 'M_(1, 1)) (0 : 'M_(1, 1)) (0 : 'M_1) (0 : 'M_(1, 1))
  (0 : 'M_(1, 1)) 1%:M 1%:M 1 0.
Proof.
rewrite /PeakBounds.supplied !row_mx0; apply: nothing_dissipates.
by apply: block_semidefinite; apply: one_semidefinite.
Qed.

Lemma nothing_is_driven : PeakBounds.driven_motion 0 (0 : 'M_(1, 1)) (0 : 'M_(1, 1)) (0 : 'M_1) (0 : 'M_(1, 1))
  (0 : 'M_(1, 1)) 1%:M 1%:M (fun=> 0 : 'cV[K]_1) (fun=> 0) (fun=> 0).
Proof.
by split=> k; rewrite ?mulmx0 ?addr0 // /ForwardConvergence.square /value /bilinear mulmx0 mxE ler01.
Qed.

Lemma nothing_at_the_start : value P (0 : 'cV_1) <= PeakBounds.level (1 : K) 0.
Proof. by rewrite /PeakBounds.level subr0 divr1 /value /bilinear mulmx0 mxE ler01. Qed.

Lemma no_contraction : 0 <= (0 : K) < 1. Proof. by rewrite lexx ltr01. Qed.
End Peaks.

Lemma states_stay_below_the_level : ltac:(can_be_met (@PeakBounds.states_stay_below_the_level)).
Proof.
move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ (nothing_is_supplied Q) ler01
  (no_contraction Q) _ _ _ (nothing_is_driven Q) (nothing_at_the_start Q) 0%N).
Qed.

Lemma signal_bound : ltac:(can_be_met (@PeakBounds.signal_bound)).
Proof.
move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ (nothing_is_supplied Q) ler01
  (no_contraction Q) _ _ _ (nothing_is_driven Q) (nothing_at_the_start Q) 0%N 0 (one_definite _)).
Qed.

Lemma form_bound : ltac:(can_be_met (@PeakBounds.form_bound)).
Proof.
move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ (nothing_is_supplied Q) ler01
  (no_contraction Q) _ _ _ (nothing_is_driven Q) (nothing_at_the_start Q) 0%N 1%N 0 0 1 ler01).
by rewrite mulmx0 subr0 scale1r; apply: one_semidefinite.
Qed.

Lemma channels_add_up : ltac:(can_be_met (@PeakBounds.channels_add_up)).
Proof.
by move=> absurd; apply: (absurd [comRingType of rat] 1%N 1%N (fun=> 0) (fun=> 0) (fun=> 0) (fun=> 0)
  (fun _ _ => 0) _ _ _ _ 0%N) => // *; rewrite !mul0mx addr0.
Qed.

(* Every function is stable: the field is a subring of itself, and 0 / 1 a plant. *)
Lemma zero_over_one (G : fieldType) :
  SimultaneousStabilisation.coprime_in (fun _ : G => Logic.True) 0 1 0 1.
Proof. by split; rewrite ?mul0r ?add0r ?mulr1. Qed.

Lemma stable_compensator_makes_a_unit :
  ltac:(can_be_met (@SimultaneousStabilisation.stable_compensator_makes_a_unit)).
Proof.
move=> absurd; apply: (absurd F _ (all_of_a_field _) 1 0 0 1 0 (oner_neq0 _) (zero_over_one F)).
exact: Logic.I.
Qed.

Lemma zero_is_no_unit (G : fieldType) : ~ SimultaneousStabilisation.unit_of (fun _ : G => Logic.True) 0.
Proof. by case; rewrite eqxx. Qed.

Lemma simultaneous_stabilisation :
  ltac:(can_be_met (@SimultaneousStabilisation.simultaneous_stabilisation)).
Proof.
move=> absurd; apply: (absurd F _ (all_of_a_field _) 0 1 0 1 0 1 0 1 (zero_over_one F) (zero_over_one F)
  (oner_neq0 _) (oner_neq0 _) (@zero_is_no_unit F)).
by rewrite /SimultaneousStabilisation.auxiliary_numerator !mul0r subrr; apply: zero_is_no_unit.
Qed.

Lemma constant_is_stable (c : rat) : StableProperFunctions.stable_proper (fun D : {poly rat} => D != 0)
  (@FracField.tofrac [idomainType of {poly rat}] c%:P).
Proof.
exists c%:P, 1; rewrite oner_neq0 size_poly1 (leq_trans (size_polyC_leq1 _)) //; split=> //.
by rewrite tofrac1 divr1.
Qed.

Lemma simultaneous_by_strong_stabilisation :
  ltac:(can_be_met (@SimultaneousStabilisation.simultaneous_by_strong_stabilisation)).
Proof.
have [one zero] := (constant_is_stable 1, constant_is_stable 0).
rewrite polyC1 tofrac1 in one; rewrite polyC0 tofrac0 in zero.
have plant : SimultaneousStabilisation.coprime_in
    (StableProperFunctions.stable_proper (fun D : {poly rat} => D != 0)) 0 1 0 1.
  by split; rewrite ?mul0r ?add0r ?mulr1.
have strict : SimultaneousStabilisation.strictly_stable (fun D : {poly rat} => D != 0) 0.
  by exists 0, 1; rewrite oner_neq0 size_poly0 size_poly1 tofrac0 mul0r.
move=> absurd; exact: (absurd F _ (all_polynomials _) 0 1 0 1 0 1 0 1 plant plant strict strict).
Qed.

Lemma stabilising_matrices_by_one_parameter :
  ltac:(can_be_met (@StabilisingMatrices.stabilising_matrices_by_one_parameter)).
Proof.
move=> absurd; apply: (absurd F _ (all_of_a_field _) 1%N 1%N 1%:M 0 0 1%:M 1%:M 0 0 1%:M _ (unitmx1 _ _)
  _ _ _ _ _ _ _ _ 0);
  try by [].
by rewrite /StabilisingMatrices.double_bezout oppr0 -scalar_mx_block mulmx1.
Qed.

Lemma all_stabilising_matrices : ltac:(can_be_met (@StabilisingMatrices.all_stabilising_matrices)).
Proof.
by move=> absurd; apply: (absurd F _ (all_polynomials _) 1%N 1%N 1%N 0 0 0 0 0 _ _ 0);
  rewrite monic_neq0 ?char_poly_monic.
Qed.

Lemma semidefinite_by_coefficients : ltac:(can_be_met (@SemidefiniteMatrices.semidefinite_by_coefficients)).
Proof. by move=> absurd; apply: (absurd [numClosedFieldType of algC] 1%N 0); apply: Lyapunov.adjoint_0. Qed.

Lemma positive_real_by_bounded_real : ltac:(can_be_met (@SemidefiniteMatrices.positive_real_by_bounded_real)).
Proof. by move=> absurd; apply: (absurd [numClosedFieldType of algC] 1%N 0); rewrite add0r unitmx1. Qed.

Lemma bounded_real_bounds_the_gain : ltac:(can_be_met (@GainOnTheCircle.bounded_real_bounds_the_gain)).
Proof.
move=> absurd; apply: (absurd [rcfType of realalg] 1%N 1%N 1%N 1%:M 0 0 0 0 1%:M 1%:M 0 0 0 0).
- exact/nothing_dissipates/one_semidefinite.
- by rewrite normr0 expr0n rmorph0.
by rewrite scaler0 !mulmx0 addr0.
Qed.
