(* A stable compensator makes a unit of the loop, and one compensator for two plants is a stable compensator
   for an auxiliary plant (Vidyasagar and Viswanadham): over a field with any subring as the stable functions,
   then for strictly proper plants. Feedback is negative, as in (7.23). *)
From Compensators.foundations Require Import MathComp.
From Compensators.theorems Require Import YoulaKucera StableProperFunctions.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Units.
Variables (F : fieldType) (S : F -> Prop).
Hypothesis stable : subring S.

Definition unit_of u := [/\ u != 0, S u & S u^-1].
Definition coprime_in (N D X Y : F) := [/\ S N, S D, S X, S Y & X * N + Y * D = 1].

(* The compensator is U / V. *)
Lemma pair_makes_a_unit D N X Y V U a b : D != 0 -> V != 0 -> coprime_in N D X Y -> coprime_in U V a b ->
  stabilises S (N / D) (U / V) <-> unit_of (D * V + N * U).
Proof.
have [S_1 S_sub S_add S_mul] := subring_closed stable.
move=> nz_D nz_V [S_N S_D S_X S_Y bezout] [S_U S_V S_a S_b bezout'].
set loop := _ + N * U; have S_loop : S loop by rewrite /loop; auto.
have E : 1 + N / D * (U / V) = loop / (D * V) by rewrite /loop; field; rewrite ?nz_D ?nz_V.
rewrite /stabilises E invf_div.
have [->|nz] := eqVneq loop 0; first by split=> -[]; rewrite ?mul0r eqxx.
have -> : U / V * (D * V / loop) = D * U / loop by field; rewrite ?nz ?nz_D ?nz_V.
have -> : N / D * (D * V / loop) = N * V / loop by field; rewrite ?nz ?nz_D ?nz_V.
split=> [[_ S_DV S_DU S_NV]|[_ _ S_inv]]; last first.
  by split; rewrite ?mulf_neq0 ?invr_eq0 ?mulf_neq0 //; auto.
split=> //; have S_NU : S (N * U / loop).
  have -> : N * U / loop = 1 - D * V / loop by rewrite /loop; field; exact: nz.
  exact: S_sub.
have -> : loop^-1 = X * a * (N * U / loop) + X * b * (N * V / loop)
    + Y * a * (D * U / loop) + Y * b * (D * V / loop).
  transitivity ((X * N + Y * D) * (a * U + b * V) / loop); first by rewrite bezout bezout' !mul1r.
  by field; exact: nz.
by auto 8.
Qed.

Theorem stable_compensator_makes_a_unit D N X Y c : D != 0 -> coprime_in N D X Y -> S c ->
  stabilises S (N / D) c <-> unit_of (D + N * c).
Proof.
move=> nz_D coprime S_c; have [S_1 S_sub _ _] := subring_closed stable.
have S_0 : S 0 by rewrite -(subrr (1 : F)); exact: S_sub.
rewrite -{1}[c]divr1 -[D in unit_of (D + _)]mulr1.
apply: (pair_makes_a_unit (a := 0) (b := 1) _ _ coprime) => //; rewrite ?oner_neq0 //.
by split=> //; rewrite mul0r add0r mulr1.
Qed.

(* Two plants N_1 / D_1 and N_2 / D_2. *)
Section TwoPlants.
Variables (N_1 D_1 X_1 Y_1 N_2 D_2 X_2 Y_2 : F).
Hypotheses (coprime_1 : coprime_in N_1 D_1 X_1 Y_1) (coprime_2 : coprime_in N_2 D_2 X_2 Y_2).
Hypotheses (nz_1 : D_1 != 0) (nz_2 : D_2 != 0).

Definition auxiliary_numerator := N_2 * D_1 - N_1 * D_2.
Definition auxiliary_denominator := D_2 * Y_1 + N_2 * X_1.
Hypotheses (no_unit_1 : ~ unit_of N_1) (no_unit_a : ~ unit_of auxiliary_numerator).

Lemma auxiliary_coprime :
  coprime_in auxiliary_numerator auxiliary_denominator (X_2 * Y_1 - Y_2 * X_1) (X_2 * N_1 + Y_2 * D_1).
Proof.
have [S_1 S_sub S_add S_mul] := subring_closed stable.
have [S_N1 S_D1 S_X1 S_Y1 bezout_1] := coprime_1; have [S_N2 S_D2 S_X2 S_Y2 bezout_2] := coprime_2.
split; rewrite /auxiliary_numerator /auxiliary_denominator; auto.
by transitivity ((X_1 * N_1 + Y_1 * D_1) * (X_2 * N_2 + Y_2 * D_2)); [ring | rewrite bezout_1 bezout_2 mulr1].
Qed.

Lemma auxiliary_exists : auxiliary_denominator != 0.
Proof.
have [S_N S_D S_X S_Y bezout] := auxiliary_coprime.
apply/negP=> /eqP zero; apply: no_unit_a; move: bezout; rewrite zero mulr0 addr0 => inverse.
have nz : auxiliary_numerator != 0.
  by apply: contraTneq (oner_neq0 F) => N0; rewrite -inverse N0 mulr0 eqxx.
by split=> //; rewrite -[_^-1]mul1r -inverse mulfK.
Qed.

(* The compensators of the first plant are (X_1 + Q D_1) / (Y_1 - Q N_1); one of them stabilises the second
   if and only if its Q stabilises the auxiliary plant. *)
Theorem simultaneous_stabilisation :
  (exists c, stabilises S (N_1 / D_1) c /\ stabilises S (N_2 / D_2) c) <->
  exists Q, S Q /\ stabilises S (auxiliary_numerator / auxiliary_denominator) Q.
Proof.
have [S_1 S_sub S_add S_mul] := subring_closed stable.
have [S_N1 S_D1 S_X1 S_Y1 bezout_1] := coprime_1.
have pair Q : S Q -> coprime_in (X_1 + Q * D_1) (Y_1 - Q * N_1) N_1 D_1.
  by move=> S_Q; split; auto; rewrite -[RHS]bezout_1; ring.
have nz_V Q : S Q -> Y_1 - Q * N_1 != 0.
  move=> /pair[S_U _ _ _ bezout]; apply/negP=> /eqP zero; apply: no_unit_1.
  move: bezout; rewrite zero mulr0 addr0 => inverse.
  have nz : N_1 != 0 by apply: contraTneq (oner_neq0 F) => N0; rewrite -inverse N0 mul0r eqxx.
  by split=> //; rewrite -[_^-1]mul1r -inverse mulrAC divff ?mul1r.
have same Q : S Q -> stabilises S (N_2 / D_2) ((X_1 + Q * D_1) / (Y_1 - Q * N_1)) <->
    stabilises S (auxiliary_numerator / auxiliary_denominator) Q.
  move=> S_Q; rewrite (pair_makes_a_unit nz_2 (nz_V Q S_Q) coprime_2 (pair Q S_Q)).
  rewrite (stable_compensator_makes_a_unit auxiliary_exists auxiliary_coprime S_Q).
  suff -> : D_2 * (Y_1 - Q * N_1) + N_2 * (X_1 + Q * D_1) = auxiliary_denominator + auxiliary_numerator * Q by [].
  by rewrite /auxiliary_denominator /auxiliary_numerator; ring.
have every := stabilising_by_one_parameter stable S_D1 S_N1 S_X1 S_Y1 nz_1 bezout_1.
split=> [[c [/every[Q [S_Q _ ->]] /(same Q S_Q)]]|[Q [S_Q aux]]]; first by exists Q.
exists ((X_1 + Q * D_1) / (Y_1 - Q * N_1)); split; last exact/(same Q S_Q).
by apply/every; exists Q; split=> //; exact: nz_V.
Qed.
End TwoPlants.
End Units.

(* The stable functions that are strictly proper are no units, and their products with stable ones are none. *)
Section StrictlyProper.
Variables (R : fieldType) (stable : {poly R} -> Prop).
Hypothesis region : stability_region stable.
Local Notation toF := (@FracField.tofrac [idomainType of {poly R}]).

Definition strictly_stable (f : {fraction {poly R}}) := exists N D : {poly R},
  [/\ stable D, (size N < size D)%N & f = toF N / toF D].

Lemma strictly_proper_is_no_unit f : strictly_stable f -> ~ unit_of (stable_proper stable) f.
Proof.
have [_ nz _] := region => -[N [D [/nz nz_D small Ef]]] [nz_f _ [N' [D' [/nz nz_D' small' Ef']]]].
have : toF (N * N') = toF (D * D').
  have tD : toF D != 0 by rewrite tofrac_eq0.
  have tD' : toF D' != 0 by rewrite tofrac_eq0.
  have : f * f^-1 = 1 by rewrite divff.
  by rewrite Ef' {1}Ef mulf_div !tofracM => /(canRL (divfK (mulf_neq0 tD tD'))); rewrite mul1r.
move/eqP; rewrite tofrac_eq => /eqP/(congr1 (fun p : {poly R} => size p)).
rewrite (size_mul nz_D nz_D') => sizes; have := size_mul_leq N N'; rewrite sizes.
by move: small small' nz_D'; rewrite -size_poly_gt0; move: (size N) (size N') (size D) (size D'); lia.
Qed.

Lemma strictly_stable_combination f g a b : strictly_stable f -> strictly_stable g ->
  stable_proper stable a -> stable_proper stable b -> strictly_stable (f * a - g * b).
Proof.
have [_ nz mul] := region.
have sizes (p q c d : {poly R}) : c != 0 -> d != 0 -> (size p < size c)%N -> (size q <= size d)%N ->
    (size (p * q)%R < size (c * d)%R)%N.
  move=> nz_c nz_d p_c q_d; rewrite (leq_ltn_trans (size_mul_leq _ _)) // size_mul //.
  by move: p_c q_d nz_d; rewrite -size_poly_gt0; move: (size p) (size q) (size c) (size d); lia.
move=> [N [D [D_s small ->]]] [N' [D' [D'_s small' ->]]] [K [E [E_s proper ->]]] [K' [E' [E'_s proper' ->]]].
have nD := nz _ D_s; have nD' := nz _ D'_s; have nE := nz _ E_s; have nE' := nz _ E'_s.
exists (N * K * (D' * E') - N' * K' * (D * E)), (D * E * (D' * E')); split; first by auto.
  have one := sizes _ _ _ _ nD nE small proper; have two := sizes _ _ _ _ nD' nE' small' proper'.
  rewrite (leq_ltn_trans (size_add _ _)) // size_opp gtn_max sizes ?mulf_neq0 //=.
  by rewrite [D * E * _]mulrC sizes ?mulf_neq0.
by rewrite tofracB !tofracM !mulf_div -mulNr addf_div ?mulf_neq0 ?tofrac_eq0 // mulNr.
Qed.

(* For strictly proper plants nothing else is asked. *)
Theorem simultaneous_by_strong_stabilisation (N_1 D_1 X_1 Y_1 N_2 D_2 X_2 Y_2 : {fraction {poly R}}) :
  let S := stable_proper stable in
  coprime_in S N_1 D_1 X_1 Y_1 -> coprime_in S N_2 D_2 X_2 Y_2 -> strictly_stable N_1 -> strictly_stable N_2 ->
  (exists c, stabilises S (N_1 / D_1) c /\ stabilises S (N_2 / D_2) c) <->
  exists Q, S Q /\
    stabilises S (auxiliary_numerator N_1 D_1 N_2 D_2 / auxiliary_denominator X_1 Y_1 N_2 D_2) Q.
Proof.
move=> S coprime_1 coprime_2 strict_1 strict_2.
have [S_N1 S_D1 S_X1 S_Y1 bezout_1] := coprime_1; have [S_N2 S_D2 S_X2 S_Y2 bezout_2] := coprime_2.
have exists_plant (N D X Y : {fraction {poly R}}) : coprime_in S N D X Y -> strictly_stable N -> D != 0.
  move=> [S_N _ S_X _ bezout] /strictly_proper_is_no_unit no_unit; apply/negP=> /eqP D0; apply: no_unit.
  move: bezout; rewrite D0 mulr0 addr0 => inverse.
  have nz : N != 0 by apply: contraTneq (oner_neq0 [fieldType of {fraction {poly R}}]) => N0;
    rewrite -inverse N0 mulr0 eqxx.
  by split=> //; rewrite -[_^-1]mul1r -inverse mulfK.
apply: (simultaneous_stabilisation (stable_proper_subring region) coprime_1 coprime_2).
- exact: exists_plant coprime_1 strict_1.
- exact: exists_plant coprime_2 strict_2.
- exact: strictly_proper_is_no_unit.
exact/strictly_proper_is_no_unit/strictly_stable_combination.
Qed.
End StrictlyProper.
