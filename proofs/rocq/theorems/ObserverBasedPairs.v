(* Proposition 1 and Theorem 1: which pairs (N_c, D_c) and which transfer functions of full order
   are those of an observer-based compensator. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement ClosedLoop Coprimeness Diophantine.
From Compensators.theorems Require Import MinimalRealisations RealFactors.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Pairs.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Hypothesis minimal_plant : minimal A B C.
Local Notation D := (denominator A).
Local Notation N := (numerator A B C).

Lemma pair_is_unique (D_1 N_1 D_2 N_2 : {poly R}) : degree_below N_1 n -> degree_below N_2 n ->
  closed_loop_polynomial D N D_1 N_1 = closed_loop_polynomial D N D_2 N_2 ->
  D_1 = D_2 /\ N_1 = N_2.
Proof.
have /minimal_iff_coprime coprime_DN := minimal_plant.
move=> deg_1 deg_2; apply: proposition_2 => //; rewrite ?size_char_poly ?ltnS //.
by rewrite monic_neq0 // char_poly_monic.
Qed.

Lemma closed_loop_degree (D_c N_c : {poly R}) :
  D_c \is monic -> degree_is D_c n -> degree_below N_c n ->
  closed_loop_polynomial D N D_c N_c \is monic /\
  degree_is (closed_loop_polynomial D N D_c N_c) (n + n).
Proof.
rewrite /closed_loop_polynomial => monic_Dc deg_Dc deg_Nc.
have monic_product : D * D_c \is monic by rewrite monicMl ?char_poly_monic.
have deg_product : size (D * D_c) = (n.+1 + n.+1).-1.
  by rewrite size_monicM ?monic_neq0 ?char_poly_monic // size_char_poly deg_Dc.
have lower : (size (N * N_c)%R < size (D * D_c)%R)%N.
  rewrite (leq_ltn_trans (size_mul_leq _ _)) // deg_product.
  move: (numerator_strictly_proper A B C) deg_Nc.
  by move: (size (numerator _ _ _)) (size N_c); lia.
by rewrite monicE lead_coefDl // -monicE size_addl // deg_product addnS.
Qed.

(* Proposition 1: the transfer function does not depend on how the poles are shared out. That the
   compensator exists is all it needs; "n even or two real roots" follows from it. *)
Theorem proposition_1 K F K' F' :
  char_poly (A + B *m K) * char_poly (A - F *m C)
  = char_poly (A + B *m K') * char_poly (A - F' *m C) ->
  denominator (observer_matrix A B C K F) = denominator (observer_matrix A B C K' F') /\
  numerator (observer_matrix A B C K F) F K = numerator (observer_matrix A B C K' F') F' K'.
Proof.
rewrite -!separation_7_23 => same.
by have [||-> /oppr_inj] := pair_is_unique _ _ same; rewrite ?size_opp ?numerator_strictly_proper.
Qed.

(* Over any field: a pair is observer-based if and only if its closed-loop polynomial splits into
   two monic factors of degree n. *)
Theorem pair_is_observer_based_iff (D_c N_c : {poly R}) : degree_below N_c n ->
  pair_is_observer_based A B C D_c N_c <->
  exists p_R p_O, [/\ p_R \is monic, p_O \is monic, degree_is p_R n, degree_is p_O n
    & closed_loop_polynomial D N D_c N_c = p_R * p_O].
Proof.
move=> deg_Nc; split=> [[K [F [-> ->]]]|[p_R [p_O [monic_R monic_O deg_R deg_O Dtilde]]]].
  exists (char_poly (A + B *m K)), (char_poly (A - F *m C)).
  by rewrite !char_poly_monic !size_char_poly separation_7_23.
have [c o] := minimal_plant.
have [K regulator] := regulator_gain c monic_R deg_R.
have [F observer] := observer_gain o monic_O deg_O.
exists K, F; apply: pair_is_unique; rewrite ?size_opp ?numerator_strictly_proper //.
by rewrite Dtilde -regulator -observer separation_7_23.
Qed.
End Pairs.

Section TheoremOne.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Hypothesis minimal_plant : minimal A B C.
Local Notation D := (denominator A).
Local Notation N := (numerator A B C).

(* Theorem 1 for pairs, roots counted with multiplicity. *)
Theorem theorem_1 (D_c N_c : {poly R}) :
  D_c \is monic -> degree_is D_c n -> degree_below N_c n ->
  pair_is_observer_based A B C D_c N_c <->
  (~~ odd n \/ odd n /\ two_roots (closed_loop_polynomial D N D_c N_c)).
Proof.
move=> monic_Dc deg_Dc deg_Nc.
have [monic_Dt deg_Dt] := closed_loop_degree A B C monic_Dc deg_Dc deg_Nc.
by rewrite (pair_is_observer_based_iff minimal_plant) // parity.
Qed.

(* Theorem 1 for transfer functions N_c / D_c of McMillan degree r <= n: always for r < n, the
   parity condition for r = n. *)
Theorem theorem_1_transfer_functions r (D_c N_c : {poly R}) : (r <= n)%N ->
  coprimep D_c N_c -> D_c \is monic -> degree_is D_c r -> degree_below N_c r ->
  transfer_function_is_observer_based A B C D_c N_c <->
  ((r < n)%N \/ ~~ odd n \/ odd n /\ two_roots (closed_loop_polynomial D N D_c N_c)).
Proof.
move=> r_n coprime_c monic_Dc deg_Dc deg_Nc.
(* equal fractions: the pair is (g N_c, g D_c) *)
have same_fraction D_o N_o : D_o \is monic -> N_c * D_o = N_o * D_c ->
    exists g, [/\ g \is monic, D_o = g * D_c & N_o = g * N_c].
  move=> monic_Do fraction.
  have /dvdpP[g Eg] : D_c %| D_o by rewrite -(Gauss_dvdpr _ coprime_c) fraction dvdp_mull.
  exists g; split=> //; first by rewrite -(monicMr _ monic_Dc) -Eg.
  have nz_Dc : D_c != 0 by rewrite monic_neq0.
  by apply: (mulIf nz_Dc); rewrite -fraction Eg mulrCA mulrA.
have padded g : closed_loop_polynomial D N (g * D_c) (g * N_c)
    = g * closed_loop_polynomial D N D_c N_c.
  by rewrite /closed_loop_polynomial mulrDr !(mulrCA g).
have monic_degree m (g : {poly R}) : g \is monic -> degree_is g m -> (m + r = n)%N ->
    [/\ g * D_c \is monic, degree_is (g * D_c) n & degree_below (g * N_c) n].
  move=> monic_g deg_g m_r; split; first by rewrite monicMl.
    by rewrite size_monicM ?monic_neq0 // deg_g deg_Dc addnS addSn m_r.
  rewrite (leq_trans (size_mul_leq _ _)) // deg_g -m_r.
  by move: deg_Nc; move: (size N_c); lia.
split=> [[D_o [N_o [based fraction]]]|condition].
  have [r_lt|r_ge] := ltnP r n; [by left | right].
  have {}r_n : r = n by apply/eqP; rewrite eqn_leq r_n.
  have [K [F [Do _]]] := based; have monic_Do : D_o \is monic by rewrite Do char_poly_monic.
  have [g [monic_g Eo En]] := same_fraction _ _ monic_Do fraction.
  have g1 : g = 1.
    have : size D_o = (size g + size D_c).-1 by rewrite Eo size_monicM ?monic_neq0.
    rewrite Do size_char_poly deg_Dc r_n => size_g; apply/eqP.
    have : size g = 1%N by move: size_g; move: (size g); lia.
    by case/eqP/size_poly1P=> c _ Eg; move: monic_g; rewrite Eg monicE lead_coefC => /eqP->.
  by apply/theorem_1; rewrite -?r_n //; move: based; rewrite Eo En g1 !mul1r.
have [r_lt|r_ge] := ltnP r n; last first.
  have Er : r = n by apply/eqP; rewrite eqn_leq r_n.
  exists D_c, N_c; split=> //; apply/theorem_1; rewrite -?Er //.
  by case: condition => //; rewrite Er ltnn.
(* pad with s^(n - r): one root of it and one of Dtilde, or two roots of it *)
pose g : {poly R} := 'X^(n - r); have monic_g : g \is monic by apply: monicXn.
have [monic_p deg_p low_p] : [/\ g * D_c \is monic, degree_is (g * D_c) n
    & degree_below (g * N_c) n].
  by apply: (monic_degree (n - r)%N) => //; rewrite ?size_polyXn ?subnK.
exists (g * D_c), (g * N_c); split; last by rewrite mulrCA mulrA.
apply/theorem_1 => //; have [odd_n|] := boolP (odd n); [right; split=> // | by left].
rewrite padded /g; set Dtilde := closed_loop_polynomial _ _ _ _.
have [one|many] := eqVneq (n - r)%N 1%N.
  have /odd_degree_has_root[x /factor_theorem[q Eq]] : ~~ odd (size Dtilde).
    have [_] := closed_loop_degree A B C monic_p deg_p low_p.
    rewrite padded -/Dtilde /g one expr1 => deg_Dt.
    have : Dtilde != 0 by apply: contra_eq_neq deg_Dt => ->; rewrite mulr0 size_poly0.
    move=> nz; move: deg_Dt; rewrite mulrC size_mulX // => -[->].
    by rewrite addnn odd_double.
  by exists 0, x, q; rewrite one expr1 Eq subr0 mulrCA.
exists 0, 0, ('X^(n - r - 2) * Dtilde); rewrite subr0 mulrAC; congr (_ * _).
have -> : (n - r = n - r - 2 + 2)%N by move: r_lt many; lia.
by rewrite addnK exprD expr2.
Qed.
End TheoremOne.
