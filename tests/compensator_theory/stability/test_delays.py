"""Windows of a delay: published ones, and winding numbers at drawn delays."""

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import CompensatorError, InputError, stability_delays
from compensator_theory.errors import NoSolutionError
from compensator_theory.strategies import polynomials
from tests.support.structure_cases import fewer

PI = np.pi


def ends(delays):
    return [(float(a), np.inf if b is None else float(b)) for a, b in delays.windows]


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        (["s", "1"], [(0, PI / 2)]),
        (["s + 1", "2"], [(0, np.arccos(-1 / 2) / np.sqrt(3))]),
        (["s**2 - s/10 + 2", "-1"], [(0.100168268, 1.717858178)]),
        (["s**3 + s**2 + 2*s + 1", "1"], [(PI / 2, PI * 2**0.5), (5 * PI / 2, 2 * PI * 2**0.5)]),
        (["s**2 + 4", "-1"], [(0, PI / 5**0.5), (2 * PI / 3**0.5, 3 * PI / 5**0.5)]),
        (["s**2 + 2*s + 5", "4"], [(0, np.inf)]),
        (["s + 2", "1"], [(0, np.inf)]),
        (["s - 1", "1/2"], []),
    ],
)
def test_published_windows(coefficients, expected):
    """Cooke and van den Driessche; Gu, Kharitonov and Chen's third; the rest by hand."""
    assert np.allclose(ends(stability_delays(coefficients)), expected, atol=1e-8)


def test_a_crossing_on_the_branch_cut_of_the_argument():
    """s^2 + s + 3 + (s + 1) exp(-tau s) at s = j sqrt(2), where the exponential is -1."""
    delays = stability_delays(["s**2 + s + 3", "s + 1"])
    (crossing,) = [c for c in delays.crossings if c.square == 2]
    assert float(crossing.frequency) == pytest.approx(2**0.5)
    assert float(crossing.first) == pytest.approx(PI / 2**0.5)


def test_several_multiples_of_the_delay():
    """Olgac and Sipahi (2002): 3 x 3 with exp(-tau s) to the third power, from its determinant."""
    s, z = sympy.symbols("s z")
    A = sympy.Matrix([["-1", "135/10", "-1"], ["-3", "-1", "-2"], ["-2", "-1", "-4"]])
    B = sympy.Matrix([["-59/10", "71/10", "-703/10"], ["2", "-1", "5"], ["2", "0", "6"]])
    P = sympy.Poly((s * sympy.eye(3) - A - B * z).det(), z)
    coefficients = [P.coeff_monomial(z**k) for k in range(4)]
    delays = stability_delays(coefficients, variable="s")
    frequencies = sorted(float(c.frequency) for c in delays.crossings)
    assert np.allclose(frequencies, [0.84, 2.11, 2.91, 3.04, 15.50], atol=6e-3)
    assert np.allclose(ends(delays), [(0, 0.162346), (0.185906, 0.221985)], atol=2e-6)


def winding(polys, delay):
    """The unstable roots by the change of the argument along the axis; None near a crossing."""
    values = [np.array([float(c) for c in p.all_coeffs()]) for p in polys]
    n = len(values[0]) - 1
    w = np.concatenate([np.linspace(0, 60, 120_001), np.geomspace(60, 1e5, 20_000)[1:]])

    def at(w):
        s = 1j * w
        return sum(np.polyval(a, s) * np.exp(-k * delay * s) for k, a in enumerate(values))

    line = at(w) / (1j * w + 1) ** n
    if abs(line).min() < 1e-2:
        return None
    angle = np.unwrap(np.angle(line))
    # (s + 1)^n turns by n pi/2 and has no unstable root
    return -(angle[-1] - angle[0]) / PI


@fewer(6)
@given(
    polynomials(min_degree=2, max_degree=3, is_monic=True),
    st.lists(polynomials(max_degree=1), min_size=1, max_size=2),
    st.lists(
        st.fractions(min_value="1/20", max_value=6, max_denominator=20), min_size=3, max_size=3
    ),
)
def test_unstable_roots_against_winding_numbers(a_0, others, delays):
    try:
        result = stability_delays([a_0, *others])
    except CompensatorError:
        assume(False)
    for delay in delays:
        count = winding(result.coefficients, float(delay))
        if count is None:
            continue
        assert abs(count - round(count)) < 0.05
        assert result.unstable_roots(delay) == round(count)
        inside = any(a < float(delay) < b for a, b in ends(result))
        assert (delay in result) == inside


def test_roots_on_the_axis_without_delay():
    """s**2 + 4 - exp(-tau s) at 0 has roots at +-j sqrt(3): which way they go, by a small delay."""
    delays = stability_delays(["s**2 + 4", "-1"])
    assert delays.unstable_without == 0 and "1/100" in delays
    other = stability_delays(["s**2 + 4", "1"])
    count = winding(other.coefficients, 0.3)
    assert other.unstable_roots("3/10") == round(count) == 2


def test_what_it_says_and_refuses():
    delays = stability_delays(["s**2 + 2*s + 5", "4"])
    assert "touch the axis" in str(delays) and delays._repr_latex_().startswith("$")
    assert delays.crossings[0].tendency == 0 and delays.crossings[0].square == 3
    with pytest.raises(InputError, match="neutral"):
        stability_delays(["s + 1", "s"])
    with pytest.raises(InputError, match="power of the variable"):
        stability_delays(["z + 1", "1"])
    with pytest.raises(InputError, match=r"give \[D, N\]"):
        stability_delays("2/(s + 1)")
    with pytest.raises(InputError, match="decide_stability"):
        stability_delays(["s + 1"])
    with pytest.raises(NoSolutionError, match="every delay"):
        stability_delays(["s**2 + s", "s"])
    with pytest.raises(NoSolutionError, match="divide"):
        stability_delays(["(s**2 + 1)*(s + 1)", "s**2 + 1"])
    with pytest.raises(InputError, match="positive rational"):
        delays.unstable_roots(-1)
