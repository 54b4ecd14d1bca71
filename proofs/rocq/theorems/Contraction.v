(* Contraction of a loop that varies in time: one P in whose length every A_k shortens every vector by a
   rate. The motion then decays at that rate, in whatever order the A_k come; a polytope of loops contracts
   where its vertices do; a strict inequality has a rate below 1, over any ordered field; and a constant
   loop that contracts has its poles in the circle of that radius. r is the square of the rate. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices PositiveDefinite.
From Compensators.theorems Require Import HighAuthorityPoles Lyapunov StabilisingSolution.
From Compensators.theorems Require Import ForwardConvergence.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma value_congruence (R : realFieldType) m n (M : 'M[R]_n) (Phi : 'M[R]_(n, m)) x :
  value (Phi^T *m M *m Phi) x = value M (Phi *m x).
Proof. exact: bilinear_congruence. Qed.

Section Forms.
Variables (R : realFieldType) (n : nat).
Implicit Types (P Q G : 'M[R]_n) (v x y : 'cV[R]_n).

(* (d' y)^2 <= d' S d  y' S^-1 y. *)
Lemma cauchy_schwarz (S : 'M[R]_n) d y : positive_definite S ->
  (d^T *m y) 0 0 ^+ 2 <= value S d * value (invmx S) y.
Proof.
move=> definite; have [symmetric positive] := definite.
have unit_S := definite_invertible definite; have [_ nonneg] := definite_semidefinite definite.
have [d0|nz_d] := eqVneq d 0.
  by rewrite d0 trmx0 mul0mx mxE expr0n /value /bilinear trmx0 !mul0mx mxE mul0r.
have a_gt0 := positive d nz_d; set b := (d^T *m y) 0 0; pose z := invmx S *m y.
have cross : bilinear S d z = b by rewrite /bilinear -mulmxA mulKVmx.
have square_z : value S z = value (invmx S) y.
  by rewrite /value /bilinear trmx_mul trmx_inv symmetric mulmxKV // mulmxA.
have := nonneg (z + (- (b / value S d)) *: d).
rewrite value_shift // value_scaled bilinear_scaled cross square_z.
move: (value S d) (value _ y) a_gt0 => a c a_gt0.
have -> : c + 2%:R * (- (b / a) * b) + (- (b / a)) ^+ 2 * a = (a * c - b ^+ 2) / a.
  by field; rewrite gt_eqF.
by rewrite pmulr_lge0 ?invr_gt0 // subr_ge0.
Qed.

(* Every form is below some multiple of a definite one. *)
Lemma definite_dominates Q G : positive_definite Q ->
  exists2 t, 1 <= t & forall y, value G y <= t * value Q y.
Proof.
move=> definite; have [symmetric _] := definite; have unit_Q := definite_invertible definite.
have [b b_ge1 G_b] := value_bounded G; have b_ge0 : 0 <= b := le_trans ler01 b_ge1.
have [c c_ge0 Q_c] := image_bounded (definite_semidefinite (definite_inverse definite)).
have [_ Q_ge0] := definite_semidefinite definite.
exists (b * c + 1) => [|y]; first by rewrite ler_addr mulr_ge0.
have lower : square y <= c * value Q y.
  have := Q_c (Q *m y); rewrite mulKmx //.
  by rewrite [value (invmx Q) _]/value /bilinear trmx_mul symmetric -[_ *m invmx Q *m _]mulmxA mulKmx.
apply: le_trans (G_b y) _; rewrite mulrDl mul1r.
by apply: le_trans (ler_wpmul2l b_ge0 lower) _; rewrite mulrA ler_addl.
Qed.

(* Jensen's inequality. *)
Lemma value_is_convex P N (w : 'I_N -> R) (y : 'I_N -> 'cV[R]_n) : positive_semidefinite P ->
  (forall i, 0 <= w i) -> \sum_i w i = 1 ->
  value P (\sum_i w i *: y i) <= \sum_i w i * value P (y i).
Proof.
case=> symmetric nonneg w_ge0 total; set z := \sum_i _.
have expand i : value P (y i + (-1) *: z) = value P (y i) - 2%:R * bilinear P z (y i) + value P z.
  by rewrite value_shift // value_scaled bilinear_scaled; ring.
have mean : \sum_i w i * bilinear P z (y i) = value P z.
  rewrite [RHS]/value [RHS]/bilinear {3}/z mulmx_sumr summxE; apply: eq_bigr => i _.
  by rewrite -scalemxAr [RHS]mxE.
have : 0 <= \sum_i w i * value P (y i + (-1) *: z) by apply: sumr_ge0 => i _; rewrite mulr_ge0.
have -> : \sum_i w i * value P (y i + (-1) *: z)
    = \sum_i w i * value P (y i) - 2%:R * (\sum_i w i * bilinear P z (y i)) + (\sum_i w i) * value P z.
  rewrite mulr_sumr mulr_suml -sumrB -big_split /=; apply: eq_bigr => i _.
  by rewrite expand; ring.
rewrite mean total => nonneg_mean; rewrite -subr_ge0.
by apply: le_trans nonneg_mean _; rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
Qed.
End Forms.

Section Contraction.
Variables (R : realFieldType) (n : nat).
Implicit Types (P A : 'M[R]_n) (r : R) (x : nat -> 'cV[R]_n).

(* A' P A <= r P. *)
Definition contracts P r A := positive_semidefinite (r *: P - A^T *m P *m A).

Lemma contractsP P r A : P^T = P ->
  contracts P r A <-> forall v, value P (A *m v) <= r * value P v.
Proof.
move=> symmetric.
have gap v : value (r *: P - A^T *m P *m A) v = r * value P v - value P (A *m v).
  by rewrite value_sub value_scale value_congruence.
split=> [[_ nonneg] v|shorter]; first by rewrite -subr_ge0 -gap.
by split=> [|v]; rewrite ?gap ?subr_ge0 // linearB linearZ /= !trmx_mul trmxK symmetric mulmxA.
Qed.

(* The A_k may be any that contract in one P, which need not be definite. *)
Theorem motion_contracts P r (A : nat -> 'M[R]_n) x : 0 <= r -> P^T = P ->
  (forall k, contracts P r (A k)) -> (forall k, x k.+1 = A k *m x k) ->
  forall k, value P (x k) <= r ^+ k * value P (x 0%N).
Proof.
move=> r_ge0 symmetric shorter moves; elim=> [|k IH]; first by rewrite expr0 mul1r.
have /(contractsP _ _ symmetric) step := shorter k.
by rewrite moves exprS -mulrA; apply: le_trans (step _) _; rewrite ler_wpmul2l.
Qed.

(* Hence every coordinate of the state decays. *)
Theorem motion_decays P r (A : nat -> 'M[R]_n) x : 0 <= r -> positive_definite P ->
  (forall k, contracts P r (A k)) -> (forall k, x k.+1 = A k *m x k) ->
  forall k i, x k i 0 ^+ 2 <= invmx P i i * (r ^+ k * value P (x 0%N)).
Proof.
move=> r_ge0 definite shorter moves k i; have [symmetric _] := definite.
pose e_i : 'cV[R]_n := delta_mx i 0.
have entry : value (invmx P) e_i = invmx P i i.
  by rewrite /value /bilinear trmx_delta -rowE -colE !mxE.
have coordinate : ((x k)^T *m e_i) 0 0 = x k i 0 by rewrite -colE !mxE.
have [_ nonneg] := definite_semidefinite (definite_inverse definite).
rewrite -coordinate -entry [X in _ <= X]mulrC; apply: le_trans (cauchy_schwarz _ _ definite) _.
by rewrite ler_wpmul2r // (motion_contracts r_ge0 symmetric shorter moves).
Qed.

(* No compactness is needed: a strict inequality has a rate. *)
Theorem strict_contraction_has_rate P A : positive_semidefinite P ->
  positive_definite (P - A^T *m P *m A) -> exists2 r, 0 <= r < 1 & contracts P r A.
Proof.
move=> [symmetric _] definite; have [t t_ge1 below] := definite_dominates P definite.
have t_gt0 : 0 < t := lt_le_trans ltr01 t_ge1.
exists (1 - t^-1); first by rewrite subr_ge0 invf_le1 // t_ge1 ltr_subl_addr ltr_addl invr_gt0.
apply/contractsP=> // v; have := below v; rewrite -ler_pdivr_mull // value_sub value_congruence => small.
by rewrite mulrBl mul1r ler_subr_addr addrC -ler_subr_addr.
Qed.

(* A polytope of loops contracts where its vertices do. *)
Theorem hull_contracts P r N (w : 'I_N -> R) (A : 'I_N -> 'M[R]_n) :
  positive_semidefinite P -> (forall i, 0 <= w i) -> \sum_i w i = 1 ->
  (forall i, contracts P r (A i)) -> contracts P r (\sum_i w i *: A i).
Proof.
move=> positive w_ge0 total vertices; have [symmetric _] := positive.
apply/contractsP=> // v; rewrite mulmx_suml; under eq_bigr do rewrite -scalemxAl.
apply: le_trans (value_is_convex _ positive w_ge0 total) _.
rewrite -[r * _]mul1r -total mulr_suml; apply: ler_sum => i _; rewrite ler_wpmul2l //.
by have /(contractsP _ _ symmetric) := vertices i; apply.
Qed.
End Contraction.

(* A loop that is affine in the q parameters theta. *)
Section Affine.
Variables (R : realFieldType) (n q N : nat) (A_0 : 'M[R]_n) (A_ : 'I_q -> 'M[R]_n).

Definition affine_loop (theta : 'cV[R]_q) : 'M[R]_n := A_0 + \sum_j theta j 0 *: A_ j.

Lemma affine_loop_of_mean (theta : 'I_N -> 'cV[R]_q) (w : 'I_N -> R) : \sum_i w i = 1 ->
  affine_loop (\sum_i w i *: theta i) = \sum_i w i *: affine_loop (theta i).
Proof.
move=> total; under [RHS]eq_bigr do rewrite scalerDr scaler_sumr.
rewrite big_split /= -scaler_suml total scale1r; congr (_ + _).
rewrite exchange_big /=; apply: eq_bigr => j _; rewrite summxE scaler_suml.
by apply: eq_bigr => i _; rewrite mxE scalerA.
Qed.

(* theta moves in the convex hull of N points in any way. *)
Theorem motion_in_the_hull P r (theta : 'I_N -> 'cV[R]_q) (w : nat -> 'I_N -> R)
    (x : nat -> 'cV[R]_n) : 0 <= r -> positive_semidefinite P ->
  (forall i, contracts P r (affine_loop (theta i))) ->
  (forall k i, 0 <= w k i) -> (forall k, \sum_i w k i = 1) ->
  (forall k, x k.+1 = affine_loop (\sum_i w k i *: theta i) *m x k) ->
  forall k, value P (x k) <= r ^+ k * value P (x 0%N).
Proof.
move=> r_ge0 positive vertices w_ge0 total; have [symmetric _] := positive.
apply: (motion_contracts (A := fun k => affine_loop (\sum_i w k i *: theta i))) => // k.
rewrite affine_loop_of_mean //; exact: hull_contracts.
Qed.
End Affine.

(* A constant loop: its poles lie in |z|^2 <= r. *)
Section Constant.
Variables (R : rcfType) (n : nat) (P A : 'M[R]_n) (r : R).
Hypotheses (definite : positive_definite P) (shorter : contracts P r A).

Theorem contraction_bounds_poles z :
  root (map_poly (real_complex R) (char_poly A)) z -> `|z| ^+ 2 <= (r%:C)%C.
Proof.
rewrite -char_poly_complex => /eigencolumn[v Ev nz_v]; have [symmetric positive] := definite.
have [_ nonneg] := definite_semidefinite definite.
pose P' := map_mx (real_complex R) P; pose A' := map_mx (real_complex R) A.
have length : 0 < hermitian_value P' v.
  have [u [w Euw]] := complex_vector v; rewrite Euw hermitian_value_complex //.
  rewrite -(rmorph0 [rmorphism of real_complex R]) ltcR.
  have [u0|nz_u] := eqVneq u 0; last by rewrite ltr_paddr ?positive.
  rewrite ltr_paddl // positive //; apply: contraNneq nz_v => w0.
  by rewrite Euw u0 w0 !map_mx0 scaler0 addr0.
have scaled a (M : 'M_n) : hermitian_value (a *: M) v = a * hermitian_value M v.
  by rewrite /hermitian_value -scalemxAr -scalemxAl mxE.
have := (semidefinite_complex shorter).2 v.
have -> : map_mx (real_complex R) (r *: P - A^T *m P *m A)
    = (r%:C)%C *: P' + (-1) *: (adjoint A' *m P' *m A').
  by rewrite adjoint_real scaleN1r map_mxB map_mxZ !map_mxM.
rewrite hermitian_value_add !scaled hermitian_value_congruence Ev.
have -> : hermitian_value P' (z *: v) = `|z| ^+ 2 * hermitian_value P' v.
  by rewrite /hermitian_value adjoint_scale -!scalemxAl -scalemxAr !mxE mulrA normCK [z^* * z]mulrC.
by rewrite mulN1r -mulrBl pmulr_lge0 // subr_ge0.
Qed.

Corollary contraction_is_stable : r < 1 -> inside (char_poly A).
Proof.
move=> small z /contraction_bounds_poles bound.
rewrite -(@ltr_pexpn2r _ 2) ?nnegrE ?normr_ge0 ?ler01 // expr1n.
by apply: le_lt_trans bound _; rewrite -(rmorph1 [rmorphism of real_complex R]) ltcR.
Qed.
End Constant.
