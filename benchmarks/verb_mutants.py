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

import argparse
import ast
import ctypes
import gc
import math
import os
import pickle
import random
import signal
import sys
import time
import tomllib
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import pytest
from coverage import Coverage
from mutants import ROOT, changed, mutated, parts, places

VERBS: dict[str, dict[str, Any]] = tomllib.loads(
    (Path(__file__).parent / "central_verbs.toml").read_text()
)
LONGEST = 300  # seconds that a mutant's tests may take, waiting included
PR_SET_PDEATHSIG = 1
LOT_VERBS, LOT_MUTANTS, LOT_SECONDS = 3, 4, 60  # what the check draws, and when it draws no more
OPTIONS = ["-q", "-p", "no:cacheprovider", "-n", "0",
           "--randomly-seed=0", "--randomly-dont-reorganize", "--hypothesis-seed=0"]  # fmt: skip


class Mutant:
    """A place in the body of a function of a module."""

    def __init__(self, path: Path, number: int, lines: set[int], function: Any) -> None:
        self.path, self.number, self.lines, self.function = path, number, lines, function
        self.words = ""

    def put(self) -> None:
        """Change the function that stands in memory."""
        tree, _ = mutated(self.path.read_text(), self.number)
        name = self.function.__code__.co_qualname
        self.function.__code__ = next(
            code for code in codes(compile(tree, self.path, "exec")) if code.co_qualname == name
        )

    @property
    def position(self) -> float:
        """Return a number in [0, 1) from the words, which another change of the module keeps."""
        return int(sha256(self.words.encode()).hexdigest()[:8], 16) / 2**32


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
    times: Counter[str] = Counter()
    for part in parts(tree):
        inside = list(getattr(part, "body", []))
        heads = {id(n) for n in ast.walk(part)} - {id(n) for s in inside for n in ast.walk(s)}
        first = min([getattr(part, "lineno", 0), *(d.lineno for d in _decorators(part))])
        function = known.get((first, getattr(part, "name", "")))
        for node in places(part):
            if function is not None and id(node) not in heads and function.__qualname__ in names:
                lines = _lines(part, node)
                mutant = Mutant(path, number, lines, function)
                head = text.splitlines()[min(lines) - 1].strip()
                words = f"{function.__qualname__}: {change_of(node)}  in  {head}"
                times[words] += 1
                mutant.words = words + (f" ({times[words]})" if times[words] > 1 else "")
                yield mutant
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


class Judge:
    """The plugin of pytest that runs the tests of a verb, first traced, then mutated."""

    def __init__(self, verb: str, mutants: list[Mutant], end: float) -> None:
        self.verb, self.mutants, self.end = verb, mutants, end
        self.failed = False

    def pytest_sessionstart(self) -> None:
        """A failure is enough: no example is made smaller."""
        import hypothesis  # not before pytest, which rewrites it

        ci = hypothesis.settings.get_profile("ci")
        phases = [hypothesis.Phase.explicit, hypothesis.Phase.generate]
        hypothesis.settings.register_profile("mutants", ci, phases=phases)
        hypothesis.settings.load_profile("mutants")

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note a failure."""
        self.failed |= report.failed

    def pytest_runtestloop(self, session: Any) -> bool:
        """Run the tests once, then those that reach a mutant on each mutant."""
        items = {item.nodeid: item for item in session.items}
        reach, took = self._traced(session, {m.path for m in self.mutants})
        reasons = {one["mutant"]: one["reason"] for one in VERBS[self.verb].get("alive", ())}
        killed = judged = 0
        unlisted = []
        for mutant in self.mutants:
            if time.monotonic() > self.end:
                break
            near = {t for line in mutant.lines for t in reach.get((str(mutant.path), line), ())}
            near &= set(took)
            ordered = [items[t] for t in sorted(near, key=lambda t: (took[t], t))]
            begun, limit = time.monotonic(), 10 + 5 * sum(took[t] for t in near)
            lives = self._forked(partial(self._survives, mutant, ordered), processor=limit)
            judged, killed = judged + 1, killed + (not lives)
            if lives and mutant.words not in reasons:
                unlisted.append(mutant)
            elif not lives and mutant.words in reasons:
                say(f"  listed as alive: {mutant.words}")
            state = "LIVES " if lives else "killed"
            say(f"  {state} {mutant.words}  [{len(near)} tests, {time.monotonic() - begun:.0f} s]")
        say(f"{self.verb}: {killed} of {judged} killed, {len(unlisted)} alive without a reason"
            f"  [{len(took)} tests, {sum(took.values()):.0f} s]")  # fmt: skip
        session.testsfailed = len(unlisted)
        return True

    def _traced(
        self, session: Any, paths: set[Path]
    ) -> tuple[dict[Any, set[str]], dict[str, float]]:
        """Which passing tests reach which lines, and how long each took; in a fork."""

        def run() -> Any:
            reach: dict[Any, set[str]] = defaultdict(set)
            took: dict[str, float] = {}
            tracer = Coverage(include=[str(p) for p in paths], data_file=None, config_file=False)
            tracer.start()
            for item in session.items:
                tracer.switch_context(item.nodeid)
                self.failed, begun = False, time.process_time()
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
                if not self.failed:
                    took[item.nodeid] = time.process_time() - begun
                else:
                    print("fails unchanged:", item.nodeid, file=sys.__stderr__)
            tracer.stop()
            for file in tracer.get_data().measured_files():
                for line, tests in tracer.get_data().contexts_by_lineno(file).items():
                    reach[file, line] |= set(tests)
            return dict(reach), took

        traced: tuple[dict[Any, set[str]], dict[str, float]] | None = self._forked(run, 3600)
        return traced or sys.exit("the tests did not come to an end unchanged")

    def _survives(self, mutant: Mutant, items: list[Any]) -> bool:
        mutant.put()
        for one in gc.get_objects():
            if hasattr(type(one), "cache_clear"):
                one.cache_clear()
        for item in items:
            self.failed = False
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
            if self.failed:
                return False
        return True

    def _forked(
        self, work: Callable[[], Any], seconds: int = LONGEST, processor: float = 3600
    ) -> Any:
        """What the work returns in a process of its own; False if it does not come to an end."""
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.setpgid(0, 0)
            if sys.platform == "linux":  # what is interrupted leaves no process behind
                ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
            signal.alarm(seconds)
            signal.setitimer(signal.ITIMER_PROF, processor)
            status = 1
            try:
                with os.fdopen(write, "wb") as pipe:
                    pipe.write(pickle.dumps(work()))
                status = 0
            except BaseException:
                say(traceback.format_exc())
            finally:
                os._exit(status)
        os.close(write)
        with os.fdopen(read, "rb") as pipe:
            answer = pipe.read()
        os.waitpid(child, 0)
        return pickle.loads(answer) if answer else False


def mutants_of_verb(verb: str) -> list[Mutant]:
    """Return the mutants of the functions of a verb, in order of their hash."""
    bodies = VERBS[verb]["bodies"].items()
    every = [
        mutant for module, names in bodies for mutant in mutants_of(ROOT / f"{module}.py", names)
    ]
    return sorted(every, key=lambda m: m.position)


def say(text: str) -> None:
    """Print past what pytest captures."""
    os.write(SHOWN, f"{text}\n".encode())


SHOWN = os.dup(1)


def judged(verb: str, mutants: list[Mutant], end: float = math.inf) -> int:
    """Judge the mutants in a process of its own; 1 if one lives without a reason."""
    tests = [f"tests/{file}" for file in VERBS[verb]["tests"]]
    doctests = [f"{module}.py" for module in VERBS[verb]["bodies"]]
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        judge = Judge(verb, mutants, end)
        os._exit(int(pytest.main([*OPTIONS, *tests, *doctests], plugins=[judge])))
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status not in (0, 1):
        say(f"{verb}: its tests cannot be run (exit status {status})")
    return int(status != 0)


def main() -> int:
    """Judge the verbs, all of them or a lot."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("verbs", nargs="*", metavar="VERB")
    parser.add_argument("--share", type=float, help="the share of each verb's mutants")
    parser.add_argument("--lot", type=int, metavar="SEED", help="draw a few, as the check does")
    options = parser.parse_args()
    os.chdir(ROOT)
    os.environ["HYPOTHESIS_PROFILE"] = "ci"
    os.environ.pop("PYTEST_ADDOPTS", None)
    verbs, end = options.verbs or list(VERBS), math.inf
    draw = random.Random(options.lot)
    if options.lot is not None:
        verbs = [verb for verb in verbs if VERBS[verb].get("share", 1) > 0]
        verbs, end = draw.sample(verbs, min(LOT_VERBS, len(verbs))), time.monotonic() + LOT_SECONDS
    failures = 0
    for verb in verbs:
        if time.monotonic() > end:
            break
        share = VERBS[verb].get("share", 1) if options.share is None else options.share
        mutants = [m for m in mutants_of_verb(verb) if m.position < share]
        if options.lot is not None:
            reasons = {one["mutant"] for one in VERBS[verb].get("alive", ())}
            mutants = [m for m in mutants if m.words not in reasons]
            mutants = draw.sample(mutants, min(LOT_MUTANTS, len(mutants)))
        failures += judged(verb, mutants, end)
    return int(failures > 0)


if __name__ == "__main__":
    raise SystemExit(main())
