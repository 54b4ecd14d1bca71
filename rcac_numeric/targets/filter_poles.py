"""Whether a filter has a pole outside the unit circle: decided exactly."""

from __future__ import annotations

from fractions import Fraction
from math import lcm

import flint
import numpy as np
from sympy import QQ, Poly, Symbol

import compensator_theory as exact_theory
from compensator_theory.errors import InputError
from compensator_theory.polynomials.budget import ask
from compensator_theory.roots.schur_cohn import has_root_outside
from rcac_numeric.arrays.array_types import Array

# Up to this degree the message says how many poles there are outside, and where the largest is.
NAMED = 200


def require_no_pole_outside(
    denominator: Array,
    exact: exact_theory.TransferFunction | exact_theory.TransferMatrix | None = None,
) -> None:
    """Refuse a filter D_f^{-1} N_f with a pole of modulus greater than 1.

    Phi_f of (2.40) would grow without bound, and a loop that matches the filter would be unstable.
    A pole on the circle is the user's to ask for. No tolerance is involved: the poles are those of
    `exact` where the denominator was rounded from it, else the roots of det D_f with the shortest
    decimals of its entries.

    Parameters
    ----------
    denominator : array, shape (n_f + 1, l_z, l_z)
        In powers of q^{-1}, the first coefficient being the identity.
    exact : TransferFunction or TransferMatrix, optional
        What the filter was rounded from: the roots of its denominator are the poles.

    Raises
    ------
    InputError
        If there is such a pole; the message names the largest, up to degree 200. BudgetError if
        l_z n_f is beyond the budget's degree.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.targets.filter_poles import require_no_pole_outside
    >>> require_no_pole_outside(np.array([1.0, -1.0]).reshape(-1, 1, 1))
    """
    if not denominator[1:].any():
        return
    poles = _determinant(denominator) if exact is None else exact.denominator
    if not has_root_outside(poles):
        return
    if poles.degree() > NAMED:
        found = "a pole outside the unit circle"
    else:
        count = exact_theory.locate_roots(poles, time="discrete").unstable
        largest = max(exact_theory.certified_roots(poles), key=lambda root: abs(root.value))
        found = f"{count} pole{'s' * (count > 1)} outside the unit circle, the largest at {largest}"
    raise InputError(
        f"the target model has {found}: the filtered regressor would grow without bound, and a "
        "loop that matched this target would be unstable. Use poles inside or on the unit circle; "
        "unstable poles of the plant do not belong in G_f."
    )


def _determinant(denominator: Array) -> Poly:
    """A multiple of q^(l n_f) det D_f(q) with integer coefficients, by fraction-free elimination.

    Raises
    ------
    BudgetError
        If the degree, or what the elimination writes down, is beyond the budget.
    """
    size, what = denominator.shape[1], "the denominator of the target model"
    degree = size * (len(denominator) - 1)
    ask("degree", degree, what)
    if (denominator * (1 - np.eye(size))).any():  # what the elimination writes down; 1 s at most
        ask("entries", size**3 * degree // 3, what)
    rows = [_integers(denominator[:, i]) for i in range(size)]
    previous = flint.fmpz_poly([1])
    for k in range(size - 1):
        # D_f(infinity) = I: every leading minor has its full degree, so that no pivot is zero.
        for i in range(k + 1, size):
            for j in range(k + 1, size):
                minor = rows[k][k] * rows[i][j] - rows[i][k] * rows[k][j]
                rows[i][j] = minor // previous
        previous = rows[k][k]
    coefficients = [int(c) for c in reversed(rows[-1][-1].coeffs())]
    return Poly(coefficients, Symbol("q"), domain=QQ)


def _integers(row: Array) -> list[flint.fmpz_poly]:
    """A row of D_f, shape (n_f + 1, l_z), times q^n_f and a common denominator of its decimals."""
    decimals = [[Fraction(repr(float(value))) for value in entry] for entry in row.T]
    common = lcm(*(value.denominator for entry in decimals for value in entry))
    return [flint.fmpz_poly([int(value * common) for value in entry[::-1]]) for entry in decimals]
