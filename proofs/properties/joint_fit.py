"""What the joint fit of theta and D_f cannot decide, for scalar signals."""

from hypothesis import strategies as st
from sympy import Matrix, zeros

from compensator_theory.matrices._linear_algebra import rank

from ..ledger.checks import for_all

Coefficients = list[int]
STEPS = 10
NUMERATORS = st.lists(st.integers(-3, 3), min_size=1, max_size=4).filter(lambda c: c[-1] != 0)
SIGNALS = st.lists(st.integers(-3, 3), min_size=STEPS, max_size=STEPS)


def dimension(N_f: Coefficients, n_c: int, n_d: int) -> int:
    """Max(0, min(n_c, n_d - n_f)), N_f = c_1 q^-1 + ... + c_n_f q^-n_f."""
    return max(0, min(n_c, n_d - len(N_f)))


def operators(N_f: Coefficients, n_c: int, n_d: int) -> Matrix:
    """Coefficients of q^-1, q^-2, ... in N_f P, N_f Q and D_f - 1, for each entry of theta and d.

    What acts on u stands above what acts on y = z.
    """
    length = max(n_c + len(N_f), n_d)
    M = zeros(2 * length, 2 * n_c + n_d)
    for signal in range(2):
        for lag in range(n_c):
            for i, c in enumerate(N_f):
                M[signal * length + lag + i + 1, signal * n_c + lag] = c
    for lag in range(n_d):
        M[length + lag, 2 * n_c + lag] = 1
    return M


@for_all(N_f=NUMERATORS, n_c=st.integers(1, 4), n_d=st.integers(0, 6))
def null_dimension(N_f: Coefficients, n_c: int, n_d: int) -> bool:
    """The operators on unrelated u and y lose exactly max(0, min(n_c, n_d - n_f)) dimensions."""
    M = operators(N_f, n_c, n_d)
    return bool(M.cols - rank(M) == dimension(N_f, n_c, n_d))


@for_all(N_f=NUMERATORS, n_c=st.integers(1, 3), n_d=st.integers(1, 5), u=SIGNALS, y=SIGNALS)
def no_data_cure_it(N_f: Coefficients, n_c: int, n_d: int, u: list[int], y: list[int]) -> bool:
    """The regressor [Phi_f, z(k-1), ..., z(k-n_d)] of any record loses at least as many."""

    def at(x: list[int], k: int) -> int:
        return x[k] if k >= 0 else 0

    def row(k: int) -> list[int]:
        filtered = [
            sum(c * at(x, k - lag - i) for i, c in enumerate(N_f, 1))
            for x in (u, y)
            for lag in range(1, n_c + 1)
        ]
        return filtered + [at(y, k - lag) for lag in range(1, n_d + 1)]

    M = Matrix([row(k) for k in range(STEPS)])
    return bool(M.cols - rank(M) >= dimension(N_f, n_c, n_d))
