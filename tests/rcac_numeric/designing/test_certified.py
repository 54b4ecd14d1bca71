"""A design whose RCAC is kept in a certified set: what it is judged by, and where there is none."""

import attrs
import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    CertifiedBounds,
    CoefficientBounds,
    ControllerSettings,
    Uncertainty,
    certified_set,
    design,
    fir,
    pid,
    simulate,
)
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._design import MOST_PROVED, certified_or_reason, compared
from rcac_numeric.designing._trials import BOXED, FIXED, RCAC, sensitivity

LAG = {"sample_time": 1.0, "disturbance": 0.5, "noise": 0.02, "seeds": 1, "steps": 400}
LOSES = {"uncertainty": Uncertainty(delay=3), "dead_time": 1.0}  # of an unstable plant
SQUARE = [["1/(10*s + 1)", "0.4/(8*s + 1)"], ["0.3/(6*s + 1)", "1.2/(12*s + 1)"]]


@pytest.fixture(scope="module")
def certified():
    return design("2/(10*s + 1)", kept="certified", **LAG)


@pytest.fixture(scope="module")
def boxed():
    return design("2/(10*s + 1)", **LAG)


def trials_of(designed, name):
    return [t for t in designed.evidence if t.controller == name]


def test_the_set_is_proved_for_the_whole_family_and_keeps_rcac(certified):
    region = certified.certified
    assert region.is_verified
    assert [one.name for one in region.members] == ["nominal", *certified.family]
    assert equal(certified.settings.bounds, region.bounds)
    fresh = certified_set(certified.plant, certified.settings, uncertainty=certified.family)
    assert np.array_equal(fresh.regressor_factor, region.regressor_factor)
    run = certified.runs[RCAC]
    assert region.contains(run.theta) and region.contains(run.theta_final)


def test_rcac_in_the_box_is_the_one_of_the_design_without_a_set(certified, boxed):
    assert isinstance(boxed.settings.bounds, CoefficientBounds) and boxed.certified is None
    in_set = attrs.evolve(boxed.settings, bounds=certified.settings.bounds)
    assert equal(certified.settings, in_set)
    pairs = ((BOXED, RCAC), (FIXED, FIXED))
    for ours, theirs in pairs:
        rows = zip(trials_of(certified, ours), trials_of(boxed, theirs), strict=True)
        assert all((a.rms, a.peak, a.Ms) == (b.rms, b.peak, b.Ms) for a, b in rows)


def test_the_guarantee_is_measured_on_the_test_runs(certified, boxed):
    guarantee = certified.verdict.guarantee
    ours, theirs = trials_of(certified, RCAC), trials_of(certified, BOXED)
    logs = [np.log(a.rms[0] / b.rms[0]) for a, b in zip(ours, theirs, strict=True)]
    assert guarantee.beside_box.ratio == pytest.approx(np.exp(np.mean(logs)))
    assert compared(certified.evidence, RCAC).ratio == certified.verdict.rcac.ratio
    used = [r for t in ours for r in t.radius]
    assert guarantee.radius == max(used) <= 1
    assert guarantee.met == (sum(r == 1 for r in used), len(used))
    assert np.isnan([t.radius for t in theirs]).all()
    # The nominal trial is the run of the design, whose every theta is stored.
    run = certified.runs[RCAC]
    every = max(run.radius.max(), float(run.bounded > 0))
    assert used[0] == pytest.approx(every, abs=0.05)
    assert boxed.verdict.guarantee is None


def test_the_report_names_the_plants_of_the_proof(certified):
    report = " ".join(certified.report().split())
    assert "Proved in exact arithmetic for 6 plants (nominal, " in report
    assert all(name in report for name in certified.family)
    assert "Not covered: u_limits" not in report
    assert all(words in report for words in certified.certified.uncovered)
    record = certified._sheet().record
    assert record["verdict"]["certified"]["plants"] == ["nominal", *certified.family]


def test_the_picture_has_the_share_of_the_radius(certified, boxed):
    line = certified.plot().axes[2].lines[0]
    assert np.array_equal(line.get_ydata(), certified.runs[RCAC].radius)
    assert len(certified.plot().axes) == len(boxed.plot().axes) + 1


def test_a_family_that_theta_0_loses_has_no_set_and_keeps_the_box():
    lost = design("1/(5*s - 1)", kept="certified", **{**LAG, **LOSES})
    assert "theta_0 itself" in lost.certified and "delay + 3" in lost.certified
    assert isinstance(lost.settings.bounds, CoefficientBounds)
    assert lost.verdict.guarantee is None
    assert BOXED not in lost.runs and not trials_of(lost, BOXED)
    report = " ".join(lost.report().split())
    assert "No certified set" in report and "certified set:" not in str(lost.verdict)


@pytest.mark.costly
def test_a_set_is_suggested_where_rcac_in_the_box_lost_a_test_run(boxed, certified):
    """At a noise that is half of the disturbance, the box does not keep the four lags stable."""
    lags = "1/((s + 1)*(s/5 + 1)*(s/25 + 1)*(s/125 + 1))"
    data = {"sample_time": 0.05, "noise": 0.5, "disturbance": 0.5, "seeds": 3}
    lost = design(lags, **data)
    stable, runs = lost.verdict.rcac.stable
    assert stable < runs and lost.possible_set.is_verified
    words = f"RCAC is unstable in {runs - stable} of {runs} test runs; a certified set exists"
    assert words in " ".join(lost.report().split())
    in_set = design(lags, kept="certified", **data)
    assert in_set.verdict.rcac.stable == (runs, runs) and in_set.possible_set is None
    assert boxed.possible_set is None and certified.possible_set is None
    assert "certified" not in boxed.report()


def test_a_proof_that_takes_minutes_is_left_to_the_user(boxed):
    taps = fir(MOST_PROVED + 1)
    target = boxed.settings.target
    many = ControllerSettings(structure=taps, target=target, update=UD(R_theta=1.0))
    reason = certified_or_reason(boxed.plant, many, boxed.family)
    assert f"{MOST_PROVED + 1} coefficients" in reason and "6 plants" in reason


@pytest.mark.costly
def test_a_limit_of_u_is_not_covered_by_name():
    limited = design("2/(10*s + 1)", kept="certified", u_limits=(-0.3, 0.3), **LAG)
    run = limited.runs[RCAC]
    steps = int((run.u_applied != run.u).any(axis=1).sum())
    assert steps > 0
    report = " ".join(limited.report().split())
    assert "Not covered: u_limits." in report and f"in {steps} of 400 steps" in report


@pytest.mark.parametrize("word", ["stable", None, True])
def test_other_words_are_refused(word):
    with pytest.raises(InputError, match="kept"):
        design("2/(10*s + 1)", kept=word, **LAG)


@pytest.mark.costly
@pytest.mark.parametrize(
    ("G", "options"),
    [
        ("2/(10*s + 1)", {"structure": pid("PI"), "dead_time": 2.0}),
        ("1/(20*s - 1)", {"noise": 0.01}),
        (SQUARE, {}),
    ],
)
def test_a_weak_prior_loses_no_plant_of_the_family(G, options):
    """The theorem: whatever the prior learns, the frozen loop of every theta is stable."""
    designed = design(G, kept="certified", **{**LAG, **options})
    assert isinstance(designed.settings.bounds, CertifiedBounds)
    weak = attrs.evolve(designed.settings.update, R_theta=designed.settings.update.R_theta / 1000)
    settings = attrs.evolve(designed.settings, update=weak)
    w = designed.expected.w(1000, 5)
    plants = [designed.plant, *designed.family.values()]
    runs = [simulate(plant, settings, w) for plant in plants]
    for run in runs:
        assert run.outcome == "completed" and designed.certified.contains(run.theta)
        assert np.isfinite(sensitivity(run))  # stable with the last theta
    assert any(run.bounded for run in runs)  # the set was needed


@pytest.mark.costly
def test_a_limit_of_an_integrator_is_not_covered_by_name():
    structure = pid("PI", integral_limit=1.0)
    limited = design("2/(10*s + 1)", kept="certified", structure=structure, **LAG)
    assert isinstance(limited.settings.bounds, CertifiedBounds)
    assert "limits of integrators" in " ".join(limited.report().split())
