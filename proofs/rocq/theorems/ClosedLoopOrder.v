(* (2.9)-(2.15) for every n: the denominator D of the plant cancels in the closed loop, and D D_c -
   N_yu N_c has the degree n + n_c where the loop is well posed. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* The adjugate, and the determinant of a bordered matrix: C adj(M) B + det(M) E. *)
Section Bordered.
Variables (R : idomainType) (n m : nat).
Variables (M : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(m, n)) (E : 'M[R]_m).

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
have := @bordered_determinant _ _ _ M inputs outputs direct.
set G := _ + _ => bordered; set Y := \det (block_mx _ _ _ _) in bordered.
have channels : G = matrix_2 N_zw N_zu N_yw N_yu.
  rewrite /G /inputs /outputs /direct map_row_mx map_col_mx map_block_mx mul_col_mx mul_col_row.
  rewrite scale_block_mx add_block_mx.
  have entry (input : 'cV[R]_n) (output : 'rV[R]_n) a :
      map_mx polyC output *m \adj M *m map_mx polyC input
      + \det M *: map_mx polyC (a%:M : 'M_1) = (channel input output a)%:M.
    apply/matrixP=> i' j'; rewrite !ord1 /channel /numerator [RHS]mxE eqxx mulr1n.
    by rewrite [LHS]mxE; congr (_ + _); rewrite !mxE eqxx mulr1n mulrC.
  rewrite !entry; apply/matrixP=> i j; rewrite [LHS]mxE.
  by case: splitP => i' Ei; rewrite [LHS]mxE; case: splitP => j' Ej;
    rewrite !mxE Ei Ej !ord1 /= ?mulr1n.
have nz_D : D != 0 by [].
have same : \det G = D * Y.
  apply: (mulIf nz_D); rewrite [LHS]bordered -/D.
  by rewrite -[\det M]/D expr2 mulrAC.
exists (- Y); rewrite mulrN -same channels det_2.
by rewrite opprB.
Qed.

(* The map from w to z is (N_zw D_c - N_c X) / (D D_c - N_yu N_c), X of hidden_factor: D is gone. *)
Theorem closed_loop_2_11 : exists X, forall D_c N_c : {poly R},
  N_zw * (D * D_c - N_yu * N_c) + N_zu * N_c * N_yw = D * (N_zw * D_c + N_c * X).
Proof.
have [X E] := hidden_factor; exists X => D_c N_c.
have -> : D * (N_zw * D_c + N_c * X) = D * N_zw * D_c + N_c * (D * X).
  by rewrite mulrDr mulrA [D * (N_c * X)]mulrCA.
by rewrite -E; move: N_zw N_zu N_yw N_yu D => a b c e f; ring.
Qed.

(* n + n_c poles: of the coefficient of q^(n + n_c) in D D_c - N_yu N_c, which is 1 minus the product
   of the direct terms. It is 0 where the loop is not well posed. *)
Theorem closed_loop_order n_c (D_c N_c : {poly R}) :
  D_c \is monic -> degree_is D_c n_c -> degree_at_most N_c n_c ->
  degree_at_most (D * D_c - N_yu * N_c) (n + n_c) /\
  (degree_is (D * D_c - N_yu * N_c) (n + n_c) <-> D_0 * N_c`_n_c != 1).
Proof.
move=> monic_c deg_c deg_N.
have deg_yu : degree_at_most N_yu n.
  rewrite (leq_trans (size_add _ _)) // geq_max (leq_trans (numerator_strictly_proper _ _ _)) //=.
  by rewrite mul_polyC (leq_trans (size_scale_leq _ _)) // size_char_poly.
have deg_D : degree_is (D : {poly R}) n by rewrite size_char_poly.
have wide : degree_at_most (D * D_c - N_yu * N_c) (n + n_c).
  rewrite (leq_trans (size_add _ _)) // size_opp geq_max.
  by rewrite !(leq_trans (size_mul_leq _ _)) // ?deg_D ?deg_c;
    move: (size N_yu) (size N_c) deg_yu deg_N; lia.
have lead : (D * D_c - N_yu * N_c)`_(n + n_c) = 1 - D_0 * N_c`_n_c.
  have top (p q : {poly R}) : degree_at_most p n -> degree_at_most q n_c ->
      (p * q)`_(n + n_c) = p`_n * q`_n_c.
    move=> deg_p deg_q; rewrite coefM (bigD1 (Ordinal (leq_addr n_c n : n < (n + n_c).+1)%N)) //=.
    rewrite addKn big1 ?addr0 // => i ne; have [below|above|same] := ltngtP i n.
    - rewrite [q`__]nth_default ?mulr0 // (leq_trans deg_q) //.
      by move: (i : nat) below => k; move: (order) => m; lia.
    - by rewrite nth_default ?mul0r // (leq_trans deg_p).
    by case/eqP: ne; apply: val_inj.
  have monic_1 (p : {poly R}) m : p \is monic -> degree_is p m -> p`_m = 1.
    by move=> monic_p deg_p; move: monic_p; rewrite monicE lead_coefE deg_p => /eqP.
  rewrite coefB !top ?deg_D ?deg_c // (monic_1 D) ?char_poly_monic // (monic_1 D_c) // mulr1.
  congr (_ - _ * _); rewrite coefD nth_default ?numerator_strictly_proper // add0r.
  by rewrite mul_polyC coefZ (monic_1 D) ?char_poly_monic // mulr1.
split=> //; split=> [deg|other].
  apply/eqP=> E; have : lead_coef (D * D_c - N_yu * N_c) = 0.
    by rewrite lead_coefE deg /= lead E subrr.
  by move/eqP; rewrite lead_coef_eq0 => /eqP zero; move: deg; rewrite zero size_poly0.
apply/eqP; rewrite eqn_leq wide ltnNge; apply/negP=> short.
by move: other; rewrite eq_sym -subr_eq0 -lead nth_default ?eqxx.
Qed.
End Order.
