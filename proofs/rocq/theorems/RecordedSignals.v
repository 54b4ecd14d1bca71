(* (4.14) for recorded sequences with any initial state: whatever made u, z is the response of the loop
   with the fixed controller to w, plus its response to u~, plus its free response. Any number of
   signals, any n_c, with all direct terms. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section RecordedSignals.
Variables (R : comUnitRingType) (n l_u l_y l_z l_w n_c : nat).
Variables (A : 'M[R]_n) (B : 'M[R]_(n, l_u)) (C : 'M[R]_(l_y, n)) (D_1 : 'M[R]_(n, l_w)).
Variables (D_0 : 'M[R]_(l_y, l_u)) (D_2 : 'M[R]_(l_y, l_w)) (E_1 : 'M[R]_(l_z, n)).
Variables (E_2 : 'M[R]_(l_z, l_u)) (E_0 : 'M[R]_(l_z, l_w)).
(* theta star, in ascending powers: P i is P_(n_c - i), Q i is Q_(n_c - i), so that Q n_c is Q_0. *)
Variables (P : nat -> 'M[R]_l_u) (Q : nat -> 'M[R]_(l_u, l_y)).

(* The signals of (2.1)-(2.3), and u = Phi theta star + u~ from step n_c on; before it u is given. *)
Definition trajectory (w : nat -> 'cV[R]_l_w) (u_tilde : nat -> 'cV[R]_l_u)
    (x : nat -> 'cV[R]_n) (u : nat -> 'cV[R]_l_u) (y : nat -> 'cV[R]_l_y) (z : nat -> 'cV[R]_l_z) :=
  forall k,
  [/\ x k.+1 = A *m x k + B *m u k + D_1 *m w k,
      y k = C *m x k + D_0 *m u k + D_2 *m w k,
      z k = E_1 *m x k + E_2 *m u k + E_0 *m w k
    & u (k + n_c)%N = \sum_(i < n_c) P i *m u (k + i)%N + \sum_(i < n_c.+1) Q i *m y (k + i)%N
                      + u_tilde (k + n_c)%N].

Lemma trajectory_sub w w' v v' x x' u u' y y' z z' :
  trajectory w v x u y z -> trajectory w' v' x' u' y' z' ->
  trajectory (fun k => w k - w' k) (fun k => v k - v' k) (fun k => x k - x' k)
    (fun k => u k - u' k) (fun k => y k - y' k) (fun k => z k - z' k).
Proof.
move=> T T' k; have [Ex Ey Ez Eu] := T k; have [Ex' Ey' Ez' Eu'] := T' k.
have three m (a b c a' b' c' : 'cV[R]_m) : a + b + c - (a' + b' + c') = a - a' + (b - b') + (c - c').
  by apply/matrixP=> i j; rewrite !mxE; ring.
split; rewrite ?Ex ?Ey ?Ez ?Eu ?Ex' ?Ey' ?Ez' ?Eu' three ?mulmxBr //.
by congr (_ + _ + _); rewrite -sumrB; apply: eq_bigr => i _; rewrite mulmxBr.
Qed.

(* Well posed: where Q_0 = 0, or D_0 = 0, it is. *)
Hypothesis well_posed : 1%:M - Q n_c *m D_0 \in unitmx.

Lemma trajectory_from_rest x u y z : trajectory (fun=> 0) (fun=> 0) x u y z ->
  x 0%N = 0 -> (forall i, (i < n_c)%N -> u i = 0) -> forall k, [/\ x k = 0, u k = 0, y k = 0 & z k = 0].
Proof.
move=> T x0 past.
suff all k : forall j, (j <= k)%N -> [/\ x j = 0, u j = 0 & y j = 0].
  move=> k; have [Ex Eu Ey] := all k k (leqnn k); split=> //; have [_ _ -> _] := T k.
  by rewrite Ex Eu !mulmx0 !addr0.
have here j : x j = 0 -> (forall i, (i < j)%N -> u i = 0 /\ y i = 0) -> u j = 0 /\ y j = 0.
  move=> Ex before; have Ey : y j = D_0 *m u j.
    by have [_ -> _ _] := T j; rewrite Ex !mulmx0 add0r addr0.
  suff Eu : u j = 0 by rewrite Ey Eu mulmx0.
  have [below|above] := ltnP j n_c; first exact: past.
  have [_ _ _] := T (j - n_c)%N; rewrite subnK // addr0 big1 ?add0r => [|i _]; last first.
    have [-> _] : u (j - n_c + i)%N = 0 /\ y (j - n_c + i)%N = 0 by apply: before; have := ltn_ord i; lia.
    by rewrite mulmx0.
  rewrite big_ord_recr /= big1 ?add0r => [|i _]; last first.
    have [_ ->] : u (j - n_c + i)%N = 0 /\ y (j - n_c + i)%N = 0 by apply: before; have := ltn_ord i; lia.
    by rewrite mulmx0.
  rewrite subnK // Ey mulmxA => loop; apply: (can_inj (mulKmx well_posed)).
  by rewrite mulmx0 mulmxBl mul1mx -loop subrr.
elim: k => [|k IH] j.
  by rewrite leqn0 => /eqP ->; have [//|Eu Ey] := here 0%N x0; split.
rewrite leq_eqVlt => /orP[/eqP ->|]; last by rewrite ltnS; apply: IH.
have Ex : x k.+1 = 0.
  by have [-> _ _ _] := T k; have [-> -> _] := IH k (leqnn k); rewrite !mulmx0 !addr0.
have [|Eu Ey] := here k.+1 Ex; last by split.
by move=> i; rewrite ltnS => /IH[].
Qed.

Theorem recorded_signals w u_tilde x u y z x_w u_w y_w z_w x_u u_u y_u z_u x_f u_f y_f z_f :
  trajectory w u_tilde x u y z ->
  trajectory w (fun=> 0) x_w u_w y_w z_w -> x_w 0%N = 0 -> (forall i, (i < n_c)%N -> u_w i = 0) ->
  trajectory (fun=> 0) u_tilde x_u u_u y_u z_u -> x_u 0%N = 0 ->
    (forall i, (i < n_c)%N -> u_u i = 0) ->
  trajectory (fun=> 0) (fun=> 0) x_f u_f y_f z_f -> x_f 0%N = x 0%N ->
    (forall i, (i < n_c)%N -> u_f i = u i) ->
  forall k, z k = z_w k + z_u k + z_f k.
Proof.
move=> T T_w x_w0 past_w T_u x_u0 past_u T_f x_f0 past_f k.
have rest := trajectory_sub (trajectory_sub (trajectory_sub T T_w) T_u) T_f.
have := @trajectory_from_rest (fun k => x k - x_w k - x_u k - x_f k)
  (fun k => u k - u_w k - u_u k - u_f k) (fun k => y k - y_w k - y_u k - y_f k)
  (fun k => z k - z_w k - z_u k - z_f k).
case/(_ _ _ _ k) => [k'||i i_n|_ _ _ zero].
- by have := rest k'; rewrite /= !subr0 !subrr.
- by rewrite x_w0 x_u0 x_f0 !subr0 subrr.
- by rewrite past_w // past_u // past_f // !subr0 subrr.
by move/eqP: zero; rewrite subr_eq0 subr_eq subr_eq => /eqP ->; rewrite addrC [z_f k + _]addrC addrA.
Qed.
End RecordedSignals.
