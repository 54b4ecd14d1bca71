"""From a plant to a controller: reference, target, prior, verdict, the file that says the same."""

import pickle
from functools import cache
from math import isfinite

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov
from scipy.stats import t as student

from compensator_theory.errors import CompensatorError, InputError, NoSolutionError
from rcac_numeric import (
    ClosedLoop,
    FixedController,
    Harmonic,
    Ramp,
    Saturation,
    Step,
    Uncertainty,
    WhiteNoise,
    design,
    exogenous,
    intercalated_match,
    pid,
    simulate,
    stability_margins,
    standard_plant,
)
from rcac_numeric.analysis._noise import with_oscillation
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._closed_loop_design import TuningParameters, settings_of
from rcac_numeric.designing._design import verdict_of
from rcac_numeric.designing._expected import KINDS, read_expected
from rcac_numeric.designing._plants import Variation, read_plant
from rcac_numeric.designing._reference import (
    MOST,
    WeightGrid,
    _calmest_first,
    loop_radius,
    reference_loop,
    sensitivity_peak,
)
from rcac_numeric.designing._trials import FIXED, PID, RCAC, Trial

QUICK = {"seeds": 1, "steps": 300}


def reference_of(G, disturbance, noise=0.01, sample_time=None, dead_time=0.0, command=None):
    plant = read_plant(G, sample_time, dead_time)
    expected, _ = read_expected(disturbance, noise, command, np.inf, plant.low_gain)
    return plant, expected, reference_loop(plant, expected)


# The reference loop.


def test_the_peak_of_the_reference_is_that_of_the_margins():
    plant, _, result = reference_of("1/(8*s + 1)**2", Step(0.5), sample_time=1.0, dead_time=2.5)
    loop = result.loop(plant)
    S_peak = stability_margins(loop).disk.S_peak
    assert result.peak <= MOST
    assert result.peak == pytest.approx(S_peak, rel=1e-3)
    assert sensitivity_peak(loop) == pytest.approx(S_peak, rel=1e-3)


def gain_from_d(plant, controller, omega):
    """abs of the response from d to e, over that of the plant alone."""
    loop = controller.loop(plant)
    return abs(loop.frequency_response([omega])[0, 0, 1] / plant.response(omega)[0])


def test_a_known_disturbance_has_its_model_in_the_controller():
    G = "0.1/((q - 0.9)*(q - 0.5))"
    constant = reference_of(G, Step(0.5))[2]
    assert np.abs(constant.compensator.poles() - 1).min() < 1e-5
    plant, _, sinusoid = reference_of(G, Harmonic(0.2, 0.5))
    assert np.abs(sinusoid.compensator.poles() - np.exp(0.2j)).min() < 1e-5
    assert gain_from_d(plant, sinusoid, 0.2) < 1e-3
    assert gain_from_d(plant, sinusoid, 0.4) > 1e-1
    white = reference_of(G, WhiteNoise(0.5))[2]
    assert white.compensator.n_c == 2 and np.abs(white.compensator.poles() - 1).min() > 1e-3


@given(omega=st.floats(0.1, 3), radius=st.floats(0.5, 0.99), power=st.floats(0.1, 10))
def test_an_oscillation_has_the_mean_square_that_was_asked_for(omega, radius, power):
    built = with_oscillation(
        standard_plant("1/(q - 0.5)"), "w", omega=omega, radius=radius, mean_square=power
    )
    A, D_1 = built.A[1:, 1:], built.D_1[1:, 1:]
    covariance = solve_discrete_lyapunov(A, D_1 @ D_1.T)
    assert np.allclose(covariance, power * np.eye(2), rtol=1e-9)
    assert np.allclose(np.linalg.eigvals(A), radius * np.exp(1j * omega * np.array([1, -1])))


@pytest.mark.parametrize("of", ["d", "r"])
def test_a_ramp_leaves_no_error(of):
    """With poles at 1 - 1e-6 it is small, not 0; one integrator alone leaves a constant."""
    ramp = Ramp(slope=0.01)
    disturbance, command = (ramp, None) if of == "d" else (Step(0.1), ramp)
    plant, _, result = reference_of(
        "1/((20*s + 1)*(3*s + 1))", disturbance, sample_time=1.0, dead_time=4.0, command=command
    )
    w = np.zeros((1500, 3))
    w[:, "rd".index(of)] = ramp.samples(1500)
    e = simulate(plant.servo(), result.fixed, w).z[-1, 0]
    assert abs(e) < 1e-2 * 0.01


PENDULUM = "(4.54*s)/(s^3 + 0.182*s^2 - 31.2*s - 4.45)"  # of a cart, from force to angle


@pytest.mark.parametrize(
    ("G", "sample_time"),
    [("(q - 1)/((q - 0.5)*(q - 0.9))", None), ("s/(s + 1)**2", 0.1), (PENDULUM, 0.01)],
)
def test_what_a_zero_keeps_from_y_has_no_integrator_in_the_controller(G, sample_time):
    """Its pole at 1 beside the zero would be a mode that nothing moves: no loop inside 1 - 1e-6."""
    for disturbance in (Step(1.0), "unknown"):
        plant = read_plant(G, sample_time, 0.0)
        expected, _ = read_expected(disturbance, 0.01, None, np.inf, plant.low_gain)
        grid = WeightGrid(plant, expected)
        assert grid.blocked == (0.0,) and not grid.models
        result = grid.best()
        assert result.loop(plant).spectral_radius < 1 - 1e-4
        assert result.compensator.n_c == len(plant.A)  # and no more for the disturbance


@pytest.mark.parametrize("rival", ["6/(q^4*(q - 0.9))", "0.2/(q^9*(q - 0.98))"])
def test_the_controller_is_slower_where_it_is_to_hold_rivals(rival):
    """Of a model whose best controller loses them; the loop's eigenvalues are those of no grid."""
    plant, other = (read_plant(G, None, 0.0) for G in ("1/(q^2*(q - 0.8))", rival))
    expected, _ = read_expected("unknown", 0.01, None, np.inf, plant.low_gain)
    fastest = WeightGrid(plant, expected).best()
    slower = WeightGrid(plant, expected, rivals=[other]).best()
    assert fastest.loop(plant).spectral_radius < 1 and slower.loop(plant).spectral_radius < 1
    assert not fastest.loop(other).spectral_radius < 1
    assert slower.loop(other).spectral_radius < 1 and slower.peak <= 2


@pytest.mark.costly
def test_the_pendulum_of_a_cart_is_designed_for_in_words_of_its_own():
    designed = design(PENDULUM, sample_time=0.01, **QUICK)
    report = " ".join(designed.report().split())
    assert "blocked by the plant's zero at rest, z = 1 (s = 0)" in report
    assert "gain 0 at rest" in report and "sign +" not in report
    nominal = next(t for t in designed.evidence if t.controller == FIXED)
    assert all(nominal.stable)


def test_through_a_zero_no_controller_follows_a_command():
    for more, words in (
        ({"command": Step(1.0)}, "zero at rest.*command"),
        ({"disturbance": Ramp(0.1)}, "zero at rest.*ramp"),
    ):
        with pytest.raises(NoSolutionError, match=words):
            design(PENDULUM, sample_time=0.01, **more, **QUICK)
    rows = [["s/(s + 1)**2", "0"], ["0", "1/(s + 1)"]]
    with pytest.raises(NoSolutionError, match=r"zero at rest.*one direction"):
        design(rows, sample_time=0.1, disturbance=Step(1.0), **QUICK)


@pytest.mark.parametrize("omega", [0.3, 1.2])
def test_a_sinusoid_at_a_zero_has_no_oscillator_in_the_controller(omega):
    plant = read_plant(f"(q^2 - {2 * np.cos(omega):.17g}*q + 1)/(q - 0.5)^3", None, 0.0)
    expected, _ = read_expected(Harmonic(omega, 0.5), 0.01, None, np.inf, plant.low_gain)
    grid = WeightGrid(plant, expected)
    assert grid.blocked == (omega,) and not grid.models
    assert WeightGrid(plant, read_expected(Step(1.0), 0.01, None, np.inf, 1.0)[0]).blocked == ()


# A refusal speaks of the plant, the disturbance, the command and the limits: nobody gave a target
# model, a regressor, weights, a Riccati equation or a matrix of them.
INNER = ("target model", "regressor", "G_f", "LQG", "Riccati", "disturbance model", "singular",
         "rung", "ladder", "float64 coefficients", "SVD", "theta")  # fmt: skip
REFUSED = [
    ("(q - 1)/((q - 1)*(q - 0.5))", {}, "pole at z = 1 "),
    ("s/(s*(s + 1))", {"sample_time": 0.1}, "pole at z = 1 "),
    ("(s - 1)/((s - 1)*(s + 2))", {"sample_time": 0.1}, "pole at z = 1.10517"),
    ("q/(q - 0.5)", {}, "strictly proper"),
    ("(s + 1)/(s + 2)", {"sample_time": 0.1}, "strictly proper"),
    ("1/(s + 1)", {}, "sample_time"),
    ("1/(s + 1)", {"sample_time": 0.1, "disturbance": 0.0}, "disturbance"),
    ("1/(s + 1)", {"sample_time": 0.1, "disturbance": Step(0.0)}, "disturbance"),
    ("1/(s + 1)", {"sample_time": 0.1, "u_limits": (0, 0)}, "u_limits"),
    ("1/(s + 1)", {"sample_time": 0.1, "u_limits": (1, 0)}, "low"),
    ("0*s/(s + 1)", {"sample_time": 0.1}, "plant"),
    (PENDULUM, {"sample_time": 0.01, "command": Step(1.0)}, "command"),
    ("s/(s + 1)**2", {"sample_time": 0.1, "structure": pid("PI")}, "structure = PI integrates"),
]


@pytest.mark.parametrize(("G", "more", "words"), REFUSED)
def test_a_refusal_speaks_of_what_was_given(G, more, words):
    with pytest.raises(CompensatorError, match=words) as refusal:
        design(G, **more, **QUICK)
    assert not [word for word in INNER if word in str(refusal.value)]


@pytest.mark.costly
@pytest.mark.parametrize(
    ("limits", "command", "words"),
    [
        ((0, 100), None, "no room below 0"),
        ((-100, 0), None, "no room above 0"),
        ((1, 2), None, "no room below 0"),
        ((0, 100), Step(-20.0), "no room below 0"),
        ((0, 100), Step(20.0), ""),
        ((-50, 50), None, ""),
    ],
)
def test_limits_at_the_working_point_are_the_first_line(limits, command, words):
    """Of a heater of 0 to 100 %: counted from its working point it can only be turned up."""
    designed = design("0.9/(175*s + 1)", sample_time=5.0, disturbance=0.44, noise=0.1,
                   u_limits=limits, command=command, seeds=1, steps=100)  # fmt: skip
    first = designed._sheet().health[0]
    assert (words in designed.no_room) if words else not designed.no_room
    assert (first.words == designed.no_room) == bool(words)


# What RCAC is told.


@pytest.mark.parametrize(
    ("G", "dead_time"),
    [("1/(8*s + 1)", 0.0), ("(1 - 3*s)/(8*s + 1)**2", 3.0), ("1/(9*s - 1)", 1.0)],
)
def test_the_target_is_what_the_reference_loop_is(G, dead_time):
    plant, expected, result = reference_of(G, Step(0.5), 0.01, 1.0, dead_time)
    settings = settings_of(plant, result, expected)
    assert intercalated_match(result.loop(plant), settings.target).worst < 1e-6
    assert np.array_equal(
        settings.compensator_of(settings.theta_0).past_u, result.compensator.past_u
    )
    low, high = settings.bounds.box(settings.structure)
    assert (low <= settings.theta_0).all() and (settings.theta_0 <= high).all()


def test_frozen_rcac_is_the_fixed_controller():
    designed = design("1/(8*s + 1)", sample_time=1.0, disturbance=Step(0.5), noise=0.01, **QUICK)
    w = exogenous([Step(0.0), Step(0.5), WhiteNoise(0.01)], 200, seed=5)
    ours = simulate(designed.plant, designed.frozen, w)
    theirs = simulate(designed.plant, designed.fixed, w)
    assert np.allclose(ours.u, theirs.u, rtol=1e-9, atol=1e-12)


def test_spare_order_is_the_same_controller():
    plant, expected, result = reference_of("1/(8*s + 1)", Step(0.5), 0.01, 1.0)
    wide = settings_of(plant, result, expected, TuningParameters(spare=3))
    assert wide.structure.n_c == result.compensator.n_c + 3
    loop = ClosedLoop(plant.servo(), wide.compensator_of(wide.theta_0))
    assert intercalated_match(loop, wide.target).worst < 1e-6


# Units.

EXPONENTS = st.floats(-6, 6)


def assert_close(ours, theirs):
    """Equal to 1e-6 of the largest entry: those that are 0 have their rounding alone."""
    assert np.abs(ours - theirs).max() < 1e-6 * np.abs(theirs).max()


@cache
def in_its_own_units():
    return design("(1 - 2*s)/((8*s + 1)*(3*s + 1))", disturbance=Step(0.5), noise=0.01,
                  dead_time=2.0, sample_time=1.0, seeds=1, steps=200)  # fmt: skip


@pytest.mark.costly
@settings(max_examples=3)
@given(u=EXPONENTS, y=EXPONENTS, t=EXPONENTS)
@example(u=6.0, y=-6.0, t=6.0)
@example(u=-6.0, y=6.0, t=-6.0)
def test_units_change_nothing_but_units(u, y, t):
    u, y, t = 10.0**u, 10.0**y, 10.0**t
    known: dict = {"seeds": 1, "steps": 200}
    one = in_its_own_units()
    known |= {"dead_time": 2 * t, "sample_time": t}
    G = f"{y / u!r}*(1 - 2*s*{t!r})/((8*s*{t!r} + 1)*(3*s*{t!r} + 1))"
    other = design(G, disturbance=Step(0.5 * u), noise=0.01 * y, **known)
    n_c = one.settings.structure.n_c
    by = np.concatenate([np.ones(n_c), np.full(n_c, u / y)])  # theta
    assert_close(other.settings.theta_0 / by, one.settings.theta_0)
    R_one, R_other = (result.settings.update.R_theta for result in (one, other))
    size = np.sqrt(np.diag(R_one))
    assert_close(R_other * np.outer(by / size, by / size) / y**2, R_one / np.outer(size, size))
    assert_close(other.settings.target.numerator * u / y, one.settings.target.numerator)
    assert_close(other.settings.target.denominator, one.settings.target.denominator)
    assert other.settings.R_z.nu * y == pytest.approx(one.settings.R_z.nu, rel=1e-6)
    assert other.verdict.rcac.ratio == pytest.approx(one.verdict.rcac.ratio, rel=1e-4)


# The verdict.


def trials(ours, theirs):
    """One run for each plant with these rms; None is a lost one."""
    built = []
    for name, values in ((RCAC, ours), (FIXED, theirs)):
        for i, value in enumerate(values):
            lost = value is None
            rms = np.inf if lost else value
            built.append(Trial(name, Variation(f"plant {i}"), (not lost,), (rms,), (1.0,), (1.5,)))
    return tuple(built)


def test_the_reference_keeps_to_the_actuator():
    plant = read_plant("2/((40*s + 1)*(8*s + 1))", 2.5, 10.0)
    expected, _ = read_expected(Step(0.3), 0.02, None, 0.36, plant.low_gain)
    w = exogenous(expected.signals(1), 4000, seed=1)
    u, most = {}, (0.36 - 0.3) / 3
    for half in (np.inf, 0.36):
        loop = reference_loop(plant, expected, half)
        run = simulate(plant.servo(), FixedController(loop.compensator), w)
        u[half] = run.u[500:].std()
    assert u[np.inf] > 1.5 * most and u[0.36] < 1.1 * most  # 10 % for 3500 coloured samples


@pytest.mark.parametrize("limits", [None, Saturation(low=-50.0, high=50.0)])  # that never bind
def test_the_reference_is_the_calmest_of_nearly_the_least_error(limits):
    plant = read_plant("1/(8*s + 1)", 1.0, 0.0)
    expected, _ = read_expected(Step(0.3), 0.01, None, np.inf, plant.low_gain)
    grid = WeightGrid(plant, expected, saturation=limits)
    result = {(R_2, V_2): grid.judged(parts) for R_2, V_2, parts in grid.candidates()}
    robust = [one for one in result.values() if one.peak <= MOST]
    best = grid.best()
    elapsed = result[best.R_2, best.V_2]
    most = 1.1 * min(np.sqrt(one.error) for one in robust)
    assert elapsed in robust and np.sqrt(elapsed.error) <= most
    assert elapsed.control == min(one.control for one in robust if np.sqrt(one.error) <= most)


def test_the_reference_is_stable_with_the_other_plants():
    plant = read_plant("1/(20*s + 1)", 1.0, 0.0)
    expected, _ = read_expected(0.5, 0.001, None, np.inf, plant.low_gain)
    later = plant.servo(Variation(delay=2))
    alone = reference_loop(plant, expected)
    assert not ClosedLoop(later, alone.compensator).is_stable  # what makes the next line a test
    robust = reference_loop(plant, expected, others=[Variation(delay=2)])
    assert ClosedLoop(later, robust.compensator).is_stable


@given(
    lag=st.floats(2, 30), late=st.integers(0, 6), noise=st.sampled_from([1e-3, 0.1]),
    gains=st.lists(st.floats(0.5, 3), max_size=2),
    rivals=st.lists(st.floats(-2, -0.3) | st.floats(0.3, 4), max_size=2),
)  # fmt: skip
@settings(max_examples=8)
def test_the_reference_is_the_first_of_all_candidates(lag, late, noise, gains, rivals):
    """Peaks and other plants are computed of few candidates; the choice is that of all."""
    plant = read_plant(f"1/({lag}*s + 1)", 1.0, float(late))
    expected, _ = read_expected(0.5, noise, None, np.inf, plant.low_gain)
    others = [Variation(gain=one) for one in gains]
    unlike = [read_plant(f"{one}/({lag}*s + 1)", 1.0, float(late + 1)) for one in rivals]
    grid = WeightGrid(plant, expected, others=others, rivals=unlike)
    rows = [
        (grid.judged(parts), R_2, V_2) for R_2, V_2, parts in grid.candidates()
        if all(loop_radius(one, parts) < 1 for one in grid.instead[len(others) :])
    ]  # fmt: skip
    rows = [one for one in rows if np.isfinite(one[0].peak)]
    rows.sort(key=lambda one: (one[0].order, *one[1:]))
    if not rows:
        with pytest.raises(NoSolutionError):
            grid.best()
        return
    first = _calmest_first(rows)[0]
    best = grid.best()
    assert first[1:] == (best.R_2, best.V_2) and best.peak == pytest.approx(first[0].peak)


@pytest.mark.parametrize(
    ("ours", "theirs", "use"),
    [
        ([0.5, 0.6, 0.55], [1.0, 1.0, 1.0], RCAC),  # clearly better
        ([1.0, 1.0, 1.0], [1.0, 1.0, 1.0], FIXED),  # the same
        ([0.99, 0.97, 0.98], [1.0, 1.0, 1.0], FIXED),  # not worth it
        ([0.1, 3.0, 0.9], [1.0, 1.0, 1.0], FIXED),  # not to be told from none
        ([0.5, None, 0.5], [1.0, 1.0, 1.0], FIXED),  # loses a plant
        ([None, 0.5, 0.5], [None, 1.0, 1.0], FIXED),  # not even the nominal plant
        ([1.0, 1.0, 1.0], [1.0, None, 1.0], RCAC),  # saves a plant at no price
    ],
)
def test_the_verdict_follows_from_the_evidence(ours, theirs, use):
    verdict = verdict_of(trials(ours, theirs))
    assert verdict.use == use
    assert verdict.rcac.stable == (sum(one is not None for one in ours), 3)
    assert str(verdict).startswith("Use RCAC: " if use == RCAC else "Use the fixed controller: ")


def test_the_interval_is_students():
    verdict = verdict_of(trials([0.5, 0.6, 0.9], [1.0, 1.0, 1.0]))
    logs = np.log([0.5, 0.6, 0.9])
    half = student.ppf(0.975, 2) * logs.std(ddof=1) / np.sqrt(3)
    assert verdict.rcac.ratio == pytest.approx(np.exp(logs.mean()))
    assert verdict.rcac.interval == pytest.approx(np.exp([logs.mean() - half, logs.mean() + half]))


def test_a_right_plant_and_a_step_need_no_adaptation():
    designed = design("1/(8*s + "
                      "1)", sample_time=1.0, dead_time=2.0, disturbance=Step(0.5), noise=0.01,
                   seeds=2, steps=600)  # fmt: skip
    assert designed.verdict.use == FIXED and equal(designed.controller, designed.frozen)
    assert all(all(trial.stable) for trial in designed.evidence)
    assert designed.report().splitlines()[1].startswith("  Use the fixed controller: ")


def test_a_sinusoid_of_unknown_frequency_is_worth_adapting_to():
    designed = design("1/(q - 0.9)", disturbance=1.0, noise=0.05, seeds=6, steps=1500)
    by_name = {(t.controller, t.variation.name): t for t in designed.evidence}
    ours, theirs = (np.array(by_name[name, "nominal"].rms) for name in (RCAC, FIXED))
    kinds = [KINDS[seed % 3] for seed in range(1_000_000, 1_000_006)]
    sinusoids = np.array([kind == "sinusoid" for kind in kinds])
    assert (ours[sinusoids] < theirs[sinusoids]).all()


# What was assumed, what is said, what is written.


def test_what_nobody_said_is_a_question():
    bare = design("1/(q - 0.9)", **QUICK)
    assert {"disturbance", "noise", "u_limits", "plant", "dead_time"} == {
        question.name for question in bare.questions
    }
    unstable = design("1/(q - 1.02)", disturbance=Step(1.0), noise=0.1, u_limits=(-50, 50), **QUICK)
    assert [question.name for question in unstable.questions] == ["plant", "dead_time", "plant"]
    assert "unstable" in unstable.questions[-1].assumed
    assert isinstance(unstable.alternatives[PID], str)


def test_too_fast_a_sampling_is_a_question():
    slow, fast = (
        design("1/((2*s + 1)*(s + 1))", sample_time=h, disturbance=Step(1.0), noise=0.1, **QUICK)
        for h in (0.5, 0.002)
    )
    assert "sample_time" not in {question.name for question in slow.questions}
    assert "sample_time" in {question.name for question in fast.questions}


def test_the_limits_scale_what_nobody_said():
    sizes = [read_expected("unknown", None, None, half, 3.0)[0].size for half in (1.0, 10.0)]
    assert sizes[1] == pytest.approx(10 * sizes[0])


def test_a_design_pickles_and_draws():
    designed = design("1/(q - 0.9)", disturbance=1.0, noise=0.1, **QUICK)
    again = pickle.loads(pickle.dumps(designed))
    assert equal(again.settings, designed.settings) and again.verdict == designed.verdict
    assert len(designed.plot().axes) == 3 and isfinite(designed.verdict.rcac.ratio)
    assert "Use " in designed._repr_html_()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"noise": -1.0}, "negative"),
        ({"disturbance": "steps"}, "Signal such as"),
        ({"disturbance": -1.0}, "positive"),
        ({"disturbance": Step(0.0)}, "nothing to control"),
        ({"u_limits": (1.0,)}, "low, high"),
        ({"command": 3.0}, "Signal"),
        ({"uncertainty": 1.2}, "Uncertainty"),
        ({"steps": 10}, "steps"),
        ({"seeds": 0}, "seeds"),
    ],
)
def test_bad_arguments_are_named(arguments, words):
    with pytest.raises(InputError, match=words):
        design("1/(q - 0.9)", **arguments)


def test_another_uncertainty_is_tried():
    weaker = Uncertainty(gain=(0.5, 1), delay=0, time=1, noise=1)
    designed = design("1/(q - 0.9)", disturbance=Step(1.0), noise=0.1, uncertainty=weaker, **QUICK)
    assert [t.variation.name for t in designed.evidence if t.controller == RCAC] == [
        "nominal", "gain x 0.5"
    ]  # fmt: skip
