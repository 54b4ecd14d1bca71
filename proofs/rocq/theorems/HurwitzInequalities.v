(* Routh's test in degrees 2, 3 and 4: the inequalities of Hurwitz, Lienard and Chipart. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require Import RouthHurwitz.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section HurwitzInequalities.
Variable R : rcfType.
Implicit Types (p : {poly R}) (a b c d : R).

Definition quadratic (a b : R) : {poly R} := 'X^2 + a *: 'X + b%:P.
Definition cubic (a b c : R) : {poly R} := 'X^3 + a *: 'X^2 + b *: 'X + c%:P.
Definition quartic (a b c d : R) : {poly R} := 'X^4 + a *: 'X^3 + b *: 'X^2 + c *: 'X + d%:P.

(* What such a polynomial is made of. *)
Lemma monic_of_list p (l : seq R) : p = Poly (rcons l 1) ->
  [/\ size p = (size l).+1, lead_coef p = 1, 0 < lead_coef p & forall i, p`_i = nth 0 (rcons l 1) i].
Proof.
move=> ->; have E : Poly (rcons l 1) = rcons l 1 :> seq R by rewrite (@PolyK _ 0) // last_rcons oner_neq0.
have lead : lead_coef (Poly (rcons l 1)) = 1 by rewrite lead_coefE E size_rcons nth_rcons ltnn eqxx.
by split=> [||| i]; rewrite ?lead ?ltr01 ?coef_Poly // E size_rcons.
Qed.

Lemma quadraticE a b : quadratic a b = Poly [:: b; a; 1].
Proof. by rewrite /quadratic /= !cons_poly_def -!mul_polyC; ring. Qed.
Lemma cubicE a b c : cubic a b c = Poly [:: c; b; a; 1].
Proof. by rewrite /cubic /= !cons_poly_def -!mul_polyC; ring. Qed.
Lemma quarticE a b c d : quartic a b c d = Poly [:: d; c; b; a; 1].
Proof. by rewrite /quartic /= !cons_poly_def -!mul_polyC; ring. Qed.

Theorem hurwitz_2 a b : hurwitz (quadratic a b) <-> 0 < a /\ 0 < b.
Proof.
have := quadraticE a b; move: (quadratic a b) => p /(@monic_of_list p [:: b; a])[size_p _ pos coef_p].
rewrite (routh_hurwitz size_p pos) /= (coef_routh size_p) !coef_p /= mulr0 subr0 andbT.
by split=> [/andP|[-> ->]].
Qed.

Theorem hurwitz_3 a b c : hurwitz (cubic a b c) <-> [/\ 0 < a, 0 < c & c < a * b].
Proof.
have := cubicE a b c; move: (cubic a b c) => p /(@monic_of_list p [:: c; b; a])[size_p lead_p pos coef_p].
rewrite (routh_hurwitz size_p pos) /= (coef_routh size_p) lead_p !coef_p /=.
have [a_gt0|a_le0] := ltP 0 a; last by split=> [|[]].
have nz_2 : p`_2 != 0 by rewrite coef_p /= gt_eqF.
have size_r := size_routh size_p nz_2.
rewrite (coef_routh size_r) (coef_routh size_p) !coef_p /= !mulr0 !subr0 andbT.
rewrite mul1r subr_gt0 mulrC ltr_pdivr_mulr // mulrC.
by split=> [/andP[]|[_ -> ->]].
Qed.

Theorem hurwitz_4 a b c d : hurwitz (quartic a b c d) <->
  [/\ 0 < a, 0 < c, 0 < d & a ^+ 2 * d < c * (a * b - c)].
Proof.
have := quarticE a b c d; move: (quartic a b c d) => p.
case/(@monic_of_list p [:: d; c; b; a])=> size_p lead_p pos coef_p.
rewrite (routh_hurwitz size_p pos) /= (coef_routh size_p) lead_p !coef_p /=.
have [a_gt0|a_le0] := ltP 0 a; last by split=> [|[]].
have nz_3 : p`_3 != 0 by rewrite coef_p /= gt_eqF.
have size_r := size_routh size_p nz_3; have lead_r := lead_routh size_p nz_3.
have pos_r : 0 < lead_coef (routh p) by rewrite lead_r coef_p.
rewrite (coef_routh size_r) lead_r !(coef_routh size_p) lead_p !coef_p /= !mulr0 !subr0 mul1r.
set m := b - a^-1 * c; have Em : a * b - c = a * m by rewrite /m mulrBr mulVKf // gt_eqF.
rewrite Em; have [m_gt0|m_le0] := ltP 0 m; last first.
  split=> // -[_ c_gt0 d_gt0]; rewrite ltNge; case/negP; apply: le_trans (_ : 0 <= _).
    by rewrite mulrCA mulr_ge0_le0 ?mulr_ge0_le0 // ltW.
  by rewrite mulr_ge0 ?exprn_ge0 // ltW.
have nz_m : (routh p)`_2 != 0 by rewrite (coef_routh size_p) lead_p !coef_p /= mul1r gt_eqF.
have size_s := size_routh size_r nz_m.
rewrite (coef_routh size_s) (coef_routh size_r) (coef_routh size_p) !coef_p /= !mulr0 !subr0 andbT.
rewrite subr_gt0 mulrAC ltr_pdivr_mulr // expr2 -mulrA [c * _]mulrCA ltr_pmul2l //.
split=> [/andP[small d_gt0]|[_ _ -> ->]//]; split=> //.
by rewrite -(pmulr_lgt0 _ m_gt0); apply: lt_trans small; rewrite mulr_gt0.
Qed.
End HurwitzInequalities.
