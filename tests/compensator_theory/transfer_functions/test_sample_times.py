"""What is read at a sample time keeps it, whatever is made of it, and goes out with it."""

import control
import numpy as np
import pytest
import scipy.signal
from sympy import Rational

import compensator_theory as c
from compensator_theory import InputError

T = 0.01
PERIOD = Rational(1, 100)


def siso(period=T):
    return control.tf([1, 0.5], [1, -0.3, 0.2], period)


def mimo(period=T):
    return control.ss([[0.5, 1], [0, 0.2]], np.eye(2), [[1, 1], [0, 1]], np.zeros((2, 2)), period)


G, P = c.transfer_function(siso()), c.transfer_matrix(mimo())
R, S = c.realisation(mimo()), c.standard_problem(siso())
PLACED = c.place_poles(G, ["0", "0.1", "0.2"], feedback=-1)
FAMILY = c.place_poles(G, [0] * 5, 3, feedback=-1)
MADE = {
    "sum": G + 1, "from the right": 2 / (G - "1/z"), "power": -(G**-2),
    "reduced": (G / G).reduced(),
    "subs": ("a" * G).subs({"a": 2}), "closed": c.feedback_connection(G, "1/2", feedback=-1),
    "composed": c.transfer_function("1/(s + 1)").compose(G),
    "sensitivity": c.sensitivity_function(G, "1/2", feedback=-1),
    "dlti": c.transfer_function(scipy.signal.dlti([1], [1, 0.5], dt=T)),
    "zpk": c.transfer_function(scipy.signal.ZerosPolesGain([0.1], [0.5], 2, dt=T)),
    "compensator": PLACED.compensator, "placement": PLACED,
    "family": FAMILY.member([c.exact_number(2)] * len(FAMILY.homogeneous)),
    "entry": P[0, 1], "matrix": P, "matrices": (P @ P + P.T - [[1, 0], [0, 1]]) * "z",
    "inverse": P.inverse(), "rows": c.transfer_matrix([[G, "1/z"]]),
    "state space": R, "basis": R.in_basis([[1, 1], [0, 1]]), "dual": R.dual(),
    "series": R @ R - R, "loop": R.feedback_with(R, feedback=-1), "map": R.transfer_matrix(),
    "minimal": c.minimal_realisation(P).realisation, "controllable": c.realisation(G),
    "minimal part": c.minimal_realisation(R @ R).realisation,
    "matrix placement": c.place_matrix_poles(mimo(), [[0, 0, 0]] * 2, 2, feedback=-1).compensator,
    "problem": S, "servo": c.servo_problem(siso()), "G_zu": S.G_zu,
    "intercalated": c.intercalated_transfer_function(S, "z", "z**2"),
    "stabilising": c.stabilising_compensators(mimo(), [0, 0], [0, 0], feedback=-1).compensator(),
}  # fmt: skip


@pytest.mark.parametrize("name", MADE)
def test_the_sample_time_is_kept_and_goes_out(name):
    made = MADE[name]
    assert getattr(made, "sample_time", PERIOD) == PERIOD
    assert made.to_control().dt == T
    assert made.to_control(0.5).dt == 0.5


def test_sampling_says_the_period_of_what_it_makes():
    assert c.sampling.zero_order_hold("1/s", "1/10").realisation.to_control().dt == 0.1
    assert c.sampling.zero_order_hold("1/s").realisation.sample_time is None


def test_what_has_no_sample_time_is_discrete_or_continuous_as_its_variable_says():
    assert c.transfer_matrix([["1/s", 0]]).to_control().dt == 0
    assert c.realisation("1/s").to_control().dt == c.standard_problem("1/s").to_control().dt == 0
    assert c.realisation("1/z").to_control().dt is True
    with pytest.raises(InputError, match="say what x means"):
        c.transfer_matrix([["1/(x + 1)"]]).to_control()
    with pytest.raises(InputError, match="substitute numbers for"):
        c.realisation("a/(s + 1)").to_control()


@pytest.mark.parametrize(
    "join", [lambda: G + c.transfer_function(siso(0.02)), lambda: P @ c.transfer_matrix(mimo(0.02)),
             lambda: R + c.realisation(mimo(0.02)),
             lambda: c.feedback_connection(G, siso(0.02), feedback=-1)],
)  # fmt: skip
def test_two_sample_times_are_not_joined(join):
    with pytest.raises(InputError, match="sampled every 1/100 s and 1/50 s cannot be joined"):
        join()


@pytest.mark.parametrize("made", [P, R, c.standard_problem(siso())], ids=str)
def test_what_goes_out_has_the_response_of_what_came_in(made):
    out = made.to_control()
    for z in np.exp(1j * np.array([0.2, 1.0, 2.5])):
        found = np.atleast_2d(out(z))
        source = mimo()(z) if made is not MADE["problem"] and found.shape == (2, 2) else None
        if isinstance(made, c.StandardProblem):
            source = np.full((2, 2), siso()(z))
        np.testing.assert_allclose(found, source, rtol=1e-12)


def test_a_static_gain_goes_out():
    assert c.realisation("3", "z").to_control().D == [[3.0]]
