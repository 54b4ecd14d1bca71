(* What moves beside theta. Several inputs: the ellipsoid of all coefficients in the factors of a certified
   set lies in Delta' S Delta <= W. Gains of modulus at most 1, each with a multiplier: an actuator whose
   effectiveness varies, or a limit that passes a share of u, in a loop with theta in its ellipsoid. And the
   directions of theta that move no pole, since entries of the regressor depend on each other. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite Matrices.
From Compensators.theorems Require Import ForwardConvergence Contraction SmallGain.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section SumsOfSquares.
Variable R : realFieldType.

Lemma value_of_diagonal n (d : 'rV[R]_n) (x : 'cV[R]_n) : value (diag_mx d) x = \sum_i d 0 i * x i 0 ^+ 2.
Proof.
rewrite /value /bilinear -mulmxA mul_diag_mx mxE; apply: eq_bigr => i _.
by rewrite !mxE expr2 mulrCA.
Qed.

(* |V x|^2 is at most the sum of the squares of V times |x|^2. *)
Lemma value_of_image m n (V : 'M[R]_(m, n)) x :
  square (V *m x) <= (\sum_i \sum_j V i j ^+ 2) * square x.
Proof.
rewrite [square (V *m x)]squareE mulr_suml; apply: ler_sum => i _.
have definite : positive_definite (1%:M : 'M[R]_n).
  split=> [|y nz]; first exact: trmx1.
  rewrite -/(square y) lt_neqAle square_ge0 andbT; apply: contraNneq nz => /esym zero.
  apply/eqP/matrixP=> j k; rewrite ord1 mxE; apply/eqP.
  by rewrite -sqrf_eq0 eq_le sqr_ge0 andbT -zero entry_square.
have := cauchy_schwarz (row i V)^T x definite; rewrite invmx1 trmxK.
have -> : (row i V *m x) 0 0 = (V *m x) i 0 by rewrite -row_mul mxE.
by rewrite -/(square _) squareE; congr (_ <= _ * _); apply: eq_bigr => j _; rewrite !mxE.
Qed.

(* The ellipsoid of theta as certified_set has it: theta_0 + factor v with |v| <= 1, where the factor is the
   Kronecker product of K and L, so that the change of Theta is L V K' with the entries of v in V. *)
Theorem in_ellipsoid_of_factors m p (S L : 'M[R]_m) (K : 'M[R]_p) (V : 'M[R]_(m, p)) : S^T = S ->
  L^T *m S *m L = 1%:M -> \sum_i \sum_j V i j ^+ 2 <= 1 -> in_ellipsoid S (K *m K^T) (L *m V *m K^T).
Proof.
move=> symmetric unit_L small; split=> [|y].
  by rewrite linearB /= !trmx_mul !trmxK symmetric !mulmxA.
rewrite value_sub value_congruence subr_ge0 -!mulmxA -[value S _]value_congruence unit_L.
have -> : value (K *m K^T) y = square (K^T *m y) by rewrite square_mul trmxK.
apply: le_trans (value_of_image _ _) _; rewrite -[X in _ <= X]mul1r ler_wpmul2r //.
exact: square_ge0.
Qed.
End SumsOfSquares.

(* x' = A x + B_1 v + B_2 e, phi = C_1 x + D_1 (v, e), q = C_2 x + D_2 (v, e): v is Delta phi, and e_i is
   delta_i q_i. *)
Section GainsBesideTheta.
Variables (R : realFieldType) (n m p g : nat).
Variables (P A : 'M[R]_n) (B : 'M[R]_(n, m + g)) (C_1 : 'M[R]_(p, n)) (D_1 : 'M[R]_(p, m + g)).
Variables (C_2 : 'M[R]_(g, n)) (D_2 : 'M[R]_(g, m + g)) (S : 'M[R]_m) (W : 'M[R]_p) (t : 'rV[R]_g).

(* The multipliers are t_i. *)
Definition scaled_inputs : 'M[R]_(m + g) := block_mx S 0 0 (diag_mx t).
Definition scaled_outputs : 'M[R]_(p + g) := block_mx W 0 0 (diag_mx t).
Definition scaled_small_gain r :=
  bounded_real P A B (col_mx C_1 C_2) (col_mx D_1 D_2) scaled_inputs scaled_outputs r.

(* What theta and the gains make of the signals that they multiply. *)
Definition moved_by (Delta : 'M[R]_(m, p)) (delta : 'rV[R]_g) (x : 'cV[R]_n) (w : 'cV[R]_(m + g)) :=
  w = col_mx (Delta *m (C_1 *m x + D_1 *m w)) (diag_mx delta *m (C_2 *m x + D_2 *m w)).

Lemma moved_is_small (Delta : 'M[R]_(m, p)) (delta : 'rV[R]_g) (phi : 'cV[R]_p) (q : 'cV[R]_g) :
  (forall i, 0 <= t 0 i) -> in_ellipsoid S W Delta -> (forall i, delta 0 i ^+ 2 <= 1) ->
  value scaled_inputs (col_mx (Delta *m phi) (diag_mx delta *m q)) <= value scaled_outputs (col_mx phi q).
Proof.
move=> t_ge0 [_ nonneg] small; rewrite /scaled_inputs /scaled_outputs !value_diagonal.
have := nonneg phi; rewrite value_sub value_congruence subr_ge0 => of_theta.
apply: ler_add => //; rewrite !value_of_diagonal; apply: ler_sum => i _; rewrite ler_wpmul2l //.
by rewrite mul_diag_mx mxE exprMn -[X in _ <= X]mul1r ler_wpmul2r ?sqr_ge0.
Qed.

Theorem gains_beside_theta r (Delta : nat -> 'M[R]_(m, p)) (delta : nat -> 'rV[R]_g) (x : nat -> 'cV[R]_n)
    (w : nat -> 'cV[R]_(m + g)) : 0 <= r -> (forall i, 0 <= t 0 i) -> scaled_small_gain r ->
  (forall k, in_ellipsoid S W (Delta k)) -> (forall k i, delta k 0 i ^+ 2 <= 1) ->
  (forall k, moved_by (Delta k) (delta k) (x k) (w k)) ->
  (forall k, x k.+1 = A *m x k + B *m w k) ->
  forall k, value P (x k) <= r ^+ k * value P (x 0%N).
Proof.
move=> r_ge0 t_ge0 gain inside small moved moves.
apply: (robust_motion r_ge0 gain moves) => k.
by rewrite {1}(moved k) !mul_col_mx add_col_mx; apply: moved_is_small.
Qed.
End GainsBesideTheta.

(* A limit of the size l passes a share of u between l / peak and 1, where |u| is at most the peak. *)
Lemma limit_is_a_share (R : realFieldType) (u l peak : R) : 0 < l -> l <= peak -> `|u| <= peak ->
  exists2 s, l / peak <= s <= 1 & Num.max (- l) (Num.min u l) = s * u.
Proof.
move=> l_gt0 l_peak u_peak; have peak_gt0 := lt_le_trans l_gt0 l_peak.
have share_le1 : l / peak <= 1 by rewrite ler_pdivr_mulr // mul1r.
have [u_l|l_u] := leP `|u| l.
  exists 1; rewrite ?share_le1 ?lexx // mul1r.
  by move: u_l; rewrite ler_norml => /andP[low high]; rewrite (min_idPl high) (max_idPr low).
have nz_u : `|u| != 0 by rewrite gt_eqF // (lt_trans l_gt0).
have u_gt0 : 0 < `|u| := lt_trans l_gt0 l_u.
exists (l / `|u|).
  rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // ler_wpmul2l ?(ltW l_gt0) //=.
  by rewrite ler_pdivr_mulr // mul1r ltW.
have [u_ge0|u_lt0] := leP 0 u.
  rewrite (ger0_norm u_ge0) in l_u nz_u *; rewrite divfK // (min_idPr (ltW l_u)).
  by apply/max_idPr; rewrite -subr_ge0 opprK addr_ge0 // ltW.
rewrite (ltr0_norm u_lt0) in l_u *; have u_l : u <= - l by rewrite ler_oppr ltW.
rewrite invrN mulrN mulNr divfK ?lt_eqF //.
apply/max_idPl; rewrite (min_idPl _) //; apply: le_trans u_l _.
by rewrite -subr_ge0 opprK addr_ge0 // ltW.
Qed.

(* Where the signals that Delta weights vanish for every u~, the poles stay, however large Delta is. *)
Section DependentRegressors.
Variables (R : idomainType) (n m p : nat).
Variables (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) (Delta : 'M[R]_(m, p)).

Theorem dependent_directions_keep_the_poles :
  map_mx polyC (Delta *m C) *m \adj (char_poly_mx A) *m map_mx polyC B = 0 ->
  char_poly (A + B *m Delta *m C) = char_poly A.
Proof.
set C' := map_mx polyC (Delta *m C); set B' := map_mx polyC B; set M := char_poly_mx A => silent.
set chi := \det M; have nz : chi != 0 by apply: char_poly_neq0.
pose loop := block_mx M B' C' (1%:M : 'M_m).
pose inverse := block_mx (\adj M) (- (\adj M *m B')) 0 (chi%:M : 'M_m).
have left : \det loop = char_poly (A + B *m Delta *m C).
  have -> : loop = block_mx (M - B' *m C') B' 0 1%:M *m block_mx 1%:M 0 C' 1%:M.
    by rewrite mulmx_block !mulmx1 !mulmx0 !mul1mx !add0r subrK.
  rewrite det_mulmx det_lblock det_ublock !det1 !mulr1 /char_poly; congr (\det _).
  by rewrite /M /B' /C' /char_poly_mx -map_mxM raddfD opprD addrA mulmxA.
have right : loop *m inverse = block_mx chi%:M 0 (C' *m \adj M) chi%:M.
  rewrite mulmx_block !mulmx0 !addr0 mul1mx !mulmxN !mulmxA mul_mx_adj -/chi silent oppr0 add0r.
  by rewrite mul_scalar_mx mul_mx_scalar addNr.
have adjugate : chi * \det (\adj M) = chi ^+ n.
  by rewrite /chi -det_mulmx mul_mx_adj det_scalar.
have nz_adj : \det (\adj M) != 0.
  by apply: contraTneq (expf_neq0 n nz) => zero; rewrite -adjugate zero mulr0 eqxx.
have := congr1 determinant right; rewrite det_mulmx !det_lblock det_ublock !det_scalar left -adjugate.
rewrite mulrA => /(mulIf (expf_neq0 m nz)); exact: mulIf.
Qed.
End DependentRegressors.
