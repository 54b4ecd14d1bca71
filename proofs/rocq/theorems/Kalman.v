(* Other words for controllable and observable, and their duality. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Kalman.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).

Lemma horner_mx_wide A m (p : {poly R}) : (size p <= m)%N ->
  horner_mx A p = \sum_(k < m) p`_k *: A ^+ k.
Proof.
move=> deg_p; have -> : p = \sum_(k < m) p`_k *: 'X^k.
  rewrite -poly_def; apply/polyP=> k; rewrite coef_poly.
  by case: ltnP => // above; rewrite nth_default // (leq_trans deg_p).
rewrite rmorph_sum /=; apply: eq_bigr => k _.
rewrite linearZ /= rmorphX /= horner_mx_X; congr (_ *: _).
rewrite coef_sum (bigD1 k) //= coefZ coefXn eqxx mulr1 big1 ?addr0 // => j ne_j.
by rewrite coefZ coefXn eq_sym (inj_eq val_inj) (negPf ne_j) mulr0.
Qed.

Lemma power_similar (T A A' : 'M[R]_n) k : A *m T = T *m A' -> A ^+ k *m T = T *m A' ^+ k.
Proof.
move=> similar; elim: k => [|k IH]; first by rewrite !expr0 mul1mx mulmx1.
by rewrite !exprSr -!mulmxE -mulmxA similar mulmxA IH mulmxA.
Qed.

Lemma transpose_power A k : (A ^+ k)^T = A^T ^+ k.
Proof.
elim: k => [|k IH]; first by rewrite !expr0 trmx1.
by rewrite exprS -mulmxE trmx_mul IH exprSr -mulmxE.
Qed.

Lemma horner_mx_transpose A (p : {poly R}) : (horner_mx A p)^T = horner_mx A^T p.
Proof.
rewrite !(@horner_mx_wide _ (size p)) // linear_sum /=.
by apply: eq_bigr => k _; rewrite linearZ /= transpose_power.
Qed.

Lemma row_observability_matrix A C i : row i (observability_matrix A C) = C *m A ^+ i.
Proof. by apply/rowP=> j; rewrite !mxE. Qed.

Lemma col_controllability_matrix A B j : col j (controllability_matrix A B) = A ^+ j *m B.
Proof. by apply/colP=> i; rewrite !mxE. Qed.

Lemma controllability_matrix_dual A C :
  controllability_matrix A^T C^T = (observability_matrix A C)^T.
Proof.
by apply/matrixP=> i j; rewrite mxE -transpose_power -trmx_mul mxE [RHS]mxE [RHS]mxE.
Qed.

(* (A, C) is observable if and only if (A', C') is controllable. *)
Theorem duality A C : observable A C = controllable A^T C^T.
Proof. by rewrite /controllable controllability_matrix_dual mxrank_tr. Qed.

Theorem dual_duality A B : controllable A B = observable A^T B^T.
Proof. by rewrite duality !trmxK. Qed.

Lemma minimal_dual A B C : minimal A B C -> minimal A^T C^T B^T.
Proof. by case=> c o; split; rewrite ?duality ?trmxK // -duality. Qed.

(* Column j of the controllability matrix. *)
Lemma times_controllability_matrix m (eta : 'M[R]_(m, n)) A B i (j : 'I_n) :
  (eta *m controllability_matrix A B) i j = (eta *m A ^+ j *m B) i 0.
Proof.
by rewrite -mulmxA !mxE; apply: eq_bigr => k _; rewrite [controllability_matrix _ _ _ _]mxE.
Qed.

Lemma horner_mx_monic A m (p : {poly R}) : p \is monic -> degree_is p m ->
  horner_mx A p = A ^+ m + \sum_(k < m) p`_k *: A ^+ k.
Proof.
move=> monic_p deg_p; have leading : p`_m = 1.
  by move: monic_p; rewrite monicE lead_coefE deg_p => /eqP.
have split_p : p = 'X^m + \poly_(k < m) p`_k.
  apply/polyP=> k; rewrite coefD coefXn coef_poly.
  case: ltngtP => [_|above|->]; rewrite ?add0r ?addr0 //.
  by rewrite nth_default // deg_p.
rewrite {1}split_p rmorphD rmorphX /= horner_mx_X (@horner_mx_wide _ m) ?size_poly //.
by congr (_ + _); apply: eq_bigr => k _; rewrite coef_poly ltn_ord.
Qed.

(* By Cayley and Hamilton the first n powers of A say it all. *)
Lemma all_powers m (eta : 'M[R]_(m, n)) A B :
  eta *m controllability_matrix A B = 0 -> forall p : {poly R}, eta *m horner_mx A p *m B = 0.
Proof.
move=> zero p.
have -> : horner_mx A p = horner_mx A (p %% char_poly A).
  by rewrite {1}(divp_eq p (char_poly A)) rmorphD rmorphM /= Cayley_Hamilton mulr0 add0r.
rewrite (@horner_mx_wide _ n); last first.
  by rewrite -ltnS -(size_char_poly A) ltn_modp monic_neq0 // char_poly_monic.
rewrite mulmx_sumr mulmx_suml big1 // => k _.
rewrite -scalemxAr -scalemxAl; apply/matrixP=> i j; rewrite ord1 mxE.
by rewrite -times_controllability_matrix zero !mxE mulr0.
Qed.

(* No row but 0 is orthogonal to every A^k B. *)
Theorem controllableP A B :
  controllable A B <->
  forall m (eta : 'M[R]_(m, n)), (forall k, eta *m A ^+ k *m B = 0) -> eta = 0.
Proof.
split=> [full m eta orthogonal|only_zero].
  apply: (row_free_inj full); rewrite mul0mx; apply/matrixP=> i j.
  by rewrite times_controllability_matrix orthogonal !mxE.
rewrite /controllable -/(row_free _) -kermx_eq0; apply/eqP/only_zero => k.
have := all_powers (mulmx_ker (controllability_matrix A B)) 'X^k.
by rewrite rmorphX /= horner_mx_X.
Qed.

(* Only the state 0 stays unseen. *)
Theorem observableP A C :
  observable A C <->
  forall m (x : 'M[R]_(n, m)), (forall k, C *m A ^+ k *m x = 0) -> x = 0.
Proof.
rewrite duality controllableP; split=> only_zero m x unseen.
  apply: (can_inj (@trmxK _ _ _)); rewrite trmx0; apply: only_zero => k.
  by rewrite -transpose_power -trmx_mul -trmx_mul mulmxA unseen trmx0.
apply: (can_inj (@trmxK _ _ _)); rewrite trmx0; apply: only_zero => k.
apply: (can_inj (@trmxK _ _ _)).
by rewrite !trmx_mul transpose_power trmxK mulmxA unseen trmx0.
Qed.

(* The test of Popov, Belevitch and Hautus, necessary half: no left eigenvector of A is
   orthogonal to B, in any invariant subspace of left vectors. *)
Theorem no_hidden_left_subspace A B m (eta : 'M[R]_(m, n)) X :
  controllable A B -> eta *m A = X *m eta -> eta *m B = 0 -> eta = 0.
Proof.
move=> /controllableP only_zero invariant orthogonal; apply: only_zero => k.
have [Y ->] : exists Y, eta *m A ^+ k = Y *m eta.
  elim: k => [|k [Y IH]]; first by exists 1%:M; rewrite expr0 mulmx1 mul1mx.
  by exists (Y *m X); rewrite exprSr -mulmxE mulmxA IH -!mulmxA invariant.
by rewrite -mulmxA orthogonal mulmx0.
Qed.

Theorem no_hidden_subspace A C m (x : 'M[R]_(n, m)) X :
  observable A C -> A *m x = x *m X -> C *m x = 0 -> x = 0.
Proof.
rewrite duality => dual invariant unseen; apply: (can_inj (@trmxK _ _ _)); rewrite trmx0.
apply: (no_hidden_left_subspace (X := X^T) dual); first by rewrite -!trmx_mul invariant.
by rewrite -trmx_mul unseen trmx0.
Qed.
End Kalman.
