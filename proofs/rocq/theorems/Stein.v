(* The Stein equation X = M X N + Q over a real closed field: where the eigenvalues of M and N are
   inside the unit circle it has exactly one solution. With M = N' it is the Lyapunov equation (4.23)
   of discrete time. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import Kalman HighAuthorityPoles.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Stein.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Implicit Types (M N X Q : 'M[R]_n).

Lemma stein_power M N X k : X = M *m X *m N -> X = M ^+ k *m X *m N ^+ k.
Proof.
move=> fixed; elim: k => [|k IH]; first by rewrite !expr0 mul1mx mulmx1.
rewrite exprSr exprS -!mulmxE !mulmxA -[_ *m M *m X]mulmxA -[_ *m (M *m X) *m N]mulmxA.
by rewrite -fixed.
Qed.

Lemma horner_mx_unit N (p : {poly R}) : coprimep p (char_poly N) -> horner_mx N p \in unitmx.
Proof.
case/Bezout_eq1_coprimepP=> -[u v] /= /(congr1 (horner_mx N)).
rewrite rmorphD !rmorphM /= Cayley_Hamilton mulr0 addr0 rmorph1.
by case/mulmx1_unit.
Qed.

(* The reversed polynomial of M, at N: chi_M(M) = 0 moves through the equation. *)
Theorem stein_zero M N X : inside (char_poly M) -> inside (char_poly N) ->
  X = M *m X *m N -> X = 0.
Proof.
move=> in_M in_N fixed; set p := char_poly M.
have moved i : (i <= n)%N -> X *m N ^+ i = M ^+ (n - i) *m X *m N ^+ n.
  move=> i_n; rewrite {1}(stein_power (n - i) fixed) -mulmxA; congr (_ *m _).
  by rewrite mulmxE -exprD subnK.
have vanishes : X *m horner_mx N (reversed n p) = 0.
  transitivity (horner_mx M p *m X *m N ^+ n); last by rewrite Cayley_Hamilton !mul0mx.
  rewrite (horner_mx_wide N (size_reversed n p)) (@horner_mx_wide _ _ M n.+1) ?size_char_poly //.
  rewrite mulmx_sumr !mulmx_suml (reindex_inj rev_ord_inj) /=; apply: eq_bigr => i _.
  have i_n : (i <= n)%N by rewrite -ltnS ltn_ord.
  rewrite subSS -scalemxAr moved ?leq_subr // subKn //.
  by rewrite coef_poly ltnS leq_subr subKn // -!scalemxAl.
have unit_r : horner_mx N (reversed n p) \in unitmx.
  apply: horner_mx_unit; rewrite coprimep_sym; apply: apart => //.
    by rewrite monic_neq0 ?char_poly_monic.
  by apply: outside_reversed; rewrite ?char_poly_monic ?size_char_poly.
by rewrite -(mulmxK unit_r X) vanishes mul0mx.
Qed.

Theorem stein_solvable M N Q : inside (char_poly M) -> inside (char_poly N) ->
  exists X, X = M *m X *m N + Q.
Proof.
move=> in_M in_N; pose L := lin_mx (idfun \- (mulmxr N \o mulmx M)).
have free : row_free L.
  rewrite -kermx_eq0; apply/rowV0P=> v /sub_kermxP; rewrite -(vec_mxK v) mul_vec_lin /=.
  move/(congr1 vec_mx); rewrite mxvecK linear0 /= => /eqP; rewrite subr_eq0 => /eqP fixed.
  by rewrite [vec_mx v](stein_zero in_M in_N fixed) linear0.
exists (vec_mx (mxvec Q *m invmx L)); set X := vec_mx _.
have : mxvec X *m L = mxvec Q by rewrite vec_mxK mulmxKV // -row_free_unit.
by rewrite mul_vec_lin /= => /(can_inj mxvecK) <-; rewrite addrC subrK.
Qed.

Theorem stein_unique M N Q X X' : inside (char_poly M) -> inside (char_poly N) ->
  X = M *m X *m N + Q -> X' = M *m X' *m N + Q -> X = X'.
Proof.
move=> in_M in_N E E'; apply/eqP; rewrite -subr_eq0; apply/eqP.
apply: (stein_zero in_M in_N); rewrite mulmxBr mulmxBl {1}E {1}E'.
by rewrite opprD addrACA subrr addr0.
Qed.

(* (4.23) for a loop whose poles are inside: exactly one Q, and it is symmetric where V is. *)
Theorem lyapunov_4_23 (Atilde V : 'M[R]_n) : inside (char_poly Atilde) -> V^T = V ->
  exists Qtilde, [/\ Qtilde = Atilde *m Qtilde *m Atilde^T + V, Qtilde^T = Qtilde
    & forall Q, Q = Atilde *m Q *m Atilde^T + V -> Q = Qtilde].
Proof.
move=> in_A V_T; have in_AT : inside (char_poly Atilde^T) by rewrite char_poly_tr.
have [X EX] := stein_solvable V in_A in_AT; exists X; split=> //; last first.
  by move=> Q EQ; apply: (stein_unique in_A in_AT EQ EX).
apply: (stein_unique in_A in_AT _ EX).
by rewrite {1}EX linearD /= !trmx_mul trmxK V_T mulmxA.
Qed.
End Stein.
