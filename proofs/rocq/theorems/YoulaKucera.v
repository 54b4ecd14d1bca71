(* All compensators by one parameter (Youla and Jabr and Bongiorno, Kucera): over any commutative ring
   from one Bezout identity, for one signal and for many; for transfer functions over a field, with any
   subring as the stable ones; and as the proper compensators that place a polynomial. Feedback is negative,
   as in (7.23). *)
From Compensators.foundations Require Import MathComp.
From Compensators.foundations Require Import Vocabulary.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory.
Local Open Scope ring_scope.

(* Every pair with D D_c + N N_c = Dtilde, of one parameter each. *)
Section Pairs.
Variables (H : comRingType) (D N X Y Dtilde : H).
Hypothesis bezout : X * N + Y * D = 1.

Theorem pairs_by_one_parameter D_c N_c : D * D_c + N * N_c = Dtilde <->
  exists! Q, D_c = Dtilde * Y - Q * N /\ N_c = Dtilde * X + Q * D.
Proof.
have by_one a : a = (X * N + Y * D) * a by rewrite bezout mul1r.
split=> [placed|[Q [[-> ->] _]]]; last by rewrite [RHS]by_one; ring.
exists (Y * N_c - X * D_c); split=> [|Q [-> ->]]; last by rewrite [RHS]by_one; ring.
by rewrite -placed; split; [rewrite {1}[D_c]by_one | rewrite {1}[N_c]by_one]; ring.
Qed.
End Pairs.

(* Several signals: the plant is N D^-1 = D_l^-1 N_l, the compensator D_c^-1 N_c. *)
Section MatrixPairs.
Variables (H : comUnitRingType) (m p : nat).
Variables (D : 'M[H]_m) (N : 'M[H]_(p, m)) (X : 'M[H]_(m, p)) (Y : 'M[H]_m).
Variables (D_l : 'M[H]_p) (N_l : 'M[H]_(p, m)) (X_l : 'M[H]_(m, p)) (Y_l : 'M[H]_p).
Hypothesis double_bezout :
  block_mx Y X (- N_l) D_l *m block_mx D (- X_l) N Y_l = 1%:M.

Theorem matrix_pairs_by_one_parameter (Dtilde D_c : 'M[H]_m) (N_c : 'M[H]_(m, p)) :
  D_c *m D + N_c *m N = Dtilde <->
  exists! Q, D_c = Dtilde *m Y - Q *m N_l /\ N_c = Dtilde *m X + Q *m D_l.
Proof.
pose right := block_mx D (- X_l) N Y_l; pose left := block_mx Y X (- N_l) D_l.
have to_right (M : 'M_m) (L : 'M_(m, p)) :
    row_mx M L *m right = row_mx (M *m D + L *m N) (L *m Y_l - M *m X_l).
  by rewrite mul_row_block mulmxN [- _ + _]addrC.
have to_left (M : 'M_m) (L : 'M_(m, p)) :
    row_mx M L *m left = row_mx (M *m Y - L *m N_l) (M *m X + L *m D_l).
  by rewrite mul_row_block mulmxN.
have inverse : right *m left = 1%:M := mulmx1C double_bezout.
split=> [placed|[Q [[ED EN] _]]].
  exists (N_c *m Y_l - D_c *m X_l); split=> [|Q [ED EN]].
    have := congr1 (mulmxr left) (to_right D_c N_c); rewrite /= placed -mulmxA inverse mulmx1 to_left.
    by move/eq_row_mx.
  have := to_left Dtilde Q; rewrite -ED -EN => /(congr1 (mulmxr right)) /=.
  by rewrite -mulmxA double_bezout mulmx1 to_right => /eq_row_mx[_ ->].
have := to_left Dtilde Q; rewrite -ED -EN => /(congr1 (mulmxr right)) /=.
by rewrite -mulmxA double_bezout mulmx1 to_right => /eq_row_mx[->].
Qed.
End MatrixPairs.

(* p = N / D and c are of the field F, the stable functions are its subring S. *)
Section StableFunctions.
Variables (F : fieldType) (S : F -> Prop).

Definition subring := [/\ S 1, forall a b, S a -> S b -> S (a - b) & forall a b, S a -> S b -> S (a * b)].

(* The loop is well posed, and its transfer functions are stable; p c / (1 + p c) is 1 less the first. *)
Definition stabilises p c :=
  [/\ 1 + p * c != 0, S (1 + p * c)^-1, S (c / (1 + p * c)) & S (p / (1 + p * c))].

Variables D N X Y : F.
Hypothesis stable : subring.
Hypotheses (S_D : S D) (S_N : S N) (S_X : S X) (S_Y : S Y).
Hypotheses (nz_D : D != 0) (bezout : X * N + Y * D = 1).

Lemma subring_closed : [/\ S 1, forall a b, S a -> S b -> S (a - b), forall a b, S a -> S b -> S (a + b)
  & forall a b, S a -> S b -> S (a * b)].
Proof.
have [S_1 S_sub S_mul] := stable; split=> // a b S_a S_b.
have S_0 : S 0 by rewrite -(subrr b); exact: (S_sub _ _ S_b S_b).
by rewrite -[b]opprK -[- b]sub0r; exact: (S_sub _ _ S_a (S_sub _ _ S_0 S_b)).
Qed.

Theorem stabilising_by_one_parameter c : stabilises (N / D) c <->
  exists Q, [/\ S Q, Y - Q * N != 0 & c = (X + Q * D) / (Y - Q * N)].
Proof.
have [S_1 S_sub S_add S_mul] := subring_closed.
have by_one a : a = (X * N + Y * D) * a by rewrite bezout mul1r.
split=> [[posed S_s S_cs S_ps]|[Q [S_Q nz_Y ->]]]; last first.
  have E : 1 + N / D * ((X + Q * D) / (Y - Q * N)) = (D * (Y - Q * N))^-1.
    by rewrite [RHS]by_one; field; rewrite nz_Y.
  have S_d : S (Y - Q * N) by auto.
  have S_n : S (X + Q * D) by auto.
  rewrite /stabilises E invrK invr_eq0 mulf_neq0 //; split=> //; first by auto.
    by rewrite [D * _]mulrC mulrA divfK //; auto.
  by rewrite mulrA divfK //; auto.
set p := N / D in posed S_s S_cs S_ps; set s := (1 + p * c)^-1 in S_s S_cs S_ps.
have p_D : N = p * D by rewrite divfK.
have nz_s : s != 0 by rewrite invr_eq0.
have total : s = 1 - p * (c * s).
  by apply/eqP; rewrite eq_sym subr_eq mulrA -[X in X + _]mul1r -mulrDl mulfV.
(* s / D and c s / D are stable *)
pose v := X * (p * s) + Y * s; pose w := X * (1 - s) + Y * (c * s).
have Ev : D * v = s by rewrite [RHS]by_one /v p_D; ring.
have Ew : D * w = c * s by rewrite [RHS]by_one /w {1}total p_D; ring.
have nz_v : v != 0 by apply: contraNneq nz_s => v0; rewrite -Ev v0 mulr0.
have S_v : S v by rewrite /v; auto.
have S_w : S w by rewrite /w; auto.
have placed : D * v + N * w = 1 by rewrite p_D -mulrA Ew Ev {1}total subrK.
pose Q := Y * w - X * v.
have [E_v E_w] : v = Y - Q * N /\ w = X + Q * D.
  split; first by rewrite {1}[v]by_one -[Y in RHS]mulr1 -placed /Q; ring.
  by rewrite {1}[w]by_one -[X in RHS]mulr1 -placed /Q; ring.
exists Q; rewrite -E_v -E_w; split=> //; first by rewrite /Q; auto.
by apply: (canRL (mulfK nz_v)); apply: (mulfI nz_D); rewrite mulrCA Ev Ew.
Qed.
End StableFunctions.

(* The proper compensators of order n_c that place Dtilde: a polynomial Q of degree at most n_c - n, and
   one compensator at most where n_c < n. *)
Theorem proper_placements (R : fieldType) n n_c (D N Dtilde D_0 N_0 : {poly R}) :
  degree_is D n -> coprimep D N -> degree_below N_0 n ->
  closed_loop_polynomial D N D_0 N_0 = Dtilde -> forall D_c N_c : {poly R}, degree_at_most N_c n_c ->
  closed_loop_polynomial D N D_c N_c = Dtilde <->
  exists Q : {poly R}, [/\ (size Q <= n_c.+1 - n)%N, D_c = D_0 - Q * N & N_c = N_0 + Q * D].
Proof.
move=> deg_D coprime_DN deg_0 <- D_c N_c deg_c; rewrite /closed_loop_polynomial.
split=> [placed|[Q [_ -> ->]]]; last by ring.
have moved : D * (D_0 - D_c) = (N_c - N_0) * N.
  by rewrite mulrBr mulrBl [N_c * N]mulrC -[N * N_c](addKr (D * D_c)) placed; ring.
have /dvdpP[Q EQ] : D %| N_c - N_0 by rewrite -(Gauss_dvdpl _ coprime_DN) -moved dvdp_mulr.
have nz_D : D != 0 by rewrite -size_poly_gt0 deg_D.
exists Q; split; last by rewrite -EQ addrC subrK.
  have [->|nz_Q] := eqVneq Q 0; first by rewrite size_poly0.
  have := size_add N_c (- N_0); rewrite size_opp EQ size_mul // deg_D addnS /=.
  move: nz_Q deg_0 deg_c; rewrite -size_poly_gt0.
  by move: (size Q) (size N_0) (size N_c); lia.
apply/eqP; rewrite eq_sym subr_eq addrC -subr_eq eq_sym; apply/eqP.
by apply: (mulfI nz_D); rewrite moved EQ; ring.
Qed.
