(* The controllers of Chapters 2 and 6 as operators: R is a commutative ring in which the forward shift q
   and its inverse live, so that u(k - i) is q^-i u. Any number of signals. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Forms.
Variables (R : comUnitRingType) (q : R) (l_u l_y n_c : nat).
Hypothesis unit_q : q \is a GRing.unit.
Variables (P : nat -> 'M[R]_l_u) (Q : nat -> 'M[R]_(l_u, l_y)) (u : 'cV[R]_l_u) (y : 'cV[R]_l_y).

(* q^n_c I - q^(n_c - 1) P_1 - ... - P_n_c and q^(n_c - k_c) Q_k_c + ... + Q_n_c. *)
Definition denominator_2_32 := q ^+ n_c *: (1%:M : 'M[R]_l_u) - \sum_(1 <= i < n_c.+1) q ^+ (n_c - i) *: P i.
Definition numerator_2_32 k_c := \sum_(k_c <= i < n_c.+1) q ^+ (n_c - i) *: Q i.

Lemma times_power l (v : 'cV[R]_l) (M : nat -> 'M[R]_(l_u, l)) first :
  q ^+ n_c *: (\sum_(first <= i < n_c.+1) M i *m (q ^- i *: v))
  = (\sum_(first <= i < n_c.+1) q ^+ (n_c - i) *: M i) *m v.
Proof.
rewrite scaler_sumr mulmx_suml !big_nat; apply: eq_bigr => i /andP[_ i_n].
rewrite -scalemxAr scalerA -scalemxAl; congr (_ *: _).
by rewrite -{1}(subnK (_ : (i <= n_c)%N)) // exprD -mulrA mulrV ?mulr1 // unitrX.
Qed.

(* (2.28) is D_c u = N_c y, (2.32); for scalar signals that is (2.33). *)
Theorem controller_2_32 k_c :
  u = \sum_(1 <= i < n_c.+1) P i *m (q ^- i *: u) + \sum_(k_c <= i < n_c.+1) Q i *m (q ^- i *: y) ->
  denominator_2_32 *m u = numerator_2_32 k_c *m y.
Proof.
move=> controller; rewrite /denominator_2_32 mulmxBl -scalemxAl mul1mx {1}controller scalerDr.
by rewrite !times_power addrAC subrr add0r.
Qed.

(* Without past controls, (2.34): n_c poles at 0, (2.35). *)
Theorem fir_controller_2_35 k_c : u = \sum_(k_c <= i < n_c.+1) Q i *m (q ^- i *: y) ->
  q ^+ n_c *: u = numerator_2_32 k_c *m y.
Proof. by move=> {1}->; rewrite times_power. Qed.

(* With two past controls, (6.1): n_c - 2 poles at 0. *)
Theorem quasi_fir_controller_6_1 : (2 <= n_c)%N -> (forall i, (2 < i)%N -> P i = 0) ->
  denominator_2_32 = q ^+ (n_c - 2) *: (q ^+ 2 *: 1%:M - q *: P 1%N - P 2).
Proof.
move=> two_n no_more; rewrite /denominator_2_32.
have later : \sum_(3 <= i < n_c.+1) q ^+ (n_c - i) *: P i = 0.
  by rewrite big_nat big1 // => i /andP[i_2 _]; rewrite no_more ?scaler0.
have -> : \sum_(1 <= i < n_c.+1) q ^+ (n_c - i) *: P i = q ^+ (n_c - 1) *: P 1%N + q ^+ (n_c - 2) *: P 2.
  rewrite (@big_cat_nat _ _ _ 3) //= later addr0.
  by rewrite big_ltn // big_ltn // big_geq // addr0.
have e2 : q ^+ n_c = q ^+ (n_c - 2) * q ^+ 2 by rewrite -exprD subnK.
have e1 : q ^+ (n_c - 1) = q ^+ (n_c - 2) * q by rewrite -exprSr; congr (_ ^+ _); lia.
rewrite e2 e1 opprD addrA; move: (q ^+ (n_c - 2)) (q ^+ 2) => a b.
by rewrite 2!scalerBr !scalerA.
Qed.

(* With an integrator, (6.4), (6.5): the poles are n_c times 0, and 1. *)
Theorem integrator_controller_6_4 l (K_1 : 'M[R]_(l_u, l)) (F : 'M[R]_(l, l_y)) (g : 'cV[R]_l) :
  g = q^-1 *: g + F *m y -> u = \sum_(1 <= i < n_c.+1) Q i *m (q ^- i *: y) + K_1 *m g ->
  (q ^+ n_c * (q - 1)) *: u = ((q - 1) *: numerator_2_32 1 + q ^+ n_c.+1 *: (K_1 *m F)) *m y.
Proof.
move=> integrates {1}->.
have sum : (q - 1) *: g = q *: (F *m y).
  by rewrite scalerBl scale1r {1}integrates scalerDr scalerA mulrV // scale1r addrAC subrr add0r.
rewrite scalerDr mulrC -scalerA times_power mulrC -scalerA [_ *: (K_1 *m g)]scalemxAr sum.
by rewrite mulmxDl -scalemxAl -scalemxAr scalerA -exprSr -scalemxAl mulmxA.
Qed.

(* The PID controller (2.58)-(2.62). *)
Theorem pid_controller_2_58 (K_P K_I K_D : 'M[R]_(l_u, l_y)) (g : 'cV[R]_l_y) :
  g = q^-1 *: g + q^-1 *: y ->
  u = K_P *m (q^-1 *: y) + K_I *m (q^-1 *: g) + K_D *m (q^-1 *: y - q ^- 2 *: y) ->
  (q ^+ 2 * (q - 1)) *: u = ((q * (q - 1)) *: K_P + q *: K_I + (q - 1) ^+ 2 *: K_D) *m y.
Proof.
move=> integrates ->; have sum : (q - 1) *: g = y.
  rewrite scalerBl scale1r {1}integrates -scalerDr scalerA mulrV // scale1r.
  by rewrite addrAC subrr add0r.
have one : q / q = 1 by rewrite mulrV.
have powers k : (k <= 2)%N -> q ^+ 2 * q ^- k = q ^+ (2 - k).
  by move=> k_2; rewrite -{1}(subnK k_2) exprD -mulrA mulrV ?mulr1 // unitrX.
have p1 : q ^+ 2 * q^-1 = q by have := powers 1%N isT.
have p2 : q ^+ 2 * q ^- 2 = 1 by have := powers 2%N isT.
rewrite !scalerDr !mulmxDl; congr (_ + _ + _).
- by rewrite -scalemxAr -scalemxAl scalerA mulrAC p1.
- by rewrite -scalemxAr -scalemxAl scalerA mulrAC p1 -scalerA scalemxAr sum.
rewrite -scalerBl -scalemxAr -scalemxAl scalerA; congr (_ *: _).
by rewrite mulrBr [X in X - _]mulrAC p1 [X in _ - X]mulrAC p2 mul1r expr2 mulrBl mul1r.
Qed.
End Forms.
