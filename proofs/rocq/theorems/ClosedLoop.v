(* The closed loop's characteristic polynomial, and its two factors where the compensator is
   observer-based: (7.14)-(7.18), (7.22)-(7.23), (A.11)-(A.12). *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section AnyNumberOfSignals.
Variables (R : idomainType) (n m p : nat).
Variables (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)).
Variables (K : 'M[R]_(m, n)) (F : 'M[R]_(n, p)).

Definition S_of_7_18 : 'M[R]_(n + n) := block_mx 1%:M 0 1%:M (- 1%:M).

(* (7.18): S A~ = A~' S. *)
Theorem similarity_7_18 :
  S_of_7_18 *m closed_loop A B C (observer_matrix A B C K F) F K
  = block_mx (A + B *m K) (- (B *m K)) 0 (A - F *m C) *m S_of_7_18.
Proof.
rewrite /S_of_7_18 /closed_loop /observer_matrix !mulmx_block.
rewrite !mul1mx !mulmx1 !mul0mx !mulmx0 !addr0 !add0r !mulmxN !mulmx1.
rewrite !mulNmx !mul1mx opprK; congr block_mx; first by rewrite addrK.
by rewrite -addrA addrCA opprD addrA subrr sub0r.
Qed.

Lemma S_of_7_18_is_invertible : \det S_of_7_18 != 0.
Proof. by rewrite det_lblock det1 mul1r -scaleN1r detZ det1 mulr1 signr_eq0. Qed.

(* The spectrum of the closed loop is that of the regulator and that of the observer. *)
Theorem separation :
  char_poly (closed_loop A B C (observer_matrix A B C K F) F K)
  = char_poly (A + B *m K) * char_poly (A - F *m C).
Proof.
rewrite -(char_poly_upper _ (- (B *m K))).
exact: char_poly_similar S_of_7_18_is_invertible similarity_7_18.
Qed.

(* (A.11) with the direct term D_0 from u to y: A_c = A + B C_c - B_c C - B_c D_0 C_c, and the
   loop feeds A_c + B_c D_0 C_c back. B_c is F here, C_c is K. *)
Theorem separation_A_11 (D_0 : 'M[R]_(p, m)) :
  let A_c := A + B *m K - F *m C - F *m D_0 *m K in
  char_poly (block_mx A (B *m K) (F *m C) (A_c + F *m D_0 *m K))
  = char_poly (A + B *m K) * char_poly (A - F *m C).
Proof. by rewrite /= subrK -separation. Qed.
End AnyNumberOfSignals.

Section ScalarSignals.
Variable R : idomainType.

(* (7.23). The minus sign of N_c is what (7.3)-(7.4), u = +C_c x_c, makes of it. *)
Theorem closed_loop_7_23 n n_c (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n)
    (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c) :
  char_poly (closed_loop A B C A_c B_c C_c)
  = closed_loop_polynomial (denominator A) (numerator A B C)
      (denominator A_c) (- numerator A_c B_c C_c).
Proof.
pose b := map_mx polyC B; pose c := map_mx polyC C.
pose b_c := map_mx polyC B_c; pose c_c := map_mx polyC C_c.
pose M := char_poly_mx A; pose M_c := char_poly_mx A_c.
(* the loop is a block triangular matrix and a matrix of rank one *)
have split_loop : char_poly_mx (closed_loop A B C A_c B_c C_c)
   = block_mx M 0 (- (b_c *m c)) M_c + col_mx (- b) 0 *m row_mx 0 c_c.
  rewrite mul_col_row !mulmx0 !mul0mx mulNmx add_block_mx !addr0 add0r.
  rewrite /closed_loop /char_poly_mx map_block_mx !map_mxM /= scalar_mx_block opp_block_mx.
  by rewrite add_block_mx !add0r.
pose d := \det M; pose d_c := \det M_c.
pose W := block_mx (d_c *: \adj M) 0 (\adj M_c *m (b_c *m c) *m \adj M) (d *: \adj M_c).
have det_triangular : \det (block_mx M 0 (- (b_c *m c)) M_c) = d * d_c by rewrite det_lblock.
rewrite {1}/char_poly split_loop (@det_rank_one _ _ _ W) ?det_triangular.
- rewrite /W mul_row_block !mul0mx !add0r mul_row_col mulmx0 addr0 mulmxN.
  rewrite mxE /closed_loop_polynomial mulrN; congr (_ - _).
  have -> : c_c *m (\adj M_c *m (b_c *m c) *m \adj M) *m b
    = (c_c *m \adj M_c *m b_c) *m (c *m \adj M *m b) by rewrite !mulmxA.
  by rewrite mxE big_ord1 mulrC.
- by rewrite mulf_neq0 // char_poly_neq0.
rewrite /W mulmx_block !mul0mx !mulmx0 !add0r addr0 -!scalemxAl !mul_adj_mx.
rewrite -/d -/d_c mulmxN scalerN -[_ *m \adj M *m M]mulmxA mul_adj_mx -/d.
rewrite mul_mx_scalar subrr scalar_mx_block !scale_scalar_mx.
by rewrite [d_c * d]mulrC.
Qed.

(* Both together: (7.23) of an observer-based compensator is a product. *)
Corollary separation_7_23 n (A : 'M[R]_n) (B F : 'cV[R]_n) (C K : 'rV[R]_n) :
  let A_c := observer_matrix A B C K F in
  closed_loop_polynomial (denominator A) (numerator A B C)
    (denominator A_c) (- numerator A_c F K)
  = char_poly (A + B *m K) * char_poly (A - F *m C).
Proof. by move=> A_c; rewrite -separation closed_loop_7_23. Qed.
End ScalarSignals.

(* (7.24): the sensitivity function determines the compensator. *)
Theorem compensator_7_24 (R : fieldType) (G G_c : R) : G != 0 -> 1 + G * G_c != 0 ->
  let S := (1 + G * G_c)^-1 in G_c = (1 - S) / (S * G).
Proof.
move=> nz_G nz_L S; have nz_S : S != 0 by rewrite invr_eq0.
have SL : S * (1 + G * G_c) = 1 by rewrite mulVf.
have E : 1 - S = S * (G * G_c) by rewrite -{1}SL mulrDr mulr1 addrAC subrr add0r.
by apply: (canRL (mulfK _)); rewrite ?mulf_neq0 // E mulrC -mulrA.
Qed.
