(* What RCMR makes of past subsystem outputs: the partition (8.38), the performance (8.39), (8.41) and the
   extended one (8.45), (8.48), and the subsystem (8.57) in the form theta(k) phi(k - 1). *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import fingroup perm.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Partition.
Variables (R : comRingType) (l_z k m : nat) (s : 'S_(k + m)).
Variables (Hbar : 'M[R]_(l_z, k + m)) (Ubar : 'cV[R]_(k + m)).

(* The columns of Hbar and the components of Ubar, rearranged alike and cut in two. *)
Definition H_rest := lsubmx (col_perm s Hbar).
Definition H_kept := rsubmx (col_perm s Hbar).
Definition U_rest := usubmx (row_perm s Ubar).
Definition U_kept := dsubmx (row_perm s Ubar).

Theorem partition_8_38 : Hbar *m Ubar = H_rest *m U_rest + H_kept *m U_kept.
Proof.
rewrite -mul_row_col hsubmxK vsubmxK col_permE row_permE mulmxA -[_ *m perm_mx s]mulmxA -perm_mxM.
by rewrite mulVg perm_mx1 mulmx1.
Qed.

(* (8.39) from (8.37), whose other terms are known, with (8.40). *)
Theorem performance_8_39 (z known : 'cV[R]_l_z) : z = known + Hbar *m Ubar ->
  z = known + H_rest *m U_rest + H_kept *m U_kept.
Proof. by rewrite partition_8_38 addrA. Qed.
End Partition.

(* (8.45) from (8.41), and (8.48) from (8.46): T j takes the components of U_j out of U~, which has none
   twice. *)
Theorem extended_8_45 (R : comRingType) l_z steps l (m : 'I_steps -> nat)
    (z S : 'I_steps -> 'cV[R]_l_z) (H : forall j, 'M[R]_(l_z, m j)) (T : forall j, 'M[R]_(m j, l))
    (U : 'cV[R]_l) :
  (forall j, z j = S j + H j *m (T j *m U)) ->
  \mxcol_j z j = \mxcol_j S j + (\mxcol_j (H j *m T j)) *m U.
Proof.
move=> delayed; apply/matrixP=> i j; rewrite !mxE delayed mulmxA !mxE; congr (_ + _).
by apply: eq_bigr => a _; rewrite !mxE.
Qed.

(* (8.57) with (8.58) and (8.59); (8.60) is n_c = 1. *)
Theorem subsystem_8_57 (R : comRingType) l_u l_y n_c (N : 'I_n_c -> 'M[R]_(l_u, l_y))
    (y : nat -> 'cV[R]_l_y) k :
  (\mxrow_i N i) *m (\mxcol_(i < n_c) y (k - i.+1)%N) = \sum_i N i *m y (k - i.+1)%N.
Proof. exact: mul_mxrow_mxcol. Qed.
