(* Witnesses of the theorems on certificates: the numbers 0 and 1, s + 1 with its root -1, z with its root 0. *)
From Coq Require Import ZArith.
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.theorems Require TraceRecursion CertifiedSigns.
From Compensators.theorems Require Import CertifiedEquations.
From Compensators.witnesses Require Import Satisfiable.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := [fieldType of rat].
Definition unit_polynomial : polynomial := [:: term (Zpos xH) [::]].
Definition single (p : polynomial) : expression 1 1 := Entries 1 1 [:: [:: p]] unit_polynomial.
Definition first_symbol : polynomial := [:: term (Zpos xH) [:: 1%N]].

Lemma rational_char0 : [char Q] =i pred0. Proof. exact: char_num. Qed.

Lemma char_poly_by_traces : ltac:(can_be_met (@TraceRecursion.char_poly_by_traces)).
Proof.
move=> absurd; apply: (absurd Q 1%N (0 : 'M_1) rational_char0 [:: 0] erefl).
by rewrite /= mxtrace1 mul0mx add0r raddf0 !eqxx.
Qed.

Lemma certified_equation : ltac:(can_be_met (@CertifiedEquations.certified_equation)).
Proof.
move=> absurd; apply: (absurd Q rational_char0 [::] [::] [::] (Zpos xH) [::] 1%N 1%N (single [::])) => //.
by rewrite /polynomial_at big_nil.
Qed.

Lemma certified_equality : ltac:(can_be_met (@CertifiedEquations.certified_equality)).
Proof.
move=> absurd; apply: (absurd Q rational_char0 [::] [::] [::] (Zpos xH) [::] 1%N 1%N
  (single unit_polynomial) (single unit_polynomial)) => //.
by rewrite /polynomial_at big_nil.
Qed.

Lemma certified_regular : ltac:(can_be_met (@CertifiedEquations.certified_regular)).
Proof.
move=> absurd; apply: (absurd Q rational_char0 [::] [::] [:: [:: unit_polynomial]] unit_polynomial 1%N
  (single unit_polynomial)) => //.
Qed.

(* det(s - 0) = s. *)
Lemma certified_spectrum : ltac:(can_be_met (@CertifiedEquations.certified_spectrum)).
Proof.
move=> absurd; apply: (absurd Q rational_char0 0 [::] [::] 1%N (single [::]) (single first_symbol)
  unit_polynomial [:: [::]]) => //.
Qed.

Lemma certified_definite : ltac:(can_be_met (@CertifiedSigns.certified_definite)).
Proof.
move=> absurd; apply: (absurd [realFieldType of rat] [::] 1%N (single unit_polynomial) (Zpos (xO xH))
  [:: Zpos xH] [:: [:: Zpos xH]]) => //.
Qed.

Lemma root_of_plus_one (F : fieldType) : at_ [:: - 1 : F] (single (first_symbol ++ unit_polynomial)) = 0.
Proof.
apply/matrixP=> i j; rewrite !mxE !ord1 /polynomial_at /= !big_cons !big_nil /= !integer1.
by rewrite expr1 !mulr1 mul1r !addr0 addNr mulr0.
Qed.

Lemma root_of_symbol (F : fieldType) : at_ [:: 0 : F] (single first_symbol) = 0.
Proof.
apply/matrixP=> i j; rewrite !mxE !ord1 /polynomial_at /= !big_cons !big_nil /= !integer1.
by rewrite expr1 !mulr1 mul1r !addr0 mulr0.
Qed.

Lemma certified_hurwitz : ltac:(can_be_met (@CertifiedSigns.certified_hurwitz)).
Proof.
move=> absurd; exact: (absurd [rcfType of realalg] (single (first_symbol ++ unit_polynomial))
  [:: Zpos xH; Zpos xH] [:: (Zpos xH, [:: Zpos xH])] (- 1) [::] erefl erefl (root_of_plus_one _)).
Qed.

Lemma certified_schur : ltac:(can_be_met (@CertifiedSigns.certified_schur)).
Proof.
move=> absurd; exact: (absurd [rcfType of realalg] (single first_symbol)
  [:: Z0; Zpos xH] [:: (Zpos xH, [:: Zpos xH])] 0 [::] erefl erefl (root_of_symbol _)).
Qed.
