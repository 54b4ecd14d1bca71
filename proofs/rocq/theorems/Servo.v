(* The servo problem (2.16)-(2.23) is the standard problem with (2.24)-(2.27), any number of signals, with
   z = e_0, which is what the printed E_0 and G_zw belong to; z = e_n of (2.24) is y itself. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Servo.
Variables (R : comRingType) (n l_u l_d l_y : nat).
Variables (A : 'M[R]_n) (B : 'M[R]_(n, l_u)) (Dbar_1 : 'M[R]_(n, l_d)).
Variables (Cbar : 'M[R]_(l_y, n)) (Dbar_0 : 'M[R]_(l_y, l_u)).

(* (2.25), (2.26), for w = [r; d; v]. *)
Definition servo_D_1 : 'M[R]_(n, l_y + (l_d + l_y)) := row_mx 0 (row_mx Dbar_1 0).
Definition servo_D_2 : 'M[R]_(l_y, l_y + (l_d + l_y)) := row_mx 1%:M (row_mx 0 (- 1%:M)).
Definition servo_E_0 : 'M[R]_(l_y, l_y + (l_d + l_y)) := row_mx 1%:M (row_mx 0 0).

(* One step: the state (2.16), e_n of (2.18), (2.20), and e_0 of (2.17), (2.19). *)
Theorem servo_is_standard (x : 'cV[R]_n) (u : 'cV[R]_l_u) (r v : 'cV[R]_l_y) (d : 'cV[R]_l_d) :
  let w := col_mx r (col_mx d v) in let y_0 := Cbar *m x + Dbar_0 *m u in
  [/\ A *m x + B *m u + Dbar_1 *m d = A *m x + B *m u + servo_D_1 *m w,
      r - (y_0 + v) = - Cbar *m x + - Dbar_0 *m u + servo_D_2 *m w
    & r - y_0 = - Cbar *m x + - Dbar_0 *m u + servo_E_0 *m w].
Proof.
rewrite /servo_D_1 /servo_D_2 /servo_E_0 !mul_row_col !mul0mx !mul1mx !addr0 !add0r !mulNmx mul1mx.
by split=> //; rewrite !opprD; [rewrite addrCA | rewrite addrC].
Qed.

(* (2.27) from (2.22); M is (qI - A)^-1. *)
Variable M : 'M[R]_n.
Let G_u := Cbar *m M *m B + Dbar_0.
Let G_d := Cbar *m M *m Dbar_1.

Theorem servo_maps_2_27 :
  [/\ - Cbar *m M *m B - Dbar_0 = - G_u,
      - Cbar *m M *m servo_D_1 + servo_E_0 = row_mx 1%:M (row_mx (- G_d) 0)
    & - Cbar *m M *m servo_D_1 + servo_D_2 = row_mx 1%:M (row_mx (- G_d) (- 1%:M))].
Proof.
rewrite /servo_D_1 /servo_D_2 /servo_E_0 !mul_mx_row !mulmx0 !add_row_mx !add0r !addr0 !mulNmx.
by split=> //; rewrite opprD.
Qed.
End Servo.
