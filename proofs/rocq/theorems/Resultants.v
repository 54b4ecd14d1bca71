(* Theorems A1 and A2, Propositions 3 and 4: the Sylvester resultants, for formal degrees. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import perm.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import Diophantine.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* Row vectors are polynomials: rows of [multiples m d r] are s^i r, i < m, in ascending powers.
   Up to the order of rows and columns the transpose of M_1(a, b) is two such bands. *)
Section Bands.
Variable R : fieldType.
Implicit Types a b g r x : {poly R}.

Lemma size_product (x y : {poly R}) i j m :
  (size x <= i)%N -> (size y <= j)%N -> ((i + j).-1 <= m)%N -> (size (x * y)%R <= m)%N.
Proof.
move=> x_i y_j ij; rewrite (leq_trans (size_mul_leq _ _)) // (leq_trans _ ij) //.
by move: (size x) (size y) x_i y_j; lia.
Qed.

Definition multiples m d r : 'M[R]_(m, d) := lin1_mx (poly_rV \o r \o* rVpoly).
Lemma mul_multiples m d r (v : 'rV_m) : v *m multiples m d r = poly_rV (rVpoly v * r).
Proof. by rewrite mul_rV_lin1. Qed.

Definition bands k l a b : 'M[R]_(l + k) := col_mx (multiples l _ a) (multiples k _ b).

(* The rows of the bands span the multiples of gcd(a, b) of degree below k + l. *)
Theorem rank_bands k l a b : degree_is a k -> degree_at_most b l ->
  \rank (bands k l a b) = (l + k - common_roots a b)%N.
Proof.
move=> deg_a deg_b; have nz_a : a != 0 by rewrite -size_poly_gt0 deg_a.
have [[u v] /= bezout] := Bezoutp a b; set g := u * a + v * b in bezout.
rewrite -(eqp_size bezout); set d := (size g).-1.
have g_a : g %| a by rewrite (eqp_dvdl _ bezout) dvdp_gcdl.
have g_b : g %| b by rewrite (eqp_dvdl _ bezout) dvdp_gcdr.
have nz_g : g != 0 by apply: contraTneq g_a => ->; rewrite dvd0p.
have size_g : size g = d.+1 by rewrite prednK // size_poly_gt0.
have d_k : (d <= k)%N by have := dvdp_leq nz_a g_a; rewrite deg_a size_g.
set a' := a %/ g; set b' := b %/ g.
have Ea : a = a' * g by rewrite divpK.
have Eb : b = b' * g by rewrite divpK.
have size_a' : size a' = (k.+1 - d)%N by rewrite size_divp // deg_a.
have nz_a' : a' != 0 by rewrite -size_poly_gt0 size_a' subn_gt0.
pose G := multiples (l + k - d) (l + k) g.
have rank_G : \rank G = (l + k - d)%N.
  apply/eqP; rewrite -/(row_free G) -kermx_eq0; apply/eqP/row_matrixP=> i.
  rewrite row0; set x := row i _.
  have : x *m G = 0 by rewrite /x -row_mul mulmx_ker row0.
  rewrite mul_multiples => /(congr1 rVpoly); rewrite linear0 poly_rV_K.
    move/eqP; rewrite mulf_eq0 (negPf nz_g) orbF => /eqP /(congr1 (@poly_rV _ (l + k - d))).
    by rewrite rVpolyK linear0.
  by apply: (size_product (size_poly _ _) (eq_leq size_g)); move: d_k; clear; lia.
(* every multiple t g is x a + y b, with y reduced modulo a / g *)
have spanned : (G <= bands k l a b)%MS.
  apply/row_subP=> i; rewrite rowE mul_multiples; set t := rVpoly _.
  have size_t : (size t <= l + k - d)%N by apply: size_poly.
  pose y := (t * v) %% a'; pose q := (t * v) %/ a'; pose x := t * u + q * b'.
  have Et : t * g = x * a + y * b.
    have division : t * v = q * a' + y by apply: divp_eq.
    transitivity (t * u * a + (t * v) * b); first by rewrite /g; ring.
    by rewrite division /x Ea Eb; ring.
  have size_y : (size y < k.+1 - d)%N by rewrite -size_a' ltn_modp.
  have size_yk : (size y <= k)%N by move: size_y; clear; lia.
  have size_x : (size x <= l)%N.
    have [->|nz_x] := eqVneq x 0; first by rewrite size_poly0.
    have : (size (x * a)%R <= l + k)%N.
      rewrite (_ : x * a = t * g - y * b); last by rewrite Et addrK.
      rewrite (leq_trans (size_add _ _)) // geq_max size_opp; apply/andP; split.
        by apply: (size_product size_t (eq_leq size_g)); move: d_k; clear; lia.
      by apply: (size_product size_yk deg_b); clear; lia.
    by rewrite size_mul // deg_a; move: (size x); clear; lia.
  have -> : poly_rV (t * g) = row_mx (poly_rV x) (poly_rV y) *m bands k l a b.
    by rewrite mul_row_col !mul_multiples !poly_rV_K // -linearD Et.
  exact: submxMl.
have spans : (bands k l a b <= G)%MS.
  rewrite /bands col_mx_sub; apply/andP; split; apply/row_subP=> i;
    rewrite rowE mul_multiples; set t := rVpoly _.
    have size_t : (size t <= l)%N by apply: size_poly.
    have -> : poly_rV (t * a) = poly_rV (t * a') *m G.
      rewrite mul_multiples poly_rV_K -?mulrA -?Ea //.
      by apply: (size_product size_t (eq_leq size_a')); move: d_k; clear; lia.
    exact: submxMl.
  have size_t : (size t <= k)%N by apply: size_poly.
  have [b0|nz_b] := eqVneq b 0; first by rewrite b0 mulr0 linear0 sub0mx.
  have d_l : (d <= l)%N by rewrite -ltnS -size_g (leq_trans (dvdp_leq nz_b g_b)).
  have size_b' : (size b' <= l.+1 - d)%N by rewrite size_divp // leq_sub2r.
  have -> : poly_rV (t * b) = poly_rV (t * b') *m G.
    rewrite mul_multiples poly_rV_K -?mulrA -?Eb //.
    by apply: (size_product size_t size_b'); move: d_k d_l; clear; lia.
  exact: submxMl.
by rewrite -rank_G; apply/eqP; rewrite eqn_leq !mxrankS.
Qed.

Lemma bands_above k l a b i j :
  bands k l a b (lshift k i) j = if (i <= j)%N then a`_(j - i) else 0.
Proof. by rewrite col_mxEu !mxE /= rVpoly_delta coefXnM ltnNge; case: leqP. Qed.

Lemma bands_below k l a b i j :
  bands k l a b (rshift l i) j = if (i <= j)%N then b`_(j - i) else 0.
Proof. by rewrite col_mxEd !mxE /= rVpoly_delta coefXnM ltnNge; case: leqP. Qed.
End Bands.

Section Resultants.
Variable R : fieldType.
Implicit Types a b D N : {poly R}.

(* M_1 lists descending powers: both groups of its columns are reversed, and its rows. *)
Definition reversed l k (j : 'I_(l + k)) : 'I_(l + k) :=
  match split j with inl j => lshift k (rev_ord j) | inr j => rshift l (rev_ord j) end.
Lemma reversedK l k : involutive (@reversed l k).
Proof.
move=> j; rewrite /reversed; case: (splitP j) => x Ex.
  have -> : j = lshift k x by apply: val_inj.
  by rewrite (unsplitK (inl _ (rev_ord x))) rev_ordK.
have -> : j = rshift l x by apply: val_inj.
by rewrite (unsplitK (inr _ (rev_ord x))) rev_ordK.
Qed.

Lemma M_1_is_bands k l a b : degree_at_most a k -> degree_at_most b l ->
  M_1 k l a b = row_perm (perm (@rev_ord_inj (l + k)))
     (col_perm (perm (inv_inj (@reversedK l k))) (bands k l a b)^T).
Proof.
move=> deg_a deg_b; apply/matrixP=> i j; rewrite mxE [RHS]mxE [RHS]mxE [RHS]mxE !permE /reversed.
have i_lt := ltn_ord i; case: (splitP j) => x _; have x_lt := ltn_ord x.
  rewrite bands_above /=; case: ifP => [/andP[h1 h2]|outside].
    by rewrite ifT; [congr (_`_ _); lia | lia].
  by case: ifP => // h3; rewrite nth_default // (leq_trans deg_a) //; move: outside h3; lia.
rewrite bands_below /=; case: ifP => [/andP[h1 h2]|outside].
  by rewrite ifT; [congr (_`_ _); lia | lia].
by case: ifP => // h3; rewrite nth_default // (leq_trans deg_b) //; move: outside h3; lia.
Qed.

(* Theorem A1, for every k and l: a_k != 0, and b_l may be 0. "l <= k" of the text is not needed,
   and common roots are counted with multiplicity, in an algebraic closure. *)
Theorem theorem_A1 k l a b : degree_is a k -> degree_at_most b l ->
  (common_roots a b = k + l - \rank (M_1 k l a b))%N /\
  (coprimep a b <-> M_1 k l a b \in unitmx).
Proof.
move=> deg_a deg_b; have rank_M : \rank (M_1 k l a b) = (l + k - common_roots a b)%N.
  rewrite M_1_is_bands ?deg_a // row_permE col_permE.
  rewrite (eqmxMfull _ _) ?row_full_unit ?unitmx_perm //.
  by rewrite mxrankMfree ?row_free_unit ?unitmx_perm // mxrank_tr rank_bands.
have nz_a : a != 0 by rewrite -size_poly_gt0 deg_a.
have at_most_k : (common_roots a b <= k)%N.
  by have := dvdp_leq nz_a (dvdp_gcdl a b); rewrite deg_a; move: (size _); clear; lia.
have nz_gcd : (0 < size (gcdp a b))%N by rewrite size_poly_gt0 gcdp_eq0 negb_and nz_a.
split; first by rewrite rank_M; move: (common_roots a b) at_most_k; clear; lia.
rewrite -row_free_unit /row_free rank_M coprimep_def.
by split=> /eqP size_1; apply/eqP; move: (size _) size_1 nz_gcd at_most_k; clear; lia.
Qed.

(* Theorem A2 is its case l = k. *)
Theorem theorem_A2 k a b : degree_is a k -> degree_at_most b k ->
  (common_roots a b = 2 * k - \rank (M_2 k a b))%N /\
  (coprimep a b <-> M_2 k a b \in unitmx).
Proof. by move=> deg_a deg_b; rewrite mul2n -addnn; apply: theorem_A1. Qed.

(* Proposition 3, the half that is used: for m^_c = n - 1 the matrix of (7.38) is M_1(D, N), N
   with formal degree n_c. m is the degree of N in (7.32); "n_c <= n" is not needed. *)
Theorem proposition_3 n n_c m D N : degree_at_most N m -> (m <= n_c)%N ->
  M_of_7_38 n n_c m n D N = castmx (addnC n_c n, erefl) (M_1 n n_c D N).
Proof.
move=> deg_N m_nc; apply/matrixP=> i j; rewrite castmxE !mxE cast_ord_id /=.
have i_lt := ltn_ord i; case: (splitP j) => // x _; have x_lt := ltn_ord x.
case: ifP => [/andP[h1 h2]|outside].
  by rewrite ifT; [congr (_`_ _); lia | lia].
by case: ifP => // h3; rewrite nth_default // (leq_trans deg_N) //; move: outside h3; lia.
Qed.

(* Proposition 4 is its case n_c = n. *)
Theorem proposition_4 n m D N : degree_at_most N m -> (m <= n)%N ->
  M_of_7_38 n n m n D N = M_2 n D N.
Proof.
move=> deg_N m_n; rewrite (proposition_3 n D deg_N m_n) /M_2.
by rewrite (_ : addnC n n = erefl) ?castmx_id //; apply: eq_irrelevance.
Qed.

(* Only a square M can be a resultant, and M has n + n_c rows and n_c + m^_c + 1 columns. *)
Theorem square_iff n n_c hat_m : (n + n_c = n_c + hat_m.+1 <-> hat_m.+1 = n)%N.
Proof. by split; lia. Qed.

(* M_2(D, N) has 2n of each. *)
Theorem shape_of_M_2 n n_c hat_m :
  (n + n_c = n + n /\ n_c + hat_m.+1 = n + n <-> hat_m.+1 = n /\ n_c = n)%N.
Proof. by split; lia. Qed.

(* Coefficients in descending order, as the columns of (7.37) list them. *)
Definition coefficients d (p : {poly R}) : 'cV[R]_d := \col_i p`_(d - i.+1).

Lemma coef_product l x a m : degree_below x l ->
  (x * a)`_m = \sum_(j < l) x`_(l - j.+1) * (if (l <= m + j.+1)%N then a`_(m + j.+1 - l) else 0).
Proof.
move=> deg_x; have {1}-> : x = \sum_(j < l) x`_(l - j.+1) *: 'X^(l - j.+1).
  rewrite [RHS](reindex_inj rev_ord_inj) /=; apply/polyP=> i; rewrite coef_sum.
  have -> : \sum_(j < l) (x`_(l - (l - j.+1).+1) *: 'X^(l - (l - j.+1).+1) : {poly R})`_i
          = \sum_(j < l) (if i == j :> nat then x`_j else 0).
    apply: eq_bigr => j _; have j_lt := ltn_ord j.
    rewrite coefZ coefXn (_ : l - (l - j.+1).+1 = j)%N; last by lia.
    by case: (i == j :> nat); rewrite ?mulr1 ?mulr0.
  have [below|above] := ltnP i l.
    rewrite (bigD1 (Ordinal below)) //= eqxx big1 ?addr0 // => j /negPf.
    by rewrite -val_eqE /= eq_sym => ->.
  rewrite nth_default ?(leq_trans deg_x) // big1 // => j _.
  by rewrite gtn_eqF // (leq_trans (ltn_ord j)).
rewrite mulr_suml coef_sum; apply: eq_bigr => j _; have j_lt := ltn_ord j.
rewrite -scalerAl coefZ coefXnM; congr (_ * _).
case: ltnP => h; case: ifP => h' //; try by move: h h'; lia.
by congr (_`_ _); lia.
Qed.

(* (7.37) is (7.23): M_1 times the coefficients of D_c and N_c gives those of D D_c + N N_c. *)
Theorem M_1_multiplies k l a b x y : degree_at_most a k -> degree_at_most b l ->
  degree_below x l -> degree_below y k ->
  M_1 k l a b *m col_mx (coefficients l x) (coefficients k y)
  = coefficients (l + k) (a * x + b * y).
Proof.
move=> deg_a deg_b deg_x deg_y; apply/colP=> i; have i_lt := ltn_ord i.
rewrite !mxE big_split_ord /= coefD (mulrC a) (mulrC b).
rewrite (coef_product _ _ deg_x) (coef_product _ _ deg_y).
congr (_ + _); apply: eq_bigr => j _; have j_lt := ltn_ord j.
  rewrite col_mxEu !mxE (unsplitK (inl _ j)) mulrC; congr (_ * _).
  case: ifP => [/andP[h1 h2]|outside].
    by rewrite ifT; [congr (_`_ _); lia | lia].
  by case: ifP => // h3; rewrite nth_default // (leq_trans deg_a) //; move: outside h3; lia.
rewrite col_mxEd !mxE (unsplitK (inr _ j)) mulrC; congr (_ * _).
case: ifP => [/andP[h1 h2]|outside].
  by rewrite ifT; [congr (_`_ _); lia | lia].
by case: ifP => // h3; rewrite nth_default // (leq_trans deg_b) //; move: outside h3; lia.
Qed.

(* Hence Proposition 5 in the matrices' terms, for every n_c >= n - 1. *)
Theorem M_is_nonsingular n n_c D N : degree_is D n -> degree_at_most N n_c ->
  coprimep D N -> M_1 n n_c D N \in unitmx.
Proof. by move=> deg_D deg_N; case: (theorem_A1 deg_D deg_N) => _ [nonsingular _]. Qed.
End Resultants.
