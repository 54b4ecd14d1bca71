(* Pole placement by state feedback and by output injection, for every n >= 1 and every field:
   (7.25)-(7.30) with Ackermann's formula. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import finalg.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* The matrix of (7.26): ones above the diagonal, the coefficients of p in the last row. *)
Definition companion (R : fieldType) n (p : {poly R}) : 'M[R]_n := \matrix_(i, j)
  if (i == n.-1 :> nat) then - p`_j else (i.+1 == j :> nat)%:R.

Lemma char_poly_companion (R : fieldType) n (p : {poly R}) :
  p \is monic -> (size p).-1 = n -> char_poly (companion n p) = p.
Proof. by move=> monic_p <-; apply: companionmxK. Qed.

Section Placement.
Variables (R : fieldType) (order : nat).
Local Notation n := order.+1.
Implicit Types (A : 'M[R]_n) (B F : 'cV[R]_n) (C K : 'rV[R]_n) (p : {poly R}).

Local Notation companion := (companion n).

(* The rows of a companion matrix shift, but for the last. *)
Lemma row_companion_next p m (T : 'M[R]_(n, m)) (i next : 'I_n) :
  next = i.+1 :> nat -> row i (companion p *m T) = row next T.
Proof.
move=> shift; rewrite row_mul mulmx_sum_row (bigD1 next) //= big1 ?addr0 => [|j ne].
  by rewrite !mxE -shift eqxx (ltn_eqF (_ : i < order)%N) ?scale1r // -ltnS -shift.
rewrite !mxE (ltn_eqF (_ : i < order)%N); last by rewrite -ltnS -shift.
by rewrite -shift eq_sym (inj_eq val_inj) (negPf ne) scale0r.
Qed.

Lemma row_companion_last p m (T : 'M[R]_(n, m)) :
  row ord_max (companion p *m T) = - \sum_(j < n) p`_j *: row j T.
Proof.
rewrite row_mul mulmx_sum_row -sumrN.
by apply: eq_bigr => j _; rewrite !mxE eqxx scaleNr.
Qed.

(* -[0 ... 0 1] [B AB ... A^(n-1) B]^-1 p(A). *)
Definition ackermann A B p : 'rV[R]_n :=
  - (delta_mx 0 ord_max *m invmx (controllability_matrix A B) *m horner_mx A p).

Theorem ackermann_places A B p : controllable A B -> p \is monic -> degree_is p n ->
  char_poly (A + B *m ackermann A B p) = p.
Proof.
rewrite /controllable -/(row_free _) row_free_unit => invertible monic_p deg_p.
pose w : 'rV[R]_n := delta_mx 0 ord_max *m invmx (controllability_matrix A B).
pose K := ackermann A B p; rewrite -/K.
(* w A^j B is 0 for j < n - 1 and 1 for j = n - 1 *)
have first_column (j : nat) : (j <= order)%N -> w *m A ^+ j *m B = (j == order)%:R%:M.
  rewrite -ltnS => j_n; rewrite -mulmxA.
  have -> : A ^+ j *m B = col (Ordinal j_n) (controllability_matrix A B).
    by apply/colP=> i; rewrite !mxE.
  rewrite colE mulmxA /w mulmxKV // mul_delta_mx_cond; apply/rowP=> i.
  rewrite [i]ord1 mulmxnE !mxE !eqxx -val_eqE /= [order == j]eq_sym.
  by case: (j == order).
have gain : K = - (w *m A ^+ n + \sum_(j < n) p`_j *: (w *m A ^+ j)).
  rewrite /K /ackermann -/w; congr (- _).
  rewrite (@horner_mx_monic _ _ _ n) // mulmxDr mulmx_sumr; congr (_ + _).
  by apply: eq_bigr => j _; rewrite -scalemxAr.
pose T : 'M[R]_n := \matrix_i (w *m A ^+ i).
have row_T (i : 'I_n) : row i T = w *m A ^+ i by rewrite rowK.
have similar : T *m (A + B *m K) = companion p *m T.
  apply/row_matrixP=> i; rewrite !row_mul row_T.
  have i_n : (i <= order)%N by rewrite -ltnS.
  have shift : w *m A ^+ i *m A = w *m A ^+ i.+1 by rewrite exprSr -mulmxE mulmxA.
  rewrite mulmxDr shift mulmxA first_column // mul_scalar_mx -row_mul.
  have [last|not_last] := eqVneq i ord_max.
    rewrite last row_companion_last eqxx scale1r gain opprD addrA subrr add0r.
    by congr (- _); apply: eq_bigr => j _; rewrite row_T.
  have next : (i.+1 < n)%N by rewrite ltnS ltn_neqAle -ltnS ltn_ord andbT.
  rewrite (@row_companion_next _ _ _ i (Ordinal next)) // row_T.
  by rewrite (ltn_eqF (_ : i < order)%N) // scale0r addr0.
rewrite (char_poly_similar _ similar) ?char_poly_companion ?deg_p //.
(* T times the controllability matrix, columns reversed, is triangular with ones *)
pose reversed : 'M[R]_n := \matrix_(i, j) (A ^+ (order - j) *m B) i 0.
have entry (i j : 'I_n) : (T *m reversed) i j = (w *m A ^+ (i + (order - j)) *m B) 0 0.
  rewrite exprD -mulmxE mulmxA -row_T -mulmxA mxE [RHS]mxE.
  by apply: eq_bigr => k _; rewrite [row _ _ _ _]mxE [reversed _ _]mxE.
have triangular : is_trig_mx (T *m reversed).
  apply/is_trig_mxP=> i j ij; rewrite entry first_column; last by have := ltn_ord j; lia.
  have /negPf-> : (i + (order - j))%N != order by have := ltn_ord j; lia.
  by rewrite mxE mul0rn.
have : \det (T *m reversed) = 1.
  rewrite det_trig // big1 // => i _; have i_n : (i <= order)%N by rewrite -ltnS.
  by rewrite entry subnKC // first_column // eqxx mxE eqxx mulr1n.
rewrite det_mulmx => product; apply: contra_eq_neq product => ->.
by rewrite mul0r eq_sym oner_eq0.
Qed.

(* A regulator gain exists for every spectrum. *)
Theorem regulator_gain A B p : controllable A B -> p \is monic -> degree_is p n ->
  exists K, char_poly (A + B *m K) = p.
Proof. by move=> c monic_p deg_p; exists (ackermann A B p); apply: ackermann_places. Qed.

(* So does an observer gain. *)
Theorem observer_gain A C p : observable A C -> p \is monic -> degree_is p n ->
  exists F, char_poly (A - F *m C) = p.
Proof.
rewrite duality => dual monic_p deg_p.
have [K placed] := regulator_gain dual monic_p deg_p.
exists (- K^T); rewrite mulNmx opprK -placed -char_poly_tr.
by rewrite linearD /= trmx_mul trmxK.
Qed.
End Placement.
