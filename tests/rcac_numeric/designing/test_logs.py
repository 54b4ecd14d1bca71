"""From a log to a controller: for the plant that made the log, and with what was not told asked."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import rcac_numeric as rn
from compensator_theory.errors import (
    InputError,
    NoSolutionError,
    UndecidedError,
)
from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._design import _basis_of_log, _DesignOptions
from rcac_numeric.designing._logs import PARTS, LogSearch, plant_from_log
from rcac_numeric.designing._plants import read_plant, slower_plant
from rcac_numeric.designing._reference import WeightGrid, sensitivity_peak

TRUE = "-(0.1*q + 0.05)/((q - 0.9)*(q - 0.6))"
QUICK = {"seeds": 1, "steps": 300}


def log_of(steps=1500, noise=0.05, seed=4, u_unit=1.0, y_unit=1.0, offset=3.0):
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(steps)
    y = lfilter([0, 0, 0, -0.1, -0.05], np.poly([0.9, 0.6]), u)
    e = noise * lfilter([1.0], [1.0, -0.8], rng.standard_normal(steps))
    return rn.ControllerLog(u_unit * u, y_unit * (y + e + offset))


@pytest.fixture(scope="module")
def from_log():
    return rn.design(log_of(), sample_time=0.5, **QUICK)


@pytest.mark.costly
def test_the_controller_is_one_for_the_plant_of_the_log(from_log):
    true = read_plant(TRUE, None, 2)
    assert (from_log.model.delay, from_log.model.sign) == (
        2,
        "-",
    ) and from_log.plant.sample_time == 0.5
    assert from_log.model.low_gain == pytest.approx(true.low_gain, rel=0.05)
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), from_log.fixed.compensator)) < 2.5


@pytest.mark.costly
def test_a_larger_disturbance_than_that_of_the_log_makes_the_controller_faster(from_log):
    size = 100 * from_log.logged.disturbance
    faster = rn.design(log_of(), sample_time=0.5, disturbance=size, **QUICK)
    low = np.array([1e-3, 1e-2])
    parts = [one.fixed.compensator.state_space() for one in (from_log, faster)]
    gains = [np.abs(responses_of(one, low)).ravel() for one in parts]
    assert (gains[1] > 2 * gains[0]).all()


@pytest.mark.costly
def test_what_the_log_shows_of_itself_is_evidence(from_log):
    logged = from_log.logged
    assert logged.stable_parts(from_log.fixed.compensator) == PARTS and len(logged.gains) == PARTS
    assert all(0.7 < gain < 1.4 for gain in logged.gains)
    low, high = from_log.uncertainty.gain
    assert low <= min(0.8, *logged.gains) and high >= max(1.25, *logged.gains)
    names = [question.name for question in from_log.questions]
    assert names[:3] == ["plant", "plant", "dead_time"]
    assert {"disturbance", "noise", "u_limits"} <= set(names)
    gates = {gate.name: gate for gate in logged.model.gates}
    assert {"effect of u", "gain", "rivals", "halves", "robustness"} <= set(gates)
    assert all(gate.passed for gate in gates.values())
    assert all(name in from_log.questions[0].words for name in gates)
    record = from_log._sheet().sections[0].record["verdict"]["log"]
    assert {one["name"] for one in record["gates"]} == set(gates)
    # 0.15/((1 - 0.9)(1 - 0.6)) = 3.75 with the other sign
    low, high = record["gain_interval"]
    assert low - 0.1 < -3.75 < high + 0.1 and len(record["poles"]) == logged.model.order
    # AR(1) at 0.8: the variance of its differences is 2 (1 - 0.8) of its own.
    size = 0.05 / np.sqrt(1 - 0.8**2)
    assert logged.noise == pytest.approx(size * np.sqrt(1 - 0.8), rel=0.1)


@pytest.mark.costly
def test_what_is_told_is_not_asked():
    designed = rn.design(log_of(), disturbance=rn.Step(0.2), noise=0.01, u_limits=(-3, 3), **QUICK)
    assert [question.name for question in designed.questions] == ["plant", "plant", "dead_time"]
    assert designed.expected.noise == 0.01


@pytest.mark.costly
def test_units_change_nothing_but_units():
    one, other = (plant_from_log(log_of(u_unit=u, y_unit=y)) for u, y in ((1, 1), (1e-6, 1e6)))
    assert (one.model.order, one.model.delay) == (other.model.order, other.model.delay)
    assert np.allclose(other.model.numerator / 1e12, one.model.numerator, rtol=1e-6)
    assert np.allclose(other.model.denominator, one.model.denominator, rtol=1e-6)
    assert other.noise == pytest.approx(1e6 * one.noise, rel=1e-6)
    assert other.disturbance == pytest.approx(1e-6 * one.disturbance, rel=1e-6)


@pytest.mark.costly
def test_a_dead_time_that_is_known_is_kept():
    assert plant_from_log(log_of(), 0.5, 0.5).plant.delay == 1


@pytest.mark.costly
def test_a_log_of_two_inputs_or_of_none_is_refused():
    two = np.random.default_rng(1).standard_normal((500, 2))
    with pytest.raises(InputError, match="2 controls"):
        rn.design(rn.ControllerLog(two, two[:, 0]), **QUICK)
    with pytest.raises(InputError, match="no effect of u"):
        rn.design(rn.ControllerLog(two[:, 0], two[:, 1]), **QUICK)


@pytest.mark.costly
def test_a_plant_with_direct_feedthrough_has_a_controller_of_the_row_before():
    """y(k) = 0.8 y(k-1) + 0.5 u(k): the controller computes u(k) from y(k-1)."""
    rng = np.random.default_rng(2)
    u = rng.standard_normal(1000)
    y = lfilter([0.5], [1, -0.8], u) + 0.05 * rng.standard_normal(1000)
    direct = rn.design(rn.ControllerLog(u, y), **QUICK)
    assert direct.logged.model.is_direct and direct.model.delay == 0
    assert any("same row" in one.assumed for one in direct.questions)
    true = read_plant("0.5/(q - 0.8)", None, 0)
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), direct.fixed.compensator)) < 2.5


@pytest.mark.costly
def test_a_plant_that_integrates_has_its_pole_at_1(from_log):
    rng = np.random.default_rng(440012)
    u = rng.standard_normal(2000)
    y = lfilter([0, 0, 0.05], np.poly([1.0, 0.8]), u)
    log = rn.ControllerLog(u, y + 0.1 * np.std(y) * rng.standard_normal(2000))
    integrating = rn.design(log, **QUICK)
    logged, true = integrating.logged, read_plant("0.05/((q - 1)*(q - 0.8))", None, 0)
    assert logged.model.integrators == 1 and not logged.integrates
    assert np.abs(np.linalg.eigvals(integrating.model.A) - 1).min() < 1e-12
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), integrating.fixed.compensator)) < 2.5
    assert any("pole at 1" in question.assumed for question in integrating.questions)
    assert from_log.logged.model.integrators == 0


def test_a_pole_near_1_that_no_pole_at_1_stands_for_is_asked_about(from_log):
    slow = replace(
        from_log.logged.model, denominator=np.poly([0.999, 0.5]), covariance=1e-4 * np.eye(3)
    )
    assert replace(from_log.logged, model=slow).integrates
    assert not replace(
        from_log.logged, model=replace(slow, covariance=1e-10 * np.eye(3))
    ).integrates
    assert not replace(from_log.logged, model=replace(slow, integrators=1)).integrates


@pytest.mark.costly
def test_the_fixed_controller_is_that_of_the_lqg_problem(from_log):
    """Which is computed when it is read, with its cost; u of the units over y of the units."""
    reference = from_log.reference
    compensator = reference.lqg.compensator
    unit_u, unit_y = reference.units
    np.testing.assert_allclose(reference.compensator.past_u, compensator.past_u, rtol=1e-9)
    np.testing.assert_allclose(
        reference.compensator.past_y, compensator.past_y * unit_u / unit_y, rtol=1e-9
    )
    assert reference.lqg.cost_gap < 1e-6


@pytest.mark.costly
def test_the_reason_of_a_log_is_that_of_its_best_model(monkeypatch):
    """It has no controller; of the next order a gate fails."""
    log = log_of()
    orders = []

    def first_gates(search, fit):
        orders.append(fit.order)
        gates = passed(search, fit)
        return tuple(replace(gate, passed=len(orders) == 1) for gate in gates)

    def no_controller(grid):
        raise NoSolutionError("no such controller")

    passed = LogSearch.first_gates
    monkeypatch.setattr(LogSearch, "first_gates", first_gates)
    monkeypatch.setattr(WeightGrid, "best", no_controller)
    with pytest.raises(NoSolutionError, match="no such controller"):
        rn.design(log, **QUICK)
    assert len(orders) > 1


@pytest.mark.costly
def test_where_the_best_model_has_no_controller_one_of_lower_order_is_taken(monkeypatch):
    best = WeightGrid.best

    def of_order_1(grid):
        poles = np.abs(np.linalg.eigvals(grid.plant.A))
        if np.sum(poles > 1e-9) > least:  # a second coefficient of B is a state at 0
            raise NoSolutionError("no such controller")
        return best(grid)

    monkeypatch.setattr(WeightGrid, "best", of_order_1)
    least = 1
    lower = rn.design(log_of(), **QUICK)
    assert lower.logged.model.order == 1 and lower.logged.model.delay >= 2
    assert any("no such controller" in question.words for question in lower.questions)
    true = read_plant(TRUE, None, 2)
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), lower.fixed.compensator)) < np.inf
    least = 0
    with pytest.raises(NoSolutionError, match="no such controller"):
        rn.design(log_of(), **QUICK)


def looped(steps=1500, noise=0.05, seed=0, dither=1.0):
    """A log of 1/((q - 1.05)(q - 0.5)), one step late, held by LQG; and the plant."""
    true = read_plant("0.1/((q - 1.05)*(q - 0.5))", None, 1)
    holding = rn.design(true.servo(), disturbance=1.0, noise=noise, **QUICK).fixed
    r = dither * np.repeat(np.random.default_rng(seed).choice([-1.0, 1.0], steps // 10), 10)
    w = rn.exogenous([rn.Recorded(r), rn.Step(0.0), rn.WhiteNoise(noise)], steps, seed)
    run = rn.simulate(true.servo(), holding, w)
    return run.u[:, 0], r - run.y[:, 0], r, true


@pytest.mark.costly
def test_an_unstable_plant_from_the_log_of_its_loop():
    u, y, r, true = looped()
    designed = rn.design(rn.ControllerLog(u, y), **QUICK)
    # Two poles more than zeros, and a step of dead time: y responds after three steps.
    assert designed.logged.is_closed and designed.model.delay == 2
    assert np.abs(np.linalg.eigvals(designed.model.A)).max() == pytest.approx(1.05, abs=0.01)
    assert designed.logged.noise == pytest.approx(0.05, rel=0.15)
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), designed.fixed.compensator)) < 2.5
    assert not any("stabilised loop" in question.words for question in designed.questions)
    with_r = rn.design(rn.ControllerLog(u, y, r=r), **QUICK)
    assert equal(with_r.settings, designed.settings)


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize(("u_unit", "y_unit", "period"), [(1e-6, 1e6, 1e6), (1e6, 1e-6, 1e-6)])
def test_the_design_of_a_loop_s_log_is_the_same_in_every_unit(u_unit, y_unit, period):
    u, y, *_ = looped()
    one = rn.design(rn.ControllerLog(u, y), sample_time=1.0, **QUICK)
    other = rn.design(rn.ControllerLog(u_unit * u, y_unit * y), sample_time=period, **QUICK)
    ours, theirs = one.fixed.compensator, other.fixed.compensator
    assert np.allclose(theirs.past_u, ours.past_u, rtol=1e-6)
    assert np.allclose(theirs.past_y * y_unit / u_unit, ours.past_y, rtol=1e-6)
    assert other.settings.R_z.nu * y_unit == pytest.approx(one.settings.R_z.nu, rel=1e-6)
    assert other.verdict.use == one.verdict.use


@pytest.mark.costly
def test_a_loop_that_nothing_moves_shows_no_plant():
    u, y, *_ = looped(dither=0.0)
    with pytest.raises(InputError, match="u is determined by y"):
        rn.design(rn.ControllerLog(u, y), **QUICK)


@pytest.mark.costly
def test_a_plant_that_no_model_reaches_is_seen_in_the_prediction_errors():
    """u acts after 1 step, and again after 19, where orders up to 4 are tried."""
    rng = np.random.default_rng(3)
    r, e = rng.standard_normal((2, 2000))
    u, y = np.zeros((2, 2000))
    for k in range(2000):
        y[k] = 0.5 * e[k] + (0.5 * y[k - 1] + u[k - 1] + u[k - 19] if k > 19 else 0.0)
        u[k] = r[k] - 0.1 * y[k]
    with pytest.raises(UndecidedError, match="misfit"):
        rn.design(rn.ControllerLog(u, y, r=r), **QUICK)


def test_the_gain_of_a_part_is_not_that_of_a_pole_and_a_zero_that_all_but_cancel_at_rest():
    """What fits the drift of the noise turns the sign at rest, and nothing at 0.02 rad/step."""
    lag, of_noise = "-0.1/(q - 0.9)", "(q - 1.0001)/(q - 0.9999)"
    whole = read_plant(lag, None, 0)
    part = read_plant(f"{lag}*{of_noise}", None, 0)
    assert (whole.sign, part.sign) == ("-", "+")
    shown = plant_from_log(log_of(400, noise=0.0))
    (gain,) = replace(shown, plant=whole, parts=(part,)).gains
    assert gain == pytest.approx(1.0, abs=0.02)


def two_inputs(seed, steps=700, gain=1.0):
    """Two inputs and outputs, diagonally dominant, with an offset."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.choice([-1.0, 1.0], (steps // 8 + 1, 2)), 8, axis=0)[:steps]
    u[:12] = 0.0
    y = np.stack([
        lfilter([0, 0, 0, gain * 0.3], [1, -0.8], u[:, 0]) + lfilter([0, 0.05], [1, -0.9], u[:, 1]),
        lfilter([0, 0.03], [1, -0.95], u[:, 0]) + lfilter([0, 0, -0.2], [1, -0.9], u[:, 1]),
    ], 1)  # fmt: skip
    return u, y + 0.05 * rng.standard_normal((steps, 2)) + [20.0, -3.0]


PLANT_OF_TWO = [["0.3/(q**2*(q - 0.8))", "0.05/(q - 0.9)"],
                ["0.03/(q - 0.95)", "-0.2/(q*(q - 0.9))"]]  # fmt: skip


@pytest.mark.costly
def test_a_frame_of_two_inputs_and_outputs_with_gaps_has_a_controller():
    pandas = pytest.importorskip("pandas")
    u, y = two_inputs(1)
    times = pandas.date_range("2024-01-01", periods=len(u), freq="60s")
    frame = pandas.DataFrame(np.hstack([u, y]), times, ["a", "b", "T1", "T2"])
    frame = frame[np.random.default_rng(1).random(len(frame)) > 0.1]
    log = rn.read_log(frame, {"u": ["a", "b"], "y": ["T1", "T2"]})
    designed = rn.design(log, **QUICK)
    with pytest.raises(InputError, match=r"read_log makes a log of it.*a, b, T1, T2"):
        rn.design(frame)
    model = designed.logged.model
    assert designed.model.sample_time == 60.0 and np.isnan(log.u).any()
    assert np.abs(model.gain / [[1.5, 0.5], [0.6, -2.0]] - 1).max() < 0.3
    assert not model.failed and any("missing" in one for one in model.assumptions)
    true = read_plant(PLANT_OF_TWO, None, 0)
    assert sensitivity_peak(rn.ClosedLoop(true.servo(), designed.fixed.compensator)) < 2.5
    record = designed._sheet().sections[0].record["verdict"]["log"]
    assert record["delays"] == [list(row) for row in model.delays] and record["assumptions"]


@pytest.mark.costly
def test_experiments_of_one_plant_are_joined_and_of_two_plants_refused():
    logs = [rn.ControllerLog(*two_inputs(seed)) for seed in (1, 2)]
    options = _DesignOptions("unknown", None, None, None, None, None, False)
    basis = _basis_of_log(logs, None, 0.0, options)
    assert len(basis.logged.parts) == 2 and min(basis.logged.gains) > 0.8
    other = rn.ControllerLog(*two_inputs(2, gain=-1.0))
    with pytest.raises(UndecidedError, match="parts"):
        _basis_of_log([logs[0], logs[0], other], None, 0.0, options)
    narrow = rn.ControllerLog(logs[0].u[:, 0], logs[0].y[:, 0])
    with pytest.raises(InputError, match="the same signals"):
        rn.design([logs[0], narrow])
    slow, fast = (rn.ControllerLog(*two_inputs(1), sample_time=h) for h in (1.0, 2.0))
    with pytest.raises(InputError, match="must have the same"):
        rn.design([slow, fast])
    with pytest.raises(InputError, match="Leave it out"):
        rn.design(logs, dead_time=2.0)


@pytest.mark.costly
def test_a_scalar_log_with_gaps_has_a_controller():
    log = log_of()
    lost = np.random.default_rng(3).random(log.steps) < 0.1
    u, y = (np.where(lost[:, None], np.nan, one) for one in (log.u, log.y))
    options = _DesignOptions("unknown", None, None, None, None, None, False)
    basis = _basis_of_log(rn.ControllerLog(u, y, has_gaps=True), 0.5, 0.0, options)
    true = read_plant(TRUE, None, 2)
    loop = rn.ClosedLoop(true.servo(), basis.reference.compensator)
    assert sensitivity_peak(loop) < 2.5 and not basis.logged.model.failed


@pytest.mark.costly
@pytest.mark.parametrize("has_gaps", [False, True])
def test_a_dead_time_of_hundreds_of_rows_has_a_controller_that_skips_rows(has_gaps):
    rng = np.random.default_rng(3)
    u = np.repeat(rng.choice([-1.0, 1.0], 20), 100)
    u[:20] = 0.0
    y = lfilter(np.r_[np.zeros(151), 0.04], [1, -0.96], u) + 0.05 * rng.standard_normal(2000)
    lost = has_gaps & (rng.random(2000) < 0.1)
    u[lost], y[lost] = np.nan, np.nan
    log = rn.ControllerLog(u, y, sample_time=0.5, has_gaps=True)
    options = _DesignOptions("unknown", None, None, None, None, None, False)
    basis = _basis_of_log(log, None, 0.0, options)
    assert basis.logged.every == 5 and basis.model.sample_time == 2.5
    true = slower_plant(replace(read_plant("0.04/(q - 0.96)", None, 0), delay=150), 5)
    loop = rn.ClosedLoop(true.servo(), basis.reference.compensator)
    assert sensitivity_peak(loop) < 2.5
