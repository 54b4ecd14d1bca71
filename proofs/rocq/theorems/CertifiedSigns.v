(* Certificates of signs, checked by computation: that a symmetric matrix of rational numbers is positive
   definite, by a rounded factor, and that every root of a polynomial is in the left half-plane or in the
   unit disk, by the rows of Routh's array or of the table of Schur and Cohn, each divided by a factor that
   its numbers share. *)
From Coq Require Import ZArith Ring_polynom.
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import ssrZ all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices PositiveDefinite.
From Compensators.theorems Require RouthHurwitz SchurCohn.
From Compensators.theorems Require Import HighAuthorityPoles CertifiedEquations.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* s W Q W - F'F is symmetric and strictly diagonally dominant, with W = diag(weights). *)
Definition whole (p : horner) : Z := if p is Pc c then c else Z0.
Definition is_whole (p : horner) : bool := if p is Pc _ then true else false.
Definition sum_of n (f : nat -> Z) : Z := foldr (fun k s => Z.add (f k) s) Z0 (iota 0 n).
Definition number_of (l : seq (seq Z)) i j : Z := nth Z0 (nth [::] l i) j.
Definition excess (m : seq (seq Z)) i j : Z :=
  if (i == j)%N then Z.opp (number_of m i j) else Z.abs (number_of m i j).
Definition is_definite n (e : expression n n) (s : Z) (weights : seq Z) (factor : seq (seq Z)) : bool :=
  let: (l, d) := computed e in let c := product d in
  let q i j := whole (cell l i j) in let w i := nth Z0 weights i in let f := number_of factor in
  let m := mkseq (fun i => mkseq (fun j => Z.sub (Z.mul s (Z.mul (w i) (Z.mul (q i j) (w j))))
    (sum_of n (fun k => Z.mul (f k i) (f k j)))) n) n in
  [&& is_defined [::] e, is_whole c && Z.ltb Z0 (whole c), Z.ltb Z0 s, all (fun i => Z.ltb Z0 (w i)) (iota 0 n),
      every n n (fun i j => is_whole (cell l i j) && Z.eqb (q i j) (q j i)) &
      all (fun i => Z.ltb (sum_of n (excess m i)) Z0) (iota 0 n)].

(* Coefficients ascend; they are those of p or of -p, which has the same roots. *)
Definition power_form (cs : seq Z) : horner := foldr (fun c q => mkPX Z0 Z.eqb q xH (constant c)) zero cs.
Definition has_coefficients (p : expression 1 1) (cs : seq Z) : bool :=
  is_defined [::] p && (same (cell (computed p).1 0 0) (power_form cs) ||
    same (times (constant (Zneg xH)) (cell (computed p).1 0 0)) (power_form cs)).
Definition shares (g : Z) (next row : seq Z) : bool :=
  (size next == size row) && all (fun i => Z.eqb (Z.mul g (nth Z0 next i)) (nth Z0 row i)) (iota 0 (size row)).

Definition routh_row (cs : seq Z) : seq Z := let n := (size cs).-2 in
  mkseq (fun i => Z.sub (Z.mul (nth Z0 cs n) (nth Z0 cs i)) (Z.mul (nth Z0 cs n.+1)
    (if (i == 0%N) || (odd i == odd n) then Z0 else nth Z0 cs i.-1))) n.+1.
Fixpoint routh_rows (cs : seq Z) (rows : seq (Z * seq Z)) : bool := Z.ltb Z0 (last Z0 cs) &&
  if rows is (g, next) :: rest
  then [&& (1 < size cs)%N, Z.ltb Z0 (nth Z0 cs (size cs).-2), Z.ltb Z0 g, shares g next (routh_row cs) &
           routh_rows next rest]
  else (size cs == 1)%N.

Definition schur_row (cs : seq Z) : seq Z := let n := (size cs).-1 in
  mkseq (fun i => Z.sub (Z.mul (last Z0 cs) (nth Z0 cs i.+1)) (Z.mul (nth Z0 cs 0) (nth Z0 cs (n - i.+1)))) n.
Fixpoint schur_rows (cs : seq Z) (rows : seq (Z * seq Z)) : bool := ~~ Z.eqb (last Z0 cs) Z0 &&
  if rows is (g, next) :: rest
  then [&& (1 < size cs)%N, Z.ltb (Z.mul (nth Z0 cs 0) (nth Z0 cs 0)) (Z.mul (last Z0 cs) (last Z0 cs)),
           ~~ Z.eqb g Z0, shares g next (schur_row cs) & schur_rows next rest]
  else (size cs == 1)%N.

Lemma char0_of (R : numDomainType) : [char R] =i pred0. Proof. exact: char_num. Qed.

Section Definite.
Variables (R : realFieldType).
Local Notation integer := (integer R).

Lemma integer_gt0 c : Z.ltb Z0 c -> 0 < integer c.
Proof. by move=> pos; rewrite /CertifiedEquations.integer ltr0z; lia. Qed.

Lemma sum_ofE n f : integer (sum_of n f) = \sum_(k < n) integer (f k).
Proof.
rewrite /sum_of -(big_mkord xpredT (fun k => integer (f k))) /index_iota subn0.
elim: (iota 0 n) => [|k s IH]; first by rewrite big_nil.
by rewrite big_cons /= integerD IH.
Qed.

Lemma square_bound (e u v : R) : - (2%:R^-1 * (`|e| * (u ^+ 2 + v ^+ 2))) <= e * (u * v).
Proof.
rewrite ler_oppl; apply: le_trans (ler_norm _) _; rewrite normrN !normrM [X in _ <= X]mulrCA.
rewrite ler_wpmul2l ?normr_ge0 // mulrC ler_pdivl_mulr ?ltr0n // mulrC -subr_ge0.
rewrite -(real_normK (num_real u)) -(real_normK (num_real v)).
move: `|u| `|v| => a b; have -> : a ^+ 2 + b ^+ 2 - 2%:R * (a * b) = (a - b) ^+ 2 by ring.
exact: sqr_ge0.
Qed.

Lemma dominant_definite n (M : 'M[R]_n) x : M^T = M ->
  (forall i, \sum_j (if i == j then - M i j else `|M i j|) < 0) -> x != 0 -> 0 < value M x.
Proof.
move=> symmetric rows nz_x; pose a i j := if i == j then - M i j else `|M i j|.
have sym_M i j : M i j = M j i by rewrite -[in LHS]symmetric mxE.
have sym_a i j : a i j = a j i by rewrite /a eq_sym sym_M; case: eqP => // ->.
have below i j : - (2%:R^-1 * (a i j * (x i 0 ^+ 2 + x j 0 ^+ 2))) <= M i j * (x i 0 * x j 0).
  rewrite /a; case: eqP => [->|_]; last exact: square_bound.
  have -> : - (2%:R^-1 * (- M j j * (x j 0 ^+ 2 + x j 0 ^+ 2))) = M j j * (x j 0 * x j 0) by field.
  exact: lexx.
have -> : value M x = \sum_i \sum_j M i j * (x i 0 * x j 0).
  rewrite /value /bilinear mxE exchange_big; apply: eq_bigr => j _; rewrite !mxE mulr_suml.
  by apply: eq_bigr => i _; rewrite !mxE mulrAC mulrC.
apply: lt_le_trans (_ : \sum_i \sum_j - (2%:R^-1 * (a i j * (x i 0 ^+ 2 + x j 0 ^+ 2))) <= _); last first.
  by apply: ler_sum => i _; apply: ler_sum.
have -> : \sum_i \sum_j - (2%:R^-1 * (a i j * (x i 0 ^+ 2 + x j 0 ^+ 2)))
    = \sum_i x i 0 ^+ 2 * - \sum_j a i j.
  transitivity (- (2%:R^-1 * \sum_i \sum_j a i j * (x i 0 ^+ 2 + x j 0 ^+ 2))).
    rewrite mulr_sumr -sumrN; apply: eq_bigr => i _; rewrite mulr_sumr -sumrN.
    by apply: eq_bigr.
  have -> : \sum_i \sum_j a i j * (x i 0 ^+ 2 + x j 0 ^+ 2)
      = \sum_i \sum_j a i j * x i 0 ^+ 2 + \sum_i \sum_j a i j * x j 0 ^+ 2.
    rewrite -big_split; apply: eq_bigr => i _; rewrite -big_split.
    by apply: eq_bigr => j _; rewrite mulrDr.
  have -> : \sum_i \sum_j a i j * x j 0 ^+ 2 = \sum_i \sum_j a i j * x i 0 ^+ 2.
    by rewrite exchange_big; apply: eq_bigr => i _; apply: eq_bigr => j _; rewrite sym_a.
  have half (u : R) : - (2%:R^-1 * (u + u)) = - u by field.
  rewrite half -sumrN; apply: eq_bigr => i _; rewrite -mulr_suml mulrN mulrC.
  by [].
have [i nz_i] : exists i, x i 0 != 0.
  apply/existsP; apply: contraT; rewrite negb_exists => /forallP zero.
  case/negP: nz_x; apply/eqP/matrixP=> i j; rewrite ord1 mxE.
  by apply/eqP; have := zero i; rewrite negbK.
rewrite (bigD1 i) //= ltr_paddr //; last by rewrite mulr_gt0 ?exprn_even_gt0 ?oppr_gt0 ?rows.
by apply: sumr_ge0 => k _; rewrite mulr_ge0 ?sqr_ge0 // oppr_ge0 ltW ?rows.
Qed.

Theorem certified_definite (x : seq R) n (e : expression n n) s weights factor :
  is_definite e s weights factor -> positive_definite (at_ x e).
Proof.
rewrite /is_definite; case E: (computed e) => [l d].
case/and5P=> defined /andP[whole_c c_gt0] s_gt0 /allP weights_gt0 /andP[cells /allP rows].
have [] := @defined_computed R (char0_of R) x [::] _ _ e isT defined; rewrite E /= => nz_c ->.
have wholeE p : is_whole p -> horner_at x p = integer (whole p) by case: p.
pose Q : 'M[R]_n := \matrix_(i, j) integer (whole (cell l i j)).
have -> : table_at x n n l = Q.
  by apply/matrixP=> i j; rewrite !mxE wholeE //; have /andP[] := everyP i j cells.
rewrite wholeE //; apply: definite_scale; first by rewrite invr_gt0 integer_gt0.
have sym_Q : Q^T = Q.
  by apply/matrixP=> i j; rewrite !mxE; have /andP[_ /Z.eqb_spec->] := everyP j i cells.
split=> // y nz_y; pose w i := integer (nth Z0 weights i).
have w_gt0 (i : 'I_n) : 0 < w i by apply/integer_gt0/weights_gt0; rewrite mem_iota /=.
pose z : 'cV[R]_n := \col_i (y i 0 / w i).
have nz_z : z != 0.
  apply: contraNneq nz_y => z0; apply/eqP/matrixP=> i j; rewrite ord1.
  have := congr1 (fun v : 'cV[R]_n => v i 0 * w i) z0; rewrite !mxE mul0r divfK //.
  by rewrite gt_eqF.
pose W : 'M[R]_n := diag_mx (\row_i w i).
have y_Wz : y = W *m z.
  by apply/matrixP=> i j; rewrite ord1 mul_diag_mx !mxE mulrC divfK // gt_eqF.
pose Fa : 'M[R]_n := \matrix_(i, j) integer (number_of factor i j).
pose M := integer s *: (W^T *m Q *m W) - Fa^T *m Fa.
have M_pos : 0 < value M z.
  apply: dominant_definite => // [|i].
    by rewrite /M linearB linearZ /= !trmx_mul !trmxK sym_Q mulmxA.
  have := rows i; rewrite mem_iota /= ltn_ord => /(_ isT) row_i.
  have : 0 < integer (Z.opp (sum_of n (excess (mkseq (fun i => mkseq (fun j => Z.sub (Z.mul s (Z.mul
    (nth Z0 weights i) (Z.mul (whole (cell l i j)) (nth Z0 weights j)))) (sum_of n (fun k =>
    Z.mul (number_of factor k i) (number_of factor k j)))) n) n) i))).
    by apply: integer_gt0; move: row_i; clear; lia.
  rewrite integerN oppr_gt0 sum_ofE; congr (_ < 0); apply: eq_bigr => j _.
  rewrite /excess /number_of !nth_mkseq // -/(number_of factor).
  have -> : M i j = integer (Z.sub (Z.mul s (Z.mul (nth Z0 weights i) (Z.mul (whole (cell l i j))
      (nth Z0 weights j)))) (sum_of n (fun k => Z.mul (number_of factor k i) (number_of factor k j)))).
    have congruent : (W^T *m Q *m W) i j = w i * (Q i j * w j).
      by rewrite tr_diag_mx mul_mx_diag mxE mul_diag_mx !mxE mulrA.
    have square : (Fa^T *m Fa) i j = \sum_k Fa k i * Fa k j by rewrite mxE; apply: eq_bigr => k _; rewrite mxE.
    have -> : M i j = integer s * (W^T *m Q *m W) i j - (Fa^T *m Fa) i j.
      by rewrite /M; move: (W^T *m Q *m W) (Fa^T *m Fa) => X Y; rewrite !mxE.
    rewrite integerB !integerM sum_ofE congruent square !mxE; congr (_ - _).
    by apply: eq_bigr => k _; rewrite !mxE integerM.
  rewrite -[i == j]/(i == j :> nat); case: eqP => _; first by rewrite integerN.
  by move: (Z.sub _ _) => m; rewrite /CertifiedEquations.integer -intr_norm; congr (_%:~R); clear; lia.
rewrite y_Wz /value -bilinear_congruence -/(value _ z) -(pmulr_rgt0 _ (integer_gt0 s_gt0)) -value_scale.
have -> : integer s *: (W^T *m Q *m W) = M + Fa^T *m Fa by rewrite /M subrK.
rewrite value_add ltr_paddr // /value -[Fa^T]mulmx1 bilinear_congruence /bilinear mulmx1 mxE.
by apply: sumr_ge0 => k _; rewrite !mxE -expr2 sqr_ge0.
Qed.
End Definite.

Section Stable.
Variable R : rcfType.
Local Notation integer := (integer R).
Local Notation C := [fieldType of R[i]].
Implicit Types (cs : seq Z) (z : R[i]).

Definition poly_of cs : {poly R} := Poly (map integer cs).

Lemma coef_poly_of cs i : (poly_of cs)`_i = integer (nth Z0 cs i).
Proof.
rewrite coef_Poly; have [small|large] := ltnP i (size cs); first by rewrite (nth_map Z0).
by rewrite !nth_default // size_map.
Qed.

Lemma integer_complex c : CertifiedEquations.integer C c = real_complex R (integer c).
Proof. by rewrite /CertifiedEquations.integer rmorph_int. Qed.

Lemma power_form_at z (y : seq C) cs :
  horner_at (z :: y) (power_form cs) = (map_poly (real_complex R) (poly_of cs)).[z].
Proof.
rewrite /poly_of; elim: cs => [|c cs IH] /=; first by rewrite map_poly0 horner0.
rewrite (horner_at_step _ _ 0) /= IH expr1 cons_poly_def rmorphD rmorphM /= map_polyX map_polyC.
by rewrite hornerD hornerMX hornerC; congr (_ + _); apply: integer_complex.
Qed.

Lemma size_poly_of cs : integer (last Z0 cs) != 0 -> size (poly_of cs) = size cs.
Proof.
move=> nz; rewrite (@PolyK _ 0) ?size_map //; have -> : 0 = integer Z0 by [].
by rewrite last_map.
Qed.

Lemma lead_poly_of cs : integer (last Z0 cs) != 0 -> lead_coef (poly_of cs) = integer (last Z0 cs).
Proof. by move=> nz; rewrite lead_coefE size_poly_of // coef_poly_of nth_last. Qed.

Lemma shares_scaled g next row : shares g next row -> poly_of row = integer g *: poly_of next.
Proof.
case/andP=> /eqP same_size /allP equal; apply/polyP=> i; rewrite coefZ !coef_poly_of -integerM.
have [small|large] := ltnP i (size row); last by rewrite !nth_default ?same_size // integerM mulr0.
have /Z.eqb_spec-> // : Z.eqb (Z.mul g (nth Z0 next i)) (nth Z0 row i) by apply: equal; rewrite mem_iota.
Qed.

Lemma root_scaled k p z : k != 0 ->
  root (map_poly (real_complex R) (k *: p)) z = root (map_poly (real_complex R) p) z.
Proof. by move=> nz; rewrite map_polyZ rootZ // fmorph_eq0. Qed.

Lemma has_root p cs z (y : seq C) : has_coefficients p cs -> at_ (z :: y) p = 0 ->
  root (map_poly (real_complex R) (poly_of cs)) z.
Proof.
case/andP=> defined coefficients.
have [nz ->] := @defined_computed C (char0_of _) (z :: y) [::] _ _ p isT defined.
move/matrixP/(_ 0 0); rewrite !mxE => /eqP; rewrite mulf_eq0 invr_eq0 (negPf nz) /= => zero.
rewrite rootE -(power_form_at z y).
case/orP: coefficients => /(horner_at_same (z :: y)) <- //.
by rewrite horner_at_times mulf_eq0 zero orbT.
Qed.

Lemma routh_rows_sound cs rows : routh_rows cs rows -> RouthHurwitz.hurwitz (poly_of cs).
Proof.
elim: rows cs => [|[g next] rows IH] cs /= /andP[lead_gt0].
  have nz : integer (last Z0 cs) != 0 by rewrite gt_eqF // integer_gt0.
  move=> /eqP one_cs z; have := size_poly_of nz; rewrite one_cs => one_p.
  rewrite (size1_polyC (eq_leq one_p)) map_polyC rootC fmorph_eq0 /= => /eqP c0.
  by have := one_p; rewrite (size1_polyC (eq_leq one_p)) c0 size_poly0.
case/and5P=> large second_gt0 g_gt0 equal /IH stable.
have {}lead_gt0 := integer_gt0 R lead_gt0; have nz := lt0r_neq0 lead_gt0.
have {}second_gt0 := integer_gt0 R second_gt0; have {}g_gt0 := integer_gt0 R g_gt0.
case E: (size cs) large => [|[|n]] // _; have size_p := size_poly_of nz; rewrite E in size_p second_gt0.
have lead_p := lead_poly_of nz; rewrite /= in second_gt0.
have lead_pos : 0 < lead_coef (poly_of cs) by rewrite lead_p.
apply/(RouthHurwitz.routh_step size_p lead_pos); rewrite coef_poly_of; split=> //.
have row : poly_of (routh_row cs) = integer (nth Z0 cs n) *: RouthHurwitz.routh (poly_of cs).
  apply/polyP=> i; rewrite coefZ (RouthHurwitz.coef_routh size_p) !coef_poly_of lead_p /routh_row E /=.
  have last_cs : last Z0 cs = nth Z0 cs n.+1 by rewrite -nth_last E.
  have [small|beyond] := ltnP i n.+1.
    rewrite nth_mkseq // integerB !integerM -last_cs.
    have -> : integer (if (i == 0%N) || (odd i == odd n) then Z0 else nth Z0 cs i.-1)
      = if (i == 0%N) || (odd i == odd n) then 0 else integer (nth Z0 cs i.-1) by case: ifP.
    by move: (if _ then _ else _) => u; field; rewrite gt_eqF.
  rewrite nth_default ?size_mkseq // integer0; move: beyond; rewrite leq_eqVlt => /orP[/eqP<-|beyond].
    rewrite -last_cs /=; have -> : (~~ odd n == odd n) = false by case: (odd n).
    by field; rewrite gt_eqF.
  have cs_i : nth Z0 cs i = Z0 by rewrite nth_default // E.
  case: i beyond cs_i => [//|i] beyond cs_i; rewrite cs_i /= integer0 sub0r.
  case: ifP => [_|]; first by rewrite mulr0 oppr0 mulr0.
  move: beyond; rewrite ltnS leq_eqVlt => /orP[/eqP<-|beyond].
    by rewrite /= negbK eqxx.
  have -> : nth Z0 cs i = Z0 by rewrite nth_default ?E.
  by rewrite integer0 mulr0 oppr0 mulr0.
move=> z root_z; apply: stable; rewrite -(@root_scaled (integer g)) ?gt_eqF // -(shares_scaled equal).
by rewrite row root_scaled // gt_eqF.
Qed.

Lemma schur_rows_sound cs rows : schur_rows cs rows -> inside (poly_of cs).
Proof.
elim: rows cs => [|[g next] rows IH] cs /= /andP[nz_lead].
  have nz : integer (last Z0 cs) != 0 by rewrite integer_eq0 //; apply: char0_of.
  move=> /eqP one_cs z; have := size_poly_of nz; rewrite one_cs => one_p.
  rewrite (size1_polyC (eq_leq one_p)) map_polyC rootC fmorph_eq0 /= => /eqP c0.
  by have := one_p; rewrite (size1_polyC (eq_leq one_p)) c0 size_poly0.
case/and5P=> large small nz_g equal /IH stable.
have nz : integer (last Z0 cs) != 0 by rewrite integer_eq0 //; apply: char0_of.
have {}nz_g : integer g != 0 by rewrite integer_eq0 //; apply: char0_of.
case E: (size cs) large => [|[|n]] // _; have size_p := size_poly_of nz; rewrite E in size_p.
have lead_p := lead_poly_of nz.
apply/(SchurCohn.schur_cohn_step size_p); rewrite lead_p coef_poly_of; split.
  have /(integer_gt0 R) : Z.ltb Z0 (Z.sub (Z.mul (last Z0 cs) (last Z0 cs)) (Z.mul (nth Z0 cs 0) (nth Z0 cs 0))).
    by move: small; lia.
  by rewrite integerB !integerM subr_gt0 !expr2.
have row : poly_of (schur_row cs) = SchurCohn.schur_step (poly_of cs).
  apply/polyP=> i; rewrite coef_poly_of coef_poly size_p lead_p !coef_poly_of /schur_row E /=.
  have [below|beyond] := ltnP i n.+1; last by rewrite nth_default ?size_mkseq.
  by rewrite nth_mkseq // integerB !integerM.
move=> z root_z; apply: stable; rewrite -(@root_scaled (integer g)) // -(shares_scaled equal).
by rewrite row.
Qed.

(* p is 1 x 1, at z and any values of other symbols, which it does not have. *)
Theorem certified_hurwitz p cs rows z (y : seq C) : has_coefficients p cs -> routh_rows cs rows ->
  at_ (z :: y) p = 0 -> complex.Re z < 0.
Proof. by move=> coefficients /routh_rows_sound stable /(has_root coefficients) /stable. Qed.

Theorem certified_schur p cs rows z (y : seq C) : has_coefficients p cs -> schur_rows cs rows ->
  at_ (z :: y) p = 0 -> `|z| < 1.
Proof. by move=> coefficients /schur_rows_sound stable /(has_root coefficients) /stable. Qed.
End Stable.
