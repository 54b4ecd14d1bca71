(* A Hermitian matrix M is positive semidefinite if and only if no coefficient of det(xI + M), a sum of
   principal minors, is negative: over every closed field with an order, where no root need be computed. With
   eigenvalues that are not negative, the Cayley transform of M + tI is stable, and the solution of a Stein
   equation with it is M + tI. At a point of the boundary a transfer matrix is positive real if and only if its
   Cayley transform is bounded real. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Lyapunov StabilisingSolution.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section SemidefiniteMatrices.
Variable C : numClosedFieldType.

(* The square of the length of a vector. *)
Let length2 n (v : 'cV[C]_n) := hermitian_value 1%:M v.

Lemma length2_gt0 n (v : 'cV[C]_n) : v != 0 -> 0 < length2 v.
Proof.
move=> nz; have E : length2 v = \sum_i v i 0 * (v i 0)^*.
  rewrite /length2 /hermitian_value mulmx1 mxE; apply: eq_bigr => i _.
  by rewrite !mxE mulrC.
have nonneg i : 0 <= v i 0 * (v i 0)^* by rewrite mul_conjC_ge0.
rewrite lt_neqAle E sumr_ge0 // andbT eq_sym; apply: contraNneq nz => /eqP.
rewrite psumr_eq0 // => /allP zero; apply/eqP/matrixP=> i j; rewrite ord1 mxE; apply/eqP.
by have := zero i (mem_index_enum i); rewrite mul_conjC_eq0.
Qed.

Lemma hermitian_value_of_eigenvector n (M : 'M[C]_n) (v : 'cV[C]_n) l :
  M *m v = l *: v -> hermitian_value M v = l * length2 v.
Proof.
by move=> Ev; rewrite /length2 /hermitian_value -mulmxA Ev mulmx1 -scalemxAr mxE.
Qed.

Lemma hermitian_value_is_real n (M : 'M[C]_n) (v : 'cV[C]_n) : adjoint M = M ->
  (hermitian_value M v)^* = hermitian_value M v.
Proof.
move=> hermitian; have E : adjoint (adjoint v *m M *m v) = adjoint v *m M *m v.
  by rewrite !adjoint_mul adjointK hermitian mulmxA.
by rewrite /hermitian_value -{2}E !mxE.
Qed.

Lemma eigenvalue_is_real n (M : 'M[C]_n) (v : 'cV[C]_n) l : adjoint M = M -> v != 0 -> M *m v = l *: v ->
  l \is Num.real.
Proof.
move=> hermitian nz Ev; have pos := length2_gt0 nz; apply/CrealP.
have := hermitian_value_is_real v hermitian; rewrite (hermitian_value_of_eigenvector Ev) rmorphM.
have -> : (length2 v)^* = length2 v by apply: CrealP; rewrite ger0_real ?ltW.
by apply: mulIf; rewrite gt_eqF.
Qed.

(* Roots that are not positive. *)
Lemma product_is_nonnegative (rs : seq C) : (forall r, r \in rs -> r <= 0) ->
  forall k, 0 <= (\prod_(r <- rs) ('X - r%:P))`_k.
Proof.
elim: rs => [|r rs IH] left k; first by rewrite big_nil coef1; case: eqP; rewrite ?ler01.
have {}IH := IH (fun t t_rs => left t (mem_behead (s := r :: rs) t_rs)).
rewrite big_cons mulrBl coefB coefXM coefCM -mulNr addr_ge0 ?mulr_ge0 ?oppr_ge0 ?left ?mem_head //.
by case: ifP.
Qed.

Lemma no_positive_root (p : {poly C}) x : p \is monic -> (forall k, 0 <= p`_k) -> 0 < x -> 0 < p.[x].
Proof.
move=> monic nonneg x_gt0; have size_p : (0 < size p)%N by rewrite size_poly_gt0 monic_neq0.
rewrite horner_coef -(prednK size_p) big_ord_recr /= ltr_paddl //.
  by apply: sumr_ge0 => i _; rewrite mulr_ge0 ?nonneg // exprn_ge0 // (ltW x_gt0).
by move: monic; rewrite monicE /lead_coef => /eqP->; rewrite mul1r exprn_gt0.
Qed.

Lemma exchanged (V : zmodType) (a b c d : V) : a - b = c + d -> a - c = b + d.
Proof.
move=> E; apply/eqP; rewrite subr_eq -[a](subrK b) E.
by rewrite [c + d]addrC -addrA [c + b]addrC addrA [d + b]addrC.
Qed.

(* Positive eigenvalues are enough. *)
Section Cayley.
Variables (n : nat) (N : 'M[C]_n.+1).
Hypotheses (hermitian : adjoint N = N).
Hypothesis positive : forall (v : 'cV[C]_n.+1) l, v != 0 -> N *m v = l *: v -> 0 < l.

Lemma positive_eigenvalues_suffice : hermitian_semidefinite N.
Proof.
pose D := 1 + N : 'M_n.+1; have unit_D : D \in unitmx.
  rewrite -unitmx_tr -row_free_unit -kermx_eq0; apply: contraT => /rowV0Pn[w].
  move/sub_kermxP=> zero nz; have nz_t : w^T != 0.
    by rewrite -(inj_eq (can_inj (@trmxK _ _ _))) trmxK trmx0.
  have : N *m w^T = (-1) *: w^T.
    have : D *m w^T = 0 by apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK zero trmx0.
    by rewrite mulmxDl mul1mx scaleN1r => /eqP; rewrite addrC addr_eq0 => /eqP.
  by move/(positive nz_t); rewrite oppr_gt0 ltr10.
pose J := invmx D; pose A := J *m (1 - N).
have adjoint_1 : adjoint (1 : 'M[C]_n.+1) = 1.
  by rewrite /adjoint map_mx1 trmx1.
have hermitian_D : adjoint D = D by rewrite adjoint_add adjoint_1 hermitian.
have hermitian_J : adjoint J = J.
  have E : adjoint J *m D = 1%:M by rewrite -hermitian_D -adjoint_mul mulmxV // -[RHS]adjoint_1.
  by rewrite -[RHS]mul1mx -E mulmxK.
have [D_J J_D] : D *m J = 1%:M /\ J *m D = 1%:M by rewrite mulmxV ?mulVmx.
have commutes : N *m J = J *m N.
  have D_N : D *m N = N *m D by rewrite mulmxDl mulmxDr mul1mx mulmx1.
  by rewrite -[N *m J]mul1mx -J_D -!mulmxA [D *m _]mulmxA D_N -mulmxA D_J mulmx1.
have identity : D *m N *m D = (1 - N) *m N *m (1 - N) + 4%:R *: (N *m N).
  have E : (1 + 'X) * 'X * (1 + 'X) = (1 - 'X) * 'X * (1 - 'X) + 4%:R *: ('X * 'X) :> {poly C}.
    by rewrite scaler_nat; ring.
  have := congr1 (horner_mx N) E; rewrite !(rmorphD, rmorphN, rmorphM, rmorph1, linearZ) /=.
  by rewrite !horner_mx_X.
have A_J : A = (1 - N) *m J by rewrite /A mulmxBr mulmxBl mul1mx mulmx1 commutes.
have adjoint_A : adjoint A = J *m (1 - N).
  rewrite A_J adjoint_mul hermitian_J; congr (_ *m _).
  by rewrite -scaleN1r adjoint_add adjoint_1 adjoint_scale hermitian rmorphN1.
pose T := 2%:R *: (N *m J); have adjoint_T : adjoint T = 2%:R *: (J *m N).
  by rewrite adjoint_scale adjoint_mul hermitian hermitian_J rmorph_nat.
have one_semidefinite : hermitian_semidefinite (1%:M : 'M[C]_n.+1).
  split=> // v; have [->|/length2_gt0/ltW//] := eqVneq v 0.
  by rewrite /hermitian_value mulmx0 mxE.
apply: (stein_hermitian (S := A) _ hermitian (hermitian_congruence T one_semidefinite)); last first.
  rewrite adjoint_T mulmx1 adjoint_A A_J /T -scalemxAl -scalemxAr scalerA -natrM.
  have {1}-> : N = J *m (D *m N *m D) *m J by rewrite !mulmxA J_D mul1mx -mulmxA D_J mulmx1.
  by rewrite identity mulmxDr mulmxDl -scalemxAr -scalemxAl !mulmxA.
move=> z /eigencolumn[v Ev nz_v]; pose u := J *m v; have Ev' : v = D *m u by rewrite mulmxA D_J mul1mx.
have nz_u : u != 0 by apply: contraNneq nz_v => u0; rewrite Ev' u0 mulmx0.
have along : (1 - z) *: u = (1 + z) *: (N *m u).
  have : (1 - N) *m u = z *: (D *m u) by rewrite -Ev' -Ev A_J /u mulmxA.
  rewrite mulmxBl mulmxDl !mul1mx scalerDr scalerBl scalerDl !scale1r; exact: exchanged.
have nz : 1 + z != 0.
  apply: contraNneq nz_u => zero; move: along; rewrite zero scale0r => /eqP.
  have -> : z = -1 by apply/eqP; rewrite -addr_eq0 addrC zero.
  by rewrite opprK -mulr2n scaler_eq0 pnatr_eq0 => /orP[].
pose l := (1 - z) / (1 + z); have l_gt0 : 0 < l.
  by apply: (positive nz_u); rewrite /l mulrC -scalerA along scalerA mulVf // scale1r.
have Ez : z * (1 + l) = 1 - l by rewrite /l; field.
have l_real : l \is Num.real by rewrite gtr0_real.
have pos : 0 < 1 + l by rewrite addr_gt0 ?ltr01.
rewrite -(ltr_pmul2r pos) mul1r -{1}(gtr0_norm pos) -normrM Ez real_ltr_norml ?rpredB ?rpred1 //.
rewrite opprD ltr_add2r (lt_trans (ltrN10 _) ltr01) ltr_add2l /=.
by apply: lt_trans (_ : 0 < _); rewrite ?oppr_lt0.
Qed.
End Cayley.

Theorem semidefinite_by_coefficients n (M : 'M[C]_n) : adjoint M = M ->
  hermitian_semidefinite M <-> forall k, 0 <= (char_poly (- M))`_k.
Proof.
move=> hermitian; have monic := char_poly_monic (- M); split=> [[_ nonneg] k|nonneg].
  have [rs] := closed_field_poly_normal (char_poly (- M)); rewrite (monicP monic) scale1r => E.
  rewrite E; apply: product_is_nonnegative => r r_rs.
  have : root (char_poly (- M)) r by rewrite E root_prod_XsubC.
  move/eigencolumn=> [v Ev nz_v]; have pos := length2_gt0 nz_v.
  have Ev' : M *m v = (- r) *: v by rewrite scaleNr -Ev mulNmx opprK.
  by have := nonneg v; rewrite (hermitian_value_of_eigenvector Ev') pmulr_lge0 // oppr_ge0.
(* no eigenvalue is negative *)
have eigen (v : 'cV[C]_n) l : v != 0 -> M *m v = l *: v -> 0 <= l.
  move=> nz_v Ev; have l_real := eigenvalue_is_real hermitian nz_v Ev.
  rewrite real_leNgt ?real0 //; apply/negP=> l_lt0.
  have := no_positive_root monic nonneg (_ : 0 < - l); rewrite oppr_gt0 => /(_ l_lt0).
  have /rootP-> : root (char_poly (- M)) (- l); last by rewrite ltxx.
  by apply: (root_of_eigencolumn _ nz_v); rewrite mulNmx Ev scaleNr.
split=> // v; case: n M hermitian {monic nonneg} eigen v => [|n'] N hermitian eigen v.
  by rewrite /hermitian_value mxE big_ord0.
have shifted t : 0 < t -> 0 <= hermitian_value N v + t * length2 v.
  move=> t_gt0; have t_real : t \is Num.real by rewrite gtr0_real.
  have hermitian_t : adjoint (N + t%:M) = N + t%:M.
    by rewrite adjoint_add hermitian /adjoint map_scalar_mx tr_scalar_mx (CrealP t_real).
  have [|_ /(_ v)] := @positive_eigenvalues_suffice _ (N + t%:M) hermitian_t.
    move=> w l nz_w Ew; have := eigen w (l - t) nz_w.
    rewrite subr_ge0 => /(_ _)/(lt_le_trans t_gt0); apply.
    by rewrite scalerBl -Ew mulmxDl mul_scalar_mx addrK.
  rewrite hermitian_value_add; congr (_ <= _ + _).
  by rewrite /length2 /hermitian_value mul_mx_scalar mulmx1 -scalemxAl mxE.
have [->|/length2_gt0 pos] := eqVneq v 0; first by rewrite /hermitian_value mulmx0 mxE.
have h_real : hermitian_value N v \is Num.real by apply/CrealP/hermitian_value_is_real.
rewrite real_leNgt ?real0 //; apply/negP=> h_lt0.
have half : hermitian_value N v + - hermitian_value N v / (2%:R * length2 v) * length2 v
    = hermitian_value N v / 2%:R by field; rewrite gt_eqF.
have := shifted (- hermitian_value N v / (2%:R * length2 v)); rewrite half.
by rewrite divr_gt0 ?mulr_gt0 ?oppr_gt0 ?ltr0n // => /(_ isT); rewrite pmulr_lge0 ?invr_gt0 ?ltr0n // (lt_geF h_lt0).
Qed.

(* The values of G and of (G - I)(G + I)^-1 at one point. *)
Theorem positive_real_by_bounded_real n (G : 'M[C]_n) : G + 1%:M \in unitmx ->
  let W := (G - 1%:M) *m invmx (G + 1%:M) in
  hermitian_semidefinite (G + adjoint G) <-> hermitian_semidefinite (1%:M - adjoint W *m W).
Proof.
set D := G + 1%:M => unit_D W; have adjoint_1 : adjoint (1%:M : 'M[C]_n) = 1%:M by rewrite /adjoint map_mx1 trmx1.
have W_D : W *m D = G - 1%:M by rewrite mulmxKV.
have adjoint_sub (M N : 'M[C]_n) : adjoint (M - N) = adjoint M - adjoint N.
  by rewrite -scaleN1r adjoint_add adjoint_scale rmorphN1 scaleN1r.
have E : adjoint D *m (1%:M - adjoint W *m W) *m D = 2%:R *: (G + adjoint G).
  have -> : adjoint D *m (1%:M - adjoint W *m W) *m D = adjoint D *m D - adjoint (W *m D) *m (W *m D).
    by rewrite mulmxBr mulmxBl mulmx1 adjoint_mul !mulmxA.
  rewrite W_D adjoint_sub /D adjoint_add adjoint_1 mulmxDl mulmxBl mulmxDr mulmxBr !mulmx1 !mul1mx.
  have collected (a b c g : 'M[C]_n) : a + b + (g + c) - (a - b - (g - c)) = 2%:R *: (g + b).
    by apply/matrixP=> i j; rewrite !mxE; ring.
  exact: collected.
have half (x : C) : 0 <= 2%:R * x -> 0 <= x by rewrite pmulr_rge0 ?ltr0n.
have value_half x : hermitian_value (2%:R *: (G + adjoint G)) x = 2%:R * hermitian_value (G + adjoint G) x.
  by rewrite /hermitian_value -scalemxAr -scalemxAl mxE.
have hermitian_G : adjoint (G + adjoint G) = G + adjoint G by rewrite adjoint_add adjointK addrC.
have hermitian_W : adjoint (1%:M - adjoint W *m W) = 1%:M - adjoint W *m W.
  by rewrite adjoint_sub adjoint_1 adjoint_mul adjointK.
split=> [[_ nonneg]|bounded]; split=> // x.
  rewrite -[x](mulKVmx unit_D) -hermitian_value_congruence E value_half.
  by rewrite mulr_ge0 ?ler0n.
by apply: half; rewrite -value_half -E; have [_] := hermitian_congruence D bounded; apply.
Qed.
End SemidefiniteMatrices.
