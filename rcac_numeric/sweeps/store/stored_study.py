"""The study of a store as an object again, so that its runs can be run once more."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.sweeps.store.store import StudyRow
from rcac_numeric.sweeps.study.axes import Axis
from rcac_numeric.sweeps.study.canonical import function_named, plain
from rcac_numeric.sweeps.study.measures import Kept
from rcac_numeric.sweeps.study.study import Study


def study_in(row: StudyRow) -> Study:
    """The study; its functions are imported by their names.

    Raises
    ------
    InputError
        Where a function is not to be found, or is not what it was.
    """
    resolved = row.resolved
    return Study(
        _restored(resolved["base"]),
        [Axis(axis["name"], axis["values"], axis["sets"]) for axis in resolved["axes"]],
        [
            Kept(_restored(kept["measure"]), kept["name"], kept["arguments"])
            for kept in resolved["keep"]
        ],
        repetitions=resolved["repetitions"],
        seed=resolved["seed"],
        common_noise=resolved["common_noise"],
        lanes=resolved["lanes"],
        keep_signals=resolved["keep_signals"],
        file=row.file,
        title=row.title,
    )


def _restored(value: Any) -> Any:
    if not (isinstance(value, dict) and value.keys() == {"function", "source"}):
        return value
    function = function_named(value["function"])
    if plain(function) != value:
        raise InputError(
            f"the function {value['function']} was changed after the study had been run with it."
        )
    return function
