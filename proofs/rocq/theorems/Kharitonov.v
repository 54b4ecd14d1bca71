(* Kharitonov's theorem: four polynomials decide a box of them, for every degree; of the four one decides
   degree 3 and two decide degree 4, where the lower ends are positive (Anderson, Jury and Mansour). *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require Import RouthHurwitz HurwitzInequalities PositiveResidues.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Kharitonov.
Variable R : rcfType.
Local Notation C := R[i].
Local Notation toC := (real_complex R).
Local Notation Re := (@complex.Re R).
Local Notation at_ p z := ((map_poly toC p).[z]).
Variables (n : nat) (low high : nat -> R).

(* Lower or upper end of the coefficients: l l u u of s^0, s^1, s^2, s^3 and so on for (false, false); e
   changes those of the even powers, o those of the odd ones. *)
Definition upper_end (e o : bool) i := (if odd i then o else e) (+) odd i./2.
Definition kharitonov_polynomial e o : {poly R} :=
  \poly_(i < n.+1) (if upper_end e o i then high i else low i).
Definition in_the_box (p : {poly R}) := size p = n.+1 /\ forall i, (i <= n)%N -> low i <= p`_i <= high i.

(* The value on the axis, with w = - s^2. *)
Let alternating (p : {poly R}) (w : R) : R := \sum_(i < n.+1) p`_i * (- w) ^+ i./2.

Lemma on_the_axis e (p : {poly R}) (x : C) : (size p <= n.+1)%N -> Re x = 0 ->
  at_ (part e p) x = x ^+ e * toC (alternating (part e p) (modulus2 x)).
Proof.
move=> small x_axis; have square : x ^+ 2 = toC (- modulus2 x).
  case: x x_axis => a b /= ->; rewrite expr2; apply/eqP; rewrite eq_complex /=.
  by apply/andP; split; apply/eqP; ring.
have size_part : (size (map_poly toC (part e p)) <= n.+1)%N.
  by rewrite size_map_poly (leq_trans (size_poly _ _)).
rewrite (horner_coef_wide _ size_part) rmorph_sum mulr_sumr; apply: eq_bigr => i _.
rewrite coef_map /= coef_part; case: eqP => [parity|_]; last by rewrite !(mul0r, rmorph0, mulr0).
have -> : x ^+ i = x ^+ e * toC ((- modulus2 x) ^+ i./2).
  by rewrite -{1}(odd_double_half i) exprD -muln2 mulnC exprM square -rmorphX parity.
by rewrite mulrCA -rmorphM.
Qed.

Lemma convex_share (a b c : R) : a <= b <= c -> exists2 t : R, 0 <= t <= 1 & b = t * a + (1 - t) * c.
Proof.
move=> /andP[ab bc]; have [E|ne] := eqVneq a c.
  by exists 0; rewrite ?lexx ?ler01 // mul0r add0r subr0 mul1r; apply/le_anti; rewrite bc -E ab.
have gap : 0 < c - a by rewrite subr_gt0 lt_neqAle ne (le_trans ab).
exists ((c - b) / (c - a)).
  by rewrite divr_ge0 ?subr_ge0 ?(le_trans ab) //= ler_pdivr_mulr // mul1r ler_sub.
by field; rewrite gt_eqF.
Qed.

(* A part of a polynomial of the box lies on the axis between those of two of the four. *)
Lemma part_between e (p q_1 q_2 : {poly R}) (x : C) : in_the_box p -> (size q_1 <= n.+1)%N -> (size q_2 <= n.+1)%N ->
  (forall i, (i <= n)%N -> odd i = e -> q_1`_i = if odd i./2 then high i else low i) ->
  (forall i, (i <= n)%N -> odd i = e -> q_2`_i = if odd i./2 then low i else high i) -> Re x = 0 ->
  exists2 t : R, 0 <= t <= 1
    & at_ (part e p) x = toC t * at_ (part e q_1) x + toC (1 - t) * at_ (part e q_2) x.
Proof.
move=> [size_p box] size_1 size_2 low_1 high_2 x_axis; have w_ge0 := modulus2_ge0 x.
rewrite !on_the_axis ?size_p //; set w := modulus2 x in w_ge0 *.
have ordered : alternating (part e q_1) w <= alternating (part e p) w <= alternating (part e q_2) w.
  apply/andP; split; apply: ler_sum => i _; have i_n : (i <= n)%N by rewrite -ltnS.
    rewrite !coef_part; case: eqP => [parity|_]; last by rewrite !mul0r.
    have /andP[l h] := box i i_n; rewrite low_1 // exprNn -signr_odd.
    by case: (odd i./2); rewrite ?expr1 ?expr0 ?mulN1r ?mul1r ?mulrN ?ler_opp2 ler_wpmul2r ?exprn_ge0.
  rewrite !coef_part; case: eqP => [parity|_]; last by rewrite !mul0r.
  have /andP[l h] := box i i_n; rewrite high_2 // exprNn -signr_odd.
  by case: (odd i./2); rewrite ?expr1 ?expr0 ?mulN1r ?mul1r ?mulrN ?ler_opp2 ler_wpmul2r ?exprn_ge0.
have [t t_range ->] := convex_share ordered; exists t => //.
by rewrite rmorphD !rmorphM /= mulrDr !mulrA ![x ^+ e * _]mulrC.
Qed.
End Kharitonov.

(* Four polynomials decide the box. *)
Theorem kharitonov (R : rcfType) n (low high : nat -> R) (p : {poly R}) : 0 < low n ->
  in_the_box n low high p -> (forall e o, hurwitz (kharitonov_polynomial n low high e o)) -> hurwitz p.
Proof.
case: n => [|n] low_gt0 box four; have [size_p inside] := box.
  have E := size1_polyC (eq_leq size_p) => z.
  by move: size_p; rewrite E map_polyC rootC fmorph_eq0 size_polyC; case: eqP.
pose K e o := kharitonov_polynomial n.+1 low high e o.
have /andP[low_p p_high] := inside n.+1 (leqnn _).
have p_gt0 : 0 < p`_n.+1 := lt_le_trans low_gt0 low_p.
have high_gt0 : 0 < high n.+1 := lt_le_trans p_gt0 p_high.
have coef_K e o i : (K e o)`_i = if (i < n.+2)%N then if upper_end e o i then high i else low i else 0.
  by rewrite coef_poly.
have degree (q : {poly R}) : (size q <= n.+2)%N -> 0 < q`_n.+1 -> size q = n.+2 /\ 0 < lead_coef q.
  move=> small positive; have E : size q = n.+2.
    apply/eqP; rewrite eqn_leq small ltnNge; apply/negP=> low_size.
    by rewrite nth_default ?ltxx in positive.
  by rewrite lead_coefE E.
have degree_K e o : size (K e o) = n.+2 /\ 0 < lead_coef (K e o).
  by apply: degree; [apply: size_poly | rewrite coef_K ltnSn; case: ifP].
have part_part e (q : {poly R}) : part e (part e q) = part e q.
  by apply/polyP=> i; rewrite !coef_part; case: eqP.
have size_part e (q : {poly R}) : (size (part e q) <= size q)%N by exact: size_poly.
have first o : hurwitz (part false p + part true (K false o)).
  have [size_0 lead_0] := degree_K false o; have [size_1 lead_1] := degree_K true o.
  apply: (between_hurwitz (e := false) (four false o) (four true o) size_0 lead_0 _ size_1) => //.
  - by apply/polyP=> i; rewrite !coef_part !coef_K /upper_end; case: (odd i).
  - by rewrite (leq_trans (size_part _ _)) ?size_p.
  - by rewrite coef_part; case: ifP => // _; apply: ltW.
  move=> x; apply: (part_between box); rewrite ?size_0 ?size_1 // => i i_n parity.
    by rewrite coef_K ltnS i_n /upper_end parity.
  by rewrite coef_K ltnS i_n /upper_end parity addTb; case: (odd i./2).
pose P o := part false p + part true (K false o).
have coef_P o i : (P o)`_i = if odd i then (K false o)`_i else p`_i.
  by rewrite coefD !coef_part; case: (odd i); rewrite ?addr0 ?add0r.
have degree_P o : size (P o) = n.+2 /\ 0 < lead_coef (P o).
  apply: degree; last by rewrite coef_P coef_K ltnSn; case: ifP => // _; case: ifP.
  rewrite (leq_trans (size_add _ _)) // geq_max !(leq_trans (size_part _ _)) ?size_p //.
  by have [-> _] := degree_K false o.
have [size_0 lead_0] := degree_P false; have [size_1 lead_1] := degree_P true.
rewrite (sum_of_parts false p).
apply: (between_hurwitz (e := true) (first false) (first true) size_0 lead_0 _ size_1) => //.
- by apply/polyP=> i; rewrite !coef_part coef_P; case: (odd i).
- by apply/polyP=> i; rewrite !coef_part coef_P; case: (odd i).
- by rewrite (leq_trans (size_part _ _)) ?size_p.
- by rewrite coef_part; case: ifP => // _; apply: ltW.
move=> x; apply: (part_between box); rewrite ?size_0 ?size_1 // => i i_n parity.
  by rewrite coef_P parity coef_K ltnS i_n /upper_end parity.
by rewrite coef_P parity coef_K ltnS i_n /upper_end parity addTb; case: (odd i./2).
Qed.

Section LowDegrees.
Variable R : rcfType.
Implicit Types (a b c d : R).

Theorem kharitonov_3 a_1 a_2 b_1 b_2 c_1 c_2 : 0 < c_1 -> hurwitz (cubic a_1 b_1 c_2) ->
  forall a b c, a_1 <= a <= a_2 -> b_1 <= b <= b_2 -> c_1 <= c <= c_2 -> hurwitz (cubic a b c).
Proof.
move=> c1_gt0 /hurwitz_3[a1_gt0 _ worst] a b c /andP[a_low _] /andP[b_low _] /andP[c_low c_high].
have c_gt0 := lt_le_trans c1_gt0 c_low.
have b1_gt0 : 0 < b_1 by rewrite -(pmulr_rgt0 _ a1_gt0) (lt_trans _ worst) // (lt_le_trans c_gt0).
apply/hurwitz_3; split=> //; first exact: lt_le_trans a_low.
by apply: le_lt_trans c_high (lt_le_trans worst _); apply: ler_pmul => //; apply: ltW.
Qed.

(* The determinant over c^2 is concave in a / c. *)
Lemma concave_determinant b d x y z : 0 <= d -> x <= y <= z ->
  d * x ^+ 2 < b * x - 1 -> d * z ^+ 2 < b * z - 1 -> d * y ^+ 2 < b * y - 1.
Proof.
move=> d_ge0 /andP[xy yz]; rewrite -![_ < _ - 1]subr_gt0 => at_x at_z.
have [E|x_z] := eqVneq x z; first by have -> : y = x by apply/le_anti; rewrite {1}E yz xy.
have xz : 0 < z - x by rewrite subr_gt0 lt_neqAle x_z (le_trans xy).
rewrite -(pmulr_rgt0 _ xz); set v := _ * _.
have -> : v = (z - y) * (b * x - 1 - d * x ^+ 2) + (y - x) * (b * z - 1 - d * z ^+ 2)
    + d * ((z - y) * (y - x) * (z - x)) by rewrite /v; ring.
apply: ltr_paddr; first by rewrite !mulr_ge0 ?subr_ge0 // (le_trans xy).
move: xy; rewrite le_eqVlt => /orP[/eqP E|x_y].
  by rewrite -E subrr mul0r addr0 mulr_gt0.
have zy : 0 <= z - y by rewrite subr_ge0.
have yx : 0 < y - x by rewrite subr_gt0.
exact: ltr_paddl (mulr_ge0 zy (ltW at_x)) (mulr_gt0 yx at_z).
Qed.

Theorem kharitonov_4 a_1 a_2 b_1 b_2 c_1 c_2 d_1 d_2 : 0 < a_1 -> 0 < c_1 -> 0 < d_1 ->
  hurwitz (quartic a_1 b_1 c_2 d_2) -> hurwitz (quartic a_2 b_1 c_1 d_2) ->
  forall a b c d, a_1 <= a <= a_2 -> b_1 <= b <= b_2 -> c_1 <= c <= c_2 -> d_1 <= d <= d_2 ->
  hurwitz (quartic a b c d).
Proof.
move=> a1_gt0 c1_gt0 d1_gt0 /hurwitz_4[_ c2_gt0 d2_gt0 worst_1] /hurwitz_4[a2_gt0 _ _ worst_2] a b c d.
move=> /andP[a_low a_high] /andP[b_low _] /andP[c_low c_high] /andP[d_low d_high].
have a_gt0 := lt_le_trans a1_gt0 a_low; have c_gt0 := lt_le_trans c1_gt0 c_low.
apply/hurwitz_4; split=> //; first exact: lt_le_trans d_low.
have scaled x y : 0 < y -> (x ^+ 2 * d_2 < y * (x * b_1 - y)) = (d_2 * (x / y) ^+ 2 < b_1 * (x / y) - 1).
  move=> y_gt0; rewrite -[RHS](ltr_pmul2l (_ : 0 < y ^+ 2)) ?exprn_gt0 //.
  by congr (_ < _); field; rewrite gt_eqF.
have low : a_1 / c_2 <= a / c by rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // ler_pmul // ltW.
have high : a / c <= a_2 / c_1 by rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // ler_pmul // ltW.
rewrite !scaled // in worst_1 worst_2.
have worst : a ^+ 2 * d_2 < c * (a * b_1 - c).
  by rewrite scaled //; apply: concave_determinant worst_1 worst_2; rewrite ?low ?(ltW d2_gt0).
apply: le_lt_trans (lt_le_trans worst _); first by rewrite ler_wpmul2l ?sqr_ge0.
by rewrite ler_wpmul2l ?(ltW c_gt0) // ler_sub // ler_wpmul2l // ltW.
Qed.
End LowDegrees.
