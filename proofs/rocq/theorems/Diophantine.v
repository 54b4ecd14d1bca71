(* D D_c + N N_c = Dtilde: Lemma 1, Propositions 2 and 5, over any field and for every degree. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Diophantine.
Variable R : fieldType.
Implicit Types a b p q D N Dtilde : {poly R}.

Lemma degree_of_cofactor n d p q (s : {poly R}) : q \is monic -> s \is monic ->
  degree_is p (n + d) -> degree_is q n -> p = q * s -> degree_is s d.
Proof.
move=> monic_q monic_s deg_p deg_q Ep.
have : size p = (size q + size s).-1 by rewrite Ep size_monicM ?monic_neq0.
by rewrite deg_p deg_q; move: (size s); lia.
Qed.

(* Lemma 1. None of "p not 0", "q monic" and "p, q coprime" of the text is needed. *)
Theorem lemma_1 a b p q :
  (size a <= size b)%N -> (size p < size q)%N ->
  b * q + a * p = 0 <-> a = 0 /\ b = 0.
Proof.
move=> ab pq; split=> [sum0|[-> ->]]; last by rewrite !mul0r addr0.
have nz_q : q != 0 by rewrite -size_poly_gt0 (leq_ltn_trans _ pq).
have [b0|nz_b] := eqVneq b 0.
  by split=> //; apply/eqP; move: ab; rewrite b0 size_poly0 leqn0 size_poly_eq0.
have [a0|nz_a] := eqVneq a 0.
  by move/eqP: sum0; rewrite a0 mul0r addr0 mulf_eq0 (negPf nz_b) (negPf nz_q).
have [p0|nz_p] := eqVneq p 0.
  by move/eqP: sum0; rewrite p0 mulr0 addr0 mulf_eq0 (negPf nz_b) (negPf nz_q).
have : size (b * q) = size (a * p).
  by move/eqP: sum0; rewrite addr_eq0 => /eqP->; rewrite size_opp.
rewrite !size_mul //; move: nz_a; rewrite -size_poly_gt0.
(* bq is of higher degree than ap *)
by move: (size a) (size b) (size p) (size q) ab pq; lia.
Qed.

(* Proposition 2: D and N coprime, deg N_c < deg D. Of D_c nothing is asked. *)
Theorem proposition_2 D N D_1 N_1 D_2 N_2 :
  coprimep D N -> D != 0 -> (size N_1 < size D)%N -> (size N_2 < size D)%N ->
  closed_loop_polynomial D N D_1 N_1 = closed_loop_polynomial D N D_2 N_2 ->
  D_1 = D_2 /\ N_1 = N_2.
Proof.
rewrite /closed_loop_polynomial => coprime_DN nz_D small_1 small_2 same.
have moved : D * (D_1 - D_2) = N * (N_2 - N_1).
  by apply/eqP; rewrite !mulrBr subr_eq addrAC -subr_eq opprK same addrC.
have D_divides : D %| N_2 - N_1.
  by rewrite -(Gauss_dvdpr _ coprime_DN) -moved dvdp_mulr.
have small : (size (N_2 - N_1)%R < size D)%N.
  by rewrite (leq_ltn_trans (size_add _ _)) // gtn_max size_opp small_1 small_2.
have N0 : N_2 - N_1 = 0.
  by apply: contraTeq small => nz; rewrite -leqNgt dvdp_leq.
split; last by apply/eqP; rewrite eq_sym -subr_eq0 N0.
by move/eqP: moved; rewrite N0 mulr0 mulf_eq0 (negPf nz_D) subr_eq0 => /eqP.
Qed.

(* Every right-hand side is reached with deg N_c < deg D. *)
Theorem placement_exists D N Dtilde : coprimep D N -> D != 0 ->
  exists D_c N_c : {poly R}, (size N_c < size D)%N /\ closed_loop_polynomial D N D_c N_c = Dtilde.
Proof.
move=> /Bezout_eq1_coprimepP[[u v] /= bezout] nz_D.
pose quotient := (Dtilde * v) %/ D; pose rest := (Dtilde * v) %% D.
exists (Dtilde * u + N * quotient), rest; split; first by rewrite ltn_modp.
have division : Dtilde * v = quotient * D + rest by apply: divp_eq.
rewrite /closed_loop_polynomial.
transitivity (D * Dtilde * u + N * (quotient * D + rest)); first by ring.
by rewrite -division; transitivity (Dtilde * (u * D + v * N)); [ring | rewrite bezout mulr1].
Qed.

(* Proposition 5 for every n_c >= n - 1: a proper compensator with monic D_c of degree n_c and
   deg N_c < n exists and is unique. The text has n_c = n - 1 and n_c = n. *)
Theorem proposition_5 n n_c D N Dtilde :
  coprimep D N -> D \is monic -> degree_is D n -> degree_below N n -> (0 < n)%N ->
  Dtilde \is monic -> degree_is Dtilde (n + n_c) -> (n <= n_c.+1)%N ->
  exists D_c N_c : {poly R},
    [/\ D_c \is monic, degree_is D_c n_c, degree_below N_c n,
        closed_loop_polynomial D N D_c N_c = Dtilde &
        forall D' N', degree_below N' n ->
          closed_loop_polynomial D N D' N' = Dtilde -> D' = D_c /\ N' = N_c].
Proof.
move=> coprime_DN monic_D deg_D deg_N n_pos monic_Dt deg_Dt large.
have nz_D : D != 0 by rewrite monic_neq0.
have [D_c [N_c [deg_Nc placed]]] := placement_exists Dtilde coprime_DN nz_D.
move: deg_Nc; rewrite deg_D ltnS => deg_Nc.
have lower : (size (N * N_c)%R < size Dtilde)%N.
  rewrite (leq_ltn_trans (size_mul_leq _ _)) // deg_Dt.
  by move: (size N) (size N_c) deg_N deg_Nc; lia.
have product : D * D_c = Dtilde - N * N_c by rewrite -placed addrK.
have size_DDc : size (D * D_c) = size Dtilde by rewrite product size_addl // size_opp.
have monic_Dc : D_c \is monic.
  by rewrite -(monicMl _ monic_D) product monicE lead_coefDl ?size_opp // -monicE.
exists D_c, N_c; split=> //.
  move: size_DDc; rewrite size_monicM ?monic_neq0 // deg_D deg_Dt addSn /=.
  by rewrite -addnS => /addnI.
move=> D' N' deg_N' placed'; apply: (proposition_2 coprime_DN nz_D); rewrite ?deg_D ?ltnS //.
by rewrite placed placed'.
Qed.
End Diophantine.
