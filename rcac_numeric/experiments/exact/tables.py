"""The tables of an exact example's file: [exact] and the checks of its claims."""

from __future__ import annotations

from typing import Annotated, Any

import attrs

from rcac_numeric.experiments.exact.checks import STATEMENTS, ExactCheck
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Exact, Form, Integer

FORMS: dict[str, Form] = {
    "poles": Exact(), "regulator": Exact(), "observer": Exact(), "n_c": Integer(),
    "decimals": Integer(), "forms": Integer(), "numerator_degree": Integer(),
}  # fmt: skip
SYSTEM = Table(ExactSystem)


def _statements() -> Kinds[Any]:
    """Every statement with its arguments; the system itself is given."""
    tables = {}
    for name, function in STATEMENTS.items():
        exactly = (
            {} if function.__annotations__.get("equals") in ("int", "str") else {"equals": Exact()}
        )
        known = {key: form for key, form in FORMS.items() if key in function.__annotations__}
        has_equals = exactly if "equals" in function.__annotations__ else {}
        tables[name] = Table(function, given=["system"], forms={**known, **has_equals})
    return Kinds(tables)


STATEMENT_KINDS = _statements()


@attrs.frozen(eq=False)
class StatementTable:
    """A statement that is decided exactly."""

    statement: Annotated[Part[Any], STATEMENT_KINDS, "What is stated."]

    def of(self, system: ExactSystem) -> ExactCheck:
        """The check of a system."""
        return ExactCheck(self.statement.make.__name__, system, self.statement.arguments)


CHECK = Table(StatementTable)
