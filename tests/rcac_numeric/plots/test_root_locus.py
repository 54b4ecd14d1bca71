"""The picture of a root locus: what is drawn are roots, what is marked is where the text says."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from compensator_theory import root_locus
from compensator_theory.errors import InputError
from rcac_numeric.plots._style import REQUESTED

PLANTS = (
    "1/(s*(s + 4)*(s**2 + 4*s + 20))",
    "(s + 2)/(s**2 + 1)",
    "(s - 1)/((s + 1)*(s + 3)**2)",
    "(q + 0.7)/((q - 1)*(q - 0.5))",
    "(q - 0.2)/(q**3 - 1.2*q**2 + 0.8*q)",
)


def coefficients(poly):
    return np.array([float(c) for c in poly.all_coeffs()])


def branches(axis):
    """The drawn lines that carry no name and are more than two points."""
    return [
        line.get_xdata() + 1j * line.get_ydata()
        for line in axis.lines
        if line.get_label().startswith("_") and len(line.get_xdata()) > 50
    ]


@pytest.mark.parametrize("plant", [*PLANTS, "1/(s**2 + 1)"])
def test_every_point_of_a_branch_is_a_root_for_a_positive_gain(plant):
    """k = -D/N at it is real and positive; rounding moves k by what its roots' condition is."""
    locus = root_locus(plant, feedback=-1)
    N, D = coefficients(locus.numerator), coefficients(locus.denominator)
    drawn = branches(locus.plot().axes[0])
    lines = [line for line in drawn if np.ptp(line.real) + np.ptp(line.imag) > 0]
    assert len(lines) >= locus.denominator.degree()
    checked = 0
    for line in lines[: locus.denominator.degree()]:
        with np.errstate(all="ignore"):
            k = -np.polyval(D, line) / np.polyval(N, line)
            slope = np.polyval(np.polyder(D), line) + k * np.polyval(np.polyder(N), line)
            # roots are those of a matrix as large as its largest coefficient, to some eps of it
            size = np.polyval(np.abs(D), np.abs(line)) + np.abs(k) * np.polyval(
                np.abs(N), np.abs(line)
            )
            moved = 1e3 * np.finfo(float).eps * size / np.abs(np.polyval(N, line))
        plain = np.isfinite(k) & (np.abs(slope) > 1e-6 * size)
        assert np.all(np.abs(k.imag[plain]) <= 1e-9 * np.abs(k[plain]) + moved[plain])
        assert np.all(k.real[plain] >= -moved[plain])
        checked += plain.sum()
    assert checked > 500


@pytest.mark.parametrize("plant", PLANTS)
def test_marked_crossings_lie_on_the_boundary_and_on_branches(plant):
    locus = root_locus(plant, feedback=-1)
    axis = locus.plot().axes[0]
    drawn = np.concatenate(branches(axis))
    marked = [
        x + 1j * y
        for line in axis.lines
        if line.get_marker() == "s" and line.get_markeredgecolor() == REQUESTED
        for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)
    ]
    positive = [
        c for c in locus.crossings if float(c.gain_enclosure) > 0 and c.frequency is not None
    ]
    assert bool(marked) == bool(positive)
    for place in marked:
        on = abs(place) - 1 if locus.time == "discrete" else place.real
        assert abs(on) < 1e-12
        assert np.abs(drawn - place).min() < 1e-6 * (1 + abs(place))


def test_gains_are_written():
    axis = root_locus(PLANTS[0], feedback=-1).plot().axes[0]
    assert [note.get_text() for note in axis.texts] == ["k = 100", "k = 64", "k = 260"]


def test_it_composes_and_fits_a_column():
    locus = root_locus(PLANTS[0], feedback=-1)
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert locus.plot(ax=right) is figure
    assert len(right.lines) > 4 and not left.lines
    assert locus.plot(width=3.5).get_figwidth() == 3.5
    for wrong in ({"width": 2}, {"width": "wide"}, {"width": float("nan")}, {"ax": [left, right]}):
        with pytest.raises(InputError):
            locus.plot(**wrong)
