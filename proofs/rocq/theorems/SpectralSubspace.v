(* The spectral subspace of a Hamiltonian matrix, H'J = -JH without eigenvalues on the imaginary axis:
   over a real closed field the eigenvalues in one half-plane belong to an invariant subspace of half
   the dimension, on which J vanishes. Its dimension needs no multiplicities: both subspaces are
   isotropic, and together they are everything. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman RealFactors.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section HalfPlanes.
Variable R : rcfType.
Implicit Types p q : {poly R}.
Local Notation toC := (real_complex R).
Local Notation complex_roots p := (root (map_poly toC p)).
Local Notation Re := (@complex.Re R).

(* All zeros in the open half-plane on the left, or on the right. *)
Definition on_the_left p := forall z : R[i], complex_roots p z -> Re z < 0.
Definition on_the_right p := forall z : R[i], complex_roots p z -> 0 < Re z.

Lemma real_divisor p z : complex_roots p z ->
  exists d, [/\ d %| p, (1 < size d)%N & forall w, complex_roots d w -> Re w = Re z].
Proof.
case: z => a b root_z; have [b0|nz_b] := eqVneq b 0; last first.
  have [q [monic_q deg_q divides over_C]] := conjugate_pair nz_b root_z.
  exists q; split=> [//||w]; first by rewrite deg_q.
  by rewrite over_C rootM !root_XsubC => /orP[] /eqP->.
have root_a : root p a by rewrite -(fmorph_root [rmorphism of toC]); move: root_z; rewrite b0.
exists ('X - a%:P); split=> [||w]; rewrite ?dvdp_XsubCl ?size_XsubC //.
by rewrite rmorphB /= map_polyX map_polyC /= root_XsubC => /eqP->.
Qed.

Lemma no_constant_root p z : (size p <= 1)%N -> p != 0 -> ~~ complex_roots p z.
Proof.
move=> /size1_polyC-> ; rewrite polyC_eq0 => nz.
by rewrite map_polyC rootC /= fmorph_eq0.
Qed.

(* Without zeros on the axis a polynomial splits between the half-planes. *)
Lemma half_planes p : p != 0 -> (forall z, complex_roots p z -> Re z != 0) ->
  exists p_l p_r, [/\ p = p_l * p_r, on_the_left p_l & on_the_right p_r].
Proof.
have [m] := ubnP (size p); elim: m p => // m IH p; rewrite ltnS => small nz_p off_axis.
have [constant|nonconstant] := leqP (size p) 1.
  by exists p, 1; rewrite mulr1; split=> // z root_z; [have := no_constant_root z constant nz_p
    | have := no_constant_root z (_ : (size (1%R : {poly R}) <= 1)%N) (oner_neq0 _)];
    rewrite ?size_poly1 ?root_z // => /(_ isT).
have /closed_rootP[z root_z] : size (map_poly toC p) != 1%N by rewrite size_map_poly gtn_eqF.
have [d [/dvdpP[s Ep] large_d same_Re]] := real_divisor root_z.
have nz_s : s != 0 by apply: contraNneq nz_p => s0; rewrite Ep s0 mul0r.
have nz_d : d != 0 by apply: contraNneq nz_p => d0; rewrite Ep d0 mulr0.
have smaller : (size s < m)%N.
  apply: leq_trans small; rewrite Ep size_mul //.
  by move: large_d nz_s; rewrite -size_poly_gt0; move: (size d) (size s); lia.
have [w root_w|s_l [s_r [Es left_s right_s]]] := IH s smaller nz_s.
  by apply: off_axis; rewrite Ep rmorphM rootM root_w.
have := off_axis z root_z; rewrite neq_lt => /orP[negative|positive].
  exists (s_l * d), s_r; split=> [||//]; first by rewrite Ep Es mulrAC.
  by move=> w; rewrite rmorphM rootM => /orP[/left_s //|/same_Re ->].
exists s_l, (s_r * d); split=> [|//|]; first by rewrite Ep Es mulrA.
by move=> w; rewrite rmorphM rootM => /orP[/right_s //|/same_Re ->].
Qed.

(* p(s) and p(-s) are coprime. *)
Lemma coprime_mirrored p : on_the_left p \/ on_the_right p -> coprimep p (p \Po (- 'X)).
Proof.
move=> one_side; rewrite -(coprimep_map [rmorphism of toC]).
apply: Pdiv.ClosedField.root_coprimep => z root_z; apply/negP=> root_mirrored.
have {}root_mirrored : complex_roots p (- z).
  move: root_mirrored; rewrite /= map_comp_poly rmorphN /= map_polyX.
  by rewrite rootE horner_comp hornerN hornerX.
case: one_side => side; have := side _ root_z; have := side _ root_mirrored; rewrite raddfN /=.
  by rewrite oppr_lt0 => /lt_trans h /h; rewrite ltxx.
by rewrite oppr_gt0 => /lt_trans h /h; rewrite ltxx.
Qed.

Lemma coprime_halves p q : on_the_left p -> on_the_right q -> coprimep p q.
Proof.
move=> left_p right_q; rewrite -(coprimep_map [rmorphism of toC]).
apply: Pdiv.ClosedField.root_coprimep => z root_p; apply/negP=> root_q.
by have := lt_trans (left_p z root_p) (right_q z root_q); rewrite ltxx.
Qed.
End HalfPlanes.

Section Hamiltonian.
Variables (R : rcfType) (m half : nat).
Variables (H J : 'M[R]_m.+1).
Hypothesis hamiltonian : H^T *m J = - (J *m H).
Hypothesis unit_J : J \in unitmx.
Hypothesis even : m.+1 = (half + half)%N.
Hypothesis off_axis : forall z, root (map_poly (real_complex R) (char_poly H)) z -> complex.Re z !=
  0.

Lemma polynomial_of_hamiltonian p : (horner_mx H p)^T *m J = J *m horner_mx H (p \Po (- 'X)).
Proof.
rewrite horner_mx_transpose; elim/poly_ind: p => [|p c IH].
  by rewrite comp_poly0 !rmorph0 mul0mx mulmx0.
rewrite comp_polyD comp_polyM comp_polyX comp_polyC !rmorphD !rmorphM /= !horner_mx_C rmorphN /=.
rewrite !horner_mx_X mulmxDl mulmxDr mul_scalar_mx mul_mx_scalar; congr (_ + _).
by rewrite -!mulmxE -mulmxA hamiltonian mulmxN mulmxA IH !mulmxN mulmxA.
Qed.

Lemma isotropic d p (V : 'M[R]_(m.+1, d)) : coprimep p (p \Po (- 'X)) ->
  horner_mx H p *m V = 0 -> V^T *m J *m V = 0.
Proof.
case/Bezout_eq1_coprimepP=> -[u v] /= bezout zero.
have mirrored : V^T *m J *m horner_mx H (p \Po - 'X) = 0.
  by rewrite -mulmxA -polynomial_of_hamiltonian mulmxA -trmx_mul zero trmx0 mul0mx.
have EV : V = horner_mx H (p \Po - 'X) *m (horner_mx H v *m V).
  have {1}-> : V = horner_mx H (u * p + v * (p \Po - 'X)) *m V by rewrite bezout rmorph1 mul1mx.
  rewrite [v * _]mulrC rmorphD !rmorphM /= mulmxDl -!mulmxE -!mulmxA zero.
  by rewrite mulmx0 add0r.
by rewrite {2}EV [_ *m J *m _]mulmxA mirrored mul0mx.
Qed.

(* Half of the space for each half-plane. *)
Theorem spectral_subspace : exists (V : 'M[R]_(m.+1, half)) Y p,
  [/\ \rank V = half, H *m V = V *m Y, V^T *m J *m V = 0, on_the_right p
    & horner_mx H p *m V = 0].
Proof.
have nz_chi : char_poly H != 0 by rewrite monic_neq0 ?char_poly_monic.
have [p_l [p_r [split_chi left_p right_p]]] := half_planes nz_chi off_axis.
have killed p : horner_mx H p *m (kermxpoly H^T p)^T = 0.
  apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK trmx0 horner_mx_transpose.
  exact: mulmx_ker.
have small p : on_the_left p \/ on_the_right p -> (\rank (kermxpoly H^T p) <= half)%N.
  move=> /coprime_mirrored mirrored; have := isotropic mirrored (killed p); rewrite trmxK.
  move/mulmx0_rank_max; rewrite mxrankMfree ?row_free_unit // mxrank_tr.
  by move: even (\rank _) => -> k; lia.
have whole : (\rank (kermxpoly H^T p_l) + \rank (kermxpoly H^T p_r) = half + half)%N.
  have apart := coprime_halves left_p right_p.
  rewrite -mxrank_disjoint_sum ?mxdirect_kermxpoly // -(kermxpolyM _ apart) -split_chi -even.
  by rewrite /kermxpoly -char_poly_tr Cayley_Hamilton kermx0 mxrank1.
have rank_r : \rank (kermxpoly H^T p_r) = half.
  by have := small _ (or_introl left_p); have := small _ (or_intror right_p); move: whole; lia.
have stable : stablemx (kermxpoly H^T p_r) H^T by apply/comm_mx_stable_kermxpoly/comm_mx_refl.
have [V [Y [rank_V [invariant [N EV]]]]] : exists (V : 'M[R]_(m.+1, half)) Y,
    \rank V = half /\ H *m V = V *m Y /\ exists N, V = (kermxpoly H^T p_r)^T *m N.
  set L := kermxpoly _ _ in stable rank_r *.
  move: (row_base L) (row_base_free L) (eq_row_base L); rewrite rank_r => B free same.
  have /submxP[D ED] : (B <= L)%MS by rewrite same.
  have /submxP[X EX] : (B *m H^T <= B)%MS by rewrite same (eqmxMr H^T same).
  exists B^T, X^T; split; first by rewrite mxrank_tr (eqP free).
  split; last by exists D^T; rewrite ED trmx_mul.
  by rewrite -trmx_mul -EX trmx_mul trmxK.
have killed_V : horner_mx H p_r *m V = 0 by rewrite EV mulmxA killed mul0mx.
exists V, Y, p_r; split=> //.
exact: isotropic (coprime_mirrored (or_intror right_p)) killed_V.
Qed.
End Hamiltonian.
