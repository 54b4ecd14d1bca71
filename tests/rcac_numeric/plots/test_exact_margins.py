"""Bode's and Nyquist's pictures of exact margins against python-control's numbers."""

import control
import numpy as np
import pytest
from matplotlib.figure import Figure

from compensator_theory import stability_margins
from compensator_theory.errors import InputError
from rcac_numeric.plots._style import REQUESTED, SECOND

LOOPS = {
    "10/(s*(s + 1)*(s + 5))": control.tf([10], [1, 6, 5, 0]),
    "5*(s + 3)/(s*(s - 1))": control.tf([5, 15], [1, -1, 0]),
    "2/((s + 1)**3)": control.tf([2], [1, 3, 3, 1]),
    "1/(8*(q - exp(-1/10))*(q - exp(-1/5)))": control.tf(
        [1], 8 * np.poly(np.exp([-1 / 10, -1 / 5])), True
    ),
    "(q + 0.7)/(4*(q - 1)*(q - 0.5))": control.tf([1, 0.7], [4, -6, 2], True),
}


@pytest.mark.parametrize("text", LOOPS)
def test_curves_are_the_response(text):
    gain, phase = stability_margins(text, feedback=-1).plot("bode").axes
    omega, size = gain.lines[0].get_data()
    response = LOOPS[text](np.exp(1j * omega) if LOOPS[text].isdtime() else 1j * omega)
    np.testing.assert_allclose(size, np.abs(response), rtol=1e-9)
    turned = np.exp(1j * np.radians(phase.lines[0].get_ydata()))
    np.testing.assert_allclose(turned, response / np.abs(response), atol=1e-9)


@pytest.mark.parametrize("text", LOOPS)
def test_marked_margins_are_those_of_python_control(text):
    """Each line goes from the curve to gain 1 or to a phase of 180 degrees."""
    gain, phase = stability_margins(text, feedback=-1).plot("bode").axes
    factor, degrees, at_phase, at_gain = control.margin(LOOPS[text])
    ends = [
        line.get_data()
        for line in gain.lines
        if line.get_color() == SECOND and len(line.get_xdata()) == 2
    ]
    drawn = {(round(float(w[0]), 6), round(float(y[1] / y[0]), 6)) for w, y in ends}
    assert (round(at_phase, 6), round(factor, 6)) in drawn
    ((w, (low, high)),) = [
        line.get_data()
        for line in phase.lines
        if line.get_color() == REQUESTED and len(line.get_xdata()) == 2
    ]
    assert abs(w[0] - at_gain) < 1e-6
    # the curve is drawn through 6000 points, between which it is straight
    assert abs((high - low) - degrees) < 1e-6 * 180
    assert abs((low / 180) % 2 - 1) < 1e-5


@pytest.mark.costly
def test_views_widths_and_axes():
    margins = stability_margins("10/(s*(s + 1)*(s + 5))", feedback=-1)
    assert [len(margins.plot(view).axes) for view in ("all", "nyquist", "bode")] == [3, 1, 2]
    for view in ("all", "nyquist", "bode"):
        figure = margins.plot(view, width=3.5)
        figure.draw_without_rendering()
        assert figure.get_figwidth() == 3.5
    figure = Figure()
    axes = figure.subplots(2, 1)
    assert margins.plot("bode", ax=axes) is figure
    for wrong in (("nichols", {}), ("disk", {}), ("bode", {"ax": axes[0]}), ("all", {"width": 1})):
        with pytest.raises(InputError):
            margins.plot(wrong[0], **wrong[1])


@pytest.mark.costly
def test_an_unstable_loop_has_a_picture_without_margins():
    gain, phase = stability_margins("1/(s - 2)", feedback=-1).plot("bode").axes
    assert gain.get_title() == "no gain margin"
    assert "phase margin" not in phase.get_title()
