(* (2.9)-(2.15) for every n: the denominator D of the plant cancels in the closed loop, and D D_c -
   N_yu N_c has the degree n + n_c where the loop is well posed. *)
From mathcomp Require Import all_ssreflect all_algebra zify ring.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* The adjugate, and the determinant of a bordered matrix: C adj(M) B + det(M) E. *)
Section Bordered.
Variables (R : idomainType) (n m : nat).
Variables (M : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(m, n)) (E : 'M[R]_m).
Hypothesis nz_M : \det M != 0.

Lemma bordered_determinant :
  \det (C *m \adj M *m B + \det M *: E) * \det M = \det M ^+ m * \det (block_mx M B (- C) E).
Proof.
have product : block_mx M B (- C) E *m block_mx 1%:M (- (\adj M *m B)) 0 (\det M)%:M
    = block_mx M 0 (- C) (C *m \adj M *m B + \det M *: E).
  rewrite mulmx_block !mulmx1 !mulmx0 !addr0 mulmxN mulmxA mul_mx_adj mul_scalar_mx.
  rewrite !mul_mx_scalar addNr mulNmx mulmxN opprK mulmxA; congr block_mx.
have := congr1 determinant product; rewrite det_mulmx det_ublock det_lblock det1 mul1r det_scalar.
by move=> E'; rewrite mulrC -E' mulrC.
Qed.
End Bordered.

Section Order.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B D_1 : 'cV[R]_n) (C E_1 : 'rV[R]_n) (D_0 D_2 E_2 E_0 : R).
Let D := denominator A.

(* Numerators over D = det(qI - A), direct terms included: [N_zw N_zu; N_yw N_yu]. *)
Definition channel (input : 'cV[R]_n) (output : 'rV[R]_n) (direct : R) : {poly R} :=
  numerator A input output + direct%:P * D.
Let N_zw := channel D_1 E_1 E_0.
Let N_zu := channel B E_1 E_2.
Let N_yw := channel D_1 C D_2.
Let N_yu := channel B C D_0.

(* D divides N_zu N_yw - N_zw N_yu: the quotient is minus the determinant of the system matrix. *)
Theorem hidden_factor : exists X, N_zu * N_yw - N_zw * N_yu = D * X.
Proof.
pose M := char_poly_mx A; pose inputs := map_mx polyC (row_mx D_1 B).
pose outputs := map_mx polyC (col_mx E_1 C).
pose direct : 'M[{poly R}]_2 := map_mx polyC (block_mx E_0%:M E_2%:M D_2%:M D_0%:M : 'M_(1 + 1)).
have nz_M : \det M != 0 by apply: char_poly_neq0.
have := bordered_determinant inputs outputs direct nz_M.
set G := _ + _ => bordered; set Y := \det (block_mx _ _ _ _) in bordered.
have channels : G = block_mx N_zw%:M N_zu%:M N_yw%:M N_yu%:M :> 'M_(1 + 1).
  rewrite /G /inputs /outputs /direct map_row_mx map_col_mx map_block_mx mul_col_mx mul_mx_row.
  rewrite mul_mx_row; apply/matrixP=> i j.
  have entry (input : 'cV[R]_n) (output : 'rV[R]_n) a :
      map_mx polyC output *m \adj M *m map_mx polyC input
      + \det M *: map_mx polyC (a%:M : 'M_1) = (channel input output a)%:M.
    apply/matrixP=> i' j'; rewrite !ord1 !mxE eqxx !mulr1n /channel /numerator mulrC.
    by rewrite [in RHS]mxE.
  rewrite [in LHS]mxE [X in _ + X]mxE.
  by rewrite -(entry D_1 E_1) -(entry B E_1) -(entry D_1 C) -(entry B C);
    rewrite !mxE; case: splitP => ? _; rewrite !mxE; case: splitP => ? _; rewrite !mxE.
have : \det G = D * Y.
  have nz_D : D != 0 by [].
  apply: (mulIf nz_D); rewrite -/D in bordered; rewrite [LHS]bordered expr2.
  by rewrite -[\det M]/D; ring.
have -> : \det G = N_zw * N_yu - N_zu * N_yw.
  rewrite channels (expand_det_row _ 0) !big_ord_recl big_ord0 /cofactor !det_mx11 !mxE.
  admit.
by move=> E; exists (- Y); rewrite mulrN -E opprB.
Admitted.
End Order.
