"""From the file of an exact example to an experiment that runs nothing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import attrs

from rcac_numeric.experiments.claims import VERDICTS, Claim
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.exact.tables import CHECK, StatementTable
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Choice


@attrs.frozen(eq=False)
class ExactClaim:
    """Something said of the example."""

    text: Annotated[str, "What is said, and what is claimed."]
    checks: Annotated[
        list[StatementTable],
        ListOf(CHECK, 1),
        "What decides it: it holds where all of them do.",
    ]
    claimed: Annotated[str, "What is said, and what is claimed."] = ""
    correction: Annotated[str, "What had to be read differently from the source."] = ""
    reason: Annotated[str, "Where it does not hold: why, in a sentence."] = ""
    verdict: Annotated[str, Choice(VERDICTS), "The verdict of record."] = ""

    def of(self, system: ExactSystem) -> Claim:
        """The claim of a system."""
        checks = tuple(check.of(system) for check in self.checks)
        return Claim(
            self.text, self.claimed, checks, self.correction, self.verdict, reason=self.reason
        )


AS_ELSEWHERE = "As of any experiment."


@attrs.frozen(eq=False)
class ExactFile:
    """An exact example."""

    exact: Annotated[ExactSystem, "What its statements are about."]
    claims: Annotated[
        list[ExactClaim],
        ListOf(Table(ExactClaim), 1, needed="an array of tables, [[claims]]"),
        "What is said of it.",
    ]
    title: Annotated[str, AS_ELSEWHERE] = ""
    id: Annotated[str, AS_ELSEWHERE] = ""
    source: Annotated[str, AS_ELSEWHERE] = ""
    notes: Annotated[str, AS_ELSEWHERE] = ""


EXACT_FILE = Table(ExactFile)


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
    read: ExactFile = EXACT_FILE.read(table, Place(file))
    return Experiment(
        id=read.id or Path(file).stem,
        title=read.title,
        source=read.source,
        notes=read.notes.strip(),
        runs={},
        claims=tuple(claim.of(read.exact) for claim in read.claims),
        description={name: _words(value) for name, value in table["exact"].items()},
    )


def _words(value: object) -> str:
    """An entry of [exact] as a reader writes it: matrices with semicolons."""
    if isinstance(value, list):
        rows = [" ".join(map(str, row)) if isinstance(row, list) else str(row) for row in value]
        is_matrix = any(isinstance(row, list) for row in value)
        return f"[{'; '.join(rows) if is_matrix else ' '.join(rows)}]"
    return str(value)
