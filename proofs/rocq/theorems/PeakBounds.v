(* How large a signal becomes while theta moves in a share of its set and w is bounded: where x' P x loses at
   the rate r and gains at most mu w' w, it stays below mu / (1 - r), an ellipsoid on which every signal has
   a bound. For each motion of theta the loop is linear in w, so that the bounds of channels add up. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import finalg.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import ForwardConvergence Contraction SmallGain.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* x' = A x + B v + E w, z = C x + D v + F w: v is what moving parameters make of z, w comes from outside. *)
Section PeakBounds.
Variables (R : realFieldType) (n m p q : nat).
Variables (P A : 'M[R]_n) (B : 'M[R]_(n, m)) (E : 'M[R]_(n, q)).
Variables (C : 'M[R]_(p, n)) (D : 'M[R]_(p, m)) (F : 'M[R]_(p, q)) (S : 'M[R]_m) (W : 'M[R]_p) (mu r : R).

Definition supplied := bounded_real P A (row_mx B E) C (row_mx D F) (block_mx S 0 0 mu%:M) W r.
Definition level := mu / (1 - r).
Definition driven_motion (x : nat -> 'cV[R]_n) (v : nat -> 'cV[R]_m) (w : nat -> 'cV[R]_q) :=
  [/\ forall k, x k.+1 = A *m x k + B *m v k + E *m w k,
      forall k, value S (v k) <= value W (C *m x k + D *m v k + F *m w k)
    & forall k, square (w k) <= 1].

Hypotheses (supply : supplied) (mu_ge0 : 0 <= mu) (r_range : 0 <= r < 1).
Variables (x : nat -> 'cV[R]_n) (v : nat -> 'cV[R]_m) (w : nat -> 'cV[R]_q).
Hypotheses (motion : driven_motion x v w) (start : value P (x 0%N) <= level).

Theorem states_stay_below_the_level k : value P (x k) <= level.
Proof.
have [moves small bounded] := motion; have /andP[r_ge0 r_lt1] := r_range.
have gap : 0 < 1 - r by rewrite subr_gt0.
elim: k => [//|k IH]; rewrite moves -addrA -mul_row_col.
apply: le_trans (bounded_realE _ _ supply) _; rewrite value_diagonal !mul_row_col addrA.
have -> : level = r * level + mu by rewrite /level; field; rewrite gt_eqF.
apply: ler_add; first by rewrite ler_wpmul2l.
have -> : value mu%:M (w k) = mu * square (w k).
  by rewrite -[mu%:M]scalemx1 value_scale.
rewrite ler_subl_addl ler_add ?small //.
by rewrite -[X in _ <= X]mulr1 ler_wpmul2l.
Qed.

(* A signal c x, and a form of signals that P bounds: the largest change that theta makes of its regressor. *)
Theorem signal_bound k (c : 'rV[R]_n) : positive_definite P ->
  (c *m x k) 0 0 ^+ 2 <= value (invmx P) c^T * level.
Proof.
move=> definite; have [_ nonneg] := definite_semidefinite (definite_inverse definite).
have -> : (c *m x k) 0 0 = ((x k)^T *m c^T) 0 0 by rewrite -trmx_mul [RHS]mxE.
rewrite [X in _ <= X]mulrC; apply: le_trans (cauchy_schwarz _ _ definite) _.
by rewrite ler_wpmul2r // states_stay_below_the_level.
Qed.

Theorem form_bound k (l : nat) (G : 'M[R]_(l, n)) (M : 'M[R]_l) lambda : 0 <= lambda ->
  positive_semidefinite (lambda *: P - G^T *m M *m G) -> value M (G *m x k) <= lambda * level.
Proof.
move=> lambda_ge0 [_ /(_ (x k))]; rewrite value_sub value_scale value_congruence subr_ge0 => below.
by apply: le_trans below _; rewrite ler_wpmul2l // states_stay_below_the_level.
Qed.
End PeakBounds.

(* For each motion of the parameters the loop is linear in w. *)
Section Channels.
Variables (R : comRingType) (n q : nat) (A : nat -> 'M[R]_n) (E : nat -> 'M[R]_(n, q)).

Theorem channels_add_up (w : nat -> 'cV[R]_q) (x : nat -> 'cV[R]_n) (alone : 'I_q -> nat -> 'cV[R]_n) :
  x 0%N = 0 -> (forall k, x k.+1 = A k *m x k + E k *m w k) ->
  (forall j, alone j 0%N = 0) ->
  (forall j k, alone j k.+1 = A k *m alone j k + E k *m (w k j 0 *: delta_mx j 0)) ->
  forall k, x k = \sum_j alone j k.
Proof.
move=> x_0 moves zero moves_alone; elim=> [|k IH]; first by rewrite x_0 big1.
under eq_bigr do rewrite moves_alone.
rewrite big_split /= -!mulmx_sumr -IH moves; congr (_ + _ *m _).
by rewrite {1}[w k]matrix_sum_delta; apply: eq_bigr => j _; rewrite big_ord1.
Qed.
End Channels.
