(* The forward-propagating Riccati equation (8.96) converges: from every P(0) >= 0 the solution P(k) tends
   geometrically to the stabilising solution of (A.7), where (A, B) is stabilisable, (A, R_1)
   detectable, R_1 >= 0 and R_2 > 0. Over every real closed field, where bounded sequences need no
   limit: a Lyapunov function of the closed loop bounds P(k) - P from above, one of the observer and the
   cost of P(k) bound it from below. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices PositiveDefinite.
From Compensators.theorems Require Import HighAuthorityPoles Stein Riccati Lyapunov.
From Compensators.theorems Require Import StabilisingSolution ForwardRiccati.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Bounds.
Variable R : realFieldType.

(* The square of the length. *)
Definition square n (x : 'cV[R]_n) : R := value 1%:M x.

Lemma squareE n (x : 'cV[R]_n) : square x = \sum_i x i 0 ^+ 2.
Proof. by rewrite /square /value /bilinear mulmx1 mxE; apply: eq_bigr => i _; rewrite mxE. Qed.

Lemma square_ge0 n (x : 'cV[R]_n) : 0 <= square x.
Proof. by rewrite squareE sumr_ge0 // => i _; rewrite sqr_ge0. Qed.

Lemma square_mul m n (M : 'M[R]_(m, n)) x : square (M *m x) = value (M^T *m M) x.
Proof. by rewrite -[M^T]mulmx1 /value bilinear_congruence. Qed.

Lemma entry_square n (x : 'cV[R]_n) i : x i 0 ^+ 2 <= square x.
Proof. by rewrite squareE (bigD1 i) //= ler_addl sumr_ge0 // => j _; rewrite sqr_ge0. Qed.

Lemma product_small (a b s : R) : 0 <= a -> 0 <= b -> a ^+ 2 <= s -> b ^+ 2 <= s -> a * b <= s.
Proof.
move=> a_ge0 b_ge0 a_s b_s; have [ab|ba] := leP a b.
  by apply: le_trans b_s; rewrite expr2 ler_wpmul2r.
by apply: le_trans a_s; rewrite expr2 ler_wpmul2l // ltW.
Qed.

(* Every form is bounded by the length. *)
Lemma value_bounded n (M : 'M[R]_n) : exists2 c, 1 <= c & forall x, value M x <= c * square x.
Proof.
exists (1 + \sum_i \sum_j `|M j i|) => [|x].
  by rewrite ler_addl !sumr_ge0 // => i _; rewrite sumr_ge0.
rewrite mulrDl mul1r ler_paddl ?square_ge0 // /value /bilinear mxE mulr_suml; apply: ler_sum => i _.
rewrite mxE !mulr_suml; apply: ler_sum => j _; rewrite mxE.
apply: le_trans (ler_norm _) _; rewrite !normrM mulrAC [X in X <= _]mulrC.
rewrite ler_wpmul2l ?normr_ge0 //.
apply: product_small; rewrite ?normr_ge0 // real_normK ?num_real // ?entry_square //.
Qed.

Lemma value_sub n (M N : 'M[R]_n) x : value (M - N) x = value M x - value N x.
Proof. by rewrite value_add -scaleN1r value_scale mulN1r. Qed.

Lemma value_scaled n c (M : 'M[R]_n) (x : 'cV[R]_n) : value M (c *: x) = c ^+ 2 * value M x.
Proof.
have ET : (c *: x)^T = c *: x^T by rewrite linearZ.
by rewrite /value /bilinear ET -!scalemxAl -scalemxAr !mxE mulrA expr2.
Qed.

Lemma bilinear_scaled n c (M : 'M[R]_n) (b a : 'cV[R]_n) : bilinear M (c *: b) a = c * bilinear M b a.
Proof.
have ET : (c *: b)^T = c *: b^T by rewrite linearZ.
by rewrite /bilinear ET -!scalemxAl mxE.
Qed.

(* |M x|^2 is bounded by the value of M >= 0 at x. *)
Lemma image_bounded n (M : 'M[R]_n) : positive_semidefinite M ->
  exists2 c, 0 <= c & forall x, square (M *m x) <= c * value M x.
Proof.
move=> [symmetric positive]; have [c c_ge1 bound] := value_bounded M.
have c_gt0 : 0 < c by rewrite (lt_le_trans ltr01).
exists c => [|x]; first exact: ltW.
have := positive (x + (- c^-1) *: (M *m x)); rewrite value_shift // value_scaled bilinear_scaled.
have -> : bilinear M (M *m x) x = square (M *m x).
  by rewrite /bilinear /square /value /bilinear trmx_mul symmetric mulmx1 -!mulmxA.
have := bound (M *m x); move: (value M (M *m x)) (square (M *m x)) (value M x) => w s v w_s sum.
rewrite -(ler_pmul2l (_ : 0 < c^-1)) ?invr_gt0 // mulrA mulVf ?gt_eqF // mul1r.
rewrite -subr_ge0; apply: le_trans sum _; rewrite sqrrN expr2.
have -> : v - c^-1 * s = v + 2%:R * (- c^-1 * s) + c^-1 * s by ring.
rewrite ler_add2l -mulrA ler_wpmul2l ?invr_ge0 ?(ltW c_gt0) //.
by rewrite -(ler_pmul2l c_gt0) mulrA mulfV ?gt_eqF // mul1r.
Qed.

Lemma square_bounded m n (M : 'M[R]_(m, n)) :
  exists2 c, 0 <= c & forall x, square (M *m x) <= c * square x.
Proof.
have [c c_ge1 bound] := value_bounded (M^T *m M); exists c; first exact: le_trans ler01 c_ge1.
by move=> x; rewrite square_mul.
Qed.

(* A form between the two arguments of a sum. *)
Lemma value_of_sum n (M : 'M[R]_n) x d t : positive_semidefinite M -> 0 < t ->
  value M (x + d) <= (1 + t) * value M x + (1 + t^-1) * value M d.
Proof.
move=> [symmetric positive] t_gt0; have := positive (x + (- t^-1) *: d).
rewrite !value_shift // value_scaled bilinear_scaled sqrrN expr2.
move: (value M x) (bilinear M d x) (value M d) => a b c; rewrite -(pmulr_rge0 _ t_gt0) => sum.
rewrite -subr_ge0; apply: le_trans sum _; rewrite le_eqVlt; apply/orP; left; apply/eqP.
have nz : t != 0 by rewrite gt_eqF.
by field.
Qed.

(* A symmetric matrix whose form is small is small. *)
Lemma entries_bounded n (M : 'M[R]_n) c : M^T = M ->
  (forall x, `|value M x| <= c * square x) -> forall i j, `|M i j| <= 2%:R * c.
Proof.
move=> symmetric small i j; pose e k : 'cV[R]_n := delta_mx k 0.
have square_e k : square (e k) = 1.
  rewrite squareE (bigD1 k) //= big1 => [|l other]; first by rewrite mxE !eqxx expr1n addr0.
  by rewrite mxE (negPf other) expr0n.
have entry : bilinear M (e i) (e j) = M i j.
  have ET : (e i)^T = delta_mx 0 i by apply/matrixP=> k l; rewrite !mxE andbC.
  by rewrite /bilinear ET -rowE -colE !mxE.
have crossed (N : 'M[R]_n) : N^T = N ->
    4%:R * bilinear N (e i) (e j) = value N (e j + e i) - value N (e j + (-1) *: e i).
  move=> N_T; rewrite !value_shift // value_scaled bilinear_scaled.
  by move: (value N (e j)) (value N (e i)) (bilinear N (e i) (e j)) => a b d; ring.
have sum : square (e j + e i) + square (e j + (-1) *: e i) = 4%:R.
  rewrite /square !value_shift ?trmx1 // value_scaled bilinear_scaled -!/(square _) !square_e.
  by move: (bilinear _ _ _) => b; ring.
have four : (0 : R) < 4%:R by rewrite ltr0n.
rewrite -(ler_pmul2l four) -{1}(ger0_norm (ltW four)) -normrM -entry crossed //.
have -> : 4%:R * (2%:R * c) = 2%:R * (c * (square (e j + e i) + square (e j + (-1) *: e i))).
  by rewrite sum; ring.
rewrite mulrDr; apply: le_trans (ler_norm_sub _ _) _.
apply: le_trans (ler_add (small _) (small _)) _; rewrite mulrDr !mulr_natl !mulr2n.
have := small (e j + e i); have := small (e j + (-1) *: e i).
move: (c * _) (c * _) => s t /(le_trans (normr_ge0 _)) s_ge0 /(le_trans (normr_ge0 _)) t_ge0.
by rewrite ler_add // ler_addl.
Qed.
End Bounds.

Section Steps.
Variables (R : realFieldType) (n m : nat).
Variables (A R_1 P : 'M[R]_n) (B : 'M[R]_(n, m)) (R_2 : 'M[R]_m).
Hypotheses (P_pos : positive_semidefinite P) (R_2_pos : positive_definite R_2).
Local Notation K := (forward_gain A P B R_2).
Local Notation W := (R_2 + B^T *m P *m B).

(* What a step costs. *)
Definition running_cost (x : 'cV[R]_n) (u : 'cV[R]_m) := value R_1 x + value R_2 u.

Lemma step_attained x :
  value (forward_step A P R_1 B R_2) x = value P ((A + B *m K) *m x) + running_cost x (K *m x).
Proof.
rewrite forward_step_with_gain // !value_add /running_cost /value !bilinear_congruence.
by rewrite -addrA [bilinear R_1 _ _ + _]addrC.
Qed.

Lemma step_optimal x u :
  value (forward_step A P R_1 B R_2) x <= value P (A *m x + B *m u) + running_cost x u.
Proof.
have [P_T _] := P_pos; have [R_T _] := R_2_pos.
have W_pos : positive_definite W by apply: definite_add => //; apply: semidefinite_congruence.
pose d := u - K *m x; have Eu : u = K *m x + d by rewrite addrC subrK.
clearbody d.
have -> : A *m x + B *m u = (A + B *m K) *m x + B *m d.
  by rewrite Eu mulmxDr mulmxDl addrA mulmxA.
rewrite step_attained /running_cost Eu !value_shift //.
have gain : W *m K = - (B^T *m P *m A).
  by rewrite /forward_gain mulmxN !mulmxA mulmxV ?definite_invertible // mul1mx.
have orthogonal : bilinear P (B *m d) ((A + B *m K) *m x) + bilinear R_2 d (K *m x) = 0.
  transitivity ((d^T *m (B^T *m P *m A + W *m K) *m x) 0 0); last first.
    by rewrite gain subrr mulmx0 mul0mx mxE.
  rewrite /bilinear trmx_mul !(mulmxDl, mulmxDr) !mulmxA.
  move: (d^T *m B^T *m P *m A *m x) (d^T *m B^T *m P *m B *m K *m x) (d^T *m R_2 *m K *m x).
  by move=> a b c; rewrite !mxE addrAC -addrA.
have least : 0 <= value P (B *m d) + value R_2 d.
  by rewrite addr_ge0 ?(P_pos.2) ?(definite_semidefinite R_2_pos).2.
move: orthogonal least; move: (bilinear P _ _) (bilinear R_2 _ _) (value P (B *m d)) (value R_2 d).
move=> a b c e sum least; rewrite -subr_ge0; apply: le_trans least _.
move: (value P _) (value R_1 x) (value R_2 _) => f g h; rewrite le_eqVlt; apply/orP; left; apply/eqP.
have -> : a = - b by apply/eqP; rewrite -addr_eq0 sum.
by ring.
Qed.
End Steps.

Section Convergence.
Variables (R : rcfType) (order m : nat).
Local Notation n := order.+1.
Variables (A R_1 : 'M[R]_n) (B : 'M[R]_(n, m)) (R_2 : 'M[R]_m).
Local Notation step P := (forward_step A P R_1 B R_2).

(* Some injection of what R_1 weighs has its poles inside the unit circle. *)
Definition detectable := exists L : 'M[R]_n, inside (char_poly (A + L *m R_1)).

Hypothesis R_1_pos : positive_semidefinite R_1.
Hypothesis R_2_pos : positive_definite R_2.

Lemma stabilising_is_fixed P K : stabilising A R_1 B 0 R_2 P K -> positive_semidefinite P ->
  step P = P.
Proof.
move=> [[P_T gain riccati] _] P_pos; set W := innovation_weight B R_2 P in gain riccati.
have W_pos : positive_definite W by apply: definite_add => //; apply: semidefinite_congruence.
have EK : K = - (invmx W *m (B^T *m P *m A)).
  by rewrite -[K](mulKmx (definite_invertible W_pos)) gain trmx0 add0r mulmxN.
rewrite [RHS]riccati /forward_step -!/(innovation_weight B R_2 P) -!/W; congr (_ - _).
rewrite -[K^T *m W *m K]mulmxA gain trmx0 add0r EK mulmxN linearN /= mulNmx opprK trmx_mul trmx_inv W_pos.1.
by rewrite !trmx_mul trmxK P_T !mulmxA.
Qed.

(* A Lyapunov function of a matrix whose eigenvalues are inside. *)
Lemma lyapunov_function (M : 'M[R]_n) : inside (char_poly M) -> exists2 X : 'M[R]_n,
  positive_semidefinite X & forall x, value X (M *m x) = value X x - square x.
Proof.
move=> in_M; have in_MT : inside (char_poly M^T) by rewrite char_poly_tr.
have [X [E X_T _]] := lyapunov_4_23 in_MT (trmx1 _ n); rewrite trmxK in E.
have one : positive_semidefinite (1%:M : 'M[R]_n) by split; [exact: trmx1 | exact: square_ge0].
exists X => [|x]; first exact: lyapunov_semidefinite in_M X_T one E.
by rewrite {2}E value_add -/(square x) addrK {2}/value bilinear_congruence.
Qed.

Lemma lyapunov_large (M X : 'M[R]_n) : positive_semidefinite X ->
  (forall x, value X (M *m x) = value X x - square x) -> forall x, square x <= value X x.
Proof. by move=> [_ positive] decreases x; rewrite -subr_ge0 -decreases. Qed.

(* Detectability: a form that every step with a small cost makes smaller. *)
Lemma detecting_form : detectable -> exists X c, [/\ 0 <= c,
  (forall x, square x <= value X x) & forall x u, value X (A *m x + B *m u)
    <= value X x - 2%:R^-1 * square x + c * running_cost R_1 R_2 x u].
Proof.
move=> [L in_L]; have [X X_pos decreases] := lyapunov_function in_L.
have [v v_ge1 small] := value_bounded X; have v_gt0 : 0 < v := lt_le_trans ltr01 v_ge1.
have [b b_ge0 small_B] := square_bounded B; have [l l_ge0 small_L] := square_bounded L.
have [r r_ge0 small_1] := image_bounded R_1_pos.
have [s s_ge0 small_2] := image_bounded (definite_semidefinite R_2_pos).
have [t t_ge0 small_i] := square_bounded (invmx R_2).
have one : positive_semidefinite (1%:M : 'M[R]_n) by split; [exact: trmx1 | exact: square_ge0].
pose a := 1 + (2%:R * v); pose c := a * (v * (2%:R * (b * (t * s) + l * r))).
have a_ge0 : 0 <= a by rewrite addr_ge0 ?ler01 // mulr_ge0 ?ler0n ?(ltW v_gt0).
have two : (0 : R) < 2%:R by rewrite ltr0n.
exists X, c; split=> //.
- by rewrite mulr_ge0 // mulr_ge0 ?(ltW v_gt0) // mulr_ge0 ?ler0n // addr_ge0 ?mulr_ge0.
- exact: lyapunov_large decreases.
move=> x u; pose d := B *m u - L *m (R_1 *m x).
have -> : A *m x + B *m u = (A + L *m R_1) *m x + d.
  by rewrite mulmxDl -mulmxA addrA addrAC addrK.
have cost_1 : 0 <= value R_1 x by apply: R_1_pos.2.
have cost_2 : 0 <= value R_2 u by apply: (definite_semidefinite R_2_pos).2.
have small_u : square u <= t * s * value R_2 u.
  rewrite -{1}[u](mulKmx (definite_invertible R_2_pos)); apply: le_trans (small_i _) _.
  by rewrite -mulrA ler_wpmul2l.
have small_d : square d <= 2%:R * (b * (t * s) + l * r) * running_cost R_1 R_2 x u.
  have := value_of_sum (B *m u) (- (L *m (R_1 *m x))) one ltr01; rewrite invr1 -!/(square _).
  have -> : square (- (L *m (R_1 *m x))) = square (L *m (R_1 *m x)).
    by rewrite -scaleN1r /square value_scaled sqrrN expr1n mul1r.
  have -> : 1 + 1 = 2%:R :> R by rewrite -mulr2n.
  rewrite -mulrDr => /le_trans; apply; rewrite -mulrA ler_wpmul2l ?(ltW two) //.
  have first : square (B *m u) <= b * (t * s) * value R_2 u.
    by apply: le_trans (small_B _) _; rewrite -mulrA ler_wpmul2l.
  have second : square (L *m (R_1 *m x)) <= l * r * value R_1 x.
    by apply: le_trans (small_L _) _; rewrite -mulrA ler_wpmul2l.
  apply: le_trans (ler_add first second) _; rewrite /running_cost -subr_ge0.
  have -> : (b * (t * s) + l * r) * (value R_1 x + value R_2 u)
      - (b * (t * s) * value R_2 u + l * r * value R_1 x)
      = b * (t * s) * value R_1 x + l * r * value R_2 u by ring.
  by rewrite addr_ge0 // !mulr_ge0.
apply: le_trans (value_of_sum _ _ X_pos (_ : 0 < (2%:R * v)^-1)) _.
  by rewrite invr_gt0 mulr_gt0.
rewrite decreases invrK -/a -[c * _]mulrA; apply: ler_add; last first.
  rewrite ler_wpmul2l // -mulrA; apply: le_trans (small d) _.
  by rewrite ler_wpmul2l ?(ltW v_gt0).
have := small x; have := square_ge0 x; move: (value X x) (square x) => w q q_ge0 w_q.
rewrite mulrDl mul1r -addrA ler_add2l.
have -> : - (2%:R^-1 * q) = - q + (2%:R * v)^-1 * (v * q).
  by field; rewrite gt_eqF.
rewrite ler_add2l ler_wpmul2l ?invr_ge0 ?mulr_ge0 ?ler0n ?(ltW v_gt0) //.
by rewrite ler_subl_addr ler_paddr.
Qed.

Lemma detectable_sees : detectable -> no_zeros_on_the_circle A R_1 B 0 R_2.
Proof.
move=> [L in_L] z x u on_circle; rewrite trmx0 !map_mx0 mul0mx mul0mx addr0 add0r => state weight input.
have u0 : u = 0.
  rewrite -[u]mul1mx -(map_mx1 [rmorphism of real_complex R]).
  by rewrite -(mulVmx (definite_invertible R_2_pos)) map_mxM -mulmxA input mulmx0.
apply/eqP; apply: contraT => nz_x.
have /in_L : root (map_poly (real_complex R) (char_poly (A + L *m R_1))) z.
  rewrite -char_poly_complex; apply: root_of_eigencolumn nz_x.
  by rewrite map_mxD mulmxDl -state u0 mulmx0 addr0 map_mxM -mulmxA weight mulmx0 addr0.
by rewrite on_circle ltxx.
Qed.

(* A form that loses half the square of the length loses a share of itself. *)
Lemma loses_a_share (X : 'M[R]_n) phi w x : 0 < phi -> value X x <= phi * square x ->
  w <= value X x - 2%:R^-1 * square x -> w <= (1 - (2%:R * phi)^-1) * value X x.
Proof.
move=> phi_gt0 small; move=> /le_trans; apply; rewrite mulrBl mul1r ler_add2l ler_opp2.
rewrite invfM -mulrA ler_wpmul2l ?invr_ge0 ?ler0n // -(ler_pmul2l phi_gt0) mulrA mulfV ?gt_eqF //.
by rewrite mul1r.
Qed.

Section Limit.
Variables (P P_0 Y X : 'M[R]_n) (p p_0 y v c : R).
Local Notation K := (forward_gain A P B R_2).
Local Notation P_ k := (iter k (fun P => step P) P_0).
Hypotheses (P_pos : positive_semidefinite P) (P_fixed : step P = P).
Hypothesis P_0_pos : positive_semidefinite P_0.
Hypotheses (p_ge1 : 1 <= p) (P_small : forall x, value P x <= p * square x).
Hypotheses (p_0_ge1 : 1 <= p_0) (P_0_small : forall x, value P_0 x <= p_0 * square x).
(* A Lyapunov function of the optimal loop, and a detecting form. *)
Hypothesis Y_pos : positive_semidefinite Y.
Hypothesis Y_decreases : forall x, value Y ((A + B *m K) *m x) = value Y x - square x.
Hypotheses (y_ge1 : 1 <= y) (Y_small : forall x, value Y x <= y * square x).
Hypothesis c_ge0 : 0 <= c.
Hypothesis X_large : forall x, square x <= value X x.
Hypothesis X_decreases : forall x u, value X (A *m x + B *m u)
  <= value X x - 2%:R^-1 * square x + c * running_cost R_1 R_2 x u.
Hypotheses (v_ge1 : 1 <= v) (X_small : forall x, value X x <= v * square x).

Let iterate_pos k : positive_semidefinite (P_ k).
Proof. exact: forward_riccati_is_semidefinite. Qed.

Let Y_large x : square x <= value Y x. Proof. exact: lyapunov_large Y_decreases x. Qed.

(* P(k) - P from above, with the gain of P in every step. *)
Lemma gap_above r k x : 0 <= r -> (forall x, value Y ((A + B *m K) *m x) <= r * value Y x) ->
  value (P_ k) x - value P x <= p_0 * r ^+ k * value Y x.
Proof.
move=> r_ge0 shrinks; elim: k x => [|k IH] x /=.
  rewrite expr0 mulr1; apply: le_trans (_ : value P_0 x <= _); first by rewrite ler_subl_addr ler_addl P_pos.2.
  by apply: le_trans (P_0_small x) _; rewrite ler_wpmul2l // (le_trans ler01).
have := step_optimal A R_1 B (iterate_pos k) R_2_pos x (K *m x).
rewrite mulmxA -mulmxDl => above.
have := step_attained A R_1 B P_pos R_2_pos x; rewrite P_fixed => ->.
apply: le_trans (ler_add above (lexx _)) _; rewrite opprD addrACA subrr addr0.
apply: le_trans (IH _) _; rewrite exprSr mulrA -[_ * r * _]mulrA ler_wpmul2l //.
by rewrite mulr_ge0 ?exprn_ge0 // (le_trans ler01).
Qed.

Let phi := v + c * (p + p_0 * y) + y.

Let phi_ge1 : 1 <= phi.
Proof.
have y_ge0 := le_trans ler01 y_ge1; have p_ge0 := le_trans ler01 p_ge1.
have p_0_ge0 := le_trans ler01 p_0_ge1.
by rewrite /phi -addrA ler_paddr // addr_ge0 // mulr_ge0 // addr_ge0 // mulr_ge0.
Qed.
Let phi_gt0 : 0 < phi. Proof. exact: lt_le_trans ltr01 phi_ge1. Qed.
Let rho := 1 - (2%:R * phi)^-1.

Lemma rho_below_1 : 0 <= rho < 1.
Proof.
have twice : 1 <= 2%:R * phi.
  by apply: le_trans phi_ge1 _; rewrite ler_pmull // ler1n.
have twice_gt0 := lt_le_trans ltr01 twice.
by rewrite subr_ge0 invf_le1 // twice /= ltr_subl_addr ltr_addl invr_gt0.
Qed.

Let rho_ge0 : 0 <= rho. Proof. by case/andP: rho_below_1. Qed.

(* What a trajectory has left to pay, in detecting form and cost. *)
Let left_over k x := value X x + c * value (P_ k) x.

Let left_over_small k x : left_over k x <= phi * square x.
Proof.
have same z : value Y ((A + B *m K) *m z) <= 1 * value Y z.
  by rewrite mul1r Y_decreases ler_subl_addr ler_addl square_ge0.
have := gap_above k x ler01 same; rewrite expr1n mulr1 ler_subl_addr addrC => bound.
have y_ge0 : 0 <= y by apply: le_trans ler01 _.
have p_0_ge0 : 0 <= p_0 by apply: le_trans ler01 _.
rewrite /left_over /phi !mulrDl -[X in X <= _]addr0; apply: ler_add; last by rewrite mulr_ge0 ?square_ge0.
apply: ler_add; first exact: X_small.
rewrite -mulrA ler_wpmul2l //; apply: le_trans bound _; rewrite mulrDl ler_add //.
by rewrite -mulrA ler_wpmul2l.
Qed.

(* P - P(k), with the gain of P(k) in every step. *)
Lemma gap_below k x : value P x - value (P_ k) x <= p * rho ^+ k * left_over k x.
Proof.
have p_ge0 : 0 <= p by apply: le_trans ler01 _.
elim: k x => [|k IH] x.
  rewrite expr0 mulr1; apply: le_trans (_ : value P x <= _).
    by rewrite ler_subl_addr ler_addl P_0_pos.2.
  apply: le_trans (P_small x) _; rewrite ler_wpmul2l //; apply: le_trans (X_large x) _.
  by rewrite /left_over ler_addl mulr_ge0 ?P_0_pos.2.
pose L := forward_gain A (P_ k) B R_2; have attained := step_attained A R_1 B (iterate_pos k) R_2_pos x.
have := step_optimal A R_1 B P_pos R_2_pos x (L *m x); rewrite P_fixed mulmxA -mulmxDl => above.
rewrite {1}[P_ k.+1]iterS attained -/L; apply: le_trans (ler_add above (lexx _)) _.
rewrite opprD addrACA subrr addr0; apply: le_trans (IH _) _.
rewrite exprSr [p * (_ * _)]mulrA -[_ * rho * _]mulrA ler_wpmul2l ?mulr_ge0 ?exprn_ge0 //.
have small := left_over_small k.+1 x.
have next : left_over k ((A + B *m L) *m x) <= left_over k.+1 x - 2%:R^-1 * square x.
  have := X_decreases x (L *m x); rewrite mulmxA -mulmxDl => decreases.
  rewrite /left_over iterS attained -/L; apply: le_trans (ler_add decreases (lexx _)) _.
  move: (running_cost _ _ _ _) (value (P_ k) _) (value X x) (_ * square x) => f g w q.
  by have -> : w - q + c * f + c * g = w + c * (g + f) - q by ring.
apply: le_trans next _; rewrite /rho mulrBl mul1r ler_add2l ler_opp2.
rewrite invfM -mulrA ler_wpmul2l ?invr_ge0 ?ler0n // -(ler_pmul2l phi_gt0) mulrA mulfV ?gt_eqF //.
by rewrite mul1r.
Qed.

Lemma gap k x : `|value (P_ k - P) x| <= (p_0 * y + p * phi) * rho ^+ k * square x.
Proof.
have y_ge0 : 0 <= y by apply: le_trans ler01 _.
have p_ge0 : 0 <= p by apply: le_trans ler01 _.
have p_0_ge0 : 0 <= p_0 by apply: le_trans ler01 _.
have share z : value Y ((A + B *m K) *m z) <= rho * value Y z.
  apply: (loses_a_share phi_gt0).
    apply: le_trans (Y_small z) _; rewrite ler_wpmul2r ?square_ge0 // /phi ler_addr.
    by rewrite addr_ge0 ?(le_trans ler01 v_ge1) // mulr_ge0 // addr_ge0 // mulr_ge0.
  rewrite Y_decreases ler_add2l ler_opp2 ler_pimull ?square_ge0 //.
  by rewrite invf_le1 ?ler1n ?ltr0n.
have rk_ge0 : 0 <= rho ^+ k by rewrite exprn_ge0.
have q_ge0 := square_ge0 x; have phi_ge0 := ltW phi_gt0.
rewrite value_sub ler_norml ler_oppl opprB; apply/andP; split.
  apply: le_trans (gap_below k x) _.
  apply: le_trans (_ : p * rho ^+ k * (phi * square x) <= _).
    by rewrite ler_wpmul2l ?left_over_small // mulr_ge0.
  move: (rho ^+ k) (square x) phi rk_ge0 q_ge0 phi_ge0 => r q f *.
  rewrite -subr_ge0; have -> : (p_0 * y + p * f) * r * q - p * r * (f * q) = p_0 * y * (r * q) by ring.
  by rewrite !mulr_ge0.
apply: le_trans (gap_above k x rho_ge0 share) _.
apply: le_trans (_ : p_0 * rho ^+ k * (y * square x) <= _).
  by rewrite ler_wpmul2l ?mulr_ge0.
move: (rho ^+ k) (square x) phi rk_ge0 q_ge0 phi_ge0 => r q f *.
rewrite -subr_ge0; have -> : (p_0 * y + p * f) * r * q - p_0 * r * (y * q) = p * f * (r * q) by ring.
by rewrite !mulr_ge0.
Qed.
End Limit.

(* From every P(0) >= 0, geometrically, entry by entry. *)
Theorem forward_riccati_converges : stabilisable A B -> detectable -> exists P K,
  [/\ stabilising A R_1 B 0 R_2 P K, positive_semidefinite P
    & forall P_0, positive_semidefinite P_0 -> exists c rho, 0 <= rho < 1 /\
      forall k i j, `|(iter k (fun P => step P) P_0 - P) i j| <= c * rho ^+ k].
Proof.
move=> stable detects.
have joint : positive_semidefinite (block_mx R_1 0 (0 : 'M_(n, m))^T R_2).
  split=> [|x]; first by rewrite tr_block_mx !trmx0 R_1_pos.1 R_2_pos.1.
  rewrite -[x]vsubmxK /value /bilinear tr_col_mx trmx0 mul_row_block !mulmx0 addr0 add0r.
  rewrite mul_row_col mxE addr_ge0 //; first exact: R_1_pos.2.
  exact: (definite_semidefinite R_2_pos).2.
have [P [K [stab P_pos _ _]]] :=
  stabilising_solution stable (detectable_sees detects) joint R_2_pos.
have fixed := stabilising_is_fixed stab P_pos.
have in_P : inside (char_poly (A + B *m forward_gain A P B R_2)).
  case: stab => -[_ gain _]; set W := innovation_weight B R_2 P in gain *.
  have W_pos : positive_definite W by apply: definite_add => //; apply: semidefinite_congruence.
  suff -> : forward_gain A P B R_2 = K by [].
  rewrite -[K](mulKmx (definite_invertible W_pos)) gain trmx0 add0r mulmxN /forward_gain.
  by rewrite !mulmxA.
have [Y Y_pos decreases] := lyapunov_function in_P.
have [X [c [c_ge0 X_large X_decreases]]] := detecting_form detects.
have [p p_ge1 P_small] := value_bounded P; have [y y_ge1 Y_small] := value_bounded Y.
have [v v_ge1 X_small] := value_bounded X.
exists P, K; split=> // P_0 P_0_pos; have [p_0 p_0_ge1 P_0_small] := value_bounded P_0.
pose phi := v + c * (p + p_0 * y) + y; pose rho := 1 - (2%:R * phi)^-1.
exists (2%:R * (p_0 * y + p * phi)), rho; split.
  exact: (rho_below_1 p_ge1 p_0_ge1 y_ge1 c_ge0 v_ge1).
move=> k i j; rewrite -mulrA; apply: entries_bounded => [|x].
  rewrite [(_ - _)^T]linearB /= P_pos.1; congr (_ - _).
  by have [] := forward_riccati_is_semidefinite A B k P_0_pos R_1_pos R_2_pos.
exact: (gap P_pos fixed P_0_pos p_ge1 P_small p_0_ge1 P_0_small Y_pos decreases y_ge1 Y_small c_ge0
  X_large X_decreases v_ge1 X_small).
Qed.
End Convergence.
