(* When a real polynomial of degree 2n is a product of two of degree n, over every real closed
   field. Complex roots come in pairs; the rest is parity. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import Diophantine.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.
Local Open Scope complex_scope.

Section Identities.
Variable K : comRingType.
Lemma quadratic (z w : K) :
  'X^2 - (z + w)%:P * 'X + (z * w)%:P = ('X - z%:P) * ('X - w%:P) :> {poly K}.
Proof. rewrite polyCM polyCD; ring. Qed.
Lemma sum_of_squares (a b : K) : a * a - b * - b = a * a + b * b. Proof. by ring. Qed.
Lemma cross_terms (a b : K) : a * - b + b * a = 0. Proof. by ring. Qed.
Lemma swap_factors (q r t s p : {poly K}) : p = q * s -> s = t * r -> p = q * r * t.
Proof. by move=> -> ->; ring. Qed.
Lemma share_factors (q t x y s p : {poly K}) :
  p = s * (x * y) -> s = q * t -> p = (q * x) * (t * y).
Proof. by move=> -> ->; ring. Qed.
End Identities.

Section RealFactors.
Variable R : rcfType.
Implicit Types p q r s : {poly R}.
Local Notation toC := (real_complex R).

(* A complex root and its conjugate: a monic quadratic factor. *)
Lemma conjugate_pair p a b : b != 0 -> root (map_poly toC p) (a +i* b) ->
  exists q, [/\ q \is monic, degree_is q 2, q %| p
    & map_poly toC q = ('X - (a +i* b)%:P) * ('X - (conjc (a +i* b))%:P)].
Proof.
move=> nz_b root_z; pose q : {poly R} := 'X^2 - (a + a) *: 'X + (a * a + b * b)%:P.
have lower : (size ((- ((a + a) *: 'X) + (a * a + b * b)%:P)%R : {poly R}) < 3)%N.
  rewrite (leq_ltn_trans (size_add _ _)) // gtn_max size_opp.
  rewrite (leq_ltn_trans (size_scale_leq _ _)) ?size_polyX //.
  by rewrite (leq_ltn_trans (size_polyC_leq1 _)).
set z := a +i* b in root_z *.
have product : z * conjc z = toC (a * a + b * b).
  by apply/eqP; rewrite eq_complex /= sum_of_squares cross_terms !eqxx.
have sum : z + conjc z = toC (a + a) by apply/eqP; rewrite eq_complex /= subrr !eqxx.
have over_C : map_poly toC q = ('X - z%:P) * ('X - (conjc z)%:P).
  rewrite /q rmorphD rmorphB /= map_polyXn map_polyZ map_polyX map_polyC /=.
  by rewrite -product -sum -mul_polyC quadratic.
exists q; split=> //.
- by rewrite /q -addrA monicE lead_coefDl ?size_polyXn // lead_coefXn.
- by rewrite /q -addrA size_addl size_polyXn.
rewrite -(dvdp_map [rmorphism of toC]) /= over_C Gauss_dvdp.
  rewrite !dvdp_XsubCl root_z andTb -complex_root_conj -map_poly_comp.
  by rewrite (@eq_map_poly _ _ _ toC) // => x /=; rewrite oppr0.
apply: coprimep_XsubC2; apply: contra nz_b => /eqP.
by move/(congr1 (@complex.Im R)) => /= /eqP; rewrite -opprD oppr_eq0 -mulr2n mulrn_eq0.
Qed.

(* Degree 2 or more: a monic quadratic factor. *)
Lemma quadratic_factor p : (2 < size p)%N ->
  exists q, [/\ q \is monic, degree_is q 2 & q %| p].
Proof.
elim: {p}(size p) {-2}p (leqnn (size p)) => [|m IH] p; first by case: (size p).
move=> below deg_p; have nz_p : p != 0 by rewrite -size_poly_gt0; case: (size p) deg_p.
have /closed_rootP[[a b] root_z] : size (map_poly toC p) != 1%N.
  by rewrite size_map_poly; case: (size p) deg_p => [|[|]].
have [b0|nz_b] := eqVneq b 0.
  (* a real root: divide by it, unless the degree is 2 *)
  have root_a : root p a by rewrite -(fmorph_root [rmorphism of toC]); move: root_z; rewrite b0.
  have [s Es] := factor_theorem p a root_a.
  have nz_s : s != 0 by apply: contraNneq nz_p => s0; rewrite Es s0 mul0r.
  have size_p : size p = (size s).+1.
    by rewrite Es size_Mmonic ?monicXsubC // size_XsubC addn2.
  have [deg_s|deg_s] := ltnP 2 (size s).
    have [||q [monic_q deg_q divides]] := IH s; [by rewrite -ltnS -size_p | by [] |].
    by exists q; split=> //; rewrite Es dvdp_mulr.
  have size_3 : size p = 3%N by move: (size p) (size s) deg_p size_p deg_s; clear; lia.
  exists ((lead_coef p)^-1 *: p); split.
  - by rewrite monicE lead_coefZ mulVf // lead_coef_eq0.
  - by rewrite size_scale ?invr_eq0 ?lead_coef_eq0.
  - by rewrite dvdpZl ?dvdpp // invr_eq0 lead_coef_eq0.
have [q [monic_q deg_q divides _]] := conjugate_pair nz_b root_z.
by exists q.
Qed.

(* A factor of every even degree that is at most the polynomial's own. *)
Lemma even_factor m p : p \is monic -> (m.*2 < size p)%N ->
  exists q s, [/\ q \is monic, s \is monic, degree_is q m.*2 & p = q * s].
Proof.
move=> monic_p; elim: m => [|m IH] deg_p.
  by exists 1, p; rewrite monic1 size_poly1 mul1r.
have [|q [s [monic_q monic_s deg_q Ep]]] := IH.
  by apply: leq_trans deg_p; rewrite doubleS; lia.
have size_p : size p = (m.*2.+1 + size s).-1.
  by rewrite Ep size_monicM ?monic_neq0 // deg_q.
have deg_s : (2 < size s)%N.
  by move: (size p) (size s) deg_p size_p => x y; rewrite doubleS; lia.
have [r [monic_r deg_r /dvdpP[t Et]]] := quadratic_factor deg_s.
exists (q * r), t; split.
- by rewrite monicMl.
- by rewrite -(monicMr _ monic_r) -Et.
- by rewrite size_monicM ?monic_neq0 // deg_q deg_r doubleS addnS /= !addnS addn0.
- exact: swap_factors Ep Et.
Qed.

(* The parity condition. *)
Theorem parity n p : p \is monic -> degree_is p (n + n) ->
  (exists q s, [/\ q \is monic, s \is monic, degree_is q n, degree_is s n & p = q * s])
  <-> ~~ odd n \/ odd n /\ two_roots p.
Proof.
move=> monic_p deg_p; split=> [[q [s [_ _ deg_q deg_s ->]]]|condition].
  have [odd_n|] := boolP (odd n); [right; split=> // | by left].
  have [|x /factor_theorem[q' ->]] := @odd_poly_root R q; first by rewrite deg_q /= odd_n.
  have [|y /factor_theorem[s' ->]] := @odd_poly_root R s; first by rewrite deg_s /= odd_n.
  by exists x, y, (q' * s'); rewrite mulrACA.
have halves := odd_double_half n; case: condition => [even_n|[odd_n [x [y [s Es]]]]].
  rewrite (negPf even_n) add0n in halves.
  have [|q [s [monic_q monic_s deg_q Ep]]] := even_factor (m := n./2) monic_p.
    by rewrite deg_p halves ltnS leq_addr.
  rewrite halves in deg_q; exists q, s; split=> //.
  exact: degree_of_cofactor deg_p deg_q Ep.
have monic_xy : ('X - x%:P) * ('X - y%:P) \is monic by rewrite monicMl ?monicXsubC.
have monic_s : s \is monic by rewrite -(monicMr _ monic_xy) -Es.
rewrite odd_n add1n in halves.
have deg_s : degree_is s (n./2.*2 + n./2.*2).
  have : size p = (size s + 3).-1.
    rewrite Es size_monicM ?monic_neq0 // size_monicM ?monicXsubC ?polyXsubC_eq0 //.
    by rewrite !size_XsubC.
  by rewrite deg_p -halves; move: (size s); lia.
have [|q [t [monic_q monic_t deg_q Et]]] := even_factor (m := n./2) monic_s.
  by rewrite deg_s ltnS leq_addr.
have deg_t := degree_of_cofactor monic_q monic_t deg_s deg_q Et.
exists (q * ('X - x%:P)), (t * ('X - y%:P)); split.
- by rewrite monicMl ?monicXsubC.
- by rewrite monicMl ?monicXsubC.
- by rewrite size_monicM ?polyXsubC_eq0 // size_XsubC deg_q addn2 /= halves.
- by rewrite size_monicM ?polyXsubC_eq0 // size_XsubC deg_t addn2 /= halves.
- exact: share_factors Es Et.
Qed.

Lemma odd_degree_has_root p : ~~ odd (size p) -> exists x, root p x.
Proof. by move=> even_size; have [x] := odd_poly_root even_size; exists x. Qed.

(* A polynomial of even degree has two real roots as soon as it has one. *)
Theorem one_root_is_enough n p : degree_is p (n + n) -> two_roots p <-> exists x, root p x.
Proof.
move=> deg_p; split=> [[x [y [q ->]]]|[x /factor_theorem[q Ep]]].
  by exists x; rewrite !rootM root_XsubC eqxx orbT.
have nz_p : p != 0 by rewrite -size_poly_gt0 deg_p.
have nz_q : q != 0 by apply: contraNneq nz_p => q0; rewrite Ep q0 mul0r.
have even_q : ~~ odd (size q).
  have size_p : size p = (size q).+1 by rewrite Ep size_Mmonic ?monicXsubC // size_XsubC addn2.
  by move: deg_p; rewrite size_p => -[->]; rewrite addnn odd_double.
have [y /factor_theorem[r Eq]] := odd_degree_has_root even_q.
by exists y, x, r; rewrite Ep Eq mulrA.
Qed.
End RealFactors.
