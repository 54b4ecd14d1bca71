"""Errors and derivatives of Box-Jenkins models: SciPy's filters, an SVD, and differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from rcac_numeric.compiled._box_jenkins import confined, student_scale
from rcac_numeric.identification._box_jenkins import CIRCLE, OF_C, NoiseModel, Start, _Errors
from rcac_numeric.identification._least_squares import minimised
from rcac_numeric.identification._process_records import process_record
from tests.support.strategies import seeds

STEPS = 200
POLES = {0: [], 1: [0.8], 2: [0.9, 0.3], 3: [0.9, 0.5 + 0.3j, 0.5 - 0.3j]}
structures = st.fixed_dictionaries({
    "n": st.integers(0, 3), "m": st.integers(1, 3), "n_C": st.integers(0, 2),
    "n_D": st.integers(0, 2), "differences": st.integers(0, 1), "delay": st.integers(0, 3),
    "summed": st.booleans(), "slope": st.booleans(), "armax": st.booleans(),
    "sinusoid": st.sampled_from([0.0, 0.07]), "jump": st.sampled_from([0, 30, 120]),
})  # fmt: skip


def polynomial(roots):
    return np.atleast_1d(np.real(np.poly(roots)))


def case(seed, structure, weighted):
    """A record, a start and weights."""
    s, rng = structure, np.random.default_rng(seed)
    u = rng.standard_normal(STEPS)
    y = lfilter([0, 0, 0.5], [1, -0.8], u) + 0.3 * rng.standard_normal(STEPS)
    noise = NoiseModel(
        polynomial([0.3, -0.5][: s["n_C"]]),
        polynomial([0.6, 0.2][: s["n_D"]]), s["differences"],
    )  # fmt: skip
    A = polynomial(POLES[s["n"]])
    start = Start(
        A, rng.standard_normal(s["m"]), s["delay"], noise, s["summed"], s["slope"], s["armax"],
        s["sinusoid"], s["jump"],
    )  # fmt: skip
    weights = 1 + 0.5 * np.sin(np.arange(STEPS)) if weighted else None
    return process_record(u, y), start, weights


def free_rows(start):
    """Level, slope, jump, sinusoid and responses to initial states, before the whitener."""
    k = np.arange(STEPS)
    rows = [np.ones(STEPS)]
    if start.slope or start.summed:
        rows.append(k / (STEPS - 1))
    if start.jump:
        rows.append(1.0 * (k >= start.jump))
    if start.sinusoid:
        rows += [np.cos(start.sinusoid * k), np.sin(start.sinusoid * k)]
    for i in range(len(start.A) - 1):
        rows.append(lfilter([1], [1] if start.armax else start.A, 1.0 * (k == i)))
    return np.stack(rows)


def reference(record, start, weights):
    """The errors, their derivatives, and the basis of what is free."""
    D = start.noise.D
    W = np.convolve(D, [1, -1]) if start.noise.differences else D
    C, A, B = start.noise.C, start.A, np.r_[0, start.B]
    w = np.ones(STEPS) if weights is None else weights
    u = np.r_[np.zeros(start.delay), record.u][:STEPS]
    u = np.cumsum(u) if start.summed else u
    x = lfilter(B, [1] if start.armax else A, u)
    v = (lfilter(A, [1], record.y) if start.armax else record.y) - x
    raw = free_rows(start)
    free = w * lfilter(W, C, raw)
    U, sizes, _ = np.linalg.svd((free / np.linalg.norm(free, axis=1)[:, None]).T, False)
    assert sizes[-1] > 1e-8
    coefficients = np.linalg.lstsq(free.T, w * lfilter(W, C, v), rcond=None)[0]
    v = v - coefficients @ raw
    n = len(A) - 1
    state = coefficients[len(raw) - n :] @ raw[len(raw) - n :]
    by_A = lfilter(W, C, record.y) if start.armax else lfilter(W, np.convolve(C, A), x + state)
    by_B = lfilter(W, C, -u) if start.armax else lfilter(W, np.convolve(C, A), -u)
    by_C = -lfilter(W, np.convolve(C, C), v)
    by_D = lfilter([1, -1] if start.noise.differences else [1], C, v)
    J = []
    for signal, count in ((by_A, n), (by_B, len(start.B)), (by_C, len(C) - 1), (by_D, len(D) - 1)):
        J += [np.r_[np.zeros(i), signal[:-i]] for i in range(1, count + 1)]
    if start.sinusoid:
        k, at = np.arange(STEPS), len(raw) - n - 2
        a, b = coefficients[at : at + 2]
        omega = start.sinusoid
        J.append(lfilter(W, C, k * (a * np.sin(omega * k) - b * np.cos(omega * k))))
    J = w * np.stack(J)
    return w * lfilter(W, C, v), J - (J @ U) @ U.T, U


@given(seed=seeds, structure=structures, weighted=st.booleans())
def test_the_errors_are_those_of_scipy(seed, structure, weighted):
    record, start, weights = case(seed, structure, weighted)
    point = _Errors(record, start, weights).at(start.coefficients)
    e, J, _ = reference(record, start, weights)
    assert point.e == pytest.approx(e, rel=0, abs=1e-9 * np.abs(e).max())
    assert point.square == pytest.approx(e @ e, rel=1e-9)
    assert np.array_equal(point.theta, start.coefficients)
    for row, other in zip(point.jacobian(), J, strict=True):
        assert row == pytest.approx(other, rel=0, abs=1e-9 * np.abs(J).max())


@given(seed=seeds, structure=structures, weighted=st.booleans())
def test_the_gradient_is_that_of_the_prediction_errors(seed, structure, weighted):
    record, start, weights = case(seed, structure, weighted)
    errors, theta, h = _Errors(record, start, weights), start.coefficients, 1e-6
    U = reference(record, start, weights)[2]
    for k, row in enumerate(errors.at(theta).jacobian()):
        step = h * np.eye(len(theta))[k]
        difference = (errors.at(theta + step).e - errors.at(theta - step).e) / (2 * h)
        # Kaufman's: the part in the space of what is free is left out.
        difference -= U @ (U.T @ difference)
        assert np.abs(difference - row).max() < 1e-5 * (1 + np.abs(row).max())


@given(seed=seeds, structure=structures, waves=st.booleans())
def test_the_remainder_has_the_errors(seed, structure, waves):
    """Whitened it is e; with its sinusoid it differs from that by cosine and sine alone."""
    record, start, _ = case(seed, structure, weighted=False)
    point = _Errors(record, start, None).at(start.coefficients)
    v = point.remainder(True)
    white = lfilter(start.noise.whitener, start.noise.C, v)
    assert white == pytest.approx(point.e, rel=0, abs=1e-9 * np.abs(v).max())
    k = np.arange(STEPS)
    sinusoid = np.stack([np.cos(start.sinusoid * k), np.sin(start.sinusoid * k)])[:, :STEPS]
    with_waves = point.remainder(waves) - v
    rest = np.linalg.lstsq(sinusoid.T, with_waves, rcond=None)[0] @ sinusoid - with_waves
    assert np.abs(rest).max() <= 1e-9 * np.abs(v).max()
    assert bool(with_waves.any()) == (not waves and start.sinusoid > 0)


@pytest.mark.parametrize("armax", [False, True])
def test_a_row_that_depends_on_the_others_is_not_in_the_basis(armax):
    """A jump in the first row is the level: errors and derivatives are those without it."""
    structure = {
        "n": 2, "m": 2, "n_C": 1, "n_D": 1, "differences": 0, "delay": 1, "summed": False,
        "slope": True, "armax": armax, "sinusoid": 0.0, "jump": 0,
    }  # fmt: skip
    record, start, _ = case(0, structure, weighted=False)
    plain, doubled = _Errors(record, start, None), _Errors(record, start, None)
    doubled.levels = np.concatenate([plain.levels, plain.levels[:1], np.zeros((1, STEPS))])
    one, other = plain.at(start.coefficients), doubled.at(start.coefficients)
    assert one.e == pytest.approx(other.e, rel=0, abs=1e-12 * np.abs(one.e).max())
    assert one.jacobian() == pytest.approx(other.jacobian(), rel=0, abs=1e-10)
    assert one.remainder(True) == pytest.approx(other.remainder(True), rel=0, abs=1e-10)


def test_errors_beyond_float64_are_none():
    record, start, _ = case(0, {
        "n": 1, "m": 1, "n_C": 1, "n_D": 0, "differences": 0, "delay": 0, "summed": False,
        "slope": False, "armax": False, "sinusoid": 0.0, "jump": 0,
    }, weighted=False)  # fmt: skip
    theta = np.array([-1e3, 1.0, 0.1])
    assert _Errors(record, start, None).at(theta) is None


class OfPython:
    """The same errors for the loop in Python, their roots and frequency confined by NumPy."""

    def __init__(self, errors):
        self.errors, self.at = errors, errors.at

    def confined(self, theta):
        A, B, noise = self.errors.split(theta)
        A = A if self.errors.start.armax else with_roots_within(A, CIRCLE)
        C, D = with_roots_within(noise.C, OF_C), with_roots_within(noise.D, CIRCLE)
        rest = theta[len(A) + len(B) + len(C) + len(D) - 3 :]
        frequency = np.abs(np.angle(np.exp(1j * rest)))
        return np.concatenate([A[1:], B, C[1:], D[1:], frequency])


def with_roots_within(A, radius):
    roots = np.roots(A)
    size = np.abs(roots)
    outside, beyond = size > radius, size > 1 / radius
    if not outside.any():
        return A
    roots[outside] *= radius / size[outside]
    roots[beyond] /= radius * size[beyond]
    return polynomial(roots)


@given(
    seed=seeds, structure=structures, weighted=st.booleans(), iterations=st.integers(0, 12),
    is_kept=st.booleans(), spread=st.sampled_from([0.0, 0.1, 1.0]),
)  # fmt: skip
def test_the_least_errors_are_those_of_the_loop_in_python(
    seed, structure, weighted, iterations, is_kept, spread
):
    """Of starts inside and outside the circles; a step of rounding may turn where many are flat."""
    record, start, weights = case(seed, structure, weighted)
    errors = _Errors(record, start, weights)
    rng = np.random.default_rng(seed + 1)
    theta = start.coefficients + spread * rng.standard_normal(len(start.coefficients))
    kept = errors.n + errors.m if is_kept else 0
    point, J = errors.minimised(theta, iterations, kept)
    other, of_other = minimised(OfPython(errors), theta, STEPS, iterations, kept)
    first = OfPython(errors).confined(theta)
    assert point.theta[:kept] == pytest.approx(first[:kept], rel=1e-9, abs=1e-9)
    assert np.array_equal(J, point.jacobian())
    assert point.square <= errors.at(first).square * (1 + 1e-9)
    size = np.linalg.norm(of_other, axis=1)
    if len(size) and np.linalg.cond(of_other / np.where(size > 0, size, 1.0)[:, None]) > 1e3:
        return
    assert point.square == pytest.approx(other.square, rel=1e-6)
    assert point.theta == pytest.approx(other.theta, rel=1e-5, abs=1e-5)
    assert point.e == pytest.approx(other.e, rel=0, abs=1e-5 * np.abs(other.e).max())


def test_a_start_beyond_float64_has_no_least_errors():
    record, start, _ = case(0, {
        "n": 1, "m": 1, "n_C": 0, "n_D": 0, "differences": 0, "delay": 0, "summed": False,
        "slope": False, "armax": True, "sinusoid": 0.0, "jump": 0,
    }, weighted=False)  # fmt: skip
    errors = _Errors(record, start, None)
    assert errors.minimised(np.array([0.1, np.nan]), 5) is None
    assert errors.minimised(np.array([1e308, 1e308]), 5) is None


@given(st.lists(st.floats(-3, 3), min_size=0, max_size=5), st.sampled_from([0.98, 0.995, 1.0]))
def test_confined_roots_are_those_of_numpy(a, radius):
    A = np.r_[1.0, a]
    within, other = confined(A, radius), with_roots_within(A, radius)
    # Of equal roots both are off by the root of rounding, their polynomials by less.
    assert within == pytest.approx(other, rel=0, abs=1e-5 * np.abs(A).max())
    if not (np.abs(np.roots(A)) > radius - 1e-9).any():
        assert np.array_equal(within, A)


def test_what_is_not_finite_is_not_confined():
    for bad in (np.nan, np.inf, -np.inf):
        assert np.array_equal(
            confined(np.array([1.0, bad, 0.2]), 0.9), [1, bad, 0.2], equal_nan=True
        )


@given(seed=seeds, steps=st.integers(1, 60), degrees=st.sampled_from([3.0, 4.0]),
       passes=st.integers(0, 12), least=st.sampled_from([1e-150, 1.0]))  # fmt: skip
def test_the_scale_of_student_is_that_of_reweighted_squares(seed, steps, degrees, passes, least):
    e = np.random.default_rng(seed).standard_t(3, steps)
    scale = max(np.sqrt(np.median(e**2)), least)
    for _ in range(passes):
        weights = (degrees + 1) / (degrees + (e / scale) ** 2)
        scale = max(np.sqrt(np.mean(weights * e**2)), least)
    assert student_scale(e, degrees, least, passes) == pytest.approx(scale, rel=1e-12)


def test_errors_that_are_no_numbers_have_no_scale_of_student():
    assert np.isnan(student_scale(np.array([1.0, np.nan, 2.0]), 4.0, 1e-150, 12))
    assert student_scale(np.zeros(5), 4.0, 1e-150, 12) == 1e-150
