(* A compensator with more states than the plant is an observer with state feedback and a filter of the
   innovations, a Youla parameter. Such forms are the factorisations D~ = p_R p_Q p_O in degrees n,
   n_c - n and n, each with its chain of invariant subspaces; over any field, for any n_c > n. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement ClosedLoop Diophantine Coprimeness.
From Compensators.theorems Require Import MinimalRealisations CanonicalForm.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* Two systems side by side: their transfer functions add up. *)
Lemma numerator_sum (R : idomainType) n r (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n)
    (A' : 'M[R]_r) (B' : 'cV[R]_r) (C' : 'rV[R]_r) :
  numerator (block_mx A 0 0 A') (col_mx B B') (row_mx C C')
  = char_poly A' * numerator A B C + char_poly A * numerator A' B' C'.
Proof.
pose M := char_poly_mx A; pose M' := char_poly_mx A'; pose d := \det M; pose d' := \det M'.
pose W := block_mx (d' *: \adj M) 0 0 (d *: \adj M').
have blocks : char_poly_mx (block_mx A 0 0 A') = block_mx M 0 0 M'.
  rewrite /char_poly_mx map_block_mx !map_mx0 scalar_mx_block opp_block_mx add_block_mx.
  by rewrite !oppr0 !addr0.
have det_M : \det (block_mx M 0 0 M') = d * d' by rewrite det_ublock.
pose b := map_mx polyC (col_mx B B'); pose c := map_mx polyC (row_mx C C').
have := @det_rank_one _ _ (block_mx M 0 0 M') W (- b) c.
rewrite det_M mulf_neq0 ?char_poly_neq0 // => /(_ isT) rank_one.
rewrite numeratorE.
have -> : char_poly (block_mx A 0 0 A' + col_mx B B' *m row_mx C C')
    = \det (block_mx M 0 0 M' + - b *m c).
  by rewrite /char_poly -blocks /char_poly_mx map_mxD map_mxM mulNmx opprD addrA.
rewrite rank_one; last first.
  rewrite /W mulmx_block !mul0mx !mulmx0 !addr0 !add0r -!scalemxAl !mul_adj_mx -/d -/d'.
  by rewrite scalar_mx_block !scale_scalar_mx [d' * d]mulrC.
rewrite [char_poly (block_mx _ _ _ _)]/char_poly blocks det_M mulmxN mxE.
rewrite opprD opprK addrA subrr add0r.
rewrite /c /b /W map_row_mx map_col_mx mul_row_block !mulmx0 addr0 add0r mul_row_col.
by rewrite -!scalemxAr -!scalemxAl [_ 0 0]mxE; congr (_ + _); rewrite mxE.
Qed.

Section YoulaForms.
Variables (R : fieldType) (order extra : nat).
Local Notation n := order.+1.
Local Notation r := extra.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (C : 'rV[R]_n).
Implicit Types (K : 'rV[R]_n) (F : 'cV[R]_n) (A_q : 'M[R]_r) (B_q : 'cV[R]_r) (C_q : 'rV[R]_r).

(* x^' = A x^ + B u + F (y - C x^), x_q' = A_q x_q + B_q (y - C x^), u = K x^ + C_q x_q. *)
Definition youla_matrix K F A_q B_q C_q : 'M[R]_(n + r) :=
  block_mx (observer_matrix A B C K F) (B *m C_q) (- (B_q *m C)) A_q.

(* x_c = T (x^, x_q) turns the compensator into it. *)
Definition youla_form (A_c : 'M[R]_(n + r)) (B_c : 'cV[R]_(n + r)) (C_c : 'rV[R]_(n + r))
    T K F A_q B_q C_q :=
  [/\ T \in unitmx, C_c *m T = row_mx K C_q, T *m col_mx F B_q = B_c
    & A_c *m T = T *m youla_matrix K F A_q B_q C_q].

(* The filter adds D N_q to the numerator, and the loop keeps what places its poles. *)
Lemma youla_numerator K F A_q B_q C_q :
  numerator (youla_matrix K F A_q B_q C_q) (col_mx F B_q) (row_mx K C_q)
  = char_poly A_q * numerator A F K + char_poly A * numerator A_q B_q C_q.
Proof.
rewrite -numerator_sum.
have -> : youla_matrix K F A_q B_q C_q
    = block_mx A 0 0 A_q + col_mx B 0 *m row_mx K C_q + col_mx F B_q *m row_mx (- C) 0.
  rewrite !mul_col_row !add_block_mx !mulmx0 !mul0mx !addr0 !add0r !mulmxN.
  by rewrite /youla_matrix /observer_matrix.
by rewrite numerator_feedback numerator_injection.
Qed.

Lemma youla_spectrum K F A_q B_q C_q :
  char_poly (closed_loop A B C (youla_matrix K F A_q B_q C_q) (col_mx F B_q) (row_mx K C_q))
  = char_poly (A + B *m K) * char_poly A_q * char_poly (A - F *m C).
Proof.
(* in the basis (x, x^ - x, x_q) *)
pose G : 'M[R]_(n + r, n) := col_mx 1%:M 0.
pose Y := block_mx (A - F *m C) 0 (- (B_q *m C)) A_q.
have upper : char_poly Y = char_poly A_q * char_poly (A - F *m C).
  by rewrite -char_poly_tr tr_block_mx trmx0 char_poly_upper !char_poly_tr mulrC.
rewrite -mulrA -upper -(char_poly_upper _ (B *m row_mx K C_q)).
apply: (@char_poly_similar _ _ (block_mx 1%:M 0 (- G) 1%:M)).
  by rewrite det_lblock !det1 mulr1 oner_neq0.
rewrite /closed_loop !mulmx_block !mul1mx !mul0mx !mulmx1 !mulmx0 !addr0 !add0r !mulNmx.
have KG : row_mx K C_q *m G = K by rewrite mul_row_col mulmx1 mulmx0 addr0.
congr block_mx.
- by rewrite mulmxN -mulmxA KG addrK.
- rewrite mulmxN /G mul_block_col !mul_col_mx !mulmx1 !mulmx0 !mul1mx !mul0mx !addr0.
  by rewrite !opp_col_mx add_col_mx oppr0 add0r opprK opprB [- A + _]addrC.
rewrite /G mul_mx_row mul_col_row !mul1mx !mul0mx opp_block_mx !oppr0 add_block_mx !add0r.
by rewrite addNr /observer_matrix [A + B *m K]addrC -addrA addKr.
Qed.

Section Forms.
Variables (A_c : 'M[R]_((order + r).+1)) (B_c : 'cV[R]_((order + r).+1)).
Variables (C_c : 'rV[R]_((order + r).+1)).
Local Notation Atilde := (closed_loop A B C A_c B_c C_c).
Local Notation form := (youla_form A_c B_c C_c).
Implicit Types (T : 'M[R]_(n + r)) (p : {poly R}).

(* Regulator, filter and observer share out the closed-loop spectrum. *)
Theorem youla_form_splits_spectrum T K F A_q B_q C_q : form T K F A_q B_q C_q ->
  char_poly Atilde = char_poly (A + B *m K) * char_poly A_q * char_poly (A - F *m C).
Proof.
case=> unit_T outputs inputs similar; rewrite -(youla_spectrum K F A_q B_q C_q) !closed_loop_7_23.
have nz_T : \det T != 0 by rewrite -unitfE -unitmxE.
rewrite /denominator -(char_poly_similar nz_T (esym similar)).
by rewrite -(numerator_similar nz_T (esym similar) inputs outputs).
Qed.

(* The chain: x^ = x is invariant with x_q = 0 in its quotient, and so is all with x^ = x. *)
Theorem youla_form_gives_chain T K F A_q B_q C_q : form T K F A_q B_q C_q ->
  let graph := col_mx 1%:M (lsubmx T) in let rest := col_mx 0 (rsubmx T) in
  [/\ \rank (row_mx graph rest) = (n + r)%N,
      Atilde *m graph = graph *m (A + B *m K)
    & Atilde *m rest = graph *m (B *m C_q) + rest *m A_q].
Proof.
case=> unit_T outputs inputs similar /=.
set T_1 := lsubmx T; set T_2 := rsubmx T; have ET : T = row_mx T_1 T_2 by rewrite hsubmxK.
move: outputs inputs similar; rewrite ET mul_mx_row => /eq_row_mx[EK ECq].
rewrite mul_row_col => inputs; rewrite mul_mx_row /youla_matrix mul_row_block => /eq_row_mx[A1 A2].
split.
- apply/eqP; rewrite eqn_leq rank_leq_col /=.
  have rank_T : \rank T = (n + r)%N by apply/eqP; rewrite -/(row_free T) row_free_unit.
  rewrite (leq_trans (eq_leq (esym rank_T))) // -block_mxEh /block_mx -ET mxrankS //.
  by rewrite -addsmxE addsmxSr.
- rewrite mul_block_col mul_col_mx !mulmx1 mul1mx -mulmxA EK; congr col_mx.
  rewrite A1 -inputs /observer_matrix mulmxBr mulmxDl !mulmxN !mulmxA.
  by rewrite -[X in _ + X]addrA -opprD addrC subrK.
rewrite mul_block_col !mul_col_mx !mulmx0 !mul0mx !mul1mx !add0r -mulmxA ECq add_col_mx addr0.
by rewrite A2.
Qed.

Hypotheses (minimal_plant : minimal A B C) (minimal_compensator : minimal A_c B_c C_c).

(* Every factorisation into monic factors of degrees n, n_c - n and n has a form. *)
Theorem factorisation_gives_youla_form p_R p_Q p_O :
  p_R \is monic -> degree_is p_R n -> p_Q \is monic -> degree_is p_Q r ->
  p_O \is monic -> degree_is p_O n -> char_poly Atilde = p_R * p_Q * p_O ->
  exists T K F A_q B_q C_q, [/\ form T K F A_q B_q C_q, char_poly (A + B *m K) = p_R,
    char_poly A_q = p_Q & char_poly (A - F *m C) = p_O].
Proof.
move=> monic_R deg_R monic_Q deg_Q monic_O deg_O factored; have [c o] := minimal_plant.
have [K regulator] := regulator_gain c monic_R deg_R.
have [F observer] := observer_gain o monic_O deg_O.
pose D := denominator A; pose N := numerator A B C.
pose D_o := denominator (observer_matrix A B C K F); pose N_o := numerator A F K.
have nz_D : D != 0 by rewrite monic_neq0 ?char_poly_monic.
have observed : D * D_o - N * N_o = p_R * p_O.
  have := separation_7_23 A B F C K; rewrite regulator observer => /= <-.
  rewrite /closed_loop_polynomial mulrN /D_o /N_o /observer_matrix -mulmxN.
  by rewrite (numerator_feedback _ F (- C) K) (numerator_injection A F K B).
pose D_c := denominator A_c; pose N_c := numerator A_c B_c C_c.
have looped : D * D_c - N * N_c = p_R * p_Q * p_O.
  by rewrite -factored closed_loop_7_23 /closed_loop_polynomial mulrN.
have same : D * (D_c - p_Q * D_o) = N * (N_c - p_Q * N_o).
  have : D * D_c - N * N_c = p_Q * (D * D_o - N * N_o) by rewrite looped observed; ring.
  move=> E; transitivity (D * D_c - N * N_c + N * N_c - D * (p_Q * D_o)); first by ring.
  by rewrite E; ring.
have coprime_DN : coprimep D N by apply/minimal_iff_coprime.
have [g Eg] : exists g, N_c - p_Q * N_o = g * D.
  by apply/dvdpP; rewrite -(Gauss_dvdpr _ coprime_DN) -same dvdp_mulr.
have deg_g : degree_below g r.
  have [->|nz_g] := eqVneq g 0; first by rewrite size_poly0.
  have : (size (N_c - p_Q * N_o)%R <= n + r)%N.
    rewrite (leq_trans (size_add _ _)) // geq_max size_opp numerator_strictly_proper.
    rewrite (leq_trans (size_mul_leq _ _)) // deg_Q.
    by have := numerator_strictly_proper A F K; rewrite -/N_o; move: (size N_o); clear; lia.
  rewrite Eg size_Mmonic ?char_poly_monic // size_char_poly.
  by move: nz_g; rewrite -size_poly_gt0; move: (size g); clear; lia.
have [] := canonical_form monic_Q deg_Q deg_g.
move: (companion r p_Q) (canonical_input R extra) (canonical_output extra g) 
  => A_q B_q C_q filter N_q.
pose M := youla_matrix K F A_q B_q C_q.
have same_N : N_c = numerator M (col_mx F B_q) (row_mx K C_q).
  rewrite youla_numerator N_q -/(denominator A_q) filter -/N_o [char_poly A * g]mulrC.
  by rewrite -[char_poly A]/D -Eg addrC subrK.
have same_D : D_c = denominator M.
  apply: (mulfI nz_D); apply: (addIr (- (N * N_c))); rewrite looped same_N.
  have := youla_spectrum K F A_q B_q C_q; rewrite regulator observer closed_loop_7_23.
  by rewrite -/(denominator A_q) filter /closed_loop_polynomial mulrN => <-.
have [T [unit_T similar inputs outputs]] := similar_realisations minimal_compensator same_D same_N.
by exists T, K, F, A_q, B_q, C_q; split.
Qed.

(* And only one, up to the coordinates of the filter. *)
Theorem youla_form_is_unique T K F A_q B_q C_q T' K' F' A_q' B_q' C_q' :
  form T K F A_q B_q C_q -> form T' K' F' A_q' B_q' C_q' ->
  char_poly (A + B *m K) = char_poly (A + B *m K') ->
  char_poly (A - F *m C) = char_poly (A - F' *m C) ->
  [/\ K = K', F = F' & exists U : 'M[R]_r, [/\ U \in unitmx, T' = T *m block_mx 1%:M 0 0 U,
    A_q *m U = U *m A_q', U *m B_q' = B_q & C_q *m U = C_q']].
Proof.
move=> form_1 form_2 same_R same_O; have [c o] := minimal_plant.
have EK := regulator_gain_is_unique c same_R; have EF := observer_gain_is_unique o same_O.
rewrite -{}EK -{}EF in form_2 *; split; [reflexivity | reflexivity |].
have same_Q : char_poly A_q = char_poly A_q'.
  have := youla_form_splits_spectrum form_1; rewrite (youla_form_splits_spectrum form_2).
  move/(mulIf (monic_neq0 (char_poly_monic _)))/(mulfI (monic_neq0 (char_poly_monic _))).
  by move=> ->.
have transfer T0 Aq Bq Cq : form T0 K F Aq Bq Cq ->
    numerator A_c B_c C_c = char_poly Aq * numerator A F K + char_poly A * numerator Aq Bq Cq.
  case=> unit_T outputs inputs similar; rewrite -youla_numerator; apply/esym.
  by apply: (numerator_similar (T := T0)) => //; rewrite -unitfE -unitmxE.
have same_N : numerator A_q B_q C_q = numerator A_q' B_q' C_q'.
  apply: (mulfI (monic_neq0 (char_poly_monic A))).
  have := transfer _ _ _ _ form_1; rewrite (transfer _ _ _ _ form_2) same_Q.
  by move/addrI.
have minimal_q T0 Aq Bq Cq : form T0 K F Aq Bq Cq -> minimal Aq Bq Cq.
  case=> unit_T outputs inputs similar; have [c_c o_c] := minimal_compensator.
  pose M : 'M[R]_((order + r).+1) := youla_matrix K F Aq Bq Cq.
  have power k : A_c ^+ k *m T0 = T0 *m M ^+ k by exact: (power_similar k similar).
  split; last first.
    apply/observableP=> m x unseen.
    have step (y : 'M[R]_(r, m)) : Cq *m y = 0 ->
        youla_matrix K F Aq Bq Cq *m col_mx 0 y = col_mx 0 (Aq *m y).
      by move=> zero; rewrite mul_block_col !mulmx0 !add0r -mulmxA zero mulmx0.
    have moved k : M ^+ k *m col_mx (0 : 'M[R]_(n, m)) x = col_mx (0 : 'M[R]_(n, m)) (Aq ^+ k *m x).
      elim: k => [|k IH]; first by rewrite !expr0 !mul1mx.
      rewrite exprS -mulmxE -mulmxA IH exprS -mulmxE -[Aq *m _ *m x]mulmxA.
      by apply: step; rewrite mulmxA.
    have : T0 *m col_mx (0 : 'M[R]_(n, m)) x = 0.
      have /observableP only_zero := o_c; apply: only_zero => k.
      rewrite mulmxA -[C_c *m _ *m T0]mulmxA power mulmxA outputs -mulmxA moved mul_row_col.
      by rewrite mulmx0 add0r mulmxA unseen.
    move=> zero; have : col_mx (0 : 'M[R]_(n, m)) x = 0.
      by rewrite -(mulKmx unit_T (col_mx _ x)) zero mulmx0.
    by move/(congr1 dsubmx); rewrite col_mxKd linear0.
  apply/controllableP=> m eta unmoved.
  have step (y : 'M[R]_(m, r)) : y *m Bq = 0 ->
      row_mx 0 y *m youla_matrix K F Aq Bq Cq = row_mx 0 (y *m Aq).
    by move=> zero; rewrite mul_row_block !mul0mx !add0r mulmxN mulmxA zero mul0mx oppr0.
  have moved k : row_mx (0 : 'M[R]_(m, n)) eta *m M ^+ k
      = row_mx (0 : 'M[R]_(m, n)) (eta *m Aq ^+ k).
    elim: k => [|k IH]; first by rewrite !expr0 !mulmx1.
    by rewrite exprSr -mulmxE mulmxA IH exprSr -mulmxE mulmxA; apply: step.
  have : row_mx (0 : 'M[R]_(m, n)) eta *m invmx T0 = 0.
    have /controllableP only_zero := c_c; apply: only_zero => k.
    have -> : B_c = T0 *m col_mx F Bq by rewrite inputs.
    rewrite [_ *m (T0 *m _)]mulmxA -[_ *m A_c ^+ k *m T0]mulmxA power mulmxA mulmxKV // moved.
    by rewrite mul_row_col mul0mx add0r unmoved.
  move=> zero; have : row_mx (0 : 'M[R]_(m, n)) eta = 0.
    by rewrite -(mulmxKV unit_T (row_mx _ eta)) zero mul0mx.
  by move/(congr1 rsubmx); rewrite row_mxKr linear0.
have [U [unit_U similar_U inputs_U outputs_U]] :=
  similar_realisations (minimal_q _ _ _ _ form_1) same_Q same_N.
exists U; split=> //; set T_U := T *m _.
have [unit_T outputs inputs similar] := form_1; have [_ outputs' _ similar'] := form_2.
have seen : C_c *m T_U = row_mx K C_q'.
  by rewrite mulmxA outputs mul_row_block !mulmx0 mulmx1 addr0 add0r outputs_U.
have moved : A_c *m T_U = T_U *m youla_matrix K F A_q' B_q' C_q'.
  rewrite mulmxA similar -!mulmxA; congr (_ *m _).
  rewrite /youla_matrix !mulmx_block !mul1mx !mul0mx !mulmx1 !mulmx0 !addr0 !add0r similar_U.
  by rewrite -mulmxA outputs_U mulmxN mulmxA inputs_U.
clearbody T_U.
apply/eqP; rewrite -subr_eq0; apply/eqP.
have [_ /observableP only_zero] := minimal_compensator; apply: only_zero => k;
  rewrite -mulmxA mulmxBr.
rewrite (power_similar _ similar') (power_similar _ moved) mulmxBr !mulmxA.
by rewrite outputs' seen subrr.
Qed.
End Forms.
End YoulaForms.
