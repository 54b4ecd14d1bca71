(* A transfer function and its minimal realisations: Markov parameters, gains that are unique,
   minimal realisations that are similar, and minimal = coprime. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement ClosedLoop.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Lemma entry_combination (R : comRingType) (x y : R) (M N : 'M[R]_1) :
  (x *: M - y *: N) 0 0 = x * M 0 0 - y * N 0 0.
Proof. by rewrite !mxE. Qed.

Section FeedbackKeepsZeros.
Variables (R : idomainType) (n : nat).
Implicit Types (A : 'M[R]_n) (B : 'cV[R]_n) (K C : 'rV[R]_n).

Lemma numerator_add A B C C' : numerator A B (C + C') = numerator A B C + numerator A B C'.
Proof. by rewrite /numerator map_mxD !mulmxDl mxE. Qed.

Lemma numerator_scale A B a C : numerator A B (a *: C) = a *: numerator A B C.
Proof. by rewrite /numerator map_mxZ -!scalemxAl mxE mul_polyC. Qed.

(* State feedback moves poles, not zeros ... *)
Lemma numerator_feedback A B K C : numerator (A + B *m K) B C = numerator A B C.
Proof.
rewrite numeratorE -addrA -mulmxDr !char_poly_rank_one numerator_add.
by rewrite opprB addrC addrA subrK addrC addKr.
Qed.

(* ... and so does output injection. *)
Lemma numerator_injection A B C (F : 'cV[R]_n) : numerator (A + F *m C) B C = numerator A B C.
Proof. by rewrite -numerator_tr linearD /= trmx_mul numerator_feedback numerator_tr. Qed.
End FeedbackKeepsZeros.

Section MarkovParameters.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

(* (sI - A) adj(sI - A) B = D B, multiplied by C from the left. *)
Lemma numerator_step A B C :
  numerator A B (C *m A) = 'X * numerator A B C - char_poly A * ((C *m B) 0 0)%:P.
Proof.
pose b := map_mx polyC B; pose v := \adj (char_poly_mx A) *m b.
have response C' : numerator A B C' = (map_mx polyC C' *m v) 0 0 by rewrite /numerator mulmxA.
have shift : map_mx polyC A *m v = 'X *: v - char_poly A *: b.
  rewrite -mul_scalar_mx -[char_poly A *: b]mul_scalar_mx -mul_mx_adj -mulmxA -mulmxBl.
  by rewrite /char_poly_mx subKr.
rewrite !response map_mxM -mulmxA shift mulmxBr -!scalemxAr entry_combination.
by rewrite -map_mxM [map_mx _ _ 0 0]mxE.
Qed.

(* H_1 = C B is the coefficient of s^(n-1). *)
Lemma leading_markov_parameter A B C : (numerator A B C)`_order = (C *m B) 0 0.
Proof.
have high : (numerator A B (C *m A))`_n = 0.
  by rewrite nth_default // numerator_strictly_proper.
have leading : (char_poly A)`_n = 1.
  by have := char_poly_monic A; rewrite monicE lead_coefE size_char_poly => /eqP.
move: high; rewrite numerator_step coefB coefXM coefMC leading mul1r /= => /eqP.
by rewrite subr_eq0 => /eqP.
Qed.
End MarkovParameters.

Section SameTransferFunction.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A A' : 'M[R]_n) (B B' : 'cV[R]_n) (C C' : 'rV[R]_n).
Hypotheses (same_D : denominator A = denominator A').
Hypotheses (same_N : numerator A B C = numerator A' B' C').

(* Equal transfer functions have equal Markov parameters C A^k B. *)
Lemma same_markov_parameters k : C *m A ^+ k *m B = C' *m A' ^+ k *m B'.
Proof.
suff same : numerator A B (C *m A ^+ k) = numerator A' B' (C' *m A' ^+ k).
  apply/matrixP=> i j; rewrite !ord1.
  by rewrite -(leading_markov_parameter A) -(leading_markov_parameter A') same.
elim: k => [|k IH]; first by rewrite !expr0 !mulmx1.
have same_entry : (C *m A ^+ k *m B) 0 0 = (C' *m A' ^+ k *m B') 0 0.
  by rewrite -(leading_markov_parameter A) -(leading_markov_parameter A') IH.
rewrite !exprSr -!mulmxE !mulmxA !numerator_step IH same_entry.
by rewrite -/(denominator A) same_D.
Qed.
End SameTransferFunction.

Section UniqueGains.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

(* A controllable single-input pair has one regulator gain for each spectrum ... *)
Theorem regulator_gain_is_unique K K' : controllable A B ->
  char_poly (A + B *m K) = char_poly (A + B *m K') -> K = K'.
Proof.
move=> /controllableP only_zero; rewrite !char_poly_rank_one => /addrI/oppr_inj same.
apply/eqP; rewrite -subr_eq0; apply/eqP/only_zero => k.
by rewrite !mulmxBl (same_markov_parameters (erefl _) same) subrr.
Qed.

(* ... and an observable single-output pair one observer gain. *)
Theorem observer_gain_is_unique F F' : observable A C ->
  char_poly (A - F *m C) = char_poly (A - F' *m C) -> F = F'.
Proof.
move=> /observableP only_zero; rewrite -!mulNmx !char_poly_rank_one => /addrI/oppr_inj same.
apply: oppr_inj; apply/eqP; rewrite -subr_eq0; apply/eqP/only_zero => k.
by rewrite !mulmxBr (same_markov_parameters (erefl _) same) subrr.
Qed.
End UniqueGains.

Section Shift.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (C : 'rV[R]_n).

(* The rows of the observability matrix shift: O A = (companion matrix) O. *)
Lemma observability_shift :
  observability_matrix A C *m A = companion n (char_poly A) *m observability_matrix A C.
Proof.
apply/row_matrixP=> i; rewrite row_mul row_observability_matrix -mulmxA mulmxE -exprSr.
have [->|not_last] := eqVneq i ord_max.
  rewrite row_companion_last -[LHS]subr0 -{1}(mulmx0 _ C) -(Cayley_Hamilton A).
  rewrite (@horner_mx_monic _ _ _ n) ?char_poly_monic ?size_char_poly //.
  rewrite mulmxDr opprD addrA subrr sub0r mulmx_sumr; congr (- _).
  by apply: eq_bigr => j _; rewrite row_observability_matrix -scalemxAr.
have next : (i.+1 < n)%N by rewrite ltnS ltn_neqAle -ltnS ltn_ord andbT.
by rewrite (@row_companion_next _ _ _ _ _ i (Ordinal next)) // row_observability_matrix.
Qed.
End Shift.

Section SimilarRealisations.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A A' : 'M[R]_n) (B B' : 'cV[R]_n) (C C' : 'rV[R]_n).

(* Two realisations of one order, one of them minimal, with the same transfer function: exactly one
   change of basis takes the second into the first, and the second is minimal too. *)
Theorem similar_realisations : minimal A B C ->
  denominator A = denominator A' -> numerator A B C = numerator A' B' C' ->
  exists T : 'M[R]_n, [/\ T \in unitmx, A *m T = T *m A', T *m B' = B & C *m T = C'].
Proof.
case; rewrite /controllable /observable -!/(row_free _) !row_free_unit.
set O := observability_matrix A C => unit_ctrb unit_O same_D same_N.
have [T OT] : exists T, O *m T = observability_matrix A' C'.
  by exists (invmx O *m observability_matrix A' C'); rewrite mulKVmx.
exists T; have outputs : C *m T = C'.
  have := congr1 (row ord0) OT.
  by rewrite row_mul !row_observability_matrix !expr0 !mulmx1.
have inputs : T *m B' = B.
  apply: (can_inj (mulKmx unit_O)); rewrite mulmxA OT; apply/row_matrixP=> i.
  by rewrite !row_mul !row_observability_matrix (same_markov_parameters same_D same_N).
have similar : A *m T = T *m A'.
  apply: (can_inj (mulKmx unit_O)); rewrite !mulmxA OT !observability_shift -mulmxA OT.
  by rewrite -/(denominator A) same_D.
have : T *m controllability_matrix A' B' \in unitmx.
  suff -> : T *m controllability_matrix A' B' = controllability_matrix A B by [].
  apply: (can_inj (@trmxK _ _ _)); apply/row_matrixP=> j; rewrite -!tr_col; congr (_^T).
  rewrite colE -mulmxA -colE !col_controllability_matrix mulmxA -(power_similar _ similar).
  by rewrite -mulmxA inputs.
by rewrite unitmx_mul => /andP[].
Qed.
End SimilarRealisations.
