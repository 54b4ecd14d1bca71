"""Runs that lanes refuse, and runs that fail in them: as in the ordinary loop."""

import numpy as np
import pytest

from rcac_numeric import (
    UD,
    ControllerSettings,
    Covariance,
    CovarianceReset,
    Decentralized,
    Gradient,
    Instantaneous,
    Plant,
    PlantChange,
    PlantSchedule,
    Saturation,
    ScheduledForgetting,
    SignalWeight,
    SimulationCase,
    SlidingWindow,
    TargetModel,
    VariableRateForgetting,
    fir,
    iir,
    pid,
    simulate,
    simulate_many,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from tests.support.comparisons import identical
from tests.support.function_plants import as_functions
from tests.support.lane_cases import GOOD, PLANT, SIGNALS, arguments
from tests.support.signals import white

REFUSED = {
    "covariance": {"update": Covariance(R_theta=1.0)},
    "sliding window": {"update": SlidingWindow(R_theta=1.0, window=5)},
    "instantaneous": {"update": Instantaneous(R_theta=1.0)},
    "gradient": {"update": Gradient(step_size=1e-3)},
    "filter form": {"form": "filter"},
    "process noise": {"update": UD(R_theta=1.0, process_noise=1e-3)},
    "variable-rate forgetting": {
        "update": UD(R_theta=1.0, lambda_=VariableRateForgetting(5, 20, 1.0))
    },
    "scheduled forgetting": {"update": UD(R_theta=1.0, lambda_=ScheduledForgetting({20: 0.95}))},
    "target changes": {"target_changes": {20: TargetModel([0, 2.0])}},
    "reset at": {"update": UD(R_theta=1.0, reset=CovarianceReset(at=[10]))},
    "reset every": {"update": UD(R_theta=1.0, reset=CovarianceReset(every=20))},
    "reset by trace": {"update": UD(R_theta=1.0, reset=CovarianceReset(trace_below=0.5))},
    "reset by growth": {
        "update": UD(R_theta=1.0, reset=CovarianceReset(growth=1.1, short=5, long=20))
    },
    "freeze": {"freeze": [(10, 20)]},
    "reflected poles": {"reflect_poles": True},
    "stop where unsupported": {"update": UD(R_theta=1.0, stop_where_unsupported=True)},
    "k_filter": {"k_filter": 2},
    "R_z function": {"R_z": lambda k, y, z, u: 1.0 + z[0] ** 2},
    "R_u function": {"R_u": lambda k, y, z, u: 0.1},
    "PID": {"structure": pid("PID"), "theta_0": None},
}
SWITCHED = PlantSchedule(
    [
        PlantChange(start=0, plant=PLANT),
        PlantChange(start=30, plant=standard_plant("1/(q*(q - 0.8))")),
    ]
)
OTHER_LOOPS = {
    "schedule": SimulationCase(SWITCHED, GOOD, white(80)),
    "ramp": SimulationCase(
        PlantSchedule(
            [replace(SWITCHED.changes[0], ramp=True), SWITCHED.changes[1]]
        ),
        GOOD, white(80),
    ),
    "delay": SimulationCase(
        PlantSchedule([PlantChange(start=0, plant=PLANT, delay=2)]), GOOD, white(80)
    ),
    "functions": SimulationCase(as_functions(PLANT), GOOD, white(80)),
    "saturation": SimulationCase(
        PLANT, GOOD, white(80), {"saturation": Saturation(low=-0.1, high=0.1)}
    ),
    "decentralised": SimulationCase(PLANT, Decentralized([GOOD, GOOD]), white(80)),
}  # fmt: skip


@pytest.mark.parametrize("name", [*REFUSED, *OTHER_LOOPS])
def test_what_lanes_do_not_do_takes_the_ordinary_loop(name):
    case = OTHER_LOOPS.get(name)
    if case is None:
        case = SimulationCase(PLANT, replace(GOOD, **REFUSED[name]), white(80))
    eligible = SimulationCase(PLANT, GOOD, white(80, seed=1))
    runs = simulate_many([eligible, case, eligible], lanes=True)
    assert identical(runs[1], simulate(**arguments(case)))
    assert identical(runs[0], runs[2])


def test_weights_out_of_range_and_many_performance_variables():
    wide = Plant(
        A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[1.0], [0.5], [0.2], [0.1]]
    )  # fmt: skip
    four = ControllerSettings(
        structure=iir(2), target=TargetModel(np.ones((2, 4, 1))), update=UD(R_theta=1.0)
    )
    two = ControllerSettings(
        structure=iir(2), target=TargetModel(np.ones((2, 2, 1))), update=UD(R_theta=1.0),
        R_u=SignalWeight(0.1, 0.1),
    )  # fmt: skip
    for case in (
        SimulationCase(wide, four, white(40)),
        SimulationCase(replace(wide, E_1=[[1.0], [0.5]], E_0=None, E_2=None), two, white(40)),
        SimulationCase(PLANT, replace(GOOD, R_z=1e-200), white(40)),
        SimulationCase(PLANT, replace(GOOD, R_z=1e200), white(40)),
    ):
        (run,) = simulate_many([case], lanes=True)
        assert identical(run, simulate(**arguments(case)))


# Each ends early in its own way, while the data still decide in which step.
UNSTABLE = standard_plant("1/(q - 3)")
WRONG_SIGN = ControllerSettings(
    structure=iir(3), target=TargetModel([0, -1.0]), update=UD(R_theta=1e6)
)
FIXED = replace(WRONG_SIGN, k_update=10**6)
FAILING = {
    "high limit": (SimulationCase(UNSTABLE, FIXED, white(400)), "diverged"),
    "low limit": (
        SimulationCase(UNSTABLE, WRONG_SIGN, white(400), {"divergence_limit": 1e3}), "diverged",
    ),
    "tiny limit": (
        SimulationCase(UNSTABLE, WRONG_SIGN, white(400), {"divergence_limit": 1e-170}), None,
    ),
    "no limit": (SimulationCase(UNSTABLE, FIXED, white(2000), {"divergence_limit": 1e308}), None),
    "theta": (
        SimulationCase(
            PLANT, replace(GOOD, update=UD(R_theta=1e-30), theta_0=np.full(6, 0.3)), white(40),
            {"divergence_limit": 0.2},
        ),
        "diverged",
    ),
    "overflow": (
        SimulationCase(PLANT, replace(GOOD, update=UD(R_theta=1e-300)), 1e8 * white(40)),
        "overflow",
    ),
    "plant": (
        SimulationCase(replace(PLANT, exact=None, E_0=[[1e308]]), GOOD,
             np.r_[1e-300 * white(20), [[1e3]], white(9)]),
        "plant not finite",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAILING)
def test_a_failing_run_ends_as_it_does_alone_and_touches_nobody(name):
    case, outcome = FAILING[name]
    healthy = [
        SimulationCase(PLANT, replace(GOOD, theta_0=np.full(6, 0.01 * i)), white(60 + i, seed=i))
        for i in range(9)
    ]
    # The failing plant has fewer states in some cases: the same company at its own order too.
    company = [replace(case, settings=replace(case.settings, theta_0=np.full(6, 1e-3)))] * 2
    runs = simulate_many([*healthy, case, *company], lanes=True)
    single = simulate(**arguments(case))
    run = runs[len(healthy)]
    assert (run.outcome, run.steps) == (single.outcome, single.steps)
    assert outcome in (None, run.outcome) and run.outcome != "completed" and run.state is None
    assert run.guard_count == single.guard_count
    for signal in SIGNALS:
        value, expected = getattr(run, signal), getattr(single, signal)
        assert np.isfinite(value).all()
        np.testing.assert_allclose(value, expected, rtol=1e-6, atol=1e-12)
    for one, in_company in zip(healthy, runs, strict=False):
        assert identical(in_company, simulate_many([one], lanes=True)[0])


def test_overflow_in_the_first_of_two_measurements():
    """The second one is finite again, and must not hide it."""
    plant = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[1.0], [0.5]])
    target = TargetModel(np.array([[[0.0], [0.0]], [[1e160], [1.0]]]))
    settings = ControllerSettings(structure=fir(1), target=target, update=UD(R_theta=1.0))
    case = SimulationCase(plant, settings, white(20))
    (run,) = simulate_many([case], lanes=True)
    single = simulate(**arguments(case))
    assert (run.outcome, run.steps) == (single.outcome, single.steps) == ("overflow", single.steps)


def test_data_that_support_no_R_theta_are_counted():
    """y = 1 gives the rows (1, 1), which say nothing of theta_1 - theta_2."""
    plant = Plant(
        A=[[0.5]], B=[[1.0]], D_1=[[0.0]], C=[[0.0]], D_2=[[1.0]], E_1=[[1.0]], E_0=[[1.0]]
    )
    settings = ControllerSettings(
        structure=fir(2), target=TargetModel([0, 1.0]), update=UD(R_theta=1e-30), k_w=5
    )
    constant = SimulationCase(plant, settings, np.ones((40, 1)))
    healthy = SimulationCase(plant, replace(settings, update=UD(R_theta=1.0)), white(40))
    run, other = simulate_many([constant, healthy], lanes=True)
    single = simulate(**arguments(constant))
    assert single.guard_count > 0 and run.guard_first_step == single.guard_first_step
    assert run.guard_count > 0 and other.guard_count == 0
