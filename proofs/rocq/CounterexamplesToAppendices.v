(* Appendices A and B: wordings that are false. Resultants.v and ReturnDifference.v have the true
   statements. *)
From mathcomp Require Import all_ssreflect all_algebra zify ring.
From Compensators Require Import Vocabulary Matrices Resultants SmallSystems.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Resultants.
Variable R : fieldType.

(* Refuted: Theorem A1 when a_k and b_l may both be 0. a = 0 s^2 + s + 1, b = 0 s + 5: no common
   roots, while k + l - rank is 1 or more and M_1(a, b) is singular. "a_k != 0" is needed. *)
Theorem theorem_A1_needs_a_k : (5%:R != 0 :> R) ->
  let k := 2%N in let l := 1%N in let a : {poly R} := 'X + 1 in let b : {poly R} := 5%:R in
  [/\ degree_at_most a k /\ degree_at_most b l, coprimep a b, common_roots a b = 0%N,
      (1 <= k + l - \rank (M_1 k l a b))%N & M_1 k l a b \notin unitmx].
Proof.
move=> nz_5 k l a b.
have Eb : b = 5%:R%:P by rewrite polyCMn.
have size_b : size b = 1%N by rewrite Eb size_polyC nz_5.
have coprime_ab : coprimep a b by rewrite Eb -alg_polyC coprimepZr ?coprimep1.
have [a2 b1] : a`_2 = 0 /\ b`_1 = 0.
  by rewrite /a Eb coefD coefX coefC coef1 addr0.
have singular : M_1 k l a b \notin unitmx.
  have first_row j : M_1 k l a b 0 j = 0.
    by rewrite mxE; case: (split j) => i; case: ifP => // _; rewrite sub0n subn0.
  by rewrite unitmxE unitfE negbK (expand_det_row _ 0) big1 // => j _; rewrite first_row mul0r.
split=> //.
- by rewrite size_b; split=> //; rewrite /a -polyC1 size_XaddC.
- by move: coprime_ab; rewrite coprimep_def => /eqP->.
rewrite subn_gt0 ltn_neqAle rank_leq_row andbT.
by move: singular; rewrite -row_free_unit.
Qed.

(* Not needed: "l <= k" of Theorem A1, which Example B.2 violates: k = 1, l = 2. *)
Theorem theorem_A1_without_l_at_most_k :
  let a : {poly R} := 'X + 1 in let b := ('X + 1) * ('X + 2%:R) in
  (common_roots a b = 1 + 2 - \rank (M_1 1 2 a b))%N /\ \rank (M_1 1 2 a b) = 2%N.
Proof.
move=> a b.
have deg_a : degree_is a 1 by rewrite /a -polyC1 size_XaddC.
have deg_b : degree_at_most b 2.
  by rewrite (leq_trans (size_mul_leq _ _)) // deg_a -polyC1 -polyCMn size_XaddC.
have [formula _] := theorem_A1 deg_a deg_b; split=> //.
have one_common_root : common_roots a b = 1%N.
  by rewrite (eqp_size (_ : gcdp a b %= a)) ?deg_a // /eqp dvdp_gcdl dvdp_gcd dvdpp dvdp_mulr.
by move: formula; rewrite one_common_root; have := rank_leq_row (M_1 1 2 a b); lia.
Qed.
End Resultants.

Section Riccati.
Variable R : realFieldType.

(* Refuted: under i)-iv) of appendix A "(A.7) has a unique positive-semidefinite solution", and its
   closed loop is stable. A = 2, B = 1, R_1 = 0, R_2 = 1: (A, B) is controllable, the mode 2 of
   (A, R_1) is not on the unit circle, and P = 0 and P = 3 both solve (A.7). P = 3 gives the stable
   A + BK = 1/2, P = 0 leaves the unstable A. True is: a unique stabilising solution. *)
Theorem riccati_solution_is_not_unique :
  let A : R := 2%:R in let B : R := 1 in let R_1 : R := 0 in let R_2 : R := 1 in
  let solves P := P = A * P * A - A * P * B * (R_2 + B * P * B)^-1 * (B * P * A) + R_1 in
  let closed P := A - B * ((R_2 + B * P * B)^-1 * (B * P * A)) in
  [/\ B != 0 /\ `|A| != 1, solves 0 /\ 0 <= 0 :> R, solves 3%:R /\ 0 <= 3%:R :> R,
      1 < `|closed 0| & `|closed 3%:R| < 1].
Proof.
move=> A B R_1 R_2 solves closed.
have four : R_2 + B * 3%:R * B = 4%:R by rewrite /R_2 /B; ring.
have nz_4 : 4%:R != 0 :> R by rewrite pnatr_eq0.
have closed_3 : closed 3%:R = 2%:R^-1.
  by rewrite /closed four /A /B; field.
split.
- by rewrite oner_neq0 /A ger0_norm ?ler0n // (eqr_nat _ 2 1).
- by rewrite /solves !(mulr0, mul0r) subr0 addr0.
- by split; rewrite ?ler0n // /solves four /A /B /R_1; field.
- by rewrite /closed !(mulr0, mul0r) subr0 ger0_norm ?ler0n // (ltr_nat _ 1 2).
by rewrite closed_3 ger0_norm ?invr_ge0 ?ler0n // invf_lt1 ?ltr0n // (ltr_nat _ 1 2).
Qed.
End Riccati.
