(* If some theta star matches the data exactly, what the recursion leaves of the retrospective cost is
   at most the weight of its distance to theta(0), for ever. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import RecursiveLeastSquares.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section ExactMatch.
Variables (R : realFieldType) (l_theta l_z : nat) (lambda : R).
Variables (Phi : nat -> 'M[R]_(l_z, l_theta)) (R_z R_u : nat -> 'M[R]_l_z).
Variables (z u_f : nat -> 'cV[R]_l_z) (R_theta : 'M[R]_l_theta) (theta_0 : 'cV[R]_l_theta).
Hypotheses (lambda_positive : 0 < lambda) (R_theta_definite : positive_definite R_theta).
Hypotheses (R_z_definite : forall i, positive_definite (R_z i)) (R_u_0 : forall i, R_u i = 0).
Let theta k := (theta_and_P lambda Phi R_z R_u z u_f R_theta theta_0 k).1.

Theorem exact_match_bound k star :
  (forall i, z i - u_f i + Phi i *m star = 0) ->
  \sum_(1 <= i < k.+1) lambda ^+ (k - i) * value (R_z i) (z i - u_f i + Phi i *m theta k)
    + lambda ^+ k * value R_theta (theta k - theta_0)
  <= lambda ^+ k * value R_theta (star - theta_0).
Proof.
move=> matches.
have v0 n (M : 'M[R]_n) : value M 0 = 0 by rewrite /value /bilinear mulmx0 mxE.
have z0 n (x : 'cV[R]_n) : value (0 : 'M[R]_n) x = 0.
  by rewrite /value /bilinear mulmx0 mul0mx mxE.
have costE x : cost lambda Phi R_z R_u z u_f R_theta theta_0 k x
   = \sum_(1 <= i < k.+1) lambda ^+ (k - i) * value (R_z i) (z i - u_f i + Phi i *m x)
     + lambda ^+ k * value R_theta (x - theta_0).
  by rewrite /cost; congr (_ + _); apply: eq_bigr => i _; rewrite /stage R_u_0 z0 addr0.
have := costE star; rewrite big1 ?add0r => [<-|i _]; last by rewrite matches v0 mulr0.
rewrite -costE; have [->//|ne] := eqVneq star (theta k).
apply/ltW/recursive_least_squares => // i; rewrite ?R_u_0 ?addr0 //; first by case: (R_z_definite i).
exact: trmx0.
Qed.
End ExactMatch.
