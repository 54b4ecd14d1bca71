"""From which step on a run is proved stable: the decrease of one function, and the refusals."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    FixedController,
    LoopAnalysis,
    PlantChange,
    PlantSchedule,
    Saturation,
    TargetModel,
    certified_from,
    check_controller,
    iir,
    simulate,
    standard_plant,
)
from rcac_numeric.analysis._certified_tail import _CenterSearch, _is_inside
from rcac_numeric.analysis._regressor_system import exact, rational_matrix, regressor_system
from rcac_numeric.reports._certified import MOST_COEFFICIENTS, MOST_PLANTS
from tests.support.engine_cases import cases, engine_plants
from tests.support.strategies import seeds

PLANT = standard_plant("1/(q - 0.9)")
OTHER = standard_plant("1.3/(q - 0.85)")


def first_order(**changed):
    fields = {"structure": iir(1), "target": TargetModel([0, 1]), "update": UD(R_theta=1.0)}
    return ControllerSettings(
        **fields | {"theta_0": [0.0, -0.3], "k_w": 0, "k_update": 2} | changed
    )


def noise(steps, seed=0, size=1.0):
    return size * np.random.default_rng(seed).standard_normal((steps, 1))


def largest_step(tail, theta):
    """Largest factor of sqrt(x'Px) in one step with theta."""
    member = tail.set.members[0]
    P = np.array([[float(e) for e in row] for row in member.P])
    root = np.linalg.cholesky(P / np.abs(P).max()).T
    A = regressor_system(member.plant, tail.set.structure, tail.set.fixed).loop_matrix(theta)
    return np.linalg.norm(np.linalg.solve(root.T, (root @ A).T), 2)


@pytest.mark.costly
@given(st.data(), st.sampled_from([(1, 1, 0), (2, 1, 1), (2, 2, 0)]), seeds)
def test_one_function_falls_at_every_step_of_the_tail(data, widths, seed):
    l_u, l_y, l_r = widths
    chosen, _ = data.draw(cases(l_u, l_y, 1, l_r))
    plant = data.draw(engine_plants(l_u, l_y, 1, l_r))
    w = np.random.default_rng(seed).standard_normal((80, plant.l_w))
    run = simulate(plant, chosen, w)
    assume(run.outcome == "completed")
    tail = certified_from(run)
    if tail.k0 is None:
        assert "pole" in tail.reason
        return
    assert tail.is_verified
    assert tail.k0 >= chosen.k_w
    for theta in tail.theta:
        assert largest_step(tail, theta) <= 1 + 1e-7
    if tail.k0 > chosen.k_w:
        before = run.theta[tail.k0 - 1]
        moved = (before - tail.set.center).reshape(-1, l_u) / tail.set.input_scale
        radius = np.linalg.norm(np.linalg.solve(tail.set.regressor_factor, moved), 2)
        assert radius >= 1 - 1e-6  # the earliest step of this set
    assert pickle.loads(pickle.dumps(tail)) == tail


@pytest.mark.parametrize(("G", "R_theta"), [("1/(q - 1.2)", 1e2), ("1/(q - 0.99)", 1e2)])
def test_a_center_beside_the_last_theta_begins_earlier(G, R_theta):
    """The same search around the last theta alone needs theta to come much nearer."""
    plant = standard_plant(G)
    run = simulate(plant, first_order(theta_0=[0.0, 0.0], update=UD(R_theta)), noise(400))
    tail = certified_from(run)
    search = _CenterSearch(regressor_system(plant, iir(1)), iir(1), run.theta)
    _, around_last = search._around(run.theta[-1], 0, None)
    assert tail.is_verified
    assert tail.earliest <= tail.k0 < around_last
    assert "no set begins" in tail.report()


def test_a_constant_theta_is_proved_from_the_first_step_on():
    run = simulate(PLANT, first_order(freeze=[(0, None)], k_w=3), noise(50))
    tail = certified_from(run)
    assert (tail.k0, tail.is_moving) == (3, False)
    assert tail.is_verified


def test_an_early_part_of_the_run_that_is_unstable_is_left_out():
    """theta_0 loses the plant; the proof begins after theta came back."""
    plant = standard_plant("1/(q - 1.2)")
    run = simulate(plant, first_order(theta_0=[0.0, 0.0]), noise(300))
    tail = certified_from(run)
    assert tail.is_verified
    assert tail.is_moving
    radii = [
        np.abs(np.linalg.eigvals(regressor_system(plant, iir(1)).loop_matrix(theta))).max()
        for theta in run.theta
    ]
    assert max(radii) > 1
    assert max(radii[tail.k0 :]) < 1
    assert radii[tail.earliest - 1] >= 1 > max(radii[tail.earliest :])
    assert tail.earliest <= tail.k0
    assert tail.k0 > int(np.flatnonzero(np.array(radii) >= 1)[-1])
    assert f"from step {tail.k0} on, while theta still moves" in " ".join(tail.report().split())


def test_a_theta_that_leaves_the_set_has_no_proof():
    tail = certified_from(simulate(PLANT, first_order(), noise(60)))
    assert tail.is_verified
    outside = np.array(tail.theta)
    outside[len(outside) // 2, 0] += 50.0
    assert not replace(tail, theta=outside).is_verified
    assert not replace(tail, k0=None).is_verified
    larger = replace(tail.set, regressor_factor=tail.set.regressor_factor * 2)
    assert not replace(tail, set=larger).is_verified


def test_each_plant_of_a_schedule_has_a_proof_of_its_own():
    changes = [
        PlantChange(start=0, plant=PLANT), PlantChange(start=100, plant=OTHER, delay=1),
    ]  # fmt: skip
    slow = first_order(update=UD(1e3), theta_0=[0.0, -0.15])
    run = simulate(PlantSchedule(changes), slow, noise(300))
    tail = certified_from(run)
    (earlier,) = tail.earlier
    assert (earlier.start, earlier.stop, tail.start, tail.stop) == (0, 100, 100, 300)
    assert tail.k0 >= 100
    assert tail.is_verified
    assert earlier.is_verified
    assert earlier.set.members[0].plant == PLANT
    assert tail.set.members[0].plant.n == 2  # with the delay
    np.testing.assert_array_equal(earlier.theta[-1], run.theta[99])


def test_there_is_no_proof_while_the_plant_drifts():
    changes = [
        PlantChange(start=0, plant=PLANT, ramp=True), PlantChange(start=100, plant=OTHER),
    ]  # fmt: skip
    tail = certified_from(simulate(PlantSchedule(changes), first_order(), noise(300)))
    assert tail.is_verified
    assert tail.earlier[0].k0 is None
    assert "drifts" in tail.earlier[0].reason
    assert "Steps 0 to 99" in tail.report()


def test_steps_at_a_limit_of_u_are_left_out():
    w = noise(200, size=0.02)
    w[50] = 20.0
    run = simulate(PLANT, first_order(), w, saturation=Saturation(low=-0.5, high=0.5))
    limited = np.flatnonzero((run.u != run.u_applied).any(axis=1))
    assert limited.size
    tail = certified_from(run)
    assert tail.is_verified
    assert tail.k0 > limited[-1]


def test_an_unstable_end_is_said():
    run = simulate(
        standard_plant("1/(q - 1.2)"),
        first_order(theta_0=[0.0, 0.0], freeze=[(0, None)]),
        noise(30),
    )
    tail = certified_from(run)
    assert (tail.k0, tail.set) == (None, None)
    assert not tail.is_verified
    assert "pole at" in tail.reason
    assert "pole at" in tail.report()


def test_what_is_no_run_of_one_adaptive_controller_is_refused():
    with pytest.raises(InputError, match="stride"):
        certified_from(simulate(PLANT, first_order(), noise(50), stride=5))
    fixed = FixedController(Compensator([[[0.0]]], [[[0.0]], [[-0.3]]]))
    with pytest.raises(InputError, match="ControllerSettings"):
        certified_from(simulate(PLANT, fixed, noise(50)))
    with pytest.raises(InputError, match="Run"):
        certified_from(PLANT)


@given(st.integers(2, 16), st.sampled_from([-1.0, 1.0]), seeds)
def test_inside_is_decided_right_however_near_the_boundary(digits, side, seed):
    """Beside the boundary in rational arithmetic, by 1e-2 to 1e-16 of the radius."""
    region = certified_from(simulate(PLANT, first_order(), noise(60))).set
    rng = np.random.default_rng(seed)
    v = rng.standard_normal((20, len(region.center)))
    v *= (1 + side * 10.0**-digits) / np.linalg.norm(v, axis=1, keepdims=True)
    thetas = region.center + v @ region.factor.T
    moved = rational_matrix((exact(thetas) - exact(region.center)).T)
    coordinates = rational_matrix(exact(region.factor)).solve(moved)
    for j, theta in enumerate(thetas):
        square = sum(coordinates[i, j] ** 2 for i in range(coordinates.nrows()))
        assert _is_inside(region, theta[None]) == (square < 1)


def test_an_analysis_and_its_report_have_the_proof():
    run = simulate(PLANT, first_order(), noise(300))
    analysis = LoopAnalysis(run)
    assert analysis.certified.is_verified
    assert certified_from(run).k0 <= analysis.certified.k0  # which tries the last theta alone
    assert f"from step {analysis.certified.k0} on" in " ".join(analysis.report().split())
    record = analysis._sheet().record["certified_from"]
    assert record["k0"] == analysis.certified.k0 and len(record["segments"]) == 1


def test_a_report_proves_no_run_that_takes_seconds_and_says_so():
    many = MOST_COEFFICIENTS // 2 + 1
    settings = ControllerSettings(
        structure=iir(many), target=TargetModel([0, 1]), update=UD(R_theta=1e3)
    )
    analysis = LoopAnalysis(simulate(PLANT, settings, noise(100)))
    assert f"not evaluated: theta has {2 * many} coeff" in " ".join(analysis.report().split())
    assert "certified" not in vars(analysis)
    changes = [PlantChange(start=10 * i, plant=PLANT) for i in range(MOST_PLANTS + 1)]
    run = simulate(PlantSchedule(changes), first_order(), noise(100))
    assert f"each of the {MOST_PLANTS + 1} plants" in " ".join(LoopAnalysis(run).report().split())


def test_an_unstable_end_has_no_second_line_on_stability():
    run = simulate(standard_plant("1/(q - 1.5)"), first_order(freeze=[(0, None)]), noise(30))
    report = LoopAnalysis(run).report()
    assert "UNSTABLE" in report and "roof" not in report


@pytest.mark.parametrize("shift", [0, 1])
def test_a_log_with_its_plant_has_the_proof_of_the_run(shift):
    run = simulate(PLANT, first_order(theta_0=[0.0, 0.2]), noise(300))
    tail = certified_from(run)
    assert tail.k0 > 2  # behind the steps that fill the regressor of a log
    theta = np.vstack([run.theta, run.theta_final])[shift : shift + 300]
    log = {"theta": theta, "structure": iir(1)}
    check = check_controller(run.u, run.y, plant=PLANT, **log)
    assert check.replay.shift == shift
    assert check.certified.is_verified
    # Without theta_final the center is another theta, and so is the set.
    assert check.certified.k0 == pytest.approx(tail.k0, abs=10)
    assert f"from step {check.certified.k0} on" in " ".join(check.report().split())
    assert check_controller(run).certified == tail
    assert "plant" in check_controller(run.u, run.y, **log).certified


def test_a_log_without_its_thetas_or_with_another_u_has_no_proof():
    run = simulate(PLANT, first_order(), noise(300))
    log = {"plant": PLANT, "structure": iir(1)}
    last = check_controller(run.u, run.y, theta=run.theta_final, **log)
    assert "theta of every step" in last.certified
    other = check_controller(run.u + noise(300, 5), run.y, theta=run.theta, **log)
    assert "not the output" in other.certified
    limited = simulate(PLANT, first_order(), noise(300), saturation=Saturation(low=-0.3, high=0.3))
    check = check_controller(
        limited.u_applied, limited.y, theta=limited.theta, u_limits=(-0.3, 0.3), **log
    )
    assert check.replay.limited and f"limit in {check.replay.limited} steps" in check.certified


def test_a_saved_run_with_two_plants_has_a_proof_for_each():
    """The log alone would be of the last plant; the run knows both."""
    changes = [PlantChange(start=0, plant=PLANT), PlantChange(start=150, plant=OTHER)]
    run = simulate(PlantSchedule(changes), first_order(theta_0=[0.0, -0.15]), noise(300))
    check = check_controller(run)
    assert check.certified == certified_from(run) and check.certified.earlier
    assert "Steps 0 to 149: " in check.report()
