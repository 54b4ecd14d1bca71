(* The regressor form of the controller, (2.28)-(2.31), any number of signals and any k_c: Phi theta is
   the control for Phi = phi' (x) I and theta = vec [P_1 ... Q_n_c], without the transpose that (2.31)
   has; and for scalar signals the control of (2.28) is N_c / D_c of (2.33). *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import finalg.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Regressor.
Variables (R : comRingType) (l_u m : nat).

(* vec stacks columns; mxvec of MathComp lists rows. *)
Definition vec (M : 'M[R]_(l_u, m)) : 'cV[R]_(m * l_u) := (mxvec M^T)^T.

(* phi' (x) I: its row i is the list of the rows of phi e_i'. *)
Definition regressor (phi : 'cV[R]_m) : 'M[R]_(l_u, m * l_u) :=
  \matrix_i mxvec (phi *m (delta_mx 0 i : 'rV[R]_l_u)).

Lemma product_of_lists p q (X Y : 'M[R]_(p, q)) :
  (mxvec X *m (mxvec Y)^T) 0 0 = \sum_i \sum_j X i j * Y i j.
Proof.
rewrite mxE (reindex _ (curry_mxvec_bij p q)) /= (pair_bigA _ (fun i j => X i j * Y i j)) /=.
by apply: eq_bigr => -[i j] _; rewrite !mxE /= !mxvecE.
Qed.

Theorem regressor_times_vec phi (M : 'M[R]_(l_u, m)) : regressor phi *m vec M = M *m phi.
Proof.
apply/matrixP=> i j; rewrite ord1 {j}.
transitivity ((row i (regressor phi *m vec M)) 0 0); first by rewrite [RHS]mxE.
rewrite row_mul rowK product_of_lists mxE; apply: eq_bigr => j _.
rewrite (bigD1 i) //= big1 ?addr0 => [|k other]; rewrite !mxE big_ord1 !mxE ?eqxx.
  by rewrite mulr1 mulrC.
by rewrite (negPf other) andbF mulr0 mul0r.
Qed.
End Regressor.

Section Controller.
Variables (R : comRingType) (l_u l_y n_c q k k_c : nat).
Variables (P : 'I_n_c -> 'M[R]_l_u) (Q : 'I_q -> 'M[R]_(l_u, l_y)).
Variables (u : nat -> 'cV[R]_l_u) (y : nat -> 'cV[R]_l_y).

(* phi(k), and [P_1 ... P_n_c Q_k_c ... Q_n_c], with q = n_c - k_c + 1. *)
Definition past_signals := col_mx (\mxcol_(i < n_c) u (k - i.+1)%N) (\mxcol_(i < q) y (k - (k_c + i))%N).
Definition coefficients := row_mx (\mxrow_i P i) (\mxrow_i Q i).

Theorem regressor_2_28 : regressor l_u past_signals *m vec coefficients =
  \sum_(i < n_c) P i *m u (k - i.+1)%N + \sum_(i < q) Q i *m y (k - (k_c + i))%N.
Proof. by rewrite regressor_times_vec mul_row_col !mul_mxrow_mxcol. Qed.
End Controller.
