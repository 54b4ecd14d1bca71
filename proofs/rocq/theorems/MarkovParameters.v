(* Markov parameters: the expansion (2.51) of a transfer function, with what is left after N terms, and
   the state after r steps of a recursion, (8.36), with the output (8.37). *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import MinimalRealisations.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* z^N N_zu = D (H_1 z^(N-1) + ... + H_N) + the numerator of E_1 A^N: the truncation after N terms leaves
   z^-N times a strictly proper transfer function. *)
Theorem markov_expansion (R : fieldType) order (A : 'M[R]_order.+1) (B : 'cV[R]_order.+1)
    (E_1 : 'rV[R]_order.+1) N :
  'X^N * numerator A B E_1
  = char_poly A * (\sum_(i < N) ((E_1 *m A ^+ i *m B) 0 0)%:P * 'X^(N - i.+1))
    + numerator A B (E_1 *m A ^+ N).
Proof.
elim: N => [|N IH]; first by rewrite big_ord0 mulr0 add0r !expr0 mul1r mulmx1.
have step : numerator A B (E_1 *m A ^+ N.+1)
    = 'X * numerator A B (E_1 *m A ^+ N) - char_poly A * ((E_1 *m A ^+ N *m B) 0 0)%:P.
  by rewrite exprSr -mulmxE mulmxA numerator_step.
have shifted : \sum_(i < N) ((E_1 *m A ^+ i *m B) 0 0)%:P * 'X^(N.+1 - i.+1)
    = 'X * (\sum_(i < N) ((E_1 *m A ^+ i *m B) 0 0)%:P * 'X^(N - i.+1)).
  rewrite mulr_sumr; apply: eq_bigr => i _.
  by rewrite mulrCA -exprS -subSn.
rewrite big_ord_recr /= subnn expr0 shifted step exprS -mulrA IH.
by rewrite mulr1 !mulrDr mulrCA [in RHS]addrACA subrr addr0.
Qed.

Section Unrolled.
Variables (R : ringType) (n p l m : nat).
Variables (A : 'M[R]_n) (D_1 : 'M[R]_(n, p)) (B : 'M[R]_(n, l)) (C : 'M[R]_(m, n)).
Variables (x : nat -> 'cV[R]_n) (w : nat -> 'cV[R]_p) (u : nat -> 'cV[R]_l) (y : nat -> 'cV[R]_m).
Hypothesis recursion : forall k, x k.+1 = A *m x k + D_1 *m w k + B *m u k.

Fixpoint matrix_power k : 'M[R]_n := if k is j.+1 then A *m matrix_power j else 1%:M.

(* (8.36), with k + r in the place of k. *)
Theorem state_8_36 r k : x (k + r)%N = matrix_power r *m x k
  + (\sum_(i < r) matrix_power i *m D_1 *m w (k + r - i.+1)%N)
  + (\sum_(i < r) matrix_power i *m B *m u (k + r - i.+1)%N).
Proof.
elim: r => [|r IH]; first by rewrite addn0 mul1mx !big_ord0 !addr0.
rewrite addnS recursion IH !big_ord_recl /= !subSS !subn0 !mul1mx !mulmxDr !mulmxA.
have shifted q (M : 'M[R]_(n, q)) (v : nat -> 'cV[R]_q) :
    A *m (\sum_(i < r) matrix_power i *m M *m v (k + r - i.+1)%N)
    = \sum_(i < r) A *m matrix_power i *m M *m v (k + r - i.+1)%N.
  by rewrite mulmx_sumr; apply: eq_bigr => i _; rewrite !mulmxA.
rewrite !shifted -!addrA; congr (_ + _); rewrite [RHS]addrCA; congr (_ + _).
by rewrite addrC -addrA.
Qed.

(* (8.37): z = C x^ - y. *)
Corollary performance_8_37 r k : C *m x (k + r)%N - y (k + r)%N = C *m matrix_power r *m x k
  + (\sum_(i < r) C *m matrix_power i *m D_1 *m w (k + r - i.+1)%N) - y (k + r)%N
  + (\sum_(i < r) C *m matrix_power i *m B *m u (k + r - i.+1)%N).
Proof.
rewrite state_8_36 !mulmxDr !mulmx_sumr mulmxA addrAC; congr (_ + _ - _ + _);
  by apply: eq_bigr => i _; rewrite !mulmxA.
Qed.
End Unrolled.
