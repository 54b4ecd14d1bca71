"""From the file of an exact example to an experiment that runs nothing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.exact.tables import CHECK, SYSTEM, exact_check_of
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.judging.claim import Claim
from rcac_numeric.experiments.judging.reading import OpenItems, claim_table, claims_of


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


CLAIM: Table[Any] = claim_table(CHECK, runs=False)
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
    >>> from rcac_numeric import load_example, verify
    >>> verification = verify(load_example("B.2"))
    >>> verification.results, [v.verdict for v in verification.verdicts]
    ({}, ['reproduced', 'reproduced'])
    """
    read = EXACT_FILE.read(table, Place(file)).arguments
    system: ExactSystem = read["exact"].build()
    text = {key: read.get(key, "") for key in ("title", "id", "source", "notes")}
    words = {name: _words(value) for name, value in table["exact"].items()}

    def made(part: Part[Any]) -> list[Claim]:
        return claims_of(part, (), OpenItems((), {}), lambda one, _: exact_check_of(one, system))

    return Experiment(
        id=text["id"] or Path(file).stem,
        title=text["title"],
        source=text["source"],
        notes=text["notes"].strip(),
        runs={},
        claims=tuple(claim for part in read["claims"] for claim in made(part)),
        description=words,
    )


def _words(value: object) -> str:
    """An entry of [exact] as a reader writes it: matrices with semicolons."""
    if isinstance(value, list):
        rows = [" ".join(map(str, row)) if isinstance(row, list) else str(row) for row in value]
        is_matrix = any(isinstance(row, list) for row in value)
        return f"[{'; '.join(rows) if is_matrix else ' '.join(rows)}]"
    return str(value)
