(* Witnesses of the theorems on contraction and small gain, on predictive control, on parity interlacing, on
   all compensators, and of the tests of Routh, Kharitonov, Schur and Cohn. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary PositiveDefinite SmallSystems.
From Compensators.theorems Require ForwardConvergence Contraction SmallGain PredictiveControl ParityInterlacing.
From Compensators.theorems Require YoulaKucera StableProperFunctions RouthHurwitz HurwitzInequalities.
From Compensators.theorems Require Kharitonov SchurCohn TargetDirections.
From Compensators.theorems Require Import HighAuthorityPoles.
From Compensators.witnesses Require Import Satisfiable Placement Circle.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [realFieldType of rat].
Local Notation RR := [rcfType of realalg].

(* x' = 0 contracts in P = 1, at any rate. *)
Lemma zero_contracts (R : realFieldType) r : 0 <= r -> @Contraction.contracts R 1 1%:M r 0.
Proof.
move=> r_ge0; rewrite /Contraction.contracts mulmx0 subr0; split=> [|x].
  by rewrite linearZ /= trmx1.
by rewrite value_scale mulr_ge0 //; have [_] := definite_semidefinite (one_definite R); apply.
Qed.

Lemma one_symmetric (R : ringType) n : (1%:M : 'M[R]_n)^T = 1%:M. Proof. exact: trmx1. Qed.

Lemma motion_contracts : ltac:(can_be_met (@Contraction.motion_contracts)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%:M 0 (fun=> 0) (fun=> 0) (lexx 0) (one_symmetric _ _) _ _ 0%N) => k.
  exact: zero_contracts.
by rewrite mul0mx.
Qed.

Lemma motion_decays : ltac:(can_be_met (@Contraction.motion_decays)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%:M 0 (fun=> 0) (fun=> 0) (lexx 0) (one_definite _) _ _ 0%N 0) => k.
  exact: zero_contracts.
by rewrite mul0mx.
Qed.

Lemma strict_contraction_has_rate : ltac:(can_be_met (@Contraction.strict_contraction_has_rate)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%:M 0 (definite_semidefinite (one_definite _))).
by rewrite mulmx0 subr0; apply: one_definite.
Qed.

Lemma hull_contracts : ltac:(can_be_met (@Contraction.hull_contracts)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%:M 0 1%N (fun=> 1) (fun=> 0) (definite_semidefinite (one_definite _))).
- by move=> i; apply: ler01.
- by rewrite big_ord1.
by move=> i; apply: zero_contracts.
Qed.

Lemma motion_in_the_hull : ltac:(can_be_met (@Contraction.motion_in_the_hull)).
Proof.
move=> absurd; suff anywhere (K : realFieldType) : Logic.False by exact: (anywhere Q).
have zero (t : 'cV[K]_1) : Contraction.affine_loop (0 : 'M[K]_1) (fun=> 0) t = 0.
  by rewrite /Contraction.affine_loop big_ord1 scaler0 addr0.
apply: (absurd K 1%N 1%N 1%N 0 (fun=> 0) 1%:M 0 (fun=> 0) (fun _ _ => 1) (fun=> 0) (lexx 0)
  (definite_semidefinite (one_definite _)) _ _ _ _ 0%N).
- by move=> i; rewrite zero; apply: zero_contracts.
- by move=> k i; apply: ler01.
- by move=> k; rewrite big_ord1.
by move=> k; rewrite mulmx0.
Qed.

Lemma contraction_bounds_poles : ltac:(can_be_met (@Contraction.contraction_bounds_poles)).
Proof.
have E : (0 : 'M[RR]_1) = number (0 : [fieldType of realalg]) by rewrite /number raddf0.
move=> absurd; apply: (absurd RR 1%N 1%:M 0 0 (one_definite _) (zero_contracts (lexx 0)) 0).
by rewrite E integrator_denominator map_polyX rootX.
Qed.

Lemma contraction_is_stable : ltac:(can_be_met (@Contraction.contraction_is_stable)).
Proof.
by move=> absurd; apply: (absurd RR 1%N 1%:M 0 0 (one_definite _) (zero_contracts (lexx 0)) ltr01).
Qed.

Lemma identity_definite (R : realFieldType) n : positive_definite (1%:M : 'M[R]_n).
Proof.
split=> [|x nz]; first exact: trmx1.
have squares (i : 'I_n) : true -> 0 <= x i 0 ^+ 2 by rewrite sqr_ge0.
rewrite -/(ForwardConvergence.square x) ForwardConvergence.squareE lt_neqAle sumr_ge0 // andbT eq_sym.
apply: contraNneq nz => /eqP; rewrite psumr_eq0 // => /allP zero; apply/eqP/colP=> i; rewrite mxE.
by apply/eqP; rewrite -sqrf_eq0; apply: zero; rewrite mem_index_enum.
Qed.

(* x' = 0, z = 0, with the weight 1 of w and of z. *)
Lemma zero_dissipation (R : realFieldType) (r : R) :
  SmallGain.dissipation 1%:M (0 : 'M_1) (0 : 'M_1) (0 : 'M_1) 0 1%:M 1%:M r = block_mx (r *: 1%:M) 0 0 1%:M.
Proof. by rewrite /SmallGain.dissipation !row_mx0 !mulmx0 !subr0. Qed.

Lemma zero_bounded_real (R : realFieldType) (r : R) : 0 <= r ->
  SmallGain.bounded_real 1%:M (0 : 'M_1) (0 : 'M_1) (0 : 'M_1) 0 1%:M 1%:M r.
Proof.
move=> r_ge0; rewrite /SmallGain.bounded_real zero_dissipation; split=> [|y].
  by rewrite tr_block_mx !trmx0 linearZ /= !trmx1.
rewrite -[y]vsubmxK SmallGain.value_diagonal value_scale addr_ge0 ?mulr_ge0 //.
  by have [_] := definite_semidefinite (one_definite R); apply.
by have [_] := definite_semidefinite (one_definite R); apply.
Qed.

Lemma strict_dissipation (R : realFieldType) : positive_definite
  (SmallGain.dissipation 1%:M (0 : 'M[R]_1) (0 : 'M_1) (0 : 'M_1) 0 1%:M 1%:M 1).
Proof. by rewrite zero_dissipation scale1r -scalar_mx_block; apply: identity_definite. Qed.

Lemma zero_in_ellipsoid (R : realFieldType) : SmallGain.in_ellipsoid (1%:M : 'M[R]_1) (1%:M : 'M_1) 0.
Proof.
by rewrite /SmallGain.in_ellipsoid mulmx0 subr0; apply/definite_semidefinite/one_definite.
Qed.

Lemma robust_motion : ltac:(can_be_met (@SmallGain.robust_motion)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 1%N 1%:M 0 0 0 0 1%:M 1%:M 0 (fun=> 0) (fun=> 0) (lexx 0)
  (zero_bounded_real (lexx 0)) _ _ 0%N) => k.
  by rewrite !mulmx0 addr0.
by rewrite !mulmx0 addr0.
Qed.

Lemma strict_bounded_real_has_rate : ltac:(can_be_met (@SmallGain.strict_bounded_real_has_rate)).
Proof. by move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ (strict_dissipation Q)); apply: trmx1. Qed.

Lemma ellipsoid_contracts : ltac:(can_be_met (@SmallGain.ellipsoid_contracts)).
Proof.
by move=> absurd; apply: (absurd _ _ _ _ _ _ _ _ _ _ _ _ _ (zero_bounded_real (lexx (0 : Q)))
  (zero_in_ellipsoid Q)); apply: trmx1.
Qed.

Lemma ellipsoid_motion : ltac:(can_be_met (@SmallGain.ellipsoid_motion)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 1%N 1%:M 0 0 0 1%:M 1%:M (one_symmetric _ _) 0 (fun=> 0) (fun=> 0)
  (lexx 0) (zero_bounded_real (lexx 0)) _ _ 0%N) => k; first exact: zero_in_ellipsoid.
by rewrite mulmx0.
Qed.

Lemma certified_ellipsoid : ltac:(can_be_met (@SmallGain.certified_ellipsoid)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%N 1%N 1%:M 0 0 0 1%:M 1%:M (one_symmetric _ _) (one_definite _)).
exact: strict_dissipation.
Qed.

Lemma in_ellipsoid_of_one_input : ltac:(can_be_met (@SmallGain.in_ellipsoid_of_one_input)).
Proof.
move=> absurd; apply: (absurd Q 1%N 1%:M 0 (one_definite _)).
by rewrite /value /bilinear mulmx0 mxE ler01.
Qed.

Lemma estimate_is_a_window : ltac:(can_be_met (@PredictiveControl.estimate_is_a_window)).
Proof.
move=> absurd; apply: (absurd [idomainType of rat] 1%N 1%N 1%N 0 0 (fun=> 0) (fun=> 0) (fun=> 0) _ 0%N).
by move=> k; rewrite !mulmx0 !addr0.
Qed.

Lemma output_is_arx : ltac:(can_be_met (@PredictiveControl.output_is_arx)).
Proof.
move=> absurd; apply: (absurd [idomainType of rat] 1%N 1%N 1%N 0 0 (fun=> 0) (fun=> 0) _ 0%N).
by move=> k; rewrite !mulmx0 !addr0.
Qed.

Lemma loop_of_predictive_control : ltac:(can_be_met (@PredictiveControl.loop_of_predictive_control)).
Proof. by move=> absurd; apply: (absurd [idomainType of rat] 1%N 1%N 1%N 0 0 0). Qed.

(* The plant 0 / 1 with the compensator 0 / 1, whose loop has no roots. *)
Lemma no_roots (R : rcfType) (x : R) : ~~ root (closed_loop_polynomial 1 0 1 0) x.
Proof. by rewrite /closed_loop_polynomial mulr1 mul0r addr0 root1. Qed.

Lemma parity_interlacing : ltac:(can_be_met (@ParityInterlacing.parity_interlacing)).
Proof.
move=> absurd; apply: (absurd RR 1 0 1 0 0 1 [::] ler01 (root0 _) (root0 _)) => [x _|x _|].
- by rewrite root1.
- exact: no_roots.
by exists 1; rewrite big_nil mulr1; split=> // x _; rewrite root1.
Qed.

Lemma parity_interlacing_at_infinity :
  ltac:(can_be_met (@ParityInterlacing.parity_interlacing_at_infinity)).
Proof.
move=> absurd; apply: (absurd RR 1 0 1 0 0 [::] (root0 _)) => [||x _|x _|]; rewrite ?size_poly0 ?size_poly1 //.
- by rewrite root1.
- exact: no_roots.
by exists 1; rewrite big_nil mulr1; split=> // x _; rewrite root1.
Qed.

Lemma parity_interlacing_through_infinity :
  ltac:(can_be_met (@ParityInterlacing.parity_interlacing_through_infinity)).
Proof.
have reversed_1 : reversed 0 (1 : {poly RR}) = 1.
  by apply/polyP=> -[|i]; rewrite coef_poly ?coef1 //= coefC.
move=> absurd; apply: (absurd RR 0%N 0%N 1 0 1 0 1 (- 1) [::] ltr01 _ (root0 _) (root0 _));
  rewrite ?size_poly1 ?size_poly0 ?oppr_lt0 ?ltr01 //.
- by rewrite /closed_loop_polynomial mulr1 mul0r addr0 size_poly1.
- by move=> x _; rewrite root1.
- by move=> x _; apply: no_roots.
by exists 1; rewrite reversed_1 big_nil mulr1; split=> // x _; rewrite root1.
Qed.

Lemma roots_between_exist : ltac:(can_be_met (@ParityInterlacing.roots_between_exist)).
Proof. by move=> absurd; apply: (absurd RR 1 0 1); rewrite ?oner_neq0 ?root1. Qed.

Lemma roots_above_exist : ltac:(can_be_met (@ParityInterlacing.roots_above_exist)).
Proof. by move=> absurd; apply: (absurd RR 1 0); rewrite ?oner_neq0 ?root1. Qed.

Lemma pairs_by_one_parameter : ltac:(can_be_met (@YoulaKucera.pairs_by_one_parameter)).
Proof. by move=> absurd; apply: (absurd [comRingType of rat] 1 0 0 1 0 _ 0 0); rewrite mul0r add0r mulr1. Qed.

Lemma matrix_pairs_by_one_parameter : ltac:(can_be_met (@YoulaKucera.matrix_pairs_by_one_parameter)).
Proof.
move=> absurd; apply: (absurd [comUnitRingType of rat] 1%N 1%N 1%:M 0 0 1%:M 1%:M 0 0 1%:M _ 0 0 0).
by rewrite oppr0 -scalar_mx_block mulmx1.
Qed.

Lemma all_of_a_field (F : fieldType) : YoulaKucera.subring (fun _ : F => Logic.True).
Proof. by []. Qed.

Lemma stabilising_by_one_parameter : ltac:(can_be_met (@YoulaKucera.stabilising_by_one_parameter)).
Proof.
move=> absurd; apply: (absurd [fieldType of rat] (fun=> Logic.True) 1 0 0 1 (all_of_a_field _) Logic.I Logic.I Logic.I Logic.I _ _ 0) => //.
Qed.

Lemma proper_placements : ltac:(can_be_met (@YoulaKucera.proper_placements)).
Proof.
move=> absurd; apply: (absurd [fieldType of rat] 0%N 0%N 1 0 1 1 0 _ _ _ _ 1 0); rewrite ?size_poly1 ?size_poly0 //.
  exact: coprime1p.
by rewrite /closed_loop_polynomial mulr1 mul0r addr0.
Qed.

Lemma all_polynomials (R : fieldType) :
  StableProperFunctions.stability_region (fun D : {poly R} => D != 0).
Proof. by split=> // [|D E]; [apply: oner_neq0 | apply: mulf_neq0]. Qed.

Lemma stable_proper_subring : ltac:(can_be_met (@StableProperFunctions.stable_proper_subring)).
Proof. by move=> absurd; apply: (absurd _ _ (all_polynomials [fieldType of rat])). Qed.

Lemma bezout_by_an_observer : ltac:(can_be_met (@StableProperFunctions.bezout_by_an_observer)).
Proof.
by move=> absurd; apply: (absurd _ _ (all_polynomials [fieldType of rat]) 1%N 0 0 0 0 0);
  rewrite monic_neq0 ?char_poly_monic.
Qed.

Lemma all_stabilising_compensators :
  ltac:(can_be_met (@StableProperFunctions.all_stabilising_compensators)).
Proof.
by move=> absurd; apply: (absurd _ _ (all_polynomials [fieldType of rat]) 1%N 0 0 0 0 0 _ _ 0);
  rewrite monic_neq0 ?char_poly_monic.
Qed.

Lemma routh_step : ltac:(can_be_met (@RouthHurwitz.routh_step)).
Proof. by move=> absurd; apply: (absurd RR 'X 0%N); rewrite ?size_polyX ?lead_coefX ?ltr01. Qed.

Lemma routh_hurwitz : ltac:(can_be_met (@RouthHurwitz.routh_hurwitz)).
Proof. by move=> absurd; apply: (absurd RR 0%N 1); rewrite ?size_poly1 ?lead_coef1 ?ltr01. Qed.

Lemma schur_cohn_step : ltac:(can_be_met (@SchurCohn.schur_cohn_step)).
Proof. by move=> absurd; apply: (absurd RR 'X 0%N); rewrite size_polyX. Qed.

Lemma schur_cohn : ltac:(can_be_met (@SchurCohn.schur_cohn)).
Proof. by move=> absurd; apply: (absurd RR 0%N 1); rewrite size_poly1. Qed.

Lemma constant_member (R : rcfType) e o :
  Kharitonov.kharitonov_polynomial 0 (fun=> 1 : R) (fun=> 1) e o = 1.
Proof. by apply/polyP=> -[|i]; rewrite coef_poly coef1 //= if_same. Qed.

Lemma kharitonov : ltac:(can_be_met (@Kharitonov.kharitonov)).
Proof.
move=> absurd; apply: (absurd RR 0%N (fun=> 1) (fun=> 1) 1 ltr01) => [|e o z].
  split=> [|i]; first by rewrite size_poly1.
  by rewrite leqn0 => /eqP->; rewrite coef1 !lexx.
by rewrite constant_member rmorph1 (negPf (root1 z)).
Qed.

Lemma kharitonov_3 : ltac:(can_be_met (@Kharitonov.kharitonov_3)).
Proof.
move=> absurd; apply: (absurd RR 2%:R 2%:R 1 1 1 1 ltr01 _ 2%:R 1 1); rewrite ?lexx //.
by apply/HurwitzInequalities.hurwitz_3; rewrite mulr1 ltr01 ltr0n ltr1n.
Qed.

Lemma kharitonov_4 : ltac:(can_be_met (@Kharitonov.kharitonov_4)).
Proof.
have stable : RouthHurwitz.hurwitz (HurwitzInequalities.quartic (1 : RR) 3%:R 1 1).
  apply/HurwitzInequalities.hurwitz_4; rewrite ltr01; split=> //.
  by rewrite expr1n !mul1r -[X in _ < _ - X]/(1%:R) -natrB // ltr1n.
by move=> absurd; apply: (absurd RR 1 1 3%:R 3%:R 1 1 1 1 ltr01 ltr01 ltr01 stable stable 1 3%:R 1 1);
  rewrite !lexx.
Qed.

Lemma target_has_a_value : ltac:(can_be_met (@TargetDirections.target_has_a_value)).
Proof.
move=> absurd; apply: (absurd [fieldType of rat] 1%N 1%N 1%N 0%N 1 1 0 0 0 1%:M 0 0).
- by rewrite /TargetDirections.matches_target_matrix scaler0 mul0mx.
- exact: oner_neq0.
rewrite /TargetDirections.loop_matrix mul0mx subr0 scale1r /TargetDirections.at_point map_mx1.
exact: unitmx1.
Qed.

Lemma direction_of_the_function : ltac:(can_be_met (@TargetDirections.direction_of_the_function)).
Proof.
move=> absurd; apply: (absurd [fieldType of rat] 1%N 1%N 1%N 0%N 1 1 0 0 0 1%:M 0 0 0 _ _ _ _ 0).
- by rewrite /TargetDirections.matches_target_matrix scaler0 mul0mx.
- by rewrite mul0mx.
- exact: oner_neq0.
- rewrite /TargetDirections.loop_matrix mul0mx subr0 scale1r /TargetDirections.at_point map_mx1.
  exact: unitmx1.
exists 1, 0; split; rewrite ?scaler0 ?hornerC ?oner_neq0 //.
by rewrite /TargetDirections.at_point map_mx0 scaler0.
Qed.
