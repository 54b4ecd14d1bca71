(* The limit of predictive cost adaptive control: an ARX model
     y(k) = sum_i (Phi_i y(k - i) + Gamma_i u(k - i)), i = 1, ..., n,
   of p outputs and m inputs in block observable form, whose state is a window of past data, and
   u = K x^ with x^(k) from the data up to k - 1. Where the model is the plant and K constant, the loop is
   observer-based with a deadbeat observer: its polynomial is q^(n p) chi(A + Gamma K), whatever K. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import ClosedLoop.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section BlockShift.
Variables (R : idomainType) (p d : nat).

(* Moves d coordinates up by k blocks of p, and zeros in from below. *)
Definition block_shift k : 'M[R]_d := \matrix_(i, j) (j == i + k * p :> nat)%N%:R.

Lemma block_shift_0 : block_shift 0 = 1%:M.
Proof. by apply/matrixP=> i j; rewrite !mxE mul0n addn0 eq_sym. Qed.

Lemma rows_of_block_shift (k m : nat) (M : 'M[R]_(d, m)) (i l : 'I_d) j : l = (i + k * p)%N :> nat ->
  (block_shift k *m M) i j = M l j.
Proof.
move=> E; rewrite mxE (bigD1 l) //= big1 => [|l' ne]; last first.
  rewrite !mxE (_ : (l' == i + k * p :> nat)%N = false) ?mul0r //.
  by apply: contraNF ne => /eqP E'; apply/eqP/val_inj; rewrite /= E' E.
by rewrite !mxE E eqxx mul1r addr0.
Qed.

Lemma rows_below_the_shift (k m : nat) (M : 'M[R]_(d, m)) (i : 'I_d) j : (d <= i + k * p)%N ->
  (block_shift k *m M) i j = 0.
Proof.
move=> large; rewrite mxE big1 // => l _; rewrite !mxE (_ : (l == i + k * p :> nat)%N = false) ?mul0r //.
by apply/eqP; have := ltn_ord l; lia.
Qed.

Lemma block_shift_step k : block_shift 1 *m block_shift k = block_shift k.+1.
Proof.
apply/matrixP=> i j; have [small|large] := ltnP (i + 1 * p) d; last first.
  rewrite rows_below_the_shift // mxE (_ : (j == i + k.+1 * p :> nat)%N = false) //.
  by apply/eqP; have := ltn_ord j; lia.
rewrite (@rows_of_block_shift 1 _ _ i (Ordinal small)) // !mxE /=.
by rewrite mul1n -addnA -mulSn.
Qed.

Lemma block_shift_vanishes n : (d <= n * p)%N -> block_shift n = 0.
Proof.
move=> large; apply/matrixP=> i j; rewrite !mxE (_ : (j == i + n * p :> nat)%N = false) //.
by apply/eqP; have := ltn_ord j; lia.
Qed.

Lemma char_poly_block_shift : (0 < p)%N -> char_poly (block_shift 1) = 'X^d.
Proof.
move=> p_gt0; rewrite /char_poly -det_tr det_trig; last first.
  apply/is_trig_mxP=> i j i_j; rewrite !mxE.
  have -> : (j == i) = false by rewrite -val_eqE gtn_eqF.
  by rewrite (_ : (i == j + 1 * p :> nat)%N = false) ?subr0 //; apply/eqP; lia.
rewrite -[d in RHS]card_ord -prodr_const; apply: eq_bigr => i _.
by rewrite !mxE eqxx (_ : (i == i + 1 * p :> nat)%N = false) ?subr0 //; apply/eqP; lia.
Qed.
End BlockShift.

Section PredictiveControl.
Variables (R : idomainType) (n p m : nat).
Local Notation d := (n * p)%N.
Variables (Phi : 'M[R]_(d, p)) (Gamma : 'M[R]_(d, m)) (K : 'M[R]_(m, d)).
Local Notation S := (block_shift R p d).

(* y = [I 0 ... 0] x, and x' = S x + Phi y + Gamma u; the i-th p rows of Phi and Gamma are Phi_i, Gamma_i. *)
Definition first_block : 'M[R]_(p, d) := \matrix_(i, j) (j == i :> nat)%N%:R.
Definition block_observable_form : 'M[R]_d := S 1 + Phi *m first_block.
Definition lag_block q (M : 'M[R]_(d, q)) i : 'M[R]_(p, q) := first_block *m S i *m M.
Local Notation C := first_block.
Local Notation A := block_observable_form.

Lemma lag_blockE q (M : 'M[R]_(d, q)) i (a : 'I_p) c (inside : (a + i * p < d)%N) :
  lag_block M i a c = M (Ordinal inside) c.
Proof.
have top : (a < d)%N by apply: leq_ltn_trans inside; rewrite leq_addr.
rewrite /lag_block -mulmxA mxE (bigD1 (Ordinal top)) //= big1 => [|l ne]; last first.
  rewrite !mxE (_ : (l == a :> nat)%N = false) ?mul0r //.
  by apply: contraNF ne => /eqP E; apply/eqP/val_inj.
by rewrite mxE eqxx mul1r addr0 (@rows_of_block_shift _ _ _ _ _ _ _ (Ordinal inside)).
Qed.

Lemma window_is_an_observer : observer_matrix A Gamma C K Phi = S 1 + Gamma *m K.
Proof. by rewrite /observer_matrix addrAC addrK. Qed.

(* After n steps the estimate is a window of the data, whatever it was. *)
Theorem estimate_is_a_window (x : nat -> 'cV[R]_d) (y : nat -> 'cV[R]_p) (u : nat -> 'cV[R]_m) :
  (forall k, x k.+1 = S 1 *m x k + Phi *m y k + Gamma *m u k) -> forall k,
  x (n + k)%N = \sum_(i < n) S i *m (Phi *m y (n + k - i.+1)%N + Gamma *m u (n + k - i.+1)%N).
Proof.
move=> moves k.
have unrolled j : x (j + k)%N = S j *m x k
    + \sum_(i < j) S i *m (Phi *m y (j + k - i.+1)%N + Gamma *m u (j + k - i.+1)%N).
  elim: j => [|j IH]; first by rewrite big_ord0 block_shift_0 mul1mx addr0.
  rewrite addSn moves IH mulmxDr mulmxA block_shift_step big_ord_recl block_shift_0 mul1mx.
  rewrite subSS subn0 -!addrA; congr (_ + _); rewrite addrC addrA; congr (_ + _).
  by rewrite mulmx_sumr; apply: eq_bigr => i _; rewrite mulmxA block_shift_step subSS.
by rewrite unrolled block_shift_vanishes // mul0mx add0r.
Qed.

(* The output of the model obeys the ARX equation. *)
Theorem output_is_arx (x : nat -> 'cV[R]_d) (u : nat -> 'cV[R]_m) :
  (forall k, x k.+1 = A *m x k + Gamma *m u k) -> let y k := C *m x k in forall k,
  y (n + k)%N
    = \sum_(i < n) (lag_block Phi i *m y (n + k - i.+1)%N + lag_block Gamma i *m u (n + k - i.+1)%N).
Proof.
move=> moves y k; rewrite {1}/y (@estimate_is_a_window x y u); last first.
  by move=> j; rewrite moves /block_observable_form mulmxDl mulmxA.
by rewrite mulmx_sumr; apply: eq_bigr => i _; rewrite /lag_block !mulmxDr !mulmxA.
Qed.

Theorem loop_of_predictive_control : (0 < p)%N ->
  char_poly (closed_loop A Gamma C (observer_matrix A Gamma C K Phi) Phi K)
  = 'X^d * char_poly (A + Gamma *m K).
Proof.
by move=> p_gt0; rewrite separation {2}/block_observable_form addrK char_poly_block_shift // mulrC.
Qed.
End PredictiveControl.

(* One input and one output, in the words of (7.23): D D_c + N N_c = q^n chi(A + Gamma K). *)
Corollary loop_polynomial_of_predictive_control (R : idomainType) n (Phi Gamma : 'cV[R]_(n * 1))
    (K : 'rV[R]_(n * 1)) :
  let A := block_observable_form Phi in let C := first_block R n 1 in
  let A_c := observer_matrix A Gamma C K Phi in
  closed_loop_polynomial (denominator A) (numerator A Gamma C) (denominator A_c) (- numerator A_c Phi K)
  = 'X^n * char_poly (A + Gamma *m K).
Proof.
by move=> A C A_c; rewrite -closed_loop_7_23 loop_of_predictive_control // [X in 'X^X]muln1.
Qed.
