"""The derivation (4.1)-(4.18) of the intercalated transfer function, each step recomputed."""

import sympy
from sympy import Expr, IndexedBase, Matrix, Sum, Symbol, expand, kronecker_product, symbols

from compensator_theory import (
    StandardProblem,
    compensator_polynomials,
    intercalated_transfer_matrix,
)
from compensator_theory.polynomials._poly import canonical

# Operators and signals of any size: letters that do not commute. q commutes with all of them.
q, n_c = symbols("q n_c", positive=True)
z, y, w, u, u_star, u_tilde, theta, Phi, G_f = symbols(
    "z y w u u_* u_~ theta Phi G_f", commutative=False
)
G_zw, G_zu, G_yw, G_yu, D_c, N_c, S = symbols("G_zw G_zu G_yw G_yu D_c N_c S", commutative=False)
G_c = D_c**-1 * N_c
LOOP = G_yu * G_c


def with_inverse(expression: Expr) -> Expr:
    r"""Simplify with :math:`S = (I - G_{yu}G_c)^{-1}`, that is, :math:`S G_{yu}G_c = S - I`.

    Examples
    --------
    >>> from proofs.symbolic.intercalation import LOOP, S, with_inverse
    >>> with_inverse(S * (1 - LOOP)), with_inverse((1 - LOOP) * S)
    (1, 1)
    """
    previous, current = None, expand(expression)
    while current != previous:
        previous = current
        current = expand(current.subs(S * LOOP, S - 1).subs(LOOP * S, S - 1))
    return current


def retrospective_performance() -> bool:
    """(2.36) is (4.1): the filter acts on u - Phi theta as a whole."""
    return bool(expand(z + G_f * Phi * theta - G_f * u - (z - G_f * (u - Phi * theta))) == 0)


def residual_of_the_fit() -> bool:
    """(4.2)-(4.6): at theta* the residual is z - G_f u~."""
    residual = z - G_f * (u - Phi * theta)
    renamed = residual.subs(Phi * theta, u_star).subs(u, u_star + u_tilde)
    return bool(expand(renamed - (z - G_f * u_tilde)) == 0)


def regressor_layout() -> bool:
    """(2.28)-(2.31): Phi theta lists exactly the terms of the controller, l_u = l_y = n_c = 2.

    It is if theta stacks the columns of [P_1 ... Q_n_c] itself; the transpose that (2.31) prints
    under vec would permute theta for l_u > 1.
    """
    l_u, l_y, order = 2, 2, 2
    P = [Matrix(l_u, l_u, symbols(f"p{i}_:{l_u * l_u}")) for i in range(1, order + 1)]
    Q = [Matrix(l_u, l_y, symbols(f"q{i}_:{l_u * l_y}")) for i in range(1, order + 1)]
    past_u = [Matrix(symbols(f"u{i}_:{l_u}")) for i in range(1, order + 1)]
    past_y = [Matrix(symbols(f"y{i}_:{l_y}")) for i in range(1, order + 1)]
    regressor = kronecker_product(Matrix.vstack(*past_u, *past_y).T, sympy.eye(l_u))
    coefficients = Matrix.hstack(*P, *Q).vec()
    control = sympy.zeros(l_u, 1)
    for matrix, signal in zip([*P, *Q], [*past_u, *past_y], strict=True):
        control += matrix * signal
    return bool((regressor * coefficients - control).expand().is_zero_matrix)


def controller_with_perturbation() -> bool:
    """(4.7): u = u* + u~ splits the past controls, for every n_c (scalar signals)."""
    k, k_c, i = symbols("k k_c i", integer=True)
    P, Q, v, v_star, v_tilde, m = map(IndexedBase, ("P", "Q", "u", "us", "ut", "y"))
    through_y = Sum(Q[i] * m[k - i], (i, k_c, n_c))
    sum_of_past = Sum(P[i] * v[k - i], (i, 1, n_c)) + through_y
    split = sum_of_past.replace(
        lambda e: e.base == v if e.is_Indexed else False,
        lambda e: v_star[e.indices[0]] + v_tilde[e.indices[0]],
    )
    claimed = (
        Sum(P[i] * v_star[k - i], (i, 1, n_c)) + Sum(P[i] * v_tilde[k - i], (i, 1, n_c)) + through_y
    )
    return bool(expand(split.doit().expand() - claimed.expand()) == 0)


def controller_in_the_shift() -> bool:
    """(4.8)-(4.11): u* solves its own difference equation; q^n_c I - D_c collects the P_i."""
    collected_P = q**n_c - D_c  # (4.9)
    times_q = q**n_c * u_star - (collected_P * (u_star + u_tilde) + N_c * y)  # (4.7), vanishes
    solved = D_c**-1 * ((q**n_c - D_c) * u_tilde + N_c * y)  # (4.8)
    return bool(expand(times_q.subs(u_star, solved)) == 0)


def substituted_controller() -> bool:
    """(4.12), (4.13): the control is D_c^-1 (q^n_c u~ + N_c y)."""
    bracket = D_c**-1 * ((q**n_c - D_c) * u_tilde + N_c * y) + u_tilde
    return bool(expand(bracket - D_c**-1 * (q**n_c * u_tilde + N_c * y)) == 0)


def _solved_for_y() -> Expr:
    return S * (G_yw * w + q**n_c * G_yu * D_c**-1 * u_tilde)


def measurement_with_loop_closed() -> bool:
    """(4.13) solved for y: y = S (G_yw w + q^n_c G_yu D_c^-1 u~)."""
    solved = _solved_for_y()
    right_side = G_yw * w + G_yu * D_c**-1 * (q**n_c * u_tilde + N_c * solved)
    return bool(with_inverse(solved - right_side) == 0)


def performance_with_loop_closed() -> bool:
    """(4.14)-(4.16): z is the sum of two closed-loop responses."""
    performance = G_zw * w + G_zu * D_c**-1 * (q**n_c * u_tilde + N_c * _solved_for_y())
    from_w = G_zw + G_zu * G_c * S * G_yw
    from_u_tilde = q**n_c * G_zu * (D_c**-1 + G_c * S * G_yu * D_c**-1)
    return bool(expand(performance - from_w * w - from_u_tilde * u_tilde) == 0)


def compact_form() -> bool:
    """(4.16): the bracket is the inverse of D_c - N_c G_yu, from both sides."""
    bracket, inverse = D_c**-1 + G_c * S * G_yu * D_c**-1, D_c - N_c * G_yu
    left = with_inverse(bracket * inverse)
    right = with_inverse(D_c**-1 * inverse * bracket * D_c)
    return bool(left == 1 and right == 1)


def scalar_form() -> bool:
    """(4.16), (4.17) and (4.18) agree for scalar signals, for every n_c."""
    D, d, c, N_zu, N_yu = symbols("D D_c N_c N_zu N_yu")
    from_matrices = (
        q**n_c * (N_zu / D) * (1 / d + (c / d) / (1 - (N_yu / D) * (c / d)) * (N_yu / D) / d)
    )
    loop = D * d - N_yu * c
    with_two_terms = N_zu * q**n_c / (D * d) + N_zu * c * N_yu * q**n_c / (D * d * loop)
    claimed = N_zu * q**n_c / loop
    return bool(
        sympy.simplify(from_matrices - with_two_terms) == 0
        and sympy.simplify(with_two_terms - claimed) == 0
    )


def external_perturbation() -> bool:
    """(4.19): a perturbation added after the controller sees D_c in place of q^n_c."""
    D, d, c, N_zu, N_yu, control = symbols("D D_c N_c N_zu N_yu u")
    perturbation = Symbol("u_bar")
    loop = sympy.Eq(control, (c / d) * (N_yu / D) * control + perturbation)
    performance = (N_zu / D) * sympy.solve(loop, control)[0]
    return bool(sympy.simplify(performance / perturbation - N_zu * d / (D * d - N_yu * c)) == 0)


def hidden_factor() -> bool:
    """(2.11): D divides the numerator, so that the loop has n + n_c poles; n = 2, 16 letters."""
    plant = _generic_plant(has_direct_terms=True)
    minor = plant.numerator("zu") * plant.numerator("yw") - plant.numerator("zw") * (
        plant.numerator("yu")
    )
    return bool(canonical(minor.rem(plant.denominator)).is_zero)


def generic_plant() -> bool:
    """(4.18) is the response of the closed loop's own state space; n = 2, every entry a letter."""
    plant = _generic_plant(has_direct_terms=False)
    P, Q = symbols("P_1 Q_1")
    memory = Matrix([[P, Q]])  # acts on u(k-1), y(k-1)
    closed = Matrix.vstack(
        Matrix.hstack(plant.A, plant.B * memory),
        Matrix.hstack(sympy.zeros(1, 2), memory),
        Matrix.hstack(plant.C, sympy.zeros(1, 2)),
    )
    enters = Matrix.vstack(plant.B, Matrix([1, 0]))
    leaves = Matrix.hstack(plant.E_1, sympy.zeros(1, 2))
    loop = StandardProblem(closed, enters, leaves, enters, None, None, leaves, None, None)
    claimed = intercalated_transfer_matrix(plant, *compensator_polynomials([P], [Q], 1, 1)).scalar()
    measured = loop.transfer_function("zu")
    difference = claimed.numerator * measured.denominator - measured.numerator * claimed.denominator
    return bool(canonical(difference).is_zero)


def _generic_plant(has_direct_terms: bool) -> StandardProblem:
    """Order 2, all signals scalar, every entry a letter of its own."""
    A = Matrix(2, 2, symbols("a:4"))
    B, C, D_1, E_1 = (Matrix(symbols(f"{name}:2")) for name in "bcde")
    D_0, D_2, E_2, E_0 = (
        Matrix([symbol]) if has_direct_terms else None for symbol in symbols("f:4")
    )
    return StandardProblem(A, B, C.T, D_1, D_0, D_2, E_1.T, E_2, E_0)
