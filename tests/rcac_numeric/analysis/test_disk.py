"""Disk margins: held against a dense grid, and against loops that the ends of the disk perturb."""

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from scipy.optimize import minimize, minimize_scalar

from compensator_theory.errors import InputError
from rcac_numeric import (
    ClosedLoop,
    Compensator,
    Plant,
    lqg_controller,
    multivariable_disk_margin,
    stability_margins,
)
from rcac_numeric.analysis._disk import best_scaling
from rcac_numeric.analysis._peaks import hinf_norm
from tests.support.loops import random_loop, seeds


@pytest.mark.costly
@settings(max_examples=25)
@given(seeds)
def test_the_peaks_are_not_below_any_grid_and_are_reached(seed):
    margins = stability_margins(random_loop(seed), feedback=-1)
    assume(margins.is_stable)
    disk = margins.disk
    L = margins.loop.response(np.linspace(0, np.pi, 4001))
    S, T = 1 / (1 + L), L / (1 + L)
    with np.errstate(all="ignore"):
        for values, peak in ((S, disk.S_peak), (T, disk.T_peak), (S - T, 2 / disk.alpha)):
            assert np.nanmax(np.abs(values)) <= peak * (1 + 1e-9)
    reached = margins.loop.response([disk.S_frequency])[0]
    assert not np.isfinite(reached) or np.isclose(abs(1 / (1 + reached)), disk.S_peak)
    assert abs(disk.radius_at - 1) < 1e-6


@pytest.mark.costly
@settings(max_examples=40)
@given(seeds)
def test_gains_and_phases_in_the_disk_keep_the_loop_stable(seed):
    margins = stability_margins(random_loop(seed), feedback=-1)
    assume(margins.is_stable)
    disk = margins.disk
    for delta in 0.999 * disk.alpha * np.exp(1j * np.linspace(0, 2 * np.pi, 24, endpoint=False)):
        assert margins.loop.radius((1 + delta / 2) / (1 - delta / 2)) < 1
    low, high = disk.gain
    assert margins.gain_down.value <= low * (1 + 1e-9)
    assert high <= margins.gain_up.value * (1 + 1e-9)
    assert disk.phase <= margins.phase.value * (1 + 1e-9)


def two_channels(coupling):
    """q - 2 and q - 1/2, each with its own gain, coupled through the plant."""
    plant = Plant(A=[[2, coupling], [0, 0.5]], B=np.eye(2), D_1=np.ones((2, 1)), C=np.eye(2))
    Q = np.zeros((2, 2, 2))
    Q[0, 0, 0] = -2.0
    return ClosedLoop(plant, Compensator(np.zeros((1, 2, 2)), Q))


def test_without_coupling_the_disk_is_that_of_the_worse_channel():
    loop = two_channels(0.0)
    alone = [stability_margins(loop, channel=i).disk.alpha for i in (0, 1)]
    for at in ("u", "y"):
        assert np.isclose(multivariable_disk_margin(loop, at=at).alpha, min(alone))


@pytest.mark.costly
@pytest.mark.parametrize("at", ["u", "y"])
def test_simultaneous_factors_within_the_disk_keep_the_loop_stable(at):
    loop = two_channels(0.7)
    rng = np.random.default_rng(1)
    disk = multivariable_disk_margin(loop, at=at)
    assert disk.alpha <= min(
        stability_margins(loop, at=at, channel=i).disk.alpha for i in (0, 1)
    ) * (1 + 1e-9)
    low, high = disk.gain
    for _ in range(50):
        factors = rng.uniform(low, high, 2)
        B, C = loop.plant.B, loop.plant.C
        B, C = (B * factors, C) if at == "u" else (B, C * factors[:, None])
        moved = Plant(A=loop.plant.A, B=B, D_1=loop.plant.D_1, C=C)
        assert ClosedLoop(moved, loop.compensator).is_stable


def test_hinf_norm_of_a_lightly_damped_pole_that_a_grid_would_miss():
    r, angle = 1 - 1e-7, 1.2345678
    A = np.array([[2 * r * np.cos(angle), -r * r], [1.0, 0.0]])
    system = (A, np.array([[1.0], [0.0]]), np.array([[0.0, 1.0]]), np.zeros((1, 1)))
    peak, omega = hinf_norm(system)
    z = np.exp(1j * angle)
    assert np.isclose(peak, abs(1 / (z * z - 2 * r * np.cos(angle) * z + r * r)), rtol=1e-6)
    assert np.isclose(omega, angle, atol=1e-6)


def test_an_unstable_loop_has_no_disk_margin():
    loop = ClosedLoop(
        two_channels(0.0).plant, Compensator(np.zeros((1, 2, 2)), np.zeros((2, 2, 2)))
    )
    with pytest.raises(InputError, match="no margins"):
        multivariable_disk_margin(loop)


def random_channels(rng, channels):
    """A stable loop of LQG with as many u and y, and its difference equation."""
    n = int(rng.integers(2, 5))
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, channels))
    C, none = rng.standard_normal((channels, n)), np.zeros((channels, channels))
    plant = Plant(
        A=A, B=B, C=C, D_1=np.hstack([np.eye(n), np.zeros((n, channels))]),
        D_2=np.hstack([np.zeros((channels, n)), np.eye(channels)]),
        E_1=np.vstack([C, np.zeros((channels, n))]), E_2=np.vstack([none, np.eye(channels)]),
    )  # fmt: skip
    return lqg_controller(plant).loop


def in_units(loop, units):
    """The same loop with u_i in other units."""
    p, c = loop.plant, loop.compensator
    plant = Plant(A=p.A, B=p.B / units, D_1=p.D_1, C=p.C, D_2=p.D_2)
    return ClosedLoop(
        plant, Compensator(units[:, None] * c.past_u / units, units[:, None] * c.past_y)
    )


@pytest.mark.costly
@settings(max_examples=5)
@given(seeds)
def test_the_units_of_the_channels_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    loop = random_channels(rng, int(rng.integers(2, 4)))
    units = 10.0 ** rng.uniform(-3, 3, loop.plant.l_u)
    ours = multivariable_disk_margin(loop).alpha
    assert multivariable_disk_margin(in_units(loop, units)).alpha == pytest.approx(ours, rel=1e-6)


@pytest.mark.costly
@settings(max_examples=4)
@given(seeds)
def test_up_to_three_channels_the_margin_is_reached(seed):
    """mu = max of rho(M U) over diagonal unitary U, a bound from below that scalings know not of.

    So factors of size alpha that put a pole on the circle exist, and no smaller ones.
    """
    rng = np.random.default_rng(seed)
    loop = random_channels(rng, int(rng.integers(2, 4)))
    disk = multivariable_disk_margin(loop)
    M = S_minus_T(loop, disk.frequency)

    def radius(phases):
        turned = M * np.exp(1j * np.concatenate([[0.0], phases]))
        return -np.abs(np.linalg.eigvals(turned)).max()

    starts = rng.uniform(0, 2 * np.pi, (12, len(M) - 1))
    reached = -min(minimize(radius, s, method="Nelder-Mead", tol=1e-10).fun for s in starts)
    assert 2 / reached == pytest.approx(disk.alpha, rel=1e-4)
    for omega in rng.uniform(0, np.pi, 50):  # and at no other frequency is there more
        least, _ = best_scaling(S_minus_T(loop, omega))
        assert least <= 2 / disk.alpha * (1 + 1e-9)


def S_minus_T(loop, omega):
    p, (A, B, C, D), z = loop.plant, loop.compensator.state_space(), np.exp(1j * omega)
    G = p.C @ np.linalg.solve(z * np.eye(p.n) - p.A, p.B) + p.D_0
    L = -(C @ np.linalg.solve(z * np.eye(len(A)) - A, B) + D) @ G
    return 2 * np.linalg.inv(np.eye(len(L)) + L) - np.eye(len(L))


def spinning_satellite(units=(1.0, 1.0)):
    """Two channels at 10 rad/s (MathWorks' and python-control's example), by Tustin's rule.

    The rule maps the imaginary axis to the unit circle, so that the margin stays what it is.
    """
    P = control.ss([[0, 10.0], [-10, 0]], np.eye(2), [[1, 10.0], [-10, 1]], np.zeros((2, 2)))
    d = control.sample_system(P, 0.1, "bilinear")
    plant = Plant(A=d.A, B=d.B / units, C=d.C, D_0=d.D / units, D_1=np.ones((2, 1)))
    Q = np.zeros((2, 2, 2))
    Q[0] = -np.array(units)[:, None] * [[1, -2], [0, 1]]
    return ClosedLoop(plant, Compensator(np.zeros((1, 2, 2)), Q))


@pytest.mark.costly
@pytest.mark.parametrize("unit", [1.0, 10.0, 1000.0])
def test_the_spinning_satellite(unit):
    """By hand, at omega = 0: S - T = [[a, -b], [b', -1]], a = 19/21, b b' = 400/21."""
    b = np.sqrt(400 / 21)
    M = np.array([[19 / 21, -b], [b, -1.0]])  # the scaling that makes both couplings equal
    by_hand = (
        2
        / minimize_scalar(
            lambda x: np.linalg.norm(M * np.exp([[0, x], [-x, 0]]), 2),
            bounds=(-1, 1),
            method="bounded",
        ).fun
    )
    disk = multivariable_disk_margin(spinning_satellite((1.0, unit)))
    assert disk.alpha == pytest.approx(by_hand, rel=1e-6) and disk.frequency < 1e-3
    # python-control with slycot prints 0.3754, 3.3 dB and 21.26 degrees, at its first frequency
    assert disk.alpha == pytest.approx(0.3754, rel=5e-3) and disk.alpha >= 0.3754
    assert disk.phase == pytest.approx(21.26, abs=0.1)


@pytest.mark.slow
def test_at_least_as_sharp_as_python_control():
    pytest.importorskip("slycot")
    for seed in range(4):
        loop = random_channels(np.random.default_rng(seed), 2)
        p, c = loop.plant, loop.compensator
        L = -control.ss(*c.state_space(), True) * control.ss(p.A, p.B, p.C, p.D_0, True)
        theirs = control.disk_margins(L, np.linspace(1e-3, np.pi, 2000))[0]
        ours = multivariable_disk_margin(loop).alpha
        assert ours >= theirs * (1 - 1e-3) and ours <= theirs * 1.02


@pytest.mark.costly
def test_channels_that_act_one_way_only_are_as_good_as_alone():
    """A triangular loop: the couplings can be scaled away, and only the diagonal counts."""
    for coupling in (1.0, 1e3):
        loop = two_channels(coupling)
        alone = [stability_margins(loop, channel=i).disk.alpha for i in (0, 1)]
        assert multivariable_disk_margin(loop).alpha == pytest.approx(min(alone), rel=1e-4)


def test_the_ends_of_the_disk_are_inverse_gains():
    """K = 1/2 in front of 1/(q - 1/2), u = -K y: alpha by S - T on the circle, where q = 1, -1."""
    disk = stability_margins(control.tf([0.5], [1, -0.5], True), feedback=-1).disk
    grid = np.exp(1j * np.linspace(0, np.pi, 20001))
    L = 0.5 / (grid - 0.5)
    alpha = 2 / np.abs((1 - L) / (1 + L)).max()
    expected = ((2 - alpha) / (2 + alpha), (2 + alpha) / (2 - alpha))
    assert disk.alpha == pytest.approx(alpha) and disk.gain == pytest.approx(expected)
