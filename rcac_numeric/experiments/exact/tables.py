"""The tables of an exact example's file: [exact] and the checks of its claims."""

from __future__ import annotations

from typing import Any

from rcac_numeric.experiments.exact.checks import STATEMENTS, ExactCheck
from rcac_numeric.experiments.exact.system import ExactSystem
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Exact, Form, Integer, Schema


class Sign(Form):
    """+1 or -1."""

    words = "1 or -1"

    def read(self, value: object, place: Place) -> int:
        """As an int."""
        if isinstance(value, bool) or value not in (1, -1) or not isinstance(value, int):
            raise place.refuse(value, self.words)
        return value

    def schema(self) -> Schema:
        """One of the two."""
        return {"enum": [1, -1]}


def _exact_check(statement: Any) -> Any:
    """A statement that is decided exactly.

    Parameters
    ----------
    statement : str
        What is stated.
    """
    return statement


FORMS: dict[str, Form] = {
    "poles": Exact(), "regulator": Exact(), "observer": Exact(), "n_c": Integer(),
    "decimals": Integer(), "forms": Integer(), "numerator_degree": Integer(),
}  # fmt: skip
SYSTEM: Table[ExactSystem] = Table(
    ExactSystem,
    forms={**dict.fromkeys(("A", "B", "C", "G", "a", "b"), Exact()), "feedback": Sign()},
)


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


CHECK: Table[Any] = Table(_exact_check, forms={"statement": _statements()})


def exact_check_of(part: Part[Any], system: ExactSystem) -> ExactCheck:
    """The check that a table makes."""
    statement = part.arguments["statement"]
    return ExactCheck(statement.make.__name__, system, statement.arguments)
