(* Parity interlacing: a plant that a stable compensator stabilises has between two of its real zeros
   outside the region of stability an even number of real poles, each as often as it counts; infinity is a
   zero of a strictly proper plant. The necessary half, over a real closed field. Nothing is asked of the loop
   or the compensator but that they have no roots on the segment: it may lie in the right half plane, outside
   the unit circle, or anywhere else. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import HighAuthorityPoles.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section ParityInterlacing.
Variable R : rcfType.
Implicit Types (p q D N D_c N_c : {poly R}) (s : seq R) (a b r t x z : R).
Local Notation linear s := (\prod_(r <- s) ('X - r%:P) : {poly R}).

(* s lists the real roots of p in ]a, b[, or above a, each as often as it counts; none is an end. *)
Definition roots_between p a b s := exists q,
  [/\ p = linear s * q, forall r, r \in s -> a < r < b & forall x, a <= x <= b -> ~~ root q x].
Definition roots_above p a s := exists q,
  [/\ p = linear s * q, forall r, r \in s -> a < r & forall x, a <= x -> ~~ root q x].

Lemma positive_parity s (t : R) : 0 < (-1) ^+ size s * t -> 0 < t -> ~~ odd (size s).
Proof.
move=> signed positive; move: signed; rewrite pmulr_lgt0 // -signr_odd.
by case: (odd _); rewrite // expr1 oppr_gt0 ltr10.
Qed.

Lemma sign_of_linear a b s : (forall r, r \in s -> a < r < b) ->
  0 < (-1) ^+ size s * ((linear s).[a] * (linear s).[b]).
Proof.
elim: s => [|r s IH] inside; first by rewrite !big_nil !hornerC expr0 !mul1r ltr01.
have /andP[a_r r_b] := inside r (mem_head _ _).
have {}IH := IH (fun t t_s => inside t (mem_behead (s := r :: s) t_s)).
rewrite !big_cons !hornerM !hornerXsubC exprS.
have first : 0 < (r - a) * (b - r) by rewrite mulr_gt0 ?subr_gt0.
have := mulr_gt0 first IH; move: (_ ^+ _) (linear s).[a] (linear s).[b] => e u v.
by congr (0 < _); ring.
Qed.

Lemma sign_above a s : (forall r, r \in s -> a < r) -> 0 < (-1) ^+ size s * (linear s).[a].
Proof.
elim: s => [|r s IH] above; first by rewrite big_nil hornerC mulr1 expr0 ltr01.
have {}IH := IH (fun t t_s => above t (mem_behead (s := r :: s) t_s)).
rewrite big_cons hornerM hornerXsubC exprS mulrACA mulr_gt0 // mulN1r opprB subr_gt0.
exact/above/mem_head.
Qed.

(* Without roots on a segment, or above a point, the sign stays. *)
Lemma sign_stays q a b : a <= b -> (forall x, a <= x <= b -> ~~ root q x) -> 0 < q.[a] * q.[b].
Proof.
move=> a_b none; have ends : q.[a] * q.[b] != 0 by rewrite mulf_neq0 // -rootE none ?lexx ?a_b.
rewrite lt_neqAle eq_sym ends leNgt; apply/negP=> negative.
have [|x] := @ivt_sign R q a b a_b; first by rewrite -sgrM ltr0_sg.
by rewrite in_itv /= => /andP[/ltW ax /ltW xb]; apply/negP; rewrite none // ax.
Qed.

Lemma sign_at_infinity q a : (forall x, a <= x -> ~~ root q x) -> 0 < q.[a] * lead_coef q.
Proof.
move=> none; have nz : q.[a] != 0 by rewrite -rootE none.
have E : Num.sg q.[a] = Num.sg (lead_coef q).
  have := @sgp_pinftyP R a q; rewrite /sgp_pinfty; apply; last by rewrite in_itv /= lexx.
  by move=> x; rewrite in_itv /= andbT; apply: none.
by rewrite -sgr_gt0 sgrM -E -expr2 sqr_sg nz ltr01.
Qed.

Lemma even_between p a b s : a <= b -> roots_between p a b s -> 0 < p.[a] * p.[b] -> ~~ odd (size s).
Proof.
move=> a_b [q [-> inside none]]; rewrite !hornerM mulrACA (pmulr_lgt0 _ (sign_stays a_b none)).
exact/positive_parity/sign_of_linear.
Qed.

Lemma even_above p a s : roots_above p a s -> 0 < p.[a] * lead_coef p -> ~~ odd (size s).
Proof.
move=> [q [-> above none]]; rewrite hornerM lead_coefM.
rewrite (monicP (monic_prod _ (fun r _ => monicXsubC r))) mul1r -mulrA.
rewrite (pmulr_lgt0 _ (sign_at_infinity none)); exact/positive_parity/sign_above.
Qed.

Theorem parity_interlacing D N D_c N_c z_1 z_2 s : z_1 <= z_2 -> root N z_1 -> root N z_2 ->
  (forall x, z_1 <= x <= z_2 -> ~~ root D_c x) ->
  (forall x, z_1 <= x <= z_2 -> ~~ root (closed_loop_polynomial D N D_c N_c) x) ->
  roots_between D z_1 z_2 s -> ~~ odd (size s).
Proof.
move=> z_12 /rootP zero_1 /rootP zero_2 /(sign_stays z_12) compensator /(sign_stays z_12) loop between.
apply: (even_between z_12 between); move: loop.
by rewrite /closed_loop_polynomial !hornerE zero_1 zero_2 !mul0r !addr0 mulrACA pmulr_lgt0.
Qed.

Theorem parity_interlacing_at_infinity D N D_c N_c z s : root N z ->
  (size N < size D)%N -> (size N_c <= size D_c)%N ->
  (forall x, z <= x -> ~~ root D_c x) ->
  (forall x, z <= x -> ~~ root (closed_loop_polynomial D N D_c N_c) x) ->
  roots_above D z s -> ~~ odd (size s).
Proof.
move=> /rootP zero strictly_proper proper /sign_at_infinity compensator /sign_at_infinity loop above.
have nz_c : D_c != 0 by apply: contraTneq compensator => ->; rewrite lead_coef0 mulr0 ltxx.
have nz_D : D != 0 by rewrite -size_poly_gt0 (leq_ltn_trans _ strictly_proper).
apply: (even_above above); move: loop.
rewrite /closed_loop_polynomial !hornerE zero lead_coefDl; last first.
  rewrite (leq_ltn_trans (size_mul_leq _ _)) // size_mul //.
  move: strictly_proper proper nz_c; rewrite -size_poly_gt0.
  by move: (size N) (size D) (size N_c) (size D_c) => [|?] ? ? [|?]; lia.
by rewrite lead_coefM mul0r addr0 mulrACA pmulr_lgt0.
Qed.

(* From a positive zero through infinity to a negative one, as discrete time has it: the roots beyond are
   those of the reversed polynomials between. *)
Lemma reversed_loop n n_c D N D_c N_c : degree_at_most D n -> degree_at_most N n ->
  degree_at_most D_c n_c -> degree_at_most N_c n_c ->
  reversed (n + n_c) (closed_loop_polynomial D N D_c N_c)
  = closed_loop_polynomial (reversed n D) (reversed n N) (reversed n_c D_c) (reversed n_c N_c).
Proof.
move=> deg_D deg_N deg_Dc deg_Nc; rewrite /closed_loop_polynomial -!reversed_mul //.
by apply/polyP=> i; rewrite coefD !coef_poly coefD; case: ifP; rewrite ?addr0.
Qed.

Lemma root_of_reversed n p x : degree_is p n -> (x != 0 -> ~~ root p x^-1) -> ~~ root (reversed n p) x.
Proof.
move=> deg_p none; have [->|nz_x] := eqVneq x 0.
  by rewrite rootE reversed_0 -[n]/(n.+1.-1) -deg_p -lead_coefE lead_coef_eq0 -size_poly_gt0 deg_p.
by rewrite rootE reversed_at ?deg_p // mulf_eq0 expf_eq0 (negPf nz_x) andbF /= -rootE none.
Qed.

Theorem parity_interlacing_through_infinity n n_c D N D_c N_c z_1 z_2 s : 0 < z_1 -> z_2 < 0 ->
  root N z_1 -> root N z_2 -> degree_is D n -> degree_at_most N n -> degree_is D_c n_c ->
  degree_at_most N_c n_c -> degree_is (closed_loop_polynomial D N D_c N_c) (n + n_c)%N ->
  (forall x, z_1 <= x \/ x <= z_2 -> ~~ root D_c x) ->
  (forall x, z_1 <= x \/ x <= z_2 -> ~~ root (closed_loop_polynomial D N D_c N_c) x) ->
  roots_between (reversed n D) z_2^-1 z_1^-1 s -> ~~ odd (size s).
Proof.
move=> z1_gt0 z2_lt0 zero_1 zero_2 deg_D deg_N deg_Dc deg_Nc deg_L none_c none_L.
have zero z : z != 0 -> root N z -> root (reversed n N) z^-1.
  by move=> nz /rootP root_z; rewrite rootE reversed_at ?invr_eq0 // invrK root_z mulr0.
have beyond x : z_2^-1 <= x <= z_1^-1 -> x != 0 -> z_1 <= x^-1 \/ x^-1 <= z_2.
  case/andP=> low high nz; have [x_gt0|x_le0] := ltP 0 x.
    by left; rewrite -[z_1]invrK lef_pinv ?posrE ?invr_gt0.
  by right; rewrite -[z_2]invrK lef_ninv ?negrE ?invr_lt0 // lt_neqAle nz.
apply: (parity_interlacing _ _ _ (D_c := reversed n_c D_c) (N_c := reversed n_c N_c) (N := reversed n N)).
- by apply: ltW; apply: lt_trans (_ : 0 < _); rewrite ?invr_lt0 ?invr_gt0.
- by apply: zero => //; rewrite lt_eqF.
- by apply: zero => //; rewrite gt_eqF.
- by move=> x inside; apply: root_of_reversed => // nz; apply/none_c/beyond.
move=> x inside; rewrite -reversed_loop ?deg_D ?deg_Dc //.
by apply: root_of_reversed => // nz; apply/none_L/beyond.
Qed.

(* The lists exist. *)
Lemma roots_between_exist p a b : p != 0 -> ~~ root p a -> ~~ root p b ->
  exists s, roots_between p a b s.
Proof.
have [k] := ubnP (size p); elim: k p => // k IH p; rewrite ltnS => small nz_p end_a end_b.
case E: (roots p a b) => [|r t].
  exists [::], p; rewrite big_nil mul1r; split=> // x /andP[ax xb]; apply/negP=> root_x.
  have : x \in roots p a b; last by rewrite E.
  rewrite in_roots root_x nz_p andbT in_itv /= !lt_neqAle ax xb !andbT.
  by apply/andP; split; [apply: contraTneq root_x => <- | apply: contraTneq root_x => ->].
have : r \in roots p a b by rewrite E mem_head.
rewrite in_roots in_itv => /and3P[/factor_theorem[q Eq] inside _].
have nz_q : q != 0 by apply: contraNneq nz_p => q0; rewrite Eq q0 mul0r.
move: end_a end_b; rewrite Eq !rootM !negb_or => /andP[qa _] /andP[qb _].
have [||//|//|s [t' [Et in_s none]]] := IH q.
- by apply: leq_trans small; rewrite Eq size_Mmonic ?monicXsubC // size_XsubC addn2.
- by [].
exists (r :: s), t'; split=> //; first by rewrite big_cons Et; ring.
by move=> r'; rewrite inE => /orP[/eqP->|/in_s].
Qed.

Lemma roots_above_exist p a : p != 0 -> ~~ root p a -> exists s, roots_above p a s.
Proof.
move=> nz_p end_a; pose b := Num.max (a + 1) (cauchy_bound p).
have a_b : a < b by rewrite lt_maxr ltr_addl ltr01.
have beyond x : b <= x -> ~~ root p x.
  rewrite le_maxl => /andP[ax bound]; apply: (@ge_cauchy_bound R p nz_p x).
  by rewrite in_itv /= andbT.
have [s [q [Ep inside none]]] := roots_between_exist nz_p end_a (beyond b (lexx b)).
exists s, q; split=> // [r /inside/andP[]//|x a_x]; have [b_x|x_b] := leP b x.
  by have := beyond x b_x; rewrite Ep rootM negb_or => /andP[].
by rewrite none // a_x ltW.
Qed.
End ParityInterlacing.
