"""The good inputs of every public function of the exact half, with a symbol put in."""

import inspect
import itertools
import re
from dataclasses import fields

from sympy import Basic, MatrixBase, Poly, Symbol

import compensator_theory as exact
from compensator_theory.polynomials._values import ExactValue
from tests.support.bad_inputs import GOOD
from tests.support.public import public_objects

PUBLIC = public_objects("compensator_theory")


def mixed(value, how, name):
    """The argument with a symbol in one place; None where there is none for it."""
    if str(value) == "0":
        how = "plus"  # the product is 0 again
    if isinstance(value, str):
        if value.isidentifier() or "," in value:
            return None
        return f"({value})*{name}" if how == "times" else f"({value}) + {name}"
    if isinstance(value, Poly):
        return mixed(str(value.as_expr()), how, name)
    if isinstance(value, exact.Realisation):
        A, C = value.A.as_mutable(), value.C
        if how == "times":
            C = C * Symbol(name)
        else:
            A[-1, -1] += Symbol(name)
        return exact.Realisation(A, value.B, C, value.D, value.variable)
    if isinstance(value, bool | ExactValue):
        return None
    if isinstance(value, int | float):
        return f"{value}*{name}" if how == "times" else f"{value} + {name}"
    if type(value) in (list, tuple):
        for place in reversed(range(len(value))):
            inner = mixed(value[place], how, name)
            if inner is not None:
                return type(value)([*value[:place], inner, *value[place + 1 :]])
    return None


def calls(name):
    """Calls of a public function: the arguments by a symbol's name, and what names they have."""
    arguments, keywords = GOOD[name]
    parameters = list(inspect.signature(PUBLIC[name]).parameters.values())
    names = [p.name for p in parameters]
    needed = sum(p.default is p.empty and p.kind is p.POSITIONAL_OR_KEYWORD for p in parameters)
    fixed = [arguments] if needed >= len(arguments) else [arguments[:needed], arguments]
    options = [keywords]
    if "variable" in set(names[len(arguments) :]) - set(keywords):
        options.append({**keywords, "variable": "s"})
    for argument, more in itertools.product(fixed, options):
        for place, how in itertools.product(range(len(argument)), ("times", "plus")):

            def call(symbol, value=argument, place=place, how=how, more=more):
                inner = mixed(value[place], how, symbol)
                return (
                    None if inner is None else ([*value[:place], inner, *value[place + 1 :]], more)
                )

            yield call, names_of(argument, more)


def names_of(*arguments):
    """What the caller has named, variables included."""
    result = symbols_in(arguments)
    for value in arguments:
        if isinstance(value, str):
            result |= set(re.findall(r"[^\W\d]\w*", value))
        elif type(value) in (list, tuple):
            result |= names_of(*value)
        elif isinstance(value, dict):
            result |= names_of(*value.values())
    return result


def symbols_in(value):
    if isinstance(value, Poly):
        return {symbol.name for symbol in (*value.gens, *value.free_symbols)}
    if isinstance(value, Basic | MatrixBase):
        return {symbol.name for symbol in value.free_symbols}
    if isinstance(value, tuple | list):
        return set().union(*map(symbols_in, value))
    if isinstance(value, ExactValue):
        return symbols_in(tuple(getattr(value, field.name) for field in fields(value)))
    return set()
