"""Studies as files: an experiment file with a table [study]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import attrs
import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.files._claims import FORMS
from rcac_experiments.files._documents import named, read_file, require_plain
from rcac_experiments.files._schema import json_schema
from rcac_experiments.format._parts import Alias, PartialCall
from rcac_experiments.format._places import Errors, Location
from rcac_experiments.format._tables import Kinds, Raw, Table, require_table
from rcac_experiments.format._values import (
    Choice,
    Form,
    Integer,
    ListOf,
    Numbers,
    Schema,
    as_float,
)
from rcac_experiments.sweeps._axes import LARGEST_AXIS, Axis, RandomAxis, pair, too_many
from rcac_experiments.sweeps._measures import STUDY_MEASURES, Metric
from rcac_experiments.sweeps._study import SIGNALS, Study
from rcac_numeric.arrays._validation import integer

BETWEEN = "Drawn at random between these two, evenly or evenly in the logarithm; `draws` of them."
# What says something of an experiment and decides no number of it.
WORDS = ("title", "id", "source", "notes", "claims")


class _Values(Form):
    """The values of an axis: anything that an experiment file may hold."""

    words = "a list of values, not an empty one"

    def read(self, value: object, place: Location) -> list[Any]:
        """Read the values unchecked; they are checked at their place in the document."""
        if not isinstance(value, list) or not value:
            raise place.refuse(value, self.words)
        return [_floats(entry) for entry in value]

    def schema(self) -> Schema:
        """An array."""
        return {"type": "array", "minItems": 1}


Pair = Annotated[Any, Numbers(longest=3)]


@attrs.frozen(eq=False)
class AxisTable:
    """One axis."""

    sets: Annotated[
        str,
        'Where its value goes: a dotted path in this file, "controller.R_theta" for instance, or '
        '"plant.changes.0.delay" into the first of several.',
    ]
    values: Annotated[list[Any] | None, _Values(), "The values themselves."] = None
    range: Annotated[Pair, "`[first, last]` or `[first, last, step]`, the last one included."] = (
        None
    )
    grid: Annotated[Pair, "Evenly spaced from the first to the last, `points` of them."] = None
    decades: Annotated[Pair, "Powers of ten, their exponents evenly spaced, `points` of them."] = (
        None
    )
    points: Annotated[int | None, Integer(2), "How many."] = None
    uniform: Annotated[Pair, BETWEEN] = None
    log_uniform: Annotated[Pair, BETWEEN] = None
    normal: Annotated[
        Pair, "Drawn from a normal distribution of this mean and standard deviation."
    ] = None
    draws: Annotated[
        int | None, Integer(1), "How many; the first ones stay when there are more."
    ] = None

    def named(self, name: str) -> Axis | RandomAxis:
        """The axis of this name."""
        entries = {key: v for key, v in attrs.asdict(self, recurse=False).items() if v is not None}
        return axis_of(name, entries.pop("sets"), entries)


MEASURE_KINDS: Kinds[Any] = Kinds(
    {name: Table(f, supplied=["r"], forms=FORMS) for name, f in STUDY_MEASURES.items()}
)


@attrs.frozen(eq=False)
class MetricTable(Alias):
    """A metric of every run."""

    measure: Annotated[PartialCall[float], MEASURE_KINDS, "What is measured."]
    name: Annotated[str, "Of its column; the measure's where it is left out."] = ""

    def build(self) -> Metric:
        """The stored metrics."""
        return Metric(self.measure.make.__name__, self.name, self.measure.arguments)


@attrs.frozen(eq=False)
class StudyTable:
    """Many runs of this experiment."""

    axes: Annotated[
        dict[str, AxisTable],
        "The axes, by name; every combination of their values is a cell.",
    ] = attrs.field(factory=dict)
    keep: Annotated[
        list[Metric],
        ListOf(Table(MetricTable), needed="an array of tables"),
        "The metrics of every run, beside its outcome.",
    ] = attrs.field(factory=list)
    repetitions: Annotated[
        int,
        Integer(1),
        "Runs of every cell. They differ in their noise, and in w by `perturbation` of [run].",
    ] = 1
    seed: Annotated[int, "Of all that is random."] = 0
    common_noise: Annotated[bool, "Whether the n-th run has the same noise in all cells."] = False
    lanes: Annotated[bool, "Whether eligible runs go eight at a time."] = True
    keep_signals: Annotated[
        list[str],
        ListOf(Choice(SIGNALS)),
        'Which of "w", "u", "y", "z" and "theta" are stored of every run.',
    ] = attrs.field(factory=list)


STUDY = Table(StudyTable)


def load_study(path: str | Path) -> Study:
    """A study from its TOML file: an experiment file with a table [study].

    Raises
    ------
    InputError
        Where the file cannot be read, or something in [study] is not as it must be. What an axis
        sets is tried when the study is run, before anything else.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_experiments.sweeps import load_study
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "study.toml"
    >>> _ = file.write_text('''
    ... signals.w = { white_noise = 1 }
    ... target.model = "fir"
    ... controller = { n_c = 2, R_theta = 1 }
    ... run.steps = 200
    ... [plant]
    ... G = "1/(q - 0.9)"
    ... [study]
    ... repetitions = 10
    ... keep = [{ measure = "rms", start = 100 }]
    ... axes.R_theta = { sets = "controller.R_theta", decades = [-2, 2], points = 5 }
    ... ''')
    >>> load_study(file)
    Study(50 runs: R_theta 5 x 10 repetitions)
    """
    table, file = read_file(path)
    try:
        return _read(table, file)
    except CompensatorError as error:
        raise named(error, file) from None


def study_of(table: Raw, file: str) -> Study:
    """The study that tables describe as a file would; `file` is named in errors."""
    require_plain(dict(table), file)
    try:
        return _read(table, file)
    except CompensatorError as error:
        raise named(error, file) from None


def study_schema() -> dict[str, Any]:
    """The JSON Schema of experiment files and studies."""
    schema = json_schema()
    study = {"description": STUDY.summary, **STUDY.schema()}
    return {**schema, "properties": {**schema["properties"], "study": study}}


def _read(table: Raw, file: str) -> Study:
    if "study" not in table:
        raise InputError(
            "the table [study], which lists the axes, is missing. See `rcac sweep --help`."
        )
    place = Location(file, "study")
    read: StudyTable = STUDY.read(require_table(table["study"], place), place)
    errors, axes = Errors(), []
    for name, axis in read.axes.items():
        with errors:
            axes.append(axis.named(name))
    errors.raise_any()
    base = {key: _floats(value) for key, value in table.items() if key not in ("study", *WORDS)}
    title = table.get("title", "")
    return Study(
        base,
        axes,
        read.keep,
        repetitions=read.repetitions,
        seed=read.seed,
        common_noise=read.common_noise,
        lanes=read.lanes,
        keep_signals=read.keep_signals,
        file=file,
        title=title if isinstance(title, str) else "",
    )


def _floats(value: Any) -> Any:
    """The data of a study with numbers of float64 alone, as its fingerprint knows them."""
    if isinstance(value, Mapping):
        return {key: _floats(entry) for key, entry in value.items()}
    return [_floats(v) for v in value] if isinstance(value, list) else as_float(value)


# The values of an axis, as a file names them: a list, a range, a grid, decades, draws.

# What goes with each way to name values; one of the first is needed, and these beside it.
BESIDE: dict[str, str] = {
    "values": "", "range": "", "grid": "points", "decades": "points",
    "uniform": "draws", "log_uniform": "draws", "normal": "draws",
}  # fmt: skip


def axis_of(name: str, sets: str, entries: dict[str, Any]) -> Axis | RandomAxis:
    """The axis that a table of [study.axes] describes."""
    ways = [way for way in BESIDE if way in entries]
    if len(ways) != 1:
        problem = f"has {' and '.join(ways)}" if ways else "does not say which values it takes"
        raise InputError(f"the axis {name!r} {problem}; give one of {', '.join(BESIDE)}.")
    way = ways[0]
    beside = BESIDE[way]
    for extra in ("points", "draws"):
        if extra in entries and extra != beside:
            raise InputError(f"the axis {name!r} has {extra}, which {way} does not take.")
    if beside and beside not in entries:
        raise InputError(f"the axis {name!r} has {way} and needs {beside} too.")
    if beside == "draws":
        return RandomAxis(name, way, entries[way], entries["draws"], sets)
    return Axis(name, MAKERS[way](name, entries[way], entries.get("points")), sets)


def _listed(name: str, values: Any, points: int | None) -> list[Any]:
    return list(values)


def _range(name: str, ends: Any, points: int | None) -> list[int]:
    entries = [] if isinstance(ends, bool | int | float) else list(ends)
    if len(entries) not in (2, 3) or any(float(entry) != int(entry) for entry in entries):
        raise InputError(f"the axis {name!r}: range = {ends!r} must be [first, last] or "
                         "[first, last, step] in integers.")  # fmt: skip
    first, last, step = (*map(int, entries), 1)[:3]
    integer(step, f"the step of axis {name!r}", at_least=1)
    if last < first:
        raise InputError(f"the axis {name!r}: its range from {first} to {last} is empty.")
    if (count := (last - first) // step + 1) > LARGEST_AXIS:
        raise too_many(name, count)
    return list(range(first, last + 1, step))


def _grid(name: str, ends: Any, points: int | None) -> list[float]:
    low, high = pair(ends, f"the grid of axis {name!r}")
    count = _count(name, low, high, points)
    return [float(value) for value in np.linspace(low, high, count)]


def _decades(name: str, ends: Any, points: int | None) -> list[float]:
    low, high = pair(ends, f"the decades of axis {name!r}")
    count = _count(name, low, high, points)
    exponents = [float(value) for value in np.linspace(low, high, count)]
    # A whole power of ten is the float64 that is written 1e-40, in whatever order it is computed.
    return [float(f"1e{int(e)}") if e.is_integer() else 10.0**e for e in exponents]


def _count(name: str, low: float, high: float, points: int | None) -> int:
    count = integer(points, f"points of axis {name!r}", at_least=2)
    if count > LARGEST_AXIS:
        raise too_many(name, count)
    if not low < high:
        raise InputError(f"the axis {name!r} goes from {low} to {high}; give the least first.")
    return count


MAKERS: dict[str, Callable[[str, Any, int | None], list[Any]]] = {
    "values": _listed,
    "range": _range,
    "grid": _grid,
    "decades": _decades,
}
