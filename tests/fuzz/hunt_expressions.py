"""As many random texts as are asked for: `python -m tests.fuzz.hunt_expressions 1000000 --seed 1`.

Hypothesis draws and shrinks with care, which costs more than reading what it drew and grows with
what it remembers. This hunt draws from a grammar of its own with one seed for each thousand texts,
in processes that are renewed, and prints the text that broke something: it then belongs among the
examples of test_expressions.py.
"""

import argparse
import random
import time
import traceback
from multiprocessing import get_context

from tests.fuzz.expression_checks import check_roots, check_text, warm

PIECE = 1000
ATOMS = [
    "0", "1", "2", "3", "7", "10", "0.1", ".5", "3.", "1e3", "1e-3", "1E+300", "1e300", "1e4000",
    "2i", "0.8j", "1_0", "0x1", "007", "1.4142135623730951", "99999999999999999999", "s", "s", "s",
    "s", "z", "q", "q", "a", "b", "x_1", "pi", "j", "I", "E", "nan", "oo", "zeta", "lambda",
    "None", "__import__", "a.b", "S",
]  # fmt: skip
OPERATORS = ["+", "-", "*", "/", " + ", " - ", "*", "/", "**", "^", "//", "%", "", " ", ",", "\n"]
EXPONENTS = ["2", "3", "-1", "10", "1000", "1001", "0.5", "(1/3)", "(-1/2)", "1e300", "s", "-2"]
CALLS = ["sqrt", "sqrt", "CRootOf", "exp", "eval", "s", ""]
DAMAGE = ["(", ")", "**", "\u2212", "\x00", "__", ";", "[", "'", '"', "=", "{", "!", "\u00b2", "é"]


def random_text(rng, depth=4):
    """Draw an expression, well formed but for its names and numbers."""
    kind = rng.randrange(14) if depth else 0
    if kind < 3:
        return (
            rng.choice(ATOMS)
            if rng.random() < 0.8
            else repr(rng.choice([rng.random(), rng.randrange(10**6)]))
        )
    if kind < 8:
        return random_text(rng, depth - 1) + rng.choice(OPERATORS) + random_text(rng, depth - 1)
    text = random_text(rng, depth - 1)
    if kind == 8:
        return rng.choice("-+") + text
    if kind == 9:
        return f"{rng.choice(CALLS)}({text})"
    if kind == 10:
        return f"({text}){rng.choice(['**', '^'])}{rng.choice(EXPONENTS)}"
    if kind == 11:
        return f"({text})/({random_text(rng, depth - 1)})"
    if kind == 12:
        return rng.choice("+*").join([f"({text})"] * rng.randrange(2, 12))
    nested = rng.randrange(1, 70)
    return "(" * nested + text + ")" * nested


def damaged(rng, text):
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(text) + 1)
        text = text[:place] + rng.choice(DAMAGE + ATOMS) + text[place + rng.randrange(3) :]
    return text


def random_case(rng):
    """One in ten is a list of roots."""
    roots = rng.random() < 0.1
    text = random_text(rng, 3 if roots else 4)
    if roots:
        others = [random_text(rng, 2) for _ in range(rng.randrange(4))]
        text = rng.choice([", ", ",", " ", ";", " ; ", "  "]).join([text, *others])
    return (check_roots if roots else check_text), damaged(
        rng, text
    ) if rng.random() < 0.4 else text


def hunt(seed):
    """Check a thousand texts; return how many were accepted, the slowest, and what failed."""
    warm()
    rng, failures, accepted, slowest = random.Random(seed), [], 0, (0.0, "")
    for _ in range(PIECE):
        check, text = random_case(rng)
        start = time.process_time()
        try:
            accepted += check(text)
        except Exception:  # whatever it is, it is found
            failures.append((check.__name__, text, traceback.format_exc(limit=-3)))
        slowest = max(slowest, (time.process_time() - start, text))
    return seed, accepted, slowest, failures


def shortened(told):
    return "\n".join(line if len(line) < 300 else line[:300] + " ..." for line in told.splitlines())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    asked = parser.parse_args()
    pieces = -(-asked.count // PIECE)
    seeds = [f"{asked.seed}/{piece}" for piece in range(pieces)]
    done, read, worst, found = 0, 0, (0.0, ""), 0
    # No executor with max_tasks_per_child: in Python 3.11 it may wait for a process for ever.
    with get_context("spawn").Pool(asked.processes, maxtasksperchild=20) as pool:
        for seed, accepted, slowest, failures in pool.imap_unordered(hunt, seeds):
            done, read = done + PIECE, read + accepted
            worst, found = max(worst, slowest), found + len(failures)
            for name, text, told in failures:
                print(f"seed {seed}: {name}({text!r})\n{shortened(told)}", flush=True)
            if done % 20_000 == 0 and done < PIECE * pieces:
                print(f"{done} texts, {read} accepted, {found} findings")
    seconds, text = worst
    print(f"{done} texts, {read} accepted, {found} findings, slowest {seconds:.2f} s: {text!r}")
    return min(found, 1)


if __name__ == "__main__":
    raise SystemExit(main())
