"""The picture of a region of two gains: what is shaded is stable."""

import numpy as np
import pytest
from matplotlib.path import Path

from compensator_theory import stability_region
from compensator_theory.errors import InputError
from rcac_numeric.plots import plot_stability_region

REGION = stability_region("s**3 + (a + 1)*s**2 + b*s + a**2 + 1/4", "a", "b")


def test_what_is_shaded_is_stable():
    figure = plot_stability_region(REGION, (-3, 3), (-1, 5))
    paths = [path for part in figure.axes[0].collections for path in part.get_paths()]
    places = np.random.default_rng(3).uniform((-3, -1), (3, 5), (300, 2))
    observed = 0
    for a, b in places:
        root = np.roots([1, a + 1, b, a * a + 0.25]).real.max()
        if abs(root) < 0.02:
            continue
        shaded = any(Path(path.vertices, path.codes).contains_point((a, b)) for path in paths)
        assert shaded == (root < 0)
        observed += shaded
    assert 50 < observed < 250


def test_ranges_and_empty_regions():
    empty = stability_region("s**2 - s + a + b", "a", "b")
    assert not plot_stability_region(empty, (0, 1), (0, 1)).axes[0].collections
    for wrong in ((1, 0), (0, float("nan")), 3, ("a", "b"), (0, float("inf"))):
        with pytest.raises(InputError):
            plot_stability_region(REGION, wrong, (0, 1))
    with pytest.raises(InputError):
        plot_stability_region("s", (0, 1), (0, 1))
