(* The stable proper functions are a subring of the rational functions, for every region of stability: a set
   of polynomials that are not 0 and whose products are in it, the stable denominators. An observer and a
   state feedback give a plant its Bezout identity there, so that all compensators that stabilise the plant
   are its observer-based compensator with one stable proper parameter Q. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import ClosedLoop HighAuthorityPoles RouthHurwitz YoulaKucera.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section StableProperFunctions.
Variables (R : fieldType) (stable : {poly R} -> Prop).

Definition stability_region :=
  [/\ stable 1, forall D, stable D -> D != 0 & forall D E, stable D -> stable E -> stable (D * E)].

Local Notation toF := (@FracField.tofrac [idomainType of {poly R}]).

(* N / D with a stable D and deg N <= deg D. *)
Definition stable_proper (f : {fraction {poly R}}) := exists N D : {poly R},
  [/\ stable D, (size N <= size D)%N & f = toF N / toF D].

Hypothesis region : stability_region.

Lemma stable_nonzero D : stable D -> toF D != 0 :> {fraction {poly R}}.
Proof. by have [_ nz _] := region => /nz; rewrite tofrac_eq0. Qed.

Theorem stable_proper_subring : subring stable_proper.
Proof.
have [stable_1 nz mul] := region.
have sizes (a b c d : {poly R}) : stable c -> stable d -> (size a <= size c)%N -> (size b <= size d)%N ->
    (size (a * b)%R <= size (c * d)%R)%N.
  move=> /nz nz_c /nz nz_d a_c b_d; rewrite (leq_trans (size_mul_leq _ _)) // size_mul //.
  by rewrite -!subn1 leq_sub2r // leq_add.
split; first by exists 1, 1; rewrite tofrac1 divr1.
  move=> f g [N [D [D_s small ->]]] [N' [D' [D'_s small' ->]]].
  have nz_D := stable_nonzero D_s; have nz_D' := stable_nonzero D'_s.
  exists (N * D' - N' * D), (D * D'); split; first exact: mul.
    rewrite (leq_trans (size_add _ _)) // size_opp geq_max sizes //= mulrC sizes //.
  by rewrite tofracB !tofracM -mulNr addf_div // mulNr.
move=> f g [N [D [D_s small ->]]] [N' [D' [D'_s small' ->]]].
exists (N * N'), (D * D'); split; [exact: mul | exact: sizes | ].
by rewrite !tofracM mulf_div.
Qed.

(* The plant and an observer-based compensator, A_c = A + B K - F C. *)
Section ObserverBased.
Variables (n : nat) (A : 'M[R]_n) (B F : 'cV[R]_n) (C K : 'rV[R]_n).
Let A_c := observer_matrix A B C K F.
Local Notation chi_R := (char_poly (A + B *m K)).
Local Notation chi_O := (char_poly (A - F *m C)).
Hypotheses (stable_R : stable chi_R) (stable_O : stable chi_O).

(* The plant as N / D and the compensator as X / Y, over stable denominators. *)
Let D := toF (denominator A) / toF chi_R.
Let N := toF (numerator A B C) / toF chi_R.
Let Y := toF (denominator A_c) / toF chi_O.
Let X := toF (- numerator A_c F K) / toF chi_O.

Theorem bezout_by_an_observer : [/\ stable_proper D, stable_proper N, stable_proper X, stable_proper Y
  & X * N + Y * D = 1].
Proof.
have size_chi (M : 'M[R]_n) : size (char_poly M) = n.+1 by exact: size_char_poly.
have nz_R := stable_nonzero stable_R; have nz_O := stable_nonzero stable_O.
split.
- by exists (denominator A), chi_R; rewrite /denominator !size_chi.
- exists (numerator A B C), chi_R; split=> //; rewrite size_chi.
  exact/leqW/numerator_strictly_proper.
- exists (- numerator A_c F K), chi_O; split=> //; rewrite size_chi size_opp.
  exact/leqW/numerator_strictly_proper.
- by exists (denominator A_c), chi_O; rewrite /denominator !size_chi.
have := separation_7_23 A B F C K; rewrite -/A_c /closed_loop_polynomial => /(congr1 toF).
rewrite tofracD !tofracM /X /N /Y /D !mulf_div -mulrDl => loop.
rewrite [toF chi_O * _]mulrC -loop [_ * toF (numerator A _ _)]mulrC [_ * toF (denominator A)]mulrC addrC.
by rewrite divff // loop mulf_neq0.
Qed.

Theorem all_stabilising_compensators c :
  stabilises stable_proper (toF (numerator A B C) / toF (denominator A)) c <->
  exists Q, [/\ stable_proper Q, Y - Q * N != 0 & c = (X + Q * D) / (Y - Q * N)].
Proof.
have [S_D S_N S_X S_Y bezout] := bezout_by_an_observer.
have nz_R := stable_nonzero stable_R.
have nz_A : toF (denominator A) != 0 :> {fraction {poly R}}.
  by rewrite tofrac_eq0 monic_neq0 ?char_poly_monic.
have nz_D : D != 0 by rewrite mulf_neq0 ?invr_eq0.
have -> : toF (numerator A B C) / toF (denominator A) = N / D by rewrite /N /D invf_div mulrA divfK.
exact: stabilising_by_one_parameter stable_proper_subring S_D S_N S_X S_Y nz_D bezout c.
Qed.
End ObserverBased.
End StableProperFunctions.

(* Discrete time: the roots of the denominators lie inside the unit circle. *)
Lemma inside_is_a_region (R : rcfType) : stability_region (fun D : {poly R} => D != 0 /\ inside D).
Proof.
split=> [|D []//|D E [nz_D in_D] [nz_E in_E]].
  by split=> [|z]; rewrite ?oner_neq0 // rmorph1 (negPf (root1 z)).
split=> [|z]; rewrite ?mulf_neq0 // rmorphM rootM => /orP[/in_D|/in_E] //.
Qed.

(* Continuous time: they lie in the open left half plane. *)
Lemma left_is_a_region (R : rcfType) : stability_region (@hurwitz R).
Proof.
split=> [z|D|D E left_D left_E z]; first by rewrite rmorph1 (negPf (root1 z)).
  exact: hurwitz_nonzero.
by rewrite rmorphM rootM => /orP[/left_D|/left_E].
Qed.
