(* Kharitonov's theorem in degrees 3 and 4: of the four polynomials one decides degree 3 and two degree 4,
   where the lower ends are positive (Anderson, Jury and Mansour). *)
From mathcomp Require Import all_ssreflect all_algebra ring.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require Import RouthHurwitz HurwitzInequalities.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

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
