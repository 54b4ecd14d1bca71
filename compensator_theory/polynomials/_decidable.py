"""Expressions whose zero test the coefficient domains decide; others are refused."""

from __future__ import annotations

from collections.abc import Iterable

import sympy
from sympy import Expr

from compensator_theory.errors import Advice, InputError
from compensator_theory.polynomials._budget import repr_of

_FACTORED = 2**30  # SymPy writes roots of smaller numbers in one form: its trial division ends
_PAIRS = (sympy.sin, sympy.cos, sympy.tan)
_TRIGONOMETRIC = sympy.functions.elementary.trigonometric.TrigonometricFunction
_DEAD_TIME = (
    "as dead_time= to {function}, sampled as 1/q**d, or as a list of polynomials to "
    "stability_delays; transfer_function, step_response and stability_margins read it, and the "
    "method pade of a transfer function approximates it by a rational one"
)
DEAD_TIME = Advice("design", (("dead_time", "..."),), f"pass a dead time separately: {_DEAD_TIME}")
_ALGEBRAIC_NAMES = (sympy.GoldenRatio, sympy.TribonacciConstant)


def require_decidable(coefficients: Iterable[Expr]) -> None:
    r"""Refuse coefficients for which no domain decides whether they are zero.

    Decided are rational functions of symbols; algebraic numbers; pi, E and SymPy's other named
    constants, of which no relation is known; and these with symbols or roots of rational numbers,
    which SymPy writes in one form. Refused are functions of symbols, as sin(t) and cos(t) are no
    two unknowns, nor are :math:`\sqrt a \sqrt b` and :math:`\sqrt{ab}`; other transcendental
    numbers, as log(2), log(3) and log(6); and symbols beside other algebraic numbers.
    Public functions that carry functions of symbols have put unknowns in their place before.
    """
    nested: set[Expr] = set()
    unknowns: set[Expr] = set()
    waiting = list(coefficients)
    while waiting:
        part = waiting.pop()
        if part.is_Rational or part.is_Float or part is sympy.I:
            continue
        if part.is_Symbol:
            unknowns.add(part)
        elif isinstance(part, sympy.Add | sympy.Mul):
            waiting += part.args
        elif isinstance(part, sympy.Pow) and part.exp.is_Integer:
            waiting.append(part.base)
        elif part.free_symbols:
            raise InputError(*_of_symbols(part))
        elif isinstance(part, sympy.NumberSymbol) and part not in _ALGEBRAIC_NAMES:
            unknowns.add(part)
        elif isinstance(part, sympy.exp) and part.exp.is_Integer:
            unknowns.add(sympy.E)
        elif _is_plain_root(part):
            continue
        elif is_algebraic(part):
            nested.add(part)
        else:
            raise InputError(_of_numbers(part))
    if nested and unknowns:
        first, other = (min(parts, key=str) for parts in (nested, unknowns))
        raise InputError(
            f"{repr_of(first)} occurs with the unknown {other}, and no test decides whether an "
            f"expression of both is zero; write a symbol for {repr_of(first)}, or a rational "
            "number close to it"
        )


def require_rational_functions(entries: Iterable[Expr], name: str) -> None:
    """Refuse entries of a matrix that are no rational functions of symbols over the rationals."""
    for part in sorted(irrational_constants(entries), key=str):
        if part.free_symbols:
            raise InputError(f"in {name}, ", *_of_symbols(part))
        raise InputError(
            f"{name} contains the irrational number {repr_of(part)}; write a rational number close "
            "to it, or, where the function takes symbols, a symbol in its place"
        )


def irrational_constants(expressions: Iterable[Expr]) -> set[Expr]:
    """Return the parts that are not composed of rational numbers and symbols."""
    constants: set[Expr] = set()
    waiting = list(expressions)
    while waiting:
        part = waiting.pop()
        if part.is_Rational or part.is_Symbol:
            continue
        if isinstance(part, sympy.Add | sympy.Mul):
            waiting += part.args
        elif isinstance(part, sympy.Pow) and part.exp.is_Integer:
            waiting.append(part.base)
        else:
            constants.add(part)
    return constants


def _is_plain_root(part: Expr) -> bool:
    """Whether it is a root of a rational number that SymPy factors."""
    if not (isinstance(part, sympy.Pow) and part.exp.is_Rational and part.base.is_Rational):
        return False
    return max(abs(int(part.base.p)), int(part.base.q)) < _FACTORED


def is_algebraic(part: Expr) -> bool:
    """Whether it is built from roots, and from values of sine and cosine at rational angles."""
    if part.is_Rational or part is sympy.I or part in _ALGEBRAIC_NAMES:
        return True
    if isinstance(part, sympy.polys.rootoftools.ComplexRootOf):
        return True
    if isinstance(part, sympy.Add | sympy.Mul):
        return all(map(is_algebraic, part.args))
    if isinstance(part, sympy.Pow):
        return bool(part.exp.is_Rational) and is_algebraic(part.base)
    if isinstance(part, _PAIRS):
        return bool((part.args[0] / sympy.pi).is_Rational)
    if isinstance(part, sympy.exp):
        return bool((part.args[0] / (sympy.I * sympy.pi)).is_Rational)
    return False


def _of_symbols(part: Expr) -> tuple[str | Advice, ...]:
    """Return the reason why a function of symbols is refused, in parts of a message."""
    subject = f"{repr_of(part)} is no rational function of its symbols, and"
    if isinstance(part, _TRIGONOMETRIC):
        angle = repr_of(part.args[0])
        return (
            f"{subject} relations between sines and cosines are not decided; write two symbols for "
            f"cos({angle}) and sin({angle}), whose squares add to 1, or one for tan({angle}/2), of "
            "which both are rational functions",
        )
    if isinstance(part, sympy.Pow) and part.exp.is_Rational:
        base, index = repr_of(part.base), int(part.exp.q)
        root = f"sqrt({base})" if index == 2 else f"({base})**(1/{index})"
        power = "square" if index == 2 else f"power {index}"
        rest = f", and its {power} for {base}" if part.base.is_Symbol else ""
        return (
            f"{subject} relations between roots are not decided; write a symbol for {root}{rest}",
        )
    if _holds_a_dead_time(part):
        return f"{repr_of(part)} is no rational function of its symbols; ", _dead_time_advice(part)
    return (
        f"{subject} relations between such functions are not decided; write a symbol in its place",
    )


def _dead_time_advice(part: Expr) -> Advice:
    """Return the advice for an exponential, with the dead time of exp(-h s), h a number."""
    factor, variable = part.args[0].as_coeff_Mul() if isinstance(part, sympy.exp) else (0, None)
    if str(variable) != "s" or not factor < 0:
        return DEAD_TIME
    return Advice(
        "design",
        (("dead_time", f"{-float(factor):.15g}"),),
        "leave the exponential out and pass the dead time of {dead_time} s separately: "
        + _DEAD_TIME,
    )


def _holds_a_dead_time(expression: Expr) -> bool:
    """Whether it has an exponential of a variable of transfer functions."""
    return any(
        {"s", "z", "q"} & {x.name for x in e.free_symbols} for e in expression.atoms(sympy.exp)
    )


def _of_numbers(part: Expr) -> str:
    if isinstance(part, _TRIGONOMETRIC) and (part.args[0] / sympy.pi).is_Rational:
        angle = repr_of(part.args[0])
        return f"{repr_of(part)} is not supported; write it with sin({angle}) and cos({angle})"
    return (
        f"no test decides whether expressions with the number {repr_of(part)} are zero; write a "
        "symbol in its place, or a rational number close to it"
    )
