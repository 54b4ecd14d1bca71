(* Plants and compensators of orders 1 and 2 given by their entries, for the counterexamples. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Sums.
Variable V : zmodType.

Lemma sum_of_one (F : 'I_1 -> V) : \sum_(i < 1) F i = F ord0 + 0.
Proof. by rewrite big_ord_recl big_ord0. Qed.

Lemma sum_of_two (F : 'I_2 -> V) : \sum_(i < 2) F i = F ord0 + (F (lift ord0 ord0) + 0).
Proof. by rewrite !big_ord_recl big_ord0. Qed.
End Sums.

(* Decides an equation between matrices of at most two rows and columns, entry by entry. Sums of one
   and of two terms are written out in one step each: terms of many small steps take long to check. *)
Ltac entry_by_entry :=
  apply/matrixP; case=> [[|[|//]] ?]; case=> [[|[|//]] ?] //;
  repeat first [rewrite !mxE | rewrite !(sum_of_two, sum_of_one) | rewrite !(big_ord_recl, big_ord0)];
  rewrite /=.

Section Entries.
Variable R : comRingType.

Definition matrix_2 (a b c d : R) : 'M[R]_2 := \matrix_(i, j)
  nth 0 (nth [::] [:: [:: a; b]; [:: c; d]] i) j.
Definition column_2 (a b : R) : 'cV[R]_2 := \col_i nth 0 [:: a; b] i.
Definition row_2 (a b : R) : 'rV[R]_2 := \row_j nth 0 [:: a; b] j.

Lemma column_row a b c d : column_2 a b *m row_2 c d = matrix_2 (a * c) (a * d) (b * c) (b * d).
Proof. by entry_by_entry; rewrite ?addr0. Qed.

Lemma matrix_2_mul a b c d a' b' c' d' : matrix_2 a b c d *m matrix_2 a' b' c' d'
  = matrix_2 (a * a' + b * c') (a * b' + b * d') (c * a' + d * c') (c * b' + d * d').
Proof. by entry_by_entry; rewrite addr0. Qed.

Lemma matrix_2_add a b c d a' b' c' d' :
  matrix_2 a b c d + matrix_2 a' b' c' d' = matrix_2 (a + a') (b + b') (c + c') (d + d').
Proof. by entry_by_entry. Qed.

Lemma matrix_2_opp a b c d : - matrix_2 a b c d = matrix_2 (- a) (- b) (- c) (- d).
Proof. by entry_by_entry. Qed.

Lemma matrix_2_scale k a b c d : k *: matrix_2 a b c d = matrix_2 (k * a) (k * b) (k * c) (k * d).
Proof. by entry_by_entry. Qed.

Lemma matrix_2_tr a b c d : (matrix_2 a b c d)^T = matrix_2 a c b d.
Proof. by entry_by_entry. Qed.

Lemma row_2_tr a b : (row_2 a b)^T = column_2 a b.
Proof. by entry_by_entry. Qed.

Lemma column_2_tr a b : (column_2 a b)^T = row_2 a b.
Proof. by entry_by_entry. Qed.

Lemma row_matrix_2 a b a' b' c' d' :
  row_2 a b *m matrix_2 a' b' c' d' = row_2 (a * a' + b * c') (a * b' + b * d').
Proof. by entry_by_entry; rewrite addr0. Qed.

Lemma row_column_2 a b c d : row_2 a b *m column_2 c d = (a * c + b * d)%:M.
Proof. by entry_by_entry; rewrite addr0 ?mulr1n. Qed.

Lemma zero_2 : 0 = matrix_2 0 0 0 0.
Proof. by entry_by_entry. Qed.

Lemma matrix_2_entries (M : 'M[R]_2) : exists a b c d, M = matrix_2 a b c d.
Proof.
exists (M 0 0), (M 0 1), (M 1 0), (M 1 1).
by entry_by_entry; congr (M _ _); apply: val_inj.
Qed.

Lemma column_2_entries (v : 'cV[R]_2) : exists a b, v = column_2 a b.
Proof. by exists (v 0 0), (v 1 0); entry_by_entry; congr (v _ _); apply: val_inj. Qed.

Lemma det_2 a b c d : \det (matrix_2 a b c d) = a * d - b * c.
Proof.
rewrite (expand_det_row _ 0) !big_ord_recl big_ord0 /cofactor !det_mx11 !mxE /=.
by rewrite expr0 mul1r addr0 expr1 mulN1r mulrN.
Qed.

Lemma char_poly_1 (a : R) : char_poly (a%:M : 'M[R]_1) = 'X - a%:P.
Proof. by rewrite /char_poly det_mx11 !mxE !eqxx !mulr1n. Qed.

Lemma char_poly_2 a b c d :
  char_poly (matrix_2 a b c d) = 'X^2 - (a + d)%:P * 'X + (a * d - b * c)%:P.
Proof.
rewrite /char_poly (expand_det_row _ 0) !big_ord_recl big_ord0 /cofactor !det_mx11 !mxE /=.
rewrite !polyCD !polyCN !polyCM /= expr0 expr1 !mulr1n !mulr0n; ring.
Qed.

Lemma char_poly_diagonal (a b : R) : char_poly (matrix_2 a 0 0 b) = ('X - a%:P) * ('X - b%:P).
Proof. by rewrite char_poly_2 !(polyCD, polyCN, polyCM); ring. Qed.

Lemma sum_of_modes (a b : R) : (1 * 1 + 1 * 1)%:P * 'X
    + (0 * 1 * 1 + 0 * 1 * 1 - a * 1 * 1 - b * 1 * 1)%:P = ('X - a%:P) + ('X - b%:P) :> {poly R}.
Proof. by rewrite !(polyCD, polyCN, polyCM); ring. Qed.

Lemma char_poly_2_difference (a b c d e f g h : R) :
  char_poly (matrix_2 a b c d)
    - char_poly (matrix_2 (a + e * g) (b + e * h) (c + f * g) (d + f * h))
  = (g * e + h * f)%:P * 'X + (b * f * g + c * e * h - a * f * h - d * e * g)%:P.
Proof. by rewrite !char_poly_2 !(polyCD, polyCN, polyCM); ring. Qed.
End Entries.

Section Numerators.
Variable R : idomainType.

Lemma numerator_1 (a b c : R) : numerator (a%:M : 'M[R]_1) b%:M c%:M = (b * c)%:P.
Proof. by rewrite numeratorE -scalar_mxM -raddfD /= !char_poly_1 polyCD; ring. Qed.

Lemma numerator_2 (a b c d e f g h : R) :
  numerator (matrix_2 a b c d) (column_2 e f) (row_2 g h)
  = (g * e + h * f)%:P * 'X + (b * f * g + c * e * h - a * f * h - d * e * g)%:P.
Proof. by rewrite numeratorE column_row matrix_2_add char_poly_2_difference. Qed.

Lemma numerator_diagonal (a b : R) :
  numerator (matrix_2 a 0 0 b) (column_2 1 1) (row_2 1 1) = ('X - a%:P) + ('X - b%:P).
Proof. by rewrite numerator_2 sum_of_modes. Qed.
End Numerators.
