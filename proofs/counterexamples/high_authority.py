"""Appendix A and (4.24) as they are printed."""

from collections.abc import Iterator

from sympy import (
    Expr,
    Matrix,
    Poly,
    Rational,
    Symbol,
    degree,
    eye,
    fraction,
    sqrt,
    together,
    zeros,
)

from compensator_theory import (
    StandardProblem,
    high_authority_target,
    polynomial,
    solve_riccati,
    standard_problem,
)
from compensator_theory.errors import UnitCircleError
from compensator_theory.matrices._linear_algebra import characteristic_polynomial

Facts = Iterator[tuple[str, bool]]
q = Symbol("q")


def printed_poles() -> Facts:
    """N_zu = q - 2, D = q^2 - 1/4, n = 2, d = 1: z^d N_s(z) N_u(1/z) has one zero, not two."""
    A, B, E = Matrix([[0, 1], [Rational(1, 4), 0]]), Matrix([0, 1]), Matrix([[-2, 1]])
    printed = together(q * (1 / q - 2))
    numerator, denominator = fraction(printed)
    zeros_minus_poles = degree(numerator, q) - degree(denominator, q)
    chi = characteristic_polynomial(
        A + B * Matrix(solve_riccati(A, B, E_1=E, time="discrete").K), q
    )
    yield "A + BC_c has the poles 0 and 1/2", chi == polynomial("q*(q - 1/2)")
    yield "the printed function has 1 zero more than poles", zeros_minus_poles == 1
    corrected = polynomial("q*(q - 1/2)")
    yield "q^d N_s q^n_u N_u(1/q)/N_u(0) is right", chi == corrected


def two_unstable_zeros() -> Facts:
    """N_zu = (q - 2)(q - 3), n = 3, d = 1, the sizes of Example A.2: the printed function has a
    pole at 0, and A + BC_c has an eigenvalue there.
    """
    A = Matrix([[0, 1, 0], [0, 0, 1], [Rational(1, 8), 0, 0]])
    B, E = Matrix([0, 0, 1]), Matrix([[6, -5, 1]])
    numerator, denominator = fraction(together(q * (1 / q - 2) * (1 / q - 3)))
    chi = characteristic_polynomial(
        A + B * Matrix(solve_riccati(A, B, E_1=E, time="discrete").K), q
    )
    yield "A + BC_c has the poles 0, 1/2, 1/3", chi == polynomial("q*(q - 1/2)*(q - 1/3)")
    yield "z^d N_s(z) N_u(1/z) is not 0 at 0", numerator.subs(q, 0) != 0
    yield "it has a pole there", denominator.subs(q, 0) == 0


def semidefinite_solutions() -> Facts:
    """A = 2, B = 1, R_1 = 0, R_2 = 1: P = 0 and P = 3 solve (A.7), and i)-iv) hold."""

    def residual(P: Rational) -> Rational:
        return 4 * P - 4 * P * P / (1 + P) - P

    def pole(P: Rational) -> Rational:
        return 2 - 2 * P / (1 + P)

    yield "P = 0 is a solution", residual(Rational(0)) == 0
    yield "P = 3 is a solution", residual(Rational(3)) == 0
    yield "with P = 0 the pole is 2", pole(Rational(0)) == 2
    yield "with P = 3 it is 1/2", pole(Rational(3)) == Rational(1, 2)


def semidefinite_without_stability() -> Facts:
    """N_zu = q - 2, R_2 = 0: P = E_1'E_1 solves (A.7) too, and its closed loop has the pole 2."""
    A, B, E = Matrix([[0, 1], [Rational(1, 4), 0]]), Matrix([0, 1]), Matrix([[-2, 1]])
    P = E.T * E
    W = (B.T * P * B)[0]
    K = -B.T * P * A / W
    residual = A.T * P * A + E.T * E - K.T * W * K - P
    yield "P = E_1'E_1 is a positive-semidefinite solution", residual == zeros(2, 2)
    chi = characteristic_polynomial(A + B * K, q)
    yield "its closed loop has the poles 0 and 2", chi == polynomial("q*(q - 2)")
    stabilising = Matrix(solve_riccati(A, B, E_1=E, time="discrete").P)
    yield "the stabilising solution is another one", stabilising != P


def zero_on_the_circle() -> Facts:
    """Poles 1/2, 3/10 and the zero 1, R_2 = 0: i) and ii) hold, and no solution is stabilising, for
    W chi(1)^2 = N_zu(1)^2 by the spectral factorisation.
    """
    plant = standard_problem("(q - 1)/((q - 1/2)*(q - 3/10))")
    eigenvalues = {Rational(1, 2), Rational(3, 10)}
    D = plant.denominator
    yield "A has no eigenvalue on the unit circle", all(D.eval(x) == 0 for x in eigenvalues)
    yield "N_zu is 0 at 1", plant.numerator("zu").eval(1) == 0
    A, B, E_1 = (Matrix(M) for M in (plant.A, plant.B, plant.E_1))
    P = E_1.T * E_1
    K = -(B.T * P * A) / (B.T * P * B)[0]
    residual = A.T * P * A + E_1.T * E_1 + A.T * P * B * K - P
    yield "P = E_1'E_1 is a positive-semidefinite solution", residual == zeros(2, 2)
    chi = characteristic_polynomial(A + B * K, q)
    yield "its closed loop has the poles 0 and 1", chi == polynomial("q*(q - 1)")
    try:
        solve_riccati(plant.A, plant.B, E_1=plant.E_1, time="discrete")
        refused = False
    except UnitCircleError:
        refused = True
    yield "solve_riccati refuses it", refused


def unsymmetric_solution() -> Facts:
    """A = diag(2, 3), B = [1; 1], E_1 = [1, -1], E_2 = 1: P = [[-4, 6 - 2 r], [6 + 2 r, -4]] with
    r^2 = 5 solves (A.7), and the spectral factorisation does not hold with it.
    """
    r, x = sqrt(5), Rational(2, 7)
    A, B, E_1 = Matrix.diag(2, 3), Matrix([1, 1]), Matrix([[1, -1]])
    P = Matrix([[-4, 6 - 2 * r], [6 + 2 * r, -4]])
    W = (1 + (B.T * P * B)[0]).expand()
    left, right = E_1.T + A.T * P * B, E_1 + B.T * P * A
    riccati = (A.T * P * A + E_1.T * E_1 - P - left * right / W).expand()
    yield "P solves (A.7)", riccati == zeros(2, 2)
    yield "P is not symmetric", P != P.T
    chi = (q * eye(2) - A + B * right / W).det()
    N = (E_1 * (q * eye(2) - A).adjugate() * B)[0] + (q * eye(2) - A).det()
    sides = W * chi.subs(q, x) * chi.subs(q, 1 / x), N.subs(q, x) * N.subs(q, 1 / x)
    difference = sides[0] - sides[1]
    yield "(R_2 + B'PB) chi(x) chi(1/x) is not N(x) N(1/x) at x = 2/7", difference.expand() != 0


def printed_target() -> Facts:
    """N_zu = 3(q - 2)(q - 1/3), N_yw = q - 4, N_yu = 1, n_c = n = 3: (4.24) literally, with d_yu or
    with d_yw for it, has the wrong relative degree and leading coefficient.
    """
    plant = _plant_of_target()
    n, d_zu, d_yw, d_yu = 3, 1, 2, 3
    degrees = [n - plant.numerator(channel).degree() for channel in ("zu", "yw", "yu")]
    yield "the relative degrees are 1, 2, 3", degrees == [d_zu, d_yw, d_yu]
    for name, d, printed_degree in (("d_yu", d_yu, 0), ("d_yw", d_yw, -1)):
        m = n - d_zu - d
        printed = together(3 * q**m * (q - 2) / ((1 / q - 2) * (1 / q - 4)))
        relative, leading = _at_infinity(*(Poly(part, q) for part in fraction(printed)))
        yield f"with {name}: relative degree {printed_degree}", relative == printed_degree
        yield f"with {name}: leading coefficient 3/8", leading == Rational(3, 8)
    target = high_authority_target(plant).transfer_function
    assert target is not None  # its zeros are rational
    relative, leading = _at_infinity(target.numerator, target.denominator)
    yield (
        "corrected: relative degree d_zu = 1 and leading coefficient 3",
        (relative, leading)
        == (
            d_zu,
            3,
        ),
    )


def _at_infinity(numerator: Poly, denominator: Poly) -> tuple[int, Expr]:
    return denominator.degree() - numerator.degree(), numerator.LC() / denominator.LC()


def _plant_of_target() -> StandardProblem:
    A = Matrix([[0, 1, 0], [0, 0, 1], [Rational(1, 8), 0, 0]])
    # N_zu = 3 (q - 2)(q - 1/3); N_yw = q - 4 through D_1 in the same coordinates
    B, E_1 = Matrix([0, 0, 1]), Matrix([[2, -7, 3]])
    C = Matrix([[1, 0, 0]])
    return StandardProblem(A, B, C, _input_for(A, C), None, None, E_1, None, None)


def _input_for(A: Matrix, C: Matrix) -> Matrix:
    """D_1 with the Markov parameters C D_1 = 0, CAD_1 = 1, CA^2D_1 = -4 of (q - 4)/(q^3 - 1/8)."""
    observability = Matrix.vstack(C, C * A, C * A * A)
    return observability.inv() * Matrix([0, 1, -4])


def undetected_growth() -> Facts:
    """A = 2, B = 1, R_1 = 0, R_2 = 1: P = 3 is stabilising, and (8.96) stays at P(0) = 0."""

    def step(P: Rational) -> Rational:
        return 4 * P - 4 * P**2 / (1 + P)

    P = Rational(3)
    yield "P = 3 solves (A.7)", step(P) == P
    pole = 2 - 2 * P / (1 + P)
    yield "its closed loop has the pole 1/2", pole == Rational(1, 2)
    yield "from P(0) = 0 every P(k) is 0", step(Rational(0)) == 0
