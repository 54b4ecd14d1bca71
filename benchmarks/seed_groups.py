"""How often verdicts of record flip on fresh groups of seeds, by example.

``python benchmarks/seed_groups.py --groups 20 5.1 6.1`` judges the claims of the text on groups 1
to 20 of held-out seeds (the verdicts of record are those of group 0) and prints, for each claim
that a draw can decide, in how many groups another verdict came out. Where a bound was changed after
a look at some groups, ``--first 21`` takes others.
"""

import argparse
from collections import Counter

import numpy as np

from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids
from rcac_experiments.judging._claim import OURS
from rcac_numeric.arrays._values import replaced as replace


def main() -> int:
    """Run the groups; 1 where more than one verdict in a hundred flips."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("examples", nargs="*")
    parser.add_argument("--groups", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    options = parser.parse_args()
    flips: Counter[tuple[str, str]] = Counter()
    judged = 0
    for number in options.examples or example_ids():
        example = load_example(number)
        runs = [*example.runs.values(), *example.studies.values()]
        if not options.examples and max((run.seeds for run in runs), default=1) == 1:
            continue  # nothing of it is drawn, or each draw is a run that can be asked for by name
        claims = [replace(c, control="") for c in example.claims if c.owner != OURS]
        for group in range(options.first, options.first + options.groups):
            with np.errstate(all="ignore"):
                verdicts = verify(example.only(claims).held_out(group)).verdicts
            judged += len(verdicts)
            for verdict in verdicts:
                if verdict.has_changed:
                    flips[number, verdict.claim.quote[:60]] += 1
                    print(number, group, verdict.claim.quote[:60], verdict.verdict, flush=True)
        print(f"{number}: {options.groups} groups, {len(claims)} claims", flush=True)
    share = sum(flips.values()) / max(judged, 1)
    print(f"{sum(flips.values())} of {judged} verdicts flipped, {100 * share:.2f} %")
    return 1 if share > 0.01 else 0


if __name__ == "__main__":
    raise SystemExit(main())
