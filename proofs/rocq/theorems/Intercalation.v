(* The intercalated transfer function, (4.7)-(4.19), for any number of signals. R is a commutative
   ring in which the transfer functions live, as the field of rational functions of q does. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section Intercalation.
Variables (R : comUnitRingType) (l_u l_y l_z l_w n_c : nat) (q : R).
Variables (G_zw : 'M[R]_(l_z, l_w)) (G_zu : 'M[R]_(l_z, l_u)).
Variables (G_yw : 'M[R]_(l_y, l_w)) (G_yu : 'M[R]_(l_y, l_u)).
Variables (D_c : 'M[R]_l_u) (N_c : 'M[R]_(l_u, l_y)).
Let G_c := invmx D_c *m N_c.
Let S := invmx (1%:M - G_yu *m G_c).

(* (4.15) and (4.16). *)
Definition closed_loop_response := G_zw + G_zu *m G_c *m S *m G_yw.
Definition intercalated_transfer_function :=
  q ^+ n_c *: (G_zu *m (invmx D_c + G_c *m S *m G_yu *m invmx D_c)).

Hypothesis D_c_invertible : D_c \in unitmx.
Hypothesis well_posed : 1%:M - G_yu *m G_c \in unitmx.

(* (4.16) is q^n_c G_zu (D_c - N_c G_yu)^-1. *)
Theorem compact_form :
  D_c - N_c *m G_yu \in unitmx /\
  intercalated_transfer_function = q ^+ n_c *: (G_zu *m invmx (D_c - N_c *m G_yu)).
Proof.
pose X := G_c *m S *m G_yu *m invmx D_c.
have through_D : D_c *m X = N_c *m S *m G_yu *m invmx D_c by rewrite !mulmxA mulmxV // mul1mx.
have loop : G_yu *m G_c *m S = S - 1%:M.
  by rewrite -(mulmxV well_posed) -/S mulmxBl mul1mx subKr.
have through_N : N_c *m G_yu *m X = D_c *m X - N_c *m G_yu *m invmx D_c.
  transitivity (N_c *m (G_yu *m G_c *m S) *m (G_yu *m invmx D_c)).
    by rewrite /X !mulmxA.
  by rewrite loop mulmxBr mulmx1 mulmxBl through_D !mulmxA.
have inverse : (D_c - N_c *m G_yu) *m (invmx D_c + X) = 1%:M.
  by rewrite mulmxDr !mulmxBl mulmxV // through_N subKr subrK.
have [unit_1 unit_2] := mulmx1_unit inverse; split=> //.
rewrite /intercalated_transfer_function; congr (_ *: (_ *m _)).
by rewrite -[LHS](mulKmx unit_1) inverse mulmx1.
Qed.

(* (4.7)-(4.14): the past controls that the controller reads are u = u* + u~, and u* is what the
   controller with the coefficients of D_c and N_c makes of them. *)
Theorem intercalation (w : 'cV[R]_l_w) (u_star u_tilde : 'cV[R]_l_u) y z :
  q ^+ n_c *: u_star = q ^+ n_c *: (u_star + u_tilde) - D_c *m (u_star + u_tilde) + N_c *m y ->
  y = G_yw *m w + G_yu *m (u_star + u_tilde) ->
  z = G_zw *m w + G_zu *m (u_star + u_tilde) ->
  z = closed_loop_response *m w + intercalated_transfer_function *m u_tilde.
Proof.
set u := u_star + u_tilde => controller measurement ->.
pose v := invmx D_c *m (q ^+ n_c *: u_tilde).
have injected : u = v + G_c *m y.
  apply: (can_inj (mulKmx D_c_invertible)).
  rewrite [in RHS]mulmxDr /v /G_c -[invmx D_c *m N_c *m y]mulmxA !mulKVmx //.
  have -> : u_tilde = u - u_star by rewrite /u addrC addKr.
  have -> : N_c *m y = q ^+ n_c *: u_star - (q ^+ n_c *: u - D_c *m u).
    by rewrite controller addrC addKr.
  by rewrite scalerBr addrA subrK subKr.
have solved : y = S *m (G_yw *m w + G_yu *m v).
  apply: (can_inj (mulKmx well_posed)); rewrite /S mulKVmx // mulmxBl mul1mx.
  by rewrite {1}measurement injected mulmxDr [G_yu *m (G_c *m y)]mulmxA addrA addrK.
have response : intercalated_transfer_function *m u_tilde
    = G_zu *m v + G_zu *m (G_c *m (S *m (G_yu *m v))).
  rewrite /intercalated_transfer_function /v -scalemxAl -mulmxA mulmxDl mulmxDr scalerDr.
  by rewrite -!scalemxAr !mulmxA.
rewrite injected solved response /closed_loop_response mulmxDl !mulmxDr !mulmxA !addrA.
by congr (_ + _); rewrite addrAC.
Qed.
End Intercalation.

(* The same for scalar signals, and (4.19): a perturbation added to the applied control, outside the
   controller, meets D_c in place of q^n_c. *)
Section ScalarSignals.
Variables (R : fieldType) (n_c : nat) (q D N_zu N_yu D_c N_c : R).
Let Dtilde := D * D_c - N_yu * N_c.
Hypotheses (nz_D : D != 0) (nz_Dc : D_c != 0) (nz_Dtilde : Dtilde != 0).

Theorem scalar_form_4_18 :
  q ^+ n_c * (N_zu / D) / (D_c - N_c * (N_yu / D)) = N_zu * q ^+ n_c / Dtilde.
Proof.
have loop : D_c - N_c * (N_yu / D) = Dtilde / D.
  by rewrite /Dtilde; field.
by rewrite loop; field; rewrite nz_Dtilde nz_D.
Qed.

Theorem external_perturbation_4_19 u u_bar :
  u = (N_c / D_c) * (N_yu / D) * u + u_bar ->
  (N_zu / D) * u = N_zu * D_c / Dtilde * u_bar.
Proof.
move=> loop; have : Dtilde * u = D * D_c * u_bar.
  have -> : u_bar = u - (N_c / D_c) * (N_yu / D) * u by rewrite {1}loop addrC addKr.
  rewrite mulrBr /Dtilde mulrBl; congr (_ - _); rewrite mulf_div.
  by field; rewrite nz_D nz_Dc.
by move/(canRL (mulKf nz_Dtilde)) => ->; field; rewrite nz_Dtilde nz_D.
Qed.
End ScalarSignals.

(* The residual of the fit, (4.1)-(4.6): G_f acts on signals and keeps sums; v is Phi theta. *)
Section Residual.
Variables (U Z : zmodType) (G_f : {additive U -> Z}).

Theorem performance_4_1 (z : Z) (u v : U) : z + G_f v - G_f u = z - G_f (u - v).
Proof. by rewrite raddfB opprB addrA. Qed.

Theorem residual_4_6 (z : Z) (u u_star u_tilde : U) : u_tilde = u - u_star ->
  u = u_star + u_tilde /\ z - G_f (u - u_star) = z - G_f u_tilde.
Proof. by move=> ->; rewrite addrC subrK. Qed.
End Residual.
