"""What supervision costs a step of `Controller`, as a ratio within one run.

Run with: python benchmarks/supervision.py [STEPS]

Two controllers with the same settings, one supervised by default and one not at all, take the same
measurements in turn, in blocks, in one process; the medians over rounds of the ratio of two
neighbouring blocks are printed, of the kernel's own step and of `Controller.step`, with the
quartiles. Processor time is counted, so that what else runs on the machine is not. theta of both is
compared at the end.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from rcac_numeric import UD, Controller, ControllerSettings, Supervision, TargetModel, iir

ORDERS = (4, 10, 16, 20, 32, 54)  # n_c; l_theta is twice that
ROUNDS = 60


def block(step, samples) -> float:
    """Seconds of processor time for one step of each sample."""
    before = time.process_time()
    for y in samples:
        step(y, y, None, None)
    return time.process_time() - before


def ratios(first: list[float], second: list[float]) -> str:
    """Median and quartiles of the ratios, in words."""
    low, middle, high = np.quantile(np.array(second) / np.array(first), (0.25, 0.5, 0.75))
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


def compared(n_c: int, steps: int) -> None:
    """One line of the table."""
    settings = ControllerSettings(
        structure=iir(n_c), target=TargetModel([0.0, 1.0]), update=UD(1e8)
    )
    off, on = Controller(settings, Supervision("off")), Controller(settings)
    rng = np.random.default_rng(n_c)
    times: dict[str, tuple[list[float], list[float]]] = {
        "kernel": ([], []), "Controller": ([], [])
    }  # fmt: skip
    for number in range(2 * ROUNDS):
        name = "kernel" if number % 2 else "Controller"
        samples = rng.standard_normal(steps).tolist()
        pair = [off, on] if number % 4 < 2 else [on, off]
        took = {
            one: block((one._kernel if name == "kernel" else one).step, samples) for one in pair
        }
        times[name][0].append(took[off])
        times[name][1].append(took[on])
    assert np.array_equal(off.theta, on.theta)
    microseconds = 1e6 * np.median(times["kernel"][0]) / steps
    print(
        f"l_theta {2 * n_c:4d}: kernel {ratios(*times['kernel'])}, Controller.step "
        f"{ratios(*times['Controller'])}; the kernel's step {microseconds:.2f} us"
    )


def main() -> None:
    """Print the table."""
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    print("supervised over not supervised, medians (quartiles)")
    for n_c in ORDERS:
        compared(n_c, steps)


if __name__ == "__main__":
    main()
