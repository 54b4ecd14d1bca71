(* The monic divisors of a product of powers of distinct irreducible polynomials: one for each
   choice of exponents. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section MonicDivisors.
Variables (R : fieldType) (I : finType) (p : I -> {poly R}).
Hypothesis monic_p : forall i, p i \is monic.
Hypothesis irreducible_p : forall i, irreducible_poly (p i).
Hypothesis distinct_p : injective p.
Implicit Types (d : {poly R}) (e m : I -> nat).

Lemma irreducible_degree i : (1 < size (p i))%N.
Proof. by have [] := irreducible_p i. Qed.

(* Two monic polynomials that divide each other's way are one: irreducible ones are coprime. *)
Lemma irreducible_dvd_or_coprime i d : p i %| d \/ coprimep (p i) d.
Proof.
have [_ only] := irreducible_p i.
have [c|/only same] := eqVneq (size (gcdp (p i) d)) 1%N; first by right; rewrite coprimep_def c.
by left; rewrite -(eqp_dvdl _ (same (dvdp_gcdl _ _))) dvdp_gcdr.
Qed.

Lemma monic_eq d d' : d \is monic -> d' \is monic -> d %| d' -> d' %| d -> d = d'.
Proof.
move=> monic_d monic_d' d_d' d'_d; apply/eqP; rewrite -eqp_monic //.
by rewrite /eqp d_d' d'_d.
Qed.

Lemma distinct_coprime i j : i != j -> coprimep (p i) (p j).
Proof.
move=> ij; have [dvd|//] := irreducible_dvd_or_coprime i (p j).
have [_ only] := irreducible_p j.
have same : p i %= p j by apply: only => //; rewrite gtn_eqF // irreducible_degree.
by case/eqP: ij; apply: distinct_p; apply/eqP; rewrite -eqp_monic.
Qed.

Definition product e := \prod_i p i ^+ e i.

Lemma product_monic e : product e \is monic.
Proof. by apply: monic_prod => i _; apply: monic_exp. Qed.

Lemma degree_product e : degree_is (product e) (\sum_i e i * (size (p i)).-1)%N.
Proof.
suff [_ ->] : product e \is monic /\ size (product e) = (\sum_i e i * (size (p i)).-1).+1 by [].
rewrite /product; elim/big_rec2: _ => [|i s q _ [monic_q size_q]].
  by rewrite monic1 size_poly1.
rewrite monicMl ?monic_exp //; split=> //.
rewrite size_monicM ?monic_exp ?monic_neq0 // size_q addnS /=.
by rewrite -[size (p i ^+ e i)]prednK ?size_exp 1?mulnC // size_poly_gt0 expf_neq0 // monic_neq0.
Qed.

Lemma product_split i e : product e = p i ^+ e i * \prod_(j | j != i) p j ^+ e j.
Proof. by rewrite /product (bigD1 i). Qed.

(* The exponent of p_i is the highest power of p_i that divides. *)
Lemma power_divides i k e : p i ^+ k %| product e -> (k <= e i)%N.
Proof.
rewrite (product_split i) Gauss_dvdpl => [dvd|]; last first.
  apply: coprimep_expl; elim/big_rec: _ => [|j q ji coprime_q]; first exact: coprimep1.
  rewrite coprimepMr coprime_q andbT.
  by apply/coprimep_expr/distinct_coprime; rewrite eq_sym.
have nz : p i ^+ e i != 0 by rewrite expf_neq0 // monic_neq0.
have : ((size (p i ^+ k)).-1 <= (size (p i ^+ e i)).-1)%N.
  by rewrite -!subn1 leq_sub2r // dvdp_leq.
by rewrite !size_exp leq_pmul2l // -ltnS prednK ?irreducible_degree // ltnW ?irreducible_degree.
Qed.

Theorem exponents_are_unique e e' : product e = product e' -> forall i, e i = e' i.
Proof.
move=> same i; apply/eqP; rewrite eqn_leq !power_divides //.
  by rewrite same (product_split i) dvdp_mulr.
by rewrite -same (product_split i) dvdp_mulr.
Qed.

Lemma product_raise i e : product (fun j => e j + (j == i))%N = p i * product e.
Proof.
rewrite !(product_split i) eqxx addn1 exprS -mulrA; congr (_ * (_ * _)).
by apply: eq_bigr => j /negPf->; rewrite addn0.
Qed.

(* Every monic divisor has exponents. *)
Theorem divisors_have_exponents m d : d \is monic -> d %| product m ->
  exists e, (forall i, e i <= m i)%N /\ d = product e.
Proof.
have [k] := ubnP (size d); elim: k d m => // k IH d m; rewrite ltnS => small monic_d divides.
have [/existsP[i p_d]|/existsPn none] := boolP [exists i, (p i %| d)%R]; last first.
  (* coprime to every p_i *)
  have : coprimep d (product m).
    rewrite /product; elim/big_rec: _ => [|i q _ coprime_q]; first exact: coprimep1.
    rewrite coprimepMr coprime_q andbT; apply: coprimep_expr; rewrite coprimep_sym.
    by have [] := irreducible_dvd_or_coprime i d => // dvd; have := none i; rewrite dvd.
  move/coprimepP/(_ d (dvdpp _) divides) => unit_d.
  exists (fun=> 0%N); split=> //; apply: monic_eq => //; rewrite ?product_monic //.
    by rewrite (eqp_dvdl _ unit_d) dvd1p.
  by rewrite /product big1 ?dvd1p // => i _; rewrite expr0.
have m_i : (0 < m i)%N.
  by apply: (@power_divides i 1); rewrite expr1 (dvdp_trans p_d).
pose m' j := (m j - (j == i))%N.
have raise : product m = p i * product m'.
  rewrite -product_raise; apply: eq_bigr => j _; rewrite /m' subnK //.
  by case: eqVneq => [->|].
have [q Eq] := dvdpP _ _ p_d.
have monic_q : q \is monic by rewrite -(monicMr _ (monic_p i)) -Eq.
have smaller : (size q < k)%N.
  apply: leq_trans small; rewrite Eq size_monicM ?monic_neq0 //.
  by case: (size (p i)) (irreducible_degree i) => [|[|s]] // _; rewrite !addnS /= ltnS leq_addr.
have [|e [below Ee]] := IH q m' smaller monic_q.
  have nz : p i != 0 by rewrite monic_neq0.
  by rewrite -(dvdp_mul2l _ _ nz) -raise mulrC -Eq.
exists (fun j => e j + (j == i))%N; split=> [j|]; last by rewrite product_raise -Ee mulrC.
have bounded : ((j == i) <= m j)%N by case: eqVneq => [->|].
by rewrite -(subnK bounded) leq_add2r below.
Qed.
End MonicDivisors.
