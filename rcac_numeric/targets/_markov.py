"""Markov parameters of G_zu, and the FIR target model that is a truncation of its series."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sympy import QQ, Matrix
from sympy.polys.matrices import DomainMatrix

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.systems._descriptions import is_description
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, real_array, rounded
from rcac_numeric.plants._foreign import linear_plant, plant_of
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel


def markov_parameters(G: Any, count: int, *, variable: str | None = None) -> Array:
    """The Markov parameters H_0, ..., H_(count - 1) of G_zu, (2.52), each rounded once.

    H_0 = E_2,  H_i = E_1 A^(i-1) B

    Parameters
    ----------
    G : Plant, or anything that `plant_of` reads
        Any numbers of signals; of a plant it is G_zu.
    count : int
        How many; the first is H_0 = G(oo).
    variable : {"z", "q"}, optional
        Of lists of coefficients and matrices, which do not show it.

    Returns
    -------
    array, shape (count, l_z, l_u)
        An entry is zero here if and only if it is zero for the shortest decimals of the plant's
        entries (or below the range of float64), so the relative degree can be read off.

    Raises
    ------
    InputError
        If count is no positive integer, or a parameter exceeds the range of float64.

    Notes
    -----
    `compensator_theory.markov_parameters` has them exactly, of a scalar G, with symbols too.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.targets import markov_parameters
    >>> markov_parameters(standard_plant("1/(q - 0.1)"), count=4).ravel()
    array([0.  , 1.  , 0.1 , 0.01])
    """
    integer(count, "count", at_least=1, at_most=10_001)
    plant = linear_plant(G if variable is None else plant_of(G, variable=variable))
    parameters = _exact_parameters(plant, count - 1)
    entries = [entry for H in parameters for entry in H]
    return rounded(entries, "the Markov parameters").reshape(-1, plant.l_z, plant.l_u)


def markov_target(source: Plant | ArrayLike, n_bar: int | None = None) -> TargetModel:
    """The Markov-parameter target model of section 2.4.5, a truncation of (2.51).

    G_f(q) = sum of H_i q^{-i} for i = d_zu, ..., n_bar

    Its zeros approximate those NMP zeros of G_zu whose modulus exceeds the spectral radius of A,
    where the series converges, and only those: the error of a simple zero shrinks like (spectral
    radius / modulus)^n_bar, while an NMP zero within that radius has no counterpart in G_f. The
    other zeros of G_f gather around the circle of the spectral radius. If A is not asymptotically
    stable they look like NMP zeros that G_zu does not have; with a pole at 1 (example 4.2,
    n_bar = 120) 117 of them lie outside the unit circle.

    Parameters
    ----------
    source : Plant, or array of shape (number of parameters, l_z, l_u)
        The parameters, H_0 first; a 1-D array stands for scalar z and u. Leading parameters that
        are zero must be exactly zero; estimates come with `IdentifiedMarkovParameters.cleared`.
    n_bar : int, optional
        Index of the last parameter that is kept; needed for a plant. By default
        all of an array are kept.

    Raises
    ------
    InputError
        If every parameter up to n_bar is zero (n_bar < d_zu), or n_bar is missing or beyond the
        array.

    Notes
    -----
    (2.51) prints E_1 (zI - A)^{-1} B for G_zu and leaves out E_2, which H_0 counts.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.targets import markov_target
    >>> plant = standard_plant("(q - 2)/(q*(q - 0.5))")
    >>> zeros = np.roots(markov_target(plant, n_bar=20).numerator[1:, 0, 0])
    >>> float(abs(zeros).max().round(6))
    2.0
    """
    if is_description(source) and not isinstance(source, list | tuple | np.ndarray):
        source = linear_plant(source)
    if isinstance(source, Plant):
        if n_bar is None:
            raise InputError("n_bar is needed to truncate a plant's Markov parameters.")
        H = markov_parameters(source, integer(n_bar, "n_bar", at_most=10_000) + 1)
        parameters = _require_nonzero(H, source)
        scalar = parameters.shape[1:] == (1, 1)
        return TargetModel(parameters, exact=_scalar_filter(source, n_bar) if scalar else None)
    H = real_array(source, "the Markov parameters")
    H = H.reshape(-1, 1, 1) if H.ndim == 1 else H
    if H.ndim != 3 or H.size == 0:
        raise InputError(
            f"the Markov parameters have shape {H.shape}; (n_bar + 1, l_z, l_u) is needed, H_0 "
            "first."
        )
    last = len(H) - 1 if n_bar is None else integer(n_bar, "n_bar")
    if last >= len(H):
        raise InputError(f"n_bar = {last}, but the last Markov parameter given is H_{len(H) - 1}.")
    return TargetModel(_require_nonzero(H[: last + 1], H))


def _require_nonzero(H: Array, source: Plant | Array) -> Array:
    if H.any():
        return H
    further = source if isinstance(source, np.ndarray) else markov_parameters(source, source.n + 1)
    if not further.any():
        raise InputError("every Markov parameter is zero, so the control does not act on z.")
    d_zu = int(np.flatnonzero(further.any(axis=(1, 2)))[0])
    raise InputError(
        f"n_bar = {len(H) - 1} is below the relative degree d_zu = {d_zu}, so that no nonzero "
        f"Markov parameter is left. Use n_bar > {d_zu}."
    )


def _exact_parameters(plant: Plant, n_bar: int) -> list[Matrix]:
    """Return the Markov parameters by x_1 = B, x_(i+1) = A x_i, over the rationals."""
    problem = plant.problem
    A, x, E_1 = (
        DomainMatrix.from_Matrix(m).convert_to(QQ).to_dense()
        for m in (problem.A, problem.B, problem.E_1)
    )
    parameters = [problem.E_2]
    for _ in range(n_bar):
        parameters.append((E_1 * x).to_Matrix())
        x = A * x
    return parameters


def _scalar_filter(plant: Plant, n_bar: int) -> exact.TransferFunction:
    coefficients = [H[0, 0] for H in _exact_parameters(plant, n_bar)]
    return exact.TransferFunction(
        exact.polynomial(coefficients, "q"), exact.polynomial([1] + [0] * n_bar, "q")
    )
