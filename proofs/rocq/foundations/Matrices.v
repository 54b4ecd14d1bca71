(* Facts about determinants and characteristic polynomials that MathComp 1.15 does not have. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section CharacteristicPolynomials.
Variable R : idomainType.

Lemma char_poly_neq0 n (A : 'M[R]_n) : \det (char_poly_mx A) != 0.
Proof. by rewrite -/(char_poly A) monic_neq0 // char_poly_monic. Qed.

(* Similar matrices; T need not be inverted. *)
Lemma char_poly_similar n (T A A' : 'M[R]_n) :
  \det T != 0 -> T *m A = A' *m T -> char_poly A = char_poly A'.
Proof.
move=> nz_T similar.
have : map_mx polyC T *m char_poly_mx A = char_poly_mx A' *m map_mx polyC T.
  by rewrite mulmxBr mulmxBl -!map_mxM similar scalar_mxC.
move/(congr1 determinant); rewrite !det_mulmx mulrC => /mulIf; apply.
by rewrite det_map_mx polyC_eq0.
Qed.

Lemma char_poly_upper n m (A : 'M[R]_n) B (D : 'M[R]_m) :
  char_poly (block_mx A B 0 D) = char_poly A * char_poly D.
Proof.
rewrite /char_poly /char_poly_mx map_block_mx scalar_mx_block opp_block_mx.
by rewrite add_block_mx map_mx0 oppr0 addr0 det_ublock.
Qed.

Lemma char_poly_tr n (A : 'M[R]_n) : char_poly A^T = char_poly A.
Proof.
rewrite /char_poly -[in RHS]det_tr; congr (\det _).
by rewrite /char_poly_mx linearB /= tr_scalar_mx map_trmx.
Qed.

(* det(M + u v) = det M + v adj(M) u, with W = adj M. *)
Lemma det_rank_one n (M W : 'M[R]_n) (u : 'cV_n) (v : 'rV_n) :
  \det M != 0 -> W *m M = (\det M)%:M ->
  \det (M + u *m v) = \det M + (v *m W *m u) 0 0.
Proof.
set d := \det M => nz_d adjoint.
have right : block_mx M (- u) v 1%:M *m block_mx 1%:M 0 (- v) (1%:M : 'M_1)
           = block_mx (M + u *m v) (- u) 0 1%:M.
  by rewrite mulmx_block !mulmx1 !mulmx0 !mul1mx mulNmx mulmxN opprK !add0r addrN.
have left : block_mx 1%:M 0 (- (v *m W)) (d%:M : 'M_1) *m block_mx M (- u) v 1%:M
          = block_mx M (- u) 0 (v *m W *m u + d%:M).
  rewrite mulmx_block !mul1mx !mul0mx !addr0 mulmx1; congr block_mx.
    by rewrite mulNmx -mulmxA adjoint mul_mx_scalar mul_scalar_mx addNr.
  by rewrite mulNmx mulmxN opprK.
move: (congr1 determinant right) (congr1 determinant left).
rewrite !det_mulmx !det_lblock !det_ublock !det1 !mul1r !mulr1 det_scalar1 => -> middle.
apply: (mulfI nz_d); rewrite middle -/d; congr (_ * _).
by rewrite det_mx11 mxE [X in _ + X]mxE eqxx mulr1n addrC.
Qed.
End CharacteristicPolynomials.

Section Numerators.
Variable R : idomainType.

(* A rank-one change of A subtracts the numerator from the characteristic polynomial. *)
Lemma char_poly_rank_one n (A : 'M[R]_n) (B : 'cV_n) (C : 'rV_n) :
  char_poly (A + B *m C) = char_poly A - numerator A B C.
Proof.
have -> : char_poly (A + B *m C) =
   \det (char_poly_mx A + (- map_mx polyC B) *m map_mx polyC C).
  by rewrite /char_poly /char_poly_mx map_mxD map_mxM mulNmx opprD addrA.
rewrite (@det_rank_one _ _ _ (\adj (char_poly_mx A))) ?char_poly_neq0 ?mul_adj_mx //.
by rewrite mulmxN mxE.
Qed.

Lemma numeratorE n (A : 'M[R]_n) (B : 'cV_n) (C : 'rV_n) :
  numerator A B C = char_poly A - char_poly (A + B *m C).
Proof. by rewrite char_poly_rank_one opprB addrC subrK. Qed.

Lemma numerator_strictly_proper n (A : 'M[R]_n) (B : 'cV_n) (C : 'rV_n) :
  degree_below (numerator A B C) n.
Proof.
apply/leq_sizeP=> j; rewrite numeratorE leq_eqVlt => /orP[/eqP<-|above]; rewrite coefB.
  have := char_poly_monic A; have := char_poly_monic (A + B *m C).
  by rewrite !monicE !lead_coefE !size_char_poly /= => /eqP-> /eqP->; rewrite subrr.
by rewrite !nth_default ?subrr // size_char_poly.
Qed.

Lemma numerator_similar n (T A A' : 'M[R]_n) (B B' : 'cV_n) (C C' : 'rV_n) :
  \det T != 0 -> T *m A = A' *m T -> T *m B = B' -> C' *m T = C ->
  numerator A B C = numerator A' B' C'.
Proof.
move=> nz_T similar inputs outputs.
rewrite !numeratorE (char_poly_similar nz_T similar); congr (_ - _).
apply: (char_poly_similar nz_T).
by rewrite mulmxDr mulmxDl similar -outputs -inputs !mulmxA.
Qed.

Lemma numerator_tr n (A : 'M[R]_n) (B : 'cV_n) (C : 'rV_n) :
  numerator A^T C^T B^T = numerator A B C.
Proof. by rewrite !numeratorE char_poly_tr -trmx_mul -linearD /= char_poly_tr. Qed.
End Numerators.
