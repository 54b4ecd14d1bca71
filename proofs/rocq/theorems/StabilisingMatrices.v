(* All compensators of a plant with several signals by one parameter: over a field with any subring as the
   stable functions, from a double Bezout identity; then the identity that an observer and a state feedback
   give, over the stable proper functions of any region. Feedback is negative, as in (7.23): the loop of a plant
   P and a compensator G is 1 + G P. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import YoulaKucera StableProperFunctions.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section StableMatrices.
Variables (F : fieldType) (S : F -> Prop).
Hypothesis stable : subring S.

Definition stable_matrix m n (M : 'M[F]_(m, n)) := forall i j, S (M i j).

Lemma stable_matrix_sub m n (M N : 'M[F]_(m, n)) :
  stable_matrix M -> stable_matrix N -> stable_matrix (M - N).
Proof. by have [_ S_sub _] := stable => S_M S_N i j; rewrite !mxE; apply: S_sub. Qed.

Lemma stable_matrix_add m n (M N : 'M[F]_(m, n)) :
  stable_matrix M -> stable_matrix N -> stable_matrix (M + N).
Proof. by have [_ _ S_add _] := subring_closed stable => S_M S_N i j; rewrite !mxE; apply: S_add. Qed.

Lemma stable_matrix_mul m n p (M : 'M[F]_(m, n)) (N : 'M[F]_(n, p)) :
  stable_matrix M -> stable_matrix N -> stable_matrix (M *m N).
Proof.
have [S_1 S_sub S_add S_mul] := subring_closed stable; move=> S_M S_N i j; rewrite mxE.
by elim/big_ind: _ => //; [rewrite -(subrr 1); apply: S_sub | move=> k _; apply: S_mul].
Qed.

Lemma stable_matrix_one n : stable_matrix (1%:M : 'M[F]_n).
Proof.
have [S_1 S_sub _] := stable; move=> i j; rewrite mxE; case: eqP => // _.
by rewrite mulr0n -(subrr 1); apply: S_sub.
Qed.

(* The loop is well posed, and its four transfer matrices are stable; (1 + P G)^-1 is 1 - P (1 + G P)^-1 G. *)
Definition stabilises_matrix m p (P : 'M[F]_(p, m)) (G : 'M[F]_(m, p)) := let T := invmx (1%:M + G *m P) in
  1%:M + G *m P \in unitmx /\
  [/\ stable_matrix T, stable_matrix (T *m G), stable_matrix (P *m T) & stable_matrix (P *m T *m G)].

Variables (m p : nat).
Variables (D : 'M[F]_m) (N : 'M[F]_(p, m)) (X : 'M[F]_(m, p)) (Y : 'M[F]_m).
Variables (D_l : 'M[F]_p) (N_l : 'M[F]_(p, m)) (X_l : 'M[F]_(m, p)) (Y_l : 'M[F]_p).

(* The plant is N D^-1. *)
Definition double_bezout := block_mx Y X (- N_l) D_l *m block_mx D (- X_l) N Y_l = 1%:M.
Hypotheses (bezout : double_bezout) (exists_P : D \in unitmx).
Hypotheses (S_D : stable_matrix D) (S_N : stable_matrix N) (S_X : stable_matrix X) (S_Y : stable_matrix Y).
Hypotheses (S_Dl : stable_matrix D_l) (S_Nl : stable_matrix N_l) (S_Xl : stable_matrix X_l).
Hypothesis S_Yl : stable_matrix Y_l.

Theorem stabilising_matrices_by_one_parameter (G : 'M[F]_(m, p)) : stabilises_matrix (N *m invmx D) G <->
  exists Q, [/\ stable_matrix Q, Y - Q *m N_l \in unitmx & G = invmx (Y - Q *m N_l) *m (X + Q *m D_l)].
Proof.
set P := N *m invmx D; have P_D : P *m D = N by rewrite mulmxKV.
clearbody P.
have [left_bezout lower] : Y *m D + X *m N = 1%:M /\ D_l *m N = N_l *m D.
  move: bezout; rewrite /double_bezout mulmx_block scalar_mx_block => /eq_block_mx[-> _ zero _]; split=> //.
  by apply/eqP; rewrite eq_sym -subr_eq0 -oppr_eq0 opprB addrC -mulNmx zero.
split=> [[posed [S_T S_TG S_PT S_PTG]]|[Q [S_Q unit_V ->]]]; last first.
  set V := Y - _ in unit_V *; set U := X + _.
  have S_V : stable_matrix V by apply: stable_matrix_sub => //; apply: stable_matrix_mul.
  have S_U : stable_matrix U by apply: stable_matrix_add => //; apply: stable_matrix_mul.
  have loop : V *m D + U *m N = 1%:M.
    by rewrite mulmxBl mulmxDl addrACA left_bezout -!mulmxA lower addNr addr0.
  clearbody U V; have E : (1%:M + invmx V *m U *m P) *m (D *m V) = 1%:M.
    have -> : 1%:M + invmx V *m U *m P = invmx V *m (V + U *m P) by rewrite mulmxDr mulVmx // mulmxA.
    by rewrite -!mulmxA [_ *m (D *m V)]mulmxA mulmxDl -mulmxA P_D loop mul1mx mulVmx.
  have [unit_L unit_DV] := mulmx1_unit E.
  have ET : invmx (1%:M + invmx V *m U *m P) = D *m V by rewrite -[RHS](mulKmx unit_L) E mulmx1.
  have TG : D *m V *m (invmx V *m U) = D *m U by rewrite mulmxA mulmxK.
  have PT : P *m (D *m V) = N *m V by rewrite mulmxA P_D.
  have PTG : P *m (D *m V) *m (invmx V *m U) = N *m U by rewrite PT mulmxA mulmxK.
  by split=> //; rewrite ET TG PTG PT; split; apply: stable_matrix_mul.
set T := invmx _ in S_T S_TG S_PT S_PTG.
pose V := invmx D *m T; pose U := V *m G.
have E_inv : invmx D = Y + X *m P by rewrite -[LHS]mul1mx -left_bezout -P_D mulmxA -mulmxDl mulmxK.
have S_V : stable_matrix V.
  rewrite /V E_inv mulmxDl -mulmxA; apply: stable_matrix_add; exact: stable_matrix_mul.
have S_U : stable_matrix U.
  rewrite /U /V E_inv !mulmxDl -!mulmxA; apply: stable_matrix_add; apply: stable_matrix_mul => //.
  by rewrite mulmxA.
have loop : V *m D + U *m N = 1%:M.
  rewrite -P_D mulmxA -mulmxDl /U -mulmxA -{1}[V]mulmx1 -mulmxDr.
  by rewrite /V -[_ *m T *m _]mulmxA mulVmx // mulmx1 mulVmx.
have unit_V : V \in unitmx by rewrite unitmx_mul !unitmx_inv exists_P.
pose Q := U *m Y_l - V *m X_l.
have [EV EU] : V = Y - Q *m N_l /\ U = X + Q *m D_l.
  apply: eq_row_mx; rewrite -[LHS]mulmx1 -(mulmx1C bezout) mulmxA [row_mx V U *m _]mul_row_block.
  by rewrite loop mulmxN [- _ + _]addrC mul_row_block !mul1mx mulmxN.
exists Q; rewrite -EV -EU; split=> //; last by rewrite mulKmx.
by apply: stable_matrix_sub; apply: stable_matrix_mul.
Qed.
End StableMatrices.

Lemma cancelled (V : zmodType) (i a b x e : V) : x + e = a - b -> i + a - (b + x) - e = i.
Proof.
move=> E; have -> : e = a - b - x by rewrite -E addrC addKr.
by apply/eqP; rewrite subr_eq opprD !addrA.
Qed.

Lemma cancelled_0 (V : zmodType) (a b x e : V) : x + e = a - b -> a - (b + x) - e = 0.
Proof. by move=> E; rewrite -[a]add0r cancelled. Qed.

(* An observer and a state feedback: Z is zI - A, and Phi its inverses in the plant and both loops. *)
Section StateSpace.
Variables (F : fieldType) (n m p : nat).
Variables (Z Phi Phi_R Phi_O : 'M[F]_n).
Variables (B : 'M[F]_(n, m)) (C : 'M[F]_(p, n)) (K : 'M[F]_(m, n)) (L : 'M[F]_(n, p)).
Hypotheses (plant : Z *m Phi = 1%:M) (regulator : (Z - B *m K) *m Phi_R = 1%:M).
Hypothesis observer : (Z + L *m C) *m Phi_O = 1%:M.

Definition right_D := 1%:M + K *m Phi_R *m B.
Definition right_N := C *m Phi_R *m B.
Definition right_X := - (K *m Phi_R *m L).
Definition right_Y := 1%:M + C *m Phi_R *m L.
Definition left_Y := 1%:M - K *m Phi_O *m B.
Definition left_X := - (K *m Phi_O *m L).
Definition left_D := 1%:M - C *m Phi_O *m L.
Definition left_N := C *m Phi_O *m B.

Lemma difference_of_resolvents a b (G : 'M[F]_(a, n)) (H : 'M[F]_(n, b)) :
  G *m Phi_O *m B *m (K *m Phi_R *m H) + G *m Phi_O *m L *m (C *m Phi_R *m H)
  = G *m Phi_R *m H - G *m Phi_O *m H.
Proof.
have E : Phi_O *m (B *m K + L *m C) *m Phi_R = Phi_R - Phi_O.
  have -> : B *m K + L *m C = (Z + L *m C) - (Z - B *m K) by rewrite opprB [RHS]addrC addrA subrK.
  by rewrite mulmxBr mulmxBl (mulmx1C observer) mul1mx -mulmxA regulator mulmx1.
by rewrite -mulmxBl -mulmxBr -E mulmxDr !mulmxDl mulmxDr mulmxDl !mulmxA.
Qed.

Lemma state_space_bezout : double_bezout right_D right_N left_X left_Y left_D left_N right_X right_Y.
Proof.
rewrite /double_bezout mulmx_block scalar_mx_block.
have diff a b (G : 'M[F]_(a, n)) (H : 'M[F]_(n, b)) := difference_of_resolvents G H.
congr block_mx; rewrite /right_D /right_N /right_X /right_Y /left_D /left_N /left_X /left_Y.
- by rewrite mulmxBl mul1mx mulmxDr mulmx1 mulNmx; apply: cancelled.
- rewrite opprK mulmxBl mul1mx mulNmx mulmxDr mulmx1 addrAC; apply: cancelled_0.
  by rewrite addrC.
- rewrite mulNmx mulmxDr mulmx1 mulmxBl mul1mx addrC addrAC; exact: cancelled_0.
rewrite opprK mulNmx mulmxBl mul1mx mulmxDr mulmx1 addrC; apply: cancelled.
by rewrite addrC.
Qed.

(* The plant C Phi B is N D^-1, and D has an inverse. *)
Lemma plant_difference a (G : 'M[F]_(a, n)) :
  G *m Phi *m B *m (K *m Phi_R *m B) = G *m Phi_R *m B - G *m Phi *m B.
Proof.
have E : Phi *m (B *m K) *m Phi_R = Phi_R - Phi.
  have -> : B *m K = Z - (Z - B *m K) by rewrite opprB addrC subrK.
  by rewrite mulmxBr mulmxBl (mulmx1C plant) mul1mx -mulmxA regulator mulmx1.
by rewrite -mulmxBl -mulmxBr -E !mulmxA.
Qed.

Lemma state_space_D : right_D \in unitmx.
Proof.
suff inverse : (1%:M - K *m Phi *m B) *m right_D = 1%:M by have [] := mulmx1_unit inverse.
rewrite /right_D mulmxBl mul1mx mulmxDr mulmx1 plant_difference.
by rewrite [K *m Phi *m B + _]addrC subrK addrK.
Qed.

Lemma state_space_plant : C *m Phi *m B = right_N *m invmx right_D.
Proof.
apply: (canRL (mulmxK state_space_D)); rewrite /right_D mulmxDr mulmx1 plant_difference.
by rewrite addrC subrK.
Qed.
End StateSpace.

Lemma entry_of_product (H G : comRingType) (f : {rmorphism H -> G}) n m p (C : 'M[H]_(p, n)) (M : 'M[H]_n)
    (B : 'M[H]_(n, m)) c i j :
  (map_mx f C *m (c *: map_mx f M) *m map_mx f B) i j = c * f ((C *m M *m B) i j).
Proof. by rewrite -scalemxAr -scalemxAl -!map_mxM !mxE. Qed.

Lemma entry_is_numerator (R : comRingType) n m p (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) i j :
  (map_mx polyC C *m \adj (char_poly_mx A) *m map_mx polyC B) i j = numerator A (col j B) (row i C).
Proof.
rewrite /numerator; move: (\adj _) => M; rewrite map_row map_col -row_mul.
by rewrite [RHS]mxE [LHS]mxE; apply: eq_bigr => k _; rewrite !mxE.
Qed.

(* Over the rational functions, with the stable proper ones of a region. *)
Section ObserverBased.
Variables (R : fieldType) (stable : {poly R} -> Prop).
Hypothesis region : stability_region stable.
Local Notation toF := (@FracField.tofrac [idomainType of {poly R}]).
Local Notation Fr := [fieldType of {fraction {poly R}}].

Definition constant m n (M : 'M[R]_(m, n)) : 'M[Fr]_(m, n) := map_mx toF (map_mx polyC M).
Definition resolvent n (M : 'M[R]_n) : 'M[Fr]_n :=
  (toF (char_poly M))^-1 *: map_mx toF (\adj (char_poly_mx M)).
Definition transfer_matrix n m p (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) : 'M[Fr]_(p, m) :=
  constant C *m resolvent A *m constant B.

Lemma constant_mul m n p (M : 'M[R]_(m, n)) (N : 'M[R]_(n, p)) : constant (M *m N) = constant M *m constant N.
Proof. by rewrite /constant !map_mxM. Qed.

Lemma constant_add m n (M N : 'M[R]_(m, n)) : constant (M + N) = constant M + constant N.
Proof. by rewrite /constant !map_mxD. Qed.

Lemma constant_sub m n (M N : 'M[R]_(m, n)) : constant (M - N) = constant M - constant N.
Proof. by rewrite /constant !map_mxB. Qed.

Lemma toF_char_poly n (M : 'M[R]_n) : toF (char_poly M) != 0.
Proof. by rewrite tofrac_eq0 monic_neq0 ?char_poly_monic. Qed.

Lemma resolventP n (M : 'M[R]_n) : ((toF 'X)%:M - constant M) *m resolvent M = 1%:M.
Proof.
have -> : (toF 'X)%:M - constant M = map_mx toF (char_poly_mx M).
  by rewrite /char_poly_mx map_mxB map_scalar_mx.
rewrite -scalemxAr -map_mxM mul_mx_adj map_scalar_mx -mul_scalar_mx -scalar_mxM.
by rewrite mulVf ?toF_char_poly.
Qed.
Lemma stable_transfer_matrix n m p (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) :
  stable (char_poly A) -> stable_matrix (stable_proper stable) (transfer_matrix A B C).
Proof.
move=> stable_A i j; exists (numerator A (col j B) (row i C)), (char_poly A); split=> //.
  by rewrite size_char_poly; apply/leqW/numerator_strictly_proper.
have := entry_of_product [rmorphism of toF] (map_mx polyC C) (\adj (char_poly_mx A)) (map_mx polyC B)
  (toF (char_poly A))^-1 i j.
by rewrite entry_is_numerator mulrC.
Qed.

(* The plant, with several signals, and an observer-based compensator. *)
Variables (n m p : nat).
Variables (A : 'M[R]_n) (B : 'M[R]_(n, m)) (C : 'M[R]_(p, n)) (K : 'M[R]_(m, n)) (F : 'M[R]_(n, p)).
Hypotheses (stable_R : stable (char_poly (A + B *m K))) (stable_O : stable (char_poly (A - F *m C))).

Let N_l := transfer_matrix (A - F *m C) B C.
Let D_l := 1%:M - transfer_matrix (A - F *m C) F C.
Let X := - transfer_matrix (A - F *m C) F K.
Let Y := 1%:M - transfer_matrix (A - F *m C) B K.

Theorem all_stabilising_matrices (G : 'M[Fr]_(m, p)) :
  stabilises_matrix (stable_proper stable) (transfer_matrix A B C) G <->
  exists Q, [/\ stable_matrix (stable_proper stable) Q, Y - Q *m N_l \in unitmx
    & G = invmx (Y - Q *m N_l) *m (X + Q *m D_l)].
Proof.
have subring := stable_proper_subring region.
pose Z : 'M[Fr]_n := (toF 'X)%:M - constant A.
have plant : Z *m resolvent A = 1%:M by exact: resolventP.
have regulator : (Z - constant B *m constant K) *m resolvent (A + B *m K) = 1%:M.
  rewrite -constant_mul -[RHS](resolventP (A + B *m K)); congr (_ *m _).
  by rewrite constant_add opprD addrA.
have observer : (Z + constant F *m constant C) *m resolvent (A - F *m C) = 1%:M.
  rewrite -constant_mul -[RHS](resolventP (A - F *m C)); congr (_ *m _).
  by rewrite constant_sub opprB [RHS]addrCA [RHS]addrC.
have bezout := state_space_bezout regulator observer.
have exists_P := state_space_D plant regulator.
rewrite /transfer_matrix (state_space_plant (constant C) plant regulator).
have S_one k : stable_matrix (stable_proper stable) (1%:M : 'M_k) by apply: stable_matrix_one.
have S_R a b (H : 'M[R]_(n, a)) (H' : 'M[R]_(b, n)) := stable_transfer_matrix H H' stable_R.
have S_O a b (H : 'M[R]_(n, a)) (H' : 'M[R]_(b, n)) := stable_transfer_matrix H H' stable_O.
have sub := stable_matrix_sub subring; have add := stable_matrix_add subring.
have opp a b (M : 'M[Fr]_(a, b)) :
    stable_matrix (stable_proper stable) M -> stable_matrix (stable_proper stable) (- M).
  move=> S_M; rewrite -[- M]add0r -{1}(subrr M); exact: sub (sub _ _ _ _ S_M S_M) S_M.
apply: (stabilising_matrices_by_one_parameter subring bezout exists_P).
- by apply: add; [apply: S_one | apply: (S_R _ _ B K)].
- exact: (S_R _ _ B C).
- by apply: opp; apply: (S_O _ _ F K).
- by apply: sub; [apply: S_one | apply: (S_O _ _ B K)].
- by apply: sub; [apply: S_one | apply: (S_O _ _ F C)].
- exact: (S_O _ _ B C).
- by apply: opp; apply: (S_R _ _ F K).
by apply: add; [apply: S_one | apply: (S_R _ _ F C)].
Qed.
End ObserverBased.
