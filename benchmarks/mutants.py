"""Which small errors in a module the tests of its own name find.

Run with: python benchmarks/mutants.py [COUNT] [SEED] [FOLDER OR MODULE ...]

A mutant is a module in which one comparison, sign, connective, condition or number, of a function
or of a constant, is another, drawn with the seed among all of the modules that have tests of their
name. It is made while the module is imported and stands in no file. The tests of that name run on
it, each mutant in a process of its own; it is killed where one of them fails or they do not come to
an end. What survives is a missing test, or a change that changes nothing.
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
import subprocess
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from hashlib import sha256
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any, Protocol, TypeVar

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
# What is printed, drawn, written or read there is held by the tests of other names.
NOT_CORE = {"cli", "dissertation", "experiments", "export", "plots", "reports", "strategies"}
LONGEST = 300  # seconds that a mutant's tests may take, waiting included
PR_SET_PDEATHSIG = 1
OPTIONS = ["-q", "-p", "no:cacheprovider", "-o", "faulthandler_timeout=0", "-n", "0",
           "--randomly-seed=0", "--randomly-dont-reorganize", "--hypothesis-seed=0"]  # fmt: skip

SWAPPED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.And: ast.Or, ast.Or: ast.And, ast.USub: ast.UAdd,
}  # fmt: skip


class Worded:
    """A mutant that is named by its words: what is changed, into what, and in which line."""

    words: str

    @property
    def position(self) -> float:
        """Return a number in [0, 1) from the words, which another change of the file keeps."""
        return int(sha256(self.words.encode()).hexdigest()[:8], 16) / 2**32


AnyWorded = TypeVar("AnyWorded", bound=Worded)


def numbered(mutants: Iterable[AnyWorded]) -> list[AnyWorded]:
    """Return the mutants, the second and later ones of the same words with their number."""
    times: Counter[str] = Counter()
    named = list(mutants)
    for mutant in named:
        times[mutant.words] += 1
        if (time := times[mutant.words]) > 1:
            mutant.words += f" ({time})"
    return named


class Verdicts:
    """The mutants of one entry of a list (central_verbs.toml, kernel_updates.toml) while judged.

    The entry says its `share`, of the mutants by position, and those that live: `alive`, each with
    its reason.
    """

    def __init__(self, name: str, entry: dict[str, Any]) -> None:
        self.name, self.entry = name, entry
        self.reasons = {one["mutant"]: one["reason"] for one in entry.get("alive", ())}
        self.judged = self.killed = self.unlisted = 0

    def chosen(
        self,
        mutants: Iterable[AnyWorded],
        share: float | None,
        lot: tuple[random.Random, int] | None,
    ) -> list[AnyWorded]:
        """Return those of the share, by position; of a lot so many that are not listed as alive."""
        most = self.entry.get("share", 1) if share is None else share
        ordered = sorted(mutants, key=lambda m: m.position)
        within = [m for m in ordered if m.position < most]
        if lot is None:
            return within
        draw, count = lot
        within = [m for m in within if m.words not in self.reasons]
        return draw.sample(within, min(count, len(within)))

    def add(self, mutant: Worded, lives: bool, how: str) -> None:
        """Count a judged mutant, and say what became of it."""
        self.judged, self.killed = self.judged + 1, self.killed + (not lives)
        self.unlisted += lives and mutant.words not in self.reasons
        if not lives and mutant.words in self.reasons:
            say(f"  listed as alive: {mutant.words}")
        say(f"  {'LIVES ' if lives else 'killed'} {mutant.words}  [{how}]")

    def end(self, how: str) -> int:
        """Say the counts; return how many live without a reason."""
        counts = f"{self.killed} of {self.judged} killed, {self.unlisted} alive without a reason"
        say(f"{self.name}: {counts}  [{how}]")
        return self.unlisted


class Placed(Protocol):
    """A mutant for `Judge`: the keys of its place in what the tracer says, and how it is put."""

    words: str

    @property
    def keys(self) -> set[Any]:
        """Keys of the tracer's result; a test that reaches one of them meets the mutant."""

    def put(self) -> None:
        """Put it in its place, in this process."""


class Tracer(Protocol):
    """What notes which places a test reaches."""

    def start(self) -> None:
        """Begin to trace."""

    def switch_context(self, test: str) -> None:
        """Say which test runs from now on."""

    def result(self) -> dict[Any, set[str]]:
        """End; return which tests reach which keys."""


class Judge:
    """The plugin of pytest that runs tests, first traced, then with each mutant in their place."""

    def __init__(
        self, verdicts: Verdicts, mutants: Sequence[Placed], tracer: Tracer, end: float = math.inf
    ) -> None:
        self.verdicts, self.mutants, self.tracer, self.end = verdicts, mutants, tracer, end
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
        reach, took = self._traced(session)
        for mutant in self.mutants:
            if time.monotonic() > self.end:
                break
            near = {test for key in mutant.keys for test in reach.get(key, ())} & set(took)
            ordered = [items[t] for t in sorted(near, key=lambda t: (took[t], t))]
            begun, limit = time.monotonic(), 10 + 5 * sum(took[t] for t in near)
            lives = self._forked(partial(self._survives, mutant, ordered), processor=limit)
            how = f"{len(near)} tests, {time.monotonic() - begun:.0f} s"
            self.verdicts.add(mutant, lives, how)
        how = f"{len(took)} tests, {sum(took.values()):.0f} s"
        session.testsfailed = self.verdicts.end(how)
        return True

    def _traced(self, session: Any) -> tuple[dict[Any, set[str]], dict[str, float]]:
        """Which passing tests reach which places, and how long each took; in a fork."""

        def run() -> Any:
            took: dict[str, float] = {}
            self.tracer.start()
            for item in session.items:
                self.tracer.switch_context(item.nodeid)
                self.failed, begun = False, time.process_time()
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
                if not self.failed:
                    took[item.nodeid] = time.process_time() - begun
                else:
                    print("fails unchanged:", item.nodeid, file=sys.__stderr__)
            return self.tracer.result(), took

        traced: tuple[dict[Any, set[str]], dict[str, float]] | None = self._forked(run, 3600)
        return traced or sys.exit("the tests did not come to an end unchanged")

    def _survives(self, mutant: Placed, items: list[Any]) -> bool:
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


def say(text: str) -> None:
    """Print past what pytest captures."""
    os.write(SHOWN, f"{text}\n".encode())


SHOWN = os.dup(1)


def judged(judge: Judge, tests: list[str]) -> int:
    """Run the tests with the plugin in a process of its own; 1 if one lives without a reason."""
    child = os.fork()
    if child == 0:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os._exit(int(pytest.main([*OPTIONS, *tests], plugins=[judge])))
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status not in (0, 1):
        say(f"{judge.verdicts.name}: its tests cannot be run (exit status {status})")
    return int(status != 0)


def options_of(description: str, name: str) -> argparse.Namespace:
    """Read the command line of a tester with a list: names of entries, --share, --lot."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("names", nargs="*", metavar=name)
    parser.add_argument("--share", type=float, help=f"the share of the mutants of each {name}")
    parser.add_argument("--lot", type=int, metavar="SEED", help="draw a few")
    return parser.parse_args()


def places(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes that a mutant may change: no annotation, no docstring, no text of an error."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.Raise | ast.JoinedStr | ast.Assert):
                continue
            if isinstance(child, ast.AST):
                if changed(child) is not None:
                    yield child
                yield from places(child)


def changed(node: ast.AST) -> tuple[str, Any] | None:
    """The field of a node that becomes another, and what it becomes."""
    match node:
        case ast.Compare(ops=[first, *rest]) if type(first) in SWAPPED:
            return "ops", [SWAPPED[type(first)](), *rest]
        case ast.BinOp(op=op) | ast.BoolOp(op=op) | ast.UnaryOp(op=op) | ast.AugAssign(op=op):
            return ("op", SWAPPED[type(op)]()) if type(op) in SWAPPED else None
        case ast.If(test=test) | ast.IfExp(test=test):
            return "test", ast.UnaryOp(ast.Not(), test)
        case ast.Constant(value=bool(value)):
            return "value", not value
        case ast.Constant(value=int(value)):
            return "value", value + 1
        case ast.Constant(value=float(value)):
            return "value", 1 - value if 0 < value < 1 and value != 0.5 else 2 * value + 1
    return None


def parts(tree: ast.Module) -> list[ast.AST]:
    """The functions of a module, the methods of its classes, and its constants."""
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    return [
        node
        for body in (tree.body, *(one.body for one in classes))
        for node in body
        if isinstance(node, ast.FunctionDef) or (body is tree.body and isinstance(node, ast.Assign))
    ]


def mutants(text: str) -> int:
    """How many mutants a module has."""
    return sum(1 for part in parts(ast.parse(text)) for _ in places(part))


def mutated(text: str, number: int) -> tuple[ast.Module, str]:
    """The mutant of that number, and what was changed in it."""
    tree = ast.parse(text)
    node: Any = [place for part in parts(tree) for place in places(part)][number]
    before = ast.unparse(node).split("\n")[0]
    field, value = changed(node) or ("", None)
    setattr(node, field, value)
    ast.fix_missing_locations(tree)
    return tree, f"line {node.lineno}: {before}  ->  {ast.unparse(node).splitlines()[0]}"


def tests_of(module: Path) -> Path:
    """Where the tests of a module's name stand."""
    return (
        ROOT / "tests" / module.parent.relative_to(ROOT) / f"test_{module.name.removeprefix('_')}"
    )


def modules(chosen: list[str]) -> list[Path]:
    """The modules of the core that have tests of their name, of all or of those chosen."""
    if chosen:
        chosen_modules = [ROOT / one for one in chosen]
        files = [
            m for one in chosen_modules for m in ([one] if one.is_file() else one.rglob("*.py"))
        ]
    else:
        files = [m for package in PACKAGES for m in (ROOT / package).rglob("*.py")]
        files = [m for m in files if not NOT_CORE & set(m.relative_to(ROOT).parts)]
    return sorted(m for m in files if tests_of(m).is_file())


def pytest_configure() -> None:
    """In the process of a mutant pytest has this file for a plugin, before it imports a test."""
    path, number = os.environ["MUTANT"].rsplit(":", 1)
    unchanged = SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, name: str) -> Any:
        if not os.path.samefile(loader.path, path):
            return unchanged(loader, name)
        return compile(mutated(Path(path).read_text(), int(number))[0], path, "exec")

    SourceFileLoader.get_code = get_code  # type: ignore[assignment, method-assign]


def survives(tests: list[Path], mutant: str, plugin: str = "mutants") -> bool:
    """Whether the tests find nothing wrong with the mutant that the plugin puts in its place."""
    path = os.environ.get("PYTHONPATH")
    environment = {
        **os.environ,
        "MUTANT": mutant,
        "HYPOTHESIS_PROFILE": "ci",
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *([path] if path else [])]),
    }
    options = ["-x", "-q", "-n", "0", "--tb=no", "-p", plugin, "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *options, *map(str, tests)]
    try:
        ended = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    if ended.returncode < 0:  # a kernel may end its process
        return False
    if ended.returncode not in (0, 1, 2):
        raise SystemExit(ended.stdout.decode() + ended.stderr.decode())
    return ended.returncode == 0


def main(count: str = "60", seed: str = "0", *chosen: str) -> None:
    """Draw the mutants and judge them."""
    every = [(m, i) for m in modules(list(chosen)) for i in range(mutants(m.read_text()))]
    drawn = random.Random(int(seed)).sample(every, min(int(count), len(every)))
    killed = 0
    for module, number in sorted(drawn):
        survived = survives([tests_of(module)], f"{module}:{number}")
        killed += not survived
        change = mutated(module.read_text(), number)[1]
        print("SURVIVES" if survived else "killed  ", module.relative_to(ROOT), change, flush=True)
    print(f"{killed} of {len(drawn)} killed, drawn among {len(every)} with seed {seed}.")


if __name__ == "__main__":
    main(*sys.argv[1:])
