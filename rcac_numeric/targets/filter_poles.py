"""Whether a filter has a pole outside the unit circle: decided exactly."""

from __future__ import annotations

import numpy as np

import compensator_theory as exact_theory
from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array


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
        If there is such a pole; the message names the largest.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.targets.filter_poles import require_no_pole_outside
    >>> require_no_pole_outside(np.array([1.0, -1.0]).reshape(-1, 1, 1))
    """
    if not denominator[1:].any():
        return
    if exact is None:
        poles = _companion(denominator).characteristic_polynomial
    else:
        poles = exact.denominator
    count = exact_theory.locate_unit_disk_roots(poles).unstable
    if count:
        largest = max(exact_theory.certified_roots(poles), key=lambda root: abs(root.value))
        raise InputError(
            f"the target model has {count} pole{'s' * (count > 1)} outside the unit circle, the "
            f"largest at {largest}: the filtered regressor would grow without bound, and a loop "
            "that matched this target would be unstable. Use poles inside or on the unit circle; "
            "unstable poles of the plant do not belong in G_f."
        )


def _companion(denominator: Array) -> exact_theory.Realisation:
    """The block companion form, whose characteristic polynomial is q^(l n_f) det D_f(q)."""
    used = denominator[: int(np.flatnonzero(denominator.any(axis=(1, 2)))[-1]) + 1]
    size = used.shape[1]
    A = np.eye(size * (len(used) - 1), k=-size)
    A[:size] = np.hstack(list(-used[1:]))
    return exact_theory.Realisation(A, np.zeros((len(A), 1)), np.zeros((1, len(A))))
