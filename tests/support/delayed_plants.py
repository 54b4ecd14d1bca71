"""Random plants whose inputs act after different numbers of steps."""

import numpy as np

from rcac_numeric import Plant


def decimals(rng, shape, sparse):
    """Entries of one decimal up to 1.5, some of them zero."""
    return rng.integers(-15, 16, shape) / 10 * (rng.random(shape) >= sparse)


def delayed_plant(rng):
    """n <= 3 states, two or three inputs, each delayed by 0 to 3 steps, entries of one decimal."""
    n, l_u, l_y = (int(rng.integers(low, 4)) for low in (1, 2, 1))
    sparse = rng.choice([0.0, 0.3, 0.6])
    A, B, C = (decimals(rng, shape, sparse) for shape in ((n, n), (n, l_u), (l_y, n)))
    E = C if rng.random() < 0.5 else decimals(rng, (int(rng.integers(1, 3)), n), sparse)
    delays = rng.integers(0, 4, l_u)
    order = n + int(delays.sum())
    A_d, B_d = np.zeros((order, order)), np.zeros((order, l_u))
    A_d[:n, :n], first = A, n
    for i, delay in enumerate(delays):
        if delay == 0:
            B_d[:n, i] = B[:, i]
            continue
        B_d[first, i] = 1.0
        A_d[first + 1 : first + delay, first : first + delay - 1] = np.eye(delay - 1)
        A_d[:n, first + delay - 1] = B[:, i]
        first += delay
    r, v = rng.choice([0.001, 0.01, 0.1, 1.0], 2)
    wide = [np.hstack([m, np.zeros((len(m), order - n))]) for m in (C, E)]
    drive = np.zeros((order, n))
    drive[:n] = np.eye(n) if rng.random() < 0.5 else decimals(rng, (n, n), 0.0)
    return Plant(
        A=A_d, B=B_d, C=wide[0],
        D_1=np.hstack([drive, np.zeros((order, l_y))]),
        D_2=np.hstack([np.zeros((l_y, n)), v * np.eye(l_y)]),
        E_1=np.vstack([wide[1], np.zeros((l_u, order))]),
        E_2=np.vstack([np.zeros((len(E), l_u)), r * np.eye(l_u)]),
    )  # fmt: skip
