"""Which small errors in the functions of the central verbs the tests find, verb by verb.

Run with: python benchmarks/verb_mutants.py [VERB ...]  all that is judged: before a release
          python benchmarks/verb_mutants.py --share 1 [VERB ...]  every mutant of the verbs
          python benchmarks/verb_mutants.py --lot 12345           a few, drawn with the seed

central_verbs.toml lists the verbs, the functions that make their answers, and their tests. In a
mutant one comparison, sign, connective, condition or number of such a function is another, as in
mutants.py. The tests are run once, traced, so that each mutant meets the tests alone that reach its
line, the quickest first, in a fork whose functions are changed in place. A mutant is killed if one
of them fails or if they take five times their processor time. A mutant that lives and has no reason
in central_verbs.toml is an error (exit status 1): a missing test, or a change that changes no
answer, which is then listed. Tests that start a process of their own do not see the mutant.
"""

from __future__ import annotations

import ast
import gc
import math
import os
import random
import time
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from coverage import Coverage
from mutants import (
    ROOT,
    Judge,
    Verdicts,
    Worded,
    changed,
    judged,
    mutated,
    numbered,
    options_of,
    parts,
    places,
)

VERBS: dict[str, dict[str, Any]] = tomllib.loads(
    (Path(__file__).parent / "central_verbs.toml").read_text()
)
LOT_VERBS, LOT_MUTANTS, LOT_SECONDS = 3, 4, 60  # what the check draws, and when it draws no more


class Mutant(Worded):
    """A place in the body of a function of a module."""

    def __init__(self, path: Path, number: int, lines: set[int], function: Any, words: str) -> None:
        self.path, self.number, self.lines, self.function = path, number, lines, function
        self.words = words

    @property
    def keys(self) -> set[Any]:
        """What `Lines` says of tests that reach it."""
        return {(str(self.path), line) for line in self.lines}

    def put(self) -> None:
        """Change the function that stands in memory."""
        tree, _ = mutated(self.path.read_text(), self.number)
        name = self.function.__code__.co_qualname
        self.function.__code__ = next(
            code for code in codes(compile(tree, self.path, "exec")) if code.co_qualname == name
        )


def codes(code: CodeType) -> Iterator[CodeType]:
    """A code and all that stand in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes(constant)


def change_of(node: Any) -> str:
    """What stands at a place, and what is put there."""
    field, value = changed(node) or ("", None)
    before, original = ast.unparse(node).split("\n")[0], getattr(node, field)
    setattr(node, field, value)
    after = ast.unparse(node).split("\n")[0]
    setattr(node, field, original)
    return f"{before}  ->  {after}"


def mutants_of(path: Path, names: list[str]) -> Iterator[Mutant]:
    """The mutants of named functions of a module: of bodies, not of defaults."""
    text = path.read_text()
    tree = ast.parse(text)
    module = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    known = {
        (f.__code__.co_firstlineno, f.__name__): f
        for f in gc.get_objects()
        if isinstance(f, FunctionType) and f.__module__ == module.__name__
    }
    number = 0
    for part in parts(tree):
        inside = list(getattr(part, "body", []))
        heads = {id(n) for n in ast.walk(part)} - {id(n) for s in inside for n in ast.walk(s)}
        first = min([getattr(part, "lineno", 0), *(d.lineno for d in _decorators(part))])
        function = known.get((first, getattr(part, "name", "")))
        for node in places(part):
            if function is not None and id(node) not in heads and function.__qualname__ in names:
                lines = _lines(part, node)
                head = text.splitlines()[min(lines) - 1].strip()
                words = f"{function.__qualname__}: {change_of(node)}  in  {head}"
                yield Mutant(path, number, lines, function, words)
            number += 1


def _decorators(part: ast.AST) -> list[Any]:
    return getattr(part, "decorator_list", [])


def _lines(part: ast.AST, node: Any) -> set[int]:
    """The lines of the innermost statement around a node; of a compound one, those of its head."""
    around = [s for s in ast.walk(part) if isinstance(s, ast.stmt) and s is not part
              and any(n is node for n in ast.walk(s))]  # fmt: skip
    statement = min(around, key=lambda s: (s.end_lineno or 0) - s.lineno)
    body = getattr(statement, "body", None)
    last = body[0].lineno if isinstance(body, list) else (statement.end_lineno or 0) + 1
    return set(range(statement.lineno, max(last, statement.lineno + 1)))


class Lines:
    """The tracer of `Judge` for Python: which lines of some files a test runs."""

    def __init__(self, files: set[Path]) -> None:
        self.coverage = Coverage(include=[str(p) for p in files], data_file=None, config_file=False)

    def start(self) -> None:
        """Begin to trace."""
        self.coverage.start()

    def switch_context(self, test: str) -> None:
        """Say which test runs from now on."""
        self.coverage.switch_context(test)

    def result(self) -> dict[Any, set[str]]:
        """Return which tests reach which lines."""
        self.coverage.stop()
        reach: dict[Any, set[str]] = defaultdict(set)
        for file in self.coverage.get_data().measured_files():
            for line, tests in self.coverage.get_data().contexts_by_lineno(file).items():
                reach[file, line] |= set(tests)
        return dict(reach)


def mutants_of_verb(verb: str) -> list[Mutant]:
    """Return the mutants of the functions of a verb."""
    bodies = VERBS[verb]["bodies"].items()
    return [
        mutant
        for module, names in bodies
        for mutant in numbered(mutants_of(ROOT / f"{module}.py", names))
    ]


def main() -> int:
    """Judge the verbs, all of them or a lot."""
    options = options_of(str(__doc__).partition("\n")[0], "VERB")
    os.chdir(ROOT)
    os.environ["HYPOTHESIS_PROFILE"] = "ci"
    os.environ.pop("PYTEST_ADDOPTS", None)
    verbs, end, lot = options.names or list(VERBS), math.inf, None
    if options.lot is not None:
        lot = random.Random(options.lot), LOT_MUTANTS
        verbs = [verb for verb in verbs if VERBS[verb].get("share", 1) > 0]
        verbs, end = (
            lot[0].sample(verbs, min(LOT_VERBS, len(verbs))),
            time.monotonic() + LOT_SECONDS,
        )
    failures = 0
    for verb in verbs:
        if time.monotonic() > end:
            break
        entry = VERBS[verb]
        verdicts = Verdicts(verb, entry)
        mutants = verdicts.chosen(mutants_of_verb(verb), options.share, lot)
        judge = Judge(verdicts, mutants, Lines({m.path for m in mutants}), end)
        tests = [f"tests/{file}" for file in entry["tests"]]
        failures += judged(judge, [*tests, *(f"{module}.py" for module in entry["bodies"])])
    return int(failures > 0)


if __name__ == "__main__":
    raise SystemExit(main())
