"""The tables of an exact example's file: [exact] and the checks of its claims."""

from __future__ import annotations

from typing import Annotated, Any

import attrs

from rcac_numeric.experiments.exact.checks import STATEMENTS, ExactCheck
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.tables import Kinds, Table

# Every statement with its arguments; the system itself is given.
STATEMENT_KINDS: Kinds[Any] = Kinds(
    {name: Table(function, given=["system"]) for name, function in STATEMENTS.items()}
)


@attrs.frozen(eq=False)
class StatementTable:
    """A statement that is decided exactly."""

    statement: Annotated[Part[Any], STATEMENT_KINDS, "What is stated."]

    def of(self, system: ExactSystem) -> ExactCheck:
        """The check of a system."""
        return ExactCheck(self.statement.make.__name__, system, self.statement.arguments)


CHECK = Table(StatementTable)
