"""Which claims of the text a change of their example's file turns, by change and example.

``python benchmarks/mutation_table.py 2.2 4.7`` changes the file of each example in the ways of
`tests.support.mutations`, one at a time, and counts the quoted claims that hold and no longer hold
then. Fewer seeds run than verdicts of record have; without numbers all examples do, in about an
hour. docs/fair-judging.md has the sum.
"""

import argparse
import time
from collections import Counter

import numpy as np

from compensator_theory import CompensatorError
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids, read_example
from rcac_experiments.judging._claim import HOLDS, OURS
from tests.support.mutations import mutations, outcomes


def main() -> int:
    """Print the table; 1 where a claim that holds is turned by no change."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("examples", nargs="*")
    options = parser.parse_args()
    turned: Counter[str] = Counter()
    could: Counter[str] = Counter()
    total = some = 0
    for number in options.examples or example_ids():
        begun = time.perf_counter()
        table = read_example(number)[0]
        claims = [claim for claim in load_example(number).claims if claim.owner != OURS]
        with np.errstate(all="ignore"):
            holding = {i for i, o in enumerate(outcomes(table, number)) if o == HOLDS}
            claims_holding: set[int] = set()
            for name, changed in mutations(table):
                try:
                    after = outcomes(changed, number)
                except CompensatorError as error:
                    print(f"{number}, {name}: no experiment any more, {str(error)[:80]}")
                    continue
                lost = {i for i in holding if after[i] != HOLDS}
                turned[name] += len(lost)
                could[name] += len(holding)
                claims_holding |= lost
                print(f"{number}, {name}: {len(lost)} of {len(holding)}", flush=True)
        total, some = total + len(holding), some + len(claims_holding)
        for i in sorted(holding - claims_holding):
            print(f"{number}: nothing turns {claims[i].text!r}")
        print(f"{number}: {time.perf_counter() - begun:.0f} s", flush=True)
    for name, count in could.items():
        print(f"{name}: {turned[name]} of {count} turned, {turned[name] / max(count, 1):.0%}")
    print(f"{some} of {total} claims that hold are turned by a change")
    return 0 if some == total else 1


if __name__ == "__main__":
    raise SystemExit(main())
