"""Recursions and regressors as Chapters 2 and 8 print them."""

from collections.abc import Iterator

from sympy import Matrix, Poly, Rational, Symbol, eye, kronecker_product

Facts = Iterator[tuple[str, bool]]


def transposed_vec() -> Facts:
    """l_u = 2, n_c = 1, P_1 = [1 2; 3 4], Q_1 = 0, u(k - 1) = [1; 0]: (2.30), (2.31) as printed."""
    P, Q = Matrix([[1, 2], [3, 4]]), Matrix([0, 0])
    coefficients = Matrix.hstack(P, Q)
    regressor = kronecker_product(Matrix([[1, 0, 0]]), eye(2))
    control = P * Matrix([1, 0])
    yield "(2.28) gives u = [1; 3]", control == Matrix([1, 3])
    yield "Phi vec([P_1 Q_1]) gives that", regressor * coefficients.vec() == control
    printed = regressor * coefficients.T.vec()
    yield "Phi vec([P_1 Q_1]') gives [1; 2]", printed == Matrix([1, 2])


def first_covariance() -> Facts:
    """lambda = 1/2, R_theta = 1, Phi_f(1) = 1, z(1) - u_f(1) = 1: if (2.43) also runs at k = 0,
    with Phi_f(0) = 0, from P(0) = R_theta^-1, the minimiser of (2.41) is missed.
    """
    half, e = Rational(1, 2), 1
    minimiser = -Rational(e) / (1 + half)  # of (theta + e)^2 + lambda theta^2

    def update(P: Rational) -> Rational:
        return -P * e / (half + P)

    yield "the minimiser of J(1) is -2/3", minimiser == Rational(-2, 3)
    yield "P(1) = R_theta^-1 gives it", update(Rational(1)) == minimiser
    yield "P(1) = P(0)/lambda gives -4/5", update(1 / half) == Rational(-4, 5)


def printed_subsystem_covariance() -> Facts:
    """P = I, phi(k - d - 1) = [1; 0], phi(k - d) = [-1/2; 0], lambda = 1: (8.63) as printed is
    indefinite.
    """
    P, phi, next_phi = eye(2), Matrix([1, 0]), Matrix([Rational(-1, 2), 0])

    def update(bracket: Matrix) -> Matrix:
        return P - P * phi * phi.T * P / ((phi.T * P * bracket)[0] + 1)

    yield "printed: P = diag(-1, 1)", update(next_phi) == Matrix.diag(-1, 1)
    yield "corrected: P = diag(1/2, 1)", update(phi) == Matrix.diag(Rational(1, 2), 1)


def unobservable_integrator() -> Facts:
    """(8.91) with C_a = [C 0]: the state gamma is not observable, its eigenvalue is 1, and Q of
    (8.100) grows by its process noise for ever.
    """
    A_a, C_a = Matrix([[Rational(1, 2), 0], [-1, 1]]), Matrix([[1, 0]])
    gamma = Matrix([0, 1])
    yield "A_a gamma = gamma and C_a gamma = 0", A_a * gamma == gamma and (C_a * gamma)[0] == 0
    Q, growth = Matrix.zeros(2, 2), []
    for _ in range(4):
        W = (C_a * Q * C_a.T)[0] + 1
        new = A_a * Q * A_a.T + eye(2) - A_a * Q * C_a.T * C_a * Q * A_a.T / W
        growth.append((new - Q)[1, 1])
        Q = new
    yield "Q_22 grows by at least V_1 = 1 in each step", all(g >= 1 for g in growth)


def filter_form_innovations() -> Facts:
    """(2.47), (2.48), one step from P(1) = 1, R = 1, Phi_f(1) = 1, Phi_f(2) = 2: Upsilon(k) and
    Upsilon(k + 1) of (2.44) are built with different regressors.
    """
    P, now, following = 1, 1, 2

    def Upsilon(Phi: int) -> int:
        return 1 + Phi * P * Phi

    posterior = Rational(1, 1 + following**2)  # (P^-1 + Phi' Phi)^-1
    yield "Upsilon(k) is 2 and Upsilon(k + 1) is 5", (Upsilon(now), Upsilon(following)) == (2, 5)
    printed = P - Rational(P * following**2 * P, Upsilon(now))
    yield "(2.47) with Upsilon(k) gives P = -1", printed == -1
    corrected = P - Rational(P * following**2 * P, Upsilon(following))
    yield "with Upsilon(k + 1) it gives 1/5", corrected == posterior == Rational(1, 5)


def not_well_posed() -> Facts:
    """D = q, N_yu = q + 1 (D_0 = 1) and D_c = N_c = q (k_c = 0, Q_0 = 1), which (2.28) allows:
    n + n_c is 2, and D D_c - N_yu N_c = -q.
    """
    q = Symbol("q")
    D, N_yu, D_c, N_c = Poly(q, q), Poly(q + 1, q), Poly(q, q), Poly(q, q)
    loop = D * D_c - N_yu * N_c
    yield "n + n_c = 2", D.degree() + D_c.degree() == 2
    yield "D_0 Q_0 = 1", N_yu.nth(1) * N_c.nth(1) == 1
    yield "D D_c - N_yu N_c has the degree 1", loop.degree() == 1
