(* The unobservable modes of a compensator, and the upper part of an invariant subspace whose
   polynomial has none of them. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman Coprimeness InvariantSubspaces.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section UnobservablePolynomial.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (C : 'rV[R]_n).

Lemma unobservable_annihilated u m (v : 'M[R]_(n, m)) : is_unobservable_polynomial A C u ->
  (forall k, C *m A ^+ k *m v = 0) -> horner_mx A u *m v = 0.
Proof.
case=> -[|d] [x [Z [_ invariant -> spanned]]] /spanned[y ->].
  by rewrite (flatmx0 y) mulmx0 mulmx0.
by rewrite mulmxA (horner_mx_columns _ invariant) Cayley_Hamilton mulmx0 mul0mx.
Qed.

(* Every pair has one. *)
Theorem unobservable_polynomial_exists : exists u, is_unobservable_polynomial A C u.
Proof.
pose O := observability_matrix A C; pose x := (row_base (kermx O^T))^T.
have Ox : O *m x = 0.
  apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK trmx0.
  by apply/sub_kermxP; rewrite eq_row_base.
have unseen k : C *m A ^+ k *m x = 0.
  apply: (can_inj (@trmxK _ _ _)); rewrite !trmx_mul transpose_power trmxK trmx0 mulmxA.
  have : x^T *m controllability_matrix A^T C^T = 0.
    by rewrite controllability_matrix_dual -trmx_mul Ox trmx0.
  by move/all_powers/(_ 'X^k); rewrite rmorphX /= horner_mx_X /x trmxK.
have spanned m (v : 'M[R]_(n, m)) : (forall k, C *m A ^+ k *m v = 0) -> exists y, v = x *m y.
  move=> zero; have Ov : O *m v = 0.
    by apply/row_matrixP=> i; rewrite row_mul row_observability_matrix zero row0.
  have /submxP[D ED] : (v^T <= row_base (kermx O^T))%MS.
    by rewrite eq_row_base; apply/sub_kermxP; rewrite -trmx_mul Ov trmx0.
  by exists D^T; rewrite /x -trmx_mul -ED trmxK.
have [|Z invariant] := spanned _ (A *m x).
  by move=> k; rewrite !mulmxA -[_ *m A ^+ k *m A]mulmxA mulmxE -exprSr unseen.
exists (char_poly Z), (\rank (kermx O^T)), x, Z; split=> //.
  by rewrite /x mxrank_tr; have := row_base_free (kermx O^T) => /eqP.
move=> m v; split; first exact: spanned.
by case=> y -> k; rewrite mulmxA unseen mul0mx.
Qed.
End UnobservablePolynomial.

(* The upper part of an invariant subspace is invertible where its polynomial has no unobservable
   mode of the compensator. *)
Section UpperPart.
Variables (R : fieldType) (order order_c : nat).
Local Notation n := order.+1.
Local Notation n_c := order_c.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c).
Variables (V_1 : 'M[R]_n) (V_2 : 'M[R]_(n_c, n)) (X : 'M[R]_n) (u : {poly R}).
Hypothesis upper : A *m V_1 + B *m C_c *m V_2 = V_1 *m X.
Hypothesis lower : B_c *m C *m V_1 + A_c *m V_2 = V_2 *m X.

Theorem coprime_upper_part : controllable A B -> is_unobservable_polynomial A_c C_c u ->
  coprimep (char_poly X) u -> \rank (col_mx V_1 V_2) = n -> V_1 \in unitmx.
Proof.
move=> c unobservable coprime_u full.
have free (W : 'M[R]_n) : V_1 *m W = 0 -> V_2 *m W = 0 -> W = 0.
  move=> W1 W2; have full_V : row_full (col_mx V_1 V_2) by rewrite /row_full full.
  by apply: (row_full_inj full_V); rewrite mulmx0 mul_col_mx W1 W2 col_mx0.
rewrite -row_full_unit -cokermx_eq0; apply/eqP; set W := cokermx V_1.
have W0 : V_1 *m W = 0 by apply: mulmx_coker.
have shift p : V_1 *m (horner_mx X p *m W) = 0 /\
    V_2 *m (horner_mx X p *m W) = horner_mx A_c p *m (V_2 *m W).
  by apply: (kernel_moves (leqnn _) upper lower p c W0).
have unseen k : C_c *m A_c ^+ k *m (V_2 *m W) = 0.
  have [zero moved] := shift 'X^k; have [_ _] := kernel_is_unseen (leqnn _) upper lower c zero.
  by rewrite moved rmorphX /= horner_mx_X !mulmxA.
apply: (can_inj (@trmxK _ _ _)); rewrite trmx0.
apply: (coprime_annihilators (A := X^T) coprime_u).
  by rewrite -char_poly_tr Cayley_Hamilton mulmx0.
have [zero_1 zero_2] := shift u.
rewrite (unobservable_annihilated unobservable unseen) in zero_2.
have := congr1 trmx (free _ zero_1 zero_2); rewrite trmx_mul trmx0 => zero.
by rewrite -[horner_mx _ u]trmxK horner_mx_transpose trmxK.
Qed.
End UpperPart.

