(* A plant is minimal if and only if its denominator and numerator are coprime. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement ClosedLoop.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Annihilators.
Variable R : fieldType.

(* What a polynomial of A does on an invariant subspace of rows, or of columns. *)
Lemma horner_mx_rows n m (A : 'M[R]_n.+1) (X : 'M[R]_m.+1) (V : 'M[R]_(m.+1, n.+1)) p :
  V *m A = X *m V -> V *m horner_mx A p = horner_mx X p *m V.
Proof.
move=> invariant; elim/poly_ind: p => [|p c IH]; first by rewrite !rmorph0 mulmx0 mul0mx.
rewrite !rmorphD !rmorphM /= !horner_mx_X !horner_mx_C mulmxDr mulmxDl scalar_mxC.
by rewrite -!mulmxE mulmxA IH -!mulmxA invariant.
Qed.

Lemma horner_mx_columns n m (A : 'M[R]_n.+1) (X : 'M[R]_m.+1) (V : 'M[R]_(n.+1, m.+1)) p :
  A *m V = V *m X -> horner_mx A p *m V = V *m horner_mx X p.
Proof. by move=> invariant; rewrite (horner_mx_rows p (esym invariant)). Qed.

(* What two coprime polynomials of A send to 0 is 0. *)
Lemma coprime_annihilators n m (A : 'M[R]_n.+1) (V : 'M[R]_(m, n.+1)) p q :
  coprimep p q -> V *m horner_mx A p = 0 -> V *m horner_mx A q = 0 -> V = 0.
Proof.
move=> /Bezout_eq1_coprimepP[[u v] /= bezout] p0 q0.
have -> : V = V *m horner_mx A (u * p + v * q) by rewrite bezout rmorph1 mulmx1.
rewrite [u * p]mulrC [v * q]mulrC rmorphD !rmorphM /= mulmxDr -!mulmxE !mulmxA.
by rewrite p0 q0 !mul0mx addr0.
Qed.
End Annihilators.

Section Coprimeness.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

(* With coprime D and N there is no subspace of left vectors that the input does not reach:
   on it D(A) = 0, and so is (D - N)(A), as A + B C acts there as A does. *)
Theorem coprime_is_controllable A B C :
  coprimep (denominator A) (numerator A B C) -> controllable A B.
Proof.
move=> coprime_DN; rewrite /controllable -/(row_free _) -kermx_eq0; apply/eqP.
set V := kermx _; have VB k : V *m A ^+ k *m B = 0.
  have := all_powers (mulmx_ker (controllability_matrix A B)) 'X^k.
  by rewrite rmorphX /= horner_mx_X.
have [X invariant] : exists X, V *m A = X *m V.
  apply/submxP/sub_kermxP/matrixP=> i j; rewrite [in RHS]mxE.
  by rewrite times_controllability_matrix -[V *m A *m _]mulmxA mulmxE -exprS VB mxE.
have actsX p : V *m horner_mx A p = horner_mx X p *m V by apply: horner_mx_rows.
have actsXB p : V *m horner_mx (A + B *m C) p = horner_mx X p *m V.
  apply: horner_mx_rows; rewrite mulmxDr invariant mulmxA.
  by have := VB 0%N; rewrite expr0 mulmx1 => ->; rewrite mul0mx addr0.
apply: (coprime_annihilators (A := A) coprime_DN).
  by rewrite /denominator Cayley_Hamilton mulmx0.
rewrite numeratorE rmorphB /= mulmxBr Cayley_Hamilton mulmx0 sub0r actsX -actsXB.
by rewrite Cayley_Hamilton mulmx0 oppr0.
Qed.

Theorem minimal_iff_coprime A B C :
  minimal A B C <-> coprimep (denominator A) (numerator A B C).
Proof.
split=> [[c o]|coprime_DN]; last first.
  split; first exact: coprime_is_controllable coprime_DN.
  rewrite duality; apply: (@coprime_is_controllable _ _ B^T).
  by rewrite /denominator char_poly_tr numerator_tr.
(* gcd(D, N) divides every product of a regulator's and an observer's polynomial *)
have divides p : p \is monic -> degree_is p n -> gcdp (char_poly A) (numerator A B C) %| p * p.
  move=> monic_p deg_p; have [K regulator] := regulator_gain c monic_p deg_p.
  have [F observer] := observer_gain o monic_p deg_p.
  rewrite -{1}regulator -observer -separation_7_23 dvdp_addr.
    by rewrite dvdp_mulr // dvdp_gcdr.
  by rewrite dvdp_mulr // dvdp_gcdl.
have at_0 := divides _ (monicXn R n) (size_polyXn R n).
have monic_1 : (('X - 1%:P) ^+ n : {poly R}) \is monic by rewrite monic_exp // monicXsubC.
have at_1 := divides _ monic_1 (size_exp_XsubC n 1).
suff apart : coprimep ('X^n * 'X^n : {poly R}) (('X - 1%:P) ^+ n * ('X - 1%:P) ^+ n).
  by have := coprimep_dvdl at_1 (coprimep_dvdr at_0 apart); rewrite coprimepp -coprimep_def.
rewrite !(coprimepMl, coprimepMr).
suff -> : coprimep ('X^n : {poly R}) (('X - 1%:P) ^+ n) by [].
rewrite coprimep_expl // coprimep_expr // coprimep_sym coprimepX.
by rewrite rootE !hornerE oppr_eq0 oner_eq0.
Qed.
End Coprimeness.
