"""Polynomials and matrices of a fixed size, every coefficient a letter of its own.

Single-input plants are in controllable canonical form, single-output compensators in observable
canonical form: a change of basis, so that nothing is lost for minimal ones.
"""

from sympy import Expr, Matrix, Poly, Symbol, expand, prod, symbols, zeros

from compensator_theory.bezout import sylvester_m, sylvester_m1, sylvester_m2
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, determinant
from compensator_theory.polynomials._poly import canonical

s, q = Symbol("s"), Symbol("q")


def generic_polynomial(letter: str, degree: int, *, is_monic: bool = False) -> Poly:
    """Return a polynomial in s with letters as coefficients.

    Examples
    --------
    >>> from proofs.symbolic.coefficients import generic_polynomial
    >>> generic_polynomial("a", 1).as_expr()
    a0 + a1*s
    """
    lower = symbols(f"{letter}:{degree + 1}")
    leading = 1 if is_monic else lower[degree]
    return Poly([leading, *reversed(lower[:degree])], s)


def companion(letter: str, size: int) -> Matrix:
    """Return the companion matrix of a generic monic polynomial.

    Examples
    --------
    >>> from proofs.symbolic.coefficients import companion
    >>> companion("a", 2)
    Matrix([
    [  0,   1],
    [-a0, -a1]])
    """
    A = zeros(size, size)
    for i in range(size - 1):
        A[i, i + 1] = 1
    A[size - 1, :] = -Matrix([symbols(f"{letter}:{size}")])
    return A


def last_unit(size: int) -> Matrix:
    """Return the last column of the identity.

    Examples
    --------
    >>> from proofs.symbolic.coefficients import last_unit
    >>> last_unit(2).T
    Matrix([[0, 1]])
    """
    return Matrix([0] * (size - 1) + [1])


def row(letter: str, size: int) -> Matrix:
    """Return a row of letters.

    Examples
    --------
    >>> from proofs.symbolic.coefficients import row
    >>> row("k", 2)
    Matrix([[k0, k1]])
    """
    return Matrix([symbols(f"{letter}:{size}")])


def polynomials_of(A: Matrix, B: Matrix, C: Matrix) -> tuple[Poly, Poly]:
    """Return det(sI - A) and C adj(sI - A) B, the latter as a difference of determinants.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from proofs.symbolic.coefficients import polynomials_of
    >>> [p.as_expr() for p in polynomials_of(Matrix([[2]]), Matrix([3]), Matrix([5]))]
    [s - 2, 15]
    """
    D = characteristic_polynomial(A, s)
    return D, D - characteristic_polynomial(A + B * C, s)


def placement_equation(n: int) -> bool:
    """(7.37), (7.38): M times the coefficients of D_c and N_c lists D D_c + N N_c - s^n_c D, for
    n_c from n - 1 to n + 1.
    """
    D, N = generic_polynomial("a", n, is_monic=True), generic_polynomial("b", n - 1)
    for n_c in range(max(n - 1, 1), n + 2):
        D_c = generic_polynomial("x", n_c, is_monic=True)
        N_c = generic_polynomial("y", n - 1)
        unknowns = Matrix([*D_c.all_coeffs()[1:], *N_c.all_coeffs()])
        listed = Poly((sylvester_m(D, N, n_c, n - 1) * unknowns).expand().T.tolist()[0], s)
        if not _same(D * D_c + N * N_c - Poly(s**n_c, s) * D, listed):
            return False
    return True


def closed_loop_polynomial(n: int) -> bool:
    """(7.23): det(sI - A~) = D D_c - N C_c adj(sI - A_c) B_c for (7.3), (7.4), n_c = n."""
    A, B, C = companion("a", n), last_unit(n), row("c", n)
    A_c, B_c, C_c = companion("d", n).T, row("f", n).T, last_unit(n).T
    loop = Matrix.vstack(Matrix.hstack(A, B * C_c), Matrix.hstack(B_c * C, A_c))
    D, N = polynomials_of(A, B, C)
    D_c, N_c = polynomials_of(A_c, B_c, C_c)
    return _same(characteristic_polynomial(loop, s), D * D_c - N * N_c)


def separated_polynomial(n: int) -> bool:
    """D det(sI - A_c) - N K adj(sI - A_c) F = det(sI - A - BK) det(sI - A + FC) for A_c = A + BK -
    FC: with (7.31) for G_c the sign of N_c is minus.
    """
    A, B, C = companion("a", n), last_unit(n), row("c", n)
    K, F = row("k", n), row("f", n).T
    D, N = polynomials_of(A, B, C)
    D_c, N_c = polynomials_of(A + B * K - F * C, F, K)
    regulator = characteristic_polynomial(A + B * K, s)
    observer = characteristic_polynomial(A - F * C, s)
    return _same(D * D_c - N * N_c, regulator * observer)


def resultant_determinants(k: int) -> bool:
    """det M_2(a, b) = a_k^(k - l) det M_1(a, b), deg a = k, every formal degree l <= k of b."""
    a = generic_polynomial("a", k)
    for l in range(k + 1):  # noqa: E741  (the text's letter)
        b = generic_polynomial("b", l)
        padded = [0] * (k - l) + b.all_coeffs()
        right = a.LC() ** (k - l) * determinant(sylvester_m1(a, b, k, l))
        if expand(determinant(sylvester_m2(a.all_coeffs(), padded)) - right) != 0:
            return False
    return True


def reflected_spectrum(n: int) -> bool:
    """N(q)N(1/q) = H^2 prod u_j^2 chi(q)chi(1/q) for N = H prod(q - s_i) prod(q - u_j) and the
    corrected (A.15), chi = q^d prod(q - s_i) prod(q - 1/u_j), for every split of n.
    """
    H = Symbol("H")
    for stable in range(n + 1):
        for unstable in range(n + 1 - stable):
            inside, outside = symbols(f"s:{stable}"), symbols(f"u:{unstable}")
            d = n - stable - unstable
            N = H * prod(q - x for x in inside) * prod(q - u for u in outside)
            chi = q**d * prod(q - x for x in inside) * prod(q - 1 / u for u in outside)
            constant = H**2 * prod(u**2 for u in outside)
            if expand(_on_circle(N) - constant * _on_circle(chi)) != 0:
                return False
    return True


def _on_circle(p: Expr) -> Expr:
    return p * p.subs(q, 1 / q)


def _same(left: Poly, right: Poly) -> bool:
    return bool(canonical(left - right).is_zero)
