"""Observer-based forms per second: all real regulator polynomials of one compensator.

Prints, for growing orders n, the number of forms, the forms per second in float64 (median of
several repetitions, exact characteristic polynomial and certified roots included) and beside it the
exact enumeration where it is affordable. Machines are noisy: read the orders of magnitude.

    python benchmarks/observer_forms.py [--repetitions 5] [--exact-up-to 4]
"""

import argparse
import random
import statistics
import time

from sympy import Rational

import rcac_numeric
from compensator_theory import observer_based_compensator, observer_forms, transfer_function


def loop_of_order(n, seed=0):
    """Return a plant and an observer-based compensator with 2n real closed-loop poles."""
    dice = random.Random(seed)
    poles = [Rational(-k, 2) for k in range(1, 2 * n + 1)]
    dice.shuffle(poles)
    plant = transfer_function(
        zeros=[Rational(dice.randint(-40, 40), 7) for _ in range(n - 1)],
        poles=[Rational(dice.randint(-20, 20), 3) for _ in range(n)], variable="s",
    )  # fmt: skip
    design = observer_based_compensator(plant, poles[:n], poles[n:])
    return design.plant, design.compensator


def seconds(run, repetitions):
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--exact-up-to", type=int, default=4)
    arguments = parser.parse_args()
    print(f"{'n':>2}{'forms':>8}{'float64 per s':>16}{'exact per s':>14}{'residual':>12}")
    for n in (2, 4, 6, 8):
        plant, compensator = loop_of_order(n)
        forms = rcac_numeric.observer_forms(plant, compensator)
        numeric = seconds(lambda p=plant, c=compensator: rcac_numeric.observer_forms(p, c),
                          arguments.repetitions)  # fmt: skip
        exact = "-"
        if n <= arguments.exact_up_to:
            duration = seconds(lambda p=plant, c=compensator: observer_forms(p, c), 1)
            exact = f"{len(forms) / duration:.0f}"
        print(
            f"{n:>2}{len(forms):>8}{len(forms) / numeric:>16.0f}{exact:>14}"
            f"{forms.residual.max():>12.1e}"
        )


if __name__ == "__main__":
    main()
