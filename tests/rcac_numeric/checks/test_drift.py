"""Where nothing excites exact arithmetic keeps theta(0), and what rounding does there is said."""

import numpy as np
import pytest

import rcac_numeric as rn
from rcac_numeric.checks._health import DRIFT, drift_of


def redundant(R_theta, seed, **options):
    """One output, three actuators, G_f = H_1/q, and what of theta is not along H_1.

    Phi_f is phi (x) H_1, so that exactly every block of theta stays parallel to H_1.
    """
    rng = np.random.default_rng(seed)
    b = rng.uniform(0.3, 1.5, (1, 3))
    plant = rn.Plant(A=[[0.6]], B=b, D_1=[[1.0]], C=[[1.0]])
    settings = rn.ControllerSettings(
        structure=rn.iir(2, l_u=3), target=rn.TargetModel(np.stack([np.zeros((1, 3)), b])),
        update=rn.UD(R_theta), k_w=10, **options,
    )  # fmt: skip
    run = rn.simulate(plant, settings, 1 + 0.3 * rng.standard_normal((300, 1)))
    theta = run.theta_final.reshape(-1, 3)
    beside = theta - (theta @ b.T) @ b / (b @ b.T)
    return run, np.linalg.norm(beside) / np.linalg.norm(theta)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("R_theta", [1e-4, 1e-8, 1e-12, 1e-14])
def test_the_drift_is_what_is_off_the_only_excited_direction(R_theta, seed):
    run, off = redundant(R_theta, seed)
    health = rn.loop_health(run)
    assert 0.5 * off <= health.excitation.drift <= 3 * off
    spoken = [w for w in health.warnings if "without excitation" in w.sentence]
    assert bool(spoken) == (health.excitation.drift > DRIFT)
    assert ("rounding moved theta" in str(health.excitation)) == bool(spoken)


def test_it_is_spoken_of_where_theta_is_half_rounding():
    run, off = redundant(1e-14, 1)
    assert off > 0.1
    assert any("without excitation" in w.sentence for w in rn.loop_health(run).warnings)
    assert rn.loop_health(redundant(1e-6, 1)[0]).excitation.drift < DRIFT


def test_where_theta_may_move_otherwise_no_drift_is_claimed():
    bounds = rn.CoefficientBounds(-1.0, 1.0, method="clip")
    for options in ({"bounds": bounds}, {"R_u": 0.1}):
        assert rn.loop_health(redundant(1e-14, 1, **options)[0]).excitation.drift == 0.0


def test_a_direction_that_is_excited_little_is_excited():
    rows = np.array([[1.0, 0.0], [0.0, 1e-9], [1.0, 1e-9]])
    moved = np.array([0.0, 5.0])
    assert drift_of(rows, np.eye(2), moved) == 0.0
    assert drift_of(rows[:1], np.eye(2), moved) == 5.0
    # In the metric of R_theta: what moves with theta_1 by the prior is no drift.
    R_theta = np.array([[1.0, 0.5], [0.5, 1.0]])
    along = np.linalg.solve(R_theta, rows[0])
    assert drift_of(rows[:1], R_theta, along) < 1e-15
    assert drift_of(rows[:1], R_theta, along + np.array([0, 2.0])) == pytest.approx(2.0)
