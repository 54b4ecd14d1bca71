(* The recursions of chapter 2 as they are printed. RecursiveLeastSquares.v has what is true. *)
From Compensators.foundations Require Import MathComp.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Recursions.
Variable R : realFieldType.

(* Refuted: the proposition of Section 2.3.4 with P(0) = R_theta^-1 and (2.43) from k = 0 on, where
   Phi_f = 0. For lambda = 1/2, R_theta = 1, theta(0) = 0, R_z = 1, R_u = 0, Phi_f(1) = 1 and
   z(1) - u_f(1) = 1 the update gives theta(2) = -4/5, and -2/3 costs less. *)
Theorem first_covariance :
  let lambda : R := 2%:R^-1 in let P_0 : R := 1 in
  let P_1 := lambda^-1 * P_0 in let Upsilon := lambda + P_1 in
  let theta_2 := 0 - P_1 * Upsilon^-1 * (0 + 1) in
  let cost theta := (1 + theta) ^+ 2 + lambda * (theta - 0) ^+ 2 in
  theta_2 = - (4%:R / 5%:R) /\ cost (- (2%:R / 3%:R)) < cost theta_2.
Proof.
move=> lambda P_0 P_1 Upsilon theta_2 cost.
have E : theta_2 = - (4%:R / 5%:R).
  by rewrite /theta_2 /Upsilon /P_1 /P_0 /lambda; field.
split=> //; rewrite E -subr_gt0.
have -> : cost (- (4%:R / 5%:R)) - cost (- (2%:R / 3%:R)) = 2%:R / 75%:R.
  by rewrite /cost /lambda; field.
by rewrite divr_gt0 ?ltr0n.
Qed.

(* Refuted: (2.47) with Upsilon(k) of (2.44) as an update of a covariance. P(k) = 1, R_z + R_u = 1,
   Phi_f(k) = 0 and Phi_f(k + 1) = 2 make P(k + 1) = -3. *)
Theorem covariance_2_47 :
  let P : R := 1 in let W : R := 1 in let Phi_k : R := 0 in let Phi_next : R := 2%:R in
  let Upsilon := W^-1 + Phi_k * P * Phi_k in
  [/\ 0 < P, 0 < W & P - P * Phi_next * Upsilon^-1 * Phi_next * P < 0].
Proof.
move=> P W Phi_k Phi_next Upsilon.
split; rewrite ?ltr01 //.
have -> : P - P * Phi_next * Upsilon^-1 * Phi_next * P = - 3%:R.
  by rewrite /Upsilon /P /W /Phi_k /Phi_next !(mul0r, invr1, addr0); ring.
by rewrite oppr_lt0 ltr0n.
Qed.
End Recursions.
