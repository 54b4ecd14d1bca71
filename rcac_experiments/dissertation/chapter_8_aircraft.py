"""Chapter 8 as it is printed: the aircraft and its compensator."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rcac_experiments.dissertation._tables import example_table
from rcac_experiments.dissertation.chapter_3 import A_0, A_1, B_0, B_1
from rcac_numeric.arrays._array_types import Array

Facts = Iterator[tuple[str, bool]]
H = 0.001  # seconds
PRINTED = np.array(
    [
        [0.9999, 0.000269, -0.000963, -0.000039],
        [-0.1088, 1.00021, 0.000099, 0],
        [0.00041, 0.000037, 0.9973, 0],
        [0, 0.00100, -0.00042, 1.0000],
    ]
)
CHANGED = [(0, 3), (1, 1), (2, 2)]


def entries_of_8_85() -> Facts:
    """(8.85) compared with I + 0.001 A of (3.2)."""
    euler = np.eye(4) + H * A_1
    off = np.abs(PRINTED - euler) > 5e-5  # half a unit of the coarsest digit printed
    where = [(int(i), int(j)) for i, j in np.argwhere(off)]
    yield "(1,4), (2,2) and (3,3) are wrong and no others", where == CHANGED
    radius = float(np.abs(np.linalg.eigvals(PRINTED)).max())
    yield "as printed there is an eigenvalue of modulus above 1.0001", radius > 1.0001
    yield "(1,4) is +0.0000397", abs(euler[0, 3] - 0.0000397) < 1e-12
    yield "(2,2) is 1.0000218", abs(euler[1, 1] - 1.0000218) < 1e-12
    yield "(3,3) is 0.99973", abs(euler[2, 2] - 0.9997313) < 1e-12


def ramp_of_8_87() -> Facts:
    """(8.87) at its ends."""

    def printed(k: int) -> float:
        return -0.02560 - 1.6640e-6 * k

    yield "as printed it jumps to -0.0672 at k = 25000", abs(printed(25000) + 0.0672) < 1e-12
    yield "as printed it is -0.1504 and not -0.1088 at k = 75000", printed(75000) < -0.15
    yield "with k - 25000 it begins at -0.0256", abs(printed(0) + 0.0256) < 1e-12
    yield "with k - 25000 it ends at -0.1088", abs(printed(50000) + 0.1088) < 1e-12


def off_nominal_entries() -> Facts:
    """The (3,1) entries of (8.85) compared with those of (3.1) and (3.2)."""
    yield "0.00041 is 0.001 times the off-nominal 0.4107", abs(0.00041 - H * A_1[2, 0]) < 5e-6
    yield "and not the nominal 0.6160", abs(0.00041 - H * A_0[2, 0]) > 1e-4
    yield "-0.0000665 is the off-nominal entry of B", abs(-0.0000665 - H * B_1[2, 0]) < 1e-12
    yield "and not the nominal one", abs(-0.0000665 - H * B_0[2, 0]) > 1e-5


def sampling_period_of_8_88() -> Facts:
    """The entry (2,1) of (8.87), (8.88) for three sampling periods."""
    periods = {h: 1 - abs(h * A_0[1, 0] / -0.02560) for h in (0.1, 0.01, 0.001)}
    yield "it is h = 0.001 that gives -0.02560", abs(periods[0.001]) < 1e-9
    yield "neither 0.01 nor 0.1 does", min(abs(periods[0.1]), abs(periods[0.01])) > 1


def loop_without_command() -> Facts:
    """(8.101) from rest over 300 steps, with r = 0 and with r = 1 in both integrators."""
    loop, _, _ = _loop()

    def output(r: float) -> float:
        x = np.zeros(6)
        for _ in range(300):
            x = loop @ x + r * np.array([0.0, 0, 1, 0, 0, 1])
        return float(x[0])

    yield "as printed the loop stays at rest", output(0.0) == 0
    yield "with [0; 1] r the output comes to r", abs(output(1.0) - 1) < 1e-6


def block_of_8_102() -> Facts:
    """The spectrum of (8.102) with A_a + B_a K - F C_a, n = 2 and an integrator."""
    loop, regulator, observer = _loop()
    requested = np.concatenate([np.linalg.eigvals(regulator), np.linalg.eigvals(observer)])
    off = float(np.abs(np.poly(loop) - np.poly(requested)).max())
    yield "it is that of the regulator and of the observer", off < 1e-12
    yield "A + BK, of order 2, has other dimensions than F C_a", observer.shape != (2, 2)


def _loop() -> tuple[Array, Array, Array]:
    """The loop of a plant of order 2, its regulator matrix and its observer matrix."""
    A, C = np.array([[0.8, 0.3], [0.0, 0.5]]), np.array([[1.0, 0.0]])
    A_a = np.block([[A, np.zeros((2, 1))], [-C, np.ones((1, 1))]])
    B_a, C_a = np.array([[0.0], [1.0], [0.0]]), np.array([[1.0, 0.0, 0.0]])
    K, F = np.array([[-0.7, -0.6, 0.2]]), np.array([[0.4], [0.1], [-0.2]])
    regulator, observer = A_a + B_a @ K, A_a - F @ C_a
    loop = np.block([[A_a, B_a @ K], [F @ C_a, A_a + B_a @ K - F @ C_a]])
    return loop, regulator, observer


def gain_of_the_observer() -> Facts:
    """The error of an observer with its gain F, and with the input matrix in its place."""
    A, C = np.array([[1.2, 0.1], [0.0, 0.9]]), np.array([[1.0, 0.0]])
    F, B = np.array([[0.9], [0.1]]), np.array([[0.0], [1.0]])
    right, other = (np.abs(np.linalg.eigvals(A - gain @ C)).max() for gain in (F, B))
    yield "A - F C is stable with the gain of (8.99)", right < 1
    yield "with another matrix for B_c(k) it need not be", other > 1


def observer_of_8_7() -> Facts:
    """The one of the two examples with an observer, and the owner of figures 8.15 and 8.16."""
    full, output = (example_table(n) for n in ("8.6", "8.7"))
    yield "Figures 8.15 and 8.16 are of Example 8.7", "8.15 and 8.16" in str(output["source"])
    feedback = "output feedback" in str(output["title"])
    yield (
        "which is that of output feedback, and 8.6 that of full state",
        (feedback and "full-state" in str(full["title"])),
    )


def one_parameter() -> Facts:
    """The entries that the nominal and the off-nominal A of (8.85), (8.88) estimate: A_2,1."""
    changed = [(i, j) for i in range(4) for j in range(4) if (i, j) == (1, 0)]
    unknown = np.abs(A_1 - A_0) > 0
    yield "A_2,1 changes between the two", bool(unknown[1, 0])
    yield "its estimate is one number, so that l_u is 1 and not 4", len(changed) == 1
