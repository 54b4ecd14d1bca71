"""Pictures as narrow as the column of a journal: nothing overlaps, nothing is squeezed."""

from itertools import pairwise

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_numeric.plots import plot_runs
from tests.support.examples import EXAMPLE_4_8


@pytest.fixture(scope="module")
def burst():
    """Its control has a peak that is drawn over decades."""
    return EXAMPLE_4_8.run()


def overlaps(boxes):
    """How far each box reaches into the next one, in points."""
    boxes = sorted(boxes, key=lambda box: box.y0)
    return [a.y1 - b.y0 for a, b in pairwise(boxes)]


@pytest.mark.cases(3)
@pytest.mark.parametrize("width", [3.0, 3.5, 7.0, 9.0])
@pytest.mark.parametrize("labels", [None, ["a", "as published, with the larger weight"]])
def test_nothing_overlaps(burst, width, labels):
    figure = plot_runs([burst] * (len(labels) if labels else 1), labels, width=width)
    figure.set_dpi(72)
    figure.draw_without_rendering()
    whole = figure.bbox
    assert figure.get_figwidth() == width
    assert any(axis.get_yscale() == "symlog" for axis in figure.axes)
    for axis in figure.axes:
        words = [label for label in axis.get_yticklabels() if label.get_text()]
        low, high = sorted(axis.get_ylim())
        boxes = [w.get_window_extent() for w in words if low <= w.get_position()[1] <= high]
        assert len(boxes) >= 2 and max(overlaps(boxes)) <= 1.0
        assert axis.bbox.width >= 0.55 * whole.width
        legend = axis.get_legend()
        if legend is not None:
            box = legend.get_window_extent()
            assert box.x0 >= -1 and box.x1 <= whole.x1 + 1
            others = [other.bbox for other in figure.axes]
            assert not any(box.overlaps(other) for other in others)


@pytest.mark.costly
def test_ticks_fit_whatever_size_the_picture_is_given_later(burst):
    """Zero stays, decades give way."""
    figure = plot_runs([burst])
    axis = next(axis for axis in figure.axes if axis.get_yscale() == "symlog")
    counts = []
    for height in (12.0, 4.0, 2.5):
        figure.set_size_inches(3.5, height)
        figure.draw_without_rendering()
        ticks = axis.get_yticks()
        assert 0.0 in ticks
        counts.append(len(ticks))
    assert counts[0] > counts[-1] and np.all(np.diff(counts) <= 0)


@pytest.mark.parametrize("width", [2.0, 0, np.nan, "wide"])
def test_a_width_that_is_none(burst, width):
    with pytest.raises(InputError, match="width"):
        plot_runs([burst], width=width)
