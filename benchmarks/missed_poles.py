"""How often it is said wrongly whether poles are reached: plants with 1 to 12 steps of dead time.

Run with: python benchmarks/missed_poles.py [LOOPS] [FIRST_SEED]

As many loops that match their target model (placed exactly, with rounding or changes of 1e-9 in the
controller, or by RCAC) as loops that do not (a pole moved by 0.06 to 0.3, another controller, the
controller of another plant, RCAC stopped too early). What is true is found with fractions; see
`tests/support/placed_loops.py`. Beside it stands what a distance of 0.01 or 0.05 would have said.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from rcac_numeric import compare_exactly, loop_health
from tests.support.placed_loops import Loop, matching, missing


def is_warned(loop: Loop) -> bool:
    """Whether the health of a run of RCAC warns of missed poles; of no run, what is decided."""
    if loop.run is None:
        return False
    return any(warning.code == "missed poles" for warning in loop_health(loop.run).warnings)


def main() -> None:
    """Print both counts."""
    count, first = (int(a) for a in (sys.argv[1:] + ["500", "0"][len(sys.argv) - 1 :])[:2])
    for name, draw in (("match", matching), ("miss", missing)):
        kinds, wrong = Counter(), []
        by_distance = dict.fromkeys((0.01, 0.05), 0)
        largest, least = 0.0, float("inf")
        drawn = 0
        for seed in range(first, first + count):
            loop = draw(seed)
            if loop is None:
                continue
            drawn += 1
            comparison = compare_exactly(loop.plant, loop.compensator, loop.target)
            kinds[loop.words.partition(":")[0]] += 1
            largest, least = (
                max(largest, comparison.backward_error),
                min(least, comparison.backward_error),
            )
            for limit in by_distance:
                by_distance[limit] += (comparison.worst_distance <= limit) != loop.is_same
            alarmed = is_warned(loop)
            if comparison.is_reached != loop.is_same or (loop.is_same and alarmed):
                wrong.append(
                    (seed, loop.words, comparison.worst_distance, comparison.backward_error)
                )
            if loop.run is not None and not loop.is_same and not alarmed:
                wrong.append((seed, loop.words, "not in its health"))
        print(f"{drawn} loops that {name} their target: {len(wrong)} judged wrongly; "
              f"{dict(kinds)}; backward error {least:.2g} to {largest:.2g}; wrong by distance: "
              + ", ".join(f"{n} with {limit:g}" for limit, n in by_distance.items()))  # fmt: skip
        for one in wrong:
            print("   ", *one)


if __name__ == "__main__":
    main()
