(* (7.25) with the change of basis that (7.26) defines. PolePlacement.v has the true statement. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary SmallSystems.
From Compensators.theorems Require Import PolePlacement.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section ChangeOfBasis.
Variable R : realFieldType.

(* Refuted: "A + BK = S_C (A_C + B_C K_C) S_C^-1" with A_C = S_C A S_C^-1 in companion form,
   B_C = S_C B and K_C = K S_C^-1. For x_1' = 2 x_2, x_2' = u and S_C = diag(1/2, 1) it holds for no
   gain K; S_C^-1 and S_C must change places. *)
Theorem change_of_basis_7_25 :
  let A : 'M[R]_2 := matrix_2 0 2%:R 0 0 in let B := column_2 0 1 in
  let S_C : 'M[R]_2 := matrix_2 2%:R^-1 0 0 1 in
  let A_C := S_C *m A *m invmx S_C in let B_C := S_C *m B in
  [/\ S_C \in unitmx, A_C = companion 2 'X^2, B_C = column_2 0 1
    & forall K : 'rV[R]_2, let K_C := K *m invmx S_C in
      A + B *m K <> S_C *m (A_C + B_C *m K_C) *m invmx S_C /\
      A + B *m K = invmx S_C *m (A_C + B_C *m K_C) *m S_C].
Proof.
move=> A B S_C A_C B_C.
have nz_2 : 2%:R != 0 :> R by rewrite pnatr_eq0.
pose inverse : 'M[R]_2 := matrix_2 2%:R 0 0 1.
have SI : S_C *m inverse = 1%:M.
  rewrite matrix_2_mul mulVf // !mulr0 !mul0r !addr0 add0r mulr1.
  by entry_by_entry; rewrite ?mulr1n ?mulr0n.
have [unit_S _] := mulmx1_unit SI.
have Einv : invmx S_C = inverse by rewrite -[LHS]mulmx1 -SI mulKmx.
have EA : A_C = matrix_2 0 1 0 0.
  rewrite /A_C Einv !matrix_2_mul !(mulr0, mul0r, addr0, add0r, mulr1, mul1r).
  by rewrite mulVf.
have EB : B_C = column_2 0 1.
  by rewrite /B_C; entry_by_entry; rewrite !(mulr0, mul0r, addr0, add0r, mulr1).
split=> //; first by rewrite EA; entry_by_entry; rewrite ?coefXn ?oppr0.
move=> K K_C; split; last first.
  rewrite mulmxDr mulmxDl /A_C /B_C /K_C !mulmxA mulVmx // mul1mx.
  rewrite -[A *m _ *m _]mulmxA mulVmx // mulmx1 mul1mx.
  by rewrite -[B *m K *m _ *m _]mulmxA mulVmx // mulmx1.
have [a [b EK]] : exists a b, K = row_2 a b.
  by exists (K 0 0), (K 0 1); entry_by_entry; congr (K _ _); apply: val_inj.
rewrite /K_C EK EA EB Einv row_matrix_2 !column_row !matrix_2_add !matrix_2_mul.
move/matrixP/(_ 0 1); rewrite !mxE /= !(mulr0, mul0r, addr0, add0r, mulr1, mul1r).
by move/(congr1 (fun t => t * 2%:R)); rewrite mulVf // -natrM => /eqP; rewrite pnatr_eq1.
Qed.
End ChangeOfBasis.
