(* Observer-based forms of a minimal compensator are the monic divisors of degree n of the
   closed-loop polynomial: the realisation-level theorem. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement ClosedLoop Diophantine Coprimeness.
From Compensators.theorems Require Import MinimalRealisations RealFactors ObserverBasedPairs.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Forms.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).
Local Notation Atilde := (closed_loop A B C A_c B_c C_c).
Local Notation form := (observer_form A B C A_c B_c C_c).

(* A form's regulator and observer share out the closed-loop spectrum. *)
Theorem form_splits_spectrum T K F : form T K F ->
  char_poly Atilde = char_poly (A + B *m K) * char_poly (A - F *m C).
Proof.
case=> unit_T outputs inputs similar; rewrite -separation !closed_loop_7_23.
have nz_T : \det T != 0 by rewrite -unitfE -unitmxE.
rewrite /denominator -(char_poly_similar nz_T (esym similar)).
by rewrite -(numerator_similar nz_T (esym similar) inputs outputs).
Qed.

Hypotheses (minimal_plant : minimal A B C) (minimal_compensator : minimal A_c B_c C_c).

(* Every monic divisor of degree n is the regulator's polynomial in exactly one form. *)
Theorem forms_are_divisors p : p \is monic -> degree_is p n ->
  p %| char_poly Atilde <-> exists T K F, form T K F /\ char_poly (A + B *m K) = p.
Proof.
move=> monic_p deg_p; split=> [/dvdpP[q Eq]|[T [K [F [is_form <-]]]]]; last first.
  by rewrite (form_splits_spectrum is_form) dvdp_mulr.
have monic_q : q \is monic by rewrite -(monicMr _ monic_p) -Eq char_poly_monic.
have deg_q : degree_is q n.
  apply: (degree_of_cofactor (n := n) (p := char_poly Atilde) monic_p) => //.
    by rewrite size_char_poly.
  by rewrite mulrC.
have [c o] := minimal_plant.
have [K regulator] := regulator_gain c monic_p deg_p.
have [F observer] := observer_gain o monic_q deg_q.
pose A_o := observer_matrix A B C K F.
have [same_D same_N] : denominator A_c = denominator A_o /\
    numerator A_c B_c C_c = numerator A_o F K.
  have low M (b : 'cV[R]_n) h : degree_below (- numerator M b h) n.
    by rewrite size_opp numerator_strictly_proper.
  have [] := pair_is_unique minimal_plant (low A_c B_c C_c) (low A_o F K) (D_1 := denominator A_c)
    (D_2 := denominator A_o); last by move=> -> /oppr_inj.
  by rewrite -closed_loop_7_23 Eq separation_7_23 regulator observer mulrC.
have [T [unit_T similar inputs outputs]] := similar_realisations minimal_compensator same_D same_N.
by exists T, K, F.
Qed.

Theorem form_is_unique T K F T' K' F' : form T K F -> form T' K' F' ->
  char_poly (A + B *m K) = char_poly (A + B *m K') -> [/\ T = T', K = K' & F = F'].
Proof.
move=> form_1 form_2 same; have [c o] := minimal_plant; have [_ o_c] := minimal_compensator.
have EK := regulator_gain_is_unique c same; rewrite -{}EK in form_2 same *.
have EF : F = F'.
  apply: (observer_gain_is_unique o); apply: (mulfI (monic_neq0 (char_poly_monic (A + B *m K)))).
  by rewrite -(form_splits_spectrum form_1) -(form_splits_spectrum form_2).
rewrite -{}EF in form_2 *; split=> //.
have [_ outputs _ similar] := form_1; have [_ outputs' _ similar'] := form_2.
apply/eqP; rewrite -subr_eq0; apply/eqP; have /observableP only_zero := o_c.
apply: only_zero => k; rewrite -mulmxA mulmxBr.
rewrite (power_similar _ similar) (power_similar _ similar') mulmxBr !mulmxA.
by rewrite outputs outputs' subrr.
Qed.
End Forms.

Section RealForms.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).

(* No form without n even or two real roots, whatever is hidden in the plant or the compensator. *)
Theorem form_needs_real_roots : realisation_is_observer_based A B C A_c B_c C_c ->
  ~~ odd n \/ odd n /\ two_roots (char_poly (closed_loop A B C A_c B_c C_c)).
Proof.
move=> [T [K [F is_form]]]; rewrite -parity ?char_poly_monic ?size_char_poly //.
exists (char_poly (A + B *m K)), (char_poly (A - F *m C)).
by rewrite !char_poly_monic !size_char_poly (form_splits_spectrum is_form).
Qed.

(* Theorem 1 as the text means it, "in some basis": for minimal compensators it is true. *)
Theorem theorem_1_realisations : minimal A B C -> minimal A_c B_c C_c ->
  realisation_is_observer_based A B C A_c B_c C_c <->
  (~~ odd n \/ odd n /\ two_roots (char_poly (closed_loop A B C A_c B_c C_c))).
Proof.
move=> minimal_plant minimal_compensator; split=> [|]; first exact: form_needs_real_roots.
rewrite -parity ?char_poly_monic ?size_char_poly //.
case=> p [q [monic_p _ deg_p _ product]].
have [exists_form _] := forms_are_divisors minimal_plant minimal_compensator monic_p deg_p.
have [|T [K [F [is_form _]]]] := exists_form; first by rewrite product dvdp_mulr.
by exists T, K, F.
Qed.
End RealForms.
