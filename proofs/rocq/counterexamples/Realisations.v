(* "In some basis" without minimality: full-order compensators of an even order that no basis makes
   observer-based. Forms.v has the true statement, for minimal compensators. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require Import ClosedLoop Coprimeness Forms.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Identities.
Variable K : comRingType.
Lemma simple_numerator : (1 * 0 + 0 * 1)%:P * 'X
  + (1 * 1 * 1 + - 2%:R * 0 * 0 - 0 * 1 * 0 - - 3%:R * 0 * 1)%:P = 1 :> {poly K}.
Proof. by rewrite !(polyCD, polyCN, polyCM); ring. Qed.
Lemma compensator_numerator : (12%:R * 1 + 0 * 0)%:P * 'X
  + (0 * 0 * 12%:R + 0 * 1 * 0 - - 6%:R * 0 * 0 - - 7%:R * 1 * 12%:R)%:P
  = 12%:R * ('X + 7%:R) :> {poly K}.
Proof. by rewrite !(polyCD, polyCN, polyCM); ring. Qed.
Lemma closed_loop_value : closed_loop_polynomial
    ('X^2 - (0 - 3%:R)%:P * 'X + (0 * - 3%:R - 1 * - 2%:R)%:P) 1
    (('X - (- 6%:R)%:P) * ('X - (- 7%:R)%:P)) (- (12%:R * ('X + 7%:R)))
  = 'X * ('X + 4%:R) * ('X + 5%:R) * ('X + 7%:R) :> {poly K}.
Proof. by rewrite /closed_loop_polynomial !(polyCD, polyCN, polyCM); ring. Qed.
End Identities.

Section HiddenModes.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).
Local Notation form := (observer_form A B C A_c B_c C_c).

(* A compensator without input and output is observer-based only if it has the plant's modes. *)
Theorem disconnected_form T K F : form T K F -> B_c = 0 -> C_c = 0 ->
  char_poly A_c = char_poly A.
Proof.
case=> unit_T outputs inputs similar B0 C0.
have K0 : K = 0 by rewrite -outputs C0 mul0mx.
have F0 : F = 0 by rewrite -(mulKmx unit_T F) inputs B0 mulmx0.
move: similar; rewrite /observer_matrix K0 F0 mulmx0 mul0mx addr0 subr0 => similar.
by rewrite -(char_poly_similar _ (esym similar)) // -unitfE -unitmxE.
Qed.

Lemma left_eigenvalue (M : 'M[R]_n) (eta : 'rV[R]_n) lambda :
  eta *m M = lambda *: eta -> eta != 0 -> root (char_poly M) lambda.
Proof. by move=> eigen nz; rewrite -eigenvalue_root_char; apply/eigenvalueP; exists eta. Qed.

Lemma right_eigenvalue (M : 'M[R]_n) (xi : 'cV[R]_n) lambda :
  M *m xi = lambda *: xi -> xi != 0 -> root (char_poly M) lambda.
Proof.
move=> eigen nz; rewrite -char_poly_tr; apply: (@left_eigenvalue _ xi^T).
  by rewrite -trmx_mul eigen linearZ.
by apply: contra nz => /eqP zero; rewrite -(trmxK xi) zero trmx0.
Qed.

(* An unobservable mode of the compensator is one of the observer. *)
Theorem unobservable_mode_is_the_observers T K F lambda (xi : 'cV[R]_n) : form T K F ->
  A_c *m xi = lambda *: xi -> C_c *m xi = 0 -> xi != 0 ->
  root (char_poly (A - F *m C)) lambda.
Proof.
case=> unit_T outputs inputs similar A_xi C_xi nz_xi.
have [z Ez] : exists z, T *m z = xi by exists (invmx T *m xi); rewrite mulKVmx.
have Kz : K *m z = 0 by rewrite -outputs -mulmxA Ez.
apply: (@right_eigenvalue _ z); last first.
  by apply: contra nz_xi => /eqP zero; rewrite -Ez zero mulmx0.
apply: (can_inj (mulKmx unit_T)); rewrite -scalemxAr Ez -A_xi -Ez [RHS]mulmxA similar -mulmxA.
congr (_ *m _); rewrite /observer_matrix addrAC [RHS]mulmxDl.
by rewrite -[B *m K *m z]mulmxA Kz mulmx0 addr0.
Qed.

(* An uncontrollable mode is one of the regulator: a mode that is both unobservable and
   uncontrollable is at least a double pole of the closed loop. *)
Theorem hidden_mode_is_double_pole T K F lambda (xi : 'cV[R]_n) (eta : 'rV[R]_n) : form T K F ->
  A_c *m xi = lambda *: xi -> C_c *m xi = 0 -> xi != 0 ->
  eta *m A_c = lambda *: eta -> eta *m B_c = 0 -> eta != 0 ->
  [/\ root (char_poly (A - F *m C)) lambda, root (char_poly (A + B *m K)) lambda
    & ('X - lambda%:P) ^+ 2 %| char_poly (closed_loop A B C A_c B_c C_c)].
Proof.
move=> formed A_xi C_xi nz_xi eta_A eta_B nz_eta.
have observer := unobservable_mode_is_the_observers formed A_xi C_xi nz_xi.
have [unit_T outputs inputs similar] := formed.
have regulator : root (char_poly (A + B *m K)) lambda.
  have etaF : eta *m T *m F = 0 by rewrite -mulmxA inputs.
  apply: (@left_eigenvalue _ (eta *m T)); last first.
    apply: contra nz_eta => /eqP zero; rewrite -(mulmxK unit_T eta) zero mul0mx //.
  have -> : A + B *m K = observer_matrix A B C K F + F *m C by rewrite /observer_matrix subrK.
  rewrite mulmxDr [X in _ + X]mulmxA etaF mul0mx addr0 -mulmxA -similar mulmxA eta_A.
  by rewrite scalemxAl.
split=> //; rewrite (form_splits_spectrum formed) expr2.
by rewrite dvdp_mul // dvdp_XsubCl.
Qed.
End HiddenModes.

Section Counterexamples.
Variable R : realFieldType.

Lemma shift_is_linear k : 'X + k%:R = 'X - (- k%:R)%:P :> {poly R}.
Proof. by rewrite polyCN opprK polyCMn. Qed.
Lemma shift_neq0 k : 'X + k%:R != 0 :> {poly R}.
Proof. by rewrite shift_is_linear polyXsubC_eq0. Qed.
Lemma root_of_shift k (x : R) : root ('X + k%:R) x = (x == - k%:R).
Proof. by rewrite shift_is_linear root_XsubC. Qed.

(* Refuted: for n even every full-order compensator is, "in some basis", observer-based. n = 2, the
   plant has the modes 3 and 4, the compensator 1 and 2, and is connected to nothing. *)
Theorem zero_compensator_is_not_observer_based :
  let A : 'M[R]_2 := matrix_2 3%:R 0 0 4%:R in let B := column_2 1 1 in let C := row_2 1 1 in
  let A_c : 'M[R]_2 := matrix_2 1 0 0 2%:R in
  minimal A B C /\ ~ realisation_is_observer_based A B C A_c 0 0.
Proof.
move=> A B C A_c; split.
  apply/minimal_iff_coprime; rewrite /denominator char_poly_diagonal numerator_diagonal.
  rewrite coprimepMl !(coprimep_sym ('X - _)) !coprimep_XsubC !rootE !hornerD !hornerN.
  by rewrite !hornerC !hornerX !subrr addr0 add0r !subr_eq0 !eqr_nat.
case=> T [K [F formed]]; have := disconnected_form formed erefl erefl.
move/(congr1 (fun p : {poly R} => root p 1%:R)); rewrite !char_poly_diagonal !rootM !root_XsubC.
by rewrite eqxx !eqr_nat.
Qed.

(* Refuted: the same with a compensator whose transfer function is not 0. n = 2; the closed-loop
   poles are 0, -4, -5, -7, so Theorem 1's condition holds twice over, and -7 is a mode of the
   compensator that its input does not reach and its output does not show. *)
Theorem hidden_mode_is_not_observer_based :
  let A : 'M[R]_2 := matrix_2 0 1 (- 2%:R) (- 3%:R) in let B := column_2 0 1 in
  let C := row_2 1 0 in
  let A_c : 'M[R]_2 := matrix_2 (- 6%:R) 0 0 (- 7%:R) in let B_c := column_2 1 0 in
  let C_c := row_2 12%:R 0 in
  [/\ minimal A B C, numerator A_c B_c C_c != 0,
      char_poly (closed_loop A B C A_c B_c C_c)
      = 'X * ('X + 4%:R) * ('X + 5%:R) * ('X + 7%:R)
    & ~ realisation_is_observer_based A B C A_c B_c C_c].
Proof.
move=> A B C A_c B_c C_c.
have Num : numerator A B C = 1 by rewrite numerator_2 simple_numerator.
have Num_c : numerator A_c B_c C_c = 12%:R * ('X + 7%:R).
  by rewrite numerator_2 compensator_numerator.
have spectrum : char_poly (closed_loop A B C A_c B_c C_c)
    = 'X * ('X + 4%:R) * ('X + 5%:R) * ('X + 7%:R).
  rewrite closed_loop_7_23 Num Num_c /denominator char_poly_diagonal char_poly_2.
  exact: closed_loop_value.
split=> //.
- by apply/minimal_iff_coprime; rewrite Num coprimep1.
- rewrite Num_c mulf_neq0 //.
    by rewrite -polyCMn polyC_eq0 pnatr_eq0.
  exact: shift_neq0.
case=> T [K [F formed]].
have [||||||_ _] := @hidden_mode_is_double_pole _ _ _ _ _ _ _ _ _ _ _ (- 7%:R)
  (column_2 0 1) (row_2 0 1) formed.
- by entry_by_entry; rewrite !(mulr0, mulr1, mul0r, addr0, add0r).
- by entry_by_entry; rewrite !(mulr0, mulr1, mul0r, addr0, add0r).
- by apply: contraNneq (oner_neq0 R) => /matrixP/(_ 1 0); rewrite !mxE => /= /eqP.
- by entry_by_entry; rewrite !(mulr0, mulr1, mul0r, mul1r, addr0, add0r).
- by entry_by_entry; rewrite !(mulr0, mulr1, mul0r, mul1r, addr0, add0r).
- by apply: contraNneq (oner_neq0 R) => /matrixP/(_ 0 1); rewrite !mxE => /= /eqP.
rewrite spectrum -shift_is_linear expr2 dvdp_mul2r ?shift_neq0 // shift_is_linear dvdp_XsubCl.
rewrite !rootM !root_of_shift -[X in root X _]addr0 (root_of_shift 0) !eqr_opp.
by rewrite !eqr_nat.
Qed.
End Counterexamples.
