(* "In some basis" for n odd: two real closed-loop poles, and no basis makes the compensator
   observer-based, because both are modes that its output does not show. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require Import PolePlacement ClosedLoop Coprimeness Forms CanonicalForm.
From Compensators.counterexamples Require Import Realisations Theorem1 TransferFunction.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Identities.
Variable K : comRingType.
Lemma regroup (a b c d : K) : a * b * (c * d) = b * d * (a * c). Proof. by ring. Qed.
Lemma no_real_pole (x : K) :
  (x ^+ 2 + 1) * (x ^+ 2 + 2%:R * x + 2%:R) = ((x + 0) ^+ 2 + 1) * ((x + 1) ^+ 2 + 1).
Proof. by ring. Qed.
End Identities.

(* In the canonical form the common roots of D and N are unobservable modes. *)
Lemma canonical_form_hides (R : fieldType) order (D N : {poly R}) lambda :
  D \is monic -> degree_is D order.+1 -> degree_below N order.+1 ->
  root D lambda -> root N lambda ->
  exists xi : 'cV[R]_order.+1, [/\ companion order.+1 D *m xi = lambda *: xi,
    canonical_output order N *m xi = 0 & xi != 0].
Proof.
move=> monic_D deg_D deg_N /eqP D0 /eqP N0; exists (\col_i lambda ^+ i); split.
- have := congr1 (map_mx (horner_eval lambda)) (canonical_response monic_D deg_D).
  rewrite map_mxM map_mxZ /= /horner_eval D0 scale0r.
  have -> : map_mx (horner_eval lambda) (powers R order) = \col_i lambda ^+ i.
    by apply/colP=> i; rewrite !mxE /horner_eval hornerXn.
  have -> : map_mx (horner_eval lambda) (char_poly_mx (companion order.+1 D))
          = lambda%:M - companion order.+1 D.
    rewrite map_mxB map_scalar_mx /= /horner_eval hornerX; congr (_ - _).
    by apply/matrixP=> i j; rewrite !mxE /horner_eval hornerC.
  by rewrite mulmxBl mul_scalar_mx => /eqP; rewrite subr_eq0 => /eqP.
- apply/matrixP=> i j; rewrite !mxE -[RHS]N0 (horner_coef_wide _ deg_N).
  by apply: eq_bigr => k _; rewrite !mxE.
by apply/negP=> /eqP/matrixP/(_ 0 0); rewrite !mxE expr0 => /eqP; rewrite oner_eq0.
Qed.

Section Counterexample.
Variable R : rcfType.

(* Refuted: "n is odd and A~ has at least two real eigenvalues, then the compensator is, in some
   basis, observer-based". G = 1 / (s^3 + s^2 + 2s), and 2 g / ((s + 1) g) with g = (s + 3)(s + 4)
   in controllable canonical form: the real poles -3 and -4 are unobservable, so both belong to
   the observer, which needs a third real pole, and there is none. *)
Theorem real_roots_and_no_form (A : 'M[R]_3) (B : 'cV[R]_3) (C : 'rV[R]_3) :
  denominator A = @plant_D R -> numerator A B C = plant_N R ->
  let D_c := written_D_c (@real_factor R) in let N_c := written_N_c (@real_factor R) in
  let A_c := companion 3 D_c in let B_c := canonical_input R 2 in
  let C_c := canonical_output 2 (- N_c) in
  [/\ minimal A B C,
      two_roots (char_poly (closed_loop A B C A_c B_c C_c))
    & ~ realisation_is_observer_based A B C A_c B_c C_c].
Proof.
move=> Den Num D_c N_c A_c B_c C_c.
have minimal_plant : minimal A B C by apply/minimal_iff_coprime; rewrite Num coprimep1.
have linear k : ('X + k%:R : {poly R}) \is monic /\ degree_is ('X + k%:R : {poly R}) 1.
  by apply: monic_linear; apply: size_natural.
have [monic_c deg_c low_c] : full_order_strictly_proper D_c N_c.
  by apply: written_is_full_order; apply: monic_product (linear _) (linear _).
have low_minus : degree_below (- N_c) 3 by rewrite size_opp.
have [Den_c Num_c] := canonical_form monic_c deg_c low_minus.
have loop : char_poly (closed_loop A B C A_c B_c C_c)
    = ('X + 3%:R) * ('X^2 + 1) * (('X + 4%:R) * ('X^2 + 2%:R * 'X + 2%:R)).
  rewrite closed_loop_7_23 Den Num Den_c Num_c opprK.
  exact: closed_loop_factors.
have hidden k : k \in [:: 3%N; 4%N] -> root D_c (- k%:R) /\ root (- N_c) (- k%:R).
  move=> k_34; have root_g : root (@real_factor R) (- k%:R).
    by move: k_34; rewrite !inE rootM !root_of_shift => /orP[] /eqP->; rewrite eqxx ?orbT.
  rewrite /D_c /N_c /written_D_c /written_N_c rootN !rootM.
  by move: root_g; rewrite rootM => ->; rewrite !orbT.
split=> //.
  exists (- 3%:R), (- 4%:R), (('X^2 + 1) * ('X^2 + 2%:R * 'X + 2%:R)).
  by rewrite loop !polyCN !opprK !polyCMn; ring.
case=> T [K [F formed]]; pose p_O := char_poly (A - F *m C).
have root_O k : k \in [:: 3%N; 4%N] -> root p_O (- k%:R).
  move=> /hidden[root_D root_N].
  have [xi [eigen unseen nz]] := canonical_form_hides monic_c deg_c low_minus root_D root_N.
  exact: unobservable_mode_is_the_observers formed eigen unseen nz.
have divides : ('X + 3%:R) * ('X + 4%:R) %| p_O.
  rewrite Gauss_dvdp ?dvdp_shift; last first.
    by rewrite !shift_is_linear; apply: coprimep_XsubC2; rewrite subr_eq0 eqr_opp eqr_nat.
  by rewrite !shift_is_linear !dvdp_XsubCl !root_O.
have [q Eq] := dvdpP _ _ divides.
have [monic_g size_g] := monic_product (linear 3%N) (linear 4%N).
have size_q : size q = 2%N.
  have : size p_O = 4%N by rewrite size_char_poly.
  have nz_q : q != 0.
    have := monic_neq0 (char_poly_monic (A - F *m C)); rewrite -/p_O Eq.
    by apply: contraNneq => ->; rewrite mul0r.
  by rewrite Eq size_Mmonic // size_g; move: (size q); lia.
have [r root_q] := poly2_root size_q.
have rest : char_poly (A + B *m K) * q = ('X^2 + 1) * ('X^2 + 2%:R * 'X + 2%:R).
  apply: (mulIf (monic_neq0 monic_g)); rewrite -mulrA -Eq -(form_splits_spectrum formed) loop.
  exact: regroup.
have : root (('X^2 + 1) * ('X^2 + 2%:R * 'X + 2%:R) : {poly R}) r.
  by rewrite -rest rootM root_q orbT.
have shifted k : root (('X + k%:R) ^+ 2 + 1) r = ((r + k%:R) ^+ 2 + 1 == 0).
  by rewrite rootE !(hornerE, hornerMn) -expr2.
by rewrite no_real_pole rootM (shifted 0%N) (shifted 1%N) !(negPf (sum_of_squares_neq0 _)).
Qed.
End Counterexample.
