"""Everything that describes a SISO transfer function, to an exact one."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import sympy
from sympy import Expr, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.expressions import parse_quotient
from compensator_theory.polynomials.from_roots import polynomial_from_roots
from compensator_theory.polynomials.numbers import exact_number
from compensator_theory.polynomials.poly import polynomial, scaled
from compensator_theory.polynomials.variables import OPERATORS, as_symbol
from compensator_theory.systems.state_space import transfer_matrix_of_realisation
from compensator_theory.systems.transfer_functions import TransferFunction

TransferFunctionLike: TypeAlias = Any
"""What :func:`transfer_function` reads."""


def transfer_function(
    obj: TransferFunctionLike = None,
    variable: str | Symbol | None = None,
    *,
    zeros: Any = None,
    poles: Any = None,
    gain: Any = None,
) -> TransferFunction:
    r"""Make an exact transfer function out of any usual description.

    .. math:: G = \frac{N}{D} = k\,\frac{\prod_i (s - z_i)}{\prod_j (s - p_j)}

    Parameters
    ----------
    obj : TransferFunction, str, Expr, pair, mapping, SymPy or python-control system
        A pair is (numerator, denominator), each of which :func:`polynomial` reads. A mapping has
        the keys ``zeros``, ``poles``, ``gain``. Floats are read by their shortest decimal.
    variable : str or Symbol, optional
        Default: evident from the symbols; for python-control ``s`` or ``z`` from its time base.
    zeros, poles : iterable, optional
        Exact roots, instead of `obj`; zeros default to none.
    gain : number, optional
        Leading coefficient of the numerator; default 1.

    Returns
    -------
    TransferFunction
        A string, a pair and zeros with poles keep common factors; an expression comes as SymPy has
        already simplified it.

    Raises
    ------
    InputError
        If the description is incomplete, not scalar, not rational in the variable, or not finite.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> print(transfer_function("(q - 0.85)/((q - 0.8)*(q - 0.9))"))
    (q - 17/20)/(q**2 - 17*q/10 + 18/25)
    >>> print(transfer_function(([1, 2], [1, 0, "a"]), "s"))
    (s + 2)/(s**2 + a)
    >>> print(transfer_function(zeros=[-1], poles=["-2+1j", "-2-1j"], gain=3, variable="s"))
    (3*s + 3)/(s**2 + 4*s + 5)
    """
    if isinstance(obj, Mapping):
        unknown = sorted(set(obj) - {"zeros", "poles", "gain"})
        if unknown:
            raise InputError(f"unknown keys {unknown}; a transfer function has zeros, poles, gain")
        return transfer_function(None, variable, **obj)
    if obj is None:
        return _from_roots(zeros, poles, gain, variable)
    if not (zeros is None and poles is None and gain is None):
        raise InputError("give either a transfer function or zeros, poles and gain, not both")
    if isinstance(obj, TransferFunction):
        return _in_variable(obj, variable)
    if isinstance(obj, str):
        numerator, denominator = parse_quotient(obj)
        return _from_pair(numerator, denominator, variable)
    if isinstance(obj, tuple | list) and len(obj) == 2:
        return _from_pair(obj[0], obj[1], variable)
    if type(obj).__module__.startswith("sympy.physics.control"):
        return _from_pair(obj.num, obj.den, variable or obj.var)
    if type(obj).__module__.split(".")[0] == "control":
        return _from_control(obj, variable)
    expression = exact_number(obj)
    numerator, denominator = sympy.fraction(sympy.together(expression))
    return _from_pair(numerator, denominator, variable)


def _from_roots(
    zeros: Any, poles: Any, gain: Any, variable: str | Symbol | None
) -> TransferFunction:
    if poles is None:
        raise InputError("give a transfer function, or at least its poles")
    if variable is None:
        raise InputError("zeros and poles do not show the variable; name it, as in variable='s'")
    symbol = as_symbol(variable)
    numerator = polynomial_from_roots(() if zeros is None else zeros, symbol)
    factor = exact_number(1 if gain is None else gain)
    return TransferFunction(scaled(numerator, factor), polynomial_from_roots(poles, symbol))


def _from_pair(numerator: Any, denominator: Any, variable: str | Symbol | None) -> TransferFunction:
    symbol = as_symbol(variable) if variable is not None else _variable_of(numerator, denominator)
    return TransferFunction(polynomial(numerator, symbol), polynomial(denominator, symbol))


def _variable_of(*sides: Any) -> Symbol:
    symbols: set[Symbol] = set()
    for side in sides:
        if isinstance(side, sympy.Poly):
            return side.gen
        if isinstance(side, str | Expr):
            symbols |= exact_number(side).free_symbols
    usual = [symbol for symbol in symbols if symbol.name in OPERATORS]
    candidates = usual or list(symbols)
    if len(candidates) != 1:
        names = ", ".join(sorted(symbol.name for symbol in symbols)) or "none"
        raise InputError(
            f"the variable of the transfer function is not evident (symbols: {names}); name it, "
            "for instance variable='s'"
        )
    return candidates[0]


def _in_variable(G: TransferFunction, variable: str | Symbol | None) -> TransferFunction:
    if variable is None or as_symbol(variable) == G.variable:
        return G
    raise InputError(
        f"{G} is a transfer function in {G.variable}, not in {variable}; build it in {variable}"
    )


def _from_control(system: Any, variable: str | Symbol | None) -> TransferFunction:
    if (system.ninputs, system.noutputs) != (1, 1):
        raise InputError(
            f"the system has {system.ninputs} inputs and {system.noutputs} outputs; "
            "pick one of each, as in system[0, 0]"
        )
    if variable is None:
        if system.dt is None:
            raise InputError("the system's time base is unspecified; name the variable, 's' or 'z'")
        variable = "s" if system.isctime() else "z"
    if hasattr(system, "num"):
        return _from_pair(list(system.num[0][0]), list(system.den[0][0]), variable)
    if not hasattr(system, "A"):
        raise InputError(f"a {type(system).__name__} has no rational transfer function")
    A, B, C, D = (
        sympy.Matrix(*m.shape, [exact_number(x) for x in m.flat])
        for m in (system.A, system.B, system.C, system.D)
    )
    return transfer_matrix_of_realisation(A, B, C, D, as_symbol(variable)).scalar()
