"""Maps of poles and zeros: every point is seen, as a mark or as a value at the rim."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from rcac_numeric.plots._pole_maps import (
    NAMED,
    REACH,
    ROOM,
    PoleGroup,
    complex_word,
    draw_plane,
    largest_counts,
)

points = st.builds(
    lambda size, angle: size * np.exp(1j * angle), st.floats(1e-3, 1e6), st.floats(-3.14, 3.14)
)


def drawn(values, word="zero"):
    figure = Figure(figsize=(3, 3), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    draw_plane(axis, [PoleGroup("zeros", word, np.array(values, dtype=complex), "o", "black", 6.0)])
    figure.draw_without_rendering()
    words = [text for text in axis.texts if text.get_text()]
    arrows = [text for text in axis.texts if isinstance(text, Annotation) and text.arrow_patch]
    return axis, words, arrows


@pytest.mark.costly
@settings(max_examples=20)
@given(st.lists(points, max_size=8))
def test_every_point_is_a_mark_or_a_value(values):
    axis, words, arrows = drawn(values)
    near = [v for v in values if abs(v) <= REACH]
    marks = axis.lines[1].get_xdata() + 1j * axis.lines[1].get_ydata()
    assert np.array_equal(np.sort_complex(marks), np.sort_complex(np.array(near, dtype=complex)))
    assert len(words) == len(arrows) and bool(arrows) == (len(near) < len(values))
    text = "\n".join(word.get_text().replace("\n", " ") for word in words)
    for value in set(values) - set(near):
        rounded = complex(np.round(value, 6))
        assert complex_word(rounded) in text or "..." in text
    assert axis.get_xlim() == axis.get_ylim() == ((-ROOM, ROOM) if arrows else (-REACH, REACH))


@pytest.mark.parametrize("value", [-3.6, 50, 2j, -2j, 0.6 + 1.5j, -1.5 - 0.4j, 3 + 3j, 1.31])
def test_an_arrow_points_to_what_it_names_and_stays_inside(value):
    axis, (words,), (arrow,) = drawn([value])
    (x, y), (x_0, y_0) = arrow.xy, arrow.xyann
    assert np.isclose(np.angle(x + 1j * y), np.angle(value)) and x * y_0 == pytest.approx(y * x_0)
    assert max(abs(x), abs(y)) == pytest.approx(ROOM)
    box, frame = words.get_window_extent(), axis.get_window_extent()
    assert frame.x0 <= box.x0 and box.x1 <= frame.x1 and box.y0 >= frame.y0 - 9


def test_points_in_one_direction_share_an_arrow():
    _, (words,), _ = drawn([-2.0, -3.0, -3.0])
    assert words.get_text() == "zero\n-2\nzero\n-3 x2"
    _, (words,), _ = drawn([2.0 + k for k in range(NAMED + 2)])
    assert words.get_text().endswith("...")


def test_a_zero_of_several_channels_counts_as_in_the_richest():
    result = largest_counts([np.array([2.0, 2.0, 0.5]), np.array([2.0]), np.zeros(0)])
    assert result.tolist() == [2.0, 2.0, 0.5]
