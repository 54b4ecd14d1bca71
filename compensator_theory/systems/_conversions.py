"""Everything that describes a SISO transfer function, to an exact one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeAlias

from sympy import Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._expressions import read_text
from compensator_theory.polynomials._from_roots import polynomial_from_roots
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import scaled, sides_in
from compensator_theory.polynomials._quotients import Quotient, multiplied_out
from compensator_theory.polynomials._reading import (
    PolynomialLike,
    in_one_variable,
    polynomial,
)
from compensator_theory.polynomials._sympy_trees import tree_of
from compensator_theory.polynomials._variables import (
    as_symbol,
    evident_variable,
    require_no_other_operator,
)
from compensator_theory.systems._descriptions import Pair, Rows, States, described
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._foreign import (
    Contents,
    ForeignSystem,
    Fraction,
    Matrices,
    ZerosAndPoles,
    contents_of,
    is_foreign,
)
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
"""What :func:`transfer_function` reads."""


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
    r"""Make an exact transfer function out of any usual description.

    .. math:: G = \frac{N}{D} = k\,\frac{\prod_i (s - z_i)}{\prod_j (s - p_j)}

    Parameters
    ----------
    obj : TransferFunction, Realisation, DescriptorSystem, text, Expr, pair, matrices, mapping, ...
        A pair is a tuple (numerator, denominator), each of which :func:`polynomial` reads; matrices
        are (A, B, C) or (A, B, C, D), in which B and C may be one-dimensional and D = 0, and need
        the variable, or (A, B, C, D, dt). A list of one row of one entry is that entry. A mapping
        has the keys ``zeros``, ``poles``, ``gain``. Foreign systems are the transfer functions,
        state spaces and connections of python-control, SciPy and SymPy. Floats are read by their
        shortest decimal.
    variable : str or Symbol, optional
        Default: evident from the symbols; for python-control ``s`` or ``z`` from its time base.
        Where it is named, other letters are parameters, s, z and q too.
    zeros, poles : iterable, optional
        Exact roots, instead of `obj`; zeros default to none.
    gain : number, optional
        Leading coefficient of the numerator; default 1.
    sample_time : number, optional
        In seconds, in discrete time. What `obj` says of time has to agree: a system knows its
        variable and its sample time, where it has one.

    Returns
    -------
    TransferFunction
        A string, a pair and zeros with poles keep common factors; an expression comes as SymPy has
        already simplified it.

    Raises
    ------
    InputError
        If the description is incomplete, not scalar, not rational in the variable, or not finite,
        or its coefficients contain another of s, z and q.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> print(transfer_function("(q - 0.85)/((q - 0.8)*(q - 0.9))"))
    (q - 17/20)/(q**2 - 17*q/10 + 18/25)
    >>> print(transfer_function(([1, 2], [1, 0, "a"]), "s"))
    (s + 2)/(s**2 + a)
    >>> print(transfer_function(zeros=[-1], poles=["-2+1j", "-2-1j"], gain=3, variable="s"))
    (3*s + 3)/(s**2 + 4*s + 5)
    >>> print(transfer_function(([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]), "s"))
    (1)/(s**2 + 3*s + 2)
    >>> G = transfer_function("1/(z - 1)", sample_time="1/100")
    >>> G.time, (G * G).sample_time
    ('discrete', 1/100)
    """
    found = _read(obj, variable, zeros, poles, gain)
    return found if sample_time is None else sampled_every(found, sample_time)


def _read(
    obj: TransferFunctionLike | None,
    variable: str | Symbol | None,
    zeros: Iterable[NumberLike] | None,
    poles: Iterable[NumberLike] | None,
    gain: NumberLike | None,
) -> TransferFunction:
    if isinstance(obj, Mapping):
        unknown = sorted(map(str, set(obj) - {"zeros", "poles", "gain"}))
        if unknown:
            raise InputError(f"unknown keys {unknown}; a transfer function has zeros, poles, gain")
        return transfer_function(None, variable, **obj)
    if obj is None:
        return _from_roots(zeros, poles, gain, variable)
    if not (zeros is None and poles is None and gain is None):
        raise InputError("give either a transfer function or zeros, poles and gain, not both")
    obj = described(obj, variable)
    if isinstance(obj, States):
        obj = obj.realisation(variable)
    if isinstance(obj, Realisation | DescriptorSystem):
        obj = obj.transfer_function() if obj.is_siso else obj.transfer_matrix()
    if isinstance(obj, TransferMatrix):
        obj = obj.scalar()
    if isinstance(obj, TransferFunction):
        return _in_variable(obj, variable)
    if isinstance(obj, str):
        return _from_quotient(read_text(obj), variable)
    if isinstance(obj, Poly):
        return TransferFunction(polynomial(obj, variable), polynomial(1, obj.gen))
    if isinstance(obj, Rows):
        return transfer_function(_only_entry(obj), variable)
    if isinstance(obj, Pair):
        pair = in_one_variable(obj.numerator, obj.denominator, variable=variable)
        return TransferFunction(*pair)
    if is_foreign(obj):
        return _from_foreign(contents_of(obj, variable))
    tree = tree_of(exact_number(obj))
    return _from_quotient(multiplied_out(tree, least_denominators=True), variable)


def _only_entry(rows: Rows) -> Any:
    if rows.shape != (1, 1):
        outputs, inputs = rows.shape
        raise InputError(
            f"a transfer matrix of {outputs} outputs and {inputs} inputs is not scalar; give one "
            "entry of it, and lists of coefficients as a tuple, ([1], [1, 2])"
        )
    return rows.entries[0][0]


def _from_roots(
    zeros: Iterable[NumberLike] | None,
    poles: Iterable[NumberLike] | None,
    gain: NumberLike | None,
    variable: str | Symbol | None,
) -> TransferFunction:
    if poles is None:
        raise InputError("give a transfer function, or at least its poles")
    if variable is None:
        raise InputError(
            "zeros and poles do not show the variable; name it, as in transfer_function(zeros=z, "
            "poles=p, gain=k, variable='s')"
        )
    symbol = as_symbol(variable)
    numerator = polynomial_from_roots(() if zeros is None else zeros, symbol)
    factor = exact_number(1 if gain is None else gain)
    return TransferFunction(scaled(numerator, factor), polynomial_from_roots(poles, symbol))


def _from_quotient(quotient: Quotient, variable: str | Symbol | None) -> TransferFunction:
    if variable is not None:
        sides = sides_in(quotient, as_symbol(variable))
        require_no_other_operator(*sides)
        return TransferFunction(*sides)
    top, bottom = quotient.sides()
    occurring = top.free_symbols | bottom.free_symbols
    return TransferFunction(
        *sides_in(quotient, evident_variable(occurring, "the transfer function"))
    )


def _in_variable(G: TransferFunction, variable: str | Symbol | None) -> TransferFunction:
    if variable is None or as_symbol(variable) == G.variable:
        return G
    raise InputError(
        f"{G} is a transfer function in {G.variable}, not in {variable}; build it in {variable}"
    )


def _from_foreign(found: Contents) -> TransferFunction:
    return replace(_fraction_of(found), sample_time=found.sample_time)


def _fraction_of(found: Contents) -> TransferFunction:
    match found:
        case Fraction(numerator, denominator, variable):
            return TransferFunction(
                polynomial(numerator, variable), polynomial(denominator, variable)
            )
        case ZerosAndPoles(zeros, poles, gain, variable):
            return _from_roots(zeros, poles, gain, variable)
        case Matrices(A, B, C, D, variable):
            return Realisation(A, B, C, D, variable).transfer_function()
