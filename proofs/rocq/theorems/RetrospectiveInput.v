(* (8.49)-(8.56): the retrospective cost of RCMR is a quadratic function of the input, and where its
   matrix is positive definite it has exactly one minimiser. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import PositiveDefinite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section RetrospectiveInput.
Variables (R : realFieldType) (s l : nat).
Variables (H : 'M[R]_(s, l)) (weight : 'M[R]_s) (eta : R) (Z : 'cV[R]_s) (U : 'cV[R]_l).

(* (8.49) and (8.51). *)
Definition retrospective_performance X := Z - H *m U + H *m X.
Definition retrospective_cost X :=
  value weight (retrospective_performance X) + eta * value 1%:M X.

(* (8.53), (8.54), (8.55), (8.56). *)
Definition quadratic_part := H^T *m weight *m H + eta%:M.
Definition linear_part := 2%:R *: (H^T *m weight *m (Z - H *m U)).
Definition constant_part := value weight (Z - H *m U).
Definition retrospective_input := - (2%:R^-1 *: (invmx quadratic_part *m linear_part)).

Hypothesis weight_symmetric : weight^T = weight.

Lemma quadratic_part_symmetric : quadratic_part^T = quadratic_part.
Proof.
by rewrite /quadratic_part linearD /= !trmx_mul trmxK weight_symmetric tr_scalar_mx mulmxA.
Qed.

Theorem quadratic_form_8_52 X : retrospective_cost X
  = value quadratic_part X + (linear_part^T *m X) 0 0 + constant_part.
Proof.
have -> : retrospective_cost X
    = value weight (Z - H *m U) + 2%:R * bilinear weight (H *m X) (Z - H *m U)
      + value weight (H *m X) + eta * value 1%:M X.
  by rewrite /retrospective_cost /retrospective_performance value_shift.
have -> : value quadratic_part X = value weight (H *m X) + eta * value 1%:M X.
  rewrite /quadratic_part value_add {1}/value bilinear_congruence -/(value _ _); congr (_ + _).
  by rewrite -value_scale scalemx1.
have -> : (linear_part^T *m X) 0 0 = 2%:R * bilinear weight (H *m X) (Z - H *m U).
  have tr (N : 'M[R]_1) : N^T = N by apply/matrixP=> i j; rewrite !ord1 mxE.
  rewrite -[linear_part^T *m X]tr trmx_mul trmxK /linear_part -scalemxAr mxE /bilinear.
  by rewrite trmx_mul !mulmxA.
rewrite /constant_part; move: (value weight (Z - H *m U)) (bilinear _ _ _) => a b.
by move: (value weight (H *m X)) (value 1%:M X) => c d; ring.
Qed.

Theorem retrospective_input_minimises X : positive_definite quadratic_part ->
  X != retrospective_input -> retrospective_cost retrospective_input < retrospective_cost X.
Proof.
move=> definite other; have unit_A := definite_invertible definite; have [A_T positive] := definite.
set X0 := retrospective_input in other *; have [D ED] : exists D, D = X - X0 by exists (X - X0).
have EX : X = X0 + D by rewrite ED addrC subrK.
have nz_D : D != 0 by rewrite ED subr_eq0.
have gradient : 2%:R * bilinear quadratic_part D X0 + (linear_part^T *m D) 0 0 = 0.
  have tr (N : 'M[R]_1) : N^T = N by apply/matrixP=> i j; rewrite !ord1 mxE.
  rewrite /bilinear -mulmxA /X0 /retrospective_input mulmxN -scalemxAr mulKVmx //.
  rewrite -[linear_part^T *m D]tr trmx_mul trmxK mulmxN -scalemxAr !mxE.
  by rewrite mulrN mulrA mulfV ?mul1r ?addNr // pnatr_eq0.
have sum_at (M N : 'M[R]_1) : (M + N) 0 0 = M 0 0 + N 0 0 by rewrite mxE.
rewrite !quadratic_form_8_52 EX (value_shift _ _ A_T) mulmxDr sum_at -subr_gt0.
have -> : value quadratic_part X0 + 2%:R * bilinear quadratic_part D X0 + value quadratic_part D
    + ((linear_part^T *m X0) 0 0 + (linear_part^T *m D) 0 0) + constant_part
    - (value quadratic_part X0 + (linear_part^T *m X0) 0 0 + constant_part)
    = value quadratic_part D + (2%:R * bilinear quadratic_part D X0 + (linear_part^T *m D) 0 0).
  move: (value quadratic_part X0) (bilinear _ _ _) (value quadratic_part D) constant_part => a b c e.
  by move: ((linear_part^T *m X0) 0 0) ((linear_part^T *m D) 0 0) => f g; ring.
by rewrite gradient addr0; apply: positive.
Qed.
End RetrospectiveInput.
