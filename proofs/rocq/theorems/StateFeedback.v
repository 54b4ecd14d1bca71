(* State feedback with several inputs, over any field: Heymann's lemma, by the argument of Hautus, and
   with it placement of every polynomial, possible for controllable pairs and for no others; and the
   dual, output injection with several outputs. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman PolePlacement Coprimeness.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section StateFeedback.
Variables (R : fieldType) (order inputs : nat).
Local Notation n := order.+1.
Local Notation m := inputs.
Implicit Types (A : 'M[R]_n) (B : 'M[R]_(n, m)) (K : 'M[R]_(m, n)) (p : {poly R}).

(* The rank condition of Kalman for [B  AB  ...  A^(n-1) B], with any number of inputs. *)
Definition controllable_pair A B := \rank (\mxrow_(k < n) (A ^+ k *m B)) == n.

(* By Cayley and Hamilton the first n powers of A say it all. *)
Lemma all_powers_of_pair l (eta : 'M[R]_(l, n)) A B :
  eta *m (\mxrow_(k < n) (A ^+ k *m B)) = 0 -> forall k, eta *m A ^+ k *m B = 0.
Proof.
rewrite mul_mxrow -[RHS](mxrow0 _) => /eq_mxrowP low k.
apply: (can_inj (@trmxK _ _ _)); apply/row_matrixP=> j; rewrite -!tr_col; congr (_^T).
rewrite [col j 0]colE mul0mx colE -mulmxA -colE.
have zero : eta *m controllability_matrix A (col j B) = 0.
  apply/matrixP=> i k'; rewrite times_controllability_matrix colE mulmxA -[eta *m _ *m B]mulmxA low.
  by rewrite mul0mx !mxE.
by have := all_powers zero 'X^k; rewrite rmorphX /= horner_mx_X.
Qed.

(* No row but 0 is orthogonal to every A^k B. *)
Theorem controllable_pairP A B :
  controllable_pair A B <->
  forall l (eta : 'M[R]_(l, n)), (forall k, eta *m A ^+ k *m B = 0) -> eta = 0.
Proof.
split=> [full l eta orthogonal|only_zero].
  apply: (row_free_inj full); rewrite mul0mx mul_mxrow -[RHS](mxrow0 _).
  by apply: eq_mxrow => k; rewrite mulmxA orthogonal.
rewrite /controllable_pair -/(row_free _) -kermx_eq0; apply/eqP/only_zero.
exact/all_powers_of_pair/mulmx_ker.
Qed.

(* x_(k+1) = A x_k + B u_k. *)
Fixpoint states A B (b : 'cV[R]_n) (u : nat -> 'cV[R]_m) k : 'cV[R]_n :=
  if k is j.+1 then A *m states A B b u j + B *m u j else b.

Lemma states_local A B b u u' k : (forall j, (j < k)%N -> u j = u' j) ->
  states A B b u k = states A B b u' k.
Proof.
elim: k => //= k IH same; rewrite IH ?same // => j j_k.
by rewrite same // ltnW // ltnS ltnW.
Qed.

Definition states_up_to A B b u k : 'M[R]_(k, n) := \matrix_(i < k) (states A B b u i)^T.

Lemma row_states A B b u k (i : 'I_k) :
  row i (states_up_to A B b u k) = (states A B b u i)^T.
Proof. exact: rowK. Qed.

Lemma states_up_to_S A B b u k :
  (states_up_to A B b u k.+1 :=: states_up_to A B b u k + (states A B b u k)^T)%MS.
Proof.
apply/eqmxP/andP; split.
  apply/row_subP=> i; rewrite row_states; have [below|above] := ltnP i k.
    by rewrite (submx_trans _ (addsmxSl _ _)) // -(row_states A B b u (Ordinal below)) row_sub.
  have -> : i = k :> nat by apply/eqP; rewrite eqn_leq above andbT -ltnS.
  exact: addsmxSr.
rewrite addsmx_sub -(row_states A B b u (@ord_max k)) row_sub andbT.
apply/row_subP=> i; rewrite row_states.
by rewrite -(row_states A B b u (widen_ord (leqnSn k) i)) row_sub.
Qed.

(* As long as there is room, some input leads out of the span of the states so far: a span that every
   input keeps is invariant and holds the columns of B. *)
Lemma next_state_is_new A B b u k : controllable_pair A B -> (k.+1 < n)%N ->
  exists w, ~~ ((A *m states A B b u k + B *m w)^T <= states_up_to A B b u k.+1)%MS.
Proof.
move=> /controllable_pairP only_zero k_n; set S := states_up_to _ _ _ _ _.
have [moved|] := boolP ((A *m states A B b u k)^T <= S)%MS; last first.
  by move=> outside; exists 0; rewrite mulmx0 addr0.
have [inputs_in|] := boolP (B^T <= S)%MS; last first.
  case/row_subPn=> j outside; exists (delta_mx j 0); apply: contra outside => sum_in.
  have -> : row j B^T = (A *m states A B b u k + B *m delta_mx j 0)^T - (A *m states A B b u k)^T.
    by rewrite [(_ + _)^T]linearD /= addrC addKr -colE tr_col.
  by rewrite addmx_sub ?eqmx_opp.
have invariant : (S *m A^T <= S)%MS.
  apply/row_subP=> i; rewrite row_mul row_states -trmx_mul.
  have [last|not_last] := eqVneq i ord_max; first by rewrite last.
  have next : (i.+1 < k.+1)%N by rewrite ltnS ltn_neqAle -ltnS ltn_ord andbT.
  have -> : (A *m states A B b u i)^T = row (Ordinal next) S - (B *m u i)^T.
    by rewrite row_states /= [(_ + _)^T]linearD /= addrK.
  by rewrite addmx_sub ?row_sub ?eqmx_opp // trmx_mul (submx_trans (submxMl _ _)).
have powers j : (B^T *m A^T ^+ j <= S)%MS.
  elim: j => [|j IH]; first by rewrite expr0 mulmx1.
  by rewrite exprSr -mulmxE mulmxA (submx_trans (submxMr _ IH)).
have [N EN] : exists N, N = cokermx S by exists (cokermx S).
have : N^T = 0.
  apply: only_zero => j; apply: (can_inj (@trmxK _ _ _)); rewrite !trmx_mul trmxK trmx0.
  by rewrite transpose_power mulmxA EN; apply/eqP; rewrite -submxE powers.
move/(congr1 trmx)/eqP; rewrite trmxK trmx0 EN cokermx_eq0 /row_full => /eqP rank_S.
by have := rank_leq_row S; rewrite rank_S leqNgt k_n.
Qed.

(* So the first n states can be made independent. *)
Lemma independent_states A B b k : controllable_pair A B -> b != 0 -> (k < n)%N ->
  exists u, row_free (states_up_to A B b u k.+1).
Proof.
move=> pair nz_b; elim: k => [_|k IH k_n].
  exists (fun=> 0); rewrite /row_free eqn_leq rank_leq_row lt0n mxrank_eq0.
  apply: contra nz_b => /eqP/row_matrixP/(_ 0); rewrite row_states row0 /= => /(congr1 trmx).
  by rewrite trmxK trmx0 => ->.
have [u free] := IH (ltnW k_n); have [w new] := next_state_is_new b u pair k_n.
pose u' j := if j == k then w else u j; exists u'.
have same j : (j <= k)%N -> states A B b u' j = states A B b u j.
  move=> j_k; apply: states_local => i i_j.
  by rewrite /u' ltn_eqF // (leq_trans i_j).
have old : states_up_to A B b u' k.+1 = states_up_to A B b u k.+1.
  by apply/row_matrixP=> i; rewrite !row_states same // -ltnS.
have last : states A B b u' k.+1 = A *m states A B b u k + B *m w.
  by rewrite /= same // /u' eqxx.
have outside : ~~ ((states A B b u' k.+1)^T <= states_up_to A B b u' k.+1)%MS by rewrite last old.
rewrite /row_free eqn_leq rank_leq_row states_up_to_S.
have : (states_up_to A B b u' k.+1 < states_up_to A B b u' k.+1 + (states A B b u' k.+1)^T)%MS.
  by rewrite ltmxE addsmxSl /=; apply: contra outside; apply: submx_trans (addsmxSr _ _).
by rewrite ltmxErank => /andP[_]; move: free; rewrite -old /row_free => /eqP->.
Qed.

(* Heymann: feedback makes a controllable pair controllable through any one column B v but 0. *)
Theorem heymann A B (v : 'cV[R]_m) : controllable_pair A B -> B *m v != 0 ->
  exists K, controllable (A + B *m K) (B *m v).
Proof.
move=> pair nz_b; set b := B *m v in nz_b *.
have [u free] := independent_states pair nz_b (ltnSn order).
pose X := (states_up_to A B b u n)^T; pose U : 'M[R]_(m, n) := \matrix_(i, j) u j i 0.
have unit_X : X \in unitmx by rewrite unitmx_tr -row_free_unit.
exists (U *m invmx X); set K := U *m invmx X.
have X_col (j : 'I_n) : col j X = states A B b u j by rewrite -tr_row row_states trmxK.
have gain (j : 'I_n) : K *m states A B b u j = u j.
  rewrite -X_col colE mulmxA /K mulmxKV // -colE.
  by apply/colP=> i; rewrite !mxE.
have orbit k : (k < n)%N -> (A + B *m K) ^+ k *m b = states A B b u k.
  elim: k => [|k IH] k_n; first by rewrite expr0 mul1mx.
  rewrite exprS -mulmxE -mulmxA IH ?(ltnW k_n) // mulmxDl -mulmxA.
  by rewrite -{2}[k]/(val (Ordinal (ltnW k_n))) gain.
suff same : controllability_matrix (A + B *m K) b = X.
  by rewrite /controllable same -/(row_free X) row_free_unit.
apply: (can_inj (@trmxK _ _ _)); apply/row_matrixP=> j; rewrite -!tr_col X_col.
by rewrite col_controllability_matrix orbit.
Qed.

(* Every monic polynomial of degree n is reached ... *)
Theorem state_feedback_places A B p : controllable_pair A B -> p \is monic -> degree_is p n ->
  exists K, char_poly (A + B *m K) = p.
Proof.
move=> pair monic_p deg_p.
have [v nz_b] : exists v : 'cV[R]_m, B *m v != 0.
  have [/existsP[j nz]|/existsPn zero] := boolP [exists j, col j B != 0].
    by exists (delta_mx j 0); rewrite -colE.
  have B0 : B = 0.
    apply: (can_inj (@trmxK _ _ _)); apply/row_matrixP=> j; rewrite -!tr_col.
    by move: (zero j); rewrite negbK => /eqP->; rewrite colE mul0mx.
  have /controllable_pairP/(_ n 1%:M) only_zero := pair.
  have /eqP := only_zero (fun k => etrans (congr1 _ B0) (mulmx0 _ _)).
  by rewrite (negPf (matrix_nonzero1 _ _)).
have [K c] := heymann pair nz_b; have [k placed] := regulator_gain c monic_p deg_p.
by exists (K + v *m k); rewrite mulmxDr addrA mulmxA.
Qed.

(* ... and by no other pair: a row that no input moves keeps its polynomial. *)
Theorem placement_needs_controllability A B :
  (forall p, p \is monic -> degree_is p n -> exists K, char_poly (A + B *m K) = p) ->
  controllable_pair A B.
Proof.
move=> places; rewrite /controllable_pair -/(row_free _) -kermx_eq0; apply: contraT.
set E := kermx _ => nz_E; have := all_powers_of_pair (mulmx_ker _ : E *m _ = 0) => unmoved.
have inv_E : (E *m A <= E)%MS.
  apply/sub_kermxP; rewrite mul_mxrow -[RHS](mxrow0 _); apply: eq_mxrow => k.
  by rewrite mulmxA -[E *m A *m _]mulmxA mulmxE -exprS unmoved.
have [d [L [X [free LA LB]]]] : exists d (L : 'M[R]_(d.+1, n)) X,
    [/\ row_free L, L *m A = X *m L & L *m B = 0].
  have : (0 < \rank E)%N by rewrite lt0n mxrank_eq0.
  move: (row_base E) (row_base_free E) (eq_row_base E); case: (\rank E) => // d L free same _.
  have /submxP[D ED] : (L <= E)%MS by rewrite same.
  have /submxP[X EX] : (L *m A <= L)%MS.
    by rewrite same ED -mulmxA (submx_trans (submxMl _ _)).
  exists d, L, X; split=> //.
  by rewrite ED -mulmxA; have := unmoved 0%N; rewrite expr0 mulmx1 => ->; rewrite mulmx0.
have d_n : (d.+1 <= n)%N by rewrite -(eqP free) rank_leq_col.
pose f := char_poly X * 'X^(n - d.+1).
have size_f : size f = n.+1.
  by rewrite size_monicM ?char_poly_monic ?monic_neq0 ?monicXn // size_char_poly size_polyXn addSn
    /= addnS subnKC.
have small : (size (1%R : {poly R}) < size f)%N by rewrite size_f size_poly1.
have [||K placed] := places (f + 1).
- by rewrite monicE lead_coefDl // -monicE monicMl ?monicXn ?char_poly_monic.
- by rewrite size_addl.
pose M := A + B *m K; have LM : L *m M = X *m L by rewrite mulmxDr mulmxA LB mul0mx addr0.
have through q : L *m horner_mx M q = horner_mx X q *m L.
  elim/poly_ind: q => [|q a IH]; first by rewrite !rmorph0 mulmx0 mul0mx.
  rewrite !rmorphD !rmorphM /= !horner_mx_X !horner_mx_C mulmxDr mulmxDl -!mulmxE mulmxA IH.
  by rewrite -!mulmxA LM mul_mx_scalar mul_scalar_mx.
have := through (f + 1); rewrite -placed Cayley_Hamilton mulmx0 placed rmorphD rmorphM rmorph1 /=.
rewrite Cayley_Hamilton mul0r add0r mul1mx => L0.
by move: free; rewrite -L0 /row_free mxrank0.
Qed.

Theorem controllable_iff_placeable A B : controllable_pair A B <->
  forall p, p \is monic -> degree_is p n -> exists K, char_poly (A + B *m K) = p.
Proof.
split=> [pair p|]; first exact: state_feedback_places.
exact: placement_needs_controllability.
Qed.
End StateFeedback.

(* With one input the word means what it meant. *)
Lemma controllable_pair_1 (R : fieldType) order (A : 'M[R]_order.+1) (B : 'cV[R]_order.+1) :
  controllable_pair A B = controllable A B.
Proof. by apply/idP/idP=> [/controllable_pairP|/controllableP] only_zero;
  [apply/controllableP | apply/controllable_pairP]. Qed.

Section OutputInjection.
Variables (R : fieldType) (order outputs : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (C : 'M[R]_(outputs, n)) (p : {poly R}).

(* The rank condition of Kalman for the rows C, CA, ..., C A^(n-1), with any number of outputs. *)
Definition observable_pair A C := \rank (\mxcol_(k < n) (C *m A ^+ k)) == n.

Theorem pair_duality A C : observable_pair A C = controllable_pair A^T C^T.
Proof.
rewrite /observable_pair -mxrank_tr tr_mxcol /controllable_pair; congr (\rank _ == _).
by apply: eq_mxrow => k; rewrite trmx_mul transpose_power.
Qed.

Theorem output_injection_places A C p : observable_pair A C -> p \is monic -> degree_is p n ->
  exists F, char_poly (A - F *m C) = p.
Proof.
rewrite pair_duality => dual monic_p deg_p.
have [K placed] := state_feedback_places dual monic_p deg_p.
exists (- K^T); rewrite mulNmx opprK -placed -char_poly_tr.
by rewrite linearD /= trmx_mul trmxK.
Qed.
End OutputInjection.
