"""A study is tried before it is run: what could not be made is refused with its axis named."""

from __future__ import annotations

import pickle
from collections.abc import Iterator

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.experiments.files.builder import build
from rcac_numeric.sweeps.study.canonical import canonical_json
from rcac_numeric.sweeps.study.cells import Cell, Cells
from rcac_numeric.sweeps.study.study import Coordinates, Study

# Values of one axis that are tried; of a longer one the first, the last, and some between.
TRIED = 40


def tried(study: Study) -> Cell:
    """The first cell, after every value of every axis was tried once, the others at their first.

    A combination of values that cannot be made shows only where it is run, as an outcome.
    """
    try:
        pickle.dumps(study)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(f"the study cannot be sent to another process: {error}.") from None
    cells = Cells(study)
    first = {axis.name: axis.values[0] for axis in study.axes}
    if isinstance(study.base, dict):
        # The whole file once: keys that no run reads, and what one run takes.
        build(study.document(first), study.file)
    for name, coordinates in _trials(study, first):
        try:
            cells.cell(coordinates).case(0)
        except CompensatorError as error:
            raise type(error)(
                f"the axis {name!r} at {coordinates[name]!r}: {error}" if name else str(error)
            ) from None
    cell = cells.cell(first)
    canonical_json(study.resolved)
    return cell


def _trials(study: Study, first: Coordinates) -> Iterator[tuple[str, Coordinates]]:
    yield "", first
    for axis in study.axes:
        step = max(1, -(-len(axis) // TRIED))
        for number in sorted({*range(0, len(axis), step), len(axis) - 1} - {0}):
            yield axis.name, {**first, axis.name: axis.values[number]}
