"""Target models from any filter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from sympy import Matrix, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.systems._conversions import transfer_function
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from rcac_numeric.arrays._validation import real_array, rounded
from rcac_numeric.targets._model import TargetModel, from_transfer_function, require_causal


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
    """Whether a value is one polynomial, such as a string or a SymPy object."""
    is_polynomial = in_our_order(part) is not part  # of NumPy or flint, which are in q
    return isinstance(part, str) or hasattr(part, "free_symbols") or is_polynomial


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
    """Return the target with rows in lowest terms: D_f = diag(d_1, ..., d_l), rounded once."""
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


# Discrete-time systems of other libraries, read exactly as transfer functions or matrices.


def read_filter(filter: Any) -> exact.TransferFunction | exact.TransferMatrix:
    """Read a filter as an exact transfer function or transfer matrix."""
    if isinstance(filter, exact.TransferMatrix):
        return _scalar_if_possible(filter)
    library = type(filter).__module__.split(".")[0]
    if library == "control":
        return _scalar_if_possible(_from_control(filter))
    if library == "scipy":
        return _scalar_if_possible(_from_scipy(filter))
    return transfer_function(filter)


def _from_control(system: Any) -> exact.TransferMatrix:
    if getattr(system, "dt", None) is None:
        raise InputError(
            f"the {type(system).__name__} has no time domain; give it a sample time, or dt=True "
            f"for discrete time."
        )
    if system.isctime():
        raise _continuous(system)
    if hasattr(system, "A"):
        return _from_state_space(system)
    if not hasattr(system, "num"):
        raise InputError(
            f"a {type(system).__name__} has no transfer function; give a TransferFunction or a "
            "StateSpace."
        )
    rows, columns = range(system.noutputs), range(system.ninputs)
    return _from_quotients([[(system.num[i][j], system.den[i][j]) for j in columns] for i in rows])


def _from_scipy(system: Any) -> exact.TransferMatrix:
    from scipy.signal import dlti, lti  # imported here: it takes 0.5 s

    if isinstance(system, lti):
        raise _continuous(system)
    if not isinstance(system, dlti):
        raise InputError(f"a {type(system).__name__} of SciPy is not a filter; give a dlti.")
    if hasattr(system, "A"):
        return _from_state_space(system)
    if hasattr(system, "num"):
        numerators = system.num if system.num.ndim == 2 else [system.num]
        return _from_quotients([[(numerator, system.den)] for numerator in numerators])
    G = transfer_function(
        zeros=list(system.zeros), poles=list(system.poles), gain=system.gain, variable="q"
    )
    return exact.TransferMatrix(((G.numerator,),), G.denominator)


def _from_state_space(system: Any) -> exact.TransferMatrix:
    A, B, C, D = (
        Matrix(*m.shape, [exact.exact_number(entry) for entry in m.ravel()])
        for m in (system.A, system.B, system.C, system.D)
    )
    return transfer_matrix_of_realisation(A, B, C, D, Symbol("q"))


def _from_quotients(entries: Sequence[Sequence[tuple[Any, Any]]]) -> exact.TransferMatrix:
    """Return the matrix of numerators over the least common denominator."""
    quotients = [
        [exact.TransferFunction(*(exact.polynomial(list(p), "q") for p in pair)) for pair in row]
        for row in entries
    ]
    common = quotients[0][0].denominator
    for G in (G for row in quotients for G in row):
        common = canonical(common.lcm(G.denominator))
    return exact.TransferMatrix(
        tuple(tuple(G.numerator * common.exquo(G.denominator) for G in row) for row in quotients),
        common,
    )


def _scalar_if_possible(
    matrix: exact.TransferMatrix,
) -> exact.TransferFunction | exact.TransferMatrix:
    return matrix.scalar() if matrix.shape == (1, 1) else matrix


def _continuous(system: Any) -> InputError:
    return InputError(
        f"the {type(system).__name__} runs in continuous time; RCAC runs in discrete time. "
        "Discretise it first, for example with control.c2d or scipy.signal.cont2discrete."
    )
