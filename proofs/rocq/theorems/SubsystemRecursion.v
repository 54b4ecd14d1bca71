(* The least squares of RCMR, (8.61)-(8.63), where the summand of (8.61) holds u*(i - d) and
   phi(i - d - 1) and the bracket of (8.63) holds phi(k - d - 1): an instance of the recursion of
   Section 2.3.4, a row of theta at a time; the gain P(k) phi is that of (2.42). *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import RecursiveLeastSquares.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section SubsystemRecursion.
Variables (R : realFieldType) (l m : nat) (lambda : R).
Variables (phi : nat -> 'cV[R]_l) (target : nat -> 'rV[R]_m) (P_0 : 'M[R]_l) (start : 'M[R]_(l, m)).

(* (8.61), for X = theta'; phi(i) and target(i) stand for phi(i - d - 1) and u*(i - d)'. *)
Definition subsystem_cost k (X : 'M[R]_(l, m)) :=
  \sum_(1 <= i < k.+1) lambda ^+ (k - i) * (\sum_j ((target i - (phi i)^T *m X) 0 j) ^+ 2)
  + lambda ^+ k * \tr ((X - start)^T *m invmx P_0 *m (X - start)).

(* (8.63), (8.62). *)
Definition next_subsystem_P (P : 'M[R]_l) (f : 'cV[R]_l) :=
  lambda^-1 *: (P - (lambda + value P f)^-1 *: (P *m f *m f^T *m P)).
Fixpoint subsystem_recursion k : 'M[R]_(l, m) * 'M[R]_l :=
  if k is i.+1 then
    let: (X, P) := subsystem_recursion i in let P' := next_subsystem_P P (phi k) in
    (X + P' *m phi k *m (target k - (phi k)^T *m X), P')
  else (start, P_0).

Hypotheses (lambda_positive : 0 < lambda) (P_0_definite : positive_definite P_0).

(* The recursion of Section 2.3.4 for one column of X: R_z = 1, R_u = 0. *)
Let column j := theta_and_P lambda (fun i => (phi i)^T) (fun=> 1%:M) (fun=> 0)
  (fun i => - (target i 0 j)%:M) (fun=> 0) (invmx P_0) (col j start).

Lemma subsystem_P_definite (P : 'M[R]_l) f : positive_definite P -> 0 < lambda + value P f.
Proof. by case/definite_semidefinite=> _ positive; rewrite ltr_paddr. Qed.

Lemma next_subsystem_PE (P : 'M[R]_l) f : positive_definite P ->
  next_subsystem_P P f = next_P P f^T 1%:M lambda.
Proof.
move=> definite; rewrite /next_subsystem_P /next_P /Upsilon; congr (_ *: (_ - _)).
have -> : lambda *: invmx 1%:M + f^T *m P *m f^T^T = (lambda + value P f)%:M.
  rewrite invmx1 trmxK scalemx1 raddfD /=; congr (_ + _).
  by rewrite [LHS]mx11_scalar.
rewrite trmxK invmx_scalar mul_mx_scalar -!scalemxAl; congr (_ *: _).
Qed.

(* The gain of (8.62) is that of (2.42). *)
Theorem gain_8_62 (P : 'M[R]_l) f : positive_definite P ->
  next_subsystem_P P f *m f = (lambda + value P f)^-1 *: (P *m f).
Proof.
move=> definite; have nz := gt_eqF (subsystem_P_definite f definite).
rewrite /next_subsystem_P -scalemxAl mulmxBl -scalemxAl.
have -> : P *m f *m f^T *m P *m f = value P f *: (P *m f).
  by rewrite -!mulmxA (mulmxA f^T) [f^T *m P *m f]mx11_scalar mul_mx_scalar -scalemxAr.
rewrite scalerA -{1}[P *m f]scale1r -scalerBl scalerA; congr (_ *: _).
by field; rewrite nz gt_eqF.
Qed.

Lemma columns_of_recursion k :
  [/\ positive_definite (subsystem_recursion k).2,
      forall j, (column j k).2 = (subsystem_recursion k).2
    & forall j, (column j k).1 = col j (subsystem_recursion k).1].
Proof.
elim: k => [|k [definite same_P same_X]] /=.
  by split=> // j; rewrite invmxK.
case: (subsystem_recursion k) definite same_P same_X => X P /= definite same_P same_X.
have W_definite : positive_definite (1%:M + 0 : 'M[R]_1).
  rewrite addr0; split=> [|x nz]; first exact: trmx1.
  rewrite /value /bilinear mulmx1 mxE big_ord1 mxE -expr2 lt_def sqr_ge0 andbT expf_eq0 /=.
  apply: contra nz => /eqP zero; apply/eqP/matrixP=> i j.
  by rewrite !ord1 zero mxE.
split=> [|j|j].
- rewrite next_subsystem_PE // -(addr0 1%:M).
  rewrite (next_P_inverse _ definite lambda_positive W_definite).
  exact/definite_inverse/(next_H_definite _ definite lambda_positive W_definite).
- move: (same_P j) (same_X j); rewrite /column /=; case: (theta_and_P _ _ _ _ _ _ _ _ k) => t Q /= -> _.
  (* By `by` the hypotheses are unified with the goal first, which unfolds the recursion: 12 s. *)
  rewrite (next_subsystem_PE _ definite) addr0; reflexivity.
move: (same_P j) (same_X j); rewrite /column /=; case: (theta_and_P _ _ _ _ _ _ _ _ k) => t Q /= -> ->.
rewrite gain_8_62 // /next_theta addr0 subr0 invmx1 mulmx1 mul1mx /Upsilon invmx1 trmxK scalemx1.
have -> : lambda%:M + (phi k.+1)^T *m P *m phi k.+1 = (lambda + value P (phi k.+1))%:M.
  by rewrite raddfD /=; congr (_ + _); rewrite [LHS]mx11_scalar.
rewrite invmx_scalar mul_mx_scalar; move: (_ *: _) => g.
have -> : col j (X + g *m (target k.+1 - (phi k.+1)^T *m X))
    = col j X + g *m col j (target k.+1 - (phi k.+1)^T *m X) by rewrite !colE mulmxDl mulmxA.
rewrite -mulmxN; congr (_ + _ *m _).
apply/matrixP=> a b; rewrite !ord1 !mxE eqxx mulr1n opprD opprK addrC; congr (_ - _).
by apply: eq_bigr => i _; rewrite !mxE.
Qed.

Lemma value_of_a_number (x : 'cV[R]_1) : value 1%:M x = x 0 0 ^+ 2.
Proof. by rewrite /value /bilinear mulmx1 mxE big_ord1 mxE expr2. Qed.

(* The cost is that of the columns. *)
Lemma cost_of_columns k X : subsystem_cost k X = \sum_j cost lambda (fun i => (phi i)^T) (fun=> 1%:M)
  (fun=> 0) (fun i => - (target i 0 j)%:M) (fun=> 0) (invmx P_0) (col j start) k (col j X).
Proof.
rewrite /subsystem_cost /cost [RHS]big_split /=; congr (_ + _).
  rewrite exchange_big /=; apply: eq_bigr => i _; rewrite mulr_sumr; apply: eq_bigr => j _.
  have value_0 (x : 'cV[R]_1) : value 0 x = 0 by rewrite /value /bilinear mulmx0 mul0mx mxE.
  congr (_ * _); rewrite /stage subr0 value_of_a_number value_0 addr0 -[RHS]sqrrN; congr (_ ^+ 2); rewrite !mxE eqxx mulr1n opprD opprK; congr (_ - _).
  by apply: eq_bigr => a _; rewrite !mxE.
rewrite -mulr_sumr; congr (_ * _); apply: eq_bigr => j _.
rewrite -linearB /= /value /bilinear tr_col -row_mul !mxE; apply: eq_bigr => i _.
by rewrite [(row _ _) _ _]mxE [(col _ _) _ _]mxE.
Qed.

(* Of all matrices, for every k, the one of the recursion has the least cost. *)
Theorem subsystem_recursion_minimises k X : X != (subsystem_recursion k).1 ->
  subsystem_cost k (subsystem_recursion k).1 < subsystem_cost k X.
Proof.
move=> other; have [definite same_P same_X] := columns_of_recursion k; rewrite !cost_of_columns.
have one_definite (i : nat) : positive_definite (1%:M + 0 : 'M[R]_1).
  rewrite addr0; split=> [|x nz]; first exact: trmx1.
  rewrite value_of_a_number lt_def sqr_ge0 andbT expf_eq0 /=.
  apply: contra nz => /eqP zero; apply/eqP/matrixP=> a b.
  by rewrite !ord1 zero mxE.
have least j x : x != (column j k).1 -> _ := @recursive_least_squares R l 1 lambda _ _ _ _ _ _ _
  lambda_positive (definite_inverse P_0_definite) (fun=> trmx1 _ 1) (fun=> trmx0 _ 1 1) one_definite k x.
have not_more j : cost lambda (fun i => (phi i)^T) (fun=> 1%:M) (fun=> 0)
    (fun i => - (target i 0 j)%:M) (fun=> 0) (invmx P_0) (col j start) k
    (col j (subsystem_recursion k).1) <= cost lambda (fun i => (phi i)^T) (fun=> 1%:M) (fun=> 0)
    (fun i => - (target i 0 j)%:M) (fun=> 0) (invmx P_0) (col j start) k (col j X).
  have [->|differs] := eqVneq (col j X) (col j (subsystem_recursion k).1); first exact: lexx.
  by rewrite ltW // -(same_X j) least // same_X.
have [j differs] : exists j, col j X != (column j k).1.
  apply/existsP; apply: contraR other; rewrite negb_exists => /forallP same.
  apply/eqP/matrixP=> i j; have /negPn/eqP := same j; rewrite same_X.
  by move/matrixP/(_ i 0); rewrite !mxE.
rewrite (bigD1 j) //= [X in _ < X](bigD1 j) //= ltr_le_add //; last by apply: ler_sum => a _.
by rewrite -(same_X j) least.
Qed.
End SubsystemRecursion.
