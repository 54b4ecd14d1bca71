"""Exact transfer functions from any description, with a dead time or without."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, TypeAlias

import sympy
from sympy import Expr, Symbol

from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._budget import ask, quoted
from compensator_theory.polynomials._carrying import carried_by
from compensator_theory.polynomials._expressions import leaves_of, read_tree, written_tree
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._quotients import Quotient, Tree, multiplied_out
from compensator_theory.polynomials._sympy_trees import require_readable, tree_of
from compensator_theory.polynomials._variables import DISCRETE, as_symbol, is_operator
from compensator_theory.systems import _conversions
from compensator_theory.systems._conversions import TransferFunctionLike
from compensator_theory.systems._delayed_transfer_functions import (
    DelayedTransferFunction,
    delayed,
    way_of_pade,
)
from compensator_theory.systems._transfer_functions import TransferFunction

DelayedLike: TypeAlias = TransferFunctionLike | DelayedTransferFunction
"""Input types of :func:`transfer_function`."""

_EXPONENTIAL = re.compile(r"(?<![^\W\d])exp\s*\(")


@holds_where_defined
@carried_by("all")
def transfer_function(
    obj: DelayedLike | None = None,
    variable: str | Symbol | None = None,
    *,
    zeros: Iterable[NumberLike] | None = None,
    poles: Iterable[NumberLike] | None = None,
    gain: NumberLike | None = None,
    sample_time: NumberLike | None = None,
) -> TransferFunction | Any:
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
        In seconds, in discrete time. The time domain of `obj` has to agree: a system knows its
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
    if zeros is None and poles is None and gain is None:
        G = with_dead_time(obj, variable)
        if G is not None:
            if sample_time is not None:
                raise InputError(
                    f"{G} is in continuous time and has no sample time; leave sample_time out"
                )
            return G
    return _conversions.transfer_function(
        obj, variable, zeros=zeros, poles=poles, gain=gain, sample_time=sample_time
    )


def with_dead_time(
    obj: Any, variable: str | Symbol | None = None
) -> TransferFunction | DelayedTransferFunction | None:
    """Return a transfer function that is written with exponentials; None of another object."""
    if isinstance(obj, DelayedTransferFunction):
        if variable is not None and as_symbol(variable) != obj.variable:
            raise InputError(f"{obj} is a transfer function in {obj.variable}, not in {variable}")
        return obj
    named = None if variable is None else as_symbol(variable)
    parts = _parts(obj)
    if parts is None:
        return None
    trees = [_tree(part) for part in parts]
    leaves = {leaf for tree in trees for leaf in leaves_of(tree)}
    exponentials = {leaf for leaf in leaves if isinstance(leaf, sympy.exp)}
    s = named or _variable(set().union(*(leaf.free_symbols for leaf in leaves)))
    late = {leaf: _delay(leaf, s) for leaf in exponentials if s in leaf.free_symbols}
    if s is None or not late:
        return None

    def undelayed(leaf: Expr) -> Expr:
        return sympy.exp(late[leaf][1]) if leaf in late else leaf

    texts = [written_tree(tree, undelayed) for tree in trees]
    ask("characters", sum(map(len, texts)), "the expression")
    rational = _conversions.transfer_function(
        texts[0] if len(texts) == 1 else (texts[0], texts[1]), s
    )
    delays = [_delay_of(multiplied_out(tree), late) for tree in trees]
    return delayed(rational, delays[0] - (delays[1] if len(delays) > 1 else 0))


@roots_in_sympy()
def _tree(part: str | Expr) -> Tree:
    """Return the sums and products of a text or an expression."""
    if isinstance(part, str):
        return read_tree(part)
    require_readable(part)
    return tree_of(part)


def _parts(obj: Any) -> list[str | Expr] | None:
    """Return the expression, or numerator and denominator, of which one has an exponential."""
    if f"{type(obj).__module__}.".startswith("sympy.physics.control.") and hasattr(obj, "num"):
        obj = obj.num, obj.den
    parts = list(obj) if isinstance(obj, tuple | sympy.Tuple) and len(obj) == 2 else [obj]
    parts = [sympy.Integer(part) if type(part) is int else part for part in parts]
    if not all(isinstance(part, str | Expr) for part in parts):
        return None
    if any(
        bool(_EXPONENTIAL.search(part)) if isinstance(part, str) else part.has(sympy.exp)
        for part in parts
    ):
        return parts
    return None


def _variable(symbols: set[Symbol]) -> Symbol | None:
    """Return the only one of s, z, q, else the only symbol; None where it is not evident."""
    candidates = {x for x in symbols if is_operator(x)} or symbols
    return next(iter(candidates)) if len(candidates) == 1 else None


def _delay(leaf: Expr, s: Symbol) -> tuple[Expr, Expr]:
    """Return theta and c of exp(-theta s + c)."""
    if s.name in DISCRETE:
        raise InputError(
            f"{quoted(leaf)} is no dead time in {s}, which is discrete time; a dead time of d "
            f"steps is {s}**-d"
        )
    exponent = sympy.expand(leaf.args[0])
    theta = -exponent.coeff(s, 1)
    rest = sympy.expand(exponent + theta * s)
    if s in rest.free_symbols or s in theta.free_symbols:
        raise InputError(
            f"{quoted(leaf)} is no dead time; the dead time theta is written exp(-theta*{s})"
        )
    return theta, rest


def _delay_of(quotient: Quotient, late: dict[Expr, tuple[Expr, Expr]]) -> Expr:
    """Return the one dead time of a quotient of polynomials in exponentials."""
    places = [(k, late[g][0]) for k, g in enumerate(quotient.generators) if g in late]
    delays = []
    for side in (quotient.numerator, quotient.denominator):
        sums = {
            sympy.expand(sympy.Add(*(int(powers[k]) * theta for k, theta in places)))
            for powers in side.to_dict()
        }
        delays.append(sorted(sums, key=sympy.default_sort_key))
    above, below = delays
    if len(below) > 1:
        raise InputError(
            "the denominator has an exponential in a sum: the dead time is inside a feedback loop. "
            "Give the loop's transfer function L to stability_margins, the coefficients of its "
            "quasi-polynomial to stability_delays, ",
            way_of_pade("or close the loop of the approximation G.pade({order})"),
        )
    if len(above) > 1:
        listed = " and ".join(f"{quoted(theta - below[0])} s" for theta in above[:3])
        raise InputError(
            f"the terms of the sum have the dead times {listed}, and a transfer function has one; "
            "give the quasi-polynomial of the loop to stability_delays, ",
            way_of_pade("or add the approximations G.pade({order}) of the terms"),
        )
    return above[0] - below[0] if above else sympy.Integer(0)
