"""The intercalated transfer function, held against recorded signals of any origin."""

from hypothesis import strategies as st
from sympy import Matrix, Rational

from compensator_theory import (
    StandardProblem,
    compensator_polynomials,
    intercalated_transfer_matrix,
)
from compensator_theory.strategies import rationals, standard_problems

from ..ledger.checks import for_all

STEPS = 6
coefficients = st.lists(rationals(3, 2), min_size=2, max_size=2)


def power_series(numerator: list[Rational], denominator: list[Rational]) -> list[Rational]:
    """Expand a proper rational function in powers of 1/q; the lists hold descending coefficients.

    Examples
    --------
    >>> from proofs.properties.recorded_data import power_series
    >>> power_series([1], [1, -2])[:4]
    [0, 1, 2, 4]
    """
    rest = [Rational(0)] * (len(denominator) - len(numerator)) + list(numerator)
    rest += [Rational(0)] * STEPS
    series = []
    for k in range(STEPS):
        leading = rest[k] / denominator[0]
        series.append(leading)
        for i, coefficient in enumerate(denominator):
            rest[k + i] -= leading * coefficient
    return series


@for_all(
    plant=standard_problems(max_order=3, max_signals=1),
    P=coefficients,
    Q=coefficients,
    u=st.lists(rationals(3, 2), min_size=STEPS, max_size=STEPS),
)
def recorded_signals(
    plant: StandardProblem, P: list[Rational], Q: list[Rational], u: list[Rational]
) -> bool:
    """(4.14) for w = 0 and x(0) = 0: whatever the recorded u and the fixed theta*, z is the
    intercalated transfer function applied to u~ = u - Phi theta*.
    """
    A, B, C, E_1, E_2 = (Matrix(getattr(plant, name)) for name in ("A", "B", "C", "E_1", "E_2"))
    x, y, z = Matrix([0] * A.rows), [], []
    for control in u:
        y.append((C * x)[0])
        z.append((E_1 * x)[0] + E_2[0] * control)
        x = A * x + B * control

    def past(signal: list[Rational], k: int) -> Rational:
        return signal[k] if k >= 0 else Rational(0)

    u_tilde = [
        u[k] - sum(P[i - 1] * past(u, k - i) + Q[i - 1] * past(y, k - i) for i in (1, 2))
        for k in range(STEPS)
    ]
    G = intercalated_transfer_matrix(plant, *compensator_polynomials(P, Q, 2, 1)).scalar()
    g = power_series(G.numerator.all_coeffs(), G.denominator.all_coeffs())
    return z == [sum(g[i] * u_tilde[k - i] for i in range(k + 1)) for k in range(STEPS)]
