"""Disk margins: held against a dense grid, and against loops that the ends of the disk perturb."""

import numpy as np
import pytest
from hypothesis import assume, given, settings

from compensator_theory.errors import InputError
from rcac_numeric import (
    ClosedLoop,
    Compensator,
    Plant,
    multivariable_disk_margin,
    stability_margins,
)
from rcac_numeric.margins.peaks import hinf_norm
from tests.support.loops import random_loop, seeds


@settings(max_examples=80)
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
    reached = margins.loop.response([disk.S_omega])[0]
    assert not np.isfinite(reached) or np.isclose(abs(1 / (1 + reached)), disk.S_peak)
    assert abs(disk.radius_at - 1) < 1e-6


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
