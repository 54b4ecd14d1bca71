"""The check of a controller: a log of another program, our own logs, and what cannot be said."""

from itertools import combinations

import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric import (
    UD,
    Compensator,
    ControllerLog,
    ControllerSettings,
    Covariance,
    Harmonic,
    Plant,
    Step,
    TargetModel,
    WhiteNoise,
    check_controller,
    exogenous,
    fir,
    fir_target,
    iir,
    pid,
    read_log,
    replay,
    servo_plant,
    simulate,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.checks._check import arguments_of_run
from rcac_numeric.checks._replays import replay_compensator
from tests.support.examples import EXAMPLE_4_7
from tests.support.strategies import controllers, plants, seeds

OCTAVE = "examples/octave/rcac_loop.mat"


@pytest.fixture(scope="module")
def octave():
    plant, target = EXAMPLE_4_7.plant, EXAMPLE_4_7.settings.target
    return check_controller(
        read_log(OCTAVE), structure=iir(n_c=4), plant=plant, target=target, k_w=50
    )


@pytest.mark.parametrize("update", [UD(R_theta=1e-6), Covariance(R_theta=1e-6)], ids=repr)
def test_the_log_that_octave_wrote_is_the_run_that_our_engine_makes(octave, update):
    """The same w. The transient is ill-conditioned (R_theta = 1e-6), what it ends at is not."""
    log = octave.log
    settings = replace(EXAMPLE_4_7.settings, update=update)
    ours = simulate(EXAMPLE_4_7.plant, settings, log.w)
    assert np.abs(ours.z - log.z).max() < 1e-4 * np.abs(log.z).max()
    assert np.abs(ours.u - log.u).max() < 1e-4 * np.abs(log.u).max()
    assert np.abs(ours.theta[-1] - log.theta[-1]).max() < 1e-4 * np.abs(log.theta[-1]).max()


def test_the_octave_controller_has_the_poles_that_theory_asks_for(octave):
    """D_p has 1/2, -1/2, +-0.8j; the zeros of G are 0.72 +- 0.54j; the rest is 0."""
    expected = [0.5, -0.5, 0.8j, -0.8j, 0.72 + 0.54j, 0.72 - 0.54j, 0]
    for pole in expected:
        assert np.abs(octave.poles - pole).min() < 1e-5
    assert octave.comparison.spectrum_distance < 1e-5 and octave.match.worst < 1e-5


def test_the_octave_log_is_consistent_and_says_everything(octave):
    assert octave.replay.agrees and octave.replay.shift == 0 and octave.replay.worst < 1e-12
    assert octave.drift.is_converged and octave.unanswered == {}
    (model,) = octave.internal_models
    assert abs(model.distance) < 1e-5 and model.rejects == "constant signals"
    assert model.gains["w"] < 1e-4
    assert octave.split.identity_error < 1e-10
    assert octave.costs.ratio > 1
    assert scipy.io.loadmat(OCTAVE)["program"][0].startswith("GNU Octave")
    assert "GNU" not in octave.report() and "converged" in octave.report()


def logged(plant, structure, signals, steps=300, **options):
    target = fir_target(plant)
    settings = ControllerSettings(
        structure=structure, target=target, update=UD(R_theta=1e-2), **options
    )
    run = simulate(plant, settings, exogenous(signals, steps))
    assert run.outcome == "completed"
    return run


@pytest.mark.costly
@given(st.data())
def test_replay_of_any_structure_size_and_weight_agrees(data):
    plant = data.draw(plants())
    settings = data.draw(controllers(plant.l_u, plant.l_y, plant.l_z))
    rng = np.random.default_rng(data.draw(seeds))
    run = simulate(plant, settings, rng.standard_normal((40, plant.l_w)))
    if run.outcome != "completed":
        return
    log = ControllerLog(u=run.u, y=run.y, z=run.z, w=run.w, theta=run.theta)
    assert replay(log, settings.structure, k_w=settings.k_w).worst < 1e-10
    check = check_controller(
        log, structure=settings.structure, plant=plant, target=settings.target, k_w=settings.k_w
    )
    if check.loop.is_stable and np.abs(run.theta_final).max() < 1e3:
        assert np.isclose(np.abs(check.poles).max(), check.loop.spectral_radius, atol=1e-4)
        assert np.isclose(sum(check.costs.reached.shares.values()), check.costs.reached.value)
        assert check.split.identity_error < 1e-6


def test_a_run_says_its_arguments_itself():
    """The target is the last that was in force, not one that was still to come."""
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    first, later, never = (TargetModel([0, 1.0, a]) for a in (-0.1, -0.2, -0.3))
    run = logged(
        plant, iir(n_c=2), [WhiteNoise()], target_changes={50: first, 100: later, 300: never}
    )
    known = arguments_of_run(run)
    assert (known["target"], known["plant"], known["k_w"]) == (later, plant, run.settings.k_w)
    assert check_controller(run).replay.agrees and known["structure"] == iir(n_c=2)


def test_rows_that_an_update_left_are_recognised():
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    run = logged(plant, iir(n_c=2), [WhiteNoise()])
    after = np.vstack([run.theta[1:], run.theta_final])
    replayed = replay(ControllerLog(u=run.u, y=run.y, theta=after), iir(n_c=2))
    assert replayed.agrees and replayed.shift == 1


@pytest.mark.parametrize(
    "structure", [pid(), fir(n_c=3), iir(n_c=3, k_c=0)], ids=["PID", "FIR", "proper"]
)
def test_other_structures_replay_too(structure):
    run = logged(servo_plant("0.1/(q - 0.9)"), structure, [Step(), Step(0), Step(0)])
    log = ControllerLog(u=run.u, y=run.y, theta=run.theta)
    assert replay(log, structure, k_w=run.settings.k_w).worst < 1e-12


def test_a_u_that_did_not_come_from_theta_is_found():
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    run = logged(plant, iir(n_c=2), [WhiteNoise()])
    u = run.u.copy()
    u[200] += 0.1 * np.abs(u).max()
    replayed = replay(ControllerLog(u=u, y=run.y, theta=run.theta), iir(n_c=2))
    assert not replayed.agrees and 200 <= replayed.worst_step <= 202
    check = check_controller(u, run.y, theta=run.theta, structure=iir(n_c=2))
    assert not check.is_consistent and "is NOT the output of theta" in check.report()


def test_a_shift_is_no_convention_where_u_is_not_the_output_either_way():
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    run = logged(plant, iir(n_c=2), [WhiteNoise()])
    left = np.vstack([run.theta[1:], run.theta_final])
    words = "row k of theta is updated at step k"
    fits = replay(ControllerLog(u=run.u, y=run.y, theta=left), iir(n_c=2))
    assert fits.agrees and fits.shift == 1 and words in str(fits)
    u = run.u.copy()
    u[200] += 1e-3 * np.abs(u).max()
    replayed = replay(ControllerLog(u=u, y=run.y, theta=left), iir(n_c=2))
    assert not replayed.agrees and replayed.shift == 1
    assert words not in str(replayed) and "row k - 1 of theta for step k" in str(replayed)


def test_last_coefficients_alone_are_compared_with_the_last_tenth():
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    run = logged(plant, iir(n_c=2), [Harmonic(0.3)], steps=2000)
    check = check_controller(run.u, run.y, theta=run.theta_final, structure=iir(n_c=2))
    assert check.replay.start == 1800 and check.unanswered["convergence"]
    assert len(check.plot().axes) == 3


# From what a check answers to the names under which the reason stands where it does not.
REASONS = {
    "comparison": {"poles", "target", "exact poles"},
    "match": {"match"},
    "split": {"split"},
    "zeros": {"poles", "zeros"},
    "loop": {"poles"},
    "costs": {"costs"},
    "margins": {"margins", "margins at u", "margins at u1", "margins at u2"},
    "drift": {"convergence"},
    "replay": {"replay"},
}
PARTS = ("plant", "target", "w", "z", "theta")


CASES = [
    (width, gone) for width in (1, 2) for n in range(4 - width) for gone in combinations(PARTS, n)
]


@pytest.mark.parametrize(("width", "left_out"), CASES, ids=str)
def test_what_is_not_answered_has_its_reason(width, left_out):
    """Whatever is not known, of one channel or two: an answer, or a sentence why there is none."""
    plant = standard_plant("1/(q - 0.5)")
    if width == 2:
        plant = Plant(A=np.eye(2) / 2, B=np.eye(2), D_1=np.eye(2), C=np.eye(2))
    target = fir_target(plant) if width == 1 else TargetModel([np.zeros((2, 2)), np.eye(2)])
    settings = ControllerSettings(structure=iir(2, width, width), target=target, update=UD(1e-2))
    run = simulate(plant, settings, exogenous([WhiteNoise()] * width, 60, 1))
    data = {"plant": plant, "target": target, "w": run.w, "z": run.z, "theta": run.theta}
    data = {name: value for name, value in data.items() if name not in left_out}
    which = {"structure": settings.structure} if "theta" in data else {}
    check = check_controller(run.u, run.y, **data, **(which or {"compensator": run.compensator}))
    for name, reasons in REASONS.items():
        answer = getattr(check, name)
        is_answered = bool(answer) if isinstance(answer, dict) else answer is not None
        assert is_answered or reasons & check.unanswered.keys(), name
    assert check.plant is data.get("plant") and check.target is data.get("target")
    words = " ".join(check.report().split())
    assert all(f"{name}: {why}." in words for name, why in check.unanswered.items())


def test_what_a_harmonic_leaves_in_the_controller():
    """Example 2.1's idea: a harmonic command drives controller poles to exp(+-j omega)."""
    plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    run = logged(plant, iir(n_c=4), [Harmonic(0.5), Step(0), Step(0)], steps=3000)
    check = check_controller(run.u, run.y, z=run.z, w=run.w, theta=run.theta,
                             structure=iir(n_c=4), plant=plant)  # fmt: skip
    model = min(check.internal_models, key=lambda m: abs(m.omega - 0.5))
    assert abs(model.omega - 0.5) < 1e-3 and "harmonics of 0.5" in model.rejects
    assert model.gains["r"] < 0.05
    assert check.unanswered.keys() >= {"target", "match", "split"}
    assert check.costs.obstacle == "" and check.costs.ratio >= 1


@pytest.mark.costly
def test_without_a_plant_or_w_it_says_what_it_cannot_say(octave):
    log = octave.log
    alone = check_controller(log.u, log.y, theta=log.theta, structure=iir(n_c=4))
    assert set(alone.unanswered) == {"poles", "costs", "margins", "match", "split"}
    assert alone.poles is None and alone.margins == {} and len(alone.plot().axes) == 3
    without_w = check_controller(
        log.u, log.y, z=log.z, theta=log.theta, structure=iir(n_c=4), plant=octave.plant,
        target=octave.target,
    )  # fmt: skip
    assert without_w.unanswered == {"split": "the exogenous input w was not logged"}


def test_a_compensator_or_its_polynomials_in_place_of_theta(octave):
    fixed = octave.compensator
    log = octave.log
    check = check_controller(log.u, log.y, compensator=fixed, plant=octave.plant)
    polynomials = ControllerLog(
        u=log.u, y=log.y, D_c=2 * fixed.denominator, N_c=2 * fixed.numerator
    )
    other = check_controller(polynomials, plant=octave.plant)
    assert np.allclose(check.poles, other.poles) and check.unanswered["convergence"]


@pytest.mark.costly
@pytest.mark.parametrize("size", [1e-300, 1e-150, 1e-8, 1e20, 1e80])
def test_extreme_coefficients_are_reported_without_a_warning_or_a_foreign_error(size):
    plant = standard_plant("(q - 1.1)/((q - 0.9)*(q - 0.95))")
    for sign in (1, -1):
        for structure in (iir(n_c=2), iir(n_c=2, k_c=0)):
            theta = sign * size * np.arange(1.0, structure.l_theta + 1)
            check = check_controller(
                np.ones(30), np.ones(30), z=np.ones(30), w=np.ones(30), theta=theta,
                structure=structure, plant=plant, target=fir_target(plant),
            )  # fmt: skip
            assert check.report() and check.loop.is_stable == (size < 1)


def test_a_diverged_controller_is_refused():
    with pytest.raises(DivergedError, match=r"1e\+150.*Cut the log"):
        check_controller(np.ones(9), np.ones(9), theta=[1.0, 1e150], structure=iir(n_c=1))


@pytest.mark.costly
def test_an_unstable_loop_and_several_inputs():
    unstable = check_controller(
        np.zeros(20), np.zeros(20), z=np.ones(20), w=np.ones(20), theta=[0.1, 0.2],
        structure=iir(n_c=1), plant=standard_plant("1/(q - 3)"),
        target=fir_target(standard_plant("1/(q - 3)")),
    )  # fmt: skip
    assert unstable.costs.reached.value == np.inf and not unstable.margins["u"].is_stable
    assert "UNSTABLE" in str(unstable)
    two = Plant(A=[[0.5, 0.1], [0, 0.2]], B=np.eye(2), D_1=np.ones((2, 1)), C=np.eye(2))
    check = check_controller(
        np.zeros((20, 2)), np.zeros((20, 2)), plant=two,
        compensator=Compensator(np.zeros((1, 2, 2)), 0.1 * np.ones((2, 2, 2))),
    )  # fmt: skip
    assert set(check.margins) == {"u1", "u2"} and check.disk.alpha > 0
    assert "all components of u" in check.report() and "zeros" in check.unanswered


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"theta": np.ones(5)}, "has 5 coefficients.* has 4"),
        ({"theta": np.ones((4, 30))}, "seems to be transposed"),
        ({"theta": np.ones((29, 4))}, r"\(30, l_theta\)"),
        ({"y": np.ones(29)}, "y has 29 steps where u has 30"),
        ({"y": np.ones((1, 30))}, "transposed"),
        ({"y": np.ones((30, 2))}, "y has 2 components.* l_y = 1"),
        ({"z": np.r_[np.ones(20), np.nan, np.ones(9)]}, "z has 1 gaps.*step 20"),
        ({"u": None}, "u is needed"),
        ({"theta": None}, "no theta; give theta with a structure"),
        ({"structure": None}, "needs the structure"),
        ({"plant": Plant(A=[[0.5]], B=[[1.0]], D_1=[[1, 1]], C=[[1]]), "w": np.ones(30)},
         "w has 1 components; the plant has l_w = 2"),
        ({"target": "1/q"}, "not a TargetModel"),
        ({"plant": 5}, "not a Plant"),
    ],
)  # fmt: skip
def test_refusals(arguments, words):
    argument = {"u": np.ones(30), "y": np.ones(30), "theta": np.ones(4), "structure": iir(n_c=2)}
    with pytest.raises(InputError, match=words):
        check_controller(**{**argument, **arguments})


def test_noise_needs_a_plant_and_a_silent_channel_has_a_share():
    plant = servo_plant("1/(q - 0.5)")
    run = logged(plant, iir(n_c=2), [Step(), Step(0), Step(0)], steps=500)
    with pytest.raises(InputError, match="they need the plant"):
        check_controller(run.u, run.y, theta=run.theta, structure=iir(n_c=2), noise={"d": 1.0})
    check = check_controller(run.u, run.y, theta=run.theta, structure=iir(n_c=2), plant=plant,
                             noise={"d": 0.0, "v": 1.0})  # fmt: skip
    assert check.costs.reached.shares["d"] == 0.0
    assert check.costs.reached.value == check.costs.reached.shares["v"]


@given(seeds, st.integers(1, 3), st.integers(1, 3), st.integers(0, 3))
def test_a_fixed_compensator_is_replayed(seed, l_u, l_y, n_c):
    """u of (2.28), summed term by term, is the compensator's; with one wrong coefficient not."""
    rng = np.random.default_rng(seed)
    P = rng.uniform(-0.3, 0.3, (n_c, l_u, l_u)) / max(n_c, 1)
    Q = rng.uniform(0.5, 1.0, (n_c + 1, l_u, l_y))
    y, u = rng.standard_normal((50, l_y)), np.zeros((50, l_u))
    for k in range(50):
        for i in range(min(n_c, k)):
            u[k] += P[i] @ u[k - 1 - i]
        for i in range(min(n_c, k) + 1):
            u[k] += Q[i] @ y[k - i]
    log = ControllerLog(u=u, y=y)
    assert replay_compensator(log, Compensator(P, Q)).worst < 1e-12
    Q[-1, 0, 0] += 0.1
    assert not replay_compensator(log, Compensator(P, Q)).agrees
