(* The return-difference identity of the Riccati equation (A.7), with every cross term, and the
   spectral factorisation behind the poles of high-authority LQG. Any number of signals first. *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary Matrices.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

Section ReturnDifference.
Variables (R : comRingType) (n m : nat).
Variables (A P R_1 : 'M[R]_n) (B R_12 : 'M[R]_(n, m)) (R_2 W : 'M[R]_m) (K : 'M[R]_(m, n)).

(* K = C_c of (A.6), and (A.7) written with it; no inverse is needed. *)
Hypothesis weight : W = R_2 + B^T *m P *m B.
Hypotheses (P_symmetric : P^T = P) (R_2_symmetric : R_2^T = R_2).
Hypothesis gain : W *m K = - (R_12^T + B^T *m P *m A).
Hypothesis riccati : P = A^T *m P *m A + R_1 - K^T *m W *m K.

(* phi and psi are (xI - A)^-1 B d and (yI - A)^-1 B e without the inverses; y = 1/x. *)
Theorem return_difference k l (x y : R) (phi : 'M[R]_(n, k)) (psi : 'M[R]_(n, l)) d e :
  x * y = 1 -> A *m phi = x *: phi - B *m d -> A *m psi = y *: psi - B *m e ->
  (e - K *m psi)^T *m W *m (d - K *m phi)
  = e^T *m R_2 *m d + psi^T *m R_1 *m phi + e^T *m R_12^T *m phi + psi^T *m R_12 *m d.
Proof.
move=> xy A_phi A_psi.
have W_symmetric : W^T = W.
  by rewrite weight linearD /= R_2_symmetric !trmx_mul trmxK P_symmetric mulmxA.
have gain_T : K^T *m W = - (R_12 + A^T *m P *m B).
  rewrite -{1}W_symmetric -trmx_mul gain linearN linearD /= !trmx_mul !trmxK P_symmetric.
  by rewrite mulmxA.
have A_psi_T : psi^T *m A^T = y *: psi^T - e^T *m B^T.
  by rewrite -trmx_mul A_psi linearB linearZ /= trmx_mul.
(* W (d - K phi) and psi' A' P A phi as sums of products *)
have from_phi : W *m (d - K *m phi) = R_2 *m d + R_12^T *m phi + x *: (B^T *m P *m phi).
  rewrite mulmxBr mulmxA gain mulNmx opprK mulmxDl -[_ *m A *m phi]mulmxA A_phi mulmxBr.
  rewrite -scalemxAr weight mulmxDl !mulmxA.
  move: (R_2 *m d) (B^T *m P *m B *m d) (R_12^T *m phi) (B^T *m P *m phi) => a b c f.
  by apply/matrixP=> i j; rewrite !mxE; ring.
have from_psi : psi^T *m (K^T *m W) = - (psi^T *m R_12 + y *: (psi^T *m P *m B)
    - e^T *m B^T *m P *m B).
  rewrite gain_T mulmxN mulmxDr !mulmxA A_psi_T !mulmxBl -!scalemxAl.
  by rewrite -!addrA.
have middle : psi^T *m (K^T *m W *m K) *m phi = psi^T *m R_1 *m phi
    - y *: (psi^T *m P *m B *m d) - x *: (e^T *m B^T *m P *m phi) + e^T *m B^T *m P *m B *m d.
  have -> : K^T *m W *m K = A^T *m P *m A + R_1 - P by rewrite {2}riccati subKr.
  rewrite mulmxBr mulmxBl mulmxDr mulmxDl !mulmxA A_psi_T -[_ *m A *m phi]mulmxA A_phi.
  rewrite !mulmxBl !mulmxBr -!scalemxAl -!scalemxAr scalerA [y * x]mulrC xy scale1r !mulmxA.
  move: (psi^T *m P *m phi) (psi^T *m P *m B *m d) (e^T *m B^T *m P *m phi) => a b c.
  move: (e^T *m B^T *m P *m B *m d) (psi^T *m R_1 *m phi) => f g.
  by apply/matrixP=> i j; rewrite !mxE; ring.
have -> : (e - K *m psi)^T *m W *m (d - K *m phi) = e^T *m (W *m (d - K *m phi))
    - psi^T *m (K^T *m W) *m d + psi^T *m (K^T *m W *m K) *m phi.
  have -> : (e - K *m psi)^T = e^T - psi^T *m K^T by rewrite linearB /= trmx_mul.
  rewrite !mulmxBl !mulmxBr !mulmxA.
  move: (e^T *m W *m d) (e^T *m W *m K *m phi) (psi^T *m K^T *m W *m d) => a b c.
  by move: (psi^T *m K^T *m W *m K *m phi) => f; apply/matrixP=> i j; rewrite !mxE; ring.
rewrite from_phi from_psi middle !mulmxDr mulNmx mulmxBl mulmxDl -!scalemxAr -!scalemxAl !mulmxA.
move: (e^T *m R_2 *m d) (psi^T *m R_1 *m phi) (e^T *m R_12^T *m phi) (psi^T *m R_12 *m d).
move: (psi^T *m P *m B *m d) (e^T *m B^T *m P *m phi) (e^T *m B^T *m P *m B *m d).
by move=> a b c f g h o; apply/matrixP=> i j; rewrite !mxE; ring.
Qed.
End ReturnDifference.

(* With z = E_1 x + E_2 u the right-hand side is the square of G_zu's numerator. *)
Section ScalarSignals.
Variables (R : fieldType) (n : nat).
Variables (A P : 'M[R]_n) (B : 'cV[R]_n) (E_1 K : 'rV[R]_n) (E_2 : R).
Let W := E_2 ^+ 2 + (B^T *m P *m B) 0 0.

Lemma numerator_at x (C : 'rV[R]_n) :
  (numerator A B C).[x] = (C *m (\adj (x%:M - A) *m B)) 0 0.
Proof.
have adjoint : map_mx (horner_eval x) (\adj (char_poly_mx A)) = \adj (x%:M - A).
  rewrite map_mx_adj; congr (\adj _); rewrite /char_poly_mx map_mxB map_scalar_mx /=.
  rewrite /horner_eval hornerX; congr (_ - _); apply/matrixP=> i j; rewrite !mxE.
  by rewrite hornerC.
have constant k l (M : 'M[R]_(k, l)) : map_mx (horner_eval x) (map_mx polyC M) = M.
  by apply/matrixP=> i j; rewrite !mxE /horner_eval hornerC.
have -> : (numerator A B C).[x] = (map_mx (horner_eval x)
    (map_mx polyC C *m \adj (char_poly_mx A) *m map_mx polyC B)) 0 0 by rewrite [RHS]mxE.
by rewrite !map_mxM adjoint !constant mulmxA.
Qed.

Lemma denominator_at x : (char_poly A).[x] = \det (x%:M - A).
Proof.
rewrite /char_poly -[_.[x]]/(horner_eval x _) -det_map_mx; congr (\det _).
rewrite /char_poly_mx map_mxB map_scalar_mx /= /horner_eval hornerX; congr (_ - _).
by apply/matrixP=> i j; rewrite !mxE hornerC.
Qed.

(* N_zu of the numerator over D = det(zI - A), the direct term included. *)
Definition full_numerator : {poly R} := numerator A B E_1 + E_2%:P * char_poly A.

Hypotheses (P_symmetric : P^T = P).
Hypothesis gain : W *: K = - (E_2 *: E_1 + B^T *m P *m A).
Hypothesis riccati : P = A^T *m P *m A + E_1^T *m E_1 - W *: (K^T *m K).

(* (R_2 + B'PB) chi(x) chi(1/x) = N_zu(x) N_zu(1/x), chi = det(zI - A - BK). *)
Theorem spectral_factorisation x y : x * y = 1 ->
  W * ((char_poly (A + B *m K)).[x] * (char_poly (A + B *m K)).[y])
  = full_numerator.[x] * full_numerator.[y].
Proof.
move=> xy; pose Phi z := \adj (z%:M - A) *m B; pose d z := (char_poly A).[z].
have moves z : A *m Phi z = z *: Phi z - B *m (d z)%:M.
  have : (z%:M - A) *m Phi z = B *m (d z)%:M.
    by rewrite mulmxA mul_mx_adj -denominator_at mul_scalar_mx mul_mx_scalar.
  by move=> <-; rewrite mulmxBl mul_scalar_mx subKr.
have W_matrix : (E_2 ^+ 2)%:M + B^T *m P *m B = W%:M.
  by rewrite [B^T *m P *m B]mx11_scalar -raddfD.
pose k z := (K *m Phi z) 0 0; pose g z := (E_1 *m Phi z) 0 0.
have K_Phi z : K *m Phi z = (k z)%:M by apply: mx11_scalar.
have E_Phi z : E_1 *m Phi z = (g z)%:M by apply: mx11_scalar.
have closed z : (char_poly (A + B *m K)).[z] = d z - k z.
  by rewrite char_poly_rank_one hornerD hornerN numerator_at.
have direct z : full_numerator.[z] = g z + E_2 * d z.
  by rewrite hornerD hornerM hornerC numerator_at.
have cross : (W%:M : 'M_1) *m K = - ((E_2 *: E_1^T)^T + B^T *m P *m A).
  by rewrite mul_scalar_mx gain linearZ /= trmxK.
have riccati' : P = A^T *m P *m A + E_1^T *m E_1 - K^T *m W%:M *m K.
  by rewrite {1}riccati mul_mx_scalar -scalemxAl.
have := return_difference (esym W_matrix) P_symmetric (tr_scalar_mx _ _) cross riccati' xy
  (moves x) (moves y).
have E_Phi_T : (Phi y)^T *m E_1^T = (g y)%:M by rewrite -trmx_mul E_Phi tr_scalar_mx.
rewrite !K_Phi -!raddfB /= !tr_scalar_mx [(E_2 *: E_1^T)^T]linearZ /= trmxK.
rewrite [_ *m (E_1^T *m E_1)]mulmxA E_Phi_T -[_ *m E_1 *m _]mulmxA E_Phi.
have E_2_Phi z : (E_2 *: E_1) *m Phi z = (E_2 * g z)%:M by rewrite -scalemxAl E_Phi scale_scalar_mx.
have E_2_Phi_T : (Phi y)^T *m (E_2 *: E_1^T) = (E_2 * g y)%:M.
  by rewrite -scalemxAr E_Phi_T scale_scalar_mx.
rewrite -[_ *m (E_2 *: E_1) *m _]mulmxA E_2_Phi E_2_Phi_T.
have sum (a b : R) : a%:M + b%:M = (a + b)%:M :> 'M_1 by rewrite raddfD.
rewrite -!scalar_mxM !sum => /(congr1 (fun M : 'M_1 => M 0 0)).
rewrite !mxE eqxx !mulr1n closed closed !direct => identity.
transitivity ((d y - k y) * W * (d x - k x)); first by ring.
by rewrite identity; ring.
Qed.
End ScalarSignals.
