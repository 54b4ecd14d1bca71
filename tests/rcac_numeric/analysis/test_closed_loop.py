"""Closed loop, intercalated transfer function and residual split against independent routes."""

from fractions import Fraction

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import ImproperError
from rcac_numeric.analysis._exact_comparison import pairing
from tests.support.examples import EXAMPLE_4_6, EXAMPLE_4_7, EXAMPLE_4_8
from tests.support.strategies import plants, seeds, targets


@st.composite
def compensators(draw, l_u, l_y):
    rng = np.random.default_rng(draw(seeds))
    n_c = draw(st.integers(1, 3))
    P = rng.uniform(-0.3, 0.3, (n_c, l_u, l_u))
    Q = rng.uniform(-0.3, 0.3, (n_c + 1, l_u, l_y))
    Q[0] *= draw(st.booleans())
    return rn.Compensator(P, Q)


def evaluate(compensator, q):
    """(D_c, N_c) of (4.9)-(4.10) at the complex number q."""
    n_c = compensator.n_c
    D_c = np.eye(compensator.l_u) * q**n_c - sum(
        P * q ** (n_c - i) for i, P in enumerate(compensator.past_u, start=1)
    )
    N_c = sum(Q * q ** (n_c - i) for i, Q in enumerate(compensator.past_y))
    return D_c, N_c


def open_loop(plant, q):
    R = np.linalg.inv(q * np.eye(plant.n) - plant.A)
    return (
        plant.E_1 @ R @ plant.D_1 + plant.E_0,
        plant.E_1 @ R @ plant.B + plant.E_2,
        plant.C @ R @ plant.D_1 + plant.D_2,
        plant.C @ R @ plant.B + plant.D_0,
    )


@given(st.data())
def test_responses_are_the_formulas_of_the_text(data):
    """(2.9) and (4.16) evaluated as written, at random frequencies."""
    plant = data.draw(plants(feedthrough=data.draw(st.booleans())))
    compensator = data.draw(compensators(plant.l_u, plant.l_y))
    omega = np.array([0.3, 1.1, 2.9])
    loop = rn.ClosedLoop(plant, compensator)
    Gzw, intercalated = loop.frequency_response(omega), loop.intercalated_response(omega)
    for i, q in enumerate(np.exp(1j * omega)):
        G_zw, G_zu, G_yw, G_yu = open_loop(plant, q)
        D_c, N_c = evaluate(compensator, q)
        G_c = np.linalg.solve(D_c, N_c)
        S = np.linalg.inv(np.eye(plant.l_y) - G_yu @ G_c)
        D_inv = np.linalg.inv(D_c)
        scale = 1 + np.linalg.cond(S) * max(1, np.abs(G_zu).max(), np.abs(D_inv).max()) ** 2
        assert np.abs(Gzw[i] - (G_zw + G_zu @ G_c @ S @ G_yw)).max() < 1e-11 * scale
        expected = q**compensator.n_c * G_zu @ (D_inv + G_c @ S @ G_yu @ D_inv)
        assert np.abs(intercalated[i] - expected).max() < 1e-11 * scale


@given(st.data())
def test_poles_agree_with_python_control(data):
    plant = data.draw(plants())
    compensator = data.draw(compensators(plant.l_u, plant.l_y))
    G = control.ss(plant.A, plant.B, plant.C, plant.D_0, True)
    theirs = control.feedback(G, compensator.to_control(), sign=+1).poles()
    assert len(theirs) == plant.n + plant.l_u * compensator.n_c
    ours = np.poly(rn.ClosedLoop(plant, compensator).poles())
    assert ours == pytest.approx(np.poly(theirs), abs=1e-10 * max(1, np.abs(ours).max()))


@given(st.data(), seeds)
def test_the_residual_splits_exactly(data, seed):
    """(4.14) for arbitrary recorded u: it need not come from any controller."""
    plant = data.draw(plants(feedthrough=True))
    compensator = data.draw(compensators(plant.l_u, plant.l_y))
    target = data.draw(targets(plant.l_z, plant.l_u))
    try:
        rn.ClosedLoop(plant, compensator)
    except ImproperError:
        return
    rng = np.random.default_rng(seed)
    w, u = rng.standard_normal((20, plant.l_w)), rng.standard_normal((20, plant.l_u))
    body, y, z = rn.Simulator(plant), [], []
    for k in range(20):
        y_k, z_k = body.output(u[k], w[k])
        body.advance(u[k], w[k])
        y.append(y_k)
        z.append(z_k)
    split = rn.split_residual(plant, compensator, target, u=u, y=np.array(y), z=np.array(z), w=w)
    growth = max(1.0, rn.ClosedLoop(plant, compensator).spectral_radius) ** 20
    assert split.identity_error < 1e-11 * growth


def test_the_split_explains_a_run():
    """In Example 4.7 the match is good, so what is left of z is the disturbance response."""
    run = EXAMPLE_4_7.run()
    split = rn.split_residual(
        run.plant, run.compensator, run.settings.target, u=run.u, y=run.y, z=run.z, w=run.w
    )
    power = split.power()
    assert split.identity_error < 1e-11
    assert power["matching error"] < 1e-6 * power["disturbance response"]
    late = np.mean(split.residual[40:] ** 2)
    assert split.power(start=40)["residual"] == pytest.approx(late, rel=1e-12)
    omega, density = split.spectrum()
    width = omega[1] - omega[0]
    assert density["residual"].sum() * width == pytest.approx(power["residual"])


def test_certified_poles_are_the_eigenvalues():
    """Two routes to the closed-loop poles: exact polynomial and float64 eigenvalues."""
    run = EXAMPLE_4_7.run()
    comparison = rn.compare_exactly(run.plant, run.compensator, run.settings.target)
    eigenvalues = rn.ClosedLoop(run.plant, run.compensator).poles()
    assert max(abs(a - b) for a, b in pairing(comparison.poles, eigenvalues)) < 1e-8
    assert comparison.worst_distance < 1e-5
    assert comparison.spectrum_distance < 1e-5
    # Strictly proper: deg N_c <= 3 leaves one parameter; an exactly proper set would have two.
    assert len(comparison.compensators.homogeneous) == 1
    assert comparison.controller_distance < 1e-3
    # w is matched with u, so (2.15) gives the zeros: those of N D_c.
    zeros = np.roots(np.convolve(run.compensator.denominator, [1, -1.44, 0.81]))
    assert max(abs(a - b) for a, b in pairing(comparison.zeros["w"], zeros)) < 1e-6


def test_zeros_from_each_channel_of_the_servo_problem():
    """(2.27): from r and v the zeros are those of D D_c, from d those of N D_c."""
    run = EXAMPLE_4_6.run()
    zeros = rn.compare_exactly(run.plant, run.compensator, run.settings.target).zeros
    N, D = [1, -1.4, 0.85], np.poly([1.05, 0.8 + 0.5j, 0.8 - 0.5j]).real
    for channel, plant_part in (("r", D), ("v", D), ("d", N)):
        expected = np.roots(np.convolve(run.compensator.denominator, plant_part))
        assert len(zeros[channel]) == len(expected)
        assert max(abs(a - b) for a, b in pairing(zeros[channel], expected)) < 1e-5


def test_an_exactly_placed_loop_matches_its_target():
    """The compensator that the theory asks for, rounded once, gives G_f in float64."""
    run = EXAMPLE_4_8.run()
    plant, target = run.plant, run.settings.target
    comparison = rn.compare_exactly(plant, run.compensator, target).compensators
    D_c = [Fraction(str(c)) for c in comparison.denominator.all_coeffs()]
    N_c = [Fraction(str(c)) for c in comparison.numerator.all_coeffs()]
    N_c = [Fraction(0)] * (len(D_c) - len(N_c)) + N_c
    ideal = rn.Compensator(
        past_u=[[[-float(c)]] for c in D_c[1:]], past_y=[[[float(c)]] for c in N_c]
    )
    assert rn.intercalated_match(rn.ClosedLoop(plant, ideal), target).worst < 1e-9
    assert rn.compare_exactly(plant, ideal, target).worst_distance < 1e-9


def test_what_cannot_be_reached_is_said():
    plant = rn.standard_plant("(q - 0.5)/(q*(q - 0.9))")
    wrong_zero = rn.TargetModel([0.0, 1.0, -0.3])
    ideal = rn.Compensator(past_u=[[[0.1]]], past_y=[[[0.0]], [[0.2]]])
    comparison = rn.compare_exactly(plant, ideal, wrong_zero)
    assert comparison.requested is None and comparison.obstacle
    assert np.isnan(comparison.spectrum_distance)
    assert np.isfinite(comparison.worst_distance)


def test_ill_posed_and_misfitting_loops_are_refused():
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], D_0=[[2.0]])
    with pytest.raises(ImproperError, match="I - Q_0 D_0 is singular"):
        rn.ClosedLoop(plant, rn.Compensator(past_u=[[[0.1]]], past_y=[[[0.5]], [[0.2]]]))
    with pytest.raises(InputError, match="l_y = 2"):
        rn.ClosedLoop(plant, rn.Compensator(past_u=[[[0.1]]], past_y=np.zeros((2, 1, 2))))
    with pytest.raises(InputError, match=r"past_u has shape \(1, 1\)"):
        rn.Compensator(past_u=[[0.1]], past_y=[[0.1]])
    with pytest.raises(InputError, match="scalar"):
        rn.compare_exactly(
            rn.Plant(A=np.eye(2) / 2, B=np.eye(2), D_1=np.eye(2), C=np.eye(2)),
            rn.Compensator(past_u=np.zeros((1, 2, 2)), past_y=np.zeros((2, 2, 2))),
            rn.TargetModel(np.zeros((1, 2, 2)) + 1),
        )


def test_fir_target_of_a_plant_is_the_limit_of_its_intercalated_response():
    plant = rn.standard_plant("(q - 0.5)/(q*(q - 0.9))")
    target = rn.fir_target(plant)
    omega = np.array([0.5, 1.5])
    expected = np.exp(-1j * omega)
    assert target.frequency_response(omega)[:, 0, 0] == pytest.approx(expected)


def test_the_frequencies_of_the_match_are_the_middles_of_equal_parts():
    plant = rn.standard_plant("1/(q - 2)")
    loop = rn.ClosedLoop(plant, rn.Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]]))
    match = rn.intercalated_match(loop, rn.fir_target(plant), points=4)
    assert match.omega == pytest.approx(np.pi * np.array([1, 3, 5, 7]) / 8)
