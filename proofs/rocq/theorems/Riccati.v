(* The stabilising solution of the Riccati equation (A.7): there is at most one, with every cross term
   and any number of signals; and for one input and scalar z = E_1 x + E_2 u there is one, where
   (A, B) is controllable and N_zu has no zero on the unit circle, R_2 = E_2^2 = 0 included. For any
   number of inputs and R_2 > 0 see StabilisingSolution. *)
From Compensators.foundations Require Import MathComp.
From mathcomp Require Import all_real_closed.
From Compensators.foundations Require Import Vocabulary Matrices.
From Compensators.theorems Require Import PolePlacement MinimalRealisations ReturnDifference.
From Compensators.theorems Require Import HighAuthorityPoles Stein.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.Theory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Difference.
Variables (R : comRingType) (n m : nat).
Variables (A R_1 : 'M[R]_n) (B R_12 : 'M[R]_(n, m)) (R_2 : 'M[R]_m).

(* R_2 + B'PB, and (A.6), (A.7) without an inverse. *)
Definition innovation_weight P := R_2 + B^T *m P *m B.
Definition solves_riccati P K := [/\ P^T = P,
    innovation_weight P *m K = - (R_12^T + B^T *m P *m A)
  & P = A^T *m P *m A + R_1 - K^T *m innovation_weight P *m K].

Hypothesis R_2_symmetric : R_2^T = R_2.

Theorem difference_of_solutions P K P' K' : solves_riccati P K -> solves_riccati P' K' ->
  P - P' = (A + B *m K)^T *m (P - P') *m (A + B *m K').
Proof.
have facts Z L : solves_riccati Z L ->
    [/\ B^T *m Z *m A = - (innovation_weight Z *m L) - R_12^T,
        A^T *m Z *m B = - (L^T *m innovation_weight Z) - R_12,
        B^T *m Z *m B = innovation_weight Z - R_2
      & A^T *m Z *m A = Z - R_1 + L^T *m innovation_weight Z *m L].
  case=> Z_T gain riccati.
  have W_T : (innovation_weight Z)^T = innovation_weight Z.
    by rewrite /innovation_weight linearD /= R_2_symmetric !trmx_mul trmxK Z_T mulmxA.
  have BZA : B^T *m Z *m A = - (innovation_weight Z *m L) - R_12^T.
    by rewrite gain opprK addrC addKr.
  split=> //.
  - have := congr1 trmx BZA; rewrite !trmx_mul trmxK Z_T mulmxA => ->.
    have sub_T (M N : 'M[R]_(m, n)) : (- M - N)^T = - M^T - N^T.
      by apply/matrixP=> i j; rewrite !mxE.
    by rewrite sub_T trmx_mul W_T trmxK.
  - by rewrite /innovation_weight addrC addKr.
  move: riccati; move: (L^T *m innovation_weight Z *m L) (A^T *m Z *m A) => b a E.
  by rewrite {1}E [a + R_1 - b - R_1]addrAC addrK subrK.
move=> /facts[BPA APB BPB APA] /facts[BPA' APB' BPB' APA'].
have -> : (A + B *m K)^T *m (P - P') *m (A + B *m K') =
    (A^T *m P *m A - A^T *m P' *m A) + (A^T *m P *m B - A^T *m P' *m B) *m K'
    + K^T *m (B^T *m P *m A - B^T *m P' *m A) + K^T *m (B^T *m P *m B - B^T *m P' *m B) *m K'.
  have -> : (A + B *m K)^T = A^T + K^T *m B^T by rewrite linearD /= trmx_mul.
  rewrite !(mulmxDl, mulmxDr, mulmxBl, mulmxBr, mulNmx, mulmxN) !mulmxA.
  move: (A^T *m P *m A) (A^T *m P' *m A) (A^T *m P *m B *m K') (A^T *m P' *m B *m K') => a b c d.
  move: (K^T *m B^T *m P *m A) (K^T *m B^T *m P' *m A) => e f.
  move: (K^T *m B^T *m P *m B *m K') (K^T *m B^T *m P' *m B *m K') => g h.
  by apply/matrixP=> i j; rewrite !mxE; ring.
rewrite BPA APB BPB APA BPA' APB' BPB' APA'.
move: (innovation_weight P) (innovation_weight P') => W W'.
rewrite !(mulmxDl, mulmxDr, mulmxBl, mulmxBr, mulNmx, mulmxN) !mulmxA.
move: (K^T *m W *m K) (K'^T *m W' *m K') (K^T *m W *m K').
move: (K^T *m W' *m K') (R_12 *m K') (K^T *m R_12^T) (K^T *m R_2 *m K').
by move=> a b c d e f g; apply/matrixP=> i j; rewrite !mxE; ring.
Qed.
End Difference.

Section Unique.
Variables (R : rcfType) (order m : nat).
Local Notation n := order.+1.
Variables (A R_1 : 'M[R]_n) (B R_12 : 'M[R]_(n, m)) (R_2 : 'M[R]_m).
Hypothesis R_2_symmetric : R_2^T = R_2.

(* A symmetric solution whose closed loop has its poles inside the unit circle. *)
Definition stabilising P K :=
  solves_riccati A R_1 B R_12 R_2 P K /\ inside (char_poly (A + B *m K)).

Theorem stabilising_solution_is_unique P K P' K' :
  stabilising P K -> stabilising P' K' -> P = P'.
Proof.
case=> solves_P in_K [solves_P' in_K']; apply/eqP; rewrite -subr_eq0; apply/eqP.
have in_K_T : inside (char_poly (A + B *m K)^T) by rewrite char_poly_tr; exact: in_K.
exact: (stein_zero in_K_T in_K' (difference_of_solutions R_2_symmetric solves_P solves_P')).
Qed.
End Unique.

(* Reversal takes the zeros outside to the inside. *)
Lemma inside_reversed (R : rcfType) n (p : {poly R}) :
  p \is monic -> degree_is p n -> outside p -> inside (reversed n p).
Proof.
move=> monic_p deg_p out_p z; have leading : p`_n = 1.
  by move: monic_p; rewrite monicE lead_coefE deg_p => /eqP.
have mapped : map_poly (real_complex R) (reversed n p)
            = reversed n (map_poly (real_complex R) p).
  apply/polyP=> i; rewrite [LHS]coef_map_id0 // [in RHS]coef_poly [in RHS]coef_map_id0 // coef_poly.
  by case: ifP.
have [->|nz_z] := eqVneq z 0.
  by rewrite rootE mapped reversed_0 coef_map_id0 // leading oner_eq0.
rewrite rootE mapped reversed_at ?size_map_poly ?deg_p // mulf_eq0 expf_eq0 (negPf nz_z) andbF /=.
by move/out_p; rewrite normfV invf_gt1 ?normr_gt0.
Qed.

(* Half the poles of a square on the circle: chi f~ + chi~ f = c chi chi~ leaves f = 0. *)
Lemma half_zero (R : rcfType) n (chi f : {poly R}) c :
  chi \is monic -> degree_is chi n -> inside chi -> degree_below f n ->
  (forall x, x != 0 -> chi.[x] * f.[x^-1] + chi.[x^-1] * f.[x] = c * (chi.[x] * chi.[x^-1])) ->
  f = 0.
Proof.
move=> monic_chi size_chi in_chi deg_f identity.
have wide_f : degree_at_most f n by rewrite (leq_trans deg_f).
have same : chi * reversed n f + reversed n chi * f = c *: (chi * reversed n chi).
  apply: poly_eq_off_0 => x nz_x; have := identity x nz_x.
  rewrite hornerZ hornerD !hornerM (reversed_at wide_f nz_x) (reversed_at _ nz_x) ?size_chi //.
  move: (x ^+ n) chi.[x] chi.[x^-1] f.[x] f.[x^-1] => e c1 c2 f1 f2 E.
  transitivity (e * (c1 * f2 + c2 * f1)); first by ring.
  by rewrite E; ring.
have apart_chi : coprimep chi (reversed n chi).
  by apply: apart; rewrite ?monic_neq0 //; apply: outside_reversed; rewrite ?size_chi.
have divides : chi %| f.
  rewrite -(Gauss_dvdpr _ apart_chi) -(dvdp_addr _ (dvdp_mulr (reversed n f) (dvdpp chi))) same.
  by rewrite -mul_polyC dvdp_mull // dvdp_mulr.
apply: contraTeq divides => nz_f; rewrite gtNdvdp // size_chi.
by rewrite ltnS.
Qed.

Section Existence.
Variables (R : rcfType) (order : nat).
Local Notation n := order.+1.
Variables (A : 'M[R]_n) (B : 'cV[R]_n) (E_1 : 'rV[R]_n) (E_2 H : R).
Variables (k l d : nat) (N_s N_u : {poly R}).
Hypothesis reaches : controllable A B.
Hypothesis N_zu : full_numerator A B E_1 E_2 = H *: (N_s * N_u).
Hypothesis n_split : n = (d + (k + l))%N.
Hypotheses (monic_s : N_s \is monic) (deg_s : degree_is N_s k) (in_s : inside N_s).
Hypotheses (monic_u : N_u \is monic) (deg_u : degree_is N_u l) (out_u : outside N_u).

(* The corrected (A.15), as a definition. *)
Let chi : {poly R} := N_u.[0]^-1 *: ('X^d * (N_s * reversed l N_u)).

Let nz_0 : N_u.[0] != 0. Proof. exact: outside_0. Qed.

Let lead_u : (reversed l N_u)`_l = N_u.[0]. Proof. exact: lead_reversed. Qed.

Let size_u : size (reversed l N_u) = l.+1.
Proof.
apply/eqP; rewrite eqn_leq size_reversed ltnNge; apply/negP=> short.
by move: nz_0; rewrite -lead_u nth_default ?eqxx.
Qed.

Let size_chi : size chi = n.+1.
Proof.
have nz_r : reversed l N_u != 0 by rewrite -size_poly_gt0 size_u.
have nz_s : N_s != 0 by rewrite monic_neq0.
rewrite size_scale ?invr_eq0 // !size_mul ?mulf_neq0 // ?monic_neq0 ?monicXn //.
rewrite size_polyXn deg_s size_u n_split.
by rewrite addnS /= addSn; apply: addnS.
Qed.

Let monic_chi : chi \is monic.
Proof.
rewrite monicE lead_coefZ !lead_coefM lead_coefXn mul1r (monicP monic_s) mul1r lead_coefE size_u /=.
by rewrite lead_u mulVf.
Qed.

Let in_chi : inside chi.
Proof.
move=> z; rewrite map_polyZ rootZ ?fmorph_eq0 ?invr_eq0 //.
rewrite !rmorphM /= map_polyXn !rootM => /orP[|/orP[]].
- case: (d) => [|d']; first by rewrite expr0 rootE hornerC oner_eq0.
  by rewrite rootE hornerXn expf_eq0 /= => /eqP->; rewrite normr0 ltr01.
- exact: in_s.
exact: inside_reversed.
Qed.

Let reflected : exists chi : {poly R},
  [/\ chi \is monic, size chi = n.+1, inside chi
    & forall x y, x * y = 1 -> (N_u.[0]) ^+ 2 * (chi.[x] * chi.[y])
        = (N_s * N_u).[x] * (N_s * N_u).[y]].
Proof.
exists chi; split=> // x y xy.
have nz_x : x != 0 by apply: contra_eq_neq xy => ->; rewrite mul0r eq_sym oner_eq0.
have nz_y : y != 0 by apply: contra_eq_neq xy => ->; rewrite mulr0 eq_sym oner_eq0.
have Ey : x^-1 = y by rewrite -[x^-1]mulr1 -xy mulKf.
have Ex : y^-1 = x by rewrite -Ey invrK.
rewrite !hornerZ !hornerM !hornerXn !reversed_at ?deg_u // Ex Ey.
transitivity ((x * y) ^+ d * (x * y) ^+ l * ((N_u.[0] * N_u.[0]^-1) ^+ 2
    * ((N_s.[x] * N_u.[x]) * (N_s.[y] * N_u.[y])))).
  rewrite !exprMn; move: (x ^+ d) (x ^+ l) (y ^+ d) (y ^+ l) N_u.[0]^-1 N_u.[0] => e1 e2 e3 e4 u v.
  by move: N_s.[x] N_s.[y] N_u.[x] N_u.[y] => a b e f; ring.
by rewrite xy mulfV // !expr1n !mul1r.
Qed.

Theorem stabilising_solution_exists : exists P K,
  let W := E_2 ^+ 2 + (B^T *m P *m B) 0 0 in
  [/\ P^T = P, W *: K = - (E_2 *: E_1 + B^T *m P *m A),
      P = A^T *m P *m A + E_1^T *m E_1 - W *: (K^T *m K)
    & inside (char_poly (A + B *m K))].
Proof.
have [c [monic_c size_c in_c square_c]] := reflected.
have [K EK] := regulator_gain reaches monic_c size_c.
pose M := A + B *m K; pose G := E_1 + E_2 *: K.
have in_M : inside (char_poly M) by rewrite EK.
have in_MT : inside (char_poly M^T) by rewrite char_poly_tr.
have [P EP] := stein_solvable (G^T *m G) in_MT in_M.
have P_T : P^T = P.
  apply: (stein_unique in_MT in_M _ EP).
  by rewrite {1}EP linearD /= !trmx_mul !trmxK mulmxA.
pose r := B^T *m P *m M + E_2 *: G.
have [Phi PhiE] : exists Phi : R -> 'cV[R]_n, forall z, Phi z = \adj (z%:M - M) *m B.
  by exists (fun z => \adj (z%:M - M) *m B).
pose g z := (G *m Phi z) 0 0.
pose f z := (r *m Phi z) 0 0; pose b := (B^T *m P *m B) 0 0.
have moves z : M *m Phi z = z *: Phi z - c.[z] *: B.
  have : (z%:M - M) *m Phi z = c.[z] *: B.
    by rewrite PhiE mulmxA mul_mx_adj -denominator_at EK mul_scalar_mx.
  by move=> <-; rewrite mulmxBl mul_scalar_mx subKr.
have f_E z : f z = (numerator A B r).[z].
  by rewrite -(numerator_feedback A B K r) numerator_at /f PhiE.
have t_E z : g z + E_2 * c.[z] = (H *: (N_s * N_u)).[z].
  rewrite -N_zu /full_numerator hornerD hornerM hornerC.
  have -> : g z = (numerator A B G).[z].
    by rewrite -(numerator_feedback A B K G) numerator_at /g PhiE.
  rewrite /G numerator_add numerator_scale hornerD hornerZ -EK char_poly_rank_one hornerD hornerN.
  by move: (numerator A B E_1).[z] (numerator A B K).[z] (char_poly A).[z] => a1 a2 a3; ring.
have b_E : B^T *m P *m B = b%:M by apply: mx11_scalar.
have cancel_1 (s g1 g2 p1 p2 c1 c2 x y b' : R) :
    s = s - y * (c1 * p2) - (c2 * (x * p1) - c2 * (c1 * b')) + g1 * g2 ->
    g1 * g2 = y * c1 * p2 + x * c2 * p1 - c1 * c2 * b'.
  move=> E; have -> : g1 * g2 = s - (s - y * (c1 * p2) - (c2 * (x * p1) - c2 * (c1 * b'))).
    by rewrite {1}E addrC addKr.
  by ring.
have cancel_2 (g1 g2 p1 p2 c1 c2 x y b' : R) :
    g1 * g2 = y * c1 * p2 + x * c2 * p1 - c1 * c2 * b' ->
    c1 * (y * p2 - c2 * b' + E_2 * g1) + c2 * (x * p1 - c1 * b' + E_2 * g2)
    = (g2 + E_2 * c1) * (g1 + E_2 * c2) - (E_2 ^+ 2 + b') * (c1 * c2).
  move=> gg; transitivity (g1 * g2 + E_2 * (c1 * g1 + c2 * g2) - b' * (c1 * c2)); last by ring.
  by rewrite gg; ring.
have identity x : x != 0 -> c.[x] * f x^-1 + c.[x^-1] * f x
    = ((H * N_u.[0]) ^+ 2 - (E_2 ^+ 2 + b)) * (c.[x] * c.[x^-1]).
  move=> nz_x; set y := x^-1.
  have xy : x * y = 1 by rewrite mulfV.
  pose p z := (B^T *m P *m Phi z) 0 0.
  have p_E z : B^T *m P *m Phi z = (p z)%:M by apply: mx11_scalar.
  have p_T z : (Phi z)^T *m P *m B = (p z)%:M.
    have -> : (Phi z)^T *m P *m B = (B^T *m P *m Phi z)^T by rewrite !trmx_mul trmxK P_T mulmxA.
    by rewrite p_E tr_scalar_mx.
  have g_M z : G *m Phi z = (g z)%:M by apply: mx11_scalar.
  have g_T z : (Phi z)^T *m G^T = (g z)%:M by rewrite -trmx_mul g_M tr_scalar_mx.
  have f_p z : f z = z * p z - c.[z] * b + E_2 * g z.
    rewrite /f /r mulmxDl -scalemxAl g_M -[_ *m M *m _]mulmxA moves mulmxBr -!scalemxAr p_E b_E.
    by rewrite !mxE eqxx !mulr1n.
  have gg : g y * g x = y * c.[x] * p y + x * c.[y] * p x - c.[x] * c.[y] * b.
    have : (Phi y)^T *m P *m Phi x = (Phi y)^T *m (M^T *m P *m M + G^T *m G) *m Phi x.
      by rewrite -EP.
    rewrite mulmxDr mulmxDl !mulmxA -[_ *m M^T]trmx_mul moves -[_ *m M *m _]mulmxA moves.
    rewrite g_T -[_ *m G *m _]mulmxA g_M.
    have -> : (y *: Phi y - c.[y] *: B)^T = y *: (Phi y)^T - c.[y] *: B^T.
      by apply/matrixP=> i j; rewrite !mxE.
    rewrite !mulmxBl !mulmxBr -!scalemxAl -!scalemxAr p_E p_T b_E [y *: (x *: _)]scalerA [y * x]mulrC xy scale1r.
    have [s Es] : exists s, (Phi y)^T *m P *m Phi x = s%:M.
      by exists (((Phi y)^T *m P *m Phi x) 0 0); apply: mx11_scalar.
    rewrite Es; move/matrixP/(_ 0 0); rewrite -scalar_mxM !mxE eqxx !mulr1n => E.
    exact: cancel_1 E.
  have square : (g x + E_2 * c.[x]) * (g y + E_2 * c.[y])
      = (H * N_u.[0]) ^+ 2 * (c.[x] * c.[y]).
    rewrite exprMn -mulrA (square_c x y xy) !t_E !hornerZ.
    by move: (N_s * N_u).[x] (N_s * N_u).[y] => u v; ring.
  transitivity ((g x + E_2 * c.[x]) * (g y + E_2 * c.[y]) - (E_2 ^+ 2 + b) * (c.[x] * c.[y])).
    by rewrite !f_p; exact: cancel_2 gg.
  by rewrite square mulrBl.
have zero : numerator A B r = 0.
  apply: (half_zero monic_c size_c in_c (c := (H * N_u.[0]) ^+ 2 - (E_2 ^+ 2 + b))) => [|x nz_x].
    exact: numerator_strictly_proper.
  by rewrite -!f_E identity.
have r0 : r = 0.
  apply: (regulator_gain_is_unique reaches); rewrite !char_poly_rank_one zero.
  by rewrite -[X in numerator A B X](scale0r 0) numerator_scale scale0r.
pose W := E_2 ^+ 2 + b.
have gain : W *: K = - (E_2 *: E_1 + B^T *m P *m A).
  apply/eqP; rewrite -subr_eq0 opprK -r0 /r /M /G mulmxDr mulmxA b_E mul_scalar_mx.
  rewrite scalerDr scalerA -expr2 /W scalerDl; apply/eqP.
  move: (B^T *m P *m A) => a; move: (b *: K) (E_2 *: E_1) (E_2 ^+ 2 *: K) => *.
  by apply/matrixP=> i j; rewrite !mxE; ring.
suff riccati : P = A^T *m P *m A + E_1^T *m E_1 - W *: (K^T *m K) by exists P, K; split; [exact: P_T | exact: gain | exact: riccati | exact: in_M].
have APB : A^T *m P *m B + E_2 *: E_1^T = - (W *: K^T).
  have := congr1 trmx gain; rewrite linearZ linearN linearD /= linearZ /= !trmx_mul trmxK P_T mulmxA.
  by move=> ->; rewrite opprK addrC.
have BPA : B^T *m P *m A + E_2 *: E_1 = - (W *: K) by rewrite gain opprK addrC.
transitivity (A^T *m P *m A + E_1^T *m E_1 + (A^T *m P *m B + E_2 *: E_1^T) *m K
    + K^T *m (B^T *m P *m A + E_2 *: E_1) + W *: (K^T *m K)).
  rewrite {1}EP /M /G.
  have -> : (A + B *m K)^T = A^T + K^T *m B^T by rewrite linearD /= trmx_mul.
  have -> : (E_1 + E_2 *: K)^T = E_1^T + E_2 *: K^T by rewrite linearD /= linearZ.
  have EbKK : b *: (K^T *m K) = K^T *m B^T *m P *m B *m K.
    by rewrite scalemxAr -mul_scalar_mx -b_E !mulmxA.
  rewrite /W scalerDl EbKK.
  rewrite !(mulmxDl, mulmxDr) -!scalemxAl -!scalemxAr scalerA -expr2 !mulmxA.
  move: (A^T *m P *m A) (A^T *m P *m B *m K) (K^T *m B^T *m P *m A) => a1 a2 a3.
  move: (K^T *m B^T *m P *m B *m K) (E_1^T *m E_1) (E_2 *: (E_1^T *m K)) => a4 a5 a6.
  move: (E_2 *: (K^T *m E_1)) (E_2 ^+ 2 *: (K^T *m K)) => a7 a8.
  by apply/matrixP=> i j; rewrite !mxE; move: (a1 i j) (a2 i j) (a3 i j) (a4 i j) (a5 i j)
    (a6 i j) (a7 i j) (a8 i j) => *; ring.
rewrite APB BPA mulNmx mulmxN -scalemxAl -scalemxAr.
move: (A^T *m P *m A) (E_1^T *m E_1) (W *: (K^T *m K)) => a1 a2 a3.
by rewrite subrK.
Qed.
End Existence.
