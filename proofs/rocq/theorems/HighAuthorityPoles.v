(* Where high-authority LQG puts the regulator's poles: (A.15) corrected, and the closed form of
   B'PB. (A.16) is the same for the transposed system. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import ReturnDifference.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* s^n p(1/s) for polynomials of degree at most n. *)
Section Reversed.
Variable R : fieldType.
Implicit Types p q : {poly R}.

Definition reversed n p : {poly R} := \poly_(i < n.+1) p`_(n - i).

Lemma reversed_at n p x : degree_at_most p n -> x != 0 ->
  (reversed n p).[x] = x ^+ n * p.[x^-1].
Proof.
move=> deg_p nz_x; rewrite horner_poly (horner_coef_wide _ deg_p) mulr_sumr.
rewrite (reindex_inj rev_ord_inj) /=; apply: eq_bigr => i _.
have i_n : (i <= n)%N by rewrite -ltnS ltn_ord.
rewrite subSS subKn // mulrCA; congr (_ * _).
by rewrite exprVn -expfB_cond // (negPf nz_x) add0n.
Qed.

(* Two polynomials that agree at all points but 0 are equal, over an infinite field. *)
Lemma poly_eq_off_0 (K : numFieldType) (p q : {poly K}) :
  (forall x, x != 0 -> p.[x] = q.[x]) -> p = q.
Proof.
move=> same; apply/eqP; rewrite -subr_eq0; apply/negP=> /negP nz.
pose points := [seq (i.+1)%:R : K | i <- iota 0 (size (p - q))].
have : (size points < size (p - q)%R)%N.
  apply: max_poly_roots => //; last first.
    by rewrite map_inj_uniq ?iota_uniq // => i j /eqP; rewrite eqr_nat eqSS => /eqP.
  apply/allP=> _ /mapP[i _ ->]; rewrite rootE hornerD hornerN same ?subrr //.
  by rewrite pnatr_eq0.
by rewrite size_map size_iota ltnn.
Qed.

Lemma size_reversed n p : degree_at_most (reversed n p) n.
Proof. exact: size_poly. Qed.

Lemma reversed_0 n p : (reversed n p).[0] = p`_n.
Proof. by rewrite horner_coef0 coef_poly subn0. Qed.

Lemma lead_reversed n p : (reversed n p)`_n = p.[0].
Proof. by rewrite coef_poly ltnSn subnn horner_coef0. Qed.
End Reversed.

Section ReversedProducts.
Variable R : numFieldType.
Implicit Types p q : {poly R}.

Lemma reversed_mul m n p q : degree_at_most p m -> degree_at_most q n ->
  reversed (m + n) (p * q) = reversed m p * reversed n q.
Proof.
move=> deg_p deg_q; apply: poly_eq_off_0 => x nz_x.
rewrite hornerM !reversed_at ?hornerM ?exprD //; first by rewrite mulrACA.
rewrite (leq_trans (size_mul_leq _ _)) //.
by move: (size p) (size q) deg_p deg_q; lia.
Qed.

Lemma reversed_wide m n p : degree_at_most p m -> reversed (n + m) p = 'X^n * reversed m p.
Proof.
move=> deg_p; apply: poly_eq_off_0 => x nz_x.
rewrite hornerM hornerXn !reversed_at ?exprD ?mulrA //.
by rewrite (leq_trans deg_p) // ltnS leq_addl.
Qed.
End ReversedProducts.

Section Poles.
Variable R : rcfType.
Implicit Types p q chi N_s N_u : {poly R}.
Local Notation complex_roots p := (root (map_poly (real_complex R) p)).

(* All zeros strictly inside, or all strictly outside, the unit circle. *)
Definition inside p := forall z : R[i], complex_roots p z -> `|z| < 1.
Definition outside p := forall z : R[i], complex_roots p z -> 1 < `|z|.

Lemma apart p q : p != 0 -> inside p -> outside q -> coprimep p q.
Proof.
move=> nz_p in_p out_q; rewrite -(coprimep_map [rmorphism of real_complex R]).
apply: Pdiv.ClosedField.root_coprimep => z root_p; apply/negP=> root_q.
by have := lt_trans (in_p z root_p) (out_q z root_q); rewrite ltxx.
Qed.

Lemma root_real p x : root p x -> complex_roots p (x%:C)%C.
Proof. by rewrite (fmorph_root [rmorphism of real_complex R]). Qed.

Lemma outside_0 q : outside q -> q.[0] != 0.
Proof.
move=> out_q; apply/negP=> /eqP root_0.
have : complex_roots q 0 by apply: (@root_real q 0); rewrite rootE root_0.
by move/out_q; rewrite normr0 ltr10.
Qed.

(* Reversal takes the zeros inside to the outside. *)
Lemma outside_reversed n p : p \is monic -> degree_is p n -> inside p -> outside (reversed n p).
Proof.
move=> monic_p deg_p in_p z; have leading : p`_n = 1.
  by move: monic_p; rewrite monicE lead_coefE deg_p => /eqP.
have mapped : map_poly (real_complex R) (reversed n p)
            = reversed n (map_poly (real_complex R) p).
  apply/polyP=> i; rewrite [LHS]coef_map_id0 // [in RHS]coef_poly [in RHS]coef_map_id0 // coef_poly.
  by case: ifP.
have [->|nz_z] := eqVneq z 0.
  by rewrite rootE mapped reversed_0 coef_map_id0 // leading oner_eq0.
rewrite rootE mapped reversed_at ?size_map_poly ?deg_p // mulf_eq0 expf_eq0 (negPf nz_z) andbF /=.
move/in_p; rewrite normfV invf_lt1 ?normr_gt0 //.
Qed.

(* chi with zeros inside, W chi(x) chi(1/x) = N(x) N(1/x), N = H N_s N_u: the zeros of chi are those
   of N_s, the reciprocals of those of N_u, and zeros at 0. *)
Theorem spectral_factor k l d W H chi N_s N_u :
  chi \is monic -> degree_is chi (d + (k + l)) -> inside chi ->
  N_s \is monic -> degree_is N_s k -> inside N_s ->
  N_u \is monic -> degree_is N_u l -> outside N_u -> H != 0 ->
  (forall x, x != 0 -> W * (chi.[x] * chi.[x^-1])
     = (H *: (N_s * N_u)).[x] * (H *: (N_s * N_u)).[x^-1]) ->
  N_u.[0] *: chi = 'X^d * (N_s * reversed l N_u) /\ W = (H * N_u.[0]) ^+ 2.
Proof.
move=> monic_chi deg_chi in_chi monic_s deg_s in_s monic_u deg_u out_u nz_H factored.
set n := (d + (k + l))%N in deg_chi.
have identity : W *: (chi * reversed n chi)
    = (H ^+ 2) *: ('X^d * (N_s * reversed l N_u) * (N_u * reversed k N_s)).
  apply: poly_eq_off_0 => x nz_x; have := factored x nz_x.
  have deg_N : degree_at_most (N_s * N_u) (k + l).
    by rewrite (leq_trans (size_mul_leq _ _)) // deg_s deg_u addnS.
  have reversed_N : reversed k N_s * reversed l N_u = reversed (k + l) (N_s * N_u).
    by rewrite reversed_mul ?deg_s ?deg_u.
  rewrite !hornerZ !hornerM hornerXn !reversed_at ?deg_chi ?deg_s ?deg_u // => same.
  transitivity (x ^+ n * (W * (chi.[x] * chi.[x^-1]))).
    by rewrite [RHS]mulrCA [x ^+ n * (_ * _)]mulrCA.
  rewrite same /n !exprD; move: (x ^+ d) (x ^+ k) (x ^+ l) N_s.[x] N_u.[x] N_s.[x^-1] N_u.[x^-1].
  by move=> *; ring.
have nz_chi : chi != 0 by rewrite monic_neq0.
have nz_0 := outside_0 out_u.
have apart_1 : coprimep chi N_u by apply: apart.
have apart_2 : coprimep chi (reversed k N_s) by apply/apart/outside_reversed.
have nz_H2 : H ^+ 2 != 0 by rewrite expf_neq0.
set product := 'X^d * (N_s * reversed l N_u) in identity *.
have divides : chi %| product.
  have coprime_rest : coprimep chi (N_u * reversed k N_s) by rewrite coprimepMr apart_1.
  rewrite -(Gauss_dvdpl _ coprime_rest) -(dvdpZr _ _ nz_H2) -identity.
  by rewrite -mul_polyC dvdp_mull // dvdp_mulr.
have [q Eq] := dvdpP _ _ divides.
have lead_u : (reversed l N_u)`_l = N_u.[0] by apply: lead_reversed.
have size_u : size (reversed l N_u) = l.+1.
  apply/eqP; rewrite eqn_leq size_reversed ltnNge; apply/negP=> short.
  by move: nz_0; rewrite -lead_u nth_default ?eqxx.
have size_product : size product = n.+1.
  have nz_r : reversed l N_u != 0 by rewrite -size_poly_gt0 size_u.
  have nz_s : N_s != 0 by rewrite monic_neq0.
  rewrite /product !size_mul ?mulf_neq0 // ?monic_neq0 ?monicXn // size_polyXn deg_s size_u /n.
  by rewrite addnS /= addSn; apply: addnS.
have q_constant : q = N_u.[0]%:P.
  have nz_q : q != 0.
    by apply/negP=> /eqP q0; move: size_product; rewrite Eq q0 mul0r size_poly0.
  have size_q : size q = 1%N.
    have : (size q + n.+1).-1 = n.+1 by rewrite -deg_chi -size_Mmonic // -Eq size_product.
    by move: (size q) (n); clear; lia.
  case/eqP/size_poly1P: size_q => a nz_a Ea; rewrite Ea; congr _%:P.
  have : lead_coef product = lead_coef q by rewrite Eq lead_coef_Mmonic.
  rewrite Ea lead_coefC => <-; rewrite /product !lead_coefM lead_coefXn mul1r.
  by rewrite (monicP monic_s) mul1r lead_coefE size_u.
have Eproduct : product = N_u.[0] *: chi by rewrite Eq q_constant mul_polyC.
split; first by rewrite -Eproduct.
(* cancel chi, and look at 0 *)
have : W *: reversed n chi = (H ^+ 2 * N_u.[0]) *: (N_u * reversed k N_s).
  apply: (mulfI nz_chi); move: identity; rewrite Eproduct -scalerAr => ->.
  by rewrite -scalerAl scalerA -scalerAr.
move/(congr1 (fun p : {poly R} => p.[0])); rewrite !hornerZ hornerM !reversed_0.
have lead p m : p \is monic -> degree_is p m -> p`_m = 1.
  by move=> monic_p deg_p; move: monic_p; rewrite monicE lead_coefE deg_p => /eqP.
by rewrite (lead chi) // (lead N_s) // !mulr1 => ->; move: N_u.[0] => a; ring.
Qed.
End Poles.

(* (A.15) corrected. P is the stabilising solution of (A.7), N_zu = H N_s N_u with monic N_s and
   N_u of degrees k and l, and d = n - k - l. The printed exponent of z lacks l, and the monic
   polynomial is N_s times the reversal of N_u over N_u(0). For R_2 = 0 the second conclusion is
   B'PB = (H N_u(0))^2, the square of H times the product of the zeros outside. *)
Theorem poles_of_high_authority_lqg (R : rcfType) n (A P : 'M[R]_n) (B : 'cV[R]_n)
    (E_1 K : 'rV[R]_n) (E_2 H : R) k l d (N_s N_u : {poly R}) :
  let W := E_2 ^+ 2 + (B^T *m P *m B) 0 0 in
  let chi := char_poly (A + B *m K) in
  P^T = P -> W *: K = - (E_2 *: E_1 + B^T *m P *m A) ->
  P = A^T *m P *m A + E_1^T *m E_1 - W *: (K^T *m K) ->
  inside chi ->
  full_numerator A B E_1 E_2 = H *: (N_s * N_u) -> H != 0 -> n = (d + (k + l))%N ->
  N_s \is monic -> degree_is N_s k -> inside N_s ->
  N_u \is monic -> degree_is N_u l -> outside N_u ->
  N_u.[0] *: chi = 'X^d * (N_s * reversed l N_u) /\ W = (H * N_u.[0]) ^+ 2.
Proof.
move=> W chi symmetric gain riccati in_chi N_zu nz_H n_split monic_s deg_s in_s monic_u deg_u out_u.
apply: (spectral_factor (k := k) (l := l) (d := d) (W := W) (H := H)) => //.
- exact: char_poly_monic.
- by rewrite size_char_poly n_split.
move=> x nz_x; rewrite -N_zu; have x_x : x * x^-1 = 1 by rewrite mulfV.
exact: (spectral_factorisation symmetric gain riccati x_x).
Qed.

(* (A.16) corrected, with N_yw = C adj(zI - A) D_1 + D_2 det(zI - A). Q is the stabilising solution
   of (A.8), B_c its gain: A - B_c C is the transpose of a regulator for (A', C', D_1'). *)
Theorem poles_of_high_authority_observer (R : rcfType) n (A Q : 'M[R]_n) (C : 'rV[R]_n)
    (D_1 B_c : 'cV[R]_n) (D_2 H : R) k l d (N_s N_u : {poly R}) :
  let W := D_2 ^+ 2 + (C *m Q *m C^T) 0 0 in
  let chi := char_poly (A - B_c *m C) in
  Q^T = Q -> W *: B_c = D_2 *: D_1 + A *m Q *m C^T ->
  Q = A *m Q *m A^T + D_1 *m D_1^T - W *: (B_c *m B_c^T) ->
  inside chi ->
  full_numerator A D_1 C D_2 = H *: (N_s * N_u) -> H != 0 -> n = (d + (k + l))%N ->
  N_s \is monic -> degree_is N_s k -> inside N_s ->
  N_u \is monic -> degree_is N_u l -> outside N_u ->
  N_u.[0] *: chi = 'X^d * (N_s * reversed l N_u) /\ W = (H * N_u.[0]) ^+ 2.
Proof.
move=> W chi symmetric gain riccati in_chi N_yw nz_H n_split monic_s deg_s in_s monic_u deg_u out_u.
have Echi : chi = char_poly (A^T + C^T *m (- B_c^T)).
  by rewrite /chi -char_poly_tr [(A - _)^T]linearB /= trmx_mul mulmxN.
have N_dual : full_numerator A^T C^T D_1^T D_2 = H *: (N_s * N_u).
  by rewrite /full_numerator numerator_tr char_poly_tr.
have EW : W = D_2 ^+ 2 + ((C^T)^T *m Q *m C^T) 0 0 by rewrite trmxK.
rewrite Echi EW in in_chi *.
apply: (poles_of_high_authority_lqg symmetric _ _ in_chi N_dual nz_H n_split);
  rewrite ?trmxK -?EW //.
  rewrite scalerN -linearZ /= gain linearD linearZ /= !trmx_mul trmxK symmetric.
  by rewrite mulmxA.
by rewrite {1}riccati [(- B_c^T)^T]linearN /= trmxK mulNmx mulmxN opprK.
Qed.
