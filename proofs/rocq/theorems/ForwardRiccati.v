(* One step of the forward-propagating Riccati equation (8.96) keeps P positive semidefinite; any
   number of states and inputs, R_2 > 0, over an ordered field. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import RecursiveLeastSquares.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Forward.
Variables (R : realFieldType) (n m : nat).
Variables (A P R_1 : 'M[R]_n) (B : 'M[R]_(n, m)) (R_2 : 'M[R]_m).
Let W := R_2 + B^T *m P *m B.

(* (8.95) and (8.96). *)
Definition forward_gain := - (invmx W *m B^T *m P *m A).
Definition forward_step :=
  A^T *m P *m A + R_1 - A^T *m P *m B *m invmx W *m B^T *m P *m A.
Let K := forward_gain.

Lemma semidefinite_add (M N : 'M[R]_n) :
  positive_semidefinite M -> positive_semidefinite N -> positive_semidefinite (M + N).
Proof.
case=> M_T M_pos [N_T N_pos]; split=> [|x]; first by rewrite linearD /= M_T N_T.
by rewrite value_add addr_ge0.
Qed.

Hypotheses (P_pos : positive_semidefinite P) (R_1_pos : positive_semidefinite R_1).
Hypothesis R_2_pos : positive_definite R_2.

Lemma forward_weight_definite : positive_definite W.
Proof. exact/definite_add/semidefinite_congruence. Qed.

(* With the gain (8.95) the step is a sum of three semidefinite matrices. *)
Theorem forward_step_with_gain :
  forward_step = (A + B *m K)^T *m P *m (A + B *m K) + K^T *m R_2 *m K + R_1.
Proof.
have unit_W := definite_invertible forward_weight_definite; have [P_T _] := P_pos.
have [W_T _] := forward_weight_definite.
have gain : W *m K = - (B^T *m P *m A).
  by rewrite /K /forward_gain mulmxN !mulmxA mulmxV // mul1mx.
have gain_T : K^T *m W = - (A^T *m P *m B).
  have -> : K^T *m W = (W *m K)^T by rewrite trmx_mul W_T.
  have N_T (M : 'M[R]_(m, n)) : (- M)^T = - M^T by apply/matrixP=> i j; rewrite !mxE.
  by rewrite gain N_T !trmx_mul trmxK P_T mulmxA.
have -> : forward_step = A^T *m P *m A + R_1 + A^T *m P *m B *m K.
  by rewrite /forward_step /K /forward_gain mulmxN !mulmxA.
have R_2_E : R_2 = W - B^T *m P *m B by rewrite /W addrK.
have -> : (A + B *m K)^T = A^T + K^T *m B^T by rewrite linearD /= trmx_mul.
rewrite [in RHS]R_2_E.
have [V EV] : exists V, V = W by exists W.
have [L EL] : exists L, L = K by exists K.
rewrite -EV -EL in gain gain_T *; clear EV EL R_2_E.
rewrite !(mulmxDl, mulmxDr, mulmxBl, mulmxBr, mulNmx, mulmxN) !mulmxA.
rewrite gain_T.
have -> : L^T *m B^T *m P *m A = L^T *m (B^T *m P *m A) by rewrite !mulmxA.
rewrite -[B^T *m P *m A]opprK -gain mulmxN mulmxA gain_T !mulNmx opprK.
by rewrite -opprD addrK addrAC.
Qed.

Theorem forward_step_is_semidefinite : positive_semidefinite forward_step.
Proof.
rewrite forward_step_with_gain; apply: semidefinite_add => //.
by apply: semidefinite_add; apply: semidefinite_congruence => //; apply: definite_semidefinite.
Qed.
End Forward.

(* Every step of it: P(k) >= 0 for all k. *)
Theorem forward_riccati_is_semidefinite (R : realFieldType) n m (A R_1 P_0 : 'M[R]_n)
    (B : 'M[R]_(n, m)) (R_2 : 'M[R]_m) k :
  positive_semidefinite P_0 -> positive_semidefinite R_1 -> positive_definite R_2 ->
  positive_semidefinite (iter k (fun P => forward_step A P R_1 B R_2) P_0).
Proof.
move=> P_pos R_1_pos R_2_pos; elim: k => //= k IH.
exact: forward_step_is_semidefinite.
Qed.

(* (8.99) and (8.100) are (8.95) and (8.96) for A', C', V_1 and V_2; and (2.46) is (8.100) for A = I,
   C = Phi_f and V_2 = (R_z + R_u)^-1, with Q as process noise: a Kalman predictor of theta. *)
Section Dual.
Variables (R : realFieldType) (n p : nat).
Variables (A Q V_1 : 'M[R]_n) (C : 'M[R]_(p, n)) (V_2 : 'M[R]_p).

Definition predictor_gain := A *m Q *m C^T *m invmx (V_2 + C *m Q *m C^T).
Definition predictor_step :=
  A *m Q *m A^T + V_1 - A *m Q *m C^T *m invmx (V_2 + C *m Q *m C^T) *m C *m Q *m A^T.

Theorem predictor_step_is_dual : predictor_step = forward_step A^T Q V_1 C^T V_2.
Proof. by rewrite /forward_step !trmxK. Qed.

Theorem predictor_gain_is_dual : Q^T = Q -> V_2^T = V_2 ->
  predictor_gain = - (forward_gain A^T Q C^T V_2)^T.
Proof.
move=> Q_T V_T; rewrite /forward_gain linearN /= opprK !trmx_mul !trmxK trmx_inv Q_T.
by rewrite linearD /= !trmx_mul !trmxK Q_T V_T !mulmxA.
Qed.
End Dual.

Theorem update_2_46 (R : realFieldType) l p (P Q : 'M[R]_l) (Phi : 'M[R]_(p, l)) (weight : 'M[R]_p) :
  next_P P Phi weight 1 + Q = predictor_step 1%:M P Q Phi (invmx weight).
Proof.
by rewrite /next_P /Upsilon invr1 !scale1r /predictor_step trmx1 !mul1mx !mulmx1 addrAC.
Qed.

(* (2.47), (2.48), with Upsilon, R_z and R_u of k + 1 in both, compute at step k what (2.45), (2.46)
   compute at step k + 1, where the Q of (2.47) is that of the step after: the filter's form is the predictor's, one step early. *)
Section FilterForm.
Variables (R : realFieldType) (l p : nat).
Variables (Phi : nat -> 'M[R]_(p, l)) (R_z R_u : nat -> 'M[R]_p) (r : nat -> 'cV[R]_p).
Variables (Q : nat -> 'M[R]_l) (theta_0 : 'cV[R]_l) (P_0 : 'M[R]_l).

(* One step with the data of step k and a process noise. *)
Definition noisy_step k noise (estimate : 'cV[R]_l * 'M[R]_l) :=
  let: (theta, P) := estimate in let W := R_z k + R_u k in
  (next_theta P (Phi k) (R_z k) W 1 theta (r k), next_P P (Phi k) W 1 + noise).

(* (2.45), (2.46), from k_0 on, and (2.48), (2.47): the estimate after k steps. *)
Fixpoint predictor_form k_0 k := if k is i.+1
  then noisy_step (k_0 + i) (Q (k_0 + i)%N) (predictor_form k_0 i) else (theta_0, P_0).
Fixpoint filter_form k := if k is i.+1
  then noisy_step i.+1 (Q i.+1) (filter_form i) else (theta_0, P_0).

Theorem filter_form_is_predictor_form k : filter_form k = predictor_form 1 k.
Proof. by elim: k => //= k ->; rewrite add1n. Qed.
End FilterForm.
