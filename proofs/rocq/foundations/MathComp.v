(* What the files need of MathComp: all_algebra without its finite and countable structures and quotients of
   rings, whose opening takes as long as that of the rest. A file with a definition that `types` commits with
   finalg's 0 of 'I_n.+1 opens finalg besides. *)
From mathcomp Require Export all_ssreflect.
From mathcomp Require Export ssralg ssrnum poly polydiv polyXY ssrint rat intdiv interval matrix mxpoly.
From mathcomp Require Export mxalgebra vector fraction zmodp zify ring.

(* The kernel checks what ring and field conclude at Qed; they need not check it themselves before. *)
Ltac ring_reflection ::= ring_reflection_no_check.
