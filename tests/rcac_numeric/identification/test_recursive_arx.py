"""Recursive ARX: the batch least squares, coverage of its errors, and refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from compensator_theory import InputError
from rcac_numeric.identification import RecursiveARX
from rcac_numeric.identification._zeros_of_arx import whiteness, zeros_of
from tests.support.strategies import seeds

# (q - 0.3)(q - 1.2)/((q - 0.5)(q^2 - 1.2 q + 0.52)), the plant of the notes
B = np.r_[0, np.poly([0.3, 1.2])]
A = np.poly([0.5, 0.6 + 0.4j, 0.6 - 0.4j]).real


def data(steps, seed, kind="matched", size=0.3):
    rng = np.random.default_rng(seed)
    u, e = rng.standard_normal((2, steps))
    noise = {"matched": lfilter(B, A, e), "out": e, "eq": lfilter([1.0], A, e)}[kind]
    return u, lfilter(B, A, u) + size * noise


@given(st.integers(1, 6), st.floats(1e-6, 10), seeds)
def test_it_is_the_batch_least_squares(order, R_theta, seed):
    u, z = data(60, seed)
    fit = RecursiveARX(order, R_theta=R_theta)
    fit.update(u[:17], z[:17])
    fit.update(u[17:, None], z[17:])
    rows = [[*u[k - order : k][::-1], *z[k - order : k][::-1]] for k in range(order, 60)]
    Phi = np.vstack([rows, np.sqrt(R_theta) * np.eye(2 * order)])
    theta, *_ = np.linalg.lstsq(Phi, np.r_[z[order:], np.zeros(2 * order)], rcond=None)
    scale = 1 + np.abs(theta).max()
    assert np.allclose(np.r_[fit.b, fit.a], theta, rtol=1e-6, atol=1e-6 * scale)
    assert np.allclose(fit.P, np.linalg.inv(Phi.T @ Phi), rtol=1e-5, atol=1e-8 / R_theta)


def test_a_restored_model_goes_on():
    u, z = data(200, 0)
    one, other = (RecursiveARX(5, lambda_=0.99) for _ in range(2))
    one.update(u[:100], z[:100])
    other.restore(one.state)
    for fit in (one, other):
        fit.update(u[100:], z[100:])
    assert one.state.tobytes() == other.state.tobytes() and other.k == 200


def coverage(kind, order, runs, steps=2000):
    inside = []
    for seed in range(runs):
        fit = RecursiveARX(order)
        fit.update(*data(steps, seed, kind))
        estimates = fit.estimate()
        nearest = np.argmin(np.abs(estimates.zeros - 1.2))
        inside.append(
            abs(abs(estimates.zeros[nearest]) - 1.2) <= 1.96 * estimates.modulus_error[nearest]
        )
    return np.mean(inside)


@pytest.mark.parametrize("kind", ["out", "matched"])
def test_the_errors_cover_what_they_say_with_a_generous_order_only(kind, in_full):
    """Nominal 95 %: three standard errors of the count at least; at p = 3 the bias shows."""
    runs = 400 if in_full else 60
    slack = 3 * np.sqrt(0.95 * 0.05 / runs)
    assert 0.95 - slack <= coverage(kind, 10, runs)
    assert coverage(kind, 3, runs) <= 0.1


def test_an_order_below_the_plant_is_refused():
    u, z = data(2000, 1, "eq")
    poor, good = RecursiveARX(1), RecursiveARX(3)
    for fit in (poor, good):
        fit.update(u, z)
    with pytest.raises(InputError, match="not white"):
        poor.zeros()
    zeros_of_plant = good.zeros()
    assert zeros_of_plant.phases[0] == "nonminimum phase" and zeros_of_plant.d_zu == 1
    assert zeros_of_plant.phases.count("minimum phase") == 1


def test_poor_data_are_refused_by_name():
    u, z = data(2000, 2)
    fit = RecursiveARX(10)
    fit.update(u[:15], z[:15])
    with pytest.raises(InputError, match="do not determine"):
        fit.zeros()
    still = RecursiveARX(4)
    still.update(np.zeros(500), z[:500])
    with pytest.raises(InputError, match="excite"):
        still.zeros()
    deaf = RecursiveARX(4)
    deaf.update(u, np.random.default_rng(3).standard_normal(2000))
    with pytest.raises(InputError, match="no effect of u"):
        deaf.zeros()
    for arguments in ({"order": 0}, {"order": 2, "R_theta": 0}, {"order": 2, "lambda_": 1.5}):
        with pytest.raises(InputError):
            RecursiveARX(**arguments)
    with pytest.raises(InputError, match="one of each"):
        still.update([1.0], [1.0, 2.0])


def test_the_rule_of_196_standard_errors():
    b, variance = np.poly([1.1, 0.5]), 1e-4
    for scale, phase in ((1.0, "nonminimum phase"), (100.0, "undecided")):
        zeros = zeros_of(b, scale * variance * np.eye(3), errors=np.ones(5), samples=9.0, d_zu=1)
        assert zeros.phases[0] == phase


@given(seeds)
def test_the_delta_method_is_the_derivative(seed):
    """Against differences of the moduli of the roots, complex pairs too."""
    rng = np.random.default_rng(seed)
    b = np.poly([1.5, 0.4 + 0.6j, 0.4 - 0.6j]).real * rng.uniform(0.5, 2)
    root = rng.standard_normal((4, 4))
    zeros = zeros_of(b, root @ root.T * 1e-8, errors=np.ones(5), samples=9.0, d_zu=1)
    slopes = []
    for direction in np.eye(4) * 1e-6:
        moved = [np.sort(np.abs(np.roots(b + sign * direction)))[::-1] for sign in (1, -1)]
        slopes.append((moved[0] - moved[1]) / 2e-6)
    spread = np.sqrt(np.einsum("in,ij,jn->n", slopes, root @ root.T * 1e-8, slopes))
    assert np.allclose(zeros.modulus_error, spread, rtol=1e-4)


def test_whiteness_is_uniform_on_white_noise():
    """The probability is one: of 400 white records about 5 % lie below 0.05."""
    rng = np.random.default_rng(0)
    low = np.mean([whiteness(rng.standard_normal(256)) < 0.05 for _ in range(400)])
    assert 0.02 < low < 0.09
    assert whiteness(lfilter([1], [1, -0.7], rng.standard_normal(256))) < 1e-6
