"""Any filter of the user's as a target model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import real_array, rounded
from rcac_numeric.targets.filter_readers import read_filter
from rcac_numeric.targets.model import TargetModel, from_transfer_function, require_causal


def target_model(filter: Any) -> TargetModel:
    """Any filter as a target model, scalar or matrix, FIR or IIR.

    Parameters
    ----------
    filter : str, expression, TransferFunction, TransferMatrix
        A quotient of polynomials in q.
    filter : python-control or scipy.signal system
        In discrete time, with any number of inputs and outputs. Each row of a transfer matrix is
        brought to lowest terms over its own denominator, so that D_f is diagonal; a scalar
        filter keeps the factors that it was given.
    filter : array, list of numbers or of l_z x l_u matrices, or a pair of those
        Coefficients of N_f, or of N_f and D_f, in ascending powers of q^{-1}, as in TargetModel.

    Raises
    ------
    ImproperError
        If the filter would use future values.
    InputError
        If it runs in continuous time, cannot be read, or has a pole outside the unit circle.

    Examples
    --------
    >>> from rcac_numeric import target_model
    >>> target_model("2/(q - 0.5)").numerator.ravel()
    array([0., 2.])
    >>> import control
    >>> G = control.tf([[[1.0], [2.0]]], [[[1.0, -0.5], [1.0, 0.0]]], dt=True)
    >>> matrix_filter = target_model(G)
    >>> matrix_filter.l_z, matrix_filter.l_u, matrix_filter.n_f
    (1, 2, 2)
    """
    if isinstance(filter, TargetModel):
        return filter
    if isinstance(filter, np.ndarray):
        return TargetModel(filter)
    if isinstance(filter, list | tuple) and not any(_is_expression(part) for part in filter):
        return _from_coefficients(filter)
    read = read_filter(filter)
    if isinstance(read, exact.TransferFunction):
        return from_transfer_function(read)
    return _from_matrix(read)


def _is_expression(part: Any) -> bool:
    """Whether it stands for a polynomial by itself, such as a string or a SymPy object."""
    return isinstance(part, str) or hasattr(part, "free_symbols")


def _from_coefficients(parts: Sequence[Any]) -> TargetModel:
    arrays = [real_array(part, f"entry {i} of the filter") for i, part in enumerate(parts)]
    dimensions = {array.ndim for array in arrays}
    if dimensions in ({0}, {2}) and len({array.shape for array in arrays}) == 1:
        return TargetModel(np.stack(arrays))
    if len(arrays) == 2 and dimensions <= {1, 3}:
        return TargetModel(arrays[0], arrays[1])
    raise InputError(
        f"the filter is a list of arrays of shapes {[array.shape for array in arrays]}; give "
        "numbers or l_z x l_u matrices, one for each power of q^{-1}, or the pair (numerator, "
        "denominator) of arrays of those."
    )


def _from_matrix(G: exact.TransferMatrix) -> TargetModel:
    """Rows in lowest terms: D_f = diag(d_1, ..., d_l), each rounded once."""
    l_z, l_u = G.shape
    rows, denominators = [], []
    common = G.denominator.one
    for row in G.numerators:
        shared = G.denominator
        for entry in row:
            shared = shared.gcd(entry)
        shared = shared.monic()
        denominators.append(G.denominator.exquo(shared))
        rows.append([entry.exquo(shared) for entry in row])
        for entry in rows[-1]:
            require_causal(exact.TransferFunction(entry, denominators[-1]))
        common = common.lcm(denominators[-1]).monic()
    order = max(d.degree() for d in denominators)
    N, D = np.zeros((order + 1, l_z, l_u)), np.zeros((order + 1, l_z, l_z))
    for i, d in enumerate(denominators):
        powers = range(d.degree(), -1, -1)
        D[: len(powers), i, i] = rounded([d.nth(k) for k in powers], "the denominator")
        for j, entry in enumerate(rows[i]):
            N[: len(powers), i, j] = rounded([entry.nth(k) for k in powers], "the numerator")
    over_common = tuple(
        tuple(entry * common.exquo(d) for entry in row)
        for row, d in zip(rows, denominators, strict=True)
    )
    return TargetModel(N, D, exact=exact.TransferMatrix(over_common, common))
