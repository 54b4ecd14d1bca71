"""Each named construction against its oracle on many drawn cases: counts and CPU seconds.

    python benchmarks/construction_oracles.py                    # all, 10 000 draws each
    python benchmarks/construction_oracles.py 38 40 --draws 1000 --seconds 60 --report counts.jsonl
    python benchmarks/construction_oracles.py --draws 0 --report counts.jsonl  # only the sums

The draws of a construction are shared by the Hypothesis tests that construction_tests.toml names
for it, each in pieces with seeds that count up. A case counts when its test has run to its end;
what a test refuses to judge (`assume`) does not. With --report each piece is a line as soon as it
is done, also when Ctrl-C or SIGTERM cuts it short, and a later run goes on where the lines end:
what stands there for the same text of the test is not drawn again.
"""

import argparse
import ast
import contextlib
import hashlib
import importlib
import itertools
import json
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import hypothesis

ROOT = Path(__file__).resolve().parents[1]
CONSTRUCTIONS = ROOT / "docs" / "constructions.toml"
TESTS = ROOT / "benchmarks" / "construction_tests.toml"


class Enough(KeyboardInterrupt):
    """The time for one piece is over."""


class Test:
    """One drawn test with one parameter set, and how many cases it has judged."""

    def __init__(self, path: str, name: str, function, parameters: dict[str, object]) -> None:
        self.id, self.function, self.parameters = f"{path}::{name}", function, parameters
        self.version = version(ROOT / path, name.partition("[")[0])
        self.lines: dict[int, dict[str, object]] = {}  # by seed, the last that was run

    def sum(self, key: str) -> float:
        """Add up the cases or the seconds of all seeds."""
        return sum(line[key] for line in self.lines.values())

    @property
    def end(self) -> str:
        """Why no other seed need be run: something is wrong, or there are no more cases."""
        verdicts = [line["verdict"] for line in self.lines.values()]
        return next((v for v in verdicts if v.startswith(("WRONG", "no more"))), "")

    def run(self, draws: int, seconds: float, first_seed: int) -> dict[str, object]:
        """Run one piece; return its line of the report."""
        seed = next(k for k in itertools.count(first_seed) if k not in self.lines)
        inner = self.function.hypothesis.inner_test
        entered, judged, start, falsified = 0, 0, time.process_time(), ""

        def counted(*args, **kwargs):
            nonlocal entered, judged, falsified
            entered += 1
            if time.process_time() - start > seconds:
                raise Enough
            try:
                inner(*args, **kwargs)
            except Exception as error:
                if isinstance(error, (AssertionError, ArithmeticError, TypeError, ValueError)):
                    drawn = {k: v for k, v in kwargs.items() if k != "data"}
                    falsified = falsified or f"{type(error).__name__}: {error} for {drawn}"[:1000]
                raise
            judged += 1

        self.function.hypothesis.inner_test = counted
        settings = hypothesis.settings(
            max_examples=draws,
            deadline=None,
            database=None,
            phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate],  # shrinking is no case
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        verdict = ""
        try:
            test = hypothesis.seed(seed)(self.function)
            test._hypothesis_internal_use_settings = settings  # those of the file ask for fewer
            test(**self.parameters)
            # the engine also stops where nine in ten are refused: that says nothing about more
            verdict = "" if judged >= draws or entered > 5 * draws else "no more cases"
        except Enough:
            verdict = "time"
        except KeyboardInterrupt:
            verdict = "interrupted"
        except Exception as error:  # the report must say which oracle disagreed, and go on
            verdict = f"WRONG: {falsified or f'{type(error).__name__}: {error}'[:1000]}"
        finally:
            self.function.hypothesis.inner_test = inner
        spent = round(time.process_time() - start, 2)
        line = {"test": self.id, "version": self.version, "seed": seed, "draws": draws}
        self.lines[seed] = line | {"cases": judged, "seconds": spent, "verdict": verdict}
        return self.lines[seed]


def cases(tests) -> int:
    """Add up what the tests have judged."""
    return int(sum(test.sum("cases") for test in tests))


def version(path: Path, name: str) -> str:
    """Return a digest of the test and of all in its file that is no other test."""
    tree = ast.parse(path.read_text())
    tests = [
        node
        for node in tree.body
        if not (isinstance(node, ast.FunctionDef) and node.name.startswith("test_"))
        or node.name == name
    ]
    return hashlib.sha256("".join(map(ast.dump, tests)).encode()).hexdigest()[:12]


def parameter_sets(function) -> list[dict[str, object]]:
    """Return what pytest's parametrize gives to the test: one empty set without it."""
    sets: list[dict[str, object]] = [{}]
    for mark in getattr(function, "pytestmark", ()):
        if mark.name != "parametrize":
            continue
        names, values = mark.args[:2]
        names = [n.strip() for n in names.split(",")] if isinstance(names, str) else list(names)
        rows = [getattr(v, "values", None) or ((v,) if len(names) == 1 else v) for v in values]
        sets = [one | dict(zip(names, row, strict=True)) for one in sets for row in rows]
    return sets


def constructions(chosen: list[int]) -> dict[int, list[Test]]:
    """Return the tests of each construction; two that share a test share its cases."""
    rows = tomllib.loads(CONSTRUCTIONS.read_text())["construction"]
    paths = {str(row["number"]): row["test"] for row in rows}
    named = tomllib.loads(TESTS.read_text())
    if set(named) != set(paths):
        raise SystemExit(f"{TESTS.name} and the table differ in {sorted(set(named) ^ set(paths))}")
    known: dict[str, Test] = {}
    tests_by_row: dict[int, list[Test]] = {}
    for number, path in paths.items():
        if chosen and int(number) not in chosen:
            continue
        module = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        tests = tests_by_row.setdefault(int(number), [])
        for name in named[number]:
            bare, _, index = name.partition("[")
            function = getattr(module, bare, None)
            if not hasattr(function, "hypothesis"):
                raise SystemExit(f"{path} has no drawn test {bare}")
            sets = parameter_sets(function)
            for k in [int(index.removesuffix("]"))] if index else range(len(sets)):
                full = f"{bare}[{k}]" if len(sets) > 1 else bare
                if f"{path}::{full}" not in known:
                    known[f"{path}::{full}"] = Test(path, full, function, sets[k])
                tests.append(known[f"{path}::{full}"])
    return tests_by_row


def commit() -> str:
    """Return which state of the code is judged."""
    command = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return answer.stdout.strip()


def raise_interrupt(*_) -> None:
    """Let SIGTERM end a piece as Ctrl-C does."""
    raise KeyboardInterrupt


def main() -> int:
    """Run what is missing, and print the sums."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("numbers", nargs="*", type=int, help="constructions; all by default")
    parser.add_argument("--draws", type=int, default=10_000, help="for each construction")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="CPU, for each, now")
    parser.add_argument("--piece", type=int, default=2500, help="draws of one piece at most")
    parser.add_argument("--piece-seconds", type=float, default=300, help="CPU of one at most")
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--report", type=Path, help="JSON lines, read first and added to")
    chosen = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    signal.signal(signal.SIGTERM, raise_interrupt)
    rows = constructions(chosen.numbers)
    tests = {test.id: test for row in rows.values() for test in row}
    if chosen.report and chosen.report.exists():
        for text in chosen.report.read_text().splitlines():
            with contextlib.suppress(json.JSONDecodeError):  # a line that a kill cut short
                line = json.loads(text)
                if line["test"] in tests and line["version"] == tests[line["test"]].version:
                    tests[line["test"]].lines[line["seed"]] = line
    if chosen.draws:  # what was wrong is drawn again with its seed: it may have been mended
        for test in tests.values():
            test.lines = {k: x for k, x in test.lines.items() if "WRONG" not in x["verdict"]}
    interrupted, judged = False, commit()
    for row in rows.values():
        left = chosen.seconds
        while not interrupted and left > 0:
            missing = chosen.draws - cases(row)
            open_ones = [test for test in row if not test.end]
            if missing <= 0 or not open_ones:
                break
            test = min(open_ones, key=lambda test: test.sum("cases"))
            draws = min(chosen.piece, max(100, -(-missing // len(open_ones))))
            line = test.run(draws, min(left, chosen.piece_seconds), chosen.seed)
            left -= line["seconds"]
            interrupted = line["verdict"] == "interrupted"
            listed = [n for n, tests_of in rows.items() if test in tests_of]
            if chosen.report:
                with chosen.report.open("a") as file:
                    file.write(json.dumps({"construction": listed, "commit": judged} | line) + "\n")
            spent, verdict = line["seconds"], line["verdict"]
            print(f"{line['cases']:6d} cases {spent:8.1f} s  {test.id}  {verdict}", flush=True)
    print(f"\n{'#':>3} {'cases':>6} {'s':>8} {'ms/case':>8}")
    for number, row in rows.items():
        count, spent = cases(row), sum(t.sum("seconds") for t in row)
        problems = [f"{t.id.partition('::')[2]}: {t.end}" for t in row if t.end]
        mean = 1000 * spent / max(count, 1)
        print(f"{number:3d} {count:6d} {spent:8.1f} {mean:8.1f}  {'; '.join(problems)}")
    wrong = [test.id for test in tests.values() if test.end.startswith("WRONG")]
    short = [n for n, row in rows.items() if cases(row) < chosen.draws]
    total = cases(tests.values())
    print(f"{total} cases, {len(wrong)} tests wrong; {len(short)} constructions short: {short}")
    return 130 if interrupted else int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
