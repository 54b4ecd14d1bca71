"""Certified sets: what they prove, how tight they are, and what they refuse."""

import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from compensator_theory import decide_bounded_real
from compensator_theory.errors import CompensatorError, ImproperError, InputError, NoSolutionError
from rcac_numeric import (
    Decentralized,
    Gradient,
    PlantChange,
    PlantSchedule,
    Uncertainty,
    certified_set,
    feedforward,
    iir,
    pid,
    simulate,
)
from rcac_numeric.analysis._certified_set import entry_names
from rcac_numeric.analysis._regressor_system import regressor_system
from rcac_numeric.arrays._values import replaced
from tests.support.certified_loops import PLANT, first_order, loops
from tests.support.strategies import seeds


def changes(region, seed, count, radius=1.0):
    """Return theta on the boundary of the ellipsoid, or at that radius."""
    v = np.random.default_rng(seed).standard_normal((count, len(region.center)))
    v *= radius / np.linalg.norm(v, axis=1, keepdims=True)
    return region.center + v @ region.factor.T


@pytest.mark.costly
@settings(max_examples=15)
@given(loops(), st.sampled_from(["prior", "volume"]), seeds)
def test_every_theta_on_the_boundary_decreases_one_function(loop, shape, seed):
    """x'Px falls at every step for every theta, so that any motion is allowed."""
    plant, chosen = loop
    region = certified_set(plant, chosen, shape=shape)
    assert region.is_verified
    system = regressor_system(plant, chosen.structure)
    P = np.array([[float(e) for e in row] for row in region.members[0].P])
    root = np.linalg.cholesky(P / np.abs(P).max()).T
    for theta in changes(region, seed, 20):
        step = np.linalg.solve(root.T, (root @ system.loop_matrix(theta)).T)
        assert np.linalg.norm(step, 2) <= 1 + 1e-7


@pytest.mark.costly
@settings(max_examples=15)
@given(loops(), seeds)
def test_radii_intervals_and_bounds_agree(loop, seed):
    region = certified_set(*loop)
    inside, outside = changes(region, seed, 5, 0.999), changes(region, seed, 5, 1.001)
    assert region.contains(inside)
    assert not any(region.contains(theta) for theta in outside)
    np.testing.assert_allclose(region.radius_of(inside), 0.999, rtol=1e-6)
    assert region.radius_of(region.center) == 0
    ends = np.array(list(region.intervals().values()))
    assert len(ends) == len(region.center)
    assert (inside >= ends[:, 0]).all()
    assert (inside <= ends[:, 1]).all()
    # the interval of a coefficient is reached by the ellipsoid
    extreme = region.center + region.factor @ region.factor[0] / np.linalg.norm(region.factor[0])
    assert np.isclose(extreme[0], ends[0, 1])
    assert pickle.loads(pickle.dumps(region)) == region


def greedy_growth(region, scale, steps=1500):
    """Growth a step of the motion of theta that makes x'Px largest at the next step."""
    member = region.members[0]
    system = regressor_system(member.plant, region.structure, region.fixed)
    P = np.array([[float(e) for e in row] for row in member.P])
    A, B, K = system.loop_matrix(region.center), system.inputs, scale * region.regressor_factor
    assert region.input_scale.size == 1
    x, growth = np.random.default_rng(1).standard_normal(len(A)), 0.0
    for k in range(steps):
        size = np.linalg.norm(K.T @ (system.outputs @ x))
        push = float((B.T @ P @ A @ x).item())
        x = A @ x + B[:, 0] * size * (1 if push >= 0 else -1)
        length = np.sqrt(x @ P @ x)  # it falls at every step within the set
        growth += np.log(length) if k >= steps // 2 else 0.0
        x /= length
    return np.exp(growth / (steps - steps // 2))


@pytest.mark.parametrize("theta_0", [[0.2, -0.3], [0.5, -0.1]])
def test_a_motion_beyond_the_radius_diverges_and_within_it_does_not(theta_0):
    region = certified_set(PLANT, first_order(theta_0=theta_0))
    assert greedy_growth(region, 0.999) < 1 < greedy_growth(region, 1.1)


@pytest.mark.costly
@settings(max_examples=8)
@given(st.floats(-0.4, 0.6), st.floats(-0.6, -0.1), st.sampled_from([1.0, 0.97]))
def test_the_exact_norm_of_the_theory_agrees(P_1, Q_1, rate):
    """K'T(rate z) of norm below 1 is decided by Sturm sequences, without P."""
    plant, chosen = PLANT, first_order(theta_0=[round(P_1, 3), round(Q_1, 3)])
    try:
        region = certified_set(plant, chosen, rate=rate)
    except NoSolutionError:
        assume(False)
    z = sympy.Symbol("z")
    # T = [1/z; 1/(z (z - a))] S z, S = the sensitivity: read off u = P_1 u + Q_1 y + u~
    a, p, q, r = (sympy.Rational(float(v)) for v in (plant.A.item(), *chosen.theta_0, rate))
    loop = (r * z - a) * (r * z - p) - q
    T = sympy.Matrix([(r * z - a) / loop, 1 / loop])
    K = sympy.Matrix([[sympy.Rational(e) for e in row] for row in region.regressor_factor.tolist()])
    assert plant.B.item() * plant.C.item() == 1
    assert decide_bounded_real((K.T * T).applyfunc(sympy.cancel).tolist(), "z").holds
    if region.peaks["nominal"] > 0.9998:  # the caps do not bound the set
        beyond = K.T * T * sympy.Rational(1001, 1000)
        assert not decide_bounded_real(beyond.applyfunc(sympy.cancel).tolist(), "z").holds


@pytest.mark.costly
@settings(max_examples=20)
@given(loops(), seeds)
def test_a_falsified_certificate_is_refused(loop, seed):
    region = certified_set(*loop)
    rng = np.random.default_rng(seed)
    member = region.members[0]
    P = [list(row) for row in member.P]
    n = len(P)
    i = int(rng.integers(n))
    negative = [list(row) for row in P]
    negative[i][i] = -negative[i][i]
    skew = [list(row) for row in P]
    skew[i][(i + 1) % n] += Fraction(1, 10**30) * (1 if n > 1 else 0)
    for rows in (negative, skew) if n > 1 else (negative,):
        forged = replace(member, P=tuple(map(tuple, rows)))
        assert not replace(region, members=(forged,)).is_verified
    # 1.001 of the radius is beyond the norm: the caps do not hold it where the peak is at 1
    if region.peaks["nominal"] > 0.9998:
        assert not replace(region, regressor_factor=region.regressor_factor * 1.001).is_verified
    upper = np.array(region.regressor_factor)
    upper[0, -1] += 1.0
    if len(upper) > 1:
        assert not replace(region, regressor_factor=upper).is_verified
    assert not replace(region, members=()).is_verified
    assert not replace(region, rate=0.5).is_verified or region.decay([0.5])[0.5] >= 1


def test_another_plant_or_another_center_has_no_proof():
    region = certified_set(PLANT, first_order())
    member = region.members[0]
    for change in ({"B": PLANT.B * 1.05}, {"A": PLANT.A + 0.05}, {"C": PLANT.C * 1.05}):
        other = replace(member, plant=replaced(PLANT, exact=None, **change))
        assert not replace(region, members=(other,)).is_verified
    assert not replace(region, center=region.center - np.array([0, 0.05])).is_verified
    assert not replace(region, center=region.center[:1]).is_verified
    assert not replace(region, center=region.center * np.nan).is_verified
    for rows in (member.P[:1], tuple(row[:1] for row in member.P), ()):
        assert not replace(region, members=(replace(member, P=rows),)).is_verified
    smaller = replace(region, regressor_factor=region.regressor_factor * 0.9)
    assert smaller.is_verified  # a P of a larger set proves a smaller one


def test_a_family_has_one_ellipsoid_and_a_certificate_for_each_plant():
    others = {"gain x 1.25": "1.25/(q - 0.9)", "gain x 0.8": "0.8/(q - 0.9)"}
    alone, region = (
        certified_set(PLANT, first_order(), shape="volume", uncertainty=u) for u in (None, others)
    )
    assert [member.name for member in region.members] == ["nominal", *others]
    assert region.is_verified
    assert max(region.peaks.values()) <= 1
    ratio = np.linalg.det(region.factor) / np.linalg.det(alone.factor)
    assert ratio < 1
    listed = certified_set(PLANT, first_order(), shape="volume", uncertainty=list(others.values()))
    assert [m.name for m in listed.members] == ["nominal", "plant 2", "plant 3"]
    np.testing.assert_array_equal(listed.factor, region.factor)


def test_a_decay_rate_is_proved_and_shrinks_the_set():
    region = certified_set(PLANT, first_order())
    slow = certified_set(PLANT, first_order(), rate=0.9)
    assert slow.is_verified
    assert slow.rate == 0.9
    shares = list(region.decay([1.0, 0.95, 0.9, 0.8, 0.1]).values())
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] == 0
    np.testing.assert_allclose(shares[0], 1 / max(region.peaks.values()))


def test_changes_along_a_dependent_direction_move_no_pole():
    """u(k) = 0.2 u(k-1) - 0.3 y(k-1) with two lags has a direction that T does not see."""
    chosen = first_order(structure=iir(2), theta_0=[0.2, 0.0, -0.3, 0.0])
    region = certified_set(PLANT, chosen)
    (direction,) = region.dependent
    system = regressor_system(PLANT, chosen.structure)
    before = np.poly(system.loop_matrix(region.center))
    after = np.poly(system.loop_matrix(region.center + 100 * direction))
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_taps_of_the_command_are_dependent_directions():
    chosen = first_order(structure=feedforward(1), theta_0=[0.2, -0.3, 1.0])
    plant = replaced(
        PLANT, D_1=[[1.0, 0.0]], D_2=None, E_0=None, blocks={"d": 1, "r": 1}, exact=None
    )
    region = certified_set(plant, chosen)
    np.testing.assert_allclose(np.abs(region.dependent), [[0, 0, 1]], atol=1e-12)
    assert list(region.intervals()) == ["P_1", "Q_1", "R_1"]


def test_names_of_matrices_of_coefficients_have_row_and_column():
    assert entry_names(iir(1, l_u=2, l_y=2))[4:] == ("Q_1[1,1]", "Q_1[2,1]", "Q_1[1,2]", "Q_1[2,2]")
    assert entry_names(iir(1, l_u=2)) == ("P_1[1,1]", "P_1[2,1]", "P_1[1,2]", "P_1[2,2]", "Q_1[1]",
                                          "Q_1[2]")  # fmt: skip
    assert entry_names(pid("PI")) == ("K_P", "K_I")


def test_what_is_not_covered_stands_before_the_proof():
    region = certified_set(PLANT, first_order(structure=pid("PI", integral_limit=2.0), k_w=2,
                                              theta_0=[-0.2, -0.05]))  # fmt: skip
    lines = region.report().splitlines()
    first = next(i for i, line in enumerate(lines) if "Not covered" in line)
    assert first < next(i for i, line in enumerate(lines) if "Proved" in line)
    assert any("limits of integrators" in words for words in region.uncovered)
    assert any("k_w" in words for words in region.uncovered)
    forged = replace(region, regressor_factor=region.regressor_factor * 2)
    assert "NOT proved" in forged.report()


def test_a_theta_0_that_loses_a_plant_is_named():
    with pytest.raises(NoSolutionError, match="gain x 9"):
        certified_set(PLANT, first_order(), uncertainty={"gain x 9": "9/(q - 0.9)"})
    with pytest.raises(NoSolutionError, match="decay rate"):
        certified_set(PLANT, first_order(), rate=0.3)


def test_a_hidden_mode_outside_the_circle_is_no_proof():
    """T does not see it, its norm is as before; the loop is unstable."""
    hidden = replaced(
        PLANT, A=np.diag([0.9, 1.01]), B=[[1.0], [0.0]], D_1=[[1.0], [0.0]], C=[[1.0, 1.0]],
        E_1=[[1.0, 1.0]], exact=None,
    )  # fmt: skip
    with pytest.raises(NoSolutionError, match="nominal"):
        certified_set(hidden, first_order())


WRONG = {
    "continuous": ("1/(s + 1)", {}, InputError, "continuous"),
    "rate": (PLANT, {"rate": 1.5}, InputError, "rate"),
    "shape": (PLANT, {"shape": "ball"}, InputError, "shape"),
    "an interval": (PLANT, {"uncertainty": Uncertainty()}, InputError, "list of plants"),
    "two of a name": (PLANT, {"uncertainty": {"nominal": "2/(q - 0.9)"}}, InputError, "nominal"),
    "a changing plant": (
        PlantSchedule([PlantChange(start=0, plant=PLANT), PlantChange(start=9, plant=PLANT)]),
        {}, InputError, "changes with time",
    ),
    "D_0": (replaced(PLANT, D_0=[[1.0]], exact=None), {}, ImproperError, "D_0"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_use_is_refused_by_name(name):
    plant, options, error, words = WRONG[name]
    with pytest.raises(error, match=words):
        certified_set(plant, first_order(), **options)


def test_controllers_without_one_metric_are_refused():
    with pytest.raises(InputError, match="volume"):
        certified_set(PLANT, first_order(update=Gradient(0.1)))
    assert certified_set(PLANT, first_order(update=Gradient(0.1)), shape="volume").is_verified
    with pytest.raises(InputError, match="ControllerSettings"):
        certified_set(PLANT, Decentralized([first_order(), first_order()]))


def test_rcac_kept_to_its_bounds_is_settings():
    region = certified_set(PLANT, first_order())
    bounded = first_order(bounds=region.bounds)
    assert bounded.bounds.contains(region.center)
    try:
        run = simulate(PLANT, bounded, np.ones((50, 1)))
    except CompensatorError:  # where the engine does not project yet
        return
    assert region.contains(run.theta)
