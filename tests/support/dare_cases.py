"""Published discrete-time Riccati equations, as numbers.

DAREX: J. Abels and P. Benner, "DAREX - A Collection of Benchmark Examples for Discrete-Time
Algebraic Riccati Equations (Version 2.0)", SLICOT Working Note 1999-16, with its numbering and
default parameters; it extends P. Benner, A. J. Laub, V. Mehrmann, "A Collection of Benchmark
Examples for the Numerical Solution of Algebraic Riccati Equations II: Discrete-Time Case", SPC
95_23, TU Chemnitz-Zwickau, 1995. SciPy: the real cases of scipy.linalg's tests of
solve_discrete_are, most of which are from the 1995 report.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Case:
    """A, B, R_1, R_2, R_12 (Q, R and S in the collection) and, where it is known, the solution."""

    name: str
    A: object
    B: object
    R_1: object
    R_2: object
    R_12: object = None
    P: object = None

    @property
    def weights(self):
        return self.R_1, self.R_2, self.R_12


def _mirror():
    return np.eye(3) - 2 / 3 * np.ones((3, 3))


def _paper_machine():
    """DAREX 1.12: a paper machine with disturbances, 13 states."""
    A = np.zeros((13, 13))
    A[range(10), range(1, 11)] = 1.0
    A[5, 6] = A[7, 8] = 0.0
    A[11, 11] = A[12, 12] = 1.0
    A[11, 0], A[12, 0] = -3.318, -1.5484
    A[5, 5], A[7, 6], A[12, 6], A[7, 7] = 0.7788, -0.4724, 0.3981, 1.3746
    A[12, 7], A[12, 8], A[10, 10] = 0.5113, 5.7865, 0.8071
    B = np.zeros((13, 2))
    B[5, 0] = B[7, 1] = 1.0
    C = np.zeros((4, 13))
    C[0, 0], C[1, 0], C[1, 6], C[1, 7], C[1, 8] = 3.318, 1.5484, -0.3981, -0.5113, -5.7865
    C[2, 11] = C[3, 12] = 1.0
    return A, B, C.T @ np.diag([0.5, 5.0, 0.5, 5.0]) @ C, np.diag([400.0, 700.0])


def _delays():
    """DAREX 2.5: process control of a paper machine, tau = 1e8, D = K = 1, r = 0.25."""
    share, r = 1e-8, 0.25
    alpha, beta = 1 - share, share
    A = np.eye(4, k=-1)
    A[0, 0] = alpha
    t = r * (alpha**2 - 1) + beta**2
    X = np.diag([(t + np.sqrt(t**2 + 4 * beta**2 * r)) / (2 * beta**2), 1.0, 1.0, 1.0])
    return A, [[beta], [0.0], [0.0], [0.0]], np.diag([0.0, 0, 0, 1]), [[r]], None, X


DAREX = (
    Case("1.1, R = 0", [[2, -1], [1, 0]], [[1], [0]], [[0, 0], [0, 1]], [[0]], None, np.eye(2)),
    Case(
        "1.2, R singular, S nonzero, indefinite",
        [[0, 1], [0, -1]],
        [[1, 0], [2, 1]],
        np.array([[-4, -4], [-4, 7]]) / 11,
        [[9, 3], [3, 1]],
        [[3, 1], [-1, 7]],
    ),
    Case(
        "1.3",
        [[0, 1], [0, 0]],
        [[0], [1]],
        [[1, 2], [2, 4]],
        [[1]],
        None,
        [[1, 2], [2, 2 + np.sqrt(5)]],
    ),
    # The collection prints P = diag(1e5, 1e3, 0), which solves the equation for Q_33 = -0.1; with
    # its Q_33 = -10 the last entry is Q_33 + 0.01^2 * 1e3 = -9.9.
    Case(
        "1.4, R singular, Q indefinite",
        [[0, 0.1, 0], [0, 0, 0.01], [0, 0, 0]],
        [[1, 0], [0, 0], [0, 1]],
        np.diag([1e5, 1e3, -10]),
        np.diag([0, 1]),
        None,
        np.diag([1e5, 1e3, -9.9]),
    ),
    Case(
        "1.5, satellite",
        [[0.998, 0.067, 0, 0], [-0.067, 0.998, 0, 0], [0, 0, 0.998, 0.153], [0, 0, -0.153, 0.998]],
        [[0.0033, 0.02], [0.1, -0.0007], [0.04, 0.0073], [-0.0028, 0.1]],
        [[1.87, 0, 0, -0.244], [0, 0.744, 0.205, 0], [0, 0.205, 0.589, 0], [-0.244, 0, 0, 1.048]],
        np.eye(2),
    ),
    Case(
        "1.9, S nonzero",
        np.kron(np.eye(2), np.eye(3, k=1)),
        [[0, 0], [0, 0], [1, 0], [0, 0], [0, 0], [0, 1]],
        np.kron(np.diag([1, 0]), [[1, 1, 0], [1, 1, 0], [0, 0, 0]])
        + np.kron(np.diag([0, 1]), [[1, -1, 0], [-1, 1, 0], [0, 0, 0]]),
        np.diag([3, 1]),
        [[1, 0], [1, 0], [0, 0], [1, 0], [-1, 0], [0, 0]],
    ),
    Case("1.12, paper machine", *_paper_machine()),
    Case(
        "2.1, R = 1e6, an uncontrollable and unobservable mode",
        [[4, 3], [-4.5, -3.5]],
        [[1], [-1]],
        [[9, 6], [6, 4]],
        [[1e6]],
        None,
        (1 + np.sqrt(1 + 4e6)) / 2 * np.array([[9, 6], [6, 4]]),
    ),
    Case(
        "2.2, condition of R 9e12",
        np.diag([0.9512, 0.9048]),
        [[4.877, 4.877], [-1.1895, 3.569]],
        np.diag([0.005, 0.02]),
        np.diag([1 / 3e6, 3e6]),
    ),
    Case(
        "2.3, badly scaled A",
        [[0, 1e6], [0, 0]],
        [[0], [1]],
        np.eye(2),
        [[1]],
        None,
        np.diag([1, 1 + 1e12]),
    ),
    Case(
        "2.4, badly scaled weights",
        _mirror() @ np.diag([0, 1, 3]) @ _mirror(),
        np.eye(3),
        1e6 * np.eye(3),
        1e6 * np.eye(3),
        None,
        1e6 * _mirror() @ np.diag([1, (1 + np.sqrt(5)) / 2, (9 + np.sqrt(85)) / 2]) @ _mirror(),
    ),
    Case("2.5, a pole 2e-8 from the circle", *_delays()),
    Case(
        "4.1, n = 100",
        np.eye(100, k=1),
        np.eye(100)[:, [99]],
        np.eye(100),
        [[1]],
        None,
        np.diag(np.arange(1.0, 101)),
    ),
)

SCIPY = (
    Case(
        "gh-2251",
        [
            [0.63399379, 0.54906824, 0.76253406],
            [0.5404729, 0.53745766, 0.08731853],
            [0.27524045, 0.84922129, 0.4681622],
        ],
        [[0.96861695], [0.05532739], [0.78934047]],
        np.eye(3),
        np.eye(1),
    ),
    Case("darex 1 of 1995", [[4, 3], [-4.5, -3.5]], [[1], [-1]], [[9, 6], [6, 4]], [[1]]),
    Case(
        "darex 2 of 1995",
        np.diag([0.9512, 0.9048]),
        [[4.877, 4.877], [-1.1895, 3.569]],
        np.diag([0.005, 0.02]),
        np.diag([1 / 3, 3]),
    ),
    Case(
        "darex 4 of 1995 without S, R singular, indefinite",
        [[0, 1], [0, -1]],
        [[1, 0], [2, 1]],
        np.array([[-4, -4], [-4, 7]]) / 11,
        [[9, 3], [3, 1]],
    ),
    Case(
        "darex 7 of 1995, a slow and a fast part",
        [
            [0.98475, -0.079903, 0.0009054, -0.0010765],
            [0.041588, 0.99899, -0.035855, 0.012684],
            [-0.54662, 0.044916, -0.32991, 0.19318],
            [2.6624, -0.10045, -0.92455, -0.26325],
        ],
        [
            [0.0037112, 0.0007361],
            [-0.087051, 9.3411e-6],
            [-1.19844, -4.1378e-4],
            [-3.1927, 9.2535e-4],
        ],
        0.01 * np.eye(4),
        np.eye(2),
    ),
    Case(
        "darex 8 of 1995",
        [
            [-0.6, -2.2, -3.6, -5.400018],
            [1.0, 0.6, 0.8, 3.399982],
            [0.0, 1.0, 1.8, 3.799982],
            [0.0, 0.0, 0.0, -0.999982],
        ],
        [[1, -1, -1, -1], [0, 1, -1, -1], [0, 0, 1, -1], [0, 0, 0, 1]],
        [[2, 1, 3, 6], [1, 2, 2, 5], [3, 2, 6, 11], [6, 5, 11, 22]],
        np.eye(4),
    ),
    Case(
        "darex 9 of 1995, chemical plant",
        0.01
        * np.array(
            [
                [95.407, 1.9643, 0.3597, 0.0673, 0.019],
                [40.849, 41.317, 16.084, 4.4679, 1.1971],
                [12.217, 26.326, 36.149, 15.93, 12.383],
                [4.1118, 12.858, 27.209, 21.442, 40.976],
                [0.1305, 0.5808, 1.875, 3.6162, 94.28],
            ]
        ),
        0.01
        * np.array(
            [
                [0.0434, -0.0122],
                [2.6606, -1.0453],
                [3.753, -5.51],
                [3.6076, -6.6],
                [0.4617, -0.9148],
            ]
        ),
        np.eye(5),
        np.eye(2),
    ),
)
