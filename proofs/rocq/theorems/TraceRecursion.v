(* The recursion of Leverrier and Faddeev as a certificate: coefficients c_n-1, ..., c_0 are those of
   det(sI - A) where B_n-1 = 1, B_k-1 = A B_k + c_k, B_-1 = 0 and tr B_k = (k + 1) c_k+1, over a field of
   characteristic 0. Nothing is divided. For sum B_k s^k is then (sI - A)^-1 p, its trace is p', and that of
   (sI - A)^-1 is chi' / chi, so that p' chi = p chi'. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Derivatives.
Variable R : comRingType.

Lemma deriv_product (I : eqType) (r : seq I) (f : I -> {poly R}) : uniq r ->
  (\prod_(i <- r) f i)^`() = \sum_(i <- r) (f i)^`() * \prod_(j <- r | j != i) f j.
Proof.
elim: r => [|i r IH] /=; first by rewrite !big_nil derivC.
case/andP=> i_r uniq_r; rewrite !big_cons derivM IH // eqxx /=; congr (_ * _ + _).
  rewrite big_seq [RHS]big_seq_cond; apply: eq_big => j; last by [].
  by case j_r: (j \in r); rewrite ?andbF //=; apply/esym/eqP => E; move: i_r; rewrite -E j_r.
rewrite mulr_sumr big_seq [RHS]big_seq; apply: eq_bigr => j j_r.
rewrite big_cons; have -> : i != j by apply: contraNneq i_r => ->.
by rewrite mulrCA.
Qed.

(* The derivative of a determinant, where that of the matrix is 1. *)
Lemma deriv_det n (M : 'M[{poly R}]_n) : (forall i j, (M i j)^`() = (i == j)%:R) ->
  (\det M)^`() = \tr (\adj M).
Proof.
move=> deriv_M; pose unit_row i := \matrix_(k, j) (if k == i then (i == j)%:R else M k j).
transitivity (\sum_i \det (unit_row i)); last first.
  apply: eq_bigr => i _; rewrite !mxE (expand_det_row _ i) (bigD1 i) //= big1 => [|j ji]; last first.
    by rewrite !mxE eqxx eq_sym (negPf ji) mul0r.
  rewrite !mxE !eqxx mul1r addr0 /cofactor; congr (_ * \det _).
  by apply/matrixP=> k l; rewrite !mxE eq_sym (negPf (neq_lift _ _)).
rewrite /determinant raddf_sum [RHS]exchange_big; apply: eq_bigr => s _ /=.
have sign (b : bool) (q : {poly R}) : ((-1) ^+ b * q)^`() = (-1) ^+ b * q^`().
  by case: b; rewrite ?expr0 ?expr1 ?mul1r ?mulN1r ?derivN.
rewrite sign deriv_product ?index_enum_uniq // mulr_sumr; apply: eq_bigr => i _; congr (_ * _).
rewrite [RHS](bigD1 i) //= !mxE eqxx deriv_M; congr (_ * _).
by apply: eq_bigr => j ji; rewrite !mxE (negPf ji).
Qed.
End Derivatives.

Section Recursion.
Variables (F : fieldType) (n : nat) (A : 'M[F]_n).
Implicit Types (B : 'M[F]_n) (c : F) (cs : seq F) (p : {poly F}).

(* The certificate, from B_k and c_k+1 on: cs is [:: c_k; ...; c_0]. *)
Fixpoint traces_agree B c cs : bool := if cs is d :: ds
  then (\tr B == c *+ size cs) && traces_agree (A *m B + d%:M) d ds else B == 0.

Lemma deriv_char_poly : (char_poly A)^`() = \tr (\adj (char_poly_mx A)).
Proof.
rewrite /char_poly deriv_det // => i j; rewrite !mxE derivB derivC subr0.
by case: eqP => _; rewrite ?mulr1n ?derivX // mulr0n derivC.
Qed.

(* Q and p are the Horner prefixes of sum B_k s^k and of the polynomial. *)
Lemma traces_invariant cs B c (Q : 'M[{poly F}]_n) p : traces_agree B c cs ->
  char_poly_mx A *m Q = p%:M - map_mx polyC B ->
  \tr Q * 'X^(size cs).+1 = 'X * ('X^(size cs) * (p - c%:P))^`() ->
  exists Q', char_poly_mx A *m Q' = (foldl (fun q d => q * 'X + d%:P) p cs)%:M /\
    \tr Q' = (foldl (fun q d => q * 'X + d%:P) p cs)^`().
Proof.
elim: cs B c Q p => [|d cs IH] B c Q p /=.
  move=> /eqP-> E; rewrite map_mx0 subr0 in E; rewrite expr0 mul1r derivB derivC subr0 expr1 mulrC => T.
  by exists Q; split=> //; apply: (mulfI (negbT (polyX_eq0 _))).
case/andP=> /eqP trace rest E T.
apply: (IH (A *m B + d%:M) d ('X *: Q + map_mx polyC B) _ rest).
  have step : char_poly_mx A *m map_mx polyC B = 'X *: map_mx polyC B - map_mx polyC (A *m B).
    by rewrite /char_poly_mx mulmxBl mul_scalar_mx map_mxM.
  rewrite mulmxDr -scalemxAr E step scalerBr addrA subrK scale_scalar_mx [p * 'X]mulrC.
  by rewrite map_mxD map_scalar_mx /= raddfD /= opprD addrACA subrr addr0.
rewrite addrK linearD /= linearZ /=.
have -> : \tr (map_mx polyC B) = (\tr B)%:P by rewrite /mxtrace raddf_sum; apply: eq_bigr => i _; rewrite mxE.
have -> : 'X^(size cs) * (p * 'X) = 'X^(size cs).+1 * (p - c%:P) + 'X^(size cs).+1 * c%:P.
  by rewrite exprSr; ring.
rewrite derivD mulrDr -T mulrDl; congr (_ + _); first by rewrite [in RHS]exprS mulrA [_ * 'X]mulrC.
rewrite trace polyCMn derivM derivC mulr0 addr0 derivXn /= exprS.
by rewrite mulrnAl mulrnAl mulrnAr; congr (_ *+ _); rewrite [RHS]mulrA mulrC.
Qed.

Hypothesis char0 : [char F] =i pred0.

(* p'chi = p chi' for monic polynomials of one degree leaves p = chi. *)
Lemma same_logarithmic_derivative p q : p \is monic -> q \is monic -> size p = size q ->
  q * p^`() = p * q^`() -> p = q.
Proof.
move=> monic_p monic_q same E; apply/eqP; rewrite -subr_eq0; apply: contraT => nz.
set d := p - q in nz; have nz_q := monic_neq0 monic_q.
have small : (size d < size q)%N.
  have [m size_q] : exists m, size q = m.+1 by exists (size q).-1; rewrite prednK // size_poly_gt0.
  rewrite size_q ltnS; apply/leq_sizeP=> j; rewrite leq_eqVlt => /orP[/eqP<-|large]; rewrite coefB.
    move: monic_p monic_q; rewrite !monicE !lead_coefE same size_q /= => /eqP-> /eqP->.
    by rewrite subrr.
  by rewrite !nth_default ?subrr // ?same size_q.
have E' : q * d^`() = d * q^`() by rewrite derivB mulrBr mulrBl E.
have nat_nz m : m != 0%N -> m%:R != 0 :> F by move=> nz_m; rewrite (proj1 (charf0P F) char0).
have top (r : {poly F}) : (1 < size r)%N -> lead_coef r^`() = lead_coef r *+ (size r).-1.
  move=> large; have nz_r : r != 0 by rewrite -size_poly_gt0; apply: leq_trans large.
  have size_r' : size r^`() = (size r).-1.
    apply/eqP; rewrite eqn_leq; apply/andP; split.
      by rewrite -ltnS prednK ?size_poly_gt0 // lt_size_deriv.
    case Er: (size r) large => [|[|k]] //= _; rewrite ltnNge; apply/negP => /leq_sizeP/(_ k (leqnn k)).
    rewrite coef_deriv -mulr_natr => /eqP; rewrite mulf_eq0 (negPf (nat_nz _ _)) // orbF.
    by have := nz_r; rewrite -lead_coef_eq0 lead_coefE Er /= => /negPf->.
  rewrite !lead_coefE size_r' coef_deriv; case: (size r) large => [|[|k]] //.
have [small_q|large_q] := leqP (size q) 1.
  move: nz; rewrite -size_poly_eq0; have : (size d < 1)%N by apply: leq_trans small small_q.
  by rewrite ltnS leqn0 => ->.
have [const_d|large_d] := leqP (size d) 1.
  have : q^`() == 0.
    have d'0 : d^`() = 0 by rewrite (size1_polyC const_d) derivC.
    by move/eqP: E'; rewrite d'0 mulr0 eq_sym mulf_eq0 (negPf nz).
  rewrite -lead_coef_eq0 top // (monicP monic_q) (negPf (nat_nz _ _)) //.
  by move: large_q; case: (size q) => [|[|]].
have := congr1 (@lead_coef F) E'; rewrite !lead_coefM !top // (monicP monic_q) mul1r.
rewrite -mulr_natr => /eqP; rewrite -subr_eq0 -mulrBr mulf_eq0.
rewrite lead_coef_eq0 (negPf nz) orFb -opprB oppr_eq0 -natrB ?leq_pred2 //; last first.
  by move: small; case: (size q) (size d) => [|a] [|b] //= /ltnW.
by rewrite (negPf (nat_nz _ _)) //; move: small large_d; case: (size q) (size d) => [|a] [|b] //=; lia.
Qed.

Theorem char_poly_by_traces cs : size cs = n -> traces_agree 1%:M 1 cs ->
  char_poly A = foldl (fun q d => q * 'X + d%:P) 1 cs.
Proof.
move=> size_cs /(@traces_invariant cs 1%:M 1 0 1) [||Q [inverse trace]].
- by rewrite mulmx0 map_mx1 subrr.
- by rewrite subrr mulr0 derivC mulr0 linear0 mul0r.
set p := foldl _ _ _ in inverse trace *.
have monic_size ds (q : {poly F}) : q \is monic ->
    foldl (fun q d => q * 'X + d%:P) q ds \is monic /\
    size (foldl (fun q d => q * 'X + d%:P) q ds) = (size q + size ds)%N.
  elim: ds q => [|d ds IH] q monic_q /=; first by rewrite addn0.
  have nz_q := monic_neq0 monic_q.
  have big : size (q * 'X) = (size q).+1 by rewrite size_mulX.
  have lower : (size (d%:P)%R < size (q * 'X)%R)%N.
    by rewrite big ltnS (leq_trans (size_polyC_leq1 _)) // size_poly_gt0.
  have [|monic_r size_r] := IH (q * 'X + d%:P).
    by rewrite monicE lead_coefDl // lead_coefM lead_coefX mulr1 -monicE.
  by split=> //; rewrite size_r size_addl // big addnS addSn.
have [monic_p size_p] : p \is monic /\ size p = n.+1.
  by have [monic_p ->] := monic_size cs 1 (monic1 _); rewrite size_poly1 size_cs.
apply/esym/same_logarithmic_derivative => //; first exact: char_poly_monic.
  by rewrite size_p size_char_poly.
have : char_poly A *: Q = p *: \adj (char_poly_mx A).
  by rewrite -!mul_scalar_mx -mul_adj_mx -mulmxA inverse mul_mx_scalar mul_scalar_mx.
by move/(congr1 (@mxtrace _ _)); rewrite !linearZ /= -deriv_char_poly trace.
Qed.
End Recursion.
