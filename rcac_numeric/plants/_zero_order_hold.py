"""Sampling with a zero-order hold, each entry rounded once."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from flint import arb, arb_mat, fmpq
from numpy.typing import ArrayLike

from compensator_theory.errors import BudgetError, InputError
from compensator_theory.polynomials._ball_precision import at_growing_precision
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import matrix, number, real_array

# Precision of the balls in bits: first and largest; enough for a norm of h A of 1e150.
FEWEST_BITS, MOST_BITS = 256, 1 << 14


def zero_order_hold(A: ArrayLike, B: ArrayLike, h: float) -> tuple[Array, Array]:
    """A_D and B_D of x' = A x + B u with u constant over each period h.

    [ A_D  B_D ]         [ A  B ]
    [  0    I  ] = exp(h [ 0  0 ])

    Parameters
    ----------
    A, B : arrays, shapes (n, n) and (n, l_u), per second
    h : float
        Sampling period, s. Entries and h mean their shortest decimals.

    Returns
    -------
    A_D, B_D : arrays
        Each entry is the float64 nearest to the true one, but for ties within 2^-60 of it.

    Raises
    ------
    InputError
        If h is not positive, the sizes do not fit, or an entry of the exponential leaves float64,
        as of a mode that grows by more than exp(709) in a period. Modes that decay may be as fast
        as they like.

    Notes
    -----
    Ball arithmetic bounds the rounding error. Section 3.2.1 calls its
    matrices (3.3) and (3.4) an Euler discretisation; they are this one.

    Examples
    --------
    >>> from rcac_numeric.plants._zero_order_hold import zero_order_hold
    >>> A_D, B_D = zero_order_hold([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], h=0.1)
    >>> A_D.tolist(), B_D.ravel().tolist()
    ([[1.0, 0.1], [0.0, 1.0]], [0.005, 0.1])
    """
    A = matrix(A, "A", (None, None))
    n = len(A)
    A, B, h = matrix(A, "A", (n, n)), matrix(B, "B", (n, None)), number(h, "h")
    if not h > 0:
        raise InputError(f"h = {h:g} must be positive: it is the sampling period.")
    generator = np.zeros((n + B.shape[1], n + B.shape[1]))
    generator[:n, :n], generator[:n, n:] = A, B
    both = _exponential(generator, h)
    if both is None:
        size = h * float(np.abs(A).max())
        raise InputError(
            f"exp(h A) was not enclosed with {MOST_BITS} bits: h A has an entry of {size:.3g}. "
            "Scale the states to similar magnitude, or remove modes that are that much faster than "
            "the sampling."
        )
    if not np.isfinite(both).all():
        fastest = float(np.linalg.eigvals(A).real.max(initial=0.0))
        raise InputError(
            f"exp(h A) has entries beyond float64: the fastest growing mode of A is {fastest:.3g} "
            f"per second, and h = {h:g} s. Sample faster."
        )
    return real_array(both[:n, :n], "A_D"), real_array(both[:n, n:], "B_D")


def _exponential(generator: Array, h: float) -> Array | None:
    """Return exp(h generator), each entry rounded once; None if the balls stay too wide."""
    period = _decimal(h)
    rows = [[_decimal(entry) * period for entry in row] for row in generator.tolist()]

    def attempt(_: int) -> Array | None:
        exponential = arb_mat([[arb(entry) for entry in row] for row in rows]).exp()
        entries = [exponential[i, j] for i in range(len(rows)) for j in range(len(rows))]
        tiny = arb(2) ** -1100  # below float64: rounded to zero
        if not all(x.rel_accuracy_bits() > 113 or abs(x) < tiny for x in entries):
            return None
        values = [float(x.mid()) for x in entries]
        return np.reshape(np.array(values, dtype=np.float64), generator.shape)

    try:
        return at_growing_precision(attempt, FEWEST_BITS, "the exponential of h A", MOST_BITS)
    except BudgetError:
        return None


def _decimal(value: float) -> fmpq:
    exact = Fraction(repr(float(value)))
    return fmpq(exact.numerator, exact.denominator)
