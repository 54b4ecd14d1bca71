(* High-authority LQG from the plant's data alone: the regulator and the observer exist, their poles
   are the corrected (A.15) and (A.16), those of the loop the corrected (A.17), and the target model
   of the corrected (4.24) is the intercalated transfer function. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman ClosedLoop ReturnDifference HighAuthorityPoles Stein.
From Compensators.theorems Require Import Riccati.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* N = H N_s N_u of degree n - d: monic N_s with its zeros inside the unit circle, N_u outside. *)
Definition split_by_circle (R : rcfType) (N : {poly R}) H (N_s N_u : {poly R}) k l :=
  [/\ N = H *: (N_s * N_u), H != 0,
      [/\ N_s \is monic, degree_is N_s k & inside N_s]
    & [/\ N_u \is monic, degree_is N_u l & outside N_u]].

(* The monic polynomial of q^l N_u(1/q): its zeros are the reciprocals. *)
Definition reciprocals (R : rcfType) l (N_u : {poly R}) : {poly R} := N_u.[0]^-1 *: reversed l N_u.

Section Regulator.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (E_1 : 'rV[R]_n) (E_2 : R).

(* (A.6), (A.7) for R_1 = E_1'E_1, R_12 = E_1'E_2, R_2 = E_2^2, with a closed loop inside. *)
Definition optimal_regulator (P : 'M[R]_n) (K : 'rV[R]_n) :=
  let W := E_2 ^+ 2 + (B^T *m P *m B) 0 0 in
  [/\ P^T = P, W *: K = - (E_2 *: E_1 + B^T *m P *m A),
      P = A^T *m P *m A + E_1^T *m E_1 - W *: (K^T *m K)
    & inside (char_poly (A + B *m K))].

Lemma optimal_is_stabilising P K : optimal_regulator P K ->
  stabilising A (E_1^T *m E_1) B (E_2 *: E_1^T) (E_2 ^+ 2)%:M P K.
Proof.
case=> P_T gain riccati in_K; split=> //.
have EW : innovation_weight B (E_2 ^+ 2)%:M P = (E_2 ^+ 2 + (B^T *m P *m B) 0 0)%:M.
  by rewrite /innovation_weight {1}[B^T *m P *m B]mx11_scalar -raddfD.
split=> //; first by rewrite EW mul_scalar_mx gain linearZ /= trmxK.
by rewrite EW mul_mx_scalar -scalemxAl.
Qed.

Theorem optimal_regulator_is_unique P K P' K' :
  optimal_regulator P K -> optimal_regulator P' K' -> P = P'.
Proof.
move=> /optimal_is_stabilising S /optimal_is_stabilising S'.
by apply: (stabilising_solution_is_unique _ S S'); rewrite tr_scalar_mx.
Qed.

(* Exactly one stabilising P, its poles, and R_2 + B'PB. *)
Theorem high_authority_regulator H k l d (N_s N_u : {poly R}) :
  controllable A B -> split_by_circle (full_numerator A B E_1 E_2) H N_s N_u k l ->
  n = (d + (k + l))%N ->
  exists P K, [/\ optimal_regulator P K,
    forall P' K', optimal_regulator P' K' -> P' = P,
    char_poly (A + B *m K) = 'X^d * (N_s * reciprocals l N_u)
    & E_2 ^+ 2 + (B^T *m P *m B) 0 0 = (H * N_u.[0]) ^+ 2].
Proof.
move=> reaches [N_zu nz_H [monic_s deg_s in_s] [monic_u deg_u out_u]] n_split.
have [P [K optimal]] :=
  stabilising_solution_exists reaches N_zu n_split monic_s deg_s in_s monic_u deg_u out_u.
have [P_T gain riccati in_K] := optimal.
have [poles weight] := poles_of_high_authority_lqg P_T gain riccati in_K N_zu nz_H n_split
  monic_s deg_s in_s monic_u deg_u out_u.
exists P, K; split=> // [P' K' other|]; first exact: optimal_regulator_is_unique other optimal.
have nz_0 := outside_0 out_u.
by rewrite /reciprocals -!scalerAr -poles scalerA mulVf ?scale1r.
Qed.
End Regulator.

Section Observer.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (C : 'rV[R]_n) (D_1 : 'cV[R]_n) (D_2 : R).

(* The regulator of the transposed system, Q for P and -B_c' for K. *)
Definition optimal_observer (Q : 'M[R]_n) (B_c : 'cV[R]_n) :=
  optimal_regulator A^T C^T D_1^T D_2 Q (- B_c^T).

Theorem high_authority_observer H k l d (N_s N_u : {poly R}) :
  observable A C -> split_by_circle (full_numerator A D_1 C D_2) H N_s N_u k l ->
  n = (d + (k + l))%N ->
  exists Q B_c, [/\ optimal_observer Q B_c,
    forall Q' B_c', optimal_observer Q' B_c' -> Q' = Q,
    char_poly (A - B_c *m C) = 'X^d * (N_s * reciprocals l N_u)
    & D_2 ^+ 2 + (C *m Q *m C^T) 0 0 = (H * N_u.[0]) ^+ 2].
Proof.
rewrite duality => reaches factors n_split.
have dual : full_numerator A^T C^T D_1^T D_2 = full_numerator A D_1 C D_2.
  by rewrite /full_numerator numerator_tr char_poly_tr.
rewrite -dual in factors.
have [Q [K [optimal unique poles weight]]] := high_authority_regulator reaches factors n_split.
exists Q, (- K^T); rewrite /optimal_observer linearN /= trmxK opprK; split=> //.
- by move=> Q' B_c' /unique.
- rewrite -poles -char_poly_tr mulNmx opprK [in LHS]linearD /= trmx_mul trmxK.
  by [].
by rewrite -weight trmxK.
Qed.
End Observer.

Section Loop.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B D_1 : 'cV[R]_n) (C E_1 : 'rV[R]_n) (D_0 : 'M[R]_1) (E_2 D_2 : R).
Variables (H H' : R) (k l d k' l' d' : nat) (N_s N_u N_s' N_u' : {poly R}).
Hypotheses (reaches : controllable A B) (sees : observable A C).
Hypothesis regulator : split_by_circle (full_numerator A B E_1 E_2) H N_s N_u k l.
Hypothesis observer : split_by_circle (full_numerator A D_1 C D_2) H' N_s' N_u' k' l'.
Hypotheses (n_split : n = (d + (k + l))%N) (n_split' : n = (d' + (k' + l'))%N).

(* (A.17) corrected: the poles of the loop, with the direct term D_0 of (A.12). *)
Theorem poles_A_17 : exists P K Q B_c,
  [/\ optimal_regulator A B E_1 E_2 P K, optimal_observer A C D_1 D_2 Q B_c
    & let A_c := A + B *m K - B_c *m C - B_c *m D_0 *m K in
      char_poly (block_mx A (B *m K) (B_c *m C) (A_c + B_c *m D_0 *m K))
      = 'X^(d + d') * (N_s * reciprocals l N_u * (N_s' * reciprocals l' N_u'))].
Proof.
have [P [K [optimal _ poles _]]] := high_authority_regulator reaches regulator n_split.
have [Q [B_c [optimal' _ poles' _]]] := high_authority_observer sees observer n_split'.
exists P, K, Q, B_c; split=> // A_c; rewrite [LHS](separation_A_11 A B C K B_c D_0) poles poles' exprD.
by rewrite mulrACA.
Qed.

(* (4.24) corrected, for n_c = n: H q^(n - d - d') N_u / (M N_s' M'), M and M' the reciprocals, is
   N_zu q^n over those poles; written without division. *)
Theorem target_4_24 :
  let Dtilde := 'X^(d + d') * (N_s * reciprocals l N_u * (N_s' * reciprocals l' N_u')) in
  'X^(d + d') * (full_numerator A B E_1 E_2 * 'X^n)
    * (reciprocals l N_u * (N_s' * reciprocals l' N_u'))
  = H *: ('X^n * N_u) * Dtilde.
Proof.
have [-> _ _ _] := regulator; rewrite /= -!mul_polyC.
move: H%:P ('X^(d + d') : {poly R}) ('X^n : {poly R}) (reciprocals l N_u) (reciprocals l' N_u').
by move=> h a b c e; ring.
Qed.
End Loop.
