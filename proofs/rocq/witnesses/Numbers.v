(* Witnesses of the theorems on hidden modes and on the number of forms: the loop with the poles 1, -1. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require CountOfForms HiddenModes.
From Compensators.theorems Require Import Kalman.
From Compensators.witnesses Require Import Satisfiable.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Local Notation o := (number (0 : Q)).
Local Notation e := (number (1 : Q)).

Lemma count_for_distinct_poles : ltac:(can_be_met (@CountOfForms.count_for_distinct_poles)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e o e e (fun i : 'I_2 => if i == 0 then 1 else - 1)
  (integrator_is_minimal Q) (integrator_is_minimal Q)).
  by case=> [[|[|//]] ?] [[|[|//]] ?] //= _; apply: val_inj.
by rewrite integrator_poles !big_ord_recl big_ord0 mulr1.
Qed.

Lemma count_of_forms : ltac:(can_be_met (@CountOfForms.count_of_forms)).
Proof.
pose p (b : bool) : {poly Q} := 'X - (if b then 1 else - 1)%:P.
move=> absurd; apply: (absurd Q 0%N o e e o e e (integrator_is_minimal Q) (integrator_is_minimal Q)
  [finType of bool] p (fun=> 1%N)).
- by move=> b; apply: monicXsubC.
- move=> b c; rewrite /p => /(congr1 (fun p : {poly Q} => p.[0])).
  by rewrite !hornerXsubC !sub0r; case: b; case: c.
- by move=> b; split; [rewrite size_XsubC | apply: irredp_XsubC].
by rewrite integrator_poles big_bool /p !expr1.
Qed.

Lemma cyclic_loop : nonderogatory (closed_loop o e e o e e).
Proof.
exists (col_mx (1%:M : 'M[Q]_1) 0); apply/controllableP => m eta unseen.
pose a : 'M[Q]_(m, 1) := @lsubmx _ m 1 1 eta; pose b : 'M[Q]_(m, 1) := @rsubmx _ m 1 1 eta.
have split_eta : eta = row_mx a b :> 'M_(m, 1 + 1) by rewrite hsubmxK.
have first : row_mx a b *m col_mx (1%:M : 'M[Q]_1) 0 = a.
  by rewrite mul_row_col mulmx1 mulmx0 addr0.
have second : row_mx a b *m closed_loop o e e o e e *m col_mx (1%:M : 'M[Q]_1) 0 = b.
  rewrite /closed_loop mul_row_block mul_row_col /number !mulmx1 mulmx0 addr0.
  by rewrite raddf0 mulmx0 add0r.
have a0 : a = 0.
  have := unseen 0%N; rewrite expr0 -[1]/(1%:M) mulmx1 => zero.
  by rewrite -first -split_eta; exact: zero.
have b0 : b = 0.
  by have := unseen 1%N; rewrite expr1 => zero; rewrite -second -split_eta; exact: zero.
by rewrite split_eta a0 b0 row_mx0.
Qed.

Lemma nothing_unobservable : is_unobservable_polynomial o e 1.
Proof.
exists 0%N, 0, 0; split; rewrite ?mxrank0 ?mulmx0 //.
  by rewrite /char_poly det_mx00.
move=> m v; split=> [unseen|[y ->] k]; last by rewrite mul0mx mulmx0.
exists 0; rewrite mulmx0; have [_ /observableP only] := integrator_is_minimal Q.
exact: only.
Qed.

Lemma nothing_uncontrollable : is_uncontrollable_polynomial o e 1.
Proof.
have T x : (number (x : Q))^T = number x by apply: tr_scalar_mx.
by rewrite /is_uncontrollable_polynomial !T; apply: nothing_unobservable.
Qed.

Lemma hidden_mode_rule : ltac:(can_be_met (@HiddenModes.hidden_mode_rule)).
Proof.
move=> absurd; apply: (absurd Q 0%N o e e o e e 1 1 (integrator_is_minimal Q) cyclic_loop
  nothing_unobservable nothing_uncontrollable ('X - 1%:P) ('X - (- 1)%:P) (monicXsubC _)).
  by rewrite size_XsubC.
exact: integrator_poles.
Qed.
