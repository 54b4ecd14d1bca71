(* The words of the field, as definitions, in which the theorems of this folder are stated; words
   that only one file needs are defined there.

   R is a field, n >= 1 the order of the plant. Signals are scalar where B is a column and C a row.
   The plant is x' = A x + B u, y = C x, the compensator x_c' = A_c x_c + B_c y, u = C_c x_c:
   (7.1)-(7.4), positive feedback. Polynomials use negative feedback, (7.22)-(7.23), so that
   N_c / D_c is minus the transfer function of (A_c, B_c, C_c).                                   *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* Degrees. The size of a polynomial is its degree plus one, and 0 for the polynomial 0. *)
Notation degree_is p n := (size (p%R : {poly _}) = n.+1).
Notation degree_below p n := (size (p%R : {poly _}) <= n)%N.
Notation degree_at_most p n := (size (p%R : {poly _}) <= n.+1)%N.
(* The number of common roots in an algebraic closure, counted with multiplicity. *)
Notation common_roots a b := ((size (gcdp a b)).-1).

Section Systems.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

(* [B  AB  ...  A^(n-1) B] and the rows C, CA, ..., C A^(n-1). *)
Definition controllability_matrix A B : 'M[R]_n := \matrix_(i, j) (A ^+ j *m B) i 0.
Definition observability_matrix A C : 'M[R]_n := \matrix_(i, j) (C *m A ^+ i) 0 j.

(* The rank conditions of Kalman. *)
Definition controllable A B := \rank (controllability_matrix A B) == n.
Definition observable A C := \rank (observability_matrix A C) == n.
Definition minimal A B C := controllable A B /\ observable A C.
End Systems.

Section TransferFunctions.
Variable R : comRingType.

(* G = N / D with D = det(sI - A) and N = C adj(sI - A) B, common factors not cancelled. *)
Definition denominator n (A : 'M[R]_n) : {poly R} := char_poly A.
Definition numerator n (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n) : {poly R} :=
  (map_mx polyC C *m \adj (char_poly_mx A) *m map_mx polyC B) 0 0.

(* (7.13)-(7.14), any number of signals and any order of the compensator. *)
Definition closed_loop n n_c m p (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n))
    (A_c : 'M[R]_n_c) (B_c : 'M[R]_(n_c, p)) (C_c : 'M[R]_(m, n_c)) : 'M[R]_(n + n_c) :=
  block_mx A (B *m C_c) (B_c *m C) A_c.

(* (7.23). *)
Definition closed_loop_polynomial (D N D_c N_c : {poly R}) : {poly R} := D * D_c + N * N_c.

(* A_c of (7.11): the state of the compensator is an estimate of x, and u = K times it. *)
Definition observer_matrix n m p (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n))
    (K : 'M[R]_(m, n)) (F : 'M[R]_(n, p)) : 'M[R]_n := A + B *m K - F *m C.
End TransferFunctions.

Section ObserverBased.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

(* A pair of polynomials, as it is written, is that of an observer-based compensator. *)
Definition pair_is_observer_based (D_c N_c : {poly R}) := exists K F,
  D_c = denominator (observer_matrix A B C K F) /\
  N_c = - numerator (observer_matrix A B C K F) F K.

(* The same for a transfer function: equal as a fraction. *)
Definition transfer_function_is_observer_based (D_c N_c : {poly R}) := exists D_o N_o,
  pair_is_observer_based D_o N_o /\ N_c * D_o = N_o * D_c.

(* x_c = T x^ turns (A_c, B_c, C_c) into the observer-based compensator with gains K and F. *)
Definition observer_form (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n) T K F :=
  [/\ T \in unitmx, C_c *m T = K, T *m F = B_c & A_c *m T = T *m observer_matrix A B C K F].
Definition realisation_is_observer_based A_c B_c C_c := exists T K F,
  observer_form A_c B_c C_c T K F.
End ObserverBased.

(* The columns of V span a subspace of their number, and M maps it into itself. *)
Definition invariant_subspace (R : fieldType) n d (M : 'M[R]_n) (V : 'M[R]_(n, d)) :=
  \rank V = d /\ exists X : 'M[R]_d, M *m V = V *m X.

(* The characteristic polynomial of A on its unobservable subspace. The columns of x are a basis. *)
Definition is_unobservable_polynomial (R : fieldType) order (A : 'M[R]_order.+1)
    (C : 'rV[R]_order.+1) (u : {poly R}) :=
  exists d (x : 'M[R]_(order.+1, d)) (Z : 'M[R]_d),
    [/\ \rank x = d, A *m x = x *m Z, u = char_poly Z &
        forall m (v : 'M[R]_(order.+1, m)),
          (forall k, C *m A ^+ k *m v = 0) <-> exists y, v = x *m y].

(* Its dual: the modes that the input does not reach. *)
Definition is_uncontrollable_polynomial (R : fieldType) order (A : 'M[R]_order.+1)
    (B : 'cV[R]_order.+1) (c : {poly R}) := is_unobservable_polynomial A^T B^T c.

(* Nonderogatory, or cyclic: one vector b reaches everything. *)
Definition nonderogatory (R : fieldType) order (M : 'M[R]_order.+1) := exists b, controllable M b.

(* At least two real roots, a double root counted twice. *)
Definition two_roots (R : comRingType) (p : {poly R}) := exists x y,
  exists q, p = q * (('X - x%:P) * ('X - y%:P)).

Section Resultants.
Variable R : ringType.

(* M_1(a, b) of (B.1): l columns of the coefficients a_k ... a_0, then k of b_l ... b_0, each
   column one row further down. l is a formal degree: b_l may be 0. *)
Definition M_1 k l (a b : {poly R}) : 'M[R]_(l + k) := \matrix_(i, j)
  match split j with
  | inl j => if (j <= i <= j + k)%N then a`_(k - (i - j)) else 0
  | inr j => if (j <= i <= j + l)%N then b`_(l - (i - j)) else 0
  end.

(* M_2(a, b) of (B.2). *)
Definition M_2 k (a b : {poly R}) : 'M[R]_(k + k) := M_1 k k a b.

(* M of (7.38), with columns = m^_c + 1: n_c columns of D_n ... D_0, then the coefficients
   N_m ... N_0, which start below n + n_c - m - columns zeros. *)
Definition M_of_7_38 n n_c m columns (D N : {poly R}) : 'M[R]_(n + n_c, n_c + columns) :=
  \matrix_(i, j) match split j with
  | inl j => if (j <= i <= j + n)%N then D`_(n - (i - j)) else 0
  | inr j => let first := (n + n_c - m - columns + j)%N in
             if (first <= i <= first + m)%N then N`_(m - (i - first)) else 0
  end.
End Resultants.
