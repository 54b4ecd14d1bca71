"""Runs in lanes: as accurate as `simulate`, the same in any company, refused where they must be."""

import attrs
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.compiled import _kernel
from rcac_numeric.plants._linear import MATRICES
from tests.support.comparisons import identical, same
from tests.support.ellipsoids import ellipsoid, exact_square
from tests.support.engine_cases import engine_plants, settings_for, structures
from tests.support.lane_cases import GOOD, PLANT, SIGNALS, arguments, ready_run
from tests.support.signals import white
from tests.support.strategies import seeds, sizes

KINDS = ("iir", "fir", "quasi_fir", "centralised", "fb_fir", "ff")
EPSILON = np.finfo(float).eps


@st.composite
def batches(draw, most=10):
    """Cases that share a structure and sizes, and nothing else."""
    l_u, l_y, l_z, l_r = draw(sizes), draw(sizes), draw(sizes), draw(st.integers(0, 1))
    structure, _ = draw(structures(l_u, l_y, l_r, KINDS))
    weights = {}
    if l_z == 1 and draw(st.booleans()):
        weights = {"R_u": rn.SignalWeight(0.1, 0.5), "R_z": rn.SignalWeight(1.0, 0.2)}
    common = draw(settings_for(structure, l_z, k_filter=0, **weights))
    n, rng = draw(st.integers(1, 3)), np.random.default_rng(draw(seeds))
    widths = draw(st.sampled_from([(None,), (None, 0.3), (0.02, 0.3, 100.0)]))
    cases = []
    for _ in range(draw(st.integers(1, most))):
        plant = draw(engine_plants(l_u, l_y, l_z, structure.l_r, n))
        if not structure.measures_first and draw(st.booleans()):
            plant = replace(
                plant, D_0=rng.standard_normal((l_y, l_u)) / 4, E_2=rng.standard_normal((l_z, l_u))
            )
        theta_0, bounds = 0.1 * rng.standard_normal(structure.l_theta), None
        if (width := draw(st.sampled_from(widths))) is not None:
            bounds = ellipsoid(draw(seeds), structure.l_theta, width=width, center=theta_0)
        settings = replace(
            common,
            bounds=bounds,
            update=rn.UD(
                R_theta=common.update.R_theta * 10 ** rng.uniform(-1, 1),
                lambda_=draw(st.sampled_from([1.0, 0.97, 0.9])),
            ),
            theta_0=theta_0,
            target=rn.TargetModel(
                np.asarray(common.target.numerator) * rng.uniform(0.5, 1),
                common.target.denominator,
            ),
        )
        w = rng.standard_normal((int(rng.integers(1, 40)), plant.l_w))
        options = {"stride": draw(st.integers(1, 4)), "x_0": rng.standard_normal(n)}
        cases.append(rn.SimulationCase(plant, settings, w, options))
    return cases


def perturbed(case, rng, relative):
    """The case with every number that it begins with moved by about `relative` of its size."""
    move = lambda a: a * (1 + relative * rng.choice([-1.0, 1.0], np.shape(a)))  # noqa: E731
    matrices = {name: move(getattr(case.plant, name)) for name in MATRICES}
    update, theta_0, bounds = (
        case.settings.update,
        move(case.settings.theta_0),
        case.settings.bounds,
    )
    if bounds is not None:
        bounds = rn.CertifiedBounds(theta_0, move(bounds.factor))
    settings = replace(
        case.settings,
        theta_0=theta_0,
        bounds=bounds,
        update=attrs.evolve(update, R_theta=update.R_theta * move(1.0)),
    )
    options = {**case.options, "x_0": move(case.options.get("x_0", np.zeros(case.plant.n)))}
    return rn.SimulationCase(
        replace(case.plant, exact=None, **matrices), settings, move(case.w), options
    )


def uncertainty(case, run, limit=100.0):
    """What rounding may do to each signal.

    In a step each number is rounded after sums of no more than `terms` products, in either loop.
    Both are then exact for data moved by so much at every step; what such a move does is measured
    by moving the data of the whole run. None where the digits of neither are certain: where the
    run hangs on its data by more than that measures, or grows, so that a late step's rounding
    outweighs all that the first data do.
    """
    if np.abs(run.u).max(initial=0) > limit:
        return None
    rng, relative = np.random.default_rng(0), 1e-9
    others = [rn.simulate(**arguments(perturbed(case, rng, relative))) for _ in range(4)]
    if any(other.steps != run.steps for other in others):
        return None
    terms = 4 * (run.settings.structure.l_theta + case.plant.n + case.plant.l_w + 8)
    result = {}
    for name in SIGNALS:
        value = getattr(run, name)
        moved = max(np.abs(getattr(other, name) - value).max(initial=0) for other in others)
        size = 1.0 + np.abs(value).max(initial=0)
        result[name] = EPSILON * terms * max(1, run.steps) * (moved / relative + size)
        if moved > 1e-3 * size:
            return None
    return result


def assert_close(run, other, bounds):
    for name in SIGNALS if bounds else ():
        difference = np.abs(getattr(run, name) - getattr(other, name)).max(initial=0)
        assert difference <= bounds[name], (name, difference, bounds[name])


@given(batches(), st.integers(1, 2))
def test_lanes_differ_from_single_runs_by_rounding(cases, threads):
    for case, run in zip(cases, rn.simulate_many(cases, threads=threads, lanes=True), strict=True):
        single = rn.simulate(**arguments(case))
        bounds = uncertainty(case, single)
        if bounds:
            assert (run.outcome, run.guard_count) == (single.outcome, single.guard_count)
            assert_close(run, single, bounds)


@given(st.data(), batches(most=20), st.integers(1, 3), seeds)
def test_a_case_is_the_same_in_any_company(data, cases, threads, seed):
    # Guarded, diverging and ending lanes among the others.
    wild = [
        replace(case, settings=replace(case.settings, **change), options={"divergence_limit": 1e12})
        for case in cases[:3]
        for change in (
            {"update": rn.UD(R_theta=1e-25)},
            {"bounds": None, "theta_0": 1e3 * np.ones_like(case.settings.theta_0)},
        )
    ]
    everything = [*cases, *wild]
    order = np.random.default_rng(seed).permutation(len(everything))
    together = rn.simulate_many([everything[i] for i in order], threads=threads, lanes=True)
    for i, run in zip(order, together, strict=True):
        (alone,) = rn.simulate_many([everything[i]], lanes=True)
        assert identical(run, alone)


@given(batches(most=3), st.data())
@hypothesis_settings(max_examples=20)
def test_a_run_in_lanes_can_be_cut_and_resumed(cases, data):
    whole = rn.simulate_many(cases, lanes=True)
    assume(all(run.outcome == "completed" for run in whole))
    cuts = [data.draw(st.integers(0, len(case.w))) for case in cases]
    pieces = [
        replace(case, w=case.w[:cut], options={**case.options, "stride": 1})
        for case, cut in zip(cases, cuts, strict=True)
    ]
    first = rn.simulate_many(pieces, lanes=True)
    rest = [
        replace(case, w=case.w[cut:], options={"start": run.state})
        for case, cut, run in zip(cases, cuts, first, strict=True)
    ]
    for run, half, cut, case in zip(
        whole, rn.simulate_many(rest, lanes=True), cuts, cases, strict=True
    ):
        assert half.first_step == cut and half.state.k == len(case.w)
        assert np.array_equal(half.z, run.z[cut:])
        assert half.state.values.tobytes() == run.state.values.tobytes()
    # The ordinary loop goes on from there too, and the other way round.
    for case, half, cut in zip(cases, first, cuts, strict=True):
        single = rn.simulate(**arguments(case))
        mixed = rn.simulate(case.plant, case.settings, case.w[cut:], start=half.state)
        bounds = uncertainty(case, single)
        if bounds:
            assert np.abs(mixed.z - single.z[cut:]).max(initial=0) <= bounds["z"]
            assert np.abs(mixed.theta_final - single.theta_final).max() <= bounds["theta_final"]


@pytest.mark.costly
@pytest.mark.parametrize("instruction_set", _kernel.instruction_sets())
@pytest.mark.parametrize("n_c", [1, 4, 5, 10])
def test_no_theta_leaves_its_ellipsoid_in_lanes(instruction_set, n_c):
    """Of eleven runs, so that lanes stay idle; some project often, some never."""
    cases, size = [], 2 * n_c
    for seed in range(11):
        bounds = ellipsoid(seed, size, width=[0.01, 0.1, 1e3][seed % 3], center=np.zeros(size))
        settings = rn.ControllerSettings(
            structure=rn.iir(n_c), target=GOOD.target, bounds=bounds,
            update=rn.UD(1e-4, lambda_=0.999),
        )  # fmt: skip
        cases.append(rn.SimulationCase(PLANT, settings, white(60 + seed, seed)))
    prepared = [ready_run(**arguments(case), supervision=rn.Supervision()) for case in cases]
    while _kernel.run_jobs([one.job for one in prepared], 1, 1e-5, True, instruction_set):
        pass
    for case, one in zip(cases, prepared, strict=True):
        run, alone = one.result(), rn.simulate(**arguments(case), supervision=rn.Supervision())
        bounds = case.settings.bounds
        assert all(exact_square(bounds, theta) <= 1 for theta in run.theta)
        looks = bounds.radius_of(np.vstack([run.theta, run.theta_final])[16::16])
        assert run.supervision.radius == pytest.approx(looks.max(), rel=1e-9)
        assert (run.bounded > 0) == (alone.bounded > 0) == (bounds.factor[0, 0] < 1)
        assert_close(run, alone, uncertainty(case, alone))


@pytest.mark.costly
@given(batches(most=9))
@hypothesis_settings(max_examples=20)
def test_every_instruction_set_does_the_same(cases):
    singles = [rn.simulate(**arguments(case)) for case in cases]
    for instruction_set in _kernel.instruction_sets():
        prepared = [ready_run(**arguments(case)) for case in cases]
        while _kernel.run_jobs([one.job for one in prepared], 2, 1e-5, True, instruction_set):
            pass
        for case, single, one in zip(cases, singles, prepared, strict=True):
            assert_close(one.result(), single, uncertainty(case, single))


def test_eligible_runs_are_not_the_ordinary_loop():
    """Else the tests above would show nothing."""
    case = rn.SimulationCase(PLANT, GOOD, white(200))
    (run,) = rn.simulate_many([case], lanes=True)
    assert not same(run, rn.simulate(**arguments(case)))
    assert identical(rn.simulate_many([case])[0], rn.simulate(**arguments(case)))


@pytest.mark.parametrize("R_theta", [1.0, 1e-10, 1e-20])
def test_lanes_beside_ball_arithmetic(R_theta):
    settings = replace(GOOD, update=rn.UD(R_theta=R_theta))
    cases = [rn.SimulationCase(PLANT, settings, white(40, seed)) for seed in range(3)]
    for case, run in zip(cases, rn.simulate_many(cases, lanes=True), strict=True):
        exact, bounds = rn.simulate_reference(**arguments(case)), uncertainty(case, run, np.inf)
        assert exact.digits > 50 and run.guard_count == 0 and bounds
        assert_close(run, exact, bounds)


def test_lanes_is_a_truth_value():
    with pytest.raises(InputError, match="lanes = 8 is not a bool"):
        rn.simulate_many([], lanes=8)
