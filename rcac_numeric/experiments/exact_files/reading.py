"""From the file of an exact example to an experiment that runs nothing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rcac_numeric.experiments.claims import VERDICTS, Claim
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.exact.tables import CHECK, SYSTEM, exact_check_of
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Choice


def _exact_claim(
    text: str,
    checks: list[Any],
    claimed: str = "",
    correction: str = "",
    reason: str = "",
    verdict: str = "",
) -> Any:
    """Something said of the example.

    Parameters
    ----------
    text, claimed : str
        What is said, and what is claimed.
    checks : tables
        What decides it: it holds where all of them do.
    correction : str
        What had to be read differently from the source.
    reason : str
        Where it does not hold: why, in a sentence.
    verdict : str
        The verdict of record.
    """
    return text


def _exact_file(
    exact: Any, claims: Any, title: str = "", id: str = "", source: str = "", notes: str = ""
) -> str:
    """An exact example.

    Parameters
    ----------
    exact : table
        What its statements are about.
    claims : tables
        What is said of it.
    title, id, source, notes : str
        As of any experiment.
    """
    return title


CLAIM: Table[Any] = Table(
    _exact_claim, forms={"checks": ListOf(CHECK, 1), "verdict": Choice(VERDICTS)}
)
EXACT_FILE: Table[str] = Table(
    _exact_file,
    forms={"exact": SYSTEM, "claims": ListOf(CLAIM, 1, needed="an array of tables, [[claims]]")},
)


def is_exact(table: Mapping[str, Any]) -> bool:
    """Whether the tables of a file are those of an exact example."""
    return "exact" in table


def exact_experiment(table: Mapping[str, Any], file: str) -> Experiment:
    """The experiment of an exact example: claims without runs.

    Raises
    ------
    InputError
        Where a key is unknown or missing, or a statement is not known.

    Examples
    --------
    >>> from rcac_numeric import verify
    >>> from rcac_numeric.dissertation import load_example
    >>> verification = verify(load_example("B.2"))
    >>> verification.results, [v.verdict for v in verification.verdicts]
    ({}, ['reproduced', 'reproduced with a correction'])
    """
    read = EXACT_FILE.read(table, Place(file)).arguments
    system: ExactSystem = read["exact"].build()
    text = {key: read.get(key, "") for key in ("title", "id", "source", "notes")}
    words = {name: _words(value) for name, value in table["exact"].items()}
    return Experiment(
        id=text["id"] or Path(file).stem,
        title=text["title"],
        source=text["source"],
        notes=text["notes"].strip(),
        runs={},
        claims=tuple(_claim(part, system) for part in read["claims"]),
        description=words,
    )


def _claim(part: Part[Any], system: ExactSystem) -> Claim:
    arguments = dict(part.arguments)
    checks = tuple(exact_check_of(check, system) for check in arguments.pop("checks"))
    recorded = arguments.pop("verdict", "")
    return Claim(checks=checks, recorded=recorded, **{"claimed": "", **arguments})


def _words(value: object) -> str:
    """An entry of [exact] as a reader writes it: matrices with semicolons."""
    if isinstance(value, list):
        rows = [" ".join(map(str, row)) if isinstance(row, list) else str(row) for row in value]
        is_matrix = any(isinstance(row, list) for row in value)
        return f"[{'; '.join(rows) if is_matrix else ' '.join(rows)}]"
    return str(value)
