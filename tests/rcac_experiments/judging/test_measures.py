"""Every measure of a hand-made run, against values computed by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_experiments.dissertation import load_example
from rcac_experiments.files._builder import build
from rcac_experiments.judging._measures import MEASURES


def repetition(z, theta, stride=1):
    """A run of x(k+1) = 0.5 x + u with the first-order controllers theta = (p, q)."""
    theta = np.array(theta, dtype=float)
    structure = rn.iir(1)
    run = SimpleNamespace(
        z=np.array(z, dtype=float).reshape(-1, 1),
        theta=theta,
        theta_final=theta[-1],
        stride=stride,
        steps=len(z),
        plant=rn.standard_plant("1/(q - 0.5)"),
        settings=SimpleNamespace(structure=structure, compensator_of=structure.compensator),
        compensator=structure.compensator(theta[-1]),
        compensator_at=lambda k: structure.compensator(theta[k // stride]),
        guard_count=3,
        outcome="completed",
    )
    return SimpleNamespace(run=run)


# The loop of (p, q) has the polynomial (z - 0.5)(z - p) - q: stable for (0, 0), unstable for
# (2, 0), whose controller is unstable too, and for (0, 1), whose controller is stable.
STABLE, BOTH, LOOP = (0.0, 0.0), (2.0, 0.0), (0.0, 1.0)


def test_the_share_of_the_radius_of_an_ellipsoid():
    plant, w = rn.standard_plant("1/(q - 0.5)"), np.ones((20, 1))
    argument = {"structure": rn.iir(1), "target": rn.TargetModel([0, 1.0]), "update": rn.UD(1.0)}
    bounded = rn.ControllerSettings(**argument, bounds=rn.CertifiedBounds([0, 0], 0.01 * np.eye(2)))
    run = rn.simulate(plant, bounded, w)
    expected = np.linalg.norm(run.theta, axis=1).max() / 0.01
    value = MEASURES["radius_of_bounds"](rn.LoopAnalysis(run))
    assert value == pytest.approx(expected, rel=1e-12) and 0.99 < value <= 1
    free = rn.simulate(plant, rn.ControllerSettings(**argument), w)
    with pytest.raises(InputError, match="no CertifiedBounds"):
        MEASURES["radius_of_bounds"](rn.LoopAnalysis(free))


def test_of_the_response():
    r = repetition([1, -3, 0.5, 0.01, -0.03, 0.005], [STABLE] * 6)
    assert MEASURES["settling_step"](r, band=0.02) == 5
    assert MEASURES["settling_step"](r, band=5) == 0
    assert MEASURES["peak"](r) == 3 and MEASURES["peak"](r, start=2) == 0.5
    assert MEASURES["peak"](r, start=0, stop=1) == 1
    assert MEASURES["rms"](r, start=0, stop=2) == pytest.approx(5**0.5)
    with pytest.raises(InputError, match="no step in"):
        MEASURES["rms"](r, start=6)


def test_of_a_chosen_signal():
    r = repetition([0, 0, 0], [STABLE] * 3)
    r.run.u = np.array([[3.0, 1.0], [0.5, -4.0], [0.25, 2.0]])
    r.run.u_applied = np.clip(r.run.u, -1, 1)
    assert MEASURES["peak"](r, signal="u") == 4
    assert MEASURES["peak"](r, signal="u", channel=0, start=1) == 0.5
    assert MEASURES["rms"](r, signal="u_applied", channel=1, stop=2) == 1
    assert MEASURES["rms"](r, signal="u", start=2) == pytest.approx((0.0625 + 4) ** 0.5)
    assert MEASURES["mean"](r, signal="u", channel=1) == pytest.approx(-1 / 3)
    assert MEASURES["saturated_fraction"](r) == 1
    assert MEASURES["saturated_fraction"](r, start=0, stop=1) == 1
    r.run.u_applied = np.clip(r.run.u, -3, 3)
    assert MEASURES["saturated_fraction"](r) == pytest.approx(1 / 3)
    with pytest.raises(InputError, match="channel = 2 must be at most 1"):
        MEASURES["rms"](r, signal="u", channel=2)
    with pytest.raises(InputError, match="signal = 'x' is not known"):
        MEASURES["peak"](r, signal="x")


def test_of_how_a_run_went():
    r = repetition([1, 0, 0], [STABLE] * 3)
    r.run.reflections, r.run.resets = 4, 2
    assert MEASURES["completed"](r) == 1 and MEASURES["steps"](r) == 3
    assert MEASURES["reflections"](r) == 4 and MEASURES["resets"](r) == 2
    assert MEASURES["settling_step"](r) == 1
    r.run.outcome = "diverged"
    assert MEASURES["completed"](r) == 0
    assert MEASURES["settling_step"](r) == np.inf, "a run that broke off has not settled"


def test_of_one_coefficient():
    r = repetition(np.zeros(6), [(1, 2), (3, 4), (5, 6)], stride=2)
    assert MEASURES["coefficient"](r, index=1) == 6
    assert MEASURES["coefficient"](r, index=0, k=2) == 3
    for k in (1, 6):
        with pytest.raises(InputError, match="is recorded at multiples of 2 below"):
            MEASURES["coefficient"](r, index=0, k=k)
    with pytest.raises(InputError, match="index = 2 must be at most 1"):
        MEASURES["coefficient"](r, index=2)


@pytest.mark.parametrize("stride", [1, 5])
def test_of_the_coefficients(stride):
    r = repetition(np.zeros(6 * stride), [STABLE, BOTH, LOOP, STABLE, LOOP, STABLE], stride)
    assert MEASURES["last_unstable_step"](r) == 4 * stride
    assert MEASURES["first_unstable_controller"](r) == 1 * stride
    assert MEASURES["unstable_fraction"](r) == pytest.approx(3 / 6)
    assert MEASURES["unstable_fraction"](r, stop=2 * stride) == pytest.approx(1 / 2)
    drifting = repetition(np.zeros(4 * stride), [(9, 0), (1, 0), (3, 0), (2, 0)], stride)
    assert MEASURES["theta_drift"](drifting, start=2 * stride) == pytest.approx(1 / 2)
    assert MEASURES["theta_drift"](drifting, start=0) == pytest.approx(7 / 2)
    with pytest.raises(InputError, match="no theta from step 1000 on"):
        MEASURES["theta_drift"](drifting, start=1000)
    quiet = repetition(np.zeros(3), [STABLE] * 3)
    assert MEASURES["last_unstable_step"](quiet) == -1
    assert MEASURES["first_unstable_controller"](quiet) == -1


def test_of_the_controller():
    r = repetition(np.zeros(2), [(0.25, 0.0), (-0.75, 0.0)])
    assert MEASURES["controller_spectral_radius"](r) == pytest.approx(0.75)
    assert MEASURES["controller_pole_distance"](r) == pytest.approx(1.75)
    assert MEASURES["controller_pole_distance"](r, omega=np.pi) == pytest.approx(0.25)
    assert MEASURES["controller_pole_distance"](r, k=0) == pytest.approx(0.75)
    assert MEASURES["guard_count"](r) == 3


def test_an_fir_controller_may_be_exactly_proper():
    from rcac_numeric import fir

    assert fir(3, k_c=0).l_theta == 4
    controller = fir(1, k_c=0).compensator([2.0, 3.0])
    assert isinstance(controller, rn.Compensator)
    assert controller.numerator.tolist() == [2.0, 3.0]


def test_a_weight_written_as_z_squared():
    table = {
        "plant": {"problem": "standard", "G": "1/(q - 0.5)"},
        "target": {"model": "fir"},
        "controller": {"n_c": 1, "R_theta": 1.0, "R_u": {"z_squared": 0.5}},
        "run": {"steps": 10},
    }
    assert build(table, "case").main_run.settings.R_u == rn.SignalWeight(z_squared=0.5)


def test_of_the_cost():
    """A first-order plant: the cost is 1/(1 - p^2), and no controller goes below 1."""
    plant = rn.standard_plant("1/(q - 0.5)")
    run = SimpleNamespace(plant=plant)

    def closed_with(pole):
        """u(k) = p u(k-1) + q y(k-1), whose loop has both its poles at `pole`."""
        # (z - 0.5)(z - p) - q = (z - pole)^2
        p = 2 * pole - 0.5
        q = 0.5 * p - pole**2
        return SimpleNamespace(
            run=run, plant=plant, loop=rn.ClosedLoop(plant, rn.iir(1).compensator([p, q]))
        )

    best = closed_with(0.0)
    # With both poles at zero z = (q - p)/q^2 w, p = -1/2: the variance is 1 + 1/4.
    assert MEASURES["h2_cost"](best) == pytest.approx(1.25)
    assert MEASURES["high_authority_cost"](best) == pytest.approx(1.25)
    assert MEASURES["cost_over_high_authority"](best) == pytest.approx(1)
    assert MEASURES["high_authority_response_distance"](best) < 1e-12
    assert MEASURES["high_authority_pole_distance"](best, value=-0.4) == pytest.approx(0.1)
    assert MEASURES["cost_over_high_authority"](closed_with(0.3)) > 1.001
    assert MEASURES["high_authority_response_distance"](closed_with(0.3)) > 0.1
    assert MEASURES["h2_cost"](closed_with(1.5)) == np.inf


def test_of_the_cost_without_what_w_adds_directly():
    """(4.21) leaves E_0 w out: of z = e_n the noise v itself."""
    measured, true = (rn.servo_plant("1/(q - 0.5)", performance=p) for p in ("measured", "true"))
    noise = {"d": 1.0, "v": 0.25}
    controller = rn.iir(1).compensator([0.1, -0.2])
    a, b = (SimpleNamespace(plant=p, loop=rn.ClosedLoop(p, controller)) for p in (measured, true))
    for name in ("h2_cost", "high_authority_cost"):
        with_v = MEASURES[name](a, noise=noise)
        assert MEASURES[name](a, noise=noise, direct=False) == pytest.approx(with_v - 0.25)
        assert MEASURES[name](b, noise=noise) == pytest.approx(with_v - 0.25)
    ratio = MEASURES["cost_over_high_authority"](b, noise=noise)
    assert MEASURES["cost_over_high_authority"](a, noise=noise, direct=False) == ratio


def test_of_the_response_from_one_channel():
    """The direct part of v hides the difference that the response from d shows."""
    plant = rn.servo_plant("1/(q - 0.5)")
    r = SimpleNamespace(plant=plant, loop=rn.ClosedLoop(plant, rn.iir(1).compensator([0.0, 0.0])))
    noise = {"d": 1.0, "v": 4.0}
    of_d = MEASURES["high_authority_response_distance"](r, noise=noise, response_from="d")
    assert of_d > MEASURES["high_authority_response_distance"](r, noise=noise) > 0


def test_of_whether_there_is_an_lqg_controller():
    there, none = (rn.standard_plant(G) for G in ("(q - 2)/(q*(q - 0.5))", "(q - 1)/(q*(q - 0.5))"))
    assert MEASURES["high_authority_exists"](SimpleNamespace(plant=there)) == 1
    assert MEASURES["high_authority_exists"](SimpleNamespace(plant=none)) == 0


def test_of_the_margins():
    """q^2 - q - 2 + 2.5 gain: stable for 0.8 < gain < 1.2, poles at -1 and at exp(+-j pi/3)."""
    plant = rn.standard_plant("1/(q - 2)")
    controller = rn.Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]])
    r = SimpleNamespace(loop=rn.ClosedLoop(plant, controller))
    assert MEASURES["margin"](r) == pytest.approx(1.2)
    assert MEASURES["margin"](r, kind="gain down") == pytest.approx(0.8)
    assert MEASURES["margin_frequency"](r, kind="gain up") == pytest.approx(np.pi / 3)
    assert MEASURES["margin_frequency"](r, kind="gain down") == pytest.approx(0)
    margins = rn.stability_margins(r.loop)
    assert MEASURES["margin"](r, kind="delay") == margins.delay.value
    assert MEASURES["margin"](r, kind="phase lag") == margins.phase_lag.value
    assert MEASURES["margin"](r, kind="phase lead") == margins.phase_lead.value
    unstable = SimpleNamespace(loop=rn.ClosedLoop(plant, rn.iir(1).compensator([0.0, 0.0])))
    assert np.isnan(MEASURES["margin"](unstable)), "an unstable loop has no margin"
    with pytest.raises(InputError, match="kind = 'gain' is not known"):
        MEASURES["margin"](r, kind="gain")


def test_of_when_a_loop_is_stable_again():
    r = repetition(np.zeros(6), [STABLE, BOTH, LOOP, STABLE, STABLE, STABLE])
    assert MEASURES["stable_from"](r) == 3 and MEASURES["stable_from"](r, start=4) == 4
    assert MEASURES["frozen_spectral_radius"](r, at=1) == pytest.approx(2)
    assert MEASURES["frozen_spectral_radius"](r, at=3) == pytest.approx(0.5)
    unstable = repetition(np.zeros(2), [STABLE, BOTH])
    assert MEASURES["stable_from"](unstable) == np.inf
    r.run.outcome = "diverged"
    assert MEASURES["stable_from"](r) == np.inf


def test_of_the_residual():
    """From rest the rest of the residual is the response to w, which the split has by itself."""
    r = load_example("2.2").main_run.execute().first.until(200)
    power = r.split.power(50)
    expected = power["matching error"] / power["disturbance response"]
    assert MEASURES["matching_error_share"](r, start=50) == pytest.approx(expected, rel=1e-9)
    assert 0 < expected < 1


def test_of_the_residual_from_an_initial_state():
    """With w = 0 and theta* = theta the residual is the free response, and no error is in it."""
    plant = rn.standard_plant("1/(q - 0.5)")
    free = 0.5 ** np.arange(9.0)[:, None]
    r = SimpleNamespace(
        split=rn.split_residual(
            plant, rn.iir(1).compensator([0.0, 0.0]), rn.TargetModel([0, 2], [1]),
            u=0 * free, y=free, z=free, w=0 * free,
        )
    )  # fmt: skip
    assert MEASURES["matching_error_share"](r) == 0
    u = np.eye(9)[:, :1]  # one step of u~: the loop answers 0.5^(k - 1), the target model 2 once
    y = free + np.r_[[[0.0]], free[:-1]]
    r.split = rn.split_residual(
        plant,
        rn.iir(1).compensator([0.0, 0.0]),
        rn.TargetModel([0, 2], [1]),
        u=u,
        y=y,
        z=y,
        w=0 * u,
    )
    error = 1 + np.sum(free[1:-1] ** 2)
    assert MEASURES["matching_error_share"](r) == pytest.approx(error / np.sum(free**2))


def test_of_the_cost_with_intensities():
    """d and v of a servo problem with their own intensities; the command is no noise."""
    plant = rn.servo_plant("1/(q - 0.5)", performance="true")
    r = SimpleNamespace(plant=plant, loop=rn.ClosedLoop(plant, rn.iir(1).compensator([0.0, 0.0])))
    noise = {"d": 4.0, "v": 1.0}
    assert MEASURES["h2_cost"](r, noise=noise) == pytest.approx(4 / 0.75)
    assert MEASURES["high_authority_cost"](r, noise=noise) < 4 / 0.75
    assert MEASURES["cost_over_high_authority"](r, noise=noise) > 1
    assert MEASURES["high_authority_response_distance"](r, noise=noise) > 0


def test_of_the_characteristic_polynomial():
    plant = rn.standard_plant("1/(q - 2)")
    converged = rn.Compensator(past_u=[[[-1.25]]], past_y=[[[0.0]], [[-2.625 + 2**-20]]])
    comparison = rn.compare_exactly(
        plant, converged, rn.pole_placement_target(plant, ["1/2", "1/4"])
    )
    r = SimpleNamespace(comparison=comparison)
    assert MEASURES["polynomial_distance"](r) == 2**-20
    target = rn.TargetModel([0, 1], [1, -0.5])
    r = SimpleNamespace(comparison=rn.compare_exactly(plant, converged, target))
    with pytest.raises(InputError, match="no characteristic polynomial"):
        MEASURES["polynomial_distance"](r)
