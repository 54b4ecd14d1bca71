"""A controller with missed samples and sensor jumps for a long time.

Run with: python benchmarks/gaps_and_jumps.py [STEPS]

A lag under noise; one sample in fifty is missed and one in a thousand is off by 1e6. Half-way the
state is saved and a second controller is restored from it, which must go on bit for bit; the counts
of the record are held against what was done.
"""

from __future__ import annotations

import sys

import numpy as np

from rcac_numeric import (
    UD,
    CappedForgetting,
    Controller,
    ControllerSettings,
    Supervision,
    fir_target,
    iir,
    standard_plant,
)


def main() -> None:
    """Drive it and print the record."""
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    plant = standard_plant("1/(q - 0.9)")
    settings = ControllerSettings(
        structure=iir(2), target=fir_target(plant), update=UD(1e-2, lambda_=CappedForgetting(0.999))
    )
    one, two = (Controller(settings, Supervision(jump=30)) for _ in range(2))
    rng = np.random.default_rng(7)
    noise, missing, jumping = (rng.random(steps) for _ in range(3))
    x, peak, missed, jumps = 0.0, 0.0, 0, 0
    for k in range(steps):
        y = x
        if k >= 100 and missing[k] < 0.02:
            y, missed = float("nan"), missed + 1
        elif k >= 100 and jumping[k] < 0.001:
            y, jumps = x + 1e6, jumps + 1
        if k == steps // 2:
            two.restore(one.state)
        (u,) = one.step(y, y)
        if k >= steps // 2 and two.step(y, y)[0] != u:
            raise AssertionError(f"step {k} differs after the restoration")
        x = 0.9 * x + float(u) + 0.3 * (noise[k] - 0.5)
        peak = max(peak, abs(x))
    troubles = one.record.troubles
    print(f"{steps} steps: largest abs(x) {peak:.3g}; {one.record}")
    print(
        f"done: {missed} missed, {jumps} jumps; noted: "
        f"{troubles['missed sample'].steps - jumps} and "
        f"{troubles['jump'].steps}; the restored one is the same: {one.state == two.state}"
    )


if __name__ == "__main__":
    main()
