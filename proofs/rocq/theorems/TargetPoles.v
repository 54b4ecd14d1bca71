(* Section 4.5.1: where a loop matches the IIR target model (4.38) or (4.39) exactly, its remaining poles
   are the minimum-phase zeros of G_zu, and 0; and the target model cannot be matched where D_p has more
   than n_c + d_zu + deg N_zu,u poles. Any field. N_zu = H N_s N_u with N_s, N_u monic of degrees k, l. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section TargetPoles.
Variables (R : fieldType) (n_c n_p d k l : nat) (H : R) (N_s N_u D_p Dtilde : {poly R}).
Hypotheses (nz_H : H != 0) (monic_s : N_s \is monic) (monic_u : N_u \is monic).
Hypotheses (deg_s : degree_is N_s k) (deg_u : degree_is N_u l).
Hypotheses (monic_p : D_p \is monic) (deg_p : degree_is D_p n_p).
Local Notation N_zu := (H *: (N_s * N_u)).

(* G_f of (4.39) equals N_zu q^n_c / D~ of (4.18), without division; N_u = 1 is (4.38). *)
Definition matches_target :=
  N_zu * 'X^n_c * D_p = H *: ('X^(n_p - d - l) * N_u) * Dtilde.

Lemma matches_without_N_u : matches_target <-> 'X^n_c * (N_s * D_p) = 'X^(n_p - d - l) * Dtilde.
Proof.
have factored (p q : {poly R}) : (H *: N_u) * p = (H *: N_u) * q <-> p = q.
  by split=> [|-> //]; apply: mulfI; rewrite scaler_eq0 negb_or nz_H monic_neq0.
rewrite -factored /matches_target -!mul_polyC.
by split=> E; [have := E | have := E]; move=> E'; [transitivity (H%:P * (N_s * N_u) * 'X^n_c * D_p);
  [ring | rewrite E'; ring] | transitivity (H%:P * N_u * ('X^n_c * (N_s * D_p)));
  [ring | rewrite E'; ring]].
Qed.

(* The poles are those of D_p, the minimum-phase zeros of G_zu, and 0, that often. *)
Theorem remaining_poles : (d + l <= n_p)%N -> (n_p <= n_c + d + l)%N ->
  matches_target <-> Dtilde = 'X^(n_c + d + l - n_p) * (N_s * D_p).
Proof.
move=> low high; rewrite matches_without_N_u.
have [e Ee] : exists e, e = (n_c + d + l - n_p)%N by exists (n_c + d + l - n_p)%N.
have split_n_c : n_c = ((n_p - d - l) + e)%N by rewrite Ee; lia.
rewrite -Ee {1}split_n_c.
rewrite exprD -mulrA; split=> [|-> //].
by move/(mulfI (monic_neq0 (monicXn _ _))).
Qed.

Theorem degree_of_matched_loop : (d + l <= n_p)%N -> (n_p <= n_c + d + l)%N -> matches_target ->
  degree_is Dtilde (d + k + l + n_c).
Proof.
move=> low high /(remaining_poles low high) ->.
rewrite size_monicM ?monicXn ?mulf_neq0 ?monic_neq0 // size_polyXn.
rewrite size_monicM ?monic_neq0 // deg_s deg_p; lia.
Qed.

(* With more poles than that only where some of them, or minimum-phase zeros, are at 0. *)
Theorem too_many_poles : (n_c + d + l < n_p)%N -> matches_target -> ~~ coprimep 'X (N_s * D_p).
Proof.
move=> many /matches_without_N_u; have -> : (n_p - d - l = n_c + (n_p - d - l - n_c).-1.+1)%N by lia.
rewrite exprD -mulrA => /(mulfI (monic_neq0 (monicXn _ _))) ->.
by rewrite exprS -mulrA coprimepMr coprimepp size_polyX.
Qed.

(* Where z = y, the loop hides these zeros: they are poles of the controller. *)
Theorem hidden_zeros (D D_c N_c : {poly R}) : (d + l <= n_p)%N -> (n_p <= n_c + d + l)%N ->
  Dtilde = D * D_c - N_zu * N_c -> coprimep N_s D -> matches_target -> N_s %| D_c.
Proof.
move=> low high loop apart /(remaining_poles low high); rewrite loop => E.
rewrite -(Gauss_dvdpr _ apart).
have : N_s %| D * D_c - N_zu * N_c by rewrite E dvdp_mull // dvdp_mulr.
by rewrite dvdp_subl // dvdp_mulr // -mul_polyC dvdp_mull // dvdp_mulr.
Qed.
End TargetPoles.

(* (2.49), (2.50), which are (4.39) for n_p = d_zu + deg N_zu,u poles at 0: all poles of a loop that matches
   them are minimum-phase zeros of G_zu, and 0. *)
Theorem fir_target_poles (R : fieldType) n_c d k l (H : R) (N_s N_u Dtilde : {poly R}) : H != 0 ->
  N_s \is monic -> N_u \is monic -> degree_is N_s k -> degree_is N_u l ->
  H *: (N_s * N_u) * 'X^n_c * 'X^(d + l) = H *: N_u * Dtilde <-> Dtilde = 'X^(n_c + d + l) * N_s.
Proof.
move=> nz_H monic_s monic_u deg_s deg_u; have deg_X : degree_is ('X^(d + l) : {poly R}) (d + l).
  by rewrite size_polyXn.
have := @remaining_poles R n_c (d + l) d k l H N_s N_u 'X^(d + l) Dtilde nz_H monic_s monic_u deg_s deg_u
  (monicXn _ _) deg_X (leqnn _).
rewrite -addnA leq_addl /matches_target => /(_ isT).
have -> : (d + l - d - l = 0)%N by lia.
have -> : (n_c + (d + l) - (d + l) = n_c)%N by lia.
by rewrite expr0 mul1r [N_s * 'X^_]mulrC mulrA -exprD.
Qed.
