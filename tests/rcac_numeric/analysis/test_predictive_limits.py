"""What predictive cost adaptive control converges to, beside its exact limit."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
import rcac_numeric as rcac
from compensator_theory.errors import InputError
from rcac_numeric import PredictiveCost, predictive_cost_limit, simulate

DIGITS = st.integers(-14, 14).map(lambda i: f"{i}/10")


def run_of(G, *, seed=0, steps=200, horizon=20, order=2, **options):
    """A run under a random command, which excites every coefficient."""
    plant = rcac.servo_plant(G)
    settings = PredictiveCost(order, horizon, problem="servo", R_theta=1e-8, **options)
    w = np.zeros((steps, 3))
    w[:, 0] = np.random.default_rng(seed).choice([-1.0, 1.0], steps)
    return simulate(plant, settings, w)


@pytest.mark.costly
@given(
    st.lists(DIGITS, min_size=4, max_size=4), st.sampled_from(["moves", "u"]), st.integers(0, 99)
)
def test_the_final_loop_has_the_poles_of_the_limit(coefficients, weighs, seed):
    """Wherever the limit is stable and has a margin; the tolerance follows from theta's error."""
    b1, b2, a1, a2 = coefficients
    G = f"(({b1})*q + {b2})/(q**2 - ({a1})*q - ({a2}))"
    assume((b1, b2) != ("0/10", "0/10"))
    system = ct.transfer_function(G)
    assume(ct.minimal_realisation(system).order == 2)
    run = run_of(G, seed=seed, weighs=weighs)
    comparison = predictive_cost_limit(run)
    assert comparison.limit.certificate.holds
    if run.outcome != "completed" or abs(comparison.predicted_poles).max() > 0.98:
        return
    theta = [float(ct.exact_number(c)) for c in coefficients]
    error = abs(run.theta_final - theta).max()
    # The gain and the polynomial are smooth in theta: their change is bounded by a multiple of it.
    smallest = np.min(np.abs(1 - abs(comparison.predicted_poles)))
    sensitivity = 1e4 / smallest**3
    assume(sensitivity * (error + 1e-12) < 1)
    assert comparison.backward_error <= sensitivity * (error + 1e-12)


@pytest.mark.parametrize("problem", ["standard", "servo"])
def test_the_reached_polynomial_is_that_of_the_loop(problem):
    """`ClosedLoop` computes the same poles in float64, with its own state-space matrices."""
    G = "(q - 2/5)/(q**2 + q/2 - 1/10)"
    plant = rcac.standard_plant(G) if problem == "standard" else rcac.servo_plant(G)
    settings = PredictiveCost(2, 5, Q=2, P=5, problem=problem, R_theta=1e-8)
    w = np.random.default_rng(0).standard_normal((100, plant.l_w))
    run = simulate(plant, settings, w)
    comparison = predictive_cost_limit(run)
    poles = np.poly(comparison.poles)
    assert np.allclose(poles, np.poly(rcac.ClosedLoop(plant if problem == "standard" else
        rcac.standard_plant(G), comparison.compensator).poles()), atol=1e-9)  # fmt: skip
    assert len(comparison.poles) == 4 and str(comparison) and repr(comparison)


def test_a_model_that_has_not_converged_is_seen():
    comparison = predictive_cost_limit(run_of("(q - 13/10)/(q**2 - 7/5*q + 3/10)", steps=3))
    assert comparison.backward_error > 0.1 and comparison.gain_error > 0.1


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda: run_of("1/(q - 2)"), "order = 2, and the plant has degree 1"),
        (lambda: simulate("1/(q - 0.5)", rcac.FixedController("0"), np.ones((5, 1))),
         "the run is of a FixedController"),
        (lambda: "run", "is not a Run"),
    ],
)  # fmt: skip
def test_bad_input(run, words):
    with pytest.raises(InputError, match=words):
        predictive_cost_limit(run())
