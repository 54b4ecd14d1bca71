(* Every strictly proper transfer function has a realisation: controllable canonical form. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import finalg.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import PolePlacement Coprimeness.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section CanonicalForm.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (D N : {poly R}).

(* The last unit vector, and the coefficients of N in ascending order. *)
Definition canonical_input : 'cV[R]_n := delta_mx ord_max 0.
Definition canonical_output N : 'rV[R]_n := \row_j N`_j.

(* [1 s ... s^(n-1)]'. *)
Definition powers : 'cV[{poly R}]_n := \col_i 'X^i.

(* (sI - A) [1 s ... s^(n-1)]' = D [0 ... 0 1]'. *)
Lemma canonical_response D : D \is monic -> degree_is D n ->
  char_poly_mx (companion n D) *m powers = D *: map_mx polyC canonical_input.
Proof.
move=> monic_D deg_D; apply/colP=> i.
rewrite /char_poly_mx mulmxBl mul_scalar_mx [LHS]mxE [X in X + _]mxE [X in _ + X]mxE.
rewrite [in X in _ * X]mxE [in X in _ - X]mxE [RHS]mxE !mxE /= eqxx andbT -exprS.
have [last|not_last] := eqVneq i ord_max.
  rewrite mulr1 last /=.
  have -> : \sum_j map_mx polyC (companion n D) ord_max j * powers j 0 = 'X^n - D.
    have Dn : D`_n = 1 by move: monic_D; rewrite monicE lead_coefE deg_D => /eqP.
    have ED : D = \sum_(j < n) D`_j *: 'X^j + 'X^n.
      by rewrite -[LHS]coefK deg_D poly_def big_ord_recr /= Dn scale1r.
    rewrite [in RHS]ED opprD addrCA subrr addr0 -sumrN; apply: eq_bigr => j _.
    by rewrite !mxE eqxx polyCN mulNr mul_polyC.
  by rewrite subKr.
rewrite mulr0; have next : (i.+1 < n)%N by rewrite ltnS ltn_neqAle -ltnS ltn_ord andbT.
have below : (i == order :> nat) = false by apply/negbTE.
rewrite (bigD1 (Ordinal next)) //= big1 ?addr0 => [|j ne]; rewrite !mxE below.
  by rewrite eqxx mul1r subrr.
by rewrite eq_sym -[i.+1]/(val (Ordinal next)) (inj_eq val_inj) (negPf ne) mul0r.
Qed.

(* A polynomial of degree below n as a sum of n terms. *)
Lemma poly_widen N : degree_below N n -> \poly_(j < n) N`_j = N.
Proof.
move=> deg_N; apply/polyP=> j; rewrite coef_poly; case: ltnP => // above.
by rewrite nth_default // (leq_trans deg_N).
Qed.

(* The plant with these three matrices has the transfer function N / D, written as N and D are. *)
Theorem canonical_form D N : D \is monic -> degree_is D n -> degree_below N n ->
  denominator (companion n D) = D /\
  numerator (companion n D) canonical_input (canonical_output N) = N.
Proof.
move=> monic_D deg_D deg_N.
have char_D : char_poly (companion n D) = D by apply: char_poly_companion; rewrite // deg_D.
split=> //; have adjoint : \adj (char_poly_mx (companion n D)) *m map_mx polyC canonical_input
    = powers.
  have nz_D : D != 0 by rewrite monic_neq0.
  have : D *: (\adj (char_poly_mx (companion n D)) *m map_mx polyC canonical_input)
       = D *: powers.
    rewrite scalemxAr -canonical_response // mulmxA mul_adj_mx mul_scalar_mx.
    by rewrite -/(char_poly _) char_D.
  move/matrixP=> same; apply/matrixP=> i j; apply: (mulfI nz_D).
  by have := same i j; rewrite [LHS]mxE [RHS]mxE.
rewrite /numerator -mulmxA adjoint mxE -[RHS](poly_widen deg_N) poly_def.
by apply: eq_bigr => j _; rewrite !mxE mul_polyC.
Qed.

(* It is minimal if and only if D and N are coprime: every strictly proper G has a minimal plant. *)
Corollary canonical_form_is_minimal D N : D \is monic -> degree_is D n -> degree_below N n ->
  minimal (companion n D) canonical_input (canonical_output N) <-> coprimep D N.
Proof.
move=> monic_D deg_D deg_N; have [Den Num] := canonical_form monic_D deg_D deg_N.
by rewrite minimal_iff_coprime Den Num.
Qed.

Corollary realisation_exists D N : D \is monic -> degree_is D n -> degree_below N n ->
  exists (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n), denominator A = D /\ numerator A B C = N.
Proof.
move=> monic_D deg_D deg_N; exists (companion n D), canonical_input, (canonical_output N).
exact: canonical_form.
Qed.
End CanonicalForm.
