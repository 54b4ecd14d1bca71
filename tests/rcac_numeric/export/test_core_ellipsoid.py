"""CertifiedBounds in the stand-alone core: the controller's bits, and inside in float32 too."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import core_tables, ellipsoid_constants, scaled
from tests.support import core_builds
from tests.support.core_builds import BOUNDED, Core
from tests.support.core_cases import Loop
from tests.support.ellipsoids import ellipsoid, exact_square, rational
from tests.support.strategies import seeds

PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
needs_a_compiler = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)


def settings_of(seed, n_c, **more):
    bounds = ellipsoid(seed, 2 * n_c)
    return rn.ControllerSettings(
        structure=rn.iir(n_c), target=rn.TargetModel([0, 1.0, -0.3]), bounds=bounds,
        theta_0=bounds.center, **{"update": rn.UD(0.05, lambda_=0.99), **more},
    )  # fmt: skip


@needs_a_compiler
@pytest.mark.costly
@pytest.mark.parametrize("n_c", [1, 3, 4, 6, 10])
def test_theta_and_the_share_of_the_radius_are_those_of_the_controller(n_c, monkeypatch):
    """Up to and beyond the tiles of eight in which the kernel keeps U."""
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    settings = settings_of(n_c, n_c, update=rn.UD(0.05, process_noise=1e-3))
    core = Core(core_tables(settings, supervision=rn.Supervision()))
    controller, loop, bounded = rn.Controller(settings), Loop(PLANT, 0, 200, 3), 0
    for k in range(200):
        y, z, _ = loop.signals(k)
        status, u = core.step(y, z)
        assert u.tobytes() == controller.step(y, z).tobytes()
        assert core.theta.tobytes() == controller.theta.tobytes()
        assert core.radius == pytest.approx(controller.radius, rel=1e-12)
        bounded += bool(status & BOUNDED)
        loop.move(k, u)
    assert bounded == controller.bounded > 20


@needs_a_compiler
@pytest.mark.costly
@pytest.mark.parametrize("n_c", [2, 6])
def test_every_theta_in_float32_is_inside_without_rounding(n_c):
    settings = settings_of(n_c, n_c)
    core, loop = Core(scaled(core_tables(settings)), "float32"), Loop(PLANT, 0, 200, 5)
    largest = bounded = 0
    for k in range(200):
        y, z, _ = loop.signals(k)
        status, u = core.step(y, z)
        largest = max(largest, exact_square(settings.bounds, core.theta))
        bounded += bool(status & BOUNDED)
        loop.move(k, u.astype(float))
    assert 0.999 < float(largest) <= 1 and bounded > 20


@given(seeds, st.integers(1, 6), st.sampled_from([1.0, 30.0]))
def test_the_ellipsoid_of_float32_lies_in_the_exact_one(seed, size, spread):
    """Rounded center and inverse, to the limit of the core, at random points and on each axis."""
    bounds = ellipsoid(seed, size, spread=spread)
    center, packed, (limit, aim) = ellipsoid_constants(bounds, np.float32)
    R = np.zeros((size, size))
    R[np.tril_indices(size)] = packed
    rng = np.random.default_rng(seed)
    for v in (*np.eye(size), *-np.eye(size), *rng.standard_normal((9, size))):
        scaled_v = rational(limit * v / np.linalg.norm(v)).transpose()
        delta = rational(center).transpose() + rational(R).solve(scaled_v)
        w = rational(bounds.factor).solve(delta - rational(bounds.center).transpose())
        assert sum(x * x for x in w.entries()) <= 1
    assert 0.9 < aim < limit < 1


def test_what_float32_cannot_keep_is_refused():
    bounds = rn.CertifiedBounds(np.zeros(2), [[1e-3, 0.0], [1e2, 1e-3]])
    settings = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(1.0), bounds=bounds
    )
    config_header(core_tables(settings))
    with pytest.raises(InputError, match='Export with real = "float64"'):
        config_header(scaled(core_tables(settings)), "float32")
    edge = rn.ControllerSettings(  # float32(0.1) is above 0.1
        structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(1.0),
        bounds=rn.CertifiedBounds(np.zeros(2), 0.1 * np.eye(2)), theta_0=[0.1, 0.0],
    )  # fmt: skip
    config_header(core_tables(edge))
    with pytest.raises(InputError, match="theta_0, rounded to float32"):
        config_header(scaled(core_tables(edge)), "float32")
