(* What a witness of a theorem says: its hypotheses can be met. can_be_met t is the type of t with False
   in the place of its conclusion, refuted: if somebody adds a hypothesis that contradicts the others,
   the witness is no longer provable. And an example that most of them use: the plant 1 / s with the
   compensator x_c' = y, u = x_c, a loop with the poles 1 and -1. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices SmallSystems.
From Compensators.theorems Require Import Kalman ClosedLoop Coprimeness Forms.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Ltac conclusion_absurd T :=
  lazymatch T with
  | forall x : ?A, @?B x => let y := fresh in constr:(forall y : A,
      ltac:(let b := eval cbv beta in (B y) in let r := conclusion_absurd b in exact r))
  | _ => constr:(False)
  end.
Ltac can_be_met t :=
  let T := type of t in let T := eval cbv zeta in T in
  let r := conclusion_absurd T in exact (r -> False).

Section Integrator.
Variable R : fieldType.

Definition number (x : R) : 'M[R]_1 := x%:M.
Local Notation o := (number 0).
Local Notation e := (number 1).

Lemma integrator_is_minimal : minimal o e e.
Proof. by apply/minimal_iff_coprime; rewrite /number numerator_1 mulr1 polyC1 coprimep1. Qed.

Lemma integrator_denominator : char_poly o = 'X.
Proof. by rewrite /number char_poly_1 subr0. Qed.

Lemma integrator_form : observer_form o e e o e e e e e.
Proof.
split; rewrite ?unitmx1 ?mulmx1 //.
by rewrite /observer_matrix /number !mulmx1 addrK mul1mx.
Qed.

Lemma integrator_loop : closed_loop o e e o e e *m col_mx e e = col_mx e e *m e.
Proof.
rewrite /closed_loop mul_block_col mul_col_mx /number !raddf0 !mul0mx !mulmx1.
by rewrite addr0 add0r.
Qed.

Lemma integrator_rank : \rank (col_mx e e) = 1%N.
Proof.
apply/eqP; rewrite eqn_leq rank_leq_col lt0n mxrank_eq0; apply/negP=> /eqP.
rewrite -[0]vsubmxK => /eq_col_mx[/matrixP/(_ 0 0)].
by rewrite !mxE eqxx => /eqP; rewrite oner_eq0.
Qed.

Lemma integrator_poles : char_poly (closed_loop o e e o e e) = ('X - 1%:P) * ('X - (- 1)%:P).
Proof.
have -> : closed_loop o e e o e e = closed_loop o e e (observer_matrix o e e e e) e e.
  by congr block_mx; rewrite /observer_matrix /number mulmx1 addrK.
rewrite ClosedLoop.separation /number !mulmx1 raddf0 add0r sub0r -raddfN !char_poly_1.
by [].
Qed.
End Integrator.
