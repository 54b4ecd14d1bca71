(* n-dimensional invariant subspaces of the closed loop are observer-based forms, and conversely. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* One side of the argument, for a compensator of any order n_c >= 1 and a subspace of any dimension
   d <= n. V = [V_1; V_2]. *)
Section KernelOfTheUpperPart.
Variables (R : fieldType) (order order_c dimension : nat).
Local Notation n := order.+1.
Local Notation n_c := order_c.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c).
Local Notation d := dimension.+1.
Variables (V_1 : 'M[R]_(n, d)) (V_2 : 'M[R]_(n_c, d)) (X : 'M[R]_d).
Hypothesis d_n : (d <= n)%N.
Hypothesis upper : A *m V_1 + B *m C_c *m V_2 = V_1 *m X.
Hypothesis lower : B_c *m C *m V_1 + A_c *m V_2 = V_2 *m X.

(* Only if V_1 is singular can some w be in its kernel. Then a left vector eta with eta V_1 = 0 and
   eta B = 1 exists, by controllability, and gives C_c V_2 = -eta A V_1, which vanishes on w. *)
Lemma kernel_is_unseen m (w : 'M[R]_(d, m)) : controllable A B -> V_1 *m w = 0 ->
  [/\ V_1 *m (X *m w) = 0, V_2 *m (X *m w) = A_c *m (V_2 *m w) & C_c *m (V_2 *m w) = 0].
Proof.
move=> c w0; suff unseen : C_c *m (V_2 *m w) = 0.
  split=> //; first by rewrite mulmxA -upper mulmxDl -!mulmxA w0 unseen !mulmx0 addr0.
  by rewrite mulmxA -lower mulmxDl -!mulmxA w0 !mulmx0 add0r.
set L := kermx V_1; have LV : L *m V_1 = 0 by apply: mulmx_ker.
have [LB|] := eqVneq (L *m B) 0.
  suff L0 : L = 0.
    have free_V : row_free V_1 by rewrite -kermx_eq0 -/L L0.
    have full_V : row_full V_1.
      rewrite /row_full eqn_leq rank_leq_col (leq_trans d_n) //.
      by move: free_V; rewrite /row_free => /eqP->.
    by rewrite (row_full_inj full_V (_ : V_1 *m w = V_1 *m 0)) ?w0 !mulmx0.
  have /submxP[Y invariant] : (L *m A <= L)%MS.
    apply/sub_kermxP; rewrite -mulmxA (_ : A *m V_1 = V_1 *m X - B *m C_c *m V_2).
      by rewrite mulmxBr !mulmxA LV LB !mul0mx subr0.
    by rewrite -upper addrK.
  exact: no_hidden_left_subspace c invariant LB.
case/rowV0Pn=> b /submxP[D Eb] nz_b.
have [eta [eta_V eta_B]] : exists eta, eta *m V_1 = 0 /\ eta *m B = b.
  by exists (D *m L); rewrite -[D *m L *m V_1]mulmxA LV mulmx0 -[D *m L *m B]mulmxA.
have : eta *m (V_1 *m X) *m w = 0 by rewrite mulmxA eta_V !mul0mx.
rewrite -upper mulmxDr mulmxDl -!mulmxA w0 !mulmx0 add0r mulmxA eta_B.
rewrite [b]mx11_scalar mul_scalar_mx => /eqP; rewrite scaler_eq0 => /orP[/eqP b0|/eqP //].
by case/negP: nz_b; rewrite [b]mx11_scalar b0 raddf0.
Qed.

(* The kernel of V_1 is invariant under X, and V_2 carries it into an unobservable subspace. *)
Lemma kernel_moves m (w : 'M[R]_(d, m)) p : controllable A B -> V_1 *m w = 0 ->
  V_1 *m (horner_mx X p *m w) = 0 /\
  V_2 *m (horner_mx X p *m w) = horner_mx A_c p *m (V_2 *m w).
Proof.
move=> c w0; elim/poly_ind: p => [|p a [IH1 IH2]]; first by rewrite !rmorph0 !mul0mx !mulmx0.
have [step1 step2 _] := kernel_is_unseen c IH1.
rewrite [p * 'X]mulrC !rmorphD !rmorphM /= !horner_mx_X !horner_mx_C -!mulmxE !mulmxDl.
rewrite !mulmxDr -!mulmxA !mul_scalar_mx -!scalemxAr step1 step2 w0 scaler0 addr0 IH2.
by rewrite mulmxA.
Qed.

(* With an observable compensator the kernel is 0. *)
Theorem upper_part_is_injective : controllable A B -> observable A_c C_c ->
  \rank (col_mx V_1 V_2) = d -> \rank V_1 = d.
Proof.
move=> c o full; have free (W : 'M[R]_d) : V_1 *m W = 0 -> V_2 *m W = 0 -> W = 0.
  move=> W1 W2; have full_V : row_full (col_mx V_1 V_2) by rewrite /row_full full.
  by apply: (row_full_inj full_V); rewrite mulmx0 mul_col_mx W1 W2 col_mx0.
apply/eqP; rewrite -/(row_full _) -cokermx_eq0; apply/eqP; set W := cokermx V_1.
have W0 : V_1 *m W = 0 by apply: mulmx_coker.
apply: free => //; have /observableP only_zero := o; apply: only_zero => k.
have [zero moved] := kernel_moves 'X^k c W0; have [_ _] := kernel_is_unseen c zero.
by rewrite moved rmorphX /= horner_mx_X !mulmxA.
Qed.
End KernelOfTheUpperPart.

Lemma square_injective (R : fieldType) n (V : 'M[R]_n) : \rank V = n -> V \in unitmx.
Proof. by rewrite -row_full_unit /row_full => ->. Qed.

Section FullOrder.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).
Local Notation Atilde := (closed_loop A B C A_c B_c C_c).

Lemma invariant_blocks V_1 V_2 (X : 'M[R]_n) :
  Atilde *m col_mx V_1 V_2 = col_mx V_1 V_2 *m X ->
  A *m V_1 + B *m C_c *m V_2 = V_1 *m X /\ B_c *m C *m V_1 + A_c *m V_2 = V_2 *m X.
Proof. by rewrite mul_block_col mul_col_mx => /eq_col_mx. Qed.

(* Where both parts are invertible, T = V_2 V_1^-1 gives a form, and its regulator acts on the
   subspace: A + BK is similar to X. *)
Theorem invertible_parts_give_form V_1 V_2 (X : 'M[R]_n) :
  Atilde *m col_mx V_1 V_2 = col_mx V_1 V_2 *m X -> V_1 \in unitmx -> V_2 \in unitmx ->
  exists T K F, [/\ observer_form A B C A_c B_c C_c T K F, V_2 = T *m V_1
    & (A + B *m K) *m V_1 = V_1 *m X].
Proof.
move=> /invariant_blocks[upper lower] unit_1 unit_2.
have [T TV] : exists T, T *m V_1 = V_2 by exists (V_2 *m invmx V_1); rewrite mulmxKV.
have unit_T : T \in unitmx by move: unit_2; rewrite -TV unitmx_mul => /andP[].
have regulator : (A + B *m (C_c *m T)) *m V_1 = V_1 *m X.
  by rewrite -upper mulmxDl -!mulmxA TV.
exists T, (C_c *m T), (invmx T *m B_c); split=> //; split=> //; first by rewrite mulKVmx.
rewrite /observer_matrix mulmxBr -[invmx T *m B_c *m C]mulmxA mulKVmx //.
apply: (can_inj (mulmxK unit_1)).
rewrite mulmxBl -[T *m _ *m V_1]mulmxA regulator mulmxA TV -lower -!mulmxA TV.
by rewrite addrAC subrr add0r.
Qed.

(* Every n-dimensional invariant subspace of the closed loop of a minimal plant and a minimal
   compensator of full order is one of an observer-based form. *)
Theorem invariant_subspace_gives_form V_1 V_2 (X : 'M[R]_n) :
  minimal A B C -> minimal A_c B_c C_c -> \rank (col_mx V_1 V_2) = n ->
  Atilde *m col_mx V_1 V_2 = col_mx V_1 V_2 *m X ->
  exists T K F, [/\ observer_form A B C A_c B_c C_c T K F, V_2 = T *m V_1, V_1 \in unitmx
    & char_poly (A + B *m K) = char_poly X].
Proof.
move=> [c o] [c_c o_c] full invariant; have [upper lower] := invariant_blocks invariant.
have unit_1 : V_1 \in unitmx.
  exact/square_injective/(upper_part_is_injective (leqnn _) upper lower).
have unit_2 : V_2 \in unitmx.
  (* plant and compensator change places *)
  apply/square_injective/(@upper_part_is_injective _ _ _ _ A_c B_c C_c A B C V_2 V_1 X);
    rewrite 1?addrC //.
  by rewrite -addsmxE addsmxC addsmxE.
have [T [K [F [form TV regulator]]]] := invertible_parts_give_form invariant unit_1 unit_2.
exists T, K, F; split=> //; apply/esym/(char_poly_similar _ (esym regulator)).
by rewrite -unitfE -unitmxE.
Qed.

(* Conversely the graph of T is invariant, and the closed loop acts on it as A + BK. *)
Theorem form_gives_invariant_subspace T K F : observer_form A B C A_c B_c C_c T K F ->
  invariant_subspace Atilde (col_mx 1%:M T) /\
  Atilde *m col_mx 1%:M T = col_mx 1%:M T *m (A + B *m K).
Proof.
case=> unit_T outputs inputs similar.
have acts : Atilde *m col_mx 1%:M T = col_mx 1%:M T *m (A + B *m K).
  rewrite mul_block_col mul_col_mx !mulmx1 mul1mx -mulmxA outputs; congr col_mx.
  by rewrite similar /observer_matrix mulmxBr mulmxA inputs addrC subrK.
split=> //; split; last by exists (A + B *m K).
have : (\rank (1%:M : 'M[R]_n) <= \rank (col_mx 1%:M T))%N.
  by rewrite mxrankS // -addsmxE addsmxSl.
by rewrite mxrank1 => full; apply/eqP; rewrite eqn_leq rank_leq_col.
Qed.
End FullOrder.

(* A compensator of another order. An n-dimensional invariant subspace is the graph of an n_c x n
   matrix T, and for n_c >= n the columns of T are independent: x_c holds T x. *)
Section OtherOrders.
Variables (R : fieldType) (order order_c : nat).
Local Notation n := order.+1.
Local Notation n_c := order_c.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n_c) (B_c : 'cV[R]_n_c) (C_c : 'rV[R]_n_c).
Variables (V_1 : 'M[R]_n) (V_2 : 'M[R]_(n_c, n)) (X : 'M[R]_n).

Theorem invariant_subspace_is_a_graph : minimal A B C -> minimal A_c B_c C_c ->
  \rank (col_mx V_1 V_2) = n ->
  closed_loop A B C A_c B_c C_c *m col_mx V_1 V_2 = col_mx V_1 V_2 *m X ->
  V_1 \in unitmx /\ exists T : 'M[R]_(n_c, n),
    [/\ V_2 = T *m V_1, B_c *m C + A_c *m T = T *m (A + B *m (C_c *m T)),
        char_poly (A + B *m (C_c *m T)) = char_poly X & (n <= n_c)%N -> \rank T = n].
Proof.
move=> [c o] [c_c o_c] full; rewrite mul_block_col mul_col_mx => /eq_col_mx[upper lower].
have unit_1 : V_1 \in unitmx.
  exact/square_injective/(upper_part_is_injective (leqnn _) upper lower).
split=> //; have [T TV] : exists T, T *m V_1 = V_2 by exists (V_2 *m invmx V_1); rewrite mulmxKV.
have acts : (A + B *m (C_c *m T)) *m V_1 = V_1 *m X.
  by rewrite -upper mulmxDl -TV !mulmxA.
exists T; split=> // [||large].
- apply: (can_inj (mulmxK unit_1)).
  by rewrite -[T *m _ *m V_1]mulmxA acts mulmxA TV -lower mulmxDl -TV !mulmxA.
- apply/esym/(char_poly_similar _ (esym acts)).
  by rewrite -unitfE -unitmxE.
have injective : \rank V_2 = n.
  apply: (@upper_part_is_injective _ _ _ _ A_c B_c C_c A B C V_2 V_1 X); rewrite 1?addrC //.
  by rewrite -addsmxE addsmxC addsmxE.
by rewrite -(mxrankMfree T (_ : row_free V_1)) ?TV // row_free_unit.
Qed.
End OtherOrders.
