"""The file of an exact example: its tables, and the experiment, which runs nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import attrs

from rcac_experiments.experiments._exact_statements import STATEMENTS, ExactCheck, ExactSystem
from rcac_experiments.experiments._experiment import Experiment
from rcac_experiments.files._documents import Heading
from rcac_experiments.format._places import Location
from rcac_experiments.format._tables import Kinds, Table
from rcac_experiments.format._values import ListOf
from rcac_experiments.judging._claim import Claim
from rcac_experiments.judging._reading import claim_table, claims_of

# Every statement with its arguments; the system itself is given.
STATEMENT_KINDS: Kinds[Any] = Kinds(
    {name: Table(function, supplied=["system"]) for name, function in STATEMENTS.items()}
)


CHECK: Table[ExactCheck] = Table(
    ExactCheck, supplied=("system", "arguments"), forms={"statement": STATEMENT_KINDS}
)
CLAIM: Table[Any] = claim_table(CHECK, runs=False)


@attrs.frozen(eq=False, kw_only=True)
class ExactFile(Heading):
    """An exact example."""

    exact: Annotated[ExactSystem, "What its statements are about."]
    claims: Annotated[
        list[Claim],
        ListOf(CLAIM, 1, needed="an array of tables, [[claims]]"),
        "The claims.",
    ]


EXACT_FILE = Table(ExactFile)


def exact_experiment(table: Mapping[str, Any], file: str) -> Experiment:
    """The experiment of an exact example: claims without runs."""
    read: ExactFile = EXACT_FILE.read(table, Location(file))
    claims: list[Claim] = []
    for one in read.claims:
        checks: Sequence[Any] = one.checks
        decided = [attrs.evolve(check, system=read.exact) for check in checks]
        claims += claims_of(attrs.evolve(one, checks=decided), (), ())
    return Experiment(
        **read.words(file),
        runs={},
        claims=claims,
        description={name: _words(value) for name, value in table["exact"].items()},
    )


def _words(value: object) -> str:
    """An entry of [exact] as a reader writes it: matrices with semicolons."""
    if isinstance(value, list):
        rows = [" ".join(map(str, row)) if isinstance(row, list) else str(row) for row in value]
        is_matrix = any(isinstance(row, list) for row in value)
        return f"[{'; '.join(rows) if is_matrix else ' '.join(rows)}]"
    return str(value)
