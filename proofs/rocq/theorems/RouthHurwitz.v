(* Routh's test for every degree, over a real closed field, from one inequality between the values of a
   polynomial and of its mirror image p(-s), an induction over the roots; no continuity of roots is needed. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section RouthHurwitz.
Variable R : rcfType.
Local Notation C := R[i].
Local Notation toC := (real_complex R).
Local Notation Re := (@complex.Re R).
Local Notation at_ p z := ((map_poly toC p).[z]).
Implicit Types (p q g h : {poly R}) (r s z u v : C).

(* All roots in the open left half plane. *)
Definition hurwitz p := forall z : C, root (map_poly toC p) z -> Re z < 0.

(* The square of the modulus, and the inner product in the plane. *)
Definition modulus2 z : R := let: (x +i* y)%C := z in x ^+ 2 + y ^+ 2.
Definition inner u v : R := let: (a +i* b)%C := u in let: (c +i* d)%C := v in a * c + b * d.

Lemma modulus2_ge0 z : 0 <= modulus2 z.
Proof. by case: z => x y; rewrite addr_ge0 ?sqr_ge0. Qed.

Lemma modulus2_mul u v : modulus2 (u * v) = modulus2 u * modulus2 v.
Proof. by case: u v => [a b] [c d]; simpc => /=; ring. Qed.

Lemma modulus2_0 z : modulus2 z <= 0 -> z = 0.
Proof.
case: z => x y /= small; have : x ^+ 2 + y ^+ 2 = 0.
  by apply/le_anti; rewrite small addr_ge0 ?sqr_ge0.
by move/eqP; rewrite paddr_eq0 ?sqr_ge0 // !sqrf_eq0 => /andP[/eqP-> /eqP->].
Qed.

(* One more root: sigma = Re s, alpha = -Re r, A the sum of the others. *)
Lemma one_more_root (sigma tau alpha A g1 g2 h1 h2 G1 G2 H1 H2 : R) : 0 <= sigma -> 0 < alpha -> 0 < A ->
  sigma * (h1 ^+ 2 + h2 ^+ 2) <= A * (g1 * h1 + g2 * h2) ->
  G1 = sigma * g1 - tau * g2 + alpha * h1 -> G2 = sigma * g2 + tau * g1 + alpha * h2 ->
  H1 = sigma * h1 - tau * h2 + alpha * g1 -> H2 = sigma * h2 + tau * h1 + alpha * g2 ->
  sigma * (H1 ^+ 2 + H2 ^+ 2) <= (A + alpha) * (G1 * H1 + G2 * H2).
Proof.
move=> sigma_ge0 alpha_gt0 A_gt0; rewrite -subr_ge0 => gap_ge0 E_1 E_2 E_3 E_4.
rewrite -subr_ge0 -(pmulr_rge0 _ A_gt0).
have -> : A * ((A + alpha) * (G1 * H1 + G2 * H2) - sigma * (H1 ^+ 2 + H2 ^+ 2))
    = (A + alpha) * (sigma ^+ 2 + tau ^+ 2 + alpha ^+ 2)
        * (A * (g1 * h1 + g2 * h2) - sigma * (h1 ^+ 2 + h2 ^+ 2))
      + (2%:R * A * alpha ^+ 2 + A ^+ 2 * alpha + alpha ^+ 3) * sigma * (h1 ^+ 2 + h2 ^+ 2)
      + alpha * sigma * ((sigma * h1 - tau * h2 - A * g1) ^+ 2 + (sigma * h2 + tau * h1 - A * g2) ^+ 2).
  by rewrite E_1 E_2 E_3 E_4; ring.
have [alpha_ge0 A_ge0] := (ltW alpha_gt0, ltW A_gt0).
have sum_ge0 (a b : R) : 0 <= a ^+ 2 + b ^+ 2 by rewrite addr_ge0 ?sqr_ge0.
apply: addr_ge0; [apply: addr_ge0; apply: mulr_ge0 => // | by rewrite !mulr_ge0].
  by rewrite mulr_ge0 ?addr_ge0 ?sqr_ge0.
by rewrite mulr_ge0 // !addr_ge0 ?mulr_ge0 ?exprn_ge0 ?ler0n.
Qed.

(* p with the roots rs and its mirror image with the roots -conj r. *)
Local Notation direct rs s := (\prod_(r <- rs) (s - r)).
Local Notation mirror rs s := (\prod_(r <- rs) (s + r^*)).

Lemma root_inequality (rs : seq C) s : (forall r, r \in rs -> Re r < 0) -> 0 <= Re s ->
  Re s * modulus2 (direct rs s - mirror rs s)
    <= - (\sum_(r <- rs) Re r) * inner (direct rs s + mirror rs s) (direct rs s - mirror rs s).
Proof.
case: s => sigma y /= left sigma_ge0.
elim: rs left => [|[rx ry] rs IH] left; first by rewrite !big_nil subrr /= expr0n addr0 mulr0 oppr0 mul0r.
have alpha_gt0 : 0 < - rx by rewrite oppr_gt0; apply: (left (rx +i* ry)%C); rewrite mem_head.
have {}left r : r \in rs -> Re r < 0 by move=> r_rs; apply: left; rewrite inE r_rs orbT.
have {}IH := IH left; rewrite !big_cons.
case: rs IH left => [|r rs] IH left.
  rewrite !big_nil !mulr1 addr0; simpc; rewrite /=.
  by rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
have A_gt0 : 0 < - \sum_(t <- r :: rs) Re t.
  rewrite big_cons opprD ltr_paddr ?oppr_gt0 ?left ?mem_head // -sumrN big_seq.
  by apply: sumr_ge0 => t t_rs; rewrite oppr_ge0 ltW // left // inE t_rs orbT.
set B := \sum_(t <- r :: rs) Re t in A_gt0 IH *; clearbody B.
set p := \prod_(t <- r :: rs) (_ - t) in IH *; set m := \prod_(t <- r :: rs) (_ + _) in IH *.
clearbody p m; case: p m IH => [p1 p2] [m1 m2] /= IH.
simpc => /=.
have := one_more_root (tau := y - ry) sigma_ge0 alpha_gt0 A_gt0 IH.
by rewrite [- B - rx]addrC; apply; ring.
Qed.

(* For a root in the left half plane no point of the right one is nearer than the root's mirror image. *)
Lemma mirror_below (rs : seq C) s : (forall r, r \in rs -> Re r < 0) -> 0 <= Re s ->
  modulus2 (mirror rs s) <= modulus2 (direct rs s).
Proof.
move=> left s_ge0; elim: rs left => [|r rs IH] left; first by rewrite !big_nil.
have r_lt0 := left r (mem_head _ _); have {}IH := IH (fun t t_s => left t (mem_behead (s := r :: rs) t_s)).
rewrite !big_cons !modulus2_mul ler_pmul ?modulus2_ge0 //.
case: s r s_ge0 {IH left} r_lt0 => [sigma y] [rx ry] /= s_ge0 r_lt0; simpc => /=.
rewrite -subr_ge0; have -> : (sigma - rx) ^+ 2 + (y - ry) ^+ 2 - ((sigma + rx) ^+ 2 + (y - ry) ^+ 2)
    = 4%:R * sigma * - rx by ring.
by rewrite !mulr_ge0 ?ler0n // oppr_ge0 ltW.
Qed.

(* A real polynomial and its roots. *)
Lemma conj_real (x : R) : (toC x)^* = toC x.
Proof. by apply/CrealP/complex_realP; exists x. Qed.

Lemma at_conj p z : at_ p z^* = (at_ p z)^*.
Proof.
by rewrite -horner_map -map_poly_comp; congr (_.[_]); apply: eq_map_poly => x; exact/esym/conj_real.
Qed.

Section Roots.
Variables (p : {poly R}) (rs : seq C).
Hypothesis factored : map_poly toC p = toC (lead_coef p) *: \prod_(r <- rs) ('X - r%:P).
Hypothesis nz_p : p != 0.

Lemma nz_lead : toC (lead_coef p) != 0. Proof. by rewrite fmorph_eq0 lead_coef_eq0. Qed.

Lemma hurwitzP : hurwitz p <-> forall r, r \in rs -> Re r < 0.
Proof. by split=> left r r_root; apply: left; move: r_root; rewrite factored rootZ ?nz_lead // root_prod_XsubC. Qed.

Lemma number_of_roots : size p = (size rs).+1.
Proof. by rewrite -(size_map_poly [rmorphism of toC]) factored size_scale ?nz_lead // size_prod_XsubC. Qed.

Lemma at_direct s : at_ p s = toC (lead_coef p) * direct rs s.
Proof.
by rewrite factored hornerZ horner_prod; congr (_ * _); apply: eq_bigr => r _; rewrite hornerXsubC.
Qed.

Lemma at_mirror s : at_ p (- s) = toC (lead_coef p) * ((-1) ^+ size rs * mirror rs s).
Proof.
rewrite -[- s]conjCK at_conj at_direct rmorphM rmorph_prod; congr (_ * _); first exact: conj_real.
elim: rs => [|r rs' IH]; first by rewrite !big_nil mul1r.
have factor : ((- s)^* - r)^* = - (s + r^*).
  by rewrite rmorphB rmorphN opprD rmorphN; congr (- _ - _); exact: conjCK.
rewrite !big_cons IH exprS factor; move: (s + r^*) (\prod_(t <- rs') (_ + _)) => a m.
by rewrite mulN1r !mulNr mulrCA.
Qed.

Lemma second_coefficient : toC (p`_(size p).-2) = toC (lead_coef p) * - (\sum_(r <- rs) r) \/ rs = [::].
Proof.
case E: rs => [|r rs']; [by right | left].
rewrite -coef_map factored coefZ number_of_roots E /=; congr (_ * _).
elim: rs' r {E} => [|r' rs' IH] r.
  by rewrite big_cons big_nil mulr1 !big_cons big_nil addr0 coefB coefX coefC /= sub0r.
rewrite big_cons mulrBl coefB coefXM coefCM /= IH.
have := monicP (monic_prod_XsubC (r' :: rs') xpredT id).
by rewrite lead_coefE size_prod_XsubC /= => ->; rewrite [in RHS]big_cons; ring.
Qed.
End Roots.

Lemma factored_over_C p : exists rs, map_poly toC p = toC (lead_coef p) *: \prod_(r <- rs) ('X - r%:P).
Proof.
have [rs] := closed_field_poly_normal (map_poly toC p).
by rewrite (lead_coef_map [rmorphism of toC]) => E; exists rs.
Qed.

Lemma modulus2_parallelogram u v : modulus2 (u + v) - modulus2 (u - v) = 4%:R * inner u v.
Proof. by case: u v => [a b] [c d] /=; ring. Qed.

Lemma modulus2_sign k u : modulus2 ((-1) ^+ k * u) = modulus2 u.
Proof.
by elim: k u => [|k IH] u; rewrite ?mul1r // exprS -mulrA mulN1r -[RHS]IH; case: (_ * u) => a b /=; ring.
Qed.

Lemma modulus2_real (x : R) u : modulus2 (toC x * u) = x ^+ 2 * modulus2 u.
Proof. by case: u => a b; simpc => /=; ring. Qed.

Lemma inner_real (x : R) u v : inner (toC x * u) (toC x * v) = x ^+ 2 * inner u v.
Proof. by case: u v => [a b] [c d]; simpc => /=; ring. Qed.

Lemma hurwitz_nonzero p : hurwitz p -> p != 0.
Proof.
move=> left; apply: contraTneq isT => p0.
by have := left 0; rewrite p0 rmorph0 root0 ltxx => /(_ isT).
Qed.

(* A Hurwitz polynomial is not smaller than its mirror image in the right half plane. *)
Lemma hurwitz_mirror p s : hurwitz p -> 0 <= Re s -> modulus2 (at_ p (- s)) <= modulus2 (at_ p s).
Proof.
move=> stable s_ge0; have nz := hurwitz_nonzero stable; have [rs factored] := factored_over_C p.
have /(hurwitzP factored nz) left := stable.
rewrite (at_mirror factored) (at_direct factored) !modulus2_real modulus2_sign.
by rewrite ler_wpmul2l ?sqr_ge0 ?mirror_below.
Qed.

(* The coefficients of even or of odd powers. *)
Definition part (e : bool) p : {poly R} := \poly_(i < size p) (if odd i == e then p`_i else 0).

Lemma coef_part e p i : (part e p)`_i = if odd i == e then p`_i else 0.
Proof. by rewrite coef_poly; case: ltnP => // large; rewrite nth_default // if_same. Qed.

Lemma sum_of_parts e p : p = part (~~ e) p + part e p.
Proof. by apply/polyP=> i; rewrite coefD !coef_part; case: (odd i) e => [] []; rewrite /= ?addr0 ?add0r. Qed.

Lemma part_mirror e p s : at_ (part e p) (- s) = (-1) ^+ e * at_ (part e p) s.
Proof.
rewrite !horner_coef size_map_poly mulr_sumr; apply: eq_bigr => i _.
rewrite coef_map coef_part /= (exprNn s) -(signr_odd _ i).
by case: eqP => [->|_]; rewrite ?rmorph0 ?mul0r ?mulr0 // mulrCA.
Qed.

(* One row of Routh's array: from p = a_n+1 s^(n+1) + a_n s^n + ... to
   a_n s^n + (a_n-1 - a_n+1/a_n a_n-2) s^(n-1) + a_n-2 s^(n-2) + ... *)
Definition routh p : {poly R} := let n := (size p).-2 in
  p - (lead_coef p / p`_n) *: ('X * part (odd n) p).

Section Step.
Variables (p : {poly R}) (n : nat).
Hypotheses (size_p : size p = n.+2) (lead_p : 0 < lead_coef p).
Let a := lead_coef p. Let b := p`_n.
Let H s := at_ (part (odd n) p) s.
Let G s := at_ (part (~~ odd n) p) s.

Lemma coef_routh i : (routh p)`_i
  = p`_i - a / b * (if (i == 0%N) || (odd i == odd n) then 0 else p`_i.-1).
Proof.
rewrite /routh size_p /= coefB coefZ coefXM coef_part -/a -/b.
by case: i => [|i] //=; case: (odd i) (odd n) => [] [].
Qed.

Lemma size_routh : b != 0 -> size (routh p) = n.+1.
Proof.
move=> nz_b; apply/eqP; rewrite eqn_leq; apply/andP; split.
  apply/leq_sizeP => j; rewrite coef_routh leq_eqVlt => /orP[/eqP<-|large].
    have -> : p`_n.+1 = a by rewrite /a lead_coefE size_p.
    by rewrite /=; case: (odd n); rewrite /= -/b divfK ?subrr.
  have small : (size p <= j)%N by rewrite size_p.
  rewrite nth_default // sub0r; case: j large small => [//|j] /= large small.
  case: ifP => [_|]; first by rewrite mulr0 oppr0.
  move: small; rewrite leq_eqVlt => /orP[/eqP E|small]; last first.
    by rewrite nth_default ?mulr0 ?oppr0.
  by move: E; rewrite size_p => -[<-] /=; rewrite ?negbK ?eqxx.
rewrite ltnNge; apply/negP=> small.
have := coef_routh n; rewrite nth_default // eqxx orbT mulr0 subr0 => /esym/eqP.
exact/negP.
Qed.

Lemma lead_routh : b != 0 -> lead_coef (routh p) = b.
Proof.
by move=> nz_b; rewrite lead_coefE size_routh //= coef_routh eqxx orbT mulr0 subr0.
Qed.

Lemma at_parts s : at_ p s = G s + H s.
Proof. by rewrite {1}(sum_of_parts (odd n) p) rmorphD hornerD. Qed.

Lemma at_routh s : at_ (routh p) s = G s - toC (a / b) * (s * H s) + H s.
Proof.
rewrite /routh size_p /= -/a -/b rmorphB /= hornerD hornerN at_parts map_polyZ hornerZ.
by rewrite [map_poly toC ('X * _)]rmorphM hornerM /= map_polyX hornerX addrAC.
Qed.

Lemma second_over_lead rs : map_poly toC p = toC a *: \prod_(r <- rs) ('X - r%:P) ->
  size rs = n.+1 /\ b / a = - \sum_(r <- rs) Re r.
Proof.
move=> factored; have nz : p != 0 by rewrite -size_poly_gt0 size_p.
have nz_a : a != 0 by rewrite gt_eqF.
have size_rs : size rs = n.+1 by have := number_of_roots factored nz; rewrite size_p => -[].
split=> //; have [|E] := second_coefficient factored nz; last by move: size_rs; rewrite E.
rewrite size_p /= -/b -/a => E; have : toC (b / a) = - \sum_(r <- rs) r.
  by apply: (mulfI (nz_lead nz)); rewrite -E -rmorphM mulrC divfK.
by move/(congr1 Re) => /=; rewrite raddfN raddf_sum.
Qed.

Lemma parts_of_hurwitz s : hurwitz p -> 0 <= Re s ->
  Re s * modulus2 (H s) <= b / a * inner (G s) (H s).
Proof.
move=> stable s_ge0; have nz := hurwitz_nonzero stable; have [rs factored] := factored_over_C p.
have /(hurwitzP factored nz) left := stable; have nz_a : a != 0 by rewrite gt_eqF.
have [size_rs sum] := second_over_lead factored.
have direct_at : at_ p s = toC a * direct rs s := at_direct factored s.
have mirror_at : G s - H s = toC a * mirror rs s.
  have := at_mirror factored s; rewrite size_rs {1}(sum_of_parts (odd n) p) rmorphD hornerD !part_mirror.
  rewrite -/(G s) -/(H s) -(signr_odd _ n.+1) /=; case: (odd n); rewrite /= ?expr0 ?expr1 ?mul1r ?mulN1r //.
  by rewrite mulrN => /(congr1 -%R); rewrite opprD !opprK.
have EG : toC a * (direct rs s + mirror rs s) = toC 2%:R * G s.
  by rewrite mulrDr -direct_at -mirror_at at_parts rmorph_nat; ring.
have EH : toC a * (direct rs s - mirror rs s) = toC 2%:R * H s.
  by rewrite mulrBr -direct_at -mirror_at at_parts rmorph_nat; ring.
have := root_inequality left s_ge0; rewrite -sum.
have pos : 0 < a ^+ 2 by rewrite exprn_even_gt0.
rewrite -(ler_pmul2l pos) mulrCA -modulus2_real [X in _ <= X]mulrCA -inner_real EG EH.
by rewrite modulus2_real inner_real mulrCA [X in _ <= X]mulrCA ler_pmul2l // exprn_even_gt0 ?pnatr_eq0.
Qed.

Theorem routh_step : hurwitz p <-> 0 < b /\ hurwitz (routh p).
Proof.
have nz_p : p != 0 by rewrite -size_poly_gt0 size_p.
have a_gt0 : 0 < a by [].
split=> [stable|[b_gt0 stable] s /rootP root_s].
  have [rs factored] := factored_over_C p; have /(hurwitzP factored nz_p) left := stable.
  have b_gt0 : 0 < b.
    have [size_rs sum] := second_over_lead factored.
    rewrite -(pmulr_lgt0 _ (_ : 0 < a^-1)) ?invr_gt0 // sum -sumrN.
    case: rs left {factored sum} size_rs => [//|r rs] left _.
    rewrite big_cons ltr_paddr ?oppr_gt0 ?left ?mem_head // big_seq.
    by apply: sumr_ge0 => t t_rs; rewrite oppr_ge0 ltW // left // inE t_rs orbT.
  split=> // s /rootP root_s; rewrite ltNge; apply/negP=> s_ge0.
  have EG : G s = toC (a / b) * (s * H s) - H s.
    by apply/eqP; rewrite -subr_eq0 opprB addrA addrAC -at_routh root_s.
  have := parts_of_hurwitz stable s_ge0; rewrite EG.
  have -> : inner (toC (a / b) * (s * H s) - H s) (H s) = (a / b * Re s - 1) * modulus2 (H s).
    by case: (s) (H s) => [s1 s2] [h1 h2]; simpc => /=; ring.
  rewrite mulrA -subr_ge0 -mulrBl; have -> : b / a * (a / b * Re s - 1) - Re s = - (b / a).
    by field; rewrite !gt_eqF.
  rewrite mulNr oppr_ge0 pmulr_rle0 ?divr_gt0 // => /modulus2_0 H0.
  suff : Re s < 0 by rewrite ltNge s_ge0.
  by apply/stable/rootP; rewrite at_parts EG H0 !mulr0 subr0 addr0.
rewrite ltNge; apply/negP=> s_ge0.
have EG : G s = - H s by apply/eqP; rewrite -addr_eq0 -at_parts root_s.
pose c := a / b; have c_gt0 : 0 < c by rewrite divr_gt0.
pose G' := G s - toC c * (s * H s).
have at_s : at_ (routh p) s = G' + H s by exact: at_routh.
have at_minus : modulus2 (at_ (routh p) (- s)) = modulus2 (G' - H s).
  rewrite at_routh /G /H !part_mirror -/(G s) -/(H s) -/c.
  have -> : (-1) ^+ (~~ odd n) * G s - toC c * (- s * ((-1) ^+ odd n * H s)) + (-1) ^+ odd n * H s
      = (-1) ^+ (~~ odd n) * (G' - H s).
    by rewrite /G'; case: (odd n); rewrite /= ?expr0 ?expr1; ring.
  by rewrite modulus2_sign.
have := hurwitz_mirror stable s_ge0; rewrite at_minus at_s -subr_ge0 modulus2_parallelogram.
have -> : inner G' (H s) = - ((1 + c * Re s) * modulus2 (H s)).
  by rewrite /G' EG; case: (s) (H s) => [s1 s2] [h1 h2]; simpc => /=; ring.
rewrite mulrN oppr_ge0 pmulr_rle0 ?ltr0n // pmulr_rle0 => [/modulus2_0 H0|]; last first.
  by apply: ltr_paddr; [apply: mulr_ge0 => //; apply: ltW | apply: ltr01].
suff : Re s < 0 by rewrite ltNge s_ge0.
by apply/stable/rootP; rewrite at_s /G' EG H0 !(mulr0, oppr0, subr0, addr0).
Qed.
End Step.

(* The whole array: the coefficient before the first of every row is positive. *)
Fixpoint routh_test n p := if n is m.+1 then (0 < p`_m) && routh_test m (routh p) else true.

Theorem routh_hurwitz n p : size p = n.+1 -> 0 < lead_coef p -> hurwitz p <-> routh_test n p.
Proof.
elim: n p => [|n IH] p size_p lead_p.
  have E := size1_polyC (eq_leq size_p); split=> // _ z; move: lead_p.
  by rewrite E map_polyC rootC fmorph_eq0 lead_coefC => /gt_eqF->.
rewrite (routh_step size_p lead_p) /=; have [b_gt0|b_le0] := ltP 0 p`_n; last by split=> [[]|].
have nz_b : p`_n != 0 by rewrite gt_eqF.
have {}IH := IH _ (size_routh size_p nz_b).
rewrite (lead_routh size_p) // in IH; have {}IH := IH b_gt0.
by rewrite andTb -IH; split=> [[]|].
Qed.
End RouthHurwitz.
