"""Pictures of margins in float64: what is marked are margins, what is shaded is stable."""

from dataclasses import replace

import control
import numpy as np
import pytest
from matplotlib.path import Path

from compensator_theory.errors import InputError
from rcac_numeric import stability_margins
from rcac_numeric.plots._margins import loop_curve

L = control.tf([0.25, 0.175], [1, -1.5, 0.5], True)


@pytest.fixture(scope="module")
def margins():
    return stability_margins(L, feedback=-1)


def test_the_marked_margins_are_the_margins(margins):
    curve = loop_curve(margins)
    assert (margins.gain_up.frequency, margins.gain_up.value) in curve.gains
    assert curve.phase == (margins.phase.frequency, margins.phase.value)
    assert curve.disk == margins.disk.alpha


def test_what_is_shaded_is_stable_and_is_not_all(margins):
    """Gain and turn at random: inside the region the poles stay in the circle."""
    axis = margins.disk.plot().axes[0]
    (region,) = [path for part in axis.collections for path in part.get_paths()]
    rng = np.random.default_rng(5)
    gains, turns = np.exp(rng.uniform(-1, 1, 400)), rng.uniform(0, 60, 400)
    inside = np.array(
        [Path(region.vertices).contains_point(p) for p in zip(gains, turns, strict=True)]
    )
    D, N = np.array([1, -1.5, 0.5]), np.array([0, 0.25, 0.175])
    stable = np.array(
        [
            max(abs(np.roots(D + g * np.exp(-1j * np.radians(t)) * N))) < 1
            for g, t in zip(gains, turns, strict=True)
        ]
    )
    assert np.all(stable[inside]) and inside.sum() > 40
    assert (~stable).sum() > 40
    boundary = 1 / max(1 / margins.disk.gain[1], 1e-9)
    assert abs(region.vertices[:, 0].max() - boundary) < 1e-9


def test_views(margins):
    assert [len(margins.plot(v).axes) for v in ("all", "nyquist", "bode", "disk")] == [3, 1, 2, 1]
    with pytest.raises(InputError, match="view"):
        margins.plot("nichols")
    unstable = stability_margins(control.tf([9], [1, -1.5], True), feedback=-1)
    assert len(unstable.plot().axes) == 3
    with pytest.raises(InputError, match="disk"):
        unstable.plot("disk")


def test_an_infinite_disk_margin_has_no_region(margins):
    with pytest.raises(InputError, match="infinite"):
        replace(margins.disk, alpha=np.inf).plot()
