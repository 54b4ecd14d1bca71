"""Responses in Hessenberg form, against LAPACK's and against 50 digits."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric import stability_margins
from rcac_numeric.analysis import _boundaries, _opened_loop
from rcac_numeric.analysis._resolvents import hessenberg_form, inverse_norms, responses

EPS = float(np.finfo(float).eps)


@st.composite
def systems(draw):
    """A, B, C of a few states, dense, companion, or a chain of delays; and points beside poles."""
    n, drawn = draw(st.integers(1, 12)), np.random.default_rng(draw(st.integers(0, 10**6)))
    A = drawn.standard_normal((n, n)) / np.sqrt(n)
    if draw(st.booleans()):
        A = np.eye(n, k=-1)
        A[0] = draw(st.sampled_from([0.0, 0.5])) * drawn.standard_normal(n)
    B, C = drawn.standard_normal((n, draw(st.integers(1, 2)))), drawn.standard_normal((2, n))
    z = np.exp(1j * np.linspace(0.1, 3, draw(st.sampled_from([1, 7, 130]))))
    return A, B, C, z


@given(systems())
def test_responses_and_slopes_are_those_of_lapack(system):
    A, B, C, z = system
    n = len(A)
    form = hessenberg_form(A, B, C)
    assert not np.tril(form[0], -2).any()
    inverses = np.linalg.inv(z[:, None, None] * np.eye(n) - A)
    sizes = np.linalg.norm(inverses, 2, axis=(1, 2))[:, None, None]
    scale = np.linalg.norm(B) * np.linalg.norm(C) * (1 + np.linalg.norm(A)) * n * 100 * EPS
    assert np.all(np.abs(responses(*form, z) - C @ inverses @ B) <= scale * sizes**2)
    slopes = responses(*form, z, slopes=True)
    assert np.all(np.abs(slopes + C @ inverses @ inverses @ B) <= 2 * scale * sizes**3)


@given(systems())
def test_norms_of_inverses_are_estimated_from_below_within_ten(system):
    """Higham's own experiments: more than 1/3 of the norm, nearly always; never above it."""
    A, B, C, z = system
    H = hessenberg_form(A, B, C)[0]
    exact = np.linalg.norm(np.linalg.inv(z[:, None, None] * np.eye(len(H)) - H), 1, axis=(1, 2))
    result = inverse_norms(H, z)
    assert np.all(result <= exact * (1 + 1e-6)) and np.all(result >= exact / 10)


def test_a_pole_is_infinite():
    A, B, C = np.diag([1.0, 0.5]), np.ones((2, 1)), np.ones((1, 2))
    points = np.array([1.0 + 0j, 2.0])
    result = responses(A, B, C, points)
    assert np.isinf(result[0, 0, 0]) and result[1, 0, 0] == 1 + 1 / 1.5
    with np.errstate(all="ignore"):
        assert inverse_norms(A, points).tolist() == [np.inf, 1.0]


@given(st.integers(0, 10**6), st.lists(st.sampled_from([0.1, 1.0, 10.0]), max_size=40))
def test_changes_of_sign_are_those_between_all_values_above_rounding(seed, sizes):
    drawn = np.random.default_rng(seed)
    value = np.array(sizes) * drawn.choice([-1, 1], len(sizes))
    shares = drawn.choice([0.0, 0.5, 5.0], len(sizes))
    omega = np.arange(len(sizes), dtype=float)

    def changes(values):
        signs = np.sign(value[values])
        return [(values[i], values[i + 1]) for i in np.flatnonzero(signs[1:] != signs[:-1])]

    _decided = _boundaries._above_rounding(omega, value, lambda points: shares[points.astype(int)])
    every = np.flatnonzero(np.abs(value) > shares)
    assert changes(_decided) == changes(every)


LOOPS = [
    "0.4/((z - 0.5)*z^3)", "0.02*(z + 0.9)/((z^2 - 1.9*z + 0.95)*z^2)", "(z - 0.8)*3/((z - 1)^2*z)",
    "1/(z*(z - 0.999))*0.001", "0.3*(z - 1.2)/(z - 0.2)^4",
]  # fmt: skip


@pytest.mark.parametrize("loop", LOOPS)
def test_margins_are_the_same_either_way(loop, monkeypatch):
    usual = stability_margins(loop, feedback=-1)
    monkeypatch.setattr(_opened_loop, "MANY_STATES", 1)
    other = stability_margins(loop, feedback=-1)
    assert other.is_stable == usual.is_stable
    assert np.allclose(other.gain_crossovers, usual.gain_crossovers, rtol=1e-9, atol=1e-9)
    assert np.allclose(other.phase_crossovers, usual.phase_crossovers, rtol=1e-9, atol=1e-9)
    for name in ("gain_up", "gain_down", "phase_lag", "phase_lead", "delay"):
        first, second = getattr(usual, name), getattr(other, name)
        assert (first is None) == (second is None)
        assert first is None or second.value == pytest.approx(first.value, rel=1e-9)


@pytest.mark.parametrize("delay", [60, 100])
def test_margins_of_long_dead_time(delay, monkeypatch):
    """L = 0.004 z^-d/(z - 0.995): its gain margin is where the phase is first -180 degrees.

    LAPACK is asked for no stack of large systems, one for each of thousands of points.
    """
    for name in ("solve", "inv"):

        def checked(first, *others, usual=getattr(np.linalg, name)):
            assert np.ndim(first) == 2 or np.shape(first)[-1] < 48
            return usual(first, *others)

        monkeypatch.setattr(np.linalg, name, checked)
    margins = stability_margins(f"0.004/((z - 0.995)*z^{delay})", feedback=-1)
    with mpmath.workdps(50):
        pole, gain = mpmath.mpf(0.995), mpmath.mpf(0.004)

        def turned(omega):
            return mpmath.arg(mpmath.expj(omega) - pole) + delay * omega - mpmath.pi

        omega = mpmath.findroot(turned, (0.5 / delay, 3.0 / delay), solver="anderson")
        margin = abs(mpmath.expj(omega) - pole) / gain
    assert margins.is_stable and margins.gain_up.frequency == pytest.approx(float(omega), rel=1e-10)
    assert margins.gain_up.value == pytest.approx(float(margin), rel=1e-9)
    assert margins.worst_gap < 1e-9
    assert len(margins.phase_crossovers) == delay // 2 + 1
