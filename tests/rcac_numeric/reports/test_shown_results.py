"""What notebooks show of results: numbers that are right, and systems that go out as they are."""

import importlib
import inspect
import re

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from docs.reference_pages import PACKAGES, public_names, public_path
from rcac_numeric import (
    ClosedLoop,
    Compensator,
    TargetModel,
    fir_target,
    intercalated_match,
    lqg_controller,
    plant_of,
    standard_plant,
)
from rcac_numeric.arrays._values import LINE, LINES
from rcac_numeric.arrays._wording import polynomial_latex
from rcac_numeric.reports._lqg import lqg_sheet
from tests.rcac_numeric.samples import SAMPLES

POINTS = np.exp(1j * np.array([0.3, 1.2, 2.7]))
SYSTEM = control.ss([[0.5, 1], [0, 1.2]], np.eye(2), [[1, 1]], [[0, 0]], 0.01)


def value_of(latex, q):
    """A polynomial in LaTeX, evaluated."""
    text = re.sub(r"\^\{(-?\d+)\}", r"**(\1)", latex).replace(r"\cdot", "*")
    return eval(re.sub(r"([\d)]) q", r"\1*q", text), {"q": q})


@given(st.lists(st.floats(-1e4, 1e4).map(lambda x: float(f"{x:.4g}")), min_size=1, max_size=6))
def test_a_polynomial_in_latex_has_its_values(coefficients):
    for q in (0.5, -1.25):
        expected = np.polyval(coefficients, q)
        size = np.polyval(np.abs(coefficients), abs(q))
        assert abs(value_of(polynomial_latex(coefficients), q) - expected) <= 1e-9 * size


def test_scalar_systems_are_fractions_and_others_sums():
    law = Compensator(past_u=[[[0.5]]], past_y=[[[0.0]], [[-2.0]]])
    assert law._repr_latex_() == r"$\displaystyle G_c = \frac{-2}{q - 0.5}$"
    target = TargetModel([0.0, 1.0, -2.0])
    assert target._repr_latex_() == r"$\displaystyle G_f = \frac{q - 2}{q^{2}}$"
    several = Compensator(np.zeros((1, 2, 2)), [np.zeros((2, 1)), [[1.0], [0.5]]])
    assert several._repr_latex_() == (
        r"$\displaystyle u(k) = \begin{bmatrix}1 \\ 0.5\end{bmatrix} y(k-1)$"
    )
    wide = TargetModel(np.array([[[0.0, 0.0]], [[1.0, 3.0]]]))
    assert r"\begin{bmatrix}1 & 3\end{bmatrix} u(k-1)" in wide._repr_latex_()


def test_a_plant_goes_out_with_its_sample_time():
    plant = plant_of(SYSTEM)
    out, exact = plant.to_control(), plant.problem.to_control()
    assert out.dt == exact.dt == 0.01
    for point in POINTS:
        np.testing.assert_allclose(out(point), np.tile(SYSTEM(point), (2, 2)), rtol=1e-12)
        np.testing.assert_allclose(out(point), exact(point), rtol=1e-12)
    assert standard_plant("1/(q - 0.5)").to_control().dt is True
    assert plant._repr_latex_().count("bmatrix") == 2 * 5  # A, B, D_1, C, E_1; the rest is zero


def test_a_loop_goes_out_with_its_sample_time():
    plant = plant_of(SYSTEM)
    loop = ClosedLoop(plant, Compensator(np.zeros((0, 2, 2)), [[[0.2], [-0.9]]]))
    out = loop.to_control()
    assert out.dt == 0.01
    for point, w_to_z in zip(POINTS, loop.frequency_response(np.angle(POINTS)), strict=True):
        np.testing.assert_allclose(out(point)[:1, :2], w_to_z, rtol=1e-9)


@pytest.mark.costly
@pytest.mark.parametrize("form", ["predictor", "filter"])
def test_lqg_shows_its_numbers_and_its_picture(form):
    design = lqg_controller(standard_plant("(q - 2)/(q**2 - 1/4)"), form=form)
    record = lqg_sheet(design).record
    assert record["cost"] == design.cost.value
    assert record["regulator_radius"] == pytest.approx(np.abs(design.regulator.poles).max())
    shown = design._repr_html_()
    assert f"{form} form" in shown and "<svg" in shown and f"{design.cost.value:.6g}" in shown


def test_a_match_draws_itself():
    plant = standard_plant("1/(q - 2)")
    loop = ClosedLoop(plant, Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]]))
    gain, phase = intercalated_match(loop, fir_target(plant)).plot().axes
    for axis in (gain, phase):
        expected, reached = (line.get_ydata() for line in axis.lines)
        np.testing.assert_allclose(reached, expected, atol=1e-9)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_public_class_shows_itself_by_its_address(package):
    shown = []
    for name in public_names(package):
        module, _, last = public_path(package, name).rpartition(".")
        public = getattr(importlib.import_module(module), last, None)
        if isinstance(public, type) and not inspect.isabstract(public):
            shown += [name] * (public.__repr__ is object.__repr__)
    assert shown == ["ProgressLine"] * (
        package == "rcac_experiments"
    )  # it is a line of the terminal


@pytest.mark.cases(60)
@pytest.mark.parametrize("sample", SAMPLES, ids=lambda kind: kind.__name__)
def test_a_result_prints_on_at_most_five_lines(sample):
    result = SAMPLES[sample](0)
    for text in (repr(result), str(result)):
        assert 1 <= len(text.splitlines()) <= LINES and len(text) <= LINES * LINE, text
