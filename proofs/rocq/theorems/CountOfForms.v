(* How many observer-based forms a minimal compensator of full order has: one for each choice of
   exponents e_i <= m_i with sum e_i deg p_i = n, where the closed-loop polynomial is the product of
   the p_i^m_i. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary MonicDivisors.
From Compensators.theorems Require Import Forms.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section CountOfForms.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).
Hypotheses (minimal_plant : minimal A B C) (minimal_compensator : minimal A_c B_c C_c).

(* The factorisation over R, with irreducible and distinct p_i. *)
Variables (I : finType) (p : I -> {poly R}) (m : I -> nat).
Hypotheses (monic_p : forall i, p i \is monic) (distinct_p : injective p).
Hypothesis irreducible_p : forall i, irreducible_poly (p i).
Hypothesis factored : char_poly (closed_loop A B C A_c B_c C_c) = \prod_i p i ^+ m i.

Definition is_form (form : 'M[R]_n * 'rV[R]_n * 'cV[R]_n) :=
  observer_form A B C A_c B_c C_c form.1.1 form.1.2 form.2.

Definition exponents := {dffun forall i : I, 'I_(m i).+1}.
Definition shares_out_n (e : exponents) := (\sum_i e i * (size (p i)).-1)%N == n.
Definition has_exponents (form : 'M[R]_n * 'rV[R]_n * 'cV[R]_n) (e : exponents) :=
  char_poly (A + B *m form.1.2) = \prod_i p i ^+ e i.

(* Forms and such choices correspond to each other, one to one. *)
Theorem every_form_has_exponents form : is_form form ->
  exists e, shares_out_n e /\ has_exponents form e.
Proof.
move=> formed; have divides : char_poly (A + B *m form.1.2) %| product p m.
  by rewrite /product -factored (form_splits_spectrum formed) dvdp_mulr.
have [e [below Ee]] := divisors_have_exponents monic_p irreducible_p distinct_p
  (char_poly_monic _) divides.
pose e' : exponents := [ffun i => inord (e i)].
have same i : e' i = e i :> nat by rewrite ffunE inordK // ltnS.
exists e'; rewrite /has_exponents Ee; split; last by apply: eq_bigr => i _; rewrite same.
have : size (product p e) = n.+1 by rewrite -Ee size_char_poly.
rewrite degree_product // => -[size_n]; apply/eqP; rewrite -size_n.
by apply: eq_bigr => i _; rewrite same.
Qed.

Theorem exponents_of_a_form_are_unique form e e' :
  has_exponents form e -> has_exponents form e' -> e = e'.
Proof.
move=> has_e has_e'; apply/ffunP=> i; apply: val_inj => /=.
have same : product p (fun j => e j) = product p (fun j => e' j) by rewrite /product -has_e.
exact: (exponents_are_unique monic_p irreducible_p distinct_p same i).
Qed.

Theorem exponents_have_a_form e : shares_out_n e ->
  exists form, is_form form /\ has_exponents form e.
Proof.
move/eqP=> shares; pose q := product p (fun i => e i).
have monic_q : q \is monic by apply: product_monic.
have deg_q : degree_is q n by rewrite degree_product // shares.
have [exists_form _] := forms_are_divisors minimal_plant minimal_compensator monic_q deg_q.
have [|T [K [F [formed Eq]]]] := exists_form; last by exists (T, K, F).
rewrite factored /q /product; apply: (big_ind2 (fun a b : {poly R} => a %| b)) => //.
  by move=> a b c d; apply: dvdp_mul.
by move=> i _; rewrite dvdp_exp2l // -ltnS.
Qed.

Theorem exponents_determine_the_form e form form' :
  is_form form -> is_form form' -> has_exponents form e -> has_exponents form' e -> form = form'.
Proof.
case: form form' => [[T K] F] [[T' K'] F']; rewrite /is_form /has_exponents /=.
move=> formed formed' has_e has_e'.
have same : char_poly (A + B *m K) = char_poly (A + B *m K') by rewrite has_e -has_e'.
by have [-> -> ->] := form_is_unique minimal_plant minimal_compensator formed formed' same.
Qed.

(* Hence the number of forms. *)
Theorem count_of_forms : exists forms : seq ('M[R]_n * 'rV[R]_n * 'cV[R]_n),
  [/\ uniq forms, forall form, (form \in forms) <-> is_form form
    & size forms = #|[set e : exponents | shares_out_n e]|].
Proof.
have [forms [uniq_forms complete count]] : exists forms : seq ('M[R]_n * 'rV[R]_n * 'cV[R]_n),
    [/\ uniq forms, forall form, (form \in forms) <->
      (is_form form /\
       exists2 e, e \in enum [set e : exponents | shares_out_n e] & has_exponents form e)
    & size forms = size (enum [set e : exponents | shares_out_n e])].
  have all_valid : all shares_out_n (enum [set e : exponents | shares_out_n e]).
    by apply/allP=> e; rewrite mem_enum inE.
  elim: (enum _) (enum_uniq (mem [set e : exponents | shares_out_n e])) all_valid => [|e es IH].
    by exists [::]; split=> // form; split=> // -[_ []].
  rewrite /= => /andP[new uniq_es] /andP[valid all_es].
  have [forms [uniq_forms complete count]] := IH uniq_es all_es.
  have [form [formed has_e]] := exponents_have_a_form valid.
  exists (form :: forms); split=> [|form'|]; rewrite /= ?count //.
    rewrite uniq_forms andbT; apply/negP=> /complete[_ [e' e'_es has_e']].
    by move: new; rewrite (exponents_of_a_form_are_unique has_e has_e') e'_es.
  rewrite inE; split=> [/orP[/eqP->|/complete[formed' [e' e'_es has_e']]]|[formed' [e']]].
  - by split=> //; exists e; rewrite ?inE ?eqxx.
  - by split=> //; exists e'; rewrite ?inE ?e'_es ?orbT.
  rewrite inE => /orP[/eqP-> has_e'|e'_es has_e'].
    by rewrite (exponents_determine_the_form formed' formed has_e' has_e) eqxx.
  by rewrite (_ : form' \in forms) ?orbT //; apply/complete; split=> //; exists e'.
exists forms; split=> [//|form|]; last by rewrite count cardE.
split=> [/complete[]//|formed]; apply/complete; split=> //.
by have [e [valid has_e]] := every_form_has_exponents formed; exists e; rewrite ?mem_enum ?inE.
Qed.
End CountOfForms.

Section DistinctRealPoles.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).

(* 2n distinct poles in R: binomial(2n, n) forms. *)
Theorem count_for_distinct_poles (pole : 'I_(n + n) -> R) :
  minimal A B C -> minimal A_c B_c C_c -> injective pole ->
  char_poly (closed_loop A B C A_c B_c C_c) = \prod_i ('X - (pole i)%:P) ->
  exists forms : seq ('M[R]_n * 'rV[R]_n * 'cV[R]_n),
    [/\ uniq forms, forall form, (form \in forms) <-> is_form A B C A_c B_c C_c form
      & size forms = 'C(n + n, n)].
Proof.
move=> minimal_plant minimal_compensator distinct factored.
pose p i : {poly R} := 'X - (pole i)%:P; pose m (i : 'I_(n + n)) := 1%N.
have [||forms [uniq_forms complete count]] := @count_of_forms _ _ A B C A_c B_c C_c
  minimal_plant minimal_compensator _ p m (fun i => monicXsubC _) _ (fun i => irredp_XsubC _).
- by move=> i j /(congr1 (fun q : {poly R} => q.[pole i])); rewrite !hornerE subrr => /esym/eqP;
    rewrite subr_eq0 => /eqP/distinct.
- by rewrite factored; apply: eq_bigr => i _; rewrite expr1.
exists forms; split=> //; rewrite count.
have -> : 'C(n + n, n) = #|[set S : {set 'I_(n + n)} | #|S| == n]| by rewrite card_draws card_ord.
pose chosen (S : {set 'I_(n + n)}) : exponents m := [ffun i => inord (i \in S)].
have chosenE S i : chosen S i = (i \in S) :> nat by rewrite ffunE inordK // ltnS leq_b1.
have chosen_inj : injective chosen.
  move=> S S' /ffunP same; apply/setP=> i; have := congr1 (@nat_of_ord _) (same i).
  by rewrite !chosenE; case: (i \in S) (i \in S') => -[].
have sum_chosen S : (\sum_i chosen S i * (size (p i)).-1 = #|S|)%N.
  rewrite -sum1_card [RHS]big_mkcond; apply: eq_bigr => i _ /=.
  by rewrite chosenE size_XsubC muln1; case: (i \in S).
rewrite -(card_imset _ chosen_inj); congr #|pred_of_set _|; apply/setP=> e; rewrite inE.
apply/eqP/imsetP=> [shares|[S]]; last by rewrite inE => /eqP size_S ->; rewrite sum_chosen.
have Ee : e = chosen [set i | e i == 1%N :> nat].
  apply/ffunP=> i; apply: val_inj; rewrite /= chosenE inE.
  by case: (e i) => -[|[|k]].
by exists [set i | e i == 1%N :> nat] => //; rewrite inE -sum_chosen -Ee shares.
Qed.
End DistinctRealPoles.
