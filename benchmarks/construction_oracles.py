"""Each named construction against its oracle on many drawn cases: counts and CPU seconds.

    python benchmarks/construction_oracles.py                    # all, 10 000 draws each
    python benchmarks/construction_oracles.py 38 40 --draws 1000 --seconds 60 --seed 1

Takes the Hypothesis tests of the files that docs/constructions.md names for a construction. A case
counts when its test has run to its end; what a test refuses to judge (`assume`) does not. A test
that reaches the limit of seconds stops there, and one whose cases run out before says so.
"""

import argparse
import importlib
import re
import sys
import time
from pathlib import Path

import hypothesis

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "constructions.md"


class Enough(KeyboardInterrupt):
    """The time for one test is over."""


def rows() -> dict[int, str]:
    """Return the test file of each construction."""
    table = PAGE.read_text().partition("## Examples")[0]
    listed = re.findall(r"^\| (\d+) \|.*`(tests/[\w/]+\.py)`.*\|$", table, re.M)
    return {int(number): path for number, path in listed}


def run(function, draws: int, seconds: float, seed: int) -> tuple[int, float, str]:
    """Run one test; return the cases that it judged, the CPU seconds and what happened."""
    inner = function.hypothesis.inner_test
    judged, start = 0, time.process_time()

    def counted(*args, **kwargs):
        nonlocal judged
        if time.process_time() - start > seconds:
            raise Enough
        inner(*args, **kwargs)
        judged += 1

    settings = hypothesis.settings(
        max_examples=draws,
        deadline=None,
        database=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    function.hypothesis.inner_test = counted
    verdict = ""
    try:
        test = hypothesis.seed(seed)(function)
        test._hypothesis_internal_use_settings = settings  # those of the file ask for fewer
        test()
        verdict = "" if judged >= draws else "no more cases"
    except Enough:
        verdict = "time"
    except Exception as error:  # the report must say which oracle disagreed, and go on
        verdict = f"WRONG: {type(error).__name__}: {str(error)[:300]}"
    finally:
        function.hypothesis.inner_test = inner
    return judged, time.process_time() - start, verdict


def main() -> int:
    """Print a line for each test."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("numbers", nargs="*", type=int, help="constructions; all by default")
    parser.add_argument("--draws", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="CPU, for each test")
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    files: dict[str, list[int]] = {}
    for number, path in rows().items():
        if not chosen.numbers or number in chosen.numbers:
            files.setdefault(path, []).append(number)
    wrong = 0
    for path, numbers in files.items():
        module = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        print(f"{path} (constructions {', '.join(map(str, numbers))})", flush=True)
        for name, function in vars(module).items():
            if not name.startswith("test_") or not hasattr(function, "hypothesis"):
                continue
            if hasattr(function, "pytestmark"):
                continue  # several arguments: pytest's to give
            judged, spent, verdict = run(function, chosen.draws, chosen.seconds, chosen.seed)
            wrong += verdict.startswith("WRONG")
            print(f"  {judged:6d} cases {spent:8.1f} s  {name}  {verdict}", flush=True)
    print(f"{wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
