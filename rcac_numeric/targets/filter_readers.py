"""Discrete-time systems of other libraries, read exactly as transfer functions or matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from compensator_theory.errors import InputError

if TYPE_CHECKING:
    from compensator_theory import TransferFunction, TransferMatrix


def read_filter(filter: Any) -> TransferFunction | TransferMatrix:
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
    from compensator_theory import TransferMatrix, transfer_function

    if isinstance(filter, TransferMatrix):
        return _scalar_if_possible(filter)
    library = type(filter).__module__.split(".")[0]
    if library == "control":
        return _scalar_if_possible(_from_control(filter))
    if library == "scipy":
        return _scalar_if_possible(_from_scipy(filter))
    return transfer_function(filter)


def _from_control(system: Any) -> TransferMatrix:
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


def _from_scipy(system: Any) -> TransferMatrix:
    from scipy.signal import dlti, lti

    from compensator_theory import TransferMatrix, transfer_function

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
    return TransferMatrix(((G.numerator,),), G.denominator)


def _from_state_space(system: Any) -> TransferMatrix:
    from sympy import Matrix, symbols

    from compensator_theory import exact_number
    from compensator_theory.systems.state_space import transfer_matrix_of_realisation

    A, B, C, D = (
        Matrix(*m.shape, [exact_number(entry) for entry in m.ravel()])
        for m in (system.A, system.B, system.C, system.D)
    )
    return transfer_matrix_of_realisation(A, B, C, D, symbols("q"))


def _from_quotients(entries: Sequence[Sequence[tuple[Any, Any]]]) -> TransferMatrix:
    """Numerators over the least common multiple of all denominators."""
    from compensator_theory import TransferFunction, TransferMatrix, polynomial
    from compensator_theory.polynomials.poly import canonical

    quotients = [
        [TransferFunction(polynomial(list(n), "q"), polynomial(list(d), "q")) for n, d in row]
        for row in entries
    ]
    common = quotients[0][0].denominator
    for G in (G for row in quotients for G in row):
        common = canonical(common.lcm(G.denominator))
    return TransferMatrix(
        tuple(tuple(G.numerator * common.exquo(G.denominator) for G in row) for row in quotients),
        common,
    )


def _scalar_if_possible(matrix: TransferMatrix) -> TransferFunction | TransferMatrix:
    return matrix.scalar() if matrix.shape == (1, 1) else matrix


def _continuous(system: Any) -> InputError:
    return InputError(
        f"the {type(system).__name__} runs in continuous time; RCAC runs in discrete time. "
        "Discretise it first, for example with control.c2d or scipy.signal.cont2discrete."
    )
