(* Nonderogatory (cyclic) matrices: those with a vector b such that (M, b) is controllable. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement Coprimeness.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Nonderogatory.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (M : 'M[R]_n) (b : 'cV[R]_n) (p q h : {poly R}).

(* Only the polynomial 0 of degree below n sends a cyclic vector to 0. *)
Lemma cyclic_vector M b h : controllable M b -> degree_below h n ->
  horner_mx M h *m b = 0 -> h = 0.
Proof.
rewrite /controllable -/(row_free _) row_free_unit => invertible deg_h.
rewrite (horner_mx_wide _ deg_h) mulmx_suml.
have -> : \sum_(k < n) h`_k *: M ^+ k *m b = controllability_matrix M b *m \col_k h`_k.
  apply/colP=> i; rewrite summxE [RHS]mxE; apply: eq_bigr => k _.
  by rewrite -scalemxAl !mxE mulrC.
move=> zero; have : \col_(k < n) h`_k = 0 by rewrite -(mulKmx invertible (\col__ _)) zero mulmx0.
move=> /colP coefs; apply/polyP=> k; rewrite coef0.
have [below|above] := ltnP k n; last by rewrite nth_default // (leq_trans deg_h).
by have := coefs (Ordinal below); rewrite !mxE.
Qed.

(* The columns b, M b, ..., M^(d-1) b. *)
Definition orbit M b d : 'M[R]_(n, d) := \matrix_(i, j) (M ^+ j *m b) i 0.

Lemma orbit_mul d M b (c : 'cV[R]_d) :
  orbit M b d *m c = horner_mx M (rVpoly c^T) *m b.
Proof.
rewrite (horner_mx_wide _ (size_poly _ _)) mulmx_suml; apply/colP=> i; rewrite summxE mxE.
by apply: eq_bigr => k _; rewrite coef_rVpoly_ord -scalemxAl !mxE mulrC.
Qed.

Lemma orbit_polynomial M b p d :
  orbit M (horner_mx M p *m b) d = horner_mx M p *m orbit M b d.
Proof.
apply: (can_inj (@trmxK _ _ _)); apply/row_matrixP=> j; rewrite -!tr_col; congr (_^T).
have col_orbit (c : 'cV_n) : col j (orbit M c d) = M ^+ j *m c by apply/colP=> i; rewrite !mxE.
rewrite col_orbit colE -mulmxA -colE col_orbit !mulmxA; congr (_ *m _).
have power : M ^+ j = horner_mx M 'X^j by rewrite rmorphX /= horner_mx_X.
by rewrite power !mulmxE -!rmorphM /= mulrC.
Qed.

Lemma rank_orbit M b p d : controllable M b -> p != 0 -> (d + (size p).-1 <= n)%N ->
  \rank (orbit M (horner_mx M p *m b) d) = d.
Proof.
move=> cyclic nz_p small; rewrite -mxrank_tr; apply/eqP; rewrite -/(row_free _) -kermx_eq0.
apply/eqP/row_matrixP=> i; rewrite row0; set c := row i _.
have : c *m (orbit M (horner_mx M p *m b) d)^T = 0 by rewrite /c -row_mul mulmx_ker row0.
rewrite -{1}[c]trmxK -trmx_mul => /(congr1 trmx); rewrite trmxK trmx0 orbit_mul trmxK.
rewrite mulmxA mulmxE -rmorphM /= => zero.
have : rVpoly c * p = 0.
  apply: (cyclic_vector cyclic) zero; rewrite (leq_trans (size_mul_leq _ _)) //.
  have := size_poly d (fun k => if insub k is Some i then c 0 i else 0).
  rewrite -/(rVpoly c) -subn1; move: nz_p; rewrite -size_poly_gt0.
  by move: (size (rVpoly c)) (size p) small; lia.
move/eqP; rewrite mulf_eq0 (negPf nz_p) orbF => /eqP/(congr1 (@poly_rV _ d)).
by rewrite rVpolyK linear0.
Qed.

(* The kernel of p(M) has dimension at most deg p, for every p. *)
Definition small_kernels M := forall p, p != 0 -> ((size p).-1 <= n)%N ->
  (n - (size p).-1 <= \rank (horner_mx M p))%N.

Theorem nonderogatory_small_kernels M : nonderogatory M -> small_kernels M.
Proof.
case=> b cyclic p nz_p small.
rewrite -(@rank_orbit M b p (n - (size p).-1)) ?subnK //.
by rewrite orbit_polynomial mxrankM_maxl.
Qed.

Lemma small_kernels_transpose M : small_kernels M -> small_kernels M^T.
Proof. by move=> small p nz_p deg_p; rewrite -horner_mx_transpose mxrank_tr small. Qed.

(* A subspace that p(M) sends to 0 and that has dimension deg p is the whole kernel. *)
Theorem kernel_of_polynomial M p d m (V : 'M[R]_(n, d)) (xi : 'M[R]_(n, m)) :
  small_kernels M -> degree_is p d -> (d <= n)%N -> \rank V = d ->
  horner_mx M p *m V = 0 -> horner_mx M p *m xi = 0 -> exists eta, xi = V *m eta.
Proof.
move=> small_M deg_p d_n rank_V zero_V zero_xi.
have nz_p : p != 0 by rewrite -size_poly_gt0 deg_p.
have large : (n - d <= \rank (horner_mx M p))%N.
  by have := small_M p nz_p; rewrite deg_p; apply.
have : (\rank (row_mx V xi) <= d)%N.
  have := mulmx0_rank_max (_ : horner_mx M p *m row_mx V xi = 0).
  rewrite mul_mx_row zero_V zero_xi row_mx0 => /(_ erefl).
  by move: (\rank (horner_mx M p)) (\rank (row_mx V xi)) large; lia.
rewrite -mxrank_tr tr_row_mx -addsmxE => small.
have rank_VT : \rank V^T = d by rewrite mxrank_tr.
have : (V^T + xi^T <= V^T)%MS.
  rewrite -(mxrank_leqif_sup (addsmxSl _ _)) rank_VT eqn_leq small andbT.
  by apply: leq_trans (mxrankS (addsmxSl V^T xi^T)); rewrite rank_VT.
rewrite addsmx_sub => /andP[_ /submxP[D]] /(congr1 trmx).
by rewrite trmxK trmx_mul trmxK => ->; exists D^T.
Qed.

(* Every monic divisor p of the characteristic polynomial belongs to an invariant subspace. *)
Theorem invariant_subspace_of_divisor M p q d : nonderogatory M -> p \is monic ->
  degree_is p d.+1 -> q != 0 -> char_poly M = p * q ->
  exists (V : 'M[R]_(n, d.+1)) X, [/\ \rank V = d.+1, M *m V = V *m X & char_poly X = p].
Proof.
case=> b cyclic monic_p deg_p nz_q factored; pose c := horner_mx M q *m b.
have size_q : (d.+1 + (size q).-1 = n)%N.
  have := congr1 (fun r : {poly R} => size r) factored.
  rewrite size_char_poly size_monicM // deg_p; move: nz_q; rewrite -size_poly_gt0.
  by move: (size q); lia.
exists (orbit M c d.+1), (companion d.+1 p)^T; split.
- by rewrite rank_orbit // size_q.
- apply: (can_inj (@trmxK _ _ _)); rewrite !trmx_mul trmxK; apply/row_matrixP=> i.
  have row_O (j : 'I_d.+1) : row j (orbit M c d.+1)^T = (M ^+ j *m c)^T.
    by apply/rowP=> k; rewrite !mxE.
  rewrite row_mul row_O -trmx_mul mulmxA mulmxE -exprS.
  have [->|not_last] := eqVneq i ord_max.
    rewrite row_companion_last; apply: (can_inj (@trmxK _ _ _)); rewrite trmxK.
    have zero : horner_mx M p *m c = 0.
      by rewrite /c mulmxA mulmxE -rmorphM /= -factored Cayley_Hamilton mul0mx.
    move/eqP: zero; rewrite (horner_mx_monic _ monic_p deg_p) mulmxDl addr_eq0 => /eqP ->.
    rewrite mulmx_suml [RHS]linearN [in RHS]linear_sum /=; congr (- _); apply: eq_bigr => k _.
    by rewrite row_O linearZ /= trmxK -scalemxAl.
  have next : (i.+1 < d.+1)%N by rewrite ltnS ltn_neqAle -ltnS ltn_ord andbT.
  by rewrite (@row_companion_next _ _ _ _ _ i (Ordinal next)) // row_O.
by rewrite char_poly_tr char_poly_companion // deg_p.
Qed.
(* Where g divides the characteristic polynomial of Z and is not constant, g(Z) is singular:
   g(s) I - g(Z) is a multiple of sI - Z. *)
Lemma common_factor_is_singular d (Z : 'M[R]_d.+1) g : g %| char_poly Z -> (1 < size g)%N ->
  \det (horner_mx Z g) = 0.
Proof.
move=> divides nonconstant.
have [Q factor] : exists Q, g%:M - map_mx polyC (horner_mx Z g) = char_poly_mx Z *m Q.
  elim/poly_ind: g {divides nonconstant} => [|g a [Q IH]].
    by exists 0; rewrite [horner_mx Z 0]rmorph0 map_mx0 raddf0 subrr mulmx0.
  exists ('X *: Q + map_mx polyC (horner_mx Z g)).
  have -> : horner_mx Z (g * 'X + a%:P) = Z *m horner_mx Z g + a%:M.
    by rewrite mulrC rmorphD rmorphM /= horner_mx_X horner_mx_C mulmxE.
  rewrite map_mxD map_mxM map_scalar_mx mulmxDr -scalemxAr -IH /char_poly_mx mulmxBl.
  rewrite mul_scalar_mx scalerBr scale_scalar_mx raddfD /= [g * 'X]mulrC.
  by rewrite opprD addrACA subrr addr0 addrA subrK.
set chi := char_poly (horner_mx Z g).
have composed : chi \Po g = char_poly Z * \det Q.
  rewrite -det_mulmx -factor /chi /char_poly -[_ \Po g]/(comp_poly_rmorphism g _) -det_map_mx.
  congr (\det _); rewrite /char_poly_mx map_mxB map_scalar_mx /= comp_polyX; congr (_ - _).
  by apply/matrixP=> i j; rewrite !mxE /= comp_polyC.
have : g %| chi \Po g - chi.[0]%:P.
  rewrite -[X in _ - X](comp_polyC _ g) -linearB /= -{1}[g]comp_polyX dvdp_comp_poly //.
  by rewrite -['X]subr0 -(polyC0 R) dvdp_XsubCl rootE !hornerE subrr.
rewrite dvdp_subr ?composed ?dvdp_mulr // => small.
have : chi.[0] = 0.
  apply: contraTeq small => nz; rewrite gtNdvdp ?polyC_eq0 //.
  by rewrite size_polyC nz.
rewrite horner_coef0 char_poly_det => /eqP.
by rewrite mulf_eq0 signr_eq0 => /eqP.
Qed.
End Nonderogatory.
