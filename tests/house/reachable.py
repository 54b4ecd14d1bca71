"""Every function that the text of a file can choose: `python -m tests.house.reachable` writes them.

What a file names is a key of one of these tables; it is looked up, and never imported.
"""

from collections.abc import Iterator
from pathlib import Path

from rcac_experiments.experiments._estimation_studies import MEASURES as OF_ESTIMATES
from rcac_experiments.experiments._exact_statements import STATEMENTS
from rcac_experiments.files._builder import FILE
from rcac_experiments.files._estimation import ESTIMATION_FILE
from rcac_experiments.files._exact import EXACT_FILE
from rcac_experiments.files._runs import TABLES
from rcac_experiments.format._signatures import Composed
from rcac_experiments.format._tables import ByKey, Kinds, Table
from rcac_experiments.format._values import Form
from rcac_experiments.judging._measures import MEASURES
from rcac_experiments.plots._requested import DRAWINGS, OF_STUDIES
from rcac_experiments.sweeps._files import STUDY
from rcac_numeric.arrays._records import _exact
from rcac_numeric.engine._runs import RECORDS

PAGE = Path(__file__).parents[2] / "docs" / "reachable-functions.txt"
ROOTS = {
    "experiment files": [FILE, *TABLES.values()],
    "exact files": [EXACT_FILE],
    "estimation files": [ESTIMATION_FILE],
    "studies": [STUDY],
}
MAPPINGS = {
    "measures of claims and figures": MEASURES,
    "measures of estimates": OF_ESTIMATES,
    "statements of exact files": STATEMENTS,
    "figures": {**DRAWINGS, **{f"{name} of estimates": f for name, f in OF_STUDIES.items()}},
    "classes of saved runs": {**RECORDS._classes, **_exact()},
}


def named(function) -> str:
    """Where a function is defined; one with arguments set is the one that it calls."""
    function = getattr(function, "func", function)
    return f"{function.__module__}.{function.__qualname__}"


def makers_of(make) -> list[object]:
    """The function itself; of one that is composed, every function that it calls."""
    if not isinstance(make, Composed):
        return [make]
    return [make.make, *(one for part in make.parts.values() for one in makers_of(part))]


def of_form(form, name: str, visited: set[int]) -> Iterator[tuple[str, object]]:
    """What a form and those inside it make of a text, each under the key that names it."""
    if isinstance(form, list | tuple):
        for one in form:
            yield from of_form(one, name, visited)
    elif isinstance(form, dict):
        for key, one in form.items():
            yield from of_form(one, f"{name}.{key}" if name else str(key), visited)
    elif isinstance(form, Form) and id(form) not in visited:
        visited.add(id(form))
        if isinstance(form, Table):
            yield from ((name, one) for one in makers_of(form.make))
            for key in form.keys:
                yield from of_form(key.form, f"{name}.{key.name}" if name else key.name, visited)
        elif isinstance(form, Kinds):
            for kind, one in form.kinds.items():
                for variant in one.variants:
                    yield from of_form(variant.table, f'{name} = "{kind}"', visited)
        elif isinstance(form, ByKey):
            yield name, form.number
            yield from of_form(form.kinds, name, visited)
        else:
            yield from of_form(list(vars(form).values()), name, visited)


def reachable() -> dict[str, list[tuple[str, str]]]:
    """The functions by the kind of file, each under what names it there."""
    result = {}
    for kind, roots in ROOTS.items():
        names: set[int] = set()
        makes = [pair for root in roots for pair in of_form(root, "", names)]
        result[kind] = sorted({(named(make), name or "the file") for name, make in makes})
    for kind, table in MAPPINGS.items():
        result[kind] = sorted((named(function), name) for name, function in table.items())
    return result


def written() -> str:
    """The list as the docs print it."""
    lines = []
    for kind, functions in reachable().items():
        width = max(len(function) for function, _ in functions)
        lines += [f"{kind} ({len(functions)})"]
        lines += [f"  {function:{width}}  {name}" for function, name in functions]
        lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(written(), encoding="utf-8")
