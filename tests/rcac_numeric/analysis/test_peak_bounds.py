"""Bounds of z and u for bounded w: no run and no hostile motion exceeds them."""

import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    CertifiedBounds,
    Compensator,
    Plant,
    Saturation,
    certified_set,
    feedforward,
    peak_bounds,
    simulate,
)
from rcac_numeric.analysis._moving_gains import InputGains
from rcac_numeric.analysis._peak_bounds import driven_loop
from rcac_numeric.analysis._regressor_system import (
    rational_matrix,
    rounded_matrix,
)
from rcac_numeric.arrays._values import replaced
from tests.support.certified_loops import PLANT, WIDTHS, first_order, loops
from tests.support.engine_cases import cases, engine_plants
from tests.support.strategies import seeds


def floats(part):
    return rounded_matrix(rational_matrix(part))


@settings(max_examples=40)
@given(st.data(), st.sampled_from(WIDTHS), seeds)
def test_the_driven_loop_is_the_run_of_the_engine(data, widths, seed):
    """x, phi, z and u with w and a theta that moves, command and delayed command included."""
    l_u, l_y, l_r = widths
    chosen, _ = data.draw(cases(l_u, l_y, 1, l_r))
    plant = data.draw(engine_plants(l_u, l_y, 1, l_r))
    chosen = replaced(chosen, k_w=0, k_update=chosen.k_w + chosen.k_update + 1)
    w = np.random.default_rng(seed).standard_normal((30, plant.l_w))
    run = simulate(plant, chosen, w)
    loop = driven_loop(plant, chosen.structure, None, chosen.theta_0, InputGains())
    names = ("A", "B", "E", "C", "F", "Z_x", "Z_v", "Z_w")
    A, B, E, C, F, Z_x, Z_v, Z_w = (floats(getattr(loop, name)) for name in names)
    x = np.zeros(len(A))
    for k in range(run.steps):
        moved = (run.theta[k] - chosen.theta_0).reshape(-1, l_u).T
        v = moved @ (C @ x + F @ w[k])
        signals = Z_x @ x + Z_v @ v + Z_w @ w[k]
        expected = np.concatenate([run.z[k], run.u[k]])
        size = 1 + np.abs(run.u[: k + 1]).max() + np.abs(run.y[: k + 1]).max()
        if size > 1e5:  # theta diverges, and the rounding of x with it
            break
        assert np.abs(signals - expected).max() <= 1e-8 * size
        x = A @ x + B @ v + E @ w[k]


@pytest.mark.costly
@settings(max_examples=12, suppress_health_check=[HealthCheck.filter_too_much])
@given(loops(radius=0.98), st.sampled_from([0.1, 0.5, 0.8]), seeds)
def test_no_run_of_rcac_kept_inside_exceeds_its_bounds(loop, share, seed):
    plant, chosen = loop
    region = certified_set(plant, chosen)
    rng = np.random.default_rng(seed)
    peaks = rng.uniform(0.1, 2.0, plant.l_w)
    bounds = peak_bounds(region, peaks, share=share)
    assert bounds.is_verified
    assert (bounds.held <= bounds.z * (1 + 1e-9)).all()
    ellipsoid = CertifiedBounds(region.center, share * region.factor)
    start = chosen.k_w + chosen.k_update + 1
    kept_settings = replaced(chosen, bounds=ellipsoid, k_w=0, k_update=start)
    w = peaks * rng.choice([-1.0, 1.0], (300, plant.l_w))
    run = simulate(plant, kept_settings, w)
    assert region.radius_of(run.theta).max() <= share * (1 + 1e-9)
    assert (np.abs(run.z).max(axis=0) <= bounds.z).all()
    assert (np.abs(run.u).max(axis=0) <= bounds.u).all()
    assert pickle.loads(pickle.dumps(bounds)) == bounds


def hostile_peak(region, share, channel, horizon, tries=40):
    """Largest abs(z) from rest where theta, the gain and w push x'Px up, or z at the end."""
    (member,) = region.members
    gains = InputGains(*region.input_gain, region.limit_share)
    loop = driven_loop(member.plant, region.structure, None, region.center, gains)
    names = ("A", "B", "E", "C", "D", "F", "Z_x")
    A, B, E, C, D, F, Z = (floats(getattr(loop, name)) for name in names)
    K, taps, worst = share * region.regressor_factor, loop.taps, 0.0
    values = [Z[0] @ np.linalg.matrix_power(A, j) for j in range(horizon)]
    rng = np.random.default_rng(0)
    for _ in range(tries):
        x, sign = np.zeros(len(A)), rng.choice([-1.0, 1.0])
        for k in range(horizon):
            c = sign * values[horizon - 1 - k]
            w = np.sign(c @ E[:, channel]) or 1.0
            phi = C[:taps] @ x + F[:taps, channel] * w
            v = np.zeros(B.shape[1])
            v[0] = (np.sign(c @ B[:, 0]) or 1.0) * np.linalg.norm(K.T @ phi)
            for j, row in enumerate(range(taps, len(C)), start=1):
                q = C[row] @ x + D[row] @ v + F[row, channel] * w
                v[j] = (np.sign(c @ B[:, j]) or 1.0) * abs(q)
            x = A @ x + B @ v + E[:, channel] * w
            worst = max(worst, abs(Z[0] @ x))
    return worst


@pytest.mark.parametrize("gains", [{}, {"input_gain": (0.9, 1.1)}, {"limit_share": 0.8}])
@pytest.mark.parametrize("share", [0.2, 0.6])
def test_a_hostile_motion_comes_near_the_bound_and_not_beyond(gains, share):
    region = certified_set(PLANT, first_order(), **gains)
    bounds = peak_bounds(region, 1.0, share=share)
    assert bounds.is_verified
    worst = hostile_peak(region, share, 0, 80)
    assert worst <= bounds.z[0] <= 3 * worst
    assert bounds.held[0] <= worst * (1 + 1e-9)


def test_the_peak_of_the_held_theta_is_that_of_impulse_responses():
    region = certified_set(PLANT, first_order())
    bounds = peak_bounds(region, 0.7, share=0.1)
    impulse = np.zeros((400, 1))
    impulse[0] = 1.0
    run = simulate(PLANT, first_order(freeze=[(0, None)], k_w=0, k_update=1), impulse)
    np.testing.assert_allclose(bounds.held, 0.7 * np.abs(run.z).sum(axis=0), rtol=1e-9)


def test_a_smaller_share_has_a_smaller_bound_and_near_zero_it_is_near_the_held_theta():
    region = certified_set(PLANT, first_order())
    bounds = [peak_bounds(region, 1.0, share=share).z[0] for share in (1e-6, 0.1, 0.5, 0.9)]
    assert bounds == sorted(bounds)
    # one ellipsoid is at most sqrt(n) beyond the peak of a held loop of this kind
    at_rest = peak_bounds(region, 1.0, share=1e-6).held[0]
    assert at_rest <= bounds[0] <= np.sqrt(3) * at_rest


def test_channels_add_up_and_those_without_a_peak_are_left_out():
    plant = Plant(A=[[0.9]], B=[[1.0]], D_1=[[1.0, 0.0]], C=[[1.0]], D_2=[[0.0, 1.0]])
    region = certified_set(plant, first_order())
    both = peak_bounds(region, [0.5, 0.2], share=0.3)
    alone = [peak_bounds(region, peaks, share=0.3) for peaks in ([0.5, 0.0], [0.0, 0.2])]
    np.testing.assert_allclose(both.z, sum(one.z for one in alone), rtol=1e-12)
    assert len(both.proofs) == 4
    assert all(one.is_verified and len(one.proofs) == 2 for one in alone)


def test_a_command_that_the_controller_reads_is_a_channel():
    plant = replaced(
        PLANT, D_1=[[1.0, 0.0]], D_2=None, E_0=[[0.0, -1.0]], blocks={"d": 1, "r": 1}, exact=None
    )
    chosen = first_order(structure=feedforward(1), theta_0=[0.2, -0.3, 0.4])
    bounds = peak_bounds(certified_set(plant, chosen), [0.0, 1.0], share=0.1)
    assert bounds.is_verified
    assert bounds.z[0] > bounds.held[0] > 1


def test_a_family_with_a_compensator_in_parallel_is_bounded_on_every_member():
    fixed = Compensator([[[0.5]]], [[[0.0]], [[-0.1]]])
    chosen = first_order(fixed=fixed)
    region = certified_set(PLANT, chosen, uncertainty={"gain x 1.2": "1.2/(q - 0.9)"})
    bounds = peak_bounds(region, 1.0, share=0.3)
    assert bounds.is_verified
    assert {proof.member for proof in bounds.proofs} == {"nominal", "gain x 1.2"}
    for output, value in enumerate([*bounds.z, *bounds.u]):
        gains = [p.gain for p in bounds.proofs if p.output == output]
        assert np.isclose(value, max(gains))
    assert "with theta = theta_0" in bounds.report()


def test_falsified_bounds_are_refused():
    region = certified_set(PLANT, first_order())
    bounds = peak_bounds(region, 1.0, share=0.3)
    proof, *others = bounds.proofs
    rows = [list(row) for row in proof.P]
    rows[0][0] += Fraction(1)
    forged = [
        replace(bounds, z=bounds.z * 0.999),
        replace(bounds, w_peak=bounds.w_peak * 1.001),
        replace(bounds, share=0.4),
        replace(bounds, proofs=tuple(others)),
        *(
            replace(bounds, proofs=(replace(proof, **change), *others))
            for change in (
                {"gain": proof.gain * 0.999}, {"supply": proof.supply * 0.9}, {"rate": 1.0},
                {"supply": proof.supply * 1.1}, {"P": tuple(map(tuple, rows))}, {"P": ()},
            )
        ),
    ]  # fmt: skip
    assert bounds.is_verified
    assert not any(one.is_verified for one in forged)
    assert "NOT proved" in forged[0].report()


@pytest.mark.parametrize(
    ("peak", "options", "words"),
    [
        ([1.0, 2.0], {}, "1 channels"),
        (-1.0, {}, "w_peak"),
        (np.nan, {}, "w_peak"),
        (1.0, {"share": 0.0}, "share"),
        (1.0, {"share": 1.1}, "share"),
    ],
)
def test_wrong_peaks_are_refused_by_name(peak, options, words):
    with pytest.raises(InputError, match=words):
        peak_bounds(certified_set(PLANT, first_order()), peak, **options)


def test_a_plant_is_no_certified_set():
    with pytest.raises(InputError, match="CertifiedSet"):
        peak_bounds(PLANT, 1.0)


def test_limits_that_the_bound_of_u_justifies_are_covered_without_an_assumption():
    """u stays below the peak that limit_share assumes, so that the limits do apply that share."""
    share, passed = 0.02, 0.4
    region = certified_set(PLANT, first_order(theta_0=[0.0, -0.1]), limit_share=passed)
    bounds = peak_bounds(region, 1.0, share=share)
    impulse = np.zeros((200, 1))
    impulse[0] = 1.0
    start = {"theta_0": [0.0, -0.1], "k_w": 0, "k_update": 2}
    response = simulate(PLANT, first_order(freeze=[(0, None)], **start), impulse).u
    worst = np.where(response[::-1] >= 0, 1.0, -1.0)  # for theta_0 without limits
    limit = passed * float(bounds.u[0])
    ellipsoid = CertifiedBounds(region.center, share * region.factor)
    chosen = first_order(update=UD(R_theta=0.1), bounds=ellipsoid, **start)
    run = simulate(PLANT, chosen, worst, saturation=Saturation(low=-limit, high=limit))
    assert (run.u != run.u_applied).any()
    assert np.abs(run.u).max() <= bounds.u[0]
    assert np.abs(run.z).max() <= bounds.z[0]
