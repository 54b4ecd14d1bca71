"""Exact SISO transfer functions from any description."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from sympy import Poly, Symbol

from compensator_theory.errors import Advice, InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._from_roots import polynomial_from_roots
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import scaled, sides_in
from compensator_theory.polynomials._quotients import Quotient
from compensator_theory.polynomials._reading import (
    PolynomialLike,
    in_one_variable,
    polynomial,
)
from compensator_theory.polynomials._variables import (
    as_symbol,
    evident_variable,
    require_no_other_operator,
)
from compensator_theory.systems._descriptions import Description, read_system, realised
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._foreign import ForeignSystem
from compensator_theory.systems._kinds import Pair, Roots, Rows, States
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import sampled_every
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

TransferFunctionLike: TypeAlias = (
    TransferFunction
    | TransferMatrix
    | Realisation
    | DescriptorSystem
    | PolynomialLike
    | tuple[PolynomialLike, PolynomialLike]
    | tuple[MatrixLike, MatrixLike, MatrixLike]
    | tuple[MatrixLike, MatrixLike, MatrixLike, MatrixLike]
    | Mapping[str, object]
    | ForeignSystem
)
"""Input types of :func:`transfer_function`."""


@holds_where_defined
@roots_in_sympy()
@carrying()
def transfer_function(
    obj: TransferFunctionLike | None = None,
    variable: str | Symbol | None = None,
    *,
    zeros: Iterable[NumberLike] | None = None,
    poles: Iterable[NumberLike] | None = None,
    gain: NumberLike | None = None,
    sample_time: NumberLike | None = None,
) -> TransferFunction:
    """Return the rational transfer function of any description."""
    if obj is None:
        obj = Roots(zeros, poles, gain)
    elif not (zeros is None and poles is None and gain is None):
        raise InputError("give either a transfer function or zeros, poles and gain, not both")
    contents = scalar_of(read_system(obj, variable), variable)
    return contents if sample_time is None else sampled_every(contents, sample_time)


def scalar_of(source: Description, variable: str | Symbol | None) -> TransferFunction:
    """Return the transfer function of a description."""
    match source:
        case TransferFunction():
            return _in_variable(source, variable)
        case TransferMatrix():
            return _in_variable(source.scalar(), variable)
        case Realisation() | DescriptorSystem():
            G = source.transfer_function() if source.is_siso else source.transfer_matrix().scalar()
            return _in_variable(G, variable)
        case States():
            return scalar_of(realised(source, variable), None)
        case Quotient():
            return _from_quotient(source, variable)
        case Poly():
            return TransferFunction(polynomial(source, variable), polynomial(1, source.gen))
        case Pair(numerator, denominator, letter, period):
            symbol = variable if letter is None else letter
            top, bottom = in_one_variable(numerator, denominator, variable=symbol)
            return TransferFunction(top, bottom, sample_time=period)
        case Roots():
            return _from_roots(source, variable)
        case Rows():
            return scalar_of(read_system(_only_entry(source), variable), variable)
    raise AssertionError(source)


def _only_entry(rows: Rows) -> Any:
    if rows.shape != (1, 1):
        outputs, inputs = rows.shape
        raise InputError(
            f"a transfer matrix of {outputs} outputs and {inputs} inputs is not scalar; give one "
            "entry of it, ",
            Advice(
                "transfer_function",
                (("obj", "([1], [1, 2])"),),
                "and lists of coefficients as a tuple, {obj}",
            ),
        )
    return rows.entries[0][0]


def _from_roots(source: Roots, variable: str | Symbol | None) -> TransferFunction:
    if source.poles is None:
        raise InputError("give a transfer function, or at least its poles")
    if (variable := variable if source.variable is None else source.variable) is None:
        raise InputError(
            "zeros and poles do not show the variable; name it, as in transfer_function(zeros=z, "
            "poles=p, gain=k, variable='s')"
        )
    symbol = as_symbol(variable)
    numerator = polynomial_from_roots(() if source.zeros is None else source.zeros, symbol)
    numerator = scaled(numerator, exact_number(1 if source.gain is None else source.gain))
    denominator = polynomial_from_roots(source.poles, symbol)
    return TransferFunction(numerator, denominator, sample_time=source.sample_time)


def _from_quotient(quotient: Quotient, variable: str | Symbol | None) -> TransferFunction:
    if variable is not None:
        sides = sides_in(quotient, as_symbol(variable))
        require_no_other_operator(*sides)
        return TransferFunction(*sides)
    symbol = evident_variable(quotient.free_symbols, "the transfer function")
    return TransferFunction(*sides_in(quotient, symbol))


def _in_variable(G: TransferFunction, variable: str | Symbol | None) -> TransferFunction:
    if variable is None or as_symbol(variable) == G.variable:
        return G
    raise InputError(
        f"{G} is a transfer function in {G.variable}, not in {variable}; build it in {variable}"
    )
