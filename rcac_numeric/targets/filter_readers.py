"""Discrete-time systems of other libraries, read exactly as transfer functions or matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy import Matrix, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.polynomials.poly import canonical
from compensator_theory.systems.state_space import transfer_matrix_of_realisation


def read_filter(filter: Any) -> exact.TransferFunction | exact.TransferMatrix:
    """A filter as an exact transfer function, or matrix where it has several inputs or outputs.

    Parameters
    ----------
    filter : python-control or scipy.signal system, or what `transfer_function` reads
        Floats mean their shortest decimals.

    Raises
    ------
    InputError
        If the system runs in continuous time, says nothing about time, or is not rational.

    Examples
    --------
    >>> import scipy.signal
    >>> from rcac_numeric.targets.filter_readers import read_filter
    >>> print(read_filter(scipy.signal.dlti([2.0], [1.0, -0.5])))
    (2)/(q - 1/2)
    """
    if isinstance(filter, exact.TransferMatrix):
        return _scalar_if_possible(filter)
    library = type(filter).__module__.split(".")[0]
    if library == "control":
        return _scalar_if_possible(_from_control(filter))
    if library == "scipy":
        return _scalar_if_possible(_from_scipy(filter))
    return exact.transfer_function(filter)


def _from_control(system: Any) -> exact.TransferMatrix:
    if getattr(system, "dt", None) is None:
        raise InputError(
            f"the {type(system).__name__} does not say whether it runs in discrete time; give it "
            "a sample time, or dt=True."
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
    from scipy.signal import dlti, lti  # half a second of import time, paid only here

    if isinstance(system, lti):
        raise _continuous(system)
    if not isinstance(system, dlti):
        raise InputError(f"a {type(system).__name__} of SciPy is not a filter; give a dlti.")
    if hasattr(system, "A"):
        return _from_state_space(system)
    if hasattr(system, "num"):
        numerators = system.num if system.num.ndim == 2 else [system.num]
        return _from_quotients([[(numerator, system.den)] for numerator in numerators])
    G = exact.transfer_function(
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
    """Numerators over the least common multiple of all denominators."""
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
