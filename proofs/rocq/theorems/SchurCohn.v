(* The test of Schur, Cohn and Jury for every degree, over a real closed field: from one inequality between
   the values of a polynomial and of the reversed one outside the unit circle; no continuity of roots is
   needed. In degrees 2 and 3 it reads as Jury's inequalities. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require Import HighAuthorityPoles RouthHurwitz HurwitzInequalities.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section SchurCohn.
Variable R : rcfType.
Local Notation C := R[i].
Local Notation toC := (real_complex R).
Local Notation at_ p z := ((map_poly toC p).[z]).
Implicit Types (p q : {poly R}) (r z u : C).

Lemma modulus2_norm z : `|z| ^+ 2 = toC (modulus2 z).
Proof.
rewrite normCK; case: z => x y; apply/eqP; rewrite eq_complex /=.
by apply/andP; split; apply/eqP; ring.
Qed.

Lemma norm_below_1 z : (`|z| < 1) = (modulus2 z < 1).
Proof. by rewrite -(@ltr_pexpn2r _ 2) ?nnegrE ?normr_ge0 // expr1n modulus2_norm ltcR. Qed.

Lemma modulus2_conj z : modulus2 z^* = modulus2 z.
Proof. by case: z => x y /=; rewrite sqrrN. Qed.

Lemma modulus2_gt0 z : z != 0 -> 0 < modulus2 z.
Proof. by move=> nz; rewrite ltNge; apply: contra nz => /modulus2_0->. Qed.

Lemma modulus2_1 : modulus2 (1 : C) = 1.
Proof. by rewrite /= expr1n expr0n addr0. Qed.

Lemma at_reversed n p z : (size p <= n.+1)%N -> z != 0 -> at_ (reversed n p) z = z ^+ n * at_ p z^-1.
Proof.
move=> small nz_z; rewrite -reversed_at ?size_map_poly //; congr (_.[_]); apply/polyP=> i.
by rewrite coef_map coef_poly [RHS]coef_poly coef_map; case: ifP; rewrite ?rmorph0.
Qed.

(* Outside the circle a root inside is not nearer than its mirror image. *)
Lemma reversed_below p n z : size p = n.+1 -> inside p -> 1 <= modulus2 z ->
  modulus2 (at_ (reversed n p) z) <= modulus2 (at_ p z).
Proof.
move=> size_p in_p z_ge1; have nz_p : p != 0 by rewrite -size_poly_gt0 size_p.
have nz_z : z != 0 by apply: contraTneq z_ge1 => ->; rewrite /= expr0n addr0 ler10.
have [rs factored] := factored_over_C p; have nz_a := nz_lead nz_p.
have size_rs : size rs = n by have := number_of_roots factored nz_p; rewrite size_p => -[].
have {}in_p r : r \in rs -> modulus2 r < 1.
  move=> r_rs; rewrite -norm_below_1; apply: in_p.
  by rewrite factored rootZ // root_prod_XsubC.
rewrite at_reversed ?size_p // modulus2_mul -(modulus2_conj (at_ p _)) -at_conj -modulus2_mul.
rewrite !(at_direct factored) mulrCA [X in X <= _]modulus2_mul [X in _ <= X]modulus2_mul ler_wpmul2l ?modulus2_ge0 // -size_rs.
elim: rs {factored size_rs} in_p => [|r rs IH] in_p; first by rewrite !big_nil mul1r.
have r_lt1 := in_p r (mem_head _ _); have {}IH := IH (fun t t_s => in_p t (mem_behead (s := r :: rs) t_s)).
rewrite modulus2_mul in IH; rewrite !big_cons exprS !modulus2_mul mulrACA.
apply: ler_pmul; rewrite ?mulr_ge0 ?modulus2_ge0 //.
rewrite -[modulus2 z]modulus2_conj -modulus2_mul mulrBr -rmorphM mulfV // rmorph1.
case: z r r_lt1 z_ge1 {IH in_p nz_z} => [x y] [a b] /= r_lt1 z_ge1; simpc => /=.
rewrite -subr_ge0; set gap := _ - _; have -> : gap = (x ^+ 2 + y ^+ 2 - 1) * (1 - (a ^+ 2 + b ^+ 2)).
  by rewrite /gap; ring.
by rewrite mulr_ge0 // subr_ge0 // ltW.
Qed.

(* One row: (a_n p - a_0 p^#) / z with the reversed polynomial p^#, of degree n - 1. *)
Definition schur_step p : {poly R} := let n := (size p).-1 in
  \poly_(i < n) (lead_coef p * p`_i.+1 - p`_0 * p`_(n - i.+1)).

Section Step.
Variables (p : {poly R}) (n : nat).
Hypothesis size_p : size p = n.+2.
Let a := lead_coef p. Let b := p`_0.

Lemma lead_at_top : p`_n.+1 = a. Proof. by rewrite /a lead_coefE size_p. Qed.

Lemma schur_stepE : 'X * schur_step p = a *: p - b *: reversed n.+1 p.
Proof.
apply/polyP=> i; rewrite coefXM coefB !coefZ [(reversed _ _)`_i]coef_poly coef_poly size_p /=.
case: i => [|i] /=; first by rewrite subn0 lead_at_top mulrC subrr.
rewrite !ltnS; case: ltnP => // large; rewrite mulr0 subr0 [p`_i.+1]nth_default ?mulr0 //.
by rewrite size_p ltnS.
Qed.

(* The reversed step. *)
Lemma at_step z : z * at_ (schur_step p) z = toC a * at_ p z - toC b * at_ (reversed n.+1 p) z.
Proof.
have := congr1 (fun q => at_ q z) schur_stepE.
by rewrite rmorphM rmorphB /= map_polyX !map_polyZ hornerM hornerX hornerD hornerN !hornerZ.
Qed.

Lemma at_reversed_step z : z != 0 ->
  at_ (reversed n (schur_step p)) z = toC a * at_ (reversed n.+1 p) z - toC b * at_ p z.
Proof.
move=> nz_z; have small : (size (schur_step p) <= n.+1)%N by rewrite (leq_trans (size_poly _ _)) ?size_p.
have small_p : (size p <= n.+2)%N by rewrite size_p.
rewrite at_reversed // -[at_ _ z^-1](mulVKf nz_z) at_step mulrA -exprSr mulrBr.
rewrite !(at_reversed small_p) ?invr_eq0 // invrK mulrCA; congr (_ - _).
by rewrite mulrCA [X in _ * X]mulrA -exprMn mulfV // expr1n mul1r.
Qed.

Lemma size_schur_step : b ^+ 2 < a ^+ 2 -> size (schur_step p) = n.+1.
Proof.
move=> small; apply/eqP; rewrite eqn_leq (leq_trans (size_poly _ _)) ?size_p //= ltnNge.
apply/negP=> /leq_sizeP/(_ n (leqnn n))/eqP; rewrite coef_poly size_p ltnSn subnn lead_at_top -/b -!expr2.
by rewrite subr_eq0 gt_eqF.
Qed.

Theorem schur_cohn_step : inside p <-> b ^+ 2 < a ^+ 2 /\ inside (schur_step p).
Proof.
have nz_p : p != 0 by rewrite -size_poly_gt0 size_p.
have at_least_1 z : ~~ (`|z| < 1) -> 1 <= modulus2 z by rewrite norm_below_1 -leNgt.
have nonzero z : 1 <= modulus2 z -> z != 0.
  by move=> z_ge1; apply: contraTneq z_ge1 => ->; rewrite /= expr0n addr0 ler10.
split=> [in_p|[small in_q] z /rootP root_z].
  have small : b ^+ 2 < a ^+ 2.
    have [rs factored] := factored_over_C p; have nz_a := nz_lead nz_p.
    have size_rs : size rs = n.+1 by have := number_of_roots factored nz_p; rewrite size_p => -[].
    have {}in_p r : r \in rs -> modulus2 r < 1.
      move=> r_rs; rewrite -norm_below_1; apply: in_p.
      by rewrite factored rootZ // root_prod_XsubC.
    have := at_direct factored 0; rewrite horner_coef0 coef_map /= => /(congr1 (@modulus2 R)).
    rewrite modulus2_real /= expr0n addr0 => ->; rewrite -[X in _ < X]mulr1 ltr_pmul2l; last first.
      by rewrite exprn_even_gt0 //= lead_coef_eq0.
    case: rs {factored} size_rs in_p => [//|r rs] _ in_p; rewrite big_cons modulus2_mul sub0r.
    have -> : modulus2 (- r) = modulus2 r by case: (r) => x y /=; rewrite !sqrrN.
    apply: le_lt_trans (in_p r (mem_head _ _)); rewrite -[X in _ <= X]mulr1 ler_wpmul2l ?modulus2_ge0 //.
    have {}in_p t : t \in rs -> modulus2 t < 1 by move=> t_rs; apply: in_p; rewrite inE t_rs orbT.
    elim: rs in_p => [|t rs IH] in_p; first by rewrite big_nil modulus2_1.
    rewrite big_cons modulus2_mul sub0r.
    have -> : modulus2 (- t) = modulus2 t by case: (t) => x y /=; rewrite !sqrrN.
    apply: mulr_ile1; rewrite ?modulus2_ge0 //; first by rewrite ltW ?in_p ?mem_head.
    by apply: IH => u u_rs; apply: in_p; rewrite inE u_rs orbT.
  split=> // z /rootP root_z; apply: contraT => /at_least_1 z_ge1.
  have nz_at : at_ p z != 0 by apply: contraTneq z_ge1 => /rootP/in_p; rewrite norm_below_1 ltNge.
  have E : toC a * at_ p z = toC b * at_ (reversed n.+1 p) z.
    by apply/eqP; rewrite -subr_eq0 -at_step root_z mulr0.
  have := congr1 (@modulus2 R) E; rewrite !modulus2_real => equal.
  have := reversed_below size_p in_p z_ge1; move: small equal.
  have := modulus2_gt0 nz_at.
  move: (modulus2 (at_ p z)) (modulus2 (at_ (reversed _ _) z)) => u v u_gt0 small equal v_u.
  have : b ^+ 2 * v < a ^+ 2 * u; last by rewrite equal ltxx.
  by apply: le_lt_trans (ler_wpmul2l (sqr_ge0 _) v_u) _; rewrite ltr_pmul2r.
apply: contraT => /at_least_1 z_ge1; have nz_z := nonzero z z_ge1.
have nz_at : at_ (schur_step p) z != 0.
  by apply: contraTneq z_ge1 => /rootP/in_q; rewrite norm_below_1 ltNge.
have := at_step z; rewrite root_z mulr0 sub0r => E_1.
have := at_reversed_step nz_z; rewrite root_z mulr0 subr0 => E_2.
have E : toC a * (z * at_ (schur_step p) z) = - (toC b * at_ (reversed n (schur_step p)) z).
  by rewrite E_1 E_2 mulrN mulrCA.
have := congr1 (@modulus2 R) E; rewrite -mulN1r -[-1]expr1 modulus2_sign !modulus2_real modulus2_mul => equal.
have := reversed_below (size_schur_step small) in_q z_ge1; move: equal.
have : 0 < modulus2 (at_ (schur_step p) z).
  exact: modulus2_gt0.
move: (modulus2 (at_ (schur_step _) z)) (modulus2 (at_ (reversed _ _) z)) z_ge1 => u v z_ge1 u_gt0 equal v_u.
have : b ^+ 2 * v < a ^+ 2 * (modulus2 z * u); last by rewrite equal ltxx.
apply: le_lt_trans (ler_wpmul2l (sqr_ge0 _) v_u) _; apply: lt_le_trans (_ : a ^+ 2 * u <= _).
  by rewrite ltr_pmul2r.
by rewrite ler_wpmul2l ?sqr_ge0 // ler_pemull // ltW.
Qed.
End Step.

(* The whole table. *)
Fixpoint schur_test n p :=
  if n is m.+1 then (p`_0 ^+ 2 < p`_n ^+ 2) && schur_test m (schur_step p) else true.

Theorem schur_cohn n p : size p = n.+1 -> inside p <-> schur_test n p.
Proof.
elim: n p => [|n IH] p size_p.
  have E := size1_polyC (eq_leq size_p); split=> // _ z.
  by move: size_p; rewrite E map_polyC rootC fmorph_eq0 size_polyC; case: eqP.
rewrite (schur_cohn_step size_p) /= (lead_at_top size_p); case: ltP => [small|large]; last by split=> [[]|].
by rewrite andTb -(IH _ (size_schur_step size_p small)); split=> [[]|].
Qed.

(* Jury's inequalities. *)
Lemma squares_below (x y : R) : 0 <= y -> (x ^+ 2 < y ^+ 2) = (`|x| < y).
Proof. by move=> y_ge0; rewrite -[x ^+ 2]real_normK ?num_real // ltr_pexpn2r // nnegrE normr_ge0. Qed.

Lemma schur_test_2 q : size q = 3%N -> 0 < q`_2 ->
  schur_test 2 q <-> `|q`_0| < q`_2 /\ `|q`_1| < q`_2 + q`_0.
Proof.
move=> size_q lead; have lead_q : lead_coef q = q`_2 by rewrite lead_coefE size_q.
rewrite /= squares_below ?ltW // andbT !coef_poly size_q lead_q /=.
have -> : q`_2 * q`_1 - q`_0 * q`_1 = (q`_2 - q`_0) * q`_1 by ring.
have -> : q`_2 * q`_2 - q`_0 * q`_0 = (q`_2 - q`_0) * (q`_2 + q`_0) by ring.
have [|_] := ltP `|q`_0| q`_2; last by split=> [|[]].
rewrite ltr_norml => /andP[low high].
have gap_gt0 : 0 < q`_2 - q`_0 by rewrite subr_gt0.
have sum_gt0 : 0 < q`_2 + q`_0 by rewrite addrC -ltr_subl_addr sub0r.
by rewrite !exprMn ltr_pmul2l ?exprn_gt0 // squares_below ?ltW //; split=> [|[]].
Qed.

Theorem jury_2 (a b : R) : inside (quadratic a b) <-> b < 1 /\ `|a| < 1 + b.
Proof.
have := quadraticE a b; move: (quadratic a b) => p /(@monic_of_list R p [:: b; a])[size_p _ _ coef_p].
rewrite (schur_cohn size_p) (schur_test_2 size_p) !coef_p /= ?ltr01 // ltr_norml.
split=> [[/andP[]]//|[b_lt1 small]]; split=> //; rewrite b_lt1 andbT -subr_gt0 opprK addrC.
exact: le_lt_trans (normr_ge0 _) small.
Qed.

Theorem jury_3 (a b c : R) : inside (cubic a b c) <->
  [/\ `|c| < 1, `|b - a * c| < 1 - c ^+ 2, 0 < 1 + a + b + c & 0 < 1 - a + b - c].
Proof.
have := cubicE a b c; move: (cubic a b c) => p.
case/(@monic_of_list R p [:: c; b; a])=> size_p lead_p _ coef_p.
rewrite (schur_cohn size_p) [schur_test _ _]/(_ && schur_test 2 _) !coef_p /=.
rewrite expr1n -[X in _ < X](expr1n _ 2) squares_below ?ler01 //.
have [small|large] := ltP `|c| 1; last by split=> [|[]].
have square : c ^+ 2 < 1 by rewrite -[X in _ < X](expr1n _ 2) squares_below ?ler01.
have top : (p`_0) ^+ 2 < (lead_coef p) ^+ 2 by rewrite lead_p coef_p expr1n.
have size_q := size_schur_step size_p top.
have at_q i : (i < 3)%N -> (schur_step p)`_i = p`_i.+1 - c * p`_(3 - i.+1).
  by move=> i_3; rewrite coef_poly size_p /= i_3 lead_p mul1r [p`_0]coef_p.
have q_2 : (schur_step p)`_2 = 1 - c ^+ 2 by rewrite at_q // !coef_p.
rewrite -[[&& _, _ & _]]/(schur_test 2 (schur_step p)).
rewrite (schur_test_2 size_q); last by rewrite q_2 subr_gt0.
rewrite q_2 !at_q // !coef_p /= [c * a]mulrC.
move: small; rewrite ltr_norml => /andP[]; rewrite -subr_gt0 opprK => low high.
have first : (0 < (1 + a + b + c) * (1 - c)) = (0 < 1 + a + b + c).
  by apply: pmulr_lgt0; rewrite subr_gt0.
have second : (0 < (1 - a + b - c) * (1 + c)) = (0 < 1 - a + b - c).
  by apply: pmulr_lgt0; rewrite addrC.
rewrite -first -second [`|a - _| < _]ltr_norml -[_ < a - _]subr_gt0 -[a - _ < _]subr_gt0 opprK.
have -> : a - c * b + (1 - c ^+ 2 + (b - a * c)) = (1 + a + b + c) * (1 - c) by ring.
have -> : 1 - c ^+ 2 + (b - a * c) - (a - c * b) = (1 - a + b - c) * (1 + c) by ring.
by split=> [[? /andP[? ?]]|[_ ? ? ?]]; split=> //; apply/andP.
Qed.
End SchurCohn.
