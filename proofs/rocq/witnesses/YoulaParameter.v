(* Witnesses of the theorems on compensators with more states than the plant: 1 / s in a loop with
   1 / (s^2 - 3s + 3), whose poles are 1, 1, 1. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require YoulaForms.
From Compensators.theorems Require Import ClosedLoop Coprimeness CanonicalForm PolePlacement.
From Compensators.witnesses Require Import Satisfiable.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Local Notation o := (number (0 : Q)).
Local Notation e := (number (1 : Q)).
Local Notation b_c := (canonical_input Q 1).
Local Notation c_c := (canonical_output 1 (1 : {poly Q})).
Local Notation pole := ('X - 1%:P : {poly Q}).

Definition denominator_3 : {poly Q} := 'X^2 + (- 3%:R *: 'X + 3%:R%:P).
Local Notation a_c := (companion 2 denominator_3).

Lemma denominator_3_is_monic : denominator_3 \is monic /\ size denominator_3 = 3%N.
Proof.
have lower : (size (- 3%:R *: 'X + 3%:R%:P : {poly Q})%R < 3)%N.
  rewrite (leq_ltn_trans (size_add _ _)) // gtn_max.
  rewrite (leq_ltn_trans (size_scale_leq _ _)) ?size_polyX //.
  by rewrite (leq_ltn_trans (size_polyC_leq1 _)).
split; last by rewrite size_addl size_polyXn.
by rewrite monicE lead_coefDl ?size_polyXn // lead_coefXn.
Qed.

Lemma third_transfer_function : char_poly a_c = denominator_3 /\ numerator a_c b_c c_c = 1.
Proof.
have [monic size_3] := denominator_3_is_monic.
by apply: canonical_form => //; rewrite size_poly1.
Qed.

Lemma third_is_minimal : minimal a_c b_c c_c.
Proof.
apply/minimal_iff_coprime; rewrite /denominator.
by have [-> ->] := third_transfer_function; rewrite coprimep1.
Qed.

Lemma third_poles : char_poly (closed_loop o e e a_c b_c c_c) = pole * pole * pole.
Proof.
rewrite closed_loop_7_23 /denominator; have [-> ->] := third_transfer_function.
rewrite integrator_denominator /number numerator_1 mulr1 polyC1 /closed_loop_polynomial.
by rewrite /denominator_3 -mul_polyC polyCN rmorph_nat; ring.
Qed.

Lemma factorisation_gives_youla_form :
  ltac:(can_be_met (@YoulaForms.factorisation_gives_youla_form)).
Proof.
have s := size_XsubC (1 : Q); have m := monicXsubC (1 : Q).
move=> absurd; exact: (absurd Q 0%N 0%N o e e a_c b_c c_c (integrator_is_minimal Q) third_is_minimal
  pole pole pole m s m s m s third_poles).
Qed.

Lemma third_form : exists T K F A_q B_q C_q,
  @YoulaForms.youla_form Q 0 0 o e e a_c b_c c_c T K F A_q B_q C_q.
Proof.
have s := size_XsubC (1 : Q); have m := monicXsubC (1 : Q).
have [T [K [F [A_q [B_q [C_q [form _ _ _]]]]]]] := YoulaForms.factorisation_gives_youla_form
  (integrator_is_minimal Q) third_is_minimal m s m s m s third_poles.
by exists T, K, F, A_q, B_q, C_q.
Qed.

Lemma youla_form_splits_spectrum : ltac:(can_be_met (@YoulaForms.youla_form_splits_spectrum)).
Proof. by have [T [K [F [A_q [B_q [C_q form]]]]]] := third_form => absurd; apply: absurd form. Qed.

Lemma youla_form_gives_chain : ltac:(can_be_met (@YoulaForms.youla_form_gives_chain)).
Proof. by have [T [K [F [A_q [B_q [C_q form]]]]]] := third_form => absurd; apply: absurd form. Qed.

Lemma youla_form_is_unique : ltac:(can_be_met (@YoulaForms.youla_form_is_unique)).
Proof.
have [T [K [F [A_q [B_q [C_q form]]]]]] := third_form => absurd.
exact: (absurd Q 0%N 0%N o e e a_c b_c c_c (integrator_is_minimal Q) third_is_minimal _ _ _ _ _ _
  _ _ _ _ _ _ form form (erefl _) (erefl _)).
Qed.
