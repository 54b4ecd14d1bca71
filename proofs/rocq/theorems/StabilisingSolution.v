(* The stabilising solution of (A.7) exists, for any number of inputs and R_2 > 0, if (A, B) is
   stabilisable and [A - zI B; R_1 R_12; R_12' R_2] has no kernel on the unit circle. No limit is taken:
   the solution is the spectral subspace of the symplectic pencil, over every real closed field. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices PositiveDefinite.
From Compensators.theorems Require Import Kalman Coprimeness HighAuthorityPoles Stein Riccati.
From Compensators.theorems Require Import Lyapunov SpectralSubspace.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma unit_of_kernel (R : fieldType) n (M : 'M[R]_n) :
  (forall v : 'cV[R]_n, M *m v = 0 -> v = 0) -> M \in unitmx.
Proof.
move=> only_zero; rewrite -unitmx_tr -row_free_unit -kermx_eq0; apply: contraT => /rowV0Pn[v].
move/sub_kermxP=> zero; have -> : v = 0; last by rewrite eqxx.
apply: (can_inj (@trmxK _ _ _)); rewrite trmx0; apply: only_zero.
by apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK zero trmx0.
Qed.

Lemma eigencolumn (F : fieldType) n (M : 'M[F]_n) z : root (char_poly M) z ->
  exists2 x : 'cV[F]_n, M *m x = z *: x & x != 0.
Proof.
rewrite -char_poly_tr -eigenvalue_root_char => /eigenvalueP[v Ev nz]; exists v^T.
  by apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK Ev linearZ /= trmxK.
by rewrite -(inj_eq (can_inj (@trmxK _ _ _))) trmxK trmx0.
Qed.

Lemma root_of_eigencolumn (F : fieldType) n (M : 'M[F]_n) (x : 'cV[F]_n) z :
  M *m x = z *: x -> x != 0 -> root (char_poly M) z.
Proof.
move=> Ex nz; rewrite -char_poly_tr -eigenvalue_root_char; apply/eigenvalueP; exists x^T.
  by rewrite -trmx_mul Ex linearZ.
by rewrite -(inj_eq (can_inj (@trmxK _ _ _))) trmxK trmx0.
Qed.

Section Standard.
Variables (R : rcfType) (order m : nat).
Local Notation n := order.+1.
Variables (A Q : 'M[R]_n) (B : 'M[R]_(n, m)) (R_2 : 'M[R]_m) (K_0 : 'M[R]_(m, n)).
Local Notation toC := (real_complex R).
Local Notation C M := (map_mx toC M).
Hypothesis positive_Q : positive_semidefinite Q.
Hypothesis positive_R : positive_definite R_2.
Hypothesis stable_K : inside (char_poly (A + B *m K_0)).
Hypothesis seen : forall z (x : 'cV[R[i]]_n), `|z| = 1 -> C A *m x = z *: x -> C Q *m x = 0 -> x =
  0.

Let S_2 := invmx R_2.
Let G := B *m S_2 *m B^T.
Let F : 'M[R]_(n + n) := block_mx A 0 (- Q) 1%:M.
Let E : 'M[R]_(n + n) := block_mx 1%:M G 0 A^T.

Let unit_R : R_2 \in unitmx. Proof. exact: definite_invertible. Qed.
Let positive_S : positive_semidefinite S_2.
Proof. exact/definite_semidefinite/definite_inverse. Qed.
Let G_T : G^T = G. Proof. by rewrite /G !trmx_mul trmxK positive_S.1 mulmxA. Qed.

(* What no input moves and what no weight sees cannot lie on the circle. *)
Lemma unmoved_on_the_circle w (x : 'cV[R[i]]_n) : `|w| = 1 ->
  x = w *: (C A^T *m x) -> C B^T *m x = 0 -> x = 0.
Proof.
move=> on_circle fixed unmoved; apply/eqP; apply: contraT => nz_x.
have nz_w : w != 0 by apply: contraNneq nz_x => w0; rewrite fixed w0 scale0r.
have : root (char_poly (C (A + B *m K_0)^T)) w^-1.
  apply: root_of_eigencolumn nz_x; rewrite [(A + _)^T]linearD /= trmx_mul map_mxD map_mxM mulmxDl.
  by rewrite -mulmxA unmoved mulmx0 addr0 {2}fixed scalerA mulVf // scale1r.
by rewrite char_poly_complex char_poly_tr => /stable_K; rewrite normfV on_circle invr1 ltxx.
Qed.

Lemma regular_on_the_circle w (x : 'cV[R[i]]_(n + n)) : `|w| = 1 ->
  C F *m x = w *: (C E *m x) -> x = 0.
Proof.
move=> on_circle; rewrite -[x]vsubmxK; set x_1 := usubmx x; set x_2 := dsubmx x.
rewrite /F /E !map_block_mx !map_mx0 !map_mx1 map_mxN !mul_block_col scale_col_mx.
rewrite !mul0mx !mul1mx addr0 add0r mulNmx => /eq_col_mx[upper lower].
have entry_add (M N : 'M[R[i]]_1) : (w *: (M + N)) 0 0 = w * M 0 0 + w * N 0 0.
  by rewrite !mxE mulrDr.
have entry_sub (M N : 'M[R[i]]_1) : (w *: (M - N)) 0 0 = w * M 0 0 - w * N 0 0.
  by rewrite !mxE mulrBr.
have ww : w * w^* = 1 by rewrite -normCK on_circle expr1n.
pose h := hermitian_value (C Q) x_1; pose g := hermitian_value (C S_2) (C B^T *m x_2).
have Eg : (adjoint x_2 *m C G *m x_2) 0 0 = g.
  by rewrite /g /hermitian_value adjoint_mul adjoint_real trmxK /G !map_mxM !mulmxA.
have first : (adjoint x_2 *m C A *m x_1) 0 0 = w * (adjoint x_2 *m x_1) 0 0 + w * g.
  by rewrite -mulmxA upper -scalemxAr mulmxDr mulmxA -Eg; apply: entry_add.
have second : (adjoint x_2 *m C A *m x_1) 0 0 = w * (adjoint x_2 *m x_1) 0 0 - w * h.
  have : w *: (adjoint x_2 - adjoint x_1 *m C Q) = adjoint x_2 *m C A.
    have := congr1 (@adjoint _ _ _) lower; rewrite adjoint_scale !adjoint_mul adjoint_real trmxK.
    rewrite adjoint_add -scaleN1r adjoint_scale adjoint_mul (semidefinite_complex positive_Q).1.
    by rewrite rmorphN1 scaleN1r addrC => ->; rewrite scalerA ww scale1r.
  by move=> <-; rewrite -scalemxAl mulmxBl; apply: entry_sub.
have nz_w : w != 0 by rewrite -normr_eq0 on_circle oner_eq0.
have h_ge0 : 0 <= h by apply: (semidefinite_complex positive_Q).2.
have g_ge0 : 0 <= g by apply: (semidefinite_complex positive_S).2.
have sum : h + g = 0.
  by apply: (mulfI nz_w); rewrite mulr0 mulrDr; move: first; rewrite second;
    move: (w * h) (w * g) (w * _) => a b c /addrI <-; rewrite subrr.
have /andP[/eqP h0 /eqP g0] : (h == 0) && (g == 0) by rewrite -paddr_eq0 // sum.
have unseen : C Q *m x_1 = 0 by apply: hermitian_value_0 => //; apply: semidefinite_complex.
have unmoved : C B^T *m x_2 = 0.
  have := hermitian_value_0 (semidefinite_complex positive_S) g0.
  move/(congr1 (mulmx (C R_2))); rewrite mulmx0 mulmxA -map_mxM mulmxV // map_mx1 mul1mx.
  by [].
have x_1_0 : x_1 = 0.
  apply: (seen on_circle) unseen; rewrite upper /G !map_mxM -mulmxA unmoved mulmx0 addr0.
  by [].
rewrite x_1_0 (unmoved_on_the_circle on_circle _ unmoved) ?col_mx0 //.
by rewrite -lower unseen oppr0 add0r.
Qed.

(* The pencil is regular at -1, and its Cayley transform is Hamiltonian without eigenvalues on the axis. *)
Let unit_at_minus_1 : F + E \in unitmx.
Proof.
apply: unit_of_kernel => v; rewrite mulmxDl => zero.
apply/eqP; rewrite -(map_mx_eq0 [rmorphism of toC]); apply/eqP.
apply: (@regular_on_the_circle (- 1)); first by rewrite normrN1.
by rewrite -!map_mxM scaleN1r -map_mxN; congr (C _); apply/eqP; rewrite -addr_eq0 zero.
Qed.

Let H : 'M[R]_(n + n) := invmx (F + E) *m (E - F).
Let J : 'M[R]_(n + n) := block_mx 0 1%:M (- 1%:M) 0.

Let HE : (F + E) *m H = E - F. Proof. by rewrite mulKVmx. Qed.

Let J_square : J *m J = - 1%:M.
Proof.
rewrite /J mulmx_block !mulmx0 !mul0mx !mulmx1 !mul1mx !addr0 !add0r.
by rewrite scalar_mx_block opp_block_mx oppr0.
Qed.

Let symplectic : F *m J *m F^T = E *m J *m E^T.
Proof.
rewrite /F /E /J !tr_block_mx !trmx0 !trmx1 trmxK linearN /= positive_Q.1 G_T !mulmx_block.
rewrite !(mulmx0, mul0mx, mulmx1, mul1mx, addr0, add0r, mulNmx, mulmxN, opprK).
by rewrite addNr subrr oppr0 add0r.
Qed.

Let hamiltonian : H^T *m J = - (J *m H).
Proof.
have both : (F + E) *m (H *m J + J *m H^T) *m (F + E)^T = 0.
  rewrite mulmxDr mulmxDl mulmxA HE -!mulmxA -trmx_mul HE.
  rewrite ![(_ + _)^T]linearD /= ![(- _)^T]linearN /= !(mulmxDl, mulmxDr, mulNmx, mulmxN) !mulmxA.
  rewrite symplectic; move: (E *m J *m E^T) (E *m J *m F^T) (F *m J *m E^T) => a b c.
  by apply/matrixP=> i j; rewrite !mxE; ring.
have : H *m J + J *m H^T = 0.
  apply: (can_inj (mulKmx unit_at_minus_1)); apply: (can_inj (mulmxK (_ : (F + E)^T \in unitmx))).
    by rewrite unitmx_tr.
  by rewrite both mulmx0 mul0mx.
move/(congr1 (fun M => J *m M *m J)); rewrite mulmxDr mulmxDl mulmx0 mul0mx.
rewrite -[J *m (H *m J) *m J]mulmxA -[H *m J *m J]mulmxA J_square mulmxN mulmx1 mulmxN.
rewrite mulmxA J_square mulNmx mul1mx mulNmx => /eqP.
by rewrite -opprD oppr_eq0 addrC addr_eq0 => /eqP.
Qed.

Let unit_J : J \in unitmx.
Proof.
have : J *m (- J) = 1%:M by rewrite mulmxN J_square opprK.
by case/mulmx1_unit.
Qed.

Let off_axis z : root (map_poly toC (char_poly (H : 'M[R]_((order + n).+1)))) z -> complex.Re z !=
  0.
Proof.
rewrite -char_poly_complex => /eigencolumn[x Ex nz]; apply: contra nz => /eqP on_axis.
have conj_z : z^* = - z by case: z on_axis {Ex} => a b /= ->; apply/eqP;
  rewrite eq_complex /= oppr0 !eqxx.
have nz_1 : 1 + z != 0.
  apply/negP=> /eqP zero; have := congr1 (@complex.Re R) zero; rewrite raddfD /= on_axis addr0.
  by move/eqP; rewrite oner_eq0.
have moved : C E *m x - C F *m x = z *: (C F *m x + C E *m x).
  rewrite -mulmxBl -mulmxDl -map_mxB -map_mxD -HE map_mxM -mulmxA.
  by rewrite (Ex : C H *m x = z *: x) -scalemxAr.
apply/eqP; apply: (@regular_on_the_circle ((1 - z) / (1 + z))).
  have -> : 1 - z = (1 + z)^* by rewrite rmorphD rmorph1 /= conj_z.
  by rewrite normrM normfV norm_conjC mulfV // normr_eq0.
move: moved; move: (C E *m x) (C F *m x) => e f moved.
have same : (1 + z) *: f = (1 - z) *: e.
  apply/matrixP=> i j; have := congr1 (fun M : 'M__ => M i j) moved; rewrite !mxE => same.
  apply/eqP; rewrite -subr_eq0; apply/eqP.
  transitivity (z * (f i j + e i j) - (e i j - f i j)); first by ring.
  by rewrite same subrr.
by rewrite [_ / _]mulrC -scalerA -same scalerA mulVf // scale1r.
Qed.

(* Its half on the right is that of the closed loop. *)
Let deflating : exists (V_1 V_2 : 'M[R]_n) S,
  [/\ \rank (col_mx V_1 V_2) = n, A *m V_1 = (V_1 + G *m V_2) *m S,
      V_2 - Q *m V_1 = A^T *m V_2 *m S, V_1^T *m V_2 = V_2^T *m V_1 & inside (char_poly S)].
Proof.
have [V [Y [p [rank_V invariant isotropic right_p zero]]]] :=
  @spectral_subspace R (order + n) n H J hamiltonian unit_J erefl off_axis.
have full_V : row_full V by rewrite /row_full rank_V.
have zero_Y : horner_mx Y p = 0.
  apply: (row_full_inj full_V); rewrite mulmx0 -(horner_mx_columns p invariant).
  exact: zero.
have nz_p : p != 0.
  apply/negP=> /eqP p0; have := right_p 0; rewrite p0 rmorph0 root0 => /(_ isT).
  by rewrite ltxx.
have unit_Y : 1%:M + Y \in unitmx.
  have apart : coprimep ('X - (- 1)%:P) p.
    rewrite coprimep_sym coprimep_XsubC; apply/negP=> /(root_real (R := R)) /right_p.
    by rewrite /= oppr_gt0 ltr10.
  have [[u v] /= /(congr1 (horner_mx Y))] := Bezout_eq1_coprimepP _ _ apart.
  rewrite rmorphD !rmorphM /= zero_Y mulr0 addr0 rmorph1 rmorphB /= horner_mx_X horner_mx_C.
  by rewrite raddfN opprK addrC => /mulmx1_unit[].
pose S := (1%:M - Y) *m invmx (1%:M + Y).
have S_Y : S *m (1%:M + Y) = 1%:M - Y by rewrite mulmxKV.
have moved : F *m V = E *m V *m S.
  apply: (can_inj (mulmxK unit_Y)); rewrite -[_ *m S *m _]mulmxA S_Y [F *m V *m _]mulmxDr [E *m V
    *m _]mulmxBr !mulmx1.
  have key : E *m V - F *m V = F *m V *m Y + E *m V *m Y.
    by rewrite -mulmxBl -!mulmxDl -HE -mulmxA (invariant : H *m V = _) mulmxA.
  move: key; move: (E *m V) (F *m V) => a b; move: (a *m Y) (b *m Y) => d c key.
  by rewrite -[a](subrK b) key addrAC addrK addrC.
pose V_1 := usubmx (V : 'M_(n + n, n)); pose V_2 := dsubmx (V : 'M_(n + n, n)).
have EV : V = col_mx V_1 V_2 by rewrite vsubmxK.
exists V_1, V_2, S; split.
- by rewrite -EV.
- move: moved; rewrite EV !mul_block_col mul_col_mx !mul0mx !mul1mx addr0 add0r.
  by case/eq_col_mx.
- move: moved; rewrite EV !mul_block_col mul_col_mx !mul0mx !mul1mx addr0 add0r.
  by case/eq_col_mx=> _ <-; rewrite mulNmx addrC.
- have : (col_mx V_1 V_2)^T *m J *m col_mx V_1 V_2 = 0 by rewrite -EV.
  rewrite tr_col_mx -mulmxA mul_block_col !mul0mx mulNmx !mul1mx addr0 add0r.
  by rewrite mul_row_col mulmxN => /eqP; rewrite subr_eq0 => /eqP.
(* s = (1 - z) / (1 + z) is on the right for the eigenvalues z of S *)
move=> z; rewrite -char_poly_complex => root_z.
have [u Eu nz_u] : exists2 u : 'rV[R[i]]_n, u *m C S = z *: u & u != 0.
  by apply/eigenvalueP; rewrite eigenvalue_root_char.
have acts : (1 + z) *: (u *m C Y) = (1 - z) *: u.
  have := congr1 (fun M => u *m C M) S_Y; rewrite map_mxM mulmxA Eu map_mxD map_mxB map_mx1.
  rewrite mulmxDr mulmxBr -!scalemxAl !mulmx1 => moved_u.
  apply/matrixP=> i j; have := congr1 (fun M : 'M__ => M i j) moved_u; rewrite !mxE => same.
  apply/eqP; rewrite -subr_eq0; apply/eqP.
  by move: same; move: (\sum_(_ < _) _) (u i j) => y x same;
    transitivity (z * x + z * y - (x - y)); [ring | rewrite same subrr].
have nz_1 : 1 + z != 0.
  apply: contra nz_u => /eqP vanishes.
  have Ez : z = - 1 by apply/eqP; rewrite -addr_eq0 addrC vanishes.
  move: acts; rewrite vanishes scale0r Ez opprK => /esym/eqP.
  by rewrite scaler_eq0 -mulr2n pnatr_eq0.
pose s := (1 - z) / (1 + z).
have Es : u *m C Y = s *: u by rewrite /s [_ / _]mulrC -scalerA -acts scalerA mulVf // scale1r.
have : 0 < complex.Re s.
  apply: right_p; have : u *m C (horner_mx Y p) = (map_poly toC p).[s] *: u.
    elim/poly_ind: (p) => [|q a IH]; first by rewrite !rmorph0 mulmx0 horner0 scale0r.
    rewrite !rmorphD !rmorphM /= horner_mx_X horner_mx_C map_scalar_mx mulmxDr -mulmxE mulmxA IH.
    rewrite -scalemxAl Es scalerA mul_mx_scalar -scalerDl map_polyX map_polyC /=.
    by rewrite hornerMXaddC.
  have -> : C (horner_mx Y p) = 0 by rewrite zero_Y; apply: map_mx0.
  by rewrite mulmx0 => /esym/eqP; rewrite scaler_eq0 (negPf nz_u) orbF.
have zE : z = (1 - s) / (1 + s).
  have nz_2 : (1 + z) + (1 - z) != 0 by rewrite addrACA subrr addr0 -mulr2n pnatr_eq0.
  have -> : 1 + s = ((1 + z) + (1 - z)) / (1 + z) by rewrite mulrDl mulfV.
  have -> : 1 - s = ((1 + z) - (1 - z)) / (1 + z) by rewrite mulrBl mulfV.
  by field; rewrite nz_1 nz_2.
have [a [b Es']] : exists a b, s = (a +i* b)%C by case: (s) => a b; exists a, b.
rewrite zE Es' /= => a_gt0; rewrite normrM normfV ltr_pdivr_mulr ?mul1r; last first.
  by rewrite normr_gt0; apply/negP=> /eqP /(congr1 (@complex.Re R)) /= /eqP;
    rewrite gt_eqF // ltr_paddl ?ler01.
rewrite !normc_def ltcR ltr_sqrt /=.
  have gap : (1 + a) ^+ 2 + (0 + b) ^+ 2 - ((1 - a) ^+ 2 + (0 - b) ^+ 2) = 4%:R * a by ring.
  by rewrite -subr_gt0 gap mulr_gt0 ?ltr0n.
by rewrite ltr_paddr ?sqr_ge0 // exprn_gt0 // ltr_paddl ?ler01.
Qed.

(* X_1' X_2 is the cost of the states X_1: it is not negative, so that X_1 has a kernel only if all is 0. *)
Let graph : exists (P M : 'M[R]_n),
  [/\ positive_semidefinite P, A = M + G *m P *m M, P = Q + A^T *m P *m M & inside (char_poly M)].
Proof.
have [V_1 [V_2 [S [rank_V upper lower isotropic inside_S]]]] := deflating.
pose Z := V_1^T *m V_2; have Z_T : Z^T = Z by rewrite /Z trmx_mul trmxK isotropic.
pose D := B^T *m V_2 *m S.
have Stein_Z : Z = S^T *m Z *m S + (V_1^T *m Q *m V_1 + D^T *m S_2 *m D).
  have {1}-> : Z = V_1^T *m Q *m V_1 + (A *m V_1)^T *m V_2 *m S.
    rewrite /Z -[V_2 in LHS](subrK (Q *m V_1)) lower mulmxDr addrC trmx_mul.
    by rewrite !mulmxA.
  rewrite upper trmx_mul linearD /= trmx_mul G_T mulmxDr !mulmxDl addrA [in RHS]addrA.
  rewrite [_ + V_1^T *m Q *m V_1]addrC /Z /D /G !trmx_mul !trmxK !mulmxA.
  by [].
have positive_Z : positive_semidefinite Z.
  apply: (lyapunov_semidefinite inside_S Z_T _ Stein_Z).
  have [s_1 p_1] := semidefinite_congruence V_1 positive_Q.
  have [s_2 p_2] := semidefinite_congruence D positive_S.
  by split=> [|x]; rewrite ?[(_ + _)^T]linearD /= ?s_1 ?s_2 // value_add addr_ge0.
have kernel (w : 'cV[R]_n) : V_1 *m w = 0 ->
    V_1 *m (S *m w) = 0 /\ V_2 *m w = (A + B *m K_0)^T *m (V_2 *m (S *m w)).
  move=> zero; have : value Z w = 0.
    by rewrite /value /bilinear /Z -!mulmxA (mulmxA V_1^T) isotropic -!mulmxA zero !mulmx0 mxE.
  rewrite Stein_Z !value_add /value !bilinear_congruence zero -!/(value _ _) => sum.
  have value_0 : value Q 0 = 0 by rewrite /value /bilinear mulmx0 mxE.
  have z_ge0 := positive_Z.2 (S *m w); have d_ge0 := positive_S.2 (D *m w).
  have d_0 : value S_2 (D *m w) = 0.
    move: sum; rewrite value_0 add0r => /eqP; rewrite paddr_eq0 // => /andP[_ /eqP].
    by [].
  have D0 : D *m w = 0.
    apply/eqP; apply: contraT => nz; have := (definite_inverse positive_R).2 _ nz.
    by rewrite d_0 ltxx.
  have D0' : B^T *m (V_2 *m (S *m w)) = 0 by rewrite !mulmxA.
  split.
    have := congr1 (mulmx^~ w) upper; rewrite -mulmxA zero mulmx0 -mulmxA mulmxDl.
    by rewrite /G -!mulmxA D0' !mulmx0 addr0.
  have := congr1 (mulmx^~ w) lower; rewrite mulmxBl -mulmxA zero mulmx0 subr0 => ->.
  by rewrite [(A + _)^T]linearD /= trmx_mul mulmxDl -[K_0^T *m _ *m _]mulmxA D0' mulmx0 addr0
    !mulmxA.
have unit_1 : V_1 \in unitmx.
  apply: unit_of_kernel => w zero; set As := (A + B *m K_0)^T in kernel.
  have powers k (v : 'cV[R]_n) : V_1 *m v = 0 ->
      V_1 *m (S ^+ k *m v) = 0 /\ V_2 *m v = As ^+ k *m (V_2 *m (S ^+ k *m v)).
    move=> zero_v; elim: k => [|k [IH_1 IH_2]]; first by rewrite !expr0 !mul1mx.
    have [step_1 step_2] := kernel _ IH_1; rewrite exprS -mulmxE -[S *m _ *m v]mulmxA step_1.
    by split=> //; rewrite IH_2 step_2 exprSr -mulmxE !mulmxA.
  pose r := reversed n (char_poly As).
  have inside_As : inside (char_poly As) by rewrite char_poly_tr; exact: stable_K.
  have unit_r : horner_mx S r \in unitmx.
    apply: horner_mx_unit; rewrite coprimep_sym; apply: apart => //.
      by rewrite monic_neq0 ?char_poly_monic.
    by apply: outside_reversed; rewrite ?char_poly_monic ?size_char_poly.
  have sum_1 : V_1 *m (horner_mx S r *m w) = 0.
    rewrite (horner_mx_wide S (size_reversed n _)) mulmx_suml mulmx_sumr big1 // => i _.
    by rewrite -scalemxAl -scalemxAr (powers _ _ zero).1 scaler0.
  have sum_2 : V_2 *m (horner_mx S r *m w) = 0.
    transitivity (horner_mx As (char_poly As) *m (V_2 *m (S ^+ n *m w))); last first.
      by rewrite Cayley_Hamilton mul0mx.
    rewrite (horner_mx_wide S (size_reversed n _)) (@horner_mx_wide _ _ As n.+1) ?size_char_poly //.
    rewrite !mulmx_suml mulmx_sumr (reindex_inj rev_ord_inj) /=; apply: eq_bigr => i _.
    have i_n : (i <= n)%N by rewrite -ltnS ltn_ord.
    rewrite subSS -!scalemxAl -scalemxAr coef_poly ltnS leq_subr subKn //; congr (_ *: _).
    have [zero_i _] := powers (n - i)%N _ zero; have [_ ->] := powers i _ zero_i.
    by rewrite [S ^+ i *m _]mulmxA mulmxE -exprD subnKC.
  have full_V : row_full (col_mx V_1 V_2) by rewrite /row_full rank_V.
  have : horner_mx S r *m w = 0.
    by apply: (row_full_inj full_V); rewrite mul_col_mx sum_1 sum_2 col_mx0 mulmx0.
  by move/(congr1 (mulmx (invmx (horner_mx S r)))); rewrite mulKmx // mulmx0.
pose P := V_2 *m invmx V_1; pose M := V_1 *m S *m invmx V_1.
have PV : P *m V_1 = V_2 by rewrite mulmxKV.
have MV : M *m V_1 = V_1 *m S by rewrite mulmxKV.
have positive_P : positive_semidefinite P.
  have -> : P = (invmx V_1)^T *m Z *m invmx V_1.
    by rewrite /Z /P !mulmxA -trmx_mul mulmxV // trmx1 mul1mx.
  exact: semidefinite_congruence.
clearbody P M; exists P, M; split; first exact: positive_P.
- apply: (can_inj (mulmxK unit_1)); rewrite upper [RHS]mulmxDl -[_ *m M *m V_1]mulmxA MV.
  by rewrite [LHS]mulmxDl -PV !mulmxA.
- apply: (can_inj (mulmxK unit_1)); rewrite mulmxDl -[_ *m M *m V_1]mulmxA MV PV.
  by rewrite -[LHS](subrK (Q *m V_1)) lower addrC -PV !mulmxA.
have nz : \det V_1 != 0 by rewrite -unitfE -unitmxE.
by rewrite -(char_poly_similar nz (esym MV)).
Qed.

Lemma standard_solution : exists P K,
  stabilising A Q B 0 R_2 P K /\ positive_semidefinite P.
Proof.
have [P [M [positive_P factored riccati inside_M]]] := graph.
pose K := - (S_2 *m B^T *m P *m M).
have closed : A + B *m K = M by rewrite mulmxN !mulmxA -/G {1}factored addrK.
have gain : innovation_weight B R_2 P *m K = - (0^T + B^T *m P *m A).
  rewrite trmx0 add0r factored /innovation_weight mulmxN mulmxDl mulmxDr; congr (- (_ + _)).
    by rewrite !mulmxA mulmxV // mul1mx.
  by rewrite /G !mulmxA.
exists P, K; split; last exact: positive_P.
split; last by rewrite closed; exact: inside_M.
split; [by case: positive_P | exact: gain |].
have WP_T : (innovation_weight B R_2 P)^T = innovation_weight B R_2 P.
  by rewrite /innovation_weight linearD /= !trmx_mul trmxK positive_P.1 positive_R.1 mulmxA.
have APB : A^T *m P *m B = - (K^T *m innovation_weight B R_2 P).
  have := congr1 trmx gain; rewrite trmx_mul WP_T => ->.
  by rewrite trmx0 add0r linearN /= opprK !trmx_mul trmxK positive_P.1 mulmxA.
rewrite {1}riccati -closed mulmxDr mulmxA APB mulNmx -mulmxA addrA [Q + _]addrC.
by rewrite !mulmxA.
Qed.
End Standard.

Section CrossWeight.
Variables (R : rcfType) (order m : nat).
Local Notation n := order.+1.
Variables (A R_1 : 'M[R]_n) (B R_12 : 'M[R]_(n, m)) (R_2 : 'M[R]_m).
Local Notation C M := (map_mx (real_complex R) M).

(* Some feedback has its poles inside the unit circle. *)
Definition stabilisable := exists K : 'M[R]_(m, n), inside (char_poly (A + B *m K)).

(* On the unit circle [A - zI B; R_1 R_12; R_12' R_2] has full column rank in x. With R_1 = E_1'E_1,
   R_12 = E_1'E_2 and R_2 = E_2'E_2 that is: z = E_1 x + E_2 u has no zeros there, unobservable
   eigenvalues included. *)
Definition no_zeros_on_the_circle := forall z (x : 'cV[R[i]]_n) (u : 'cV[R[i]]_m), `|z| = 1 ->
  C A *m x + C B *m u = z *: x -> C R_1 *m x + C R_12 *m u = 0 -> C R_12^T *m x + C R_2 *m u = 0 ->
  x = 0.

Theorem stabilising_solution : stabilisable -> no_zeros_on_the_circle ->
  positive_semidefinite (block_mx R_1 R_12 R_12^T R_2) -> positive_definite R_2 ->
  exists P K, [/\ stabilising A R_1 B R_12 R_2 P K, positive_semidefinite P,
    positive_definite (innovation_weight B R_2 P)
    & forall P' K', stabilising A R_1 B R_12 R_2 P' K' -> P' = P].
Proof.
move=> [K_0 stable_K] no_zeros joint positive_R; have unit_R := definite_invertible positive_R.
pose L := invmx R_2 *m R_12^T; have RL : R_2 *m L = R_12^T by rewrite mulKVmx.
have LR : L^T *m R_2 = R_12 by rewrite -{1}positive_R.1 -trmx_mul RL trmxK.
clearbody L; pose A_R := A - B *m L; pose R_h := R_1 - R_12 *m L.
have positive_h : positive_semidefinite R_h.
  have := semidefinite_congruence (col_mx 1%:M (- L)) joint.
  rewrite tr_col_mx mul_row_block mul_row_col trmx1 !mul1mx mulmx1 [(- L)^T]linearN /= !mulNmx LR.
  by rewrite subrr mul0mx addr0 -RL mulmxA LR.
have stable_h : inside (char_poly (A_R + B *m (K_0 + L))).
  by rewrite mulmxDr addrA addrAC subrK.
have seen z (x : 'cV[R[i]]_n) : `|z| = 1 -> C A_R *m x = z *: x -> C R_h *m x = 0 -> x = 0.
  rewrite map_mxB map_mxM mulmxBl -mulmxA => on_circle; rewrite -mulmxN => state.
  rewrite map_mxB map_mxM mulmxBl -mulmxA -mulmxN => weight.
  apply: (no_zeros z x (- (C L *m x))) => //.
  by rewrite mulmxN mulmxA -map_mxM RL subrr.
have [P [K [[[P_T gain riccati] in_K] positive_P]]] :=
  standard_solution positive_h positive_R stable_h seen.
exists P, (K - L); have closed : A + B *m (K - L) = A_R + B *m K.
  by rewrite mulmxBr addrA addrAC.
set W := innovation_weight B R_2 P in gain riccati *.
have W_T : W^T = W.
  by rewrite /W /innovation_weight linearD /= !trmx_mul trmxK P_T positive_R.1 mulmxA.
have positive_W : positive_definite W.
  by apply: definite_add => //; apply: semidefinite_congruence.
have WL : W *m L = R_12^T + B^T *m P *m B *m L by rewrite /W /innovation_weight mulmxDl RL.
have gain' : W *m (K - L) = - (R_12^T + B^T *m P *m A).
  rewrite mulmxBr gain WL trmx0 add0r /A_R mulmxBr !mulmxA.
  move: (B^T *m P *m A) (B^T *m P *m B *m L) R_12^T => a b c.
  by rewrite opprB [c + b]addrC [- (b + c)]opprD addrACA subrr add0r [RHS]opprD addrC.
have solution : stabilising A R_1 B R_12 R_2 P (K - L).
  split; last by rewrite closed.
  split=> //; rewrite -/W.
  have cross : A^T *m P *m B + R_12 = - ((K - L)^T *m W).
    have := congr1 trmx gain'; rewrite trmx_mul W_T => ->.
    by rewrite linearN /= opprK linearD /= trmxK !trmx_mul trmxK P_T mulmxA addrC.
  have moved : B^T *m P *m (A_R + B *m K) = - (R_2 *m K).
    rewrite mulmxDr mulmxA; have := gain; rewrite trmx0 add0r => /eqP;
      rewrite eq_sym eqr_oppLR => /eqP ->.
    by rewrite /W /innovation_weight mulmxDl opprD subrK.
  have short : P = A^T *m P *m (A + B *m (K - L)) + R_1 + R_12 *m (K - L).
    have split_P : P = A_R^T *m P *m (A_R + B *m K) + R_h.
      have APB : A_R^T *m P *m B = - (K^T *m W).
        have := congr1 trmx gain; rewrite trmx_mul W_T trmx0 add0r => ->.
        by rewrite linearN /= opprK !trmx_mul trmxK P_T mulmxA.
      by rewrite {1}riccati [_ *m (A_R + B *m K)]mulmxDr [A_R^T *m P *m (B *m K)]mulmxA APB mulNmx
        addrAC.
    rewrite {1}split_P closed /A_R [(A - _)^T]linearB /= trmx_mul mulmxBl mulmxBl -/A_R.
    rewrite -[L^T *m B^T *m P]mulmxA -[L^T *m (B^T *m P) *m _]mulmxA moved mulmxN opprK mulmxA LR.
    rewrite /R_h mulmxBr; move: (A^T *m P *m _) (R_12 *m K) (R_12 *m L) => a b c.
    by rewrite addrACA.
  have term : A^T *m P *m (B *m (K - L)) + R_12 *m (K - L) = - ((K - L)^T *m W *m (K - L)).
    by rewrite mulmxA -mulmxDl cross mulNmx.
  by rewrite {1}short [A^T *m P *m (A + _)]mulmxDr -term -[LHS]addrA addrACA.
split=> // P' K' stable'.
exact: (stabilising_solution_is_unique positive_R.1 stable' solution).
Qed.
End CrossWeight.
