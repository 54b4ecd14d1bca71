(* Appendices A and B: wordings that are false. Resultants.v and ReturnDifference.v have the true
   statements. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require Import Coprimeness Resultants.
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

(* Refuted: "the number of common roots" as the number of different ones. a = b = (s + 1)^2 have
   one, and k + l - rank is 2. *)
Theorem theorem_A1_counts_multiplicity :
  let a : {poly R} := ('X + 1) ^+ 2 in
  (2 + 2 - \rank (M_1 2 2 a a))%N = 2%N /\ (forall x, root a x <-> x = -1).
Proof.
move=> a; have deg_a : degree_is a 2.
  by rewrite /a -polyC1 -[X in 'X + X]opprK -polyCN size_exp_XsubC.
have [formula _] := theorem_A1 deg_a (eq_leq deg_a); split.
  by rewrite -formula gcdpp deg_a.
move=> x; rewrite /a expr2 rootM orbb rootE !hornerE addr_eq0.
by split=> /eqP.
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

(* z (1/z - 2) = 1 - 2z, and z^2 (1/z - 2) = -2 z (z - 1/2). *)
Lemma printed_value (z : R) : z != 0 -> z * (z^-1 - 2%:R) = 1 - 2%:R * z.
Proof. by move=> nz_z; field. Qed.
Lemma corrected_value (z : R) : z != 0 -> z ^+ 2 * (z^-1 - 2%:R) = - 2%:R * (z * (z - 2%:R^-1)).
Proof. by move=> nz_z; field; rewrite nz_z. Qed.

(* Refuted: (A.15) "mspec(A + B C_c) = mzeros(z^d_zu N_zu,s(z) N_zu,u(1/z))" where G_zu has NMP
   zeros. G_zu = (z - 2) / z^2, n = 2, d_zu = 1, N_zu,s = 1, N_zu,u = z - 2, R_2 = 0: P >= 0 solves
   (A.7), C_c = K of (A.6) gives the eigenvalues 0 and 1/2, and the printed function is 1 - 2z,
   whose only zero is 1/2. The exponent must be d_zu + deg N_zu,u, here 2. *)
Theorem A_15_exponent :
  let A : 'M[R]_2 := matrix_2 0 1 0 0 in let B := column_2 0 1 in let E_1 := row_2 (- 2%:R) 1 in
  let P : 'M[R]_2 := matrix_2 4%:R (- 2%:R) (- 2%:R) 4%:R in let K := row_2 0 2%:R^-1 in
  let R_1 := E_1^T *m E_1 in let R_2 : 'M[R]_1 := 0 in
  let N_u : {poly R} := 'X - 2%:R%:P in let printed : {poly R} := 1 - 2%:R%:P * 'X in
  let chi := char_poly (A + B *m K) in
  [/\ [/\ minimal A B E_1, numerator A B E_1 = N_u
        & forall x : 'cV[R]_2, 0 <= (x^T *m P *m x) 0 0],
      P = A^T *m P *m A - A^T *m P *m B *m invmx (R_2 + B^T *m P *m B) *m B^T *m P *m A + R_1 /\
        K = - (invmx (R_2 + B^T *m P *m B) *m B^T *m P *m A),
      chi = 'X * ('X - 2%:R^-1%:P),
      (forall z, z != 0 -> z ^+ 1 * N_u.[z^-1] = printed.[z]) /\
        (forall z, root printed z <-> z = 2%:R^-1)
    & forall z, z != 0 -> z ^+ (1 + 1) * N_u.[z^-1] = - 2%:R * chi.[z]].
Proof.
move=> A B E_1 P K R_1 R_2 N_u printed chi.
have nz_2 : 2%:R != 0 :> R by rewrite pnatr_eq0.
have nz_4 : 4%:R != 0 :> R by rewrite pnatr_eq0.
have EA_T : A^T = matrix_2 0 0 1 0 by entry_by_entry.
have weight : R_2 + B^T *m P *m B = (4%:R)%:M.
  by entry_by_entry; rewrite !(mul0r, mulr0, mulr1, mul1r, add0r, addr0).
have inverse : invmx (R_2 + B^T *m P *m B) = (4%:R^-1)%:M.
  by rewrite weight invmx_scalar.
have EBP : B^T *m P *m A = row_2 0 (- 2%:R).
  by rewrite column_2_tr !row_matrix_2; congr row_2; ring.
have gain : K = - (invmx (R_2 + B^T *m P *m B) *m B^T *m P *m A).
  rewrite inverse -!mulmxA mul_scalar_mx [B^T *m _]mulmxA EBP.
  by entry_by_entry; field.
have chi_E : chi = 'X * ('X - 2%:R^-1%:P).
  rewrite /chi column_row matrix_2_add char_poly_2 !(mul0r, mulr0, mul1r, addr0, add0r, subr0).
  by rewrite oppr0 addr0 mulrBr -expr2; congr (_ - _); apply: mulrC.
have Num : numerator A B E_1 = N_u.
  by rewrite numerator_2 !(mul0r, mulr0, mulr1, mul1r, add0r, addr0, subr0) polyCN.
have Den : denominator A = 'X^2.
  by rewrite /denominator char_poly_2 !(mul0r, mulr0, addr0, subr0).
split=> //.
- split=> // [|x].
    apply/minimal_iff_coprime; rewrite Num Den coprimep_XsubC rootE hornerXn.
    by rewrite expf_eq0.
  have [a [b ->]] := column_2_entries x.
  have -> : (column_2 a b)^T *m P *m column_2 a b
      = (2%:R * (a ^+ 2 + b ^+ 2 + (a - b) ^+ 2))%:M by entry_by_entry; ring.
  rewrite mxE eqxx mulr1n.
  by rewrite mulr_ge0 ?ler0n // !addr_ge0 ?sqr_ge0.
- split=> //; have -> : A^T *m P *m B = (B^T *m P *m A)^T.
    by rewrite !trmx_mul trmxK mulmxA [P^T]matrix_2_tr.
  rewrite inverse EBP -!mulmxA mul_scalar_mx [B^T *m _]mulmxA EBP EA_T row_2_tr -scalemxAr.
  rewrite column_row matrix_2_scale /R_1 row_2_tr column_row !matrix_2_mul matrix_2_opp !matrix_2_add.
  by congr matrix_2; field.
- split=> z.
    move=> nz_z; rewrite expr1 /N_u /printed !hornerE; exact: printed_value.
  rewrite rootE /printed !hornerE subr_eq0 eq_sym.
  split=> [/eqP double|->]; last by rewrite mulfV.
  by rewrite -[z](mulKf nz_2) double mulr1.
move=> z nz_z; rewrite chi_E !(hornerM, hornerD, hornerN, hornerX, hornerC).
exact: corrected_value.
Qed.
End Riccati.
