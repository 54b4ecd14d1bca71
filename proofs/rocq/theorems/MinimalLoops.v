(* The loop of a minimal plant and an observable compensator has one eigenvector for each eigenvalue,
   over any field: it is nonderogatory. Any n and n_c, scalar signals. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
From Compensators.theorems Require Import Kalman.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.
Section MinimalLoops.
Variables (R : fieldType) (order order_c : nat).
Local Notation n := order.+1.
Local Notation n_c := order_c.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c).

Lemma rank_by_row m k (V : 'M[R]_(k, m)) (u : 'rV[R]_m) :
  (forall p (w : 'M[R]_(m, p)), u *m w = 0 -> V *m w = 0) -> (\rank V <= 1)%N.
Proof.
move=> inj; have : (kermx u^T <= kermx V^T)%MS.
  apply/sub_kermxP; have zero : u *m (kermx u^T)^T = 0.
    by apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK mulmx_ker trmx0.
  by apply: (can_inj (@trmxK _ _ _)); rewrite trmx_mul trmxK inj // trmx0.
move/mxrankS; rewrite !mxrank_ker !mxrank_tr => le; have := rank_leq_row u; have := rank_leq_col V.
by move: (\rank V) (\rank u) le (rank_leq_col u); lia.
Qed.

(* Whatever columns are sent to lambda times themselves, they span one dimension at most. *)
Theorem minimal_loop_has_one_eigenvector lambda m (V_1 : 'M[R]_(n, m)) (V_2 : 'M[R]_(n_c, m)) :
  minimal A B C -> observable A_c C_c ->
  closed_loop A B C A_c B_c C_c *m col_mx V_1 V_2 = lambda *: col_mx V_1 V_2 ->
  (\rank (col_mx V_1 V_2) <= 1)%N.
Proof.
move=> [cAB oAC] oc; rewrite mul_block_col scale_col_mx => /eq_col_mx[upper lower].
have unseen p (w : 'M[R]_(m, p)) : C_c *m V_2 *m w = 0 -> C *m V_1 *m w = 0 ->
  col_mx V_1 V_2 *m w = 0.
  move=> u0 y0; rewrite mul_col_mx.
  have -> : V_1 *m w = 0.
    apply: (no_hidden_subspace (X := lambda%:M) oAC); last by rewrite mulmxA.
    have := congr1 (fun X => X *m w) upper; rewrite mulmxDl -!mulmxA (mulmxA C_c) u0 mulmx0 addr0.
    by move=> ->; rewrite mul_mx_scalar -scalemxAl -scalemxAr.
  have -> : V_2 *m w = 0.
    apply: (no_hidden_subspace (X := lambda%:M) oc); last by rewrite mulmxA.
    have := congr1 (fun X => X *m w) lower; rewrite mulmxDl -!mulmxA (mulmxA C V_1) y0 mulmx0 add0r.
    by move=> ->; rewrite mul_mx_scalar -scalemxAl -scalemxAr.
  by rewrite col_mx0.
have [eigen|regular] := boolP (eigenvalue A lambda).
  have [eta Eeta nz_eta] := eigenvalueP eigen.
  have u0 : C_c *m V_2 = 0.
    have nz : eta *m B != 0.
      apply: contraNneq nz_eta => zero; apply/eqP.
      by apply: (no_hidden_left_subspace (X := lambda%:M) cAB _ zero); rewrite Eeta mul_scalar_mx.
    have := congr1 (fun X => eta *m X) upper; rewrite mulmxDr mulmxA Eeta -scalemxAl -scalemxAr.
    rewrite -[RHS]addr0 => /addrI; rewrite -(mulmxA B) mulmxA; set b := eta *m B.
    rewrite [b]mx11_scalar mul_scalar_mx => /eqP.
    rewrite scaler_eq0 => /orP[/eqP zero|/eqP //].
    by move: nz; rewrite -/b [b]mx11_scalar zero raddf0 eqxx.
  by apply: (@rank_by_row _ _ _ (C *m V_1)) => p w; apply: unseen; rewrite u0 mul0mx.
pose M := lambda%:M - A.
have unit_M : M \in unitmx.
  rewrite -row_free_unit -kermx_eq0; apply: contraNT regular => nz.
  by rewrite /eigenvalue /eigenspace -opprB -[X in kermx (- X)]/M -scaleN1r -mxrank_eq0
    mxrank_ker mxrank_scale_nz ?oppr_eq0 ?oner_eq0 // -mxrank_ker mxrank_eq0.
have V1E : V_1 = invmx M *m (B *m (C_c *m V_2)).
  rewrite [B *m _]mulmxA -[LHS](mulKmx unit_M); congr (_ *m _).
  by rewrite /M mulmxBl mul_scalar_mx -upper addrAC subrr add0r.
apply: (@rank_by_row _ _ _ (C_c *m V_2)) => p w u0; apply: unseen => //.
by rewrite V1E -!mulmxA (mulmxA C_c) u0 !mulmx0.
Qed.
End MinimalLoops.

(* And so in every field that contains the first: the loop is nonderogatory over an algebraic closure. *)
Section Extension.
Variables (R F : fieldType) (f : {rmorphism R -> F}) (order order_c : nat).
Local Notation n := order.+1.
Local Notation n_c := order_c.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c).

Lemma controllable_map k (M : 'M[R]_k.+1) (b : 'cV[R]_k.+1) :
  controllable (map_mx f M) (map_mx f b) = controllable M b.
Proof.
rewrite /controllable -(mxrank_map f (controllability_matrix M b)); congr (\rank _ == _).
by apply/matrixP=> i j; rewrite [LHS]mxE [RHS]mxE [X in f X]mxE -[map_mx f M ^+ _]rmorphX /= -map_mxM mxE.
Qed.

Lemma observable_map k (M : 'M[R]_k.+1) (c : 'rV[R]_k.+1) :
  observable (map_mx f M) (map_mx f c) = observable M c.
Proof.
rewrite /observable -(mxrank_map f (observability_matrix M c)); congr (\rank _ == _).
by apply/matrixP=> i j; rewrite [LHS]mxE [RHS]mxE [X in f X]mxE -[map_mx f M ^+ _]rmorphX /= -map_mxM mxE.
Qed.

Theorem minimal_loop_is_nonderogatory lambda m (V_1 : 'M[F]_(n, m)) (V_2 : 'M[F]_(n_c, m)) :
  minimal A B C -> observable A_c C_c ->
  map_mx f (closed_loop A B C A_c B_c C_c) *m col_mx V_1 V_2 = lambda *: col_mx V_1 V_2 ->
  (\rank (col_mx V_1 V_2) <= 1)%N.
Proof.
rewrite /minimal -controllable_map -!observable_map /closed_loop map_block_mx !map_mxM => mABC oc.
exact: (minimal_loop_has_one_eigenvector mABC oc).
Qed.
End Extension.
