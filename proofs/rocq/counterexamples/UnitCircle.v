(* Appendix A's conditions i)-iv) with R_2 = 0. HighAuthorityPoles.v assumes what is needed. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require Import Coprimeness.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section UnitCircle.
Variable R : realFieldType.

(* Refuted: under i)-iv) "A~ is asymptotically stable" for R_2 = 0. G_zu = (z - 1) / z^2 is minimal,
   so (A, R_1) has no unobservable mode at all; P = E_1' E_1 is positive semidefinite and solves
   (A.7), and the pole of A + B C_c at the zero 1 of G_zu is on the unit circle. "No zero of G_zu on
   the circle" must take the place of ii). *)
Theorem zero_on_the_circle :
  let A : 'M[R]_2 := matrix_2 0 1 0 0 in let B := column_2 0 1 in let E_1 := row_2 (- 1) 1 in
  let R_1 := E_1^T *m E_1 in let R_2 : 'M[R]_1 := 0 in let P := R_1 in let K := row_2 0 1 in
  [/\ minimal A B E_1 /\ numerator A B E_1 = 'X - 1,
      forall x : 'cV[R]_2, 0 <= (x^T *m P *m x) 0 0,
      P = A^T *m P *m A - A^T *m P *m B *m invmx (R_2 + B^T *m P *m B) *m B^T *m P *m A + R_1,
      K = - (invmx (R_2 + B^T *m P *m B) *m B^T *m P *m A)
    & char_poly (A + B *m K) = 'X * ('X - 1)].
Proof.
move=> A B E_1 R_1 R_2 P K.
have EA_T : A^T = matrix_2 0 0 1 0 by entry_by_entry.
have EP : P = matrix_2 1 (- 1) (- 1) 1 by rewrite /P /R_1; entry_by_entry; ring.
have inverse : invmx (R_2 + B^T *m P *m B) = 1%:M.
  rewrite -[RHS]invmx1; congr invmx; rewrite EP.
  by entry_by_entry; rewrite !(mul0r, mulr0, mulr1, mul1r, add0r, addr0).
have EBP : B^T *m P *m A = row_2 0 (- 1).
  by rewrite EP column_2_tr !row_matrix_2; congr row_2; ring.
have Num : numerator A B E_1 = 'X - 1.
  rewrite numerator_2 !(mul0r, mulr0, mulr1, mul1r, add0r, addr0, subr0).
  by rewrite polyCN polyC1.
have Den : denominator A = 'X^2.
  by rewrite /denominator char_poly_2 !(mul0r, mulr0, addr0, subr0).
split.
- split=> //; apply/minimal_iff_coprime; rewrite Num Den -polyC1 coprimep_XsubC rootE hornerXn.
  by rewrite expr1n oner_eq0.
- move=> x; rewrite /P /R_1 mulmxA -trmx_mul -mulmxA mxE big_ord1 mxE.
  by rewrite -expr2 sqr_ge0.
- rewrite inverse mulmx1 -{1}[P]add0r; congr (_ + _).
  have -> : A^T *m P *m B = (B^T *m P *m A)^T by rewrite !trmx_mul !trmxK !mulmxA.
  have -> (v : 'cV[R]_2) : v *m B^T *m P *m A = v *m (B^T *m P *m A) by rewrite !mulmxA.
  rewrite EBP EA_T EP row_2_tr column_row !matrix_2_mul matrix_2_opp matrix_2_add [LHS]zero_2.
  by congr matrix_2; ring.
- by rewrite inverse mul1mx EBP; entry_by_entry; rewrite ?oppr0 ?opprK.
rewrite column_row matrix_2_add char_poly_2 !(mul0r, mulr0, mul1r, addr0, add0r, subr0).
by rewrite oppr0 polyC0 addr0 mulrBr mulr1 expr2.
Qed.
End UnitCircle.
