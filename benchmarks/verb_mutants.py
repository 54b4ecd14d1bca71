"""Which small errors in the modules of the central verbs the tests find, verb by verb.

Run with: python benchmarks/verb_mutants.py [COUNT] [SEED] [VERB ...]

Of each verb of VERBS, COUNT mutants of its own modules are drawn with the seed: one comparison,
sign, connective, condition or number in the body of a function is another, as in mutants.py. Its
tests are collected and run once, traced, so that each mutant meets the tests alone that reach its
line, the quickest first, in a fork whose functions are changed in place. It is killed where one of
them fails or they do not come to an end. What lives is printed: a missing test, or a change that
changes nothing. Tests that start a process of their own do not see the mutant.
"""

from __future__ import annotations

import ast
import gc
import os
import pickle
import random
import signal
import sys
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import pytest
from coverage import Coverage
from mutants import ROOT, mutated, parts, places

CT, RN = "compensator_theory", "rcac_numeric"
# A verb, its own modules, and the folders of its tests; the modules' doctests are run in any case.
VERBS: dict[str, tuple[list[str], list[str]]] = {
    "place_poles": ([f"{CT}/placement/_pole_placement", f"{CT}/placement/_solutions"],
                    [f"{CT}/placement", f"{CT}/exercises"]),
    "stabilising_compensators": ([f"{CT}/placement/_stabilising_compensators"],
                                 [f"{CT}/placement", f"{CT}/exercises"]),
    "transfer_function": ([f"{CT}/systems/_conversions", f"{CT}/systems/_transfer_functions"],
                          [f"{CT}/systems", f"{CT}/bezout", f"{CT}/roots"]),
    "realisation": ([f"{CT}/systems/_canonical_forms", f"{CT}/systems/_realisations"],
                    [f"{CT}/systems", f"{CT}/bezout", f"{CT}/roots"]),
    "bezout_identity": ([f"{CT}/bezout/_common_factors", f"{CT}/bezout/_sylvester"],
                        [f"{CT}/systems", f"{CT}/bezout", f"{CT}/roots"]),
    "decide_stability": ([f"{CT}/roots/_stability"],
                         [f"{CT}/systems", f"{CT}/bezout", f"{CT}/roots"]),
    "smith_form": ([f"{CT}/forms/_equivalence", f"{CT}/forms/_smith_mcmillan"],
                   [f"{CT}/forms"]),
    "solve_diophantine": ([f"{CT}/forms/_polynomial_equations"], [f"{CT}/forms"]),
    "observer_forms": ([f"{CT}/observers/_enumeration", f"{CT}/observers/_form"],
                       [f"{CT}/observers"]),
    "observer_based_compensator": ([f"{CT}/observers/_design", f"{CT}/observers/_gains"],
                                   [f"{CT}/observers"]),
    "lqg_poles": ([f"{CT}/lqg/_poles", f"{CT}/lqg/_controllers"], [f"{CT}/lqg"]),
    "solve_riccati": ([f"{CT}/lqg/_riccati"], [f"{CT}/lqg"]),
    "stability_conditions": ([f"{CT}/stability/_conditions"], [f"{CT}/stability"]),
    "stability_margins": ([f"{CT}/stability/_margins"], [f"{CT}/stability"]),
    "feedforward, pid, iir": ([f"{RN}/controllers/_kinds"],
                              [f"{RN}/controllers", f"{RN}/engine"]),
    "ControllerSettings": ([f"{RN}/controllers/_settings", f"{RN}/controllers/_structure"],
                           [f"{RN}/controllers", f"{RN}/engine"]),
    "simulate": ([f"{RN}/engine/_simulation", f"{RN}/engine/_run", f"{RN}/engine/_runs"],
                 [f"{RN}/controllers", f"{RN}/engine"]),
    "Controller.step": ([f"{RN}/engine/_controller", f"{RN}/engine/_states"],
                        [f"{RN}/controllers", f"{RN}/engine"]),
    "check_controller": ([f"{RN}/checks/_check"], [f"{RN}/checks"]),
    "loop_health": ([f"{RN}/checks/_diagnosis", f"{RN}/checks/_rules"], [f"{RN}/checks"]),
    "compare_exactly": ([f"{RN}/analysis/_exact_comparison", f"{RN}/analysis/_loop_analysis"],
                        [f"{RN}/analysis"]),
    "lqg": ([f"{RN}/analysis/_lqg", f"{RN}/analysis/_equations"], [f"{RN}/analysis"]),
    "h2_cost": ([f"{RN}/analysis/_costs"], [f"{RN}/analysis"]),
    "numeric stability_margins": ([f"{RN}/analysis/_classical", f"{RN}/analysis/_disk"],
                                  [f"{RN}/analysis"]),
    "design": ([f"{RN}/designing/_design", f"{RN}/designing/_plants"], [f"{RN}/designing"]),
}  # fmt: skip
LONGEST = 120  # seconds that a mutant's tests may take
OPTIONS = ["-q", "-p", "no:cacheprovider", "-n", "0",
           "--randomly-seed=0", "--randomly-dont-reorganize", "--hypothesis-seed=0"]  # fmt: skip


class Mutant:
    """A place in the body of a function of a module."""

    def __init__(self, path: Path, number: int, lines: set[int], function: Any) -> None:
        self.path, self.number, self.lines, self.function = path, number, lines, function

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


def mutants_of(path: Path) -> Iterator[Mutant]:
    """The mutants of a module that can be made in memory: of bodies, not of defaults."""
    tree = ast.parse(path.read_text())
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
            if function is not None and id(node) not in heads:
                yield Mutant(path, number, _lines(part, node), function)
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
    """The plugin of pytest that runs the tests of a group of verbs, first traced, then mutated."""

    def __init__(self, verbs: list[str], count: int, seed: int) -> None:
        self.verbs, self.count, self.seed = verbs, count, seed
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
        paths = {p for verb in self.verbs for p in paths_of(verb)}
        items = {item.nodeid: item for item in session.items}
        reach, took = self._traced(session, paths)
        print(f"{len(took)} tests of {', '.join(self.verbs)}: {sum(took.values()):.0f} s",
              file=sys.__stderr__, flush=True)  # fmt: skip
        for verb in self.verbs:
            every = [m for path in paths_of(verb) for m in mutants_of(path)]
            draw = random.Random(f"{self.seed} {verb}")
            drawn = draw.sample(every, min(self.count, len(every)))
            killed = 0
            for mutant in sorted(drawn, key=lambda m: (m.path, m.number)):
                near = {t for line in mutant.lines for t in reach.get((str(mutant.path), line), ())}
                near &= set(took)
                ordered = [items[t] for t in sorted(near, key=lambda t: (took[t], t))]
                begun = time.monotonic()
                lives = self._forked(partial(self._survives, mutant, ordered))
                killed += not lives
                where = f"{mutant.path.relative_to(ROOT)} #{mutant.number}"
                what = mutated(mutant.path.read_text(), mutant.number)[1]
                say(f"  {'LIVES ' if lives else 'killed'} {where} {what}"
                    f"  [{len(near)} tests, {time.monotonic() - begun:.0f} s]")  # fmt: skip
            say(f"{verb}: {killed} of {len(drawn)} killed, drawn among {len(every)}")
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
                self.failed, begun = False, time.perf_counter()
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
                if not self.failed:
                    took[item.nodeid] = time.perf_counter() - begun
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

    def _forked(self, work: Callable[[], Any], seconds: int = LONGEST) -> Any:
        """What the work returns in a process of its own; False if it does not come to an end."""
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.setpgid(0, 0)
            signal.alarm(seconds)
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


def paths_of(verb: str) -> list[Path]:
    """The files of a verb's modules."""
    return [ROOT / f"{module}.py" for module in VERBS[verb][0]]


def say(text: str) -> None:
    """Print past what pytest captures."""
    os.write(SHOWN, f"{text}\n".encode())


SHOWN = os.dup(1)


def main(count: str = "10", seed: str = "0", *chosen: str) -> None:
    """Judge the verbs, those with the same tests together."""
    os.environ["HYPOTHESIS_PROFILE"] = "ci"
    groups: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for verb in chosen or VERBS:
        groups[tuple(VERBS[verb][1])].append(verb)
    os.chdir(ROOT)
    for folders, verbs in groups.items():
        tests = [f"tests/{folder}" for folder in folders]
        doctests = [str(path) for verb in verbs for path in paths_of(verb)]
        child = os.fork()
        if child == 0:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            judge = Judge(verbs, int(count), int(seed))
            os._exit(int(pytest.main([*OPTIONS, *tests, *doctests], plugins=[judge])))
        if os.waitpid(child, 0)[1]:
            say(f"the tests of {', '.join(verbs)} did not come to an end")


if __name__ == "__main__":
    main(*sys.argv[1:])
