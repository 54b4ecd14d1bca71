(* Where the eigenvalues of M are inside the unit circle and Q >= 0, the solution of the Stein equation
   X = M'XM + Q is positive semidefinite: over every real closed field, where no series need converge.
   An eigenvector is split off at a time, and what is left is a Schur complement. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices PositiveDefinite.
From Compensators.theorems Require Import HighAuthorityPoles.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Hermitian.
Variable C : numClosedFieldType.

(* The conjugate transpose, and Hermitian matrices M >= 0. *)
Definition adjoint m n (M : 'M[C]_(m, n)) : 'M[C]_(n, m) := (map_mx conjC M)^T.
Definition hermitian_value n (M : 'M[C]_n) (x : 'cV[C]_n) : C := (adjoint x *m M *m x) 0 0.
Definition hermitian_semidefinite n (M : 'M[C]_n) :=
  adjoint M = M /\ forall x, 0 <= hermitian_value M x.

Lemma adjointK m n : cancel (@adjoint m n) (@adjoint n m).
Proof. by move=> M; apply/matrixP=> i j; rewrite !mxE conjCK. Qed.

Lemma adjoint_mul m n p (M : 'M[C]_(m, n)) (N : 'M[C]_(n, p)) :
  adjoint (M *m N) = adjoint N *m adjoint M.
Proof. by rewrite /adjoint map_mxM trmx_mul. Qed.

Lemma adjoint_add m n (M N : 'M[C]_(m, n)) : adjoint (M + N) = adjoint M + adjoint N.
Proof. by rewrite /adjoint map_mxD linearD. Qed.

Lemma adjoint_scale m n a (M : 'M[C]_(m, n)) : adjoint (a *: M) = a^* *: adjoint M.
Proof. by apply/matrixP=> i j; rewrite !mxE rmorphM. Qed.

Lemma adjoint_0 m n : adjoint (0 : 'M[C]_(m, n)) = 0.
Proof. by rewrite /adjoint map_mx0 trmx0. Qed.

Lemma adjoint_block m1 m2 n1 n2 (A : 'M[C]_(m1, n1)) (B : 'M[C]_(m1, n2)) (D : 'M[C]_(m2, n1))
    (E : 'M[C]_(m2, n2)) :
  adjoint (block_mx A B D E) = block_mx (adjoint A) (adjoint D) (adjoint B) (adjoint E).
Proof. by rewrite /adjoint map_block_mx tr_block_mx. Qed.

Lemma adjoint_col m1 m2 n (A : 'M[C]_(m1, n)) (B : 'M[C]_(m2, n)) :
  adjoint (col_mx A B) = row_mx (adjoint A) (adjoint B).
Proof. by rewrite /adjoint map_col_mx tr_col_mx. Qed.

Lemma hermitian_value_add n (M N : 'M[C]_n) x :
  hermitian_value (M + N) x = hermitian_value M x + hermitian_value N x.
Proof. by rewrite /hermitian_value mulmxDr mulmxDl mxE. Qed.

Lemma hermitian_value_congruence m n (M : 'M[C]_n) (T : 'M[C]_(n, m)) x :
  hermitian_value (adjoint T *m M *m T) x = hermitian_value M (T *m x).
Proof. by rewrite /hermitian_value adjoint_mul !mulmxA. Qed.

Lemma hermitian_congruence m n (M : 'M[C]_n) (T : 'M[C]_(n, m)) :
  hermitian_semidefinite M -> hermitian_semidefinite (adjoint T *m M *m T).
Proof.
case=> hermitian positive; split=> [|x]; first by rewrite !adjoint_mul adjointK hermitian mulmxA.
by rewrite hermitian_value_congruence.
Qed.

Lemma hermitian_add n (M N : 'M[C]_n) :
  hermitian_semidefinite M -> hermitian_semidefinite N -> hermitian_semidefinite (M + N).
Proof.
case=> M_h M_pos [N_h N_pos]; split=> [|x]; first by rewrite adjoint_add M_h N_h.
by rewrite hermitian_value_add addr_ge0.
Qed.

Lemma entry_combination (M N : 'M[C]_1) t : (M + t *: N) 0 0 = M 0 0 + t * N 0 0.
Proof. by rewrite !mxE. Qed.

(* Only a vector that M sends to 0 has the value 0. *)
Lemma hermitian_value_0 n (M : 'M[C]_n) x :
  hermitian_semidefinite M -> hermitian_value M x = 0 -> M *m x = 0.
Proof.
case=> hermitian positive zero; apply/matrixP=> i j; rewrite [j]ord1 {j} [RHS]mxE.
set c := (M *m x) i 0; pose d : 'cV[C]_n := delta_mx i 0.
pose form (y z : 'cV[C]_n) := (adjoint y *m M *m z) 0 0; pose a := form d d.
have right y z t : form y (z + t *: d) = form y z + t * form y d.
  by rewrite /form mulmxDr -scalemxAr entry_combination.
have left y z t : form (z + t *: d) y = form z y + t^* * form d y.
  by rewrite /form adjoint_add adjoint_scale !mulmxDl -!scalemxAl entry_combination.
have cross : form d x = c.
  have Ed : adjoint d = delta_mx 0 i by apply/matrixP=> k l; rewrite !mxE conjC_nat andbC.
  by rewrite /form Ed -mulmxA -rowE mxE.
have cross' : form x d = c^*.
  have E : adjoint x *m M *m d = adjoint (adjoint d *m M *m x).
    by rewrite !adjoint_mul adjointK hermitian mulmxA.
  by rewrite /form E -cross /form; move: (_ *m x) => N; rewrite !mxE.
have a_ge0 : 0 <= a := positive d.
pose s := (a + 1)^-1; have s_gt0 : 0 < s by rewrite invr_gt0 ltr_paddl ?ltr01.
have := positive (x + (- (s * c)) *: d).
rewrite -[hermitian_value M _]/(form _ _) right !left cross cross' -/a [form x x]zero add0r.
have s_real : s^* = s by apply: CrealP; rewrite ger0_real ?ltW.
rewrite !rmorphN rmorphM /= s_real => nonnegative.
have Es : s * a = 1 - s by rewrite /s; field; rewrite gt_eqF // ltr_paddl ?ltr01.
have sum : - (s * c^*) * c + - (s * c) * (c^* + - (s * c^*) * a) = - (s * (1 + s) * (c * c^*)).
  transitivity (s * c * c^* * (- 2%:R + s * a)); first by ring.
  by rewrite Es; ring.
move: nonnegative; rewrite sum oppr_ge0 pmulr_rle0 ?mulr_gt0 ?addr_gt0 ?ltr01 // => small.
have : c * c^* == 0 by rewrite eq_le small mul_conjC_ge0.
by rewrite mulf_eq0 conjC_eq0 orbb => /eqP.
Qed.

Definition roots_inside (p : {poly C}) := forall z, root p z -> `|z| < 1.

(* A change of basis, S T = T S'. *)
Lemma stein_congruence n (T S S' Z Q : 'M[C]_n) : S *m T = T *m S' ->
  Z = adjoint S *m Z *m S + Q ->
  adjoint T *m Z *m T = adjoint S' *m (adjoint T *m Z *m T) *m S' + adjoint T *m Q *m T.
Proof.
move=> similar {1}->; rewrite mulmxDr mulmxDl; congr (_ + _).
by rewrite !mulmxA -!adjoint_mul -!mulmxA similar.
Qed.

(* The step for a triangular S and an X without a block beside its corner. *)
Lemma stein_diagonal n a l (s : 'rV[C]_n) (S_2 D : 'M[C]_n) (Q : 'M[C]_(1 + n)) :
  let S : 'M[C]_(1 + n) := block_mx l%:M s 0 S_2 in
  let X : 'M[C]_(1 + n) := block_mx a%:M 0 0 D in
  (forall Q_2, hermitian_semidefinite Q_2 -> D = adjoint S_2 *m D *m S_2 + Q_2 ->
    forall x, 0 <= hermitian_value D x) ->
  `|l| < 1 -> hermitian_semidefinite Q ->
  X = adjoint S *m X *m S + Q -> forall x, 0 <= hermitian_value X x.
Proof.
move=> S X smaller inside_l positive_Q; rewrite /S /X.
rewrite -{1}[Q]submxK adjoint_block adjoint_0 !mulmx_block !mul0mx !mulmx0 !addr0 !add0r.
rewrite add_block_mx => /eq_block_mx[corner _ _ rest].
have corner_Q : (ulsubmx Q) 0 0 = a * (1 - `|l| ^+ 2).
  have E : a = l^* * a * l + (ulsubmx Q) 0 0.
    have := congr1 (fun M : 'M[C]_1 => M 0 0) corner; rewrite /adjoint map_scalar_mx tr_scalar_mx.
    by rewrite -!scalar_mxM [in RHS]mxE ![_%:M 0 0]mxE eqxx !mulr1n.
  transitivity (a - l^* * a * l); first by rewrite {1}E addrC addKr.
  by rewrite normCK; ring.
have a_ge0 : 0 <= a.
  have : 0 <= (ulsubmx Q) 0 0.
    have := positive_Q.2 (col_mx 1%:M 0); rewrite /hermitian_value -{1}[Q]submxK adjoint_col
      adjoint_0.
    by rewrite mul_row_block mul_row_col !mul0mx !mulmx0 !addr0 mulmx1 /adjoint map_mx1 trmx1
      mul1mx.
  by rewrite corner_Q pmulr_lge0 // subr_gt0 exprn_ilt1.
have positive_N : hermitian_semidefinite (drsubmx Q).
  have := hermitian_congruence (col_mx 0 1%:M) positive_Q;
    rewrite -{1}[Q]submxK adjoint_col adjoint_0.
  by rewrite mul_row_block mul_row_col !mul0mx !mulmx0 !add0r mulmx1 /adjoint map_mx1 trmx1 mul1mx.
have positive_D := smaller (a *: (adjoint s *m s) + drsubmx Q).
move=> x; rewrite -[x]vsubmxK; set x_1 := usubmx x; set x_2 := dsubmx x.
rewrite /hermitian_value adjoint_col mul_row_block !mulmx0 addr0 add0r mul_row_col mxE.
rewrite mul_mx_scalar -scalemxAl [X in X + _]mxE addr_ge0 //; last first.
  apply: positive_D; last by rewrite {1}rest mul_mx_scalar -scalemxAl -addrA addrCA.
  split=> [|y]; first by rewrite adjoint_add adjoint_scale adjoint_mul adjointK positive_N.1
    (CrealP _) ?ger0_real.
  rewrite hermitian_value_add addr_ge0 ?positive_N.2 //.
  rewrite /hermitian_value -scalemxAr -scalemxAl mxE mulr_ge0 // mulmxA -adjoint_mul -mulmxA.
  by move: (s *m y) => z; rewrite mxE big_ord1 !mxE mulrC mul_conjC_ge0.
by rewrite mulr_ge0 // mxE big_ord1 !mxE mulrC mul_conjC_ge0.
Qed.

(* Where the corner of X is 0, so is the block beside it. *)
Lemma beside_the_corner n a l (b s : 'rV[C]_n) (S_2 D : 'M[C]_n) (Q : 'M[C]_(1 + n)) :
  let S : 'M[C]_(1 + n) := block_mx l%:M s 0 S_2 in
  let X : 'M[C]_(1 + n) := block_mx a%:M b (adjoint b) D in
  roots_inside (char_poly S_2) -> `|l| < 1 -> hermitian_semidefinite Q ->
  X = adjoint S *m X *m S + Q -> exists y, b + a *: y = 0.
Proof.
move=> S X inside_2 inside_l positive_Q E; have [a0|nz_a] := eqVneq a 0; last first.
  by exists (- a^-1 *: b); rewrite scalerA mulrN mulfV // scaleN1r subrr.
exists 0; rewrite scaler0 addr0; move: E; rewrite /S /X a0 raddf0 -{1}[Q]submxK adjoint_block
  adjoint_0.
rewrite !mulmx_block !mul0mx !mulmx0 !addr0 !add0r add_block_mx !mul0mx !add0r.
case/eq_block_mx=> corner beside _ _.
have zero_Q : Q *m col_mx (1%:M : 'M_1) 0 = 0.
  apply: hermitian_value_0 => //; rewrite /hermitian_value -[Q]submxK adjoint_col adjoint_0.
  rewrite mul_row_block mul_row_col !mul0mx !mulmx0 !addr0 mulmx1 /adjoint map_mx1 trmx1 mul1mx.
  by rewrite -corner mxE.
have zero_p : ursubmx Q = 0.
  have : dlsubmx Q = 0.
    move: zero_Q; rewrite -{1}[Q]submxK mul_block_col !mulmx1 !mulmx0 !addr0 -[0]vsubmxK.
    by case/eq_col_mx=> _ ->; rewrite linear0.
  have := positive_Q.1; rewrite -{1 2}[Q]submxK adjoint_block => /eq_block_mx[_ <- _ _] ->.
  exact: adjoint_0.
move: beside; rewrite zero_p addr0 /adjoint map_scalar_mx tr_scalar_mx mul_scalar_mx -scalemxAl =>
  fixed.
have [//|nz_b] := eqVneq b 0; have nz_l : l^* != 0.
  by apply: contraNneq nz_b => l0; rewrite fixed l0 scale0r.
have : root (char_poly S_2) (l^*)^-1.
  rewrite -eigenvalue_root_char; apply/eigenvalueP; exists b => //.
  by rewrite {2}fixed scalerA mulVf // scale1r.
move/inside_2; rewrite normfV norm_conjC invf_lt1 ?normr_gt0 // => [outside|].
  by have := lt_trans outside inside_l; rewrite ltxx.
by apply: contraNneq nz_l => ->; rewrite conjC0.
Qed.

(* The step: a Schur complement of X. *)
Lemma stein_triangular n l (s : 'rV[C]_n) (S_2 : 'M[C]_n) (X Q : 'M[C]_(1 + n)) :
  let S : 'M[C]_(1 + n) := block_mx l%:M s 0 S_2 in
  (forall D Q_2, adjoint D = D -> hermitian_semidefinite Q_2 ->
    D = adjoint S_2 *m D *m S_2 + Q_2 -> forall x, 0 <= hermitian_value D x) ->
  roots_inside (char_poly S_2) -> `|l| < 1 -> adjoint X = X -> hermitian_semidefinite Q ->
  X = adjoint S *m X *m S + Q -> forall x, 0 <= hermitian_value X x.
Proof.
move=> S smaller inside_2 inside_l hermitian positive_Q E.
have [a [b [D EX]]] : exists a (b : 'rV[C]_n) (D : 'M[C]_n), X = block_mx a%:M b (adjoint b) D.
  exists (ulsubmx X 0 0), (ursubmx X), (drsubmx X); rewrite -mx11_scalar -{1}[X]submxK.
  have := hermitian; rewrite -{1 2}[X]submxK adjoint_block => /eq_block_mx[_ _ -> _].
  by [].
move: E hermitian; rewrite EX => E hermitian.
have [y zero] := beside_the_corner inside_2 inside_l positive_Q E.
pose T : 'M[C]_(1 + n) := block_mx 1%:M y 0 1%:M.
pose S' : 'M[C]_(1 + n) := block_mx l%:M (s + l *: y - y *m S_2) 0 S_2.
have similar : S *m T = T *m S'.
  rewrite /S /T /S' !mulmx_block !mulmx1 !mulmx0 !mul0mx !mul1mx !addr0 !add0r mul_scalar_mx.
  by rewrite subrK addrC.
have E' := stein_congruence similar E.
have real_a : a^* = a.
  have := hermitian; rewrite adjoint_block => /eq_block_mx[+ _ _ _].
  by rewrite /adjoint map_scalar_mx tr_scalar_mx => /matrixP/(_ 0 0); rewrite !mxE eqxx !mulr1n.
have hermitian_D : adjoint D = D by have := hermitian; rewrite adjoint_block => /eq_block_mx[].
have zero' : adjoint y *m a%:M + adjoint b = 0.
  by have := congr1 (@adjoint _ _) zero; rewrite adjoint_add adjoint_scale real_a adjoint_0
    mul_mx_scalar addrC.
have diagonal : adjoint T *m block_mx a%:M b (adjoint b) D *m T
    = block_mx a%:M 0 0 (D + adjoint y *m b).
  rewrite /T adjoint_block adjoint_0 !mulmx_block !mul0mx !mulmx0 !mulmx1 !addr0.
  rewrite /adjoint !map_mx1 !trmx1 -!/(adjoint _) !mul1mx zero' !mul0mx !add0r mul_scalar_mx.
  by rewrite addrC zero [D + _]addrC.
have hermitian_D' : adjoint (D + adjoint y *m b) = D + adjoint y *m b.
  have -> : b = - (a *: y) by apply/eqP; rewrite -addr_eq0 zero.
  rewrite mulmxN -scalemxAr adjoint_add hermitian_D -scaleN1r scalerA adjoint_scale adjoint_mul.
  by rewrite adjointK rmorphM rmorphN rmorph1 real_a.
rewrite diagonal in E'; have positive_Q' := hermitian_congruence T positive_Q.
have nonnegative := stein_diagonal (smaller _ ^~ hermitian_D') inside_l positive_Q' E'.
move=> x; have unit_T : T \in unitmx by rewrite unitmxE det_ublock !det1 mulr1 unitr1.
by rewrite -(mulKVmx unit_T x) -hermitian_value_congruence diagonal.
Qed.

(* Over the complex numbers of a real closed field. *)
Theorem stein_hermitian n (S X Q : 'M[C]_n) : roots_inside (char_poly S) ->
  adjoint X = X -> hermitian_semidefinite Q -> X = adjoint S *m X *m S + Q ->
  hermitian_semidefinite X.
Proof.
move=> inside_S hermitian positive_Q E; split=> //.
elim: n S X Q inside_S hermitian positive_Q E => [|n IH] S X Q inside_S hermitian positive_Q E x.
  by rewrite /hermitian_value mxE big_ord0.
have /closed_rootP[l root_l] : size (char_poly S) != 1%N by rewrite size_char_poly.
have [v Ev nz_v] : exists2 v : 'rV_n.+1, v *m S^T = l *: v & v != 0.
  by apply/eigenvalueP; rewrite eigenvalue_root_char char_poly_tr.
pose W : 'M[C]_(1 + n) := row_ebase v; have unit_W : W \in unitmx := row_ebase_unit v.
have first : v = col_ebase v *m usubmx W.
  rewrite -{1}(mulmx_ebase v) rank_rV nz_v -mulmxA -/W; congr (_ *m _).
  rewrite -{1}[W]vsubmxK (pid_mx_row _ n 1).
  by apply: (etrans (mul_row_col 1%:M 0 _ _)); rewrite mul1mx mul0mx addr0.
pose T : 'M[C]_(1 + n) := W^T; have unit_T : T \in unitmx by rewrite unitmx_tr.
pose e : 'M[C]_(1 + n, 1) := col_mx 1%:M 0.
have Te : T *m e = (usubmx W)^T.
  by rewrite /T -{1}[W]vsubmxK tr_col_mx mul_row_col mulmx1 mulmx0 addr0.
have Ee : S *m (T *m e) = l *: (T *m e).
  rewrite Te; apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK linearZ /= trmxK.
  have -> : usubmx W = invmx (col_ebase v) *m v by rewrite {2}first mulKmx ?col_ebase_unit.
  by rewrite -mulmxA Ev -scalemxAr.
pose S' : 'M[C]_(1 + n) := invmx T *m (S *m T).
have similar : S *m T = T *m S' by rewrite mulKVmx.
have : S' *m e = l *: e by rewrite /S' -!mulmxA Ee -scalemxAr mulKmx.
rewrite -{1}[S']submxK mul_block_col !mulmx1 !mulmx0 !addr0 scale_col_mx scaler0 scalemx1.
case/eq_col_mx=> corner below.
have triangular : S' = block_mx l%:M (ursubmx S') 0 (drsubmx S') by rewrite -corner -below submxK.
have same : char_poly S = char_poly (l%:M : 'M_1) * char_poly (drsubmx S').
  rewrite -(char_poly_upper _ (ursubmx S')) -triangular;
    apply/esym/(@char_poly_similar _ _ T) => //.
  by rewrite -unitfE -unitmxE.
have inside_l := inside_S l root_l.
have inside_2 : roots_inside (char_poly (drsubmx S')).
  by move=> z root_z; apply: inside_S; rewrite same rootM root_z orbT.
have := stein_congruence similar E; rewrite {1 2}triangular => E'.
have hermitian' : adjoint (adjoint T *m X *m T) = adjoint T *m X *m T.
  by rewrite !adjoint_mul adjointK hermitian mulmxA.
rewrite -(mulKVmx unit_T x) -hermitian_value_congruence.
apply: (stein_triangular _ inside_2 inside_l hermitian' (hermitian_congruence T positive_Q) E').
by move=> D Q_2 hermitian_D positive_Q_2 E_2; apply: IH inside_2 hermitian_D positive_Q_2 E_2.
Qed.
End Hermitian.

Section RealMatrices.
Variables (R : rcfType).
Local Notation toC := (real_complex R).

Lemma adjoint_real m n (M : 'M[R]_(m, n)) : adjoint (map_mx toC M) = map_mx toC M^T.
Proof. by apply/matrixP=> i j; rewrite !mxE; apply/CrealP/complex_realP; exists (M j i). Qed.

Lemma hermitian_value_real n (M : 'M[R]_n) (x : 'cV[R]_n) :
  hermitian_value (map_mx toC M) (map_mx toC x) = toC (value M x).
Proof. by rewrite /hermitian_value adjoint_real -!map_mxM mxE. Qed.

(* A complex vector is u + iv. *)
Lemma complex_vector n (x : 'cV[R[i]]_n) : exists u v : 'cV[R]_n,
  x = map_mx toC u + 'i%C *: map_mx toC v.
Proof.
exists (map_mx (@complex.Re R) x), (map_mx (@complex.Im R) x).
by apply/matrixP=> i j; rewrite !mxE -complexE.
Qed.

Lemma hermitian_value_complex n (M : 'M[R]_n) (u v : 'cV[R]_n) : M^T = M ->
  hermitian_value (map_mx toC M) (map_mx toC u + 'i%C *: map_mx toC v)
  = toC (value M u + value M v).
Proof.
move=> symmetric.
rewrite /hermitian_value adjoint_add adjoint_scale !adjoint_real complexiE conjCi.
rewrite !mulmxDl !mulmxDr -!scalemxAl -!scalemxAr -!map_mxM.
have -> : v^T *m M *m u = u^T *m M *m v.
  have tr (N : 'M[R]_1) : N^T = N by apply/matrixP=> i j; rewrite !ord1 mxE.
  by rewrite -[LHS]tr !trmx_mul trmxK symmetric mulmxA.
rewrite /value /bilinear; move: (u^T *m M *m u) (u^T *m M *m v) (v^T *m M *m v) => a b c.
rewrite !mxE; move: (a 0 0) (b 0 0) (c 0 0) => a_0 b_0 c_0.
rewrite -[(a_0 + c_0)%:C%C]/([rmorphism of toC] (a_0 + c_0)) rmorphD /=.
have ring_fact (x y z i : R[i]) : x + i * y + (- i * y + - i * (i * z)) = x - i ^+ 2 * z by ring.
by rewrite ring_fact sqrCi mulN1r opprK.
Qed.

Lemma semidefinite_complex n (M : 'M[R]_n) :
  positive_semidefinite M -> hermitian_semidefinite (map_mx toC M).
Proof.
case=> symmetric positive; split=> [|x]; first by rewrite adjoint_real symmetric.
have [u [v ->]] := complex_vector x.
by rewrite hermitian_value_complex // -(rmorph0 [rmorphism of toC]) lecR addr_ge0.
Qed.

Lemma char_poly_complex n (M : 'M[R]_n) : char_poly (map_mx toC M) = map_poly toC (char_poly M).
Proof. by rewrite (map_char_poly [rmorphism of toC]). Qed.

(* (4.23) with V >= 0, transposed: the sum of M'^k Q M^k, were there series, is semidefinite. *)
Theorem lyapunov_semidefinite n (M X Q : 'M[R]_n) : inside (char_poly M) -> X^T = X ->
  positive_semidefinite Q -> X = M^T *m X *m M + Q -> positive_semidefinite X.
Proof.
move=> inside_M symmetric positive_Q E; split=> // x.
have [||||_ positive] := @stein_hermitian _ n (map_mx toC M) (map_mx toC X) (map_mx toC Q).
- by move=> z; rewrite char_poly_complex => /inside_M.
- by rewrite adjoint_real symmetric.
- exact: semidefinite_complex.
- by rewrite adjoint_real -!map_mxM -map_mxD -E.
by have := positive (map_mx toC x); rewrite hermitian_value_real -(rmorph0 [rmorphism of toC]) lecR.
Qed.
End RealMatrices.
