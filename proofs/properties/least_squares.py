"""Recursive least squares against the minimiser of the whole cost, in rational arithmetic."""

from hypothesis import strategies as st
from sympy import Matrix, Rational, eye, ones, zeros

from compensator_theory.strategies import matrices, rationals

from ..ledger.checks import for_all

forgetting_factors = st.sampled_from([Rational(1), Rational(1, 2), Rational(9, 10)])
Step = tuple[Matrix, Matrix, Rational]  # Phi_f, z - u_f, R_u


@st.composite
def steps(draw: st.DrawFn, l_z: int = 2, l_theta: int = 3) -> list[Step]:
    """Draw up to three steps of data with R_u(i) >= 0."""
    step = st.tuples(
        matrices(l_z, l_theta), matrices(l_z, 1), rationals(4, 2).map(abs)
    )  # fmt: skip
    return [(Matrix(a), Matrix(b), r) for a, b, r in draw(st.lists(step, min_size=1, max_size=3))]


def recursive(data: list[Step], P: Matrix, theta: Matrix, forgetting: Rational) -> Matrix:
    """Run (2.42)-(2.44) with R_z = I from P(1) = P and theta(1) = theta."""
    for Phi, e, r in data:
        weight = eye(Phi.rows) / (1 + r)  # (R_z + R_u)^-1
        gain = P * Phi.T * (forgetting * weight + Phi * P * Phi.T).inv()
        theta = theta - gain * (Phi * theta + weight * e)
        P = (P - gain * Phi * P) / forgetting
    return theta


def batch(data: list[Step], R_theta: Matrix, theta: Matrix, forgetting: Rational) -> Matrix:
    """Minimise (2.41) by its normal equations."""
    k = len(data)
    hessian, right = forgetting**k * R_theta, forgetting**k * R_theta * theta
    for i, (Phi, e, r) in enumerate(data, start=1):
        hessian += forgetting ** (k - i) * (1 + r) * Phi.T * Phi
        right -= forgetting ** (k - i) * Phi.T * e
    return hessian.LUsolve(right)


@for_all(data=steps(), start=matrices(3, 1), forgetting=forgetting_factors)
def recursion_is_batch(data: list[Step], start: Matrix, forgetting: Rational) -> bool:
    """(2.42)-(2.44) from P(1) = R_theta^-1 and theta(1) = theta(0) give the minimiser of (2.41) at
    every k >= 1.
    """
    R_theta = Matrix(3, 3, lambda i, j: 1 + (i == j))
    theta = recursive(data, R_theta.inv(), Matrix(start), forgetting)
    return bool(theta == batch(data, R_theta, Matrix(start), forgetting))


@for_all(data=steps(l_z=1), beta=st.sampled_from([Rational(1, 3), Rational(5)]),
         forgetting=forgetting_factors)  # fmt: skip
def subsystem_recursion(data: list[Step], beta: Rational, forgetting: Rational) -> bool:
    """(8.62), (8.63) with phi(k - d - 1) in every place minimise (8.61), P(0) = beta I, with u*(i -
    d) and phi(i - d - 1) in the sum.
    """
    P, theta = beta * eye(3), zeros(3, 1)
    for row, target, _ in data:
        phi = row.T
        P = (P - P * phi * phi.T * P / (forgetting + (phi.T * P * phi)[0])) / forgetting
        theta = theta + P * phi * (target - phi.T * theta)
    rows = [(row, -target, Rational(0)) for row, target, _ in data]
    return bool(theta == batch(rows, eye(3) / beta, zeros(3, 1), forgetting))


@for_all(data=steps(), forgetting=forgetting_factors)
def unique_minimiser(data: list[Step], forgetting: Rational) -> bool:
    """The minimiser of (2.41) is unique: its Hessian is positive definite for R_theta > 0."""
    k = len(data)
    hessian = forgetting**k * (eye(3) + ones(3, 3))
    for i, (Phi, _, r) in enumerate(data, start=1):
        hessian += forgetting ** (k - i) * (1 + r) * Phi.T * Phi
    return all(hessian[:size, :size].det() > 0 for size in (1, 2, 3))


@for_all(data=steps(), star=matrices(3, 1), start=matrices(3, 1), forgetting=forgetting_factors)
def exact_match(data: list[Step], star: Matrix, start: Matrix, forgetting: Rational) -> bool:
    """Where z - u_f = -Phi_f theta* in every step and R_u = 0, the cost at theta(k + 1) is at most
    lambda^k times the square of theta* - theta(0) in R_theta.
    """
    R_theta, star, start = eye(3) + ones(3, 3), Matrix(star), Matrix(start)
    matched = [(Phi, -Phi * star, Rational(0)) for Phi, _, _ in data]
    theta, k = recursive(matched, R_theta.inv(), start, forgetting), len(data)

    def distance(x: Matrix) -> Rational:
        return forgetting**k * ((x - start).T * R_theta * (x - start))[0]

    residuals = [forgetting ** (k - i) * (Phi * theta + e).dot(Phi * theta + e)
                 for i, (Phi, e, _) in enumerate(matched, start=1)]  # fmt: skip
    return bool(sum(residuals) + distance(theta) <= distance(star))


@for_all(
    U=matrices(3, 3),
    phi=matrices(3, 1),
    d=st.lists(st.integers(1, 5), min_size=3, max_size=3),
    r=st.integers(1, 4),
    forgetting=forgetting_factors,
)
def ud_factors(U: Matrix, phi: Matrix, d: list[int], r: int, forgetting: Rational) -> bool:
    """Bierman's factors of (2.43), a column at a time: d > 0, U unit upper triangular, and their
    product is P - P phi phi' P / (r + phi' P phi) over lambda.
    """
    unit = Matrix(3, 3, lambda i, j: U[i, j] if i < j else int(i == j))
    P, f = unit * Matrix.diag(*d) * unit.T, unit.T * phi
    new, gain, alpha, d_new = unit.copy(), zeros(3, 1), Rational(r), []
    for j in range(3):
        v = d[j] * f[j]
        following = alpha + v * f[j]
        d_new.append(d[j] * alpha / following / forgetting)
        for i in range(j):
            new[i, j] = unit[i, j] - f[j] / alpha * gain[i]
            gain[i] += v * unit[i, j]
        gain[j], alpha = v, following
    expected = (P - P * phi * phi.T * P / (r + (phi.T * P * phi)[0])) / forgetting
    return bool(min(d_new) > 0 and new * Matrix.diag(*d_new) * new.T == expected)


@for_all(
    H=matrices(3, 2),
    E=matrices(3, 3),
    Z=matrices(3, 1),
    U=matrices(2, 1),
    other=matrices(2, 1),
    eta=st.integers(1, 3),
)
def retrospective_input(
    H: Matrix, E: Matrix, Z: Matrix, U: Matrix, other: Matrix, eta: int
) -> bool:
    """The cost (8.51) is quadratic with (8.53)-(8.55), and U* of (8.56) has a lower one than any
    other input.
    """
    weight = E.T * E

    def cost(X: Matrix) -> Rational:
        z = Z - H * U + H * X
        return (z.T * weight * z)[0] + eta * (X.T * X)[0]

    A = H.T * weight * H + eta * eye(2)
    B = 2 * H.T * weight * (Z - H * U)
    constant = ((Z - H * U).T * weight * (Z - H * U))[0]
    best = -A.inv() * B / 2
    quadratic = (other.T * A * other + B.T * other)[0] + constant
    return bool(cost(other) == quadratic and (other == best or cost(best) < cost(other)))
