"""Uniqueness and existence of the compensator as Section 7.4 and 7.5 word them."""

from collections.abc import Iterator

from sympy import Expr, I, Integer, Matrix, Symbol, expand

from compensator_theory import TransferFunction, polynomial
from compensator_theory.bezout import check_proposition_3
from compensator_theory.bezout._sylvester import sylvester_m
from compensator_theory.loops import target_characteristic_polynomial
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, determinant

Facts = Iterator[tuple[str, bool]]
s = Symbol("s")


def without_coprimeness() -> Facts:
    """D = (s + 1)(s + 2), N = s + 1: adding (s + 2, -1) to (N_c, D_c) leaves D D_c + N N_c."""
    D, N = polynomial("(s + 1)*(s + 2)"), polynomial("s + 1")
    D_c, N_c = polynomial("s**2 + 3*s + 4"), polynomial("5*s + 6")
    other_D, other_N = D_c - 1, N_c + polynomial("s + 2")
    yield "deg N_c <= n - 1 for both", N_c.degree() == other_N.degree() == 1
    yield "both place the same poles", D * D_c + N * N_c == D * other_D + N * other_N
    yield "they differ", (D_c, N_c) != (other_D, other_N)


def high_numerator() -> Facts:
    """Examples 7.3 and 7.4, G = 1/(s + 2): with deg N_c = n two compensators share D~."""
    D, N = polynomial("s + 2"), polynomial("1", "s")
    for number, pairs, loop in (
        ("7.3", [("-s - 1", "s + 1"), ("-2*s - 3", "s + 2")], "s**2 + 2*s + 1"),
        ("7.4", [("-3*s - 1", "s**2 + 2*s + 1"), ("-4*s - 3", "s**2 + 2*s + 2")],
         "s**3 + 4*s**2 + 2*s + 1"),
    ):  # fmt: skip
        placed = [D * polynomial(D_c) + N * polynomial(N_c) for N_c, D_c in pairs]
        yield f"Example {number}: both give {loop}", placed == [polynomial(loop)] * 2


def degree_of_the_numerator() -> Facts:
    """A = [0 1; -2 -3], K = [1 0], F = [0; 1]: KF = 0, and deg N_c is 0 instead of n - 1 = 1."""
    A, B, C = Matrix([[0, 1], [-2, -3]]), Matrix([0, 1]), Matrix([[1, 0]])
    K, F = Matrix([[1, 0]]), Matrix([0, 1])
    A_c = A + B * K - F * C
    N_c = characteristic_polynomial(A_c, s) - characteristic_polynomial(A_c + F * K, s)
    yield "KF = 0", (K * F)[0] == 0
    yield "K adj(sI - A_c) F = 1", N_c == polynomial("1", "s")


def more_states_than_the_plant() -> Facts:
    """D = s^2 + 3s + 2, N = s + 5, n_c = 4 > n: M is M_1(D, N), N with formal degree n_c, and it is
    nonsingular, so that "n_c <= n" of Propositions 3 and 5 is not necessary.
    """
    proposition = check_proposition_3("s**2 + 3*s + 2", "s + 5", n_c=4, m_hat=1)
    yield "M = M_1(D, N)", proposition.left
    yield "n_c <= n does not hold", not proposition.printed_right
    yield "M is nonsingular", determinant(sylvester_m("s**2 + 3*s + 2", "s + 5", 4, 1)) != 0


def constant_zero() -> Facts:
    """Lemma 1 with "deg 0 = 0": a = 1, b = 0, q = s, p = 0 has bq + ap = 0 and deg a <= deg b."""
    a, b, q, p = (polynomial(text, "s") for text in ("1", "0", "s", "0"))
    yield "bq + ap = 0", (b * q + a * p).is_zero
    yield "a is not 0", not a.is_zero


def separated_pair() -> Facts:
    """D = s^2 + 3s + 2, N = 1, the poles j, -j, -1, -5: with j in the regulator and -j in the
    observer K and F are complex, and the compensator is that of the real share.
    """
    A, B, C = Matrix([[0, 1], [-2, -3]]), Matrix([0, 1]), Matrix([[1, 0]])

    def compensator(p: tuple[Expr, Expr], o: tuple[Expr, Expr]) -> tuple[Matrix, Expr, Expr]:
        """Return K, D_c and N_c for the regulator s^2 + p_1 s + p_0 and the observer o."""
        K = Matrix([[2 - p[1], 3 - p[0]]])
        F = Matrix([o[0] - 3, o[1] - 2 - 3 * (o[0] - 3)])
        spectra = (A + B * K).charpoly(s).as_expr(), (A - F * C).charpoly(s).as_expr()
        requested = (s**2 + p[0] * s + p[1], s**2 + o[0] * s + o[1])
        assert all(expand(x - y) == 0 for x, y in zip(spectra, requested, strict=True))
        A_c = A + B * K - F * C
        D_c = expand(A_c.charpoly(s).as_expr())
        return K, D_c, expand(D_c - (A_c + F * K).charpoly(s).as_expr())

    separated = compensator((1 - I, -I), (5 + I, 5 * I))  # (s - j)(s + 1), (s + j)(s + 5)
    real = compensator((Integer(0), Integer(1)), (Integer(6), Integer(5)))
    yield "K of the separated share is complex", separated[0] != separated[0].C
    yield "D_c and N_c are the same", separated[1:] == real[1:]


def too_many_target_poles() -> Facts:
    """N_zu = (q - 1/2)(q - 1/4), n = 3, n_c = 1, D_p = (q - 1/3)^3: n_p = 3 < n + n_c = 4, but
    (4.38) has the zero 0 once more than q^n_c N_zu.
    """
    N_zu, D_p = polynomial("(q - 1/2)*(q - 1/4)"), polynomial("(q - 1/3)**3")
    q = polynomial("q")
    n, n_c, n_p, d = 3, 1, D_p.degree(), 1
    yield "n_p < n + n_c", n_p < n + n_c
    yield (
        "q^(n_p - d) does not divide q^n_c N_zu D_p",
        (q**n_c * N_zu * D_p).rem(q ** (n_p - d)) != 0,
    )
    fewer = polynomial("(q - 1/3)**2")
    matched = target_characteristic_polynomial((N_zu, n), n_c, TransferFunction(q, fewer))
    yield "with n_p = n_c + d it is matched, by D~ = N_zu D_p", matched == N_zu * fewer
