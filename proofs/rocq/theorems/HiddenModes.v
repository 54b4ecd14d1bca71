(* Compensators with hidden modes. A choice of regulator's polynomial p_R gives an observer-based
   form if and only if p_R has no unobservable mode of the compensator and the observer's polynomial
   p_O no uncontrollable one. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman Coprimeness InvariantSubspaces Forms.
From Compensators.theorems Require Import NonderogatoryMatrices UnobservableModes.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section FullOrder.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n).
Variables (u c : {poly R}).
Local Notation Atilde := (closed_loop A B C A_c B_c C_c).
Hypotheses (minimal_plant : minimal A B C).
Hypothesis unobservable : is_unobservable_polynomial A_c C_c u.
Hypothesis uncontrollable : is_uncontrollable_polynomial A_c B_c c.

(* Beside an invariant graph x_c = T x the rows [-T I] are invariant, with the matrix Y of the
   observer's error. *)
Section Graph.
Variables (T X : 'M[R]_n).
Hypothesis invariant : Atilde *m col_mx 1%:M T = col_mx 1%:M T *m X.
Let Y := A_c - T *m B *m C_c.

Lemma graph_acts : A + B *m C_c *m T = X.
Proof. by have [] := invariant_blocks invariant; rewrite mulmx1 mul1mx. Qed.

Lemma rows_are_invariant : - (T *m A) + B_c *m C = - (Y *m T).
Proof.
have [_] := invariant_blocks invariant; rewrite mulmx1 => lower.
have -> : B_c *m C = T *m X - A_c *m T by rewrite -lower addrK.
rewrite -graph_acts mulmxDr mulmxBl opprB !mulmxA.
by move: (T *m A) (T *m B *m C_c *m T) (A_c *m T) => a b e; rewrite -addrA addKr.
Qed.

Lemma graph_splits_spectrum : char_poly Atilde = char_poly X * char_poly Y.
Proof.
rewrite -(char_poly_upper _ (B *m C_c)).
apply: (@char_poly_similar _ _ (block_mx 1%:M 0 (- T) 1%:M)).
  by rewrite det_lblock !det1 mulr1 oner_neq0.
rewrite /closed_loop !mulmx_block !mul1mx !mul0mx !mulmx1 !mulmx0 !addr0 !add0r !mulNmx !mulmxN.
congr block_mx; first by rewrite -graph_acts addrK.
  exact: rows_are_invariant.
by rewrite addrC mulmxA.
Qed.

Lemma dual_upper : A^T *m (- T^T) + C^T *m B_c^T *m 1%:M = - T^T *m Y^T.
Proof.
have := congr1 trmx rows_are_invariant; rewrite [LHS]linearD [RHS]linearN /=.
by rewrite [(- (T *m A))^T]linearN /= !trmx_mul mulmxN mulNmx mulmx1.
Qed.

Lemma dual_lower : C_c^T *m B^T *m (- T^T) + A_c^T *m 1%:M = 1%:M *m Y^T.
Proof.
rewrite mulmx1 mul1mx mulmxN /Y [in RHS]linearB /= !trmx_mul mulmxA.
by rewrite addrC.
Qed.
End Graph.

(* If: no hidden mode on the wrong side. *)
Theorem coprime_modes_give_form V_1 V_2 (X : 'M[R]_n) p_O :
  Atilde *m col_mx V_1 V_2 = col_mx V_1 V_2 *m X -> \rank (col_mx V_1 V_2) = n ->
  char_poly Atilde = char_poly X * p_O -> coprimep (char_poly X) u -> coprimep p_O c ->
  exists T K F, observer_form A B C A_c B_c C_c T K F /\ char_poly (A + B *m K) = char_poly X.
Proof.
move=> invariant full factored coprime_R coprime_O; have [ctrb obsv] := minimal_plant.
have [upper lower] := invariant_blocks invariant.
have unit_1 : V_1 \in unitmx := coprime_upper_part upper lower ctrb unobservable coprime_R full.
have [T TV] : exists T, T *m V_1 = V_2 by exists (V_2 *m invmx V_1); rewrite mulmxKV.
(* the same subspace as a graph, on which the loop acts as Y *)
pose Y := V_1 *m X *m invmx V_1.
have graph : Atilde *m col_mx 1%:M T = col_mx 1%:M T *m Y.
  have -> : col_mx 1%:M T = col_mx V_1 V_2 *m invmx V_1.
    by rewrite mul_col_mx mulmxV // -TV mulmxK.
  rewrite mulmxA invariant /Y -!mulmxA; congr (_ *m _).
  by rewrite [invmx V_1 *m (V_1 *m _)]mulmxA mulVmx // mul1mx.
have same : char_poly Y = char_poly X.
  apply: (@char_poly_similar _ _ (invmx V_1)); last by rewrite /Y !mulmxA mulVmx // mul1mx.
  by rewrite -unitfE -unitmxE unitmx_inv.
have observer : p_O = char_poly (A_c - T *m B *m C_c).
  apply: (mulfI (monic_neq0 (char_poly_monic X))).
  by rewrite -factored (graph_splits_spectrum graph) same.
(* duality: the rows [-T I] are invariant from the left *)
have unit_T : T \in unitmx.
  have ctrb_dual : controllable A^T C^T by rewrite -duality.
  suff : - T^T \in unitmx by rewrite -scaleN1r unitmxZ ?unitrN1 // unitmx_tr.
  apply: (@coprime_upper_part _ _ _ A^T C^T B^T A_c^T C_c^T B_c^T (- T^T) 1%:M
    (A_c - T *m B *m C_c)^T c) => //.
  - exact: dual_upper graph.
  - exact: dual_lower.
  - by rewrite char_poly_tr -observer.
  have full_1 : (\rank (1%:M : 'M[R]_n) <= \rank (col_mx (- T^T) 1%:M))%N.
    by rewrite mxrankS // -addsmxE addsmxSr.
  by rewrite mxrank1 in full_1; apply/eqP; rewrite eqn_leq rank_leq_col.
have unit_2 : V_2 \in unitmx by rewrite -TV unitmx_mul unit_T.
have [T' [K [F [formed _ regulator]]]] := invertible_parts_give_form invariant unit_1 unit_2.
exists T', K, F; split; first exact: formed.
apply/esym/(char_poly_similar _ (esym regulator)).
by rewrite -unitfE -unitmxE.
Qed.
End FullOrder.

(* Only if. *)
Section Necessity.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n) (u : {poly R}).
Let Atilde : 'M[R]_((order + n).+1) := closed_loop A B C A_c B_c C_c.

(* An unobservable mode of the compensator is one of the loop, and x is not excited in it. In the
   kernel of p_R(A~) it would lie in the graph of T, which holds no [0; xi]. *)
Theorem regulator_has_no_unobservable_mode T K F :
  is_unobservable_polynomial A_c C_c u -> small_kernels Atilde ->
  observer_form A B C A_c B_c C_c T K F -> coprimep (char_poly (A + B *m K)) u.
Proof.
case=> -[|d] [x [Z [rank_x invariant -> unseen]]] small formed.
  by rewrite /char_poly det_mx00 coprimep1.
set p_R := char_poly _; rewrite coprimep_def eqn_leq andbC lt0n size_poly_eq0 gcdp_eq0 negb_and.
rewrite monic_neq0 ?char_poly_monic //= leqNgt; apply/negP=> nonconstant.
have [[_ _] acts] := form_gives_invariant_subspace formed.
have [full _] := (form_gives_invariant_subspace formed).1.
have singular := common_factor_is_singular (dvdp_gcdr p_R (char_poly Z)) nonconstant.
have [y nz_y zero_y] : exists2 y : 'cV[R]_d.+1, y != 0 & horner_mx Z p_R *m y = 0.
  have : (horner_mx Z (gcdp p_R (char_poly Z)))^T \notin unitmx.
    by rewrite unitmx_tr unitmxE unitfE singular eqxx.
  rewrite -row_free_unit -kermx_eq0 => /rowV0Pn[v /sub_kermxP zero nz_v].
  exists v^T; first by rewrite -(inj_eq (can_inj (@trmxK _ _ _))) trmxK trmx0.
  have /dvdpP[q ->] := dvdp_gcdl p_R (char_poly Z).
  by rewrite rmorphM /= -mulmxE -mulmxA -[_ *m v^T]trmxK trmx_mul trmxK zero trmx0 mulmx0.
pose hidden := col_mx (0 : 'M[R]_(n, d.+1)) x; pose V := col_mx (1%:M : 'M[R]_n) T.
have hidden_invariant : closed_loop A B C A_c B_c C_c *m hidden = hidden *m Z.
  have [_ zero] := unseen _ x; have {}zero : C_c *m x = 0.
    by have := zero (ex_intro _ 1%:M (esym (mulmx1 x))) 0%N; rewrite expr0 mulmx1.
  by rewrite mul_block_col mul_col_mx !mulmx0 !add0r mul0mx -mulmxA zero mulmx0 invariant.
have [eta] : exists eta, hidden *m y = V *m eta.
  have polynomial_V : horner_mx Atilde p_R *m V = V *m horner_mx (A + B *m K) p_R.
    exact: horner_mx_columns acts.
  have polynomial_hidden : horner_mx Atilde p_R *m hidden = hidden *m horner_mx Z p_R.
    exact: horner_mx_columns hidden_invariant.
  apply: (kernel_of_polynomial small (p := p_R)) => //.
  - by rewrite size_char_poly.
  - by apply: leqW; apply: leq_addl.
  - by rewrite polynomial_V Cayley_Hamilton mulmx0.
  by rewrite mulmxA polynomial_hidden -mulmxA zero_y mulmx0.
rewrite !mul_col_mx mul0mx mul1mx => /eq_col_mx[<-]; rewrite mulmx0 => xy.
case/negP: nz_y; apply/eqP; apply: (can_inj (@trmxK _ _ _)); rewrite trmx0.
have free : row_free x^T by rewrite /row_free mxrank_tr rank_x.
by apply: (row_free_inj free); rewrite mul0mx -trmx_mul xy trmx0.
Qed.
End Necessity.

Section Rule.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Variables (A_c : 'M[R]_n) (B_c : 'cV[R]_n) (C_c : 'rV[R]_n) (u c : {poly R}).
Let Atilde : 'M[R]_((order + n).+1) := closed_loop A B C A_c B_c C_c.

(* Transposed, regulator and observer change places. *)
Lemma dual_form T K F : observer_form A B C A_c B_c C_c T K F ->
  observer_form A^T C^T B^T A_c^T C_c^T B_c^T (- (invmx T)^T) (- F^T) (- K^T).
Proof.
case=> unit_T <- inputs similar; split.
- by rewrite -scaleN1r unitmxZ ?unitrN1 // unitmx_tr unitmx_inv.
- by rewrite mulmxN -trmx_mul -inputs mulKmx.
- by rewrite mulNmx mulmxN opprK -trmx_mul mulmxK.
rewrite mulmxN mulNmx -trmx_mul; congr (- _).
have -> : observer_matrix A^T C^T B^T (- F^T) (- (C_c *m T)^T)
        = (observer_matrix A B C (C_c *m T) F)^T.
  rewrite /observer_matrix mulmxN mulNmx opprK.
  have -> : (A + B *m (C_c *m T) - F *m C)^T = A^T + (B *m (C_c *m T))^T - (F *m C)^T.
    by rewrite [LHS]linearB [X in X - _]linearD.
  by rewrite (trmx_mul F) (trmx_mul B) addrAC.
by rewrite -trmx_mul; congr (_^T); rewrite -[A_c](mulmxK unit_T) similar -!mulmxA mulKmx.
Qed.

Theorem observer_has_no_uncontrollable_mode T K F :
  is_uncontrollable_polynomial A_c B_c c -> small_kernels Atilde ->
  observer_form A B C A_c B_c C_c T K F -> coprimep (char_poly (A - F *m C)) c.
Proof.
move=> uncontrollable small formed.
have := regulator_has_no_unobservable_mode uncontrollable _ (dual_form formed).
rewrite mulmxN -trmx_mul -linearB /= char_poly_tr; apply.
have -> : closed_loop A^T C^T B^T A_c^T C_c^T B_c^T = (closed_loop A B C A_c B_c C_c)^T.
  by rewrite /closed_loop tr_block_mx !trmx_mul.
exact: small_kernels_transpose.
Qed.

Hypotheses (minimal_plant : minimal A B C) (cyclic : nonderogatory Atilde).
Hypothesis unobservable : is_unobservable_polynomial A_c C_c u.
Hypothesis uncontrollable : is_uncontrollable_polynomial A_c B_c c.

(* The hidden-mode rule. *)
Theorem hidden_mode_rule p_R p_O : p_R \is monic -> degree_is p_R n ->
  char_poly Atilde = p_R * p_O ->
  (exists T K F, observer_form A B C A_c B_c C_c T K F /\ char_poly (A + B *m K) = p_R)
  <-> coprimep p_R u /\ coprimep p_O c.
Proof.
move=> monic_R deg_R factored; have small := nonderogatory_small_kernels cyclic.
split=> [[T [K [F [formed regulator]]]]|[coprime_R coprime_O]].
  rewrite -regulator (regulator_has_no_unobservable_mode unobservable small formed).
  have observer : p_O = char_poly (A - F *m C).
    apply: (mulfI (monic_neq0 monic_R)); rewrite -factored -regulator.
    exact: form_splits_spectrum formed.
  by rewrite observer (observer_has_no_uncontrollable_mode uncontrollable small formed).
have nz_O : p_O != 0.
  apply: contraTneq (monic_neq0 (char_poly_monic Atilde)) => p_O0.
  by rewrite factored p_O0 mulr0 eqxx.
have [V [X [rank_V invariant regulator]]] :=
  invariant_subspace_of_divisor cyclic monic_R deg_R nz_O factored.
have [V_1 [V_2 EV]] : exists (V_1 V_2 : 'M[R]_n), V = col_mx V_1 V_2.
  by exists (usubmx (V : 'M_(n + n, _))), (dsubmx (V : 'M_(n + n, _))); rewrite vsubmxK.
rewrite EV in rank_V invariant; rewrite -regulator in factored coprime_R *.
exact: (coprime_modes_give_form minimal_plant unobservable uncontrollable invariant rank_V
  factored coprime_R coprime_O).
Qed.
End Rule.
