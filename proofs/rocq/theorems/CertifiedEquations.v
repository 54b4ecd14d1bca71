(* Certificates of matrices of rational functions, checked by computation. The data of a matrix are lists, as
   a record of JSON has them: numerators over one denominator, a polynomial as its terms [coefficient,
   exponents] with integers. at_ says what an expression in such matrices is for values x of the symbols in
   a field of characteristic 0 (the rational, real or complex numbers, or rational functions); the checks
   are booleans that vm_compute evaluates, on the sparse polynomials of Coq's own tactic ring. *)
From Coq Require Import ZArith Ring_polynom Ring_theory.
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import ssrZ.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import TraceRecursion.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Definition polynomial := seq (Z * seq nat).
Definition term (coefficient : Z) (exponents : seq nat) : Z * seq nat := (coefficient, exponents).
Definition rows := seq (seq polynomial).

Inductive expression : nat -> nat -> Type :=
| Entries m n of rows & polynomial : expression m n
| Transpose m n of expression m n : expression n m
| Times m n p of expression m n & expression n p : expression m p
| Plus m n of expression m n & expression m n : expression m n
| Minus m n of expression m n & expression m n : expression m n
| Scale m n of Z & expression m n : expression m n.

(* What the data mean. *)
Section Meaning.
Variable F : fieldType.
Implicit Types (x : seq F).

Definition integer (z : Z) : F := (int_of_Z z)%:~R.
Fixpoint power_product x (exponents : seq nat) : F :=
  if exponents is e :: es then head 0 x ^+ e * power_product (behead x) es else 1.
Definition polynomial_at x (p : polynomial) : F := \sum_(t <- p) integer t.1 * power_product x t.2.
Definition entry (r : rows) i j : polynomial := nth [::] (nth [::] r i) j.
Definition entries_at x m n (r : rows) : 'M[F]_(m, n) := \matrix_(i, j) polynomial_at x (entry r i j).

Fixpoint at_ x m n (e : expression m n) : 'M[F]_(m, n) := match e with
  | Entries m n r below => (polynomial_at x below)^-1 *: entries_at x m n r
  | Transpose _ _ e => (at_ x e)^T
  | Times _ _ _ e f => at_ x e *m at_ x f
  | Plus _ _ e f => at_ x e + at_ x f
  | Minus _ _ e f => at_ x e - at_ x f
  | Scale _ _ c e => integer c *: at_ x e
  end.

Definition nonzero_at x (ps : seq polynomial) := all (fun p => polynomial_at x p != 0) ps.
End Meaning.

(* How they are computed. *)
Definition horner := Pol Z.
Definition constant (z : Z) : horner := Pc z.
Definition plus : horner -> horner -> horner := Padd Z0 Z.add Z.eqb.
Definition times : horner -> horner -> horner := Pmul Z0 (Zpos xH) Z.add Z.mul Z.eqb.
Definition same : horner -> horner -> bool := Peq Z.eqb.
Definition zero : horner := constant Z0.
Definition one : horner := constant (Zpos xH).
Fixpoint monomial (c : Z) (es : seq nat) : horner := match es with
  | [::] => constant c
  | O :: es => mkPinj xH (monomial c es)
  | e.+1 :: es => mkPX Z0 Z.eqb (mkPinj xH (monomial c es)) (Pos.of_succ_nat e) zero
  end.
Definition of_terms (p : polynomial) : horner := foldr (fun t q => plus (monomial t.1 t.2) q) zero p.

Definition table := seq (seq horner).
Definition cell (l : table) i j : horner := nth zero (nth [::] l i) j.
Definition tabulate m n (f : nat -> nat -> horner) : table := mkseq (fun i => mkseq (f i) n) m.
Definition every m n (f : nat -> nat -> bool) : bool := all (fun i => all (f i) (iota 0 n)) (iota 0 m).
Definition total n (f : nat -> horner) : horner := foldr (fun k s => plus (f k) s) zero (iota 0 n).
Definition table_times m n p (a b : table) : table :=
  tabulate m p (fun i j => total n (fun k => times (cell a i k) (cell b k j))).
Definition product (ps : seq horner) : horner := foldr times one ps.

(* The denominators of a product are kept as a list; a sum takes what is common once. *)
Fixpoint without (p : horner) (ps : seq horner) : option (seq horner) := match ps with
  | [::] => None
  | q :: qs => if same p q then Some qs else omap (cons q) (without p qs)
  end.
Fixpoint differences (a b : seq horner) : seq horner * seq horner := match a with
  | [::] => ([::], b)
  | p :: ps => if without p b is Some rest then differences ps rest
               else let: (only_a, only_b) := differences ps b in (p :: only_a, only_b)
  end.

Definition joined m n (sign : Z) (e f : table * seq horner) : table * seq horner :=
  let: (l, d) := e in let: (k, c) := f in
  let: (only_d, only_c) := differences d c in
  let lift_l := product only_c in let lift_k := times (constant sign) (product only_d) in
  (tabulate m n (fun i j => plus (times lift_l (cell l i j)) (times lift_k (cell k i j))), d ++ only_c).

Fixpoint computed m n (e : expression m n) : table * seq horner := match e with
  | Entries m n r below =>
      let d := of_terms below in
      (tabulate m n (fun i j => of_terms (entry r i j)), if same d one then [::] else [:: d])
  | Transpose m n e => let: (l, d) := computed e in (tabulate n m (fun i j => cell l j i), d)
  | Times m n p e f =>
      let: (l, d) := computed e in let: (k, c) := computed f in (table_times m n p l k, d ++ c)
  | Plus m n e f => joined m n (Zpos xH) (computed e) (computed f)
  | Minus m n e f => joined m n (Zneg xH) (computed e) (computed f)
  | Scale m n z e => let: (l, d) := computed e in
      (tabulate m n (fun i j => times (constant z) (cell l i j)), d)
  end.

(* A denominator is a number other than 0, or one that is assumed not to vanish. *)
Definition is_number (p : horner) : bool := if p is Pc c then ~~ Z.eqb c Z0 else false.
Definition admitted (given : seq polynomial) (p : horner) : bool :=
  is_number p || has (fun q => same (of_terms q) p) given.
Fixpoint denominators m n (e : expression m n) : seq polynomial := match e with
  | Entries _ _ _ below => [:: below]
  | Transpose _ _ e => denominators e
  | Times _ _ _ e f => denominators e ++ denominators f
  | Plus _ _ e f => denominators e ++ denominators f
  | Minus _ _ e f => denominators e ++ denominators f
  | Scale _ _ _ e => denominators e
  end.
Definition is_defined (given : seq polynomial) m n (e : expression m n) : bool :=
  all (fun p => admitted given (of_terms p)) (denominators e).

(* c e = quotients * modulus, entry by entry; where nothing is adjoined the modulus is [::], which is 0. *)
Definition vanishes given (modulus : polynomial) (c : Z) (quotients : rows) m n (e : expression m n) : bool :=
  let l := (computed e).1 in let d := of_terms modulus in
  [&& is_defined given e, ~~ Z.eqb c Z0 &
      every m n (fun i j => same (times (constant c) (cell l i j)) (times (of_terms (entry quotients i j)) d))].

(* M adjugate = determinant. *)
Definition is_regular given (adjugate : rows) (determinant : polynomial) n (e : expression n n) : bool :=
  let l := (computed e).1 in let d := of_terms determinant in
  [&& is_defined given e, admitted given d &
      every n n (fun i j => same (total n (fun k => times (cell l i k) (of_terms (entry adjugate k j))))
                                 (if (i == j)%N then d else zero))].

(* The recursion of TraceRecursion.v for N / d: lift is d^(n-1-k), B is d^(n-1-k) B_k. *)
Definition trace n (l : table) : horner := total n (fun i => cell l i i).
Fixpoint recursion n (N : table) (d : horner) (B : table) (lift c : horner) (cs : seq horner) : bool :=
  match cs with
  | [::] => every n n (fun i j => same (cell B i j) zero)
  | f :: fs =>
      same (trace n B) (times (constant (Z.of_nat (size cs))) (times lift c)) &&
      (let lift' := times d lift in let s := times lift' f in
       recursion n N d (let l := table_times n n n N B in
           tabulate n n (fun i j => if (i == j)%N then plus (cell l i j) s else cell l i j)) lift' f fs)
  end.

(* The polynomial is 1 x 1, in the first symbol; its coefficients, descending, have the other ones. *)
Definition has_spectrum given n (e : expression n n) (p : expression 1 1) (c : polynomial) (cs : seq polynomial) :=
  let: (l, d) := computed e in
  let inner q := mkPinj xH (of_terms q) in
  let lead := inner c in let rest := map inner cs in
  let power := foldl (fun q f => plus (mkPX Z0 Z.eqb q xH zero) f) lead rest in
  [&& is_defined given e, is_defined given p, size cs == n, admitted given lead,
      same (cell (computed p).1 0 0) power, same (product (computed p).2) lead &
      recursion n l (product d) (tabulate n n (fun i j => if (i == j)%N then lead else zero)) one lead rest].

Section Soundness.
Variable F : fieldType.
Local Notation integer := (integer F).
Implicit Types (x : seq F).

Definition horner_at x (p : horner) : F := Pphi 0 +%R *%R integer x p.
Definition table_at x m n (l : table) : 'M[F]_(m, n) := \matrix_(i, j) horner_at x (cell l i j).

Lemma integer_ring : ring_theory 0 1 +%R *%R (fun a b : F => a - b) -%R eq.
Proof.
split=> //=; [exact: add0r | exact: addrC | exact: addrA | exact: mul1r | exact: mulrC | exact: mulrA
  | exact: mulrDl | exact: addrN].
Qed.

Lemma integerD a b : integer (Z.add a b) = integer a + integer b.
Proof. by rewrite /integer -rmorphD -(rmorphD [rmorphism of int_of_Z]). Qed.
Lemma integerN a : integer (Z.opp a) = - integer a.
Proof. by rewrite /integer -rmorphN -(rmorphN [rmorphism of int_of_Z]). Qed.
Lemma integerB a b : integer (Z.sub a b) = integer a - integer b.
Proof. by rewrite /integer -rmorphB -(rmorphB [rmorphism of int_of_Z]). Qed.
Lemma integerM a b : integer (Z.mul a b) = integer a * integer b.
Proof. by rewrite /integer -rmorphM -(rmorphM [rmorphism of int_of_Z]). Qed.
Lemma integer1 : integer (Zpos xH) = 1. Proof. by []. Qed.
Lemma integer0 : integer Z0 = 0. Proof. by []. Qed.

Lemma integer_morphism : ring_morph 0 1 +%R *%R (fun a b : F => a - b) -%R eq
  Z0 (Zpos xH) Z.add Z.mul Z.sub Z.opp Z.eqb integer.
Proof.
split=> //; [exact: integerD | exact: integerB | exact: integerM | exact: integerN |].
by move=> a b /Z.eqb_eq->.
Qed.

Let extension := Eq_ext +%R *%R (@GRing.opp F).
Let almost := Rth_ARth (Eqsth F) extension integer_ring.

Lemma horner_at_plus x p q : horner_at x (plus p q) = horner_at x p + horner_at x q.
Proof. exact: (Padd_ok (Eqsth F) extension almost integer_morphism). Qed.
Lemma horner_at_times x p q : horner_at x (times p q) = horner_at x p * horner_at x q.
Proof. exact: (Pmul_ok (Eqsth F) extension almost integer_morphism). Qed.
Lemma horner_at_same x p q : same p q -> horner_at x p = horner_at x q.
Proof. by move=> E; apply: (Peq_ok (Eqsth F) extension integer_morphism). Qed.
Lemma horner_at_constant x c : horner_at x (constant c) = integer c. Proof. by []. Qed.
Lemma horner_at_zero x : horner_at x zero = 0. Proof. by []. Qed.
Lemma horner_at_one x : horner_at x one = 1. Proof. by []. Qed.

Lemma head_behead x : List.hd 0 x = head 0 x /\ List.tl x = behead x. Proof. by case: x. Qed.

Lemma power_positive (a : F) e : pow_pos *%R a (Pos.of_succ_nat e) = a ^+ e.+1.
Proof.
elim: e => [|e IH]; first by rewrite expr1.
have proper : Morphisms.Proper (Morphisms.respectful eq (Morphisms.respectful eq eq)) ( *%R : F -> F -> F).
  by move=> a1 a2 -> b1 b2 ->.
by rewrite [Pos.of_succ_nat _]/= (pow_pos_succ (Eqsth F) proper (@mulrA F)) IH -exprS.
Qed.

Lemma horner_at_inner x p : horner_at x (mkPinj xH p) = horner_at (behead x) p.
Proof. by rewrite /horner_at (mkPinj_ok _ _ _ (Eqsth F)) /=; have [_ ->] := head_behead x. Qed.

Lemma horner_at_step x p e q :
  horner_at x (mkPX Z0 Z.eqb p (Pos.of_succ_nat e) q) = horner_at x p * head 0 x ^+ e.+1 + horner_at (behead x) q.
Proof.
rewrite /horner_at (mkPX_ok (Eqsth F) extension almost integer_morphism) power_positive.
by have [-> ->] := head_behead x.
Qed.

Lemma horner_at_monomial x c es : horner_at x (monomial c es) = integer c * power_product x es.
Proof.
elim: es x => [|[|e] es IH] x /=; first by rewrite mulr1.
  by rewrite horner_at_inner IH expr0 mul1r.
by rewrite horner_at_step horner_at_inner IH horner_at_zero addr0 mulrAC mulrA.
Qed.

Lemma horner_at_of_terms x p : horner_at x (of_terms p) = polynomial_at x p.
Proof.
rewrite /polynomial_at; elim: p => [|t p IH]; first by rewrite big_nil.
by rewrite big_cons -IH /= horner_at_plus horner_at_monomial.
Qed.

Lemma cell_tabulate m n f i j : (i < m)%N -> (j < n)%N -> cell (tabulate m n f) i j = f i j.
Proof. by move=> i_m j_n; rewrite /cell /tabulate !nth_mkseq. Qed.

Lemma everyP m n f (i : 'I_m) (j : 'I_n) : every m n f -> f i j.
Proof.
move=> /allP all_rows; have /allP : all (f i) (iota 0 n) by apply: all_rows; rewrite mem_iota /=.
by apply; rewrite mem_iota /=.
Qed.

Lemma table_at_tabulate x m n f : table_at x m n (tabulate m n f) = \matrix_(i, j) horner_at x (f i j).
Proof. by apply/matrixP=> i j; rewrite !mxE cell_tabulate. Qed.

Lemma horner_at_total x n f : horner_at x (total n f) = \sum_(k < n) horner_at x (f k).
Proof.
rewrite /total -(big_mkord xpredT (fun k => horner_at x (f k))) /index_iota subn0.
elim: (iota 0 n) => [|k s IH]; first by rewrite big_nil.
by rewrite big_cons /= horner_at_plus IH.
Qed.

Lemma table_at_times x m n p a b :
  table_at x m p (table_times m n p a b) = table_at x m n a *m table_at x n p b.
Proof.
rewrite table_at_tabulate; apply/matrixP=> i j; rewrite !mxE horner_at_total.
by apply: eq_bigr => k _; rewrite !mxE horner_at_times.
Qed.

Lemma horner_at_product x ps qs : horner_at x (product (ps ++ qs)) = horner_at x (product ps) * horner_at x (product qs).
Proof.
elim: ps => [|p ps IH] /=; first by rewrite mul1r.
by rewrite !horner_at_times IH mulrA.
Qed.

Lemma without_product x p ps rest : without p ps = Some rest ->
  horner_at x (product ps) = horner_at x p * horner_at x (product rest).
Proof.
elim: ps rest => [//|q qs IH] rest /=; have [E|_] := boolP (same p q).
  by move=> [<-]; rewrite horner_at_times (horner_at_same x E).
case: (without p qs) IH => //= s IH [<-].
by rewrite !horner_at_times (IH _ erefl) mulrCA.
Qed.

Lemma differences_product x a b : horner_at x (product a) * horner_at x (product (differences a b).2)
  = horner_at x (product b) * horner_at x (product (differences a b).1).
Proof.
elim: a b => [|p ps IH] b /=; first by rewrite mulrC.
case E: (without p b) => [rest|].
  by rewrite (without_product x E) horner_at_times -!mulrA IH.
have := IH b; case: (differences ps b) => l r /= {}IH.
by rewrite !horner_at_times mulrCA -IH; ring.
Qed.

Lemma differences_nonzero x a b : horner_at x (product b) != 0 -> horner_at x (product (differences a b).2) != 0.
Proof.
elim: a b => [|p ps IH] b //= nz; case E: (without p b) => [rest|].
  by apply: IH; move: nz; rewrite (without_product x E) mulf_eq0 => /norP[].
by have := IH b nz; case: (differences ps b).
Qed.

Hypothesis char0 : [char F] =i pred0.

Lemma integer_eq0 c : (integer c == 0) = Z.eqb c Z0.
Proof.
have nat_nz k : k.+1%:R != 0 :> F by rewrite ((charf0P F).1 char0).
rewrite /CertifiedEquations.integer; have -> : Z.eqb c Z0 = (int_of_Z c == 0) by lia.
case: (int_of_Z c) => [[|k]|k]; first by rewrite eqxx.
  by rewrite (negPf (nat_nz k)).
by rewrite NegzE mulrNz oppr_eq0 (negPf (nat_nz k)).
Qed.

Lemma number_is_nonzero x p : is_number p -> horner_at x p != 0.
Proof. by case: p => // c; rewrite /= /horner_at /= integer_eq0. Qed.

Lemma admitted_nonzero x given p : nonzero_at x given -> admitted given p -> horner_at x p != 0.
Proof.
move=> /allP nonzero /orP[|/hasP[q q_given /(horner_at_same x)<-]]; first exact: number_is_nonzero.
by rewrite horner_at_of_terms nonzero.
Qed.

Lemma defined_below x given m n (e : expression m n) : nonzero_at x given -> is_defined given e ->
  all (fun p => polynomial_at x p != 0) (denominators e).
Proof.
move=> nonzero; apply: sub_all => p /(admitted_nonzero nonzero).
by rewrite horner_at_of_terms.
Qed.

Lemma joined_sound x m n sign (e f : table * seq horner) :
  horner_at x (product e.2) != 0 -> horner_at x (product f.2) != 0 ->
  horner_at x (product (joined m n sign e f).2) != 0 /\
  (horner_at x (product (joined m n sign e f).2))^-1 *: table_at x m n (joined m n sign e f).1
  = (horner_at x (product e.2))^-1 *: table_at x m n e.1
    + integer sign *: ((horner_at x (product f.2))^-1 *: table_at x m n f.1).
Proof.
case: e f => [l d] [k c] /= nz_d nz_c.
have := differences_product x d c; have := differences_nonzero d nz_c.
case: (differences d c) => u v /= nz_v E; rewrite horner_at_product.
have nz_u : horner_at x (product u) != 0.
  by apply: contraTneq (mulf_neq0 nz_d nz_v) => u0; rewrite E u0 mulr0 eqxx.
split; first exact: mulf_neq0.
apply/matrixP=> i j; rewrite table_at_tabulate !mxE horner_at_plus !horner_at_times horner_at_constant mulrDr.
congr (_ + _); first by rewrite mulrA invfM mulrVK // unitfE.
rewrite E; move: (horner_at x (product c)) (horner_at x (product u)) nz_c nz_u => a b nz_a nz_b.
by field; rewrite nz_a nz_b.
Qed.

(* What is computed of an expression is a table over its denominators. *)
Theorem computed_sound x m n (e : expression m n) : nonzero_at x (denominators e) ->
  horner_at x (product (computed e).2) != 0 /\
  at_ x e = (horner_at x (product (computed e).2))^-1 *: table_at x m n (computed e).1.
Proof.
elim: e => {m n} [m n r below|m n e IH|m n p e IHe f IHf|m n e IHe f IHf|m n e IHe f IHf|m n c e IH] /=.
- rewrite /nonzero_at /= andbT -horner_at_of_terms table_at_tabulate => nz; split.
    by case: ifP => _; rewrite /= ?oner_neq0 // horner_at_times horner_at_one mulr1.
  have -> : horner_at x (product (if same (of_terms below) one then [::] else [:: of_terms below]))
      = horner_at x (of_terms below).
    by case: ifP => [/(horner_at_same x)->|_] //=; rewrite horner_at_times horner_at_one mulr1.
  by congr (_ *: _); apply/matrixP=> i j; rewrite !mxE horner_at_of_terms.
- move=> /IH; case: (computed e) => l d /= [nz ->]; split=> //.
  by rewrite linearZ /= table_at_tabulate; congr (_ *: _); apply/matrixP=> i j; rewrite !mxE.
- rewrite /nonzero_at all_cat => /andP[/IHe {}IHe /IHf {}IHf].
  case: (computed e) IHe => l d /= [nz_d ->]; case: (computed f) IHf => k c /= [nz_c ->].
  rewrite horner_at_product mulf_neq0 //; split=> //.
  by rewrite table_at_times -scalemxAl -scalemxAr scalerA invfM.
- rewrite /nonzero_at all_cat => /andP[/IHe[nz_d ->] /IHf[nz_c ->]].
  by have [nz ->] := joined_sound m n (Zpos xH) nz_d nz_c; rewrite scale1r.
- rewrite /nonzero_at all_cat => /andP[/IHe[nz_d ->] /IHf[nz_c ->]].
  by have [nz ->] := joined_sound m n (Zneg xH) nz_d nz_c; rewrite scaleN1r.
- move=> /IH; case: (computed e) => l d /= [nz ->]; split=> //.
  rewrite scalerA mulrC -scalerA; congr (_ *: _); rewrite table_at_tabulate.
  by apply/matrixP=> i j; rewrite !mxE horner_at_times.
Qed.

Lemma defined_computed x given m n (e : expression m n) : nonzero_at x given -> is_defined given e ->
  horner_at x (product (computed e).2) != 0 /\
  at_ x e = (horner_at x (product (computed e).2))^-1 *: table_at x m n (computed e).1.
Proof. by move=> nonzero /(defined_below nonzero) /computed_sound. Qed.

(* Equations between matrices, identically in the symbols; or for a root of the modulus. *)
Theorem certified_equation x given modulus c quotients m n (e : expression m n) :
  nonzero_at x given -> polynomial_at x modulus = 0 -> vanishes given modulus c quotients e ->
  at_ x e = 0.
Proof.
move=> nonzero root /and3P[defined nz_c equal].
have [_ ->] := defined_computed nonzero defined; apply/matrixP=> i j; rewrite !mxE.
have := horner_at_same x (everyP i j equal); rewrite !horner_at_times !horner_at_of_terms root mulr0 horner_at_constant.
by move/eqP; rewrite mulf_eq0 integer_eq0 (negPf nz_c) => /eqP->; rewrite mulr0.
Qed.

(* The same as two sides. *)
Definition agree given modulus (c : Z) (quotients : rows) m n (e f : expression m n) : bool :=
  vanishes given modulus c quotients (Minus e f).

Corollary certified_equality x given modulus c quotients m n (e f : expression m n) :
  nonzero_at x given -> polynomial_at x modulus = 0 -> agree given modulus c quotients e f ->
  at_ x e = at_ x f.
Proof. by move=> nonzero root /(certified_equation nonzero root) /= /eqP; rewrite subr_eq0 => /eqP. Qed.

Theorem certified_regular x given adjugate determinant n (e : expression n n) :
  nonzero_at x given -> is_regular given adjugate determinant e -> at_ x e \in unitmx.
Proof.
move=> nonzero /and3P[defined nz_d equal].
have [nz ->] := defined_computed nonzero defined.
have {}nz_d := admitted_nonzero nonzero nz_d; rewrite horner_at_of_terms in nz_d.
rewrite unitmxZ ?unitfE ?invr_eq0 //; set M := table_at _ _ _ _.
pose X := (polynomial_at x determinant)^-1 *: entries_at x n n adjugate.
suff /mulmx1_unit[] : M *m X = 1%:M by [].
rewrite -scalemxAr; apply/matrixP=> i j; rewrite !mxE.
have := horner_at_same x (everyP i j equal); rewrite horner_at_total.
rewrite (eq_bigr (fun k => M i k * entries_at x n n adjugate k j)) => [->|k _]; last first.
  by rewrite /= horner_at_times horner_at_of_terms !mxE.
rewrite -[i == j]/(i == j :> nat); case: eqP => _; last by rewrite mulr0.
by rewrite horner_at_of_terms mulVf.
Qed.

Lemma horner_at_trace x n l : horner_at x (trace n l) = \tr (table_at x n n l).
Proof. by rewrite horner_at_total; apply: eq_bigr => i _; rewrite mxE. Qed.

Lemma recursion_sound x n N d B lift c cs a : horner_at x d != 0 -> horner_at x lift != 0 -> a != 0 ->
  recursion n N d B lift c cs ->
  traces_agree ((horner_at x d)^-1 *: table_at x n n N) ((a * horner_at x lift)^-1 *: table_at x n n B)
    (horner_at x c / a) [seq horner_at x f / a | f <- cs].
Proof.
move=> nz_d; elim: cs B lift c => [|f fs IH] B lift c nz_lift nz_a.
  move=> zero_B; have {}zero_B : every n n (fun i j => same (cell B i j) zero) := zero_B.
  rewrite /=; have -> : table_at x n n B = 0.
    by apply/matrixP=> i j; rewrite !mxE (horner_at_same x (everyP i j zero_B)).
  by rewrite scaler0 eqxx.
case/andP=> /(horner_at_same x); rewrite horner_at_trace !horner_at_times horner_at_constant => trace_B /IH {}IH /=.
apply/andP; split.
  rewrite linearZ /= trace_B size_map -mulr_natr; apply/eqP.
  have -> : integer (Z.of_nat (size fs).+1) = (size fs).+1%:R.
    by rewrite /CertifiedEquations.integer; have -> : int_of_Z (Z.of_nat (size fs).+1) = (size fs).+1 by lia.
  by move: (_%:R) (horner_at x c) => k u; field; rewrite nz_a nz_lift.
have := IH _ nz_a; rewrite horner_at_times => /(_ (mulf_neq0 nz_d nz_lift)).
congr traces_agree; rewrite table_at_tabulate -scalemxAl -scalemxAr scalerA -invfM.
have -> : \matrix_(i < n, j < n) horner_at x (if (i == j :> nat)%N
    then plus (cell (table_times n n n N B) i j) (times (times d lift) f)
    else cell (table_times n n n N B) i j)
  = table_at x n n N *m table_at x n n B + (horner_at x d * horner_at x lift * horner_at x f)%:M.
  rewrite -table_at_times; apply/matrixP=> i j; rewrite !mxE -[i == j]/(i == j :> nat).
  by case: eqP => _; rewrite ?mulr0n ?addr0 // horner_at_plus !horner_at_times.
rewrite scalerDr scale_scalar_mx; congr (_ *: _ + _%:M); first by rewrite mulrCA.
by field; rewrite nz_a nz_d nz_lift.
Qed.

(* The characteristic polynomial; M is taken where the first symbol, which it does not have, is 0. *)
Theorem certified_spectrum (s : F) y given n (e : expression n n) p c cs :
  nonzero_at (0 :: y) given -> nonzero_at (s :: y) given -> has_spectrum given e p c cs ->
  (char_poly (at_ (0 :: y) e)).[s] = at_ (s :: y) p 0 0.
Proof.
move=> nonzero_0 nonzero_s; rewrite /has_spectrum.
case E: (computed e) => [l d]; case/and5P=> defined_e defined_p /eqP size_cs nz_c.
case/and3P=> /(horner_at_same (s :: y)) power /(horner_at_same (s :: y)) below.
pose a := polynomial_at y c; have inner t q : horner_at (t :: y) (mkPinj xH (of_terms q)) = polynomial_at y q.
  by rewrite horner_at_inner horner_at_of_terms.
have nz_a : a != 0 by have := admitted_nonzero nonzero_0 nz_c; rewrite inner.
have [] := defined_computed nonzero_0 defined_e; rewrite E /= => nz_d ->.
have [_ ->] := defined_computed nonzero_s defined_p; rewrite !mxE power below inner -/a.
move/(@recursion_sound (0 :: y) _ _ _ _ _ _ _ a nz_d); rewrite horner_at_one oner_neq0 nz_a => /(_ isT isT).
rewrite inner divff // mulr1 table_at_tabulate.
have -> : \matrix_(i < n, j < n) horner_at (0 :: y) (if (i == j :> nat)%N then mkPinj xH (of_terms c) else zero)
    = a%:M.
  apply/matrixP=> i j; rewrite !mxE -[i == j]/(i == j :> nat).
  by case: eqP => _; rewrite ?horner_at_zero ?mulr0n // inner.
rewrite scale_scalar_mx mulVf // => /(char_poly_by_traces char0) ->; last by rewrite !size_map.
rewrite -map_comp; have start : horner_at (s :: y) (mkPinj xH (of_terms c)) = a * (1 : {poly F}).[s].
  by rewrite inner hornerC mulr1.
elim: cs {size_cs power} (mkPinj xH (of_terms c)) (1 : {poly F}) start => [|f fs IH] q r start /=.
  by rewrite start mulKf.
apply: IH; rewrite horner_at_plus !(horner_at_step _ _ 0) horner_at_zero addr0 expr1 start.
by rewrite !inner hornerD hornerMX hornerC /= mulrDr mulrA [a * (_ / _)]mulrC divfK.
Qed.
End Soundness.
