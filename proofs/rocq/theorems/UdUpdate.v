(* The UD update of Bierman for one measurement: with P = U diag(d) U', U unit upper triangular, its
   factors are those of the covariance update (2.43), and they stay a unit upper triangular matrix and
   positive numbers. Any size, over any ordered field. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* One innovation: f = U' phi, v = diag(d) f, a_k = r + f_0 v_0 + ... + f_(k-1) v_(k-1). *)
Section Numbers.
Variables (R : realFieldType) (r : R) (f d : nat -> R).
Definition ud_gain k := d k * f k.
Definition ud_innovation k := r + \sum_(0 <= i < k) f i * ud_gain i.
Definition ud_diagonal k := d k * ud_innovation k / ud_innovation k.+1.
Definition ud_factor i j : R :=
  if i == j then 1 else if (i < j)%N then - (ud_gain i * f j / ud_innovation j) else 0.
Local Notation v := ud_gain.
Local Notation a := ud_innovation.

Hypotheses (r_positive : 0 < r) (d_positive : forall k, 0 < d k).

Lemma ud_innovation_positive k : 0 < a k.
Proof.
rewrite /ud_innovation ltr_paddr // sumr_ge0 // => i _.
by rewrite /ud_gain mulrCA -expr2 mulr_ge0 ?sqr_ge0 ?(ltW (d_positive i)).
Qed.

Lemma ud_diagonal_positive k : 0 < ud_diagonal k.
Proof. by rewrite /ud_diagonal divr_gt0 ?mulr_gt0 // ud_innovation_positive. Qed.

Let nz k : a k != 0. Proof. by rewrite gt_eqF // ud_innovation_positive. Qed.

Let step k : a k.+1 = a k + f k * v k.
Proof. by rewrite /ud_innovation big_nat_recr //= addrA. Qed.

Let telescope i j n : (j < n)%N ->
  \sum_(j.+1 <= k < n) ((- (v i * f k / a k)) * ud_diagonal k * (- (v j * f k / a k)))
  = v i * v j * ((a j.+1)^-1 - (a n)^-1).
Proof.
move=> j_n; pose u k := - (v i * v j * (a k)^-1).
have -> : v i * v j * ((a j.+1)^-1 - (a n)^-1) = u n - u j.+1.
  by rewrite /u opprK mulrBr addrC.
rewrite -(@telescope_sumr _ j.+1 n u) //; apply: eq_big_nat => k _.
have nz_k := nz k; have nz_k1 := nz k.+1; move: nz_k1.
have gain : v k = d k * f k by [].
rewrite /u /ud_diagonal step gain; move: (a k) (v i) (v j) (f k) (d k) nz_k => A V W F D nz_A nz_B.
by field; rewrite nz_A nz_B.
Qed.

Let entry_upper n i j : (i <= j)%N -> (j < n)%N ->
  \sum_(0 <= k < n) ud_factor i k * ud_diagonal k * ud_factor j k
  = (if i == j then d i else 0) - v i * v j / a n.
Proof.
move=> i_j j_n; rewrite (@big_cat_nat _ _ _ j) ?(ltnW j_n) //= big_nat big1 => [|k /andP[_ k_j]].
  rewrite add0r big_ltn // {2}/ud_factor eqxx mulr1.
  have -> : \sum_(j.+1 <= k < n) ud_factor i k * ud_diagonal k * ud_factor j k
      = v i * v j * ((a j.+1)^-1 - (a n)^-1).
    rewrite -(telescope i j_n); apply: eq_big_nat => k /andP[j_k _].
    have i_k := leq_ltn_trans i_j j_k.
    by rewrite /ud_factor (ltn_eqF i_k) (ltn_eqF j_k) i_k j_k.
  rewrite /ud_factor; case: eqVneq => [->|ne].
    have nz_j := nz j; have nz_j1 := nz j.+1; have nz_n := nz n; move: nz_j1.
    have gain : v j = d j * f j by [].
    rewrite mul1r /ud_diagonal step gain; move: (a j) (a n) (f j) (d j) nz_j nz_n => A N F D nA nN nB.
    by field; rewrite nB nN.
  have -> : (i < j)%N by rewrite ltn_neqAle ne.
  have nz_j := nz j; have nz_j1 := nz j.+1; have nz_n := nz n.
  have gain : v j = d j * f j by [].
  rewrite /ud_diagonal gain; move: nz_j1.
  move: (a j) (a j.+1) (a n) (v i) (f j) (d j) nz_j nz_n => A B N V F D nA nN nB.
  by field; rewrite nB nN nA.
by rewrite {2}/ud_factor gtn_eqF // ltnNge (ltnW k_j) /= mulr0.
Qed.

Lemma ud_entry n i j : (i < n)%N -> (j < n)%N ->
  \sum_(0 <= k < n) ud_factor i k * ud_diagonal k * ud_factor j k
  = (if i == j then d i else 0) - v i * v j / a n.
Proof.
move=> i_n j_n; have [i_j|j_i] := leqP i j; first exact: entry_upper.
have := entry_upper (ltnW j_i) i_n; rewrite (ltn_eqF j_i) (gtn_eqF j_i) [v j * v i]mulrC => <-.
apply: eq_bigr => k _; move: (ud_factor i k) (ud_factor j k) (ud_diagonal k) => x y z.
by ring.
Qed.
End Numbers.

Section Matrices.
Variables (R : realFieldType) (n : nat) (r lambda : R).
Variables (U : 'M[R]_n) (d : 'rV[R]_n) (phi : 'cV[R]_n).

Definition unit_upper_triangular (T : 'M[R]_n) :=
  forall i j : 'I_n, (j <= i)%N -> T i j = (i == j)%:R.

Let entries (x : 'I_n -> R) k := if insub k is Some i then x i else 1.
Let f := entries (fun i => (U^T *m phi) i 0).
Let dd := entries (fun i => d 0 i).

(* The update: U times a unit upper triangular matrix, and new diagonal numbers. *)
Definition updated_U : 'M[R]_n := U *m (\matrix_(i < n, j < n) ud_factor r f dd i j).
Definition updated_d : 'rV[R]_n := \row_k (lambda^-1 * ud_diagonal r f dd k).
Let P := U *m diag_mx d *m U^T.

Hypotheses (r_positive : 0 < r) (lambda_positive : 0 < lambda) (d_positive : forall k, 0 < d 0 k).
Hypothesis U_triangular : unit_upper_triangular U.

Let entriesE x (i : 'I_n) : entries x i = x i.
Proof. by rewrite /entries valK. Qed.

Let dd_positive k : 0 < dd k.
Proof. by rewrite /dd /entries; case: insubP => [i _ _|_]; rewrite ?d_positive ?ltr01. Qed.

Theorem ud_update_stays_positive k : 0 < updated_d 0 k.
Proof. by rewrite mxE mulr_gt0 ?invr_gt0 // ud_diagonal_positive. Qed.

Theorem ud_update_stays_triangular : unit_upper_triangular updated_U.
Proof.
move=> i j j_i; rewrite mxE (bigD1 j) //= [X in X + _](_ : _ = (i == j)%:R).
  rewrite big1 ?addr0 // => k ne; have [k_i|i_k] := leqP k i; last first.
    by rewrite [X in _ * X]mxE /ud_factor gtn_eqF ?(leq_ltn_trans j_i) //
      ltnNge (ltnW (leq_ltn_trans j_i i_k)) mulr0.
  rewrite U_triangular //; case: eqVneq => [E|_]; last by rewrite mul0r.
  rewrite mul1r mxE /ud_factor -E in ne *; rewrite (negPf (_ : i != j :> nat)) // ltnNge j_i.
  by [].
by rewrite U_triangular // mxE /ud_factor eqxx mulr1.
Qed.

(* (2.43), (2.44) for l_z = 1, W = 1 / r: P+ = (P - P phi phi' P / (r + phi' P phi)) / lambda. *)
Theorem ud_update_is_covariance_update :
  updated_U *m diag_mx updated_d *m updated_U^T
  = lambda^-1 *: (P - (r + (phi^T *m P *m phi) 0 0)^-1 *: (P *m phi *m phi^T *m P)).
Proof.
pose T : 'M[R]_n := \matrix_(i, j) ud_factor r f dd i j; pose v := diag_mx d *m (U^T *m phi).
have vE i : v i 0 = ud_gain f dd i.
  by rewrite /v mul_diag_mx mxE /ud_gain /f /dd !entriesE.
have total : ud_innovation r f dd n = r + (phi^T *m P *m phi) 0 0.
  rewrite /ud_innovation big_mkord; congr (_ + _).
  have -> : phi^T *m P *m phi = (U^T *m phi)^T *m v by rewrite /v trmx_mul trmxK !mulmxA.
  by rewrite mxE; apply: eq_bigr => i _; rewrite vE mxE /f entriesE.
have core : T *m diag_mx updated_d *m T^T
    = lambda^-1 *: (diag_mx d - (r + (phi^T *m P *m phi) 0 0)^-1 *: (v *m v^T)).
  apply/matrixP=> i j; rewrite mxE -total.
  transitivity (lambda^-1 * \sum_(0 <= k < n) ud_factor r f dd i k * ud_diagonal r f dd k
      * ud_factor r f dd j k).
    rewrite big_mkord mulr_sumr; apply: eq_bigr => k _.
    by rewrite mul_mx_diag !mxE; ring.
  have vv : (v *m v^T) i j = v i 0 * v j 0 by rewrite mxE big_ord1 [v^T _ _]mxE.
  have rhs a b (M N : 'M[R]_n) : (a *: (M - b *: N)) i j = a * (M i j - b * N i j) by rewrite !mxE.
  rewrite ud_entry // rhs vv -!vE; congr (_ * (_ - _)); last by rewrite mulrC.
  by rewrite mxE /dd entriesE -val_eqE; case: (val i == val j); rewrite ?mulr1n ?mulr0n.
have -> : updated_U = U *m T by [].
have -> : U *m T *m diag_mx updated_d *m (U *m T)^T = U *m (T *m diag_mx updated_d *m T^T) *m U^T.
  by rewrite trmx_mul !mulmxA.
rewrite core -scalemxAr -scalemxAl mulmxBr mulmxBl -scalemxAr -scalemxAl; congr (_ *: (_ - _ *: _)).
have D_T : (diag_mx d)^T = diag_mx d by rewrite tr_diag_mx.
by rewrite /v /P !trmx_mul trmxK D_T !mulmxA.
Qed.
End Matrices.
