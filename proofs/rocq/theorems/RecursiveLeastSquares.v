(* The proposition of Section 2.3.4: the recursion (2.42)-(2.44) minimises the retrospective cost
   (2.41) at every step, and nothing else does. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* One step. H is the inverse of P, and r = z - u_f. *)
Section Step.
Variables (R : realFieldType) (l_theta l_z : nat).
Variables (P : 'M[R]_l_theta) (Phi : 'M[R]_(l_z, l_theta)) (R_z R_u W : 'M[R]_l_z) (lambda : R).
Hypotheses (P_definite : positive_definite P) (lambda_positive : 0 < lambda).
Hypotheses (R_z_symmetric : R_z^T = R_z) (R_u_symmetric : R_u^T = R_u).
Hypotheses (W_sum : W = R_z + R_u) (W_definite : positive_definite W).

(* (2.44), (2.43), (2.42). *)
Definition Upsilon := lambda *: invmx W + Phi *m P *m Phi^T.
Definition next_P := lambda^-1 *: (P - P *m Phi^T *m invmx Upsilon *m Phi *m P).
Definition next_theta (theta : 'cV[R]_l_theta) (r : 'cV[R]_l_z) :=
  theta - P *m Phi^T *m invmx Upsilon *m (Phi *m theta + invmx W *m R_z *m r).

Definition next_H := lambda *: invmx P + Phi^T *m W *m Phi.

Lemma Upsilon_invertible : Upsilon \in unitmx.
Proof.
apply/definite_invertible/definite_add.
  exact/(definite_scale lambda_positive)/definite_inverse.
rewrite -{1}[Phi]trmxK; exact/semidefinite_congruence/definite_semidefinite.
Qed.

Lemma next_H_definite : positive_definite next_H.
Proof.
apply: definite_add; first exact/(definite_scale lambda_positive)/definite_inverse.
exact/semidefinite_congruence/definite_semidefinite.
Qed.

Lemma next_H_gain : next_H *m P *m Phi^T = Phi^T *m W *m Upsilon.
Proof.
have unit_P := definite_invertible P_definite; have unit_W := definite_invertible W_definite.
rewrite /next_H /Upsilon !mulmxDl mulmxDr -!scalemxAl mulVmx // mul1mx -scalemxAr.
by rewrite -[Phi^T *m W *m invmx W]mulmxA mulmxV // mulmx1 !mulmxA.
Qed.

Lemma next_P_inverse : next_P = invmx next_H.
Proof.
have unit_P := definite_invertible P_definite.
have unit_H := definite_invertible next_H_definite.
suff product : next_H *m next_P = 1%:M by rewrite -[LHS](mulKmx unit_H) product mulmx1.
rewrite /next_P -scalemxAr mulmxBr !mulmxA next_H_gain -[_ *m Upsilon *m _]mulmxA.
rewrite mulmxV ?Upsilon_invertible // mulmx1 {1}/next_H mulmxDl -scalemxAl mulVmx //.
by rewrite addrK scalerA mulVf ?scale1r // gt_eqF.
Qed.

Lemma next_theta_solves theta r :
  next_H *m next_theta theta r = lambda *: (invmx P *m theta) - Phi^T *m R_z *m r.
Proof.
have unit_W := definite_invertible W_definite.
rewrite /next_theta mulmxBr !mulmxA next_H_gain -[_ *m Upsilon *m _]mulmxA.
rewrite mulmxV ?Upsilon_invertible // mulmx1 mulmxDr {1}/next_H mulmxDl -scalemxAl.
rewrite !mulmxA -[Phi^T *m W *m invmx W]mulmxA mulmxV // mulmx1.
by rewrite opprD addrA addrK.
Qed.

(* What the step adds to the cost. *)
Definition stage (r : 'cV[R]_l_z) (x : 'cV[R]_l_theta) :=
  value R_z (r + Phi *m x) + value R_u (Phi *m x).

Lemma step_completes_the_square theta r x :
  lambda * value (invmx P) (x - theta) + stage r x
  = value next_H (x - next_theta theta r)
    + (lambda * value (invmx P) (next_theta theta r - theta) + stage r (next_theta theta r)).
Proof.
move: (next_theta theta r) (next_theta_solves theta r) => t solves.
have [d Ed] : exists d, x - t = d by exists (x - t).
have Ex : x = t + d by rewrite -Ed addrC subrK.
have H_symmetric : (invmx P)^T = invmx P by have [] := definite_inverse P_definite.
have Etheta : t + d - theta = (t - theta) + d by rewrite addrAC.
have Er : r + Phi *m (t + d) = (r + Phi *m t) + Phi *m d by rewrite mulmxDr addrA.
rewrite /stage Ed Ex Etheta Er (mulmxDr Phi) (value_shift (t - theta) d H_symmetric).
rewrite (value_shift (r + _) _ R_z_symmetric) (value_shift (Phi *m t) _ R_u_symmetric).
have gradient : lambda * bilinear (invmx P) d (t - theta) + bilinear R_z (Phi *m d) (r + Phi *m t)
    + bilinear R_u (Phi *m d) (Phi *m t) = 0.
  transitivity ((d^T *m (next_H *m t - (lambda *: (invmx P *m theta) - Phi^T *m R_z *m r))) 0 0).
    have Ht : next_H *m t = lambda *: (invmx P *m t) + Phi^T *m R_z *m Phi *m t
        + Phi^T *m R_u *m Phi *m t.
      by rewrite /next_H W_sum mulmxDr !mulmxDl -scalemxAl addrA.
    rewrite Ht /bilinear trmx_mul !mulmxBr !mulmxDr -!scalemxAr !mulmxA.
    move: (d^T *m invmx P *m t) (d^T *m invmx P *m theta) (d^T *m Phi^T *m R_z *m r) => a b c.
    move: (d^T *m Phi^T *m R_z *m Phi *m t) (d^T *m Phi^T *m R_u *m Phi *m t) => e f.
    rewrite !mxE; move: (a 0 0) (b 0 0) (c 0 0) (e 0 0) (f 0 0) => *; ring.
  by rewrite solves subrr mulmx0 mxE.
have H_value : value next_H d = lambda * value (invmx P) d + value R_z (Phi *m d)
    + value R_u (Phi *m d).
  rewrite /next_H !value_add value_scale W_sum /value -addrA !bilinear_congruence.
  by rewrite -!/(value _ _) value_add.
rewrite H_value; move: gradient.
move: (bilinear (invmx P) d (t - theta)) (bilinear R_z (Phi *m d) (r + Phi *m t)).
move: (bilinear R_u (Phi *m d) (Phi *m t)) (value (invmx P) d) (value R_z (Phi *m d)).
move: (value R_u (Phi *m d)) (value (invmx P) (t - theta)) (value R_z (r + Phi *m t)).
move: (value R_u (Phi *m t)) => a1 a2 a3 a4 a5 a6 a7 a8 a9 gradient.
transitivity (lambda * a6 + a7 + a2 + (lambda * a3 + (a4 + a1))
  + 2%:R * (lambda * a8 + a9 + a5)); first by ring.
by rewrite gradient mulr0 addr0.
Qed.
End Step.

(* All steps. *)
Section Recursion.
Variables (R : realFieldType) (l_theta l_z : nat) (lambda : R).
Variables (Phi : nat -> 'M[R]_(l_z, l_theta)) (R_z R_u : nat -> 'M[R]_l_z).
Variables (z u_f : nat -> 'cV[R]_l_z) (R_theta : 'M[R]_l_theta) (theta_0 : 'cV[R]_l_theta).

(* (2.41). *)
Definition cost k (x : 'cV[R]_l_theta) :=
  \sum_(1 <= i < k.+1) lambda ^+ (k - i) * stage (Phi i) (R_z i) (R_u i) (z i - u_f i) x
  + lambda ^+ k * value R_theta (x - theta_0).

(* theta(k + 1) and P(k + 1), from theta(1) = theta(0) and P(1) = R_theta^-1. *)
Fixpoint theta_and_P k : 'cV[R]_l_theta * 'M[R]_l_theta :=
  if k is i.+1 then
    let: (theta, P) := theta_and_P i in
    let W := R_z k + R_u k in
    (next_theta P (Phi k) (R_z k) W lambda theta (z k - u_f k), next_P P (Phi k) W lambda)
  else (theta_0, invmx R_theta).

Hypotheses (lambda_positive : 0 < lambda) (R_theta_definite : positive_definite R_theta).
Hypotheses (R_z_symmetric : forall i, (R_z i)^T = R_z i).
Hypotheses (R_u_symmetric : forall i, (R_u i)^T = R_u i).
Hypotheses (sum_definite : forall i, positive_definite (R_z i + R_u i)).

Lemma cost_step k x : cost k.+1 x
  = lambda * cost k x + stage (Phi k.+1) (R_z k.+1) (R_u k.+1) (z k.+1 - u_f k.+1) x.
Proof.
rewrite /cost big_nat_recr //= subnn expr0 mul1r mulrDr mulr_sumr [RHS]addrAC; congr (_ + _ + _).
  rewrite !big_nat; apply: eq_bigr => i /andP[_ i_k].
  by rewrite subSn // exprS mulrA.
by rewrite exprS mulrA.
Qed.

Lemma recursion_is_exact k : let: (theta, P) := theta_and_P k in
  positive_definite P /\
  forall x, cost k x = value (invmx P) (x - theta) + cost k theta.
Proof.
elim: k => [|k IH] /=.
  split=> [|x]; first exact: definite_inverse.
  have at_0 : value R_theta 0 = 0 by rewrite /value /bilinear mulmx0 mxE.
  by rewrite /cost !big_geq // expr0 !mul1r !add0r invmxK subrr at_0 addr0.
case: (theta_and_P k) IH => theta P [definite quadratic].
have W_definite := sum_definite k.+1.
have inverse := next_P_inverse (Phi k.+1) definite lambda_positive W_definite.
split=> [|x].
  by rewrite inverse; apply/definite_inverse/next_H_definite.
rewrite !cost_step inverse invmxK (quadratic x) (quadratic (next_theta _ _ _ _ _ _ _)).
move: (cost k theta) => least; rewrite !mulrDr addrAC.
rewrite (step_completes_the_square (Phi k.+1) definite lambda_positive
  (R_z_symmetric _) (R_u_symmetric _) (erefl _) W_definite).
by rewrite -[LHS]addrA; congr (_ + _); rewrite addrAC.
Qed.

(* The proposition, with P(1) = R_theta^-1 and theta(1) = theta(0): theta(k + 1) of (2.42)-(2.45) is
   the only minimiser of (2.41), for every k >= 0. *)
Theorem recursive_least_squares k x : x != (theta_and_P k).1 ->
  cost k (theta_and_P k).1 < cost k x.
Proof.
move=> other; have := recursion_is_exact k; case: (theta_and_P k) other => theta P /= other.
case=> definite quadratic; have [_ positive] := definite_inverse definite.
by rewrite (quadratic x) ltr_addr positive // subr_eq0.
Qed.
End Recursion.
