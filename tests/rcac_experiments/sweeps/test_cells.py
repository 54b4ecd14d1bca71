"""A cell that is made beside others is the one that its document alone describes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import CompensatorError
from rcac_experiments.files import _runs
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.sweeps import Axis, Metric, Study
from rcac_experiments.sweeps._cells import Cells
from rcac_numeric import TargetModel
from rcac_numeric.arrays._values import fingerprint

BASE = {
    "plant": {"problem": "standard", "G": "(q - 0.5)/(q*(q - 0.9))"},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 2, "R_theta": 1.0},
    "run": {"steps": 50},
}
# Values of each axis: some make no run, some stand where no number belongs, some are like others.
VALUES = {
    "controller.R_theta": [1e-3, 1, 1.0, 7.5, 0.0, -1.0, 1e-310, [[2.0]], "text", True],
    "controller.lambda": [1, 1.0, 0.95, 0.5, 0.0, 1.5, "0.9"],
    "controller.R_z": [1, 0.25, 0.0, {"z_squared": 0.1, "constant": 1.0}],
    "controller.R_u": [0, 0.0, 0.5, -1.0, {"z_squared": 0.1}],
    "controller.theta_0": [[0.1, 0.2, 0.3, 0.4], [0, 0, 0, 1], [0.1], 0.5],
    "controller.n_c": [1, 2, 3, 0],
    "controller.k_w": [2, 9, 0, 60, 3.0, "soon"],
    "controller.k_update": [2, 20, 1, 50, 4.0],
    "controller.update": ["ud", "covariance", "gradient", "sliding window"],
    "controller.process_noise": [0.1, 0.0],
    "controller.prior": [{"samples": 10, "y": 1.0}],
    "signals.w": [{"white_noise": 2.0}, 1.0, {"step": -1.0}, {"steps": 1}],
    "signals.w.white_noise": [0.5, 2, "loud"],
    "run.steps": [20, 51, 0, 1],
    "run.stride": [1, 3],
    "run.arithmetic": ["ud", "covariance", "reference"],
    "target.model": ["fir", "markov", "nothing"],
    "plant.G": ["1/(q - 0.9)", "(q - 0.5)/(q*(q - 0.9))", "2/(q - 1.1)", "x"],
}


@st.composite
def walks(draw):
    """A study, and cells of it in any order."""
    paths = draw(st.lists(st.sampled_from(sorted(VALUES)), min_size=1, max_size=4, unique=True))
    if "signals.w" in paths and "signals.w.white_noise" in paths:
        paths.remove("signals.w")
    chosen = {f"axis_{i}": path for i, path in enumerate(paths)}
    axes = [Axis(name, _apart(VALUES[path]), sets=path) for name, path in chosen.items()]
    where = {name: st.sampled_from(VALUES[path]) for name, path in chosen.items()}
    cells = draw(st.lists(st.fixed_dictionaries(where), min_size=2, max_size=8))
    return Study(BASE, axes, [Metric("rms")]), cells


def _apart(values):
    """Without those that an axis counts as another's equal."""
    return [v for i, v in enumerate(values) if not any(v == other for other in values[:i])]


def result_of(make):
    """What is made, or what is said of it."""
    try:
        return fingerprint(make())
    except CompensatorError as error:
        return type(error).__name__, str(error)


def specification(cells, coordinates):
    built = cells.cell(coordinates).specification
    names = (
        "plant",
        "settings",
        "signals",
        "steps",
        "stride",
        "target",
        "arithmetic",
        "saturation",
    )
    return [getattr(built, name) for name in names]


MAKES = PartialCall.of


def of_no_target(part, plant, **others):
    built = MAKES(part, plant, **others)
    assert not isinstance(built, TargetModel), "a target model is made again"
    return built


@given(walks())
def test_it_does_not_depend_on_those_before(walk):
    """In any order, with tables that are wrong among them: the same settings, the same errors."""
    study, coordinates = walk
    together = Cells(study)
    for place in coordinates:
        alone = result_of(lambda position=place: specification(Cells(study), position))
        assert result_of(lambda position=place: specification(together, position)) == alone, place


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("controller.R_theta", [0.5, 0.75, 1.0]),
        ("controller.lambda", [0.5, 0.75, 1.0]),
        ("controller.R_u", [0.5, 0.75, 1.0]),
        ("controller.k_w", [5, 6, 7]),
        ("controller.k_update", [5, 6, 7]),
    ],
)
def test_a_number_of_the_controller_reads_no_table(path, values, monkeypatch):
    cells = Cells(Study(BASE, [Axis("x", values, sets=path)], [Metric("rms")]))
    first = cells.cell({"x": values[0]}).specification
    monkeypatch.setattr(_runs, "read_controllers", None)  # a call would fail
    monkeypatch.setattr(PartialCall, "of", of_no_target)
    for value in values[1:]:
        built = cells.cell({"x": value}).specification
        assert built.settings.structure is first.settings.structure
        assert built.plant is first.plant and built.settings != first.settings


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("signals.w.white_noise", [1.0, 2.0, 3.0]),
        ("run.steps", [50, 60, 70]),
        ("controller.k_w", [5, 6, 7]),
    ],
)
def test_a_target_model_is_made_once(path, values, monkeypatch):
    cells = Cells(Study(BASE, [Axis("x", values, sets=path)], [Metric("rms")]))
    first = cells.cell({"x": values[0]}).specification
    monkeypatch.setattr(PartialCall, "of", of_no_target)
    for value in values[1:]:
        built = cells.cell({"x": value}).specification
        assert built.settings.target is first.settings.target
        assert built != first
    with pytest.raises(AssertionError, match="made again"):
        Cells(Study(BASE, [Axis("x", values, sets=path)], [Metric("rms")])).cell({"x": values[0]})
