"""Ten thousand loops at the corners of stability: how long each question takes, what contradicts.

``python benchmarks/boundary_loops.py [LOOPS [SEED]]`` draws loops with factors on the boundary,
common factors, constants and ill-posed pairs, half of them in s and half in z, asks margins, gains,
locus, delays, norms and connections of each, and prints the counts, the slowest answer of each
question, and what two answers contradict. The exit status is 1 where there is a contradiction, or
an answer that took more than 10 s. Ten thousand take about an hour.
"""

import sys
import traceback
from collections import Counter

from hypothesis import HealthCheck, Phase, given, seed, settings

from compensator_theory.strategies import boundary_loops
from tests.support.boundary_loops import Requests, contradictions

LONGEST = 10.0  # seconds
BATCH = 250
"""Loops of one seed; Hypothesis gets slow with what it remembers of many."""


def measure_seed(variable: str, batch: int, loops: int, worst: dict, counts: Counter) -> int:
    """Draw loops with one seed, keep the slowest answers, and count what is false."""
    drawn = []

    @seed(batch)
    @settings(max_examples=loops, database=None, deadline=None, phases=[Phase.generate],
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(boundary_loops(variable, max_order=2 + batch % 2))
    def run(pair):
        requests = Requests()
        try:
            sentences = contradictions(*pair, requests)
        except Exception as error:  # an error that is not ours, or a check that fails
            where = traceback.extract_tb(error.__traceback__)[-1]
            sentences = [f"{type(error).__name__} in {where.name}: {error}"[:200]]
        drawn.append(pair)
        for sentence in sentences:
            counts[sentence] += 1
            print(f"FALSE {sentence}: {pair[0]}  {pair[1]}", flush=True)
        for name, took in requests.seconds.items():
            worst[name] = max(worst.get(name, (0.0, "")), (took, f"{pair[0]}  {pair[1]}"))

    run()
    return len(drawn)


def main(loops: int = 10_000, batch: int = 0) -> int:
    """Ask, print, and return the exit status."""
    worst: dict[str, tuple[float, str]] = {}
    failures: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    while sum(counts.values()) < loops:
        for variable in ("s", "z"):
            counts[variable] += measure_seed(variable, batch, min(BATCH, loops), worst, failures)
        batch += 1
        print(f"{dict(counts)} loops, {sum(failures.values())} contradictions", flush=True)
    for name, (took, loop) in sorted(worst.items()):
        print(f"{name}: slowest {took:.2f} s for {loop}")
    return int(bool(failures) or max(took for took, _ in worst.values()) > LONGEST)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
