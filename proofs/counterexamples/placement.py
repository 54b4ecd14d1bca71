"""Uniqueness and existence of the compensator as Section 7.4 and 7.5 word them."""

from collections.abc import Iterator

from sympy import Matrix, Symbol

from compensator_theory import check_proposition_3, polynomial
from compensator_theory.exact_linear_algebra import characteristic_polynomial, determinant
from compensator_theory.sylvester import sylvester_m

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
    found = check_proposition_3("s**2 + 3*s + 2", "s + 5", n_c=4, m_hat=1)
    yield "M = M_1(D, N)", found.left
    yield "n_c <= n does not hold", not found.printed_right
    yield "M is nonsingular", determinant(sylvester_m("s**2 + 3*s + 2", "s + 5", 4, 1)) != 0


def constant_zero() -> Facts:
    """Lemma 1 with "deg 0 = 0": a = 1, b = 0, q = s, p = 0 has bq + ap = 0, so p != 0 is needed."""
    a, b, q, p = (polynomial(text, "s") for text in ("1", "0", "s", "0"))
    yield "bq + ap = 0", (b * q + a * p).is_zero
    yield "a is not 0", not a.is_zero
