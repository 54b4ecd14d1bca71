(* Hermite and Biehler by residues: of a Hurwitz polynomial G + H, with its even and its odd part as G and H
   in either order, H has simple roots, on the imaginary axis, at which G / H has positive residues; and a
   polynomial with such parts is Hurwitz. Over a real closed field. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require Import RouthHurwitz.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section PositiveResidues.
Variable R : rcfType.
Local Notation C := R[i].
Local Notation toC := (real_complex R).
Local Notation Re := (@complex.Re R).
Local Notation at_ p z := ((map_poly toC p).[z]).
Implicit Types (p G H : {poly R}) (s x z u v : C) (xs : seq C) (e : bool).

Lemma inner_add u v z : inner (u + v) z = inner u z + inner v z.
Proof. by case: u v z => [a b] [c d] [f g] /=; ring. Qed.

Lemma inner_self u : inner u u = modulus2 u.
Proof. by case: u => a b /=; rewrite !expr2. Qed.

Lemma inner_opp u : inner (- u) u = - modulus2 u.
Proof. by case: u => a b /=; ring. Qed.

Lemma inner_scale (c : R) u v : inner (toC c * u) v = c * inner u v.
Proof. by case: u v => [a b] [d f]; simpc => /=; ring. Qed.

Lemma inner_mul z u : inner (z * u) u = Re z * modulus2 u.
Proof. by case: z u => [a b] [c d]; simpc => /=; ring. Qed.

Lemma inner_both z u v : inner (z * u) (z * v) = modulus2 z * inner u v.
Proof. by case: z u v => [a b] [c d] [f g]; simpc => /=; ring. Qed.

Lemma modulus2_gt0 z : z != 0 -> 0 < modulus2 z.
Proof. by move=> nz; rewrite ltNge; apply: contra nz => /modulus2_0->. Qed.

(* H is its leading coefficient times the product of X - x over xs, each x once, all on the axis. *)
Section Criterion.
Variables (G H : {poly R}) (xs : seq C) (c : R).
Hypothesis factored : map_poly toC H = toC (lead_coef H) *: \prod_(x <- xs) ('X - x%:P).
Hypotheses (nz_H : H != 0) (simple : uniq xs) (axis : forall x, x \in xs -> Re x = 0).
Hypotheses (proper : (size (G - c *: ('X * H))%R <= size xs)%N) (c_ge0 : 0 <= c).
Hypothesis residues : forall x, x \in xs -> exists2 rho : R, 0 < rho & at_ G x = toC rho * at_ H^`() x.

Let T x : {poly C} := toC (lead_coef H) *: \prod_(y <- rem x xs) ('X - y%:P).

Lemma one_factor x : x \in xs -> map_poly toC H = ('X - x%:P) * T x.
Proof. by move=> x_xs; rewrite factored (perm_big _ (perm_to_rem x_xs)) big_cons -scalerAr. Qed.

Lemma at_own_root x : x \in xs -> (T x).[x] = at_ H^`() x.
Proof.
move=> x_xs; rewrite -deriv_map (one_factor x_xs) derivM derivXsubC mul1r hornerD hornerM hornerXsubC.
by rewrite subrr mul0r addr0.
Qed.

Lemma at_other_root x y : y \in xs -> x != y -> (T x).[y] = 0.
Proof.
move=> y_xs ne; apply/rootP; rewrite rootZ ?nz_lead // root_prod_XsubC mem_rem_uniq //.
by rewrite inE /= eq_sym ne.
Qed.

Lemma derivative_at_root x : x \in xs -> at_ H^`() x != 0.
Proof.
move=> x_xs; rewrite -at_own_root // -rootE rootZ ?nz_lead // root_prod_XsubC.
by rewrite mem_rem_uniq // inE eqxx.
Qed.

Let rho x : R := Re (at_ G x / at_ H^`() x).

Lemma residue x : x \in xs -> 0 < rho x /\ at_ G x = toC (rho x) * at_ H^`() x.
Proof.
move=> x_xs; have nz := derivative_at_root x_xs; have [r r_gt0 E] := residues x_xs.
by have -> : rho x = r by rewrite /rho E mulfK.
Qed.

(* Lagrange's interpolation at the roots of H. *)
Lemma partial_fractions :
  map_poly toC (G - c *: ('X * H)) = \sum_(x <- xs) toC (rho x) *: T x.
Proof.
apply/eqP; rewrite -subr_eq0; apply/eqP; apply: (@roots_geq_poly_eq0 _ _ xs) => //.
  apply/allP=> y y_xs; apply/rootP; rewrite hornerD hornerN horner_sum rmorphB /= map_polyZ rmorphM /=.
  rewrite map_polyX hornerD hornerN hornerZ hornerM hornerX (one_factor y_xs) hornerM hornerXsubC.
  rewrite subrr mul0r !mulr0 subr0 (bigD1_seq y) //= hornerZ at_own_root // big1_seq ?addr0 => [|x].
    by rewrite (residue y_xs).2 subrr.
  by case/andP=> ne x_xs; rewrite hornerZ at_other_root ?mulr0 //.
apply: leq_trans (size_add _ _) _; rewrite size_opp geq_max size_map_poly proper /=.
apply: leq_trans (size_sum _ _ _) _; apply/bigmax_leqP_seq => x x_xs _.
apply: leq_trans (size_scale_leq _ _) _; apply: leq_trans (size_scale_leq _ _) _.
by rewrite size_prod_XsubC size_rem // prednK //; case: (xs) x_xs.
Qed.

Theorem positive_residues_are_hurwitz : hurwitz (G + H).
Proof.
move=> s /rootP; rewrite rmorphD hornerD => root_s; rewrite ltNge; apply/negP=> s_ge0.
have EG : at_ G s = - at_ H s by apply/eqP; rewrite -addr_eq0 root_s.
have [/eqP H0|nz] := boolP (at_ H s == 0).
  have s_xs : s \in xs by move/rootP: H0; rewrite factored rootZ ?nz_lead // root_prod_XsubC.
  have [rho_gt0 /eqP] := residue s_xs; rewrite EG H0 oppr0 eq_sym mulf_eq0 (negPf (derivative_at_root s_xs)).
  by rewrite orbF fmorph_eq0 gt_eqF.
have term x : x \in xs -> 0 <= inner ((toC (rho x) *: T x).[s]) (at_ H s).
  move=> x_xs; have [rho_gt0 _] := residue x_xs; have EH := one_factor x_xs.
  rewrite hornerZ inner_scale mulr_ge0 ?(ltW rho_gt0) // EH hornerM hornerXsubC.
  have -> : inner (T x).[s] ((s - x) * (T x).[s]) = Re (s - x) * modulus2 (T x).[s].
    by case: (s - x) ((T x).[s]) => [a b] [d f]; simpc => /=; ring.
  by rewrite mulr_ge0 ?modulus2_ge0 // raddfB /= (axis x_xs) subr0.
have : 0 <= inner (at_ G s) (at_ H s).
  have -> : at_ G s = (map_poly toC (G - c *: ('X * H))).[s] + toC c * (s * at_ H s).
    by rewrite rmorphB /= map_polyZ rmorphM /= map_polyX hornerD hornerN hornerZ hornerM hornerX subrK.
  rewrite inner_add inner_scale inner_mul partial_fractions horner_sum addr_ge0 //; last first.
    by rewrite !mulr_ge0 ?modulus2_ge0.
  rewrite big_seq; elim/big_ind: _ => [|u v u_ge0 v_ge0|x x_xs]; last exact: term.
    by case: (at_ H s) => a b /=; rewrite !mul0r addr0.
  by rewrite inner_add addr_ge0.
rewrite EG inner_opp oppr_ge0 => /modulus2_0 H0; by rewrite H0 eqxx in nz.
Qed.
End Criterion.

(* The converse. *)
Lemma simple_roots xs : (forall x, x \in xs -> ((\prod_(y <- xs) ('X - y%:P) : {poly C})^`()).[x] != 0) ->
  uniq xs.
Proof.
elim: xs => // x xs IH nz; have derivative y : ((\prod_(y <- x :: xs) ('X - y%:P) : {poly C})^`()).[y]
    = (\prod_(y <- xs) ('X - y%:P)).[y] + (y - x) * (\prod_(y <- xs) ('X - y%:P))^`().[y].
  by rewrite big_cons derivM derivXsubC mul1r hornerD hornerM hornerXsubC.
apply/andP; split.
  apply/negP=> x_xs; have := nz x (mem_head _ _); rewrite derivative subrr mul0r addr0.
  by apply/negP/negPn; rewrite -rootE root_prod_XsubC.
apply: IH => y y_xs; have := nz y; rewrite inE y_xs orbT derivative => /(_ isT).
have -> : (\prod_(y <- xs) ('X - y%:P)).[y] = 0 by apply/rootP; rewrite root_prod_XsubC.
by rewrite add0r mulf_eq0 negb_or => /andP[].
Qed.

(* p' / p has a positive real part to the right of all roots. *)
Lemma logarithmic_derivative p s : hurwitz p -> (1 < size p)%N -> 0 <= Re s ->
  0 < inner (at_ p^`() s) (at_ p s).
Proof.
move=> stable large s_ge0; have nz := hurwitz_nonzero stable; have [rs factored] := factored_over_C p.
have /(hurwitzP factored nz) left := stable; have := number_of_roots factored nz.
rewrite -deriv_map factored derivZ !hornerZ inner_both => size_p.
have nz_rs : rs != [::] by apply: contraTneq large => E; rewrite size_p E.
rewrite mulr_gt0 ?modulus2_gt0 ?nz_lead //.
have apart r : r \in rs -> 0 < Re (s - r) by move=> r_rs; rewrite raddfB subr_gt0 (lt_le_trans _ s_ge0) ?left.
have value : (\prod_(r <- rs) ('X - r%:P)).[s] != 0.
  rewrite -rootE root_prod_XsubC; apply/negP=> s_rs; have := apart s s_rs.
  by rewrite subrr ltxx.
elim: rs {factored left size_p} nz_rs apart value => // r rs IH _ apart.
rewrite big_cons derivM derivXsubC mul1r hornerD !hornerM hornerXsubC => value.
have [nz_r nz_q] : s - r != 0 /\ (\prod_(j <- rs) ('X - j%:P)).[s] != 0.
  by move: value; rewrite mulf_eq0 negb_or => /andP.
rewrite inner_add inner_both ltr_paddr //.
  have [->|nz_rs] := eqVneq rs [::].
    by rewrite big_nil derivC hornerC mulr_ge0 ?modulus2_ge0 //; case: (_.[s]) => a b /=; rewrite !mul0r addr0.
  rewrite mulr_ge0 ?modulus2_ge0 // ltW // IH // => t t_rs; apply: apart; rewrite inE t_rs orbT.
  exact: isT.
move: nz_q; move: ((\prod_(j <- rs) ('X - j%:P)).[s]) => q nz_q.
have -> : inner q ((s - r) * q) = Re (s - r) * modulus2 q.
  by case: (s - r) q {nz_q} => [a b] [d f]; simpc => /=; ring.
by rewrite mulr_gt0 ?modulus2_gt0 // apart ?mem_head.
Qed.

Lemma mirror_strictly_below p s : hurwitz p -> (1 < size p)%N -> 0 < Re s ->
  modulus2 (at_ p (- s)) < modulus2 (at_ p s).
Proof.
move=> stable large s_gt0; have nz := hurwitz_nonzero stable; have [rs factored] := factored_over_C p.
have /(hurwitzP factored nz) left := stable; have := number_of_roots factored nz.
rewrite (at_mirror factored) (at_direct factored) !modulus2_real modulus2_sign => size_p.
rewrite ltr_pmul2l; last by rewrite exprn_even_gt0 //= lead_coef_eq0.
case: rs {factored} left size_p => [|r rs] left size_p; first by rewrite size_p in large.
have r_lt0 := left r (mem_head _ _); have {}left t : t \in rs -> Re t < 0.
  by move=> t_rs; apply: left; rewrite inE t_rs orbT.
have below := mirror_below left (ltW s_gt0).
have positive : 0 < modulus2 (\prod_(t <- rs) (s - t)).
  apply: modulus2_gt0; rewrite prodf_seq_neq0; apply/allP=> t t_rs /=; rewrite subr_eq0.
  by apply: contraTneq s_gt0 => ->; rewrite lt_gtF ?left.
rewrite !big_cons !modulus2_mul; apply: le_lt_trans (ler_wpmul2l (modulus2_ge0 _) below) _.
rewrite ltr_pmul2r //; case: s r s_gt0 r_lt0 {left below positive size_p} => [sigma y] [rx ry] /= s_gt0 r_lt0.
rewrite -subr_gt0; simpc => /=; have E (u w : R) : u = w -> 0 < w -> 0 < u by move=> ->.
apply: (E _ (4%:R * sigma * - rx)); first by ring.
by rewrite !mulr_gt0 ?ltr0n // oppr_gt0.
Qed.

Lemma deriv_part e p : (part e p)^`() = part (~~ e) p^`().
Proof.
apply/polyP=> i; rewrite coef_deriv !coef_part coef_deriv /=.
by case: (odd i) e => [] [] //=; rewrite mul0rn.
Qed.

(* On the axis the even part is real and the odd part imaginary. *)
Lemma part_on_the_axis e p x : Re x = 0 -> if e then Re (at_ (part e p) x) = 0 else complex.Im (at_ (part e p) x) = 0.
Proof.
move=> x_axis; have conj_x : x^* = - x.
  by case: x x_axis => a b /= ->; apply/eqP; rewrite eq_complex /= oppr0 !eqxx.
have := at_conj (part e p) x; rewrite conj_x part_mirror.
case: (at_ (part e p) x) => a b; case: e => /=; rewrite ?expr0 ?expr1; simpc => -[E].
  by move/eqP: E; rewrite eq_sym -addr_eq0 -mulr2n mulrn_eq0 => /eqP.
by move/eqP: E; rewrite -addr_eq0 -mulr2n mulrn_eq0 => /eqP.
Qed.

Theorem residues_of_hurwitz e p x : hurwitz p -> (1 < size p)%N ->
  let G := part e p in let H := part (~~ e) p in root (map_poly toC H) x ->
  [/\ Re x = 0, at_ H^`() x != 0 & exists2 rho : R, 0 < rho & at_ G x = toC rho * at_ H^`() x].
Proof.
move=> stable large G H /rootP root_x; have nz := hurwitz_nonzero stable.
have sum s : at_ p s = at_ G s + at_ H s.
  by rewrite {1}(sum_of_parts (~~ e) p) negbK rmorphD hornerD.
have not_right s : at_ H s = 0 -> 0 < Re s -> Logic.False.
  move=> zero s_gt0; have := mirror_strictly_below stable large s_gt0.
  by rewrite !sum !part_mirror -/G -/H zero mulr0 !addr0 modulus2_sign ltxx.
have x_axis : Re x = 0.
  apply/eqP; rewrite eq_le; apply/andP; split; rewrite leNgt; apply/negP=> side.
    exact: not_right root_x side.
  apply: (not_right (- x)); first by rewrite /H part_mirror -/H root_x mulr0.
  by rewrite raddfN oppr_gt0.
have EG : at_ p x = at_ G x by rewrite sum root_x addr0.
have nz_G : at_ G x != 0.
  by rewrite -EG; apply/negP=> /eqP/rootP/stable; rewrite x_axis ltxx.
have x_ge0 : 0 <= Re x by rewrite x_axis.
have EG' : at_ p^`() x = at_ (part (~~ e) p^`()) x + at_ (part e p^`()) x.
  by rewrite {1}(sum_of_parts e p^`()) rmorphD hornerD.
have EH' : at_ H^`() x = at_ (part e p^`()) x by rewrite /H deriv_part negbK.
have := logarithmic_derivative stable large x_ge0; rewrite EG EG' EH'; move: nz_G.
have := part_on_the_axis (~~ e) p^`() x_axis; have := part_on_the_axis e p^`() x_axis.
have := part_on_the_axis e p x_axis; rewrite /G.
case: (at_ (part (~~ e) p^`()) x) (at_ (part e p^`()) x) (at_ (part e p) x) => [a b] [c d] [f g].
have quotient (u v : R) : 0 < v * u -> 0 < u / v.
  by move=> pos; have nz_v : v != 0; [apply: contraTneq pos => ->; rewrite mul0r ltxx |
    rewrite -(pmulr_lgt0 _ (_ : 0 < v ^+ 2)) ?exprn_even_gt0 // expr2 mulrA divfK // mulrC].
case: (e) => /= -> -> -> _; rewrite ?mul0r ?mulr0 ?add0r ?addr0 => pos; split=> //.
- by apply: contraTneq pos => -[->]; rewrite mul0r ltxx.
- exists (g / d); first exact: quotient.
  have nz_d : d != 0 by apply: contraTneq pos => ->; rewrite mul0r ltxx.
  by simpc; rewrite divfK.
- by apply: contraTneq pos => -[->]; rewrite mul0r ltxx.
exists (f / c); first exact: quotient.
have nz_c : c != 0 by apply: contraTneq pos => ->; rewrite mul0r ltxx.
by simpc; rewrite divfK.
Qed.

(* Between two Hurwitz polynomials with the same part H, on the axis. *)
Theorem between_hurwitz e n G H p_1 p_2 : hurwitz p_1 -> hurwitz p_2 ->
  size p_1 = n.+2 -> 0 < lead_coef p_1 -> part (~~ e) p_1 = H -> size p_2 = n.+2 -> part (~~ e) p_2 = H ->
  part e G = G -> (size G <= n.+2)%N -> 0 <= G`_n.+1 ->
  (forall x, Re x = 0 -> exists2 t : R, 0 <= t <= 1
    & at_ G x = toC t * at_ (part e p_1) x + toC (1 - t) * at_ (part e p_2) x) ->
  hurwitz (G + H).
Proof.
move=> stable_1 stable_2 size_1 lead_1 E_1 size_2 E_2 parity size_G lead_G between.
have large_1 : (1 < size p_1)%N by rewrite size_1.
have large_2 : (1 < size p_2)%N by rewrite size_2.
have b_gt0 : 0 < p_1`_n by have [] := (routh_step size_1 lead_1).1 stable_1.
have coef_H i : H`_i = if odd i == ~~ e then p_1`_i else 0 by rewrite -E_1 coef_part.
have coef_G i : odd i != e -> G`_i = 0 by rewrite -parity coef_part => /negPf->.
have residue x : root (map_poly toC H) x -> [/\ Re x = 0, at_ H^`() x != 0 &
    exists2 rho : R, 0 < rho & at_ G x = toC rho * at_ H^`() x].
  move=> root_x.
  have := @residues_of_hurwitz e p_1 x stable_1 large_1; rewrite E_1 => /(_ root_x)[x_axis nz [r_1 pos_1 res_1]].
  have := @residues_of_hurwitz e p_2 x stable_2 large_2; rewrite E_2 => /(_ root_x)[_ _ [r_2 pos_2 res_2]].
  have [t /andP[t_ge0 t_le1] ->] := between x x_axis; split=> //; exists (t * r_1 + (1 - t) * r_2).
    have [->|nz_t] := eqVneq t 0; first by rewrite mul0r add0r subr0 mul1r.
    rewrite ltr_paddr ?mulr_ge0 ?subr_ge0 ?(ltW pos_2) // mulr_gt0 // lt_neqAle eq_sym nz_t.
    exact: t_ge0.
  by rewrite res_1 res_2 !mulrA -mulrDl -!rmorphM -rmorphD.
have nz_H : H != 0.
  apply: contraTneq isT => H0; have := residue 1; rewrite H0 rmorph0 root0 => /(_ isT)[/eqP].
  by rewrite /= oner_eq0.
have [xs factored] := factored_over_C H; have size_H := number_of_roots factored nz_H.
have of_xs x : x \in xs -> root (map_poly toC H) x.
  by move=> x_xs; rewrite factored rootZ ?nz_lead // root_prod_XsubC.
have simple : uniq xs.
  apply: simple_roots => x /of_xs/residue[_ nz _]; apply: contraNneq nz => zero.
  by rewrite -deriv_map factored derivZ hornerZ zero mulr0.
pose c := if odd n == ~~ e then G`_n.+1 / p_1`_n else 0.
apply: (positive_residues_are_hurwitz factored nz_H simple (c := c)) => [x /of_xs/residue[]//|||x].
- apply/leq_sizeP => j large; rewrite coefB coefZ coefXM /c.
  have [same|differ] := eqVneq (odd n) (~~ e).
    have lead : H`_n != 0 by rewrite coef_H same eqxx gt_eqF.
    have n_j : (n <= j)%N.
      apply: leq_trans large; rewrite -ltnS -size_H ltnNge; apply/negP=> small.
      by rewrite nth_default ?eqxx in lead.
    move: n_j; rewrite leq_eqVlt => /orP[/eqP<-|].
      rewrite coef_G ?same; last by case: (e).
      case: (n) same => [|m] /= same; first by rewrite mulr0 subrr.
      by rewrite coef_H; case: (odd m) (e) same => [] [] //=; rewrite mulr0 subrr.
    rewrite leq_eqVlt => /orP[/eqP<-|large_j] /=.
      by rewrite coef_H same eqxx divfK ?subrr // gt_eqF.
    have zero_G : G`_j = 0 by rewrite nth_default // (leq_trans size_G).
    rewrite zero_G; case: j large_j {large zero_G} => // j large_j /=.
    rewrite coef_H; case: ifP => [parity_j|_]; last by rewrite mulr0 subrr.
    rewrite [p_1`_j]nth_default ?mulr0 ?subrr // size_1; move: large_j parity_j; rewrite ltnS leq_eqVlt.
    by case/orP=> [/eqP<-|//] /=; rewrite same; case: (e).
  rewrite mul0r subr0; have lead : H`_n.+1 != 0.
    rewrite coef_H /= (_ : (~~ odd n == ~~ e) = true); last by case: (odd n) (e) differ => [] [].
    by move: lead_1; rewrite lead_coefE size_1 /= => /gt_eqF->.
  have n_j : (n < j)%N.
    apply: leq_trans large; rewrite -ltnS -size_H ltnNge; apply/negP=> small.
    by rewrite nth_default ?eqxx in lead.
  move: n_j; rewrite leq_eqVlt => /orP[/eqP<-|large_j]; last by rewrite nth_default // (leq_trans size_G).
  by rewrite coef_G //=; case: (odd n) (e) differ => [] [].
- by rewrite /c; case: ifP => // _; rewrite mulr_ge0 ?invr_ge0 ?(ltW b_gt0).
by move/of_xs/residue=> [].
Qed.
End PositiveResidues.
