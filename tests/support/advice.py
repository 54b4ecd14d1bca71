"""What a message advises: the keywords and the functions that it names, and where they must be."""

import builtins
import inspect
import pkgutil
import re

import sympy

from tests.support.public import public_objects

PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
MATHEMATICS = {"sqrt", "exp", "log", "sin", "cos", "tan", "a_0", "a_1", "G"}
ECHOED = {"Matrix", "masked_array", "array", "poly1d", "np.float64", "SampledPlant", "Realisation"}
"""Reprs of what was given."""
NAME = r"(?<![\w.'\"\\])([A-Za-z_]\w*)"
CALL = re.compile(r"(?<![\w.'\"\\])([A-Za-z_.][\w.]*)\(")
KEYWORD = re.compile(rf"{NAME}=(?! (?:to|of) )(?![=\s])|{NAME}= (?:to|of) (\w+)")


def known():
    """Every public function or class, by its name with and without its package."""
    result = {}
    for package in reversed(PACKAGES):
        for name, one in public_objects(package).items():
            result[name.rpartition(".")[2]] = one
            result[f"{package}.{name}"] = one
    return result


def wrong_advice(message, door, table):
    """What a message names that is not there: no such function, or no such keyword in it."""
    spans, wrong = [], []
    for call in CALL.finditer(message):
        if call[1] not in MATHEMATICS:
            spans.append((call.end(), _closing(message, call.end()), call[1]))
            if call[1] not in ECHOED and _function(call[1], table) is None:
                wrong.append(f"{call[1]}(...) is nowhere public")
    for result in KEYWORD.finditer(message):
        keyword, of = result[1] or result[2], result[3]
        inside = [name for first, last, name in spans if first <= result.start() < last]
        if ECHOED & {*inside}:
            continue
        function = _function(of or inside[-1], table) if of or inside else door
        if function is not None and not _takes(function, keyword):
            wrong.append(f"{keyword}= is no argument of {getattr(function, '__name__', function)}")
    return wrong


def has_argument(table, function, name):
    """Whether a function is public and takes an argument of this name; any, for an empty name."""
    one = _function(function, table) or _function(f".{function.rpartition('.')[2]}", table)
    return one is not None and (not name or _takes(one, name))


def _closing(text, start):
    """Where the bracket that is open at `start` closes; the end of a shortened text."""
    depth = 1
    for place in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if not depth:
            return place
    return len(text)


def _function(name, table):
    """A public function of ours, of another package by its full name, or a method; else None."""
    if name in table:
        return table[name]
    if hasattr(builtins, name):
        return getattr(builtins, name)
    if not name.startswith("."):
        try:
            return pkgutil.resolve_name(name)
        except (ImportError, AttributeError, ValueError):
            pass
    if "." not in name:
        return None
    method = name.rpartition(".")[2]
    return next((getattr(one, method) for one in (*table.values(), sympy.Matrix)
                 if inspect.isclass(one) and hasattr(one, method)), None)  # fmt: skip


def _takes(function, keyword):
    try:
        parameters = inspect.signature(function).parameters
    except (ValueError, TypeError):  # of a class of another package
        return True
    return keyword in parameters or any(p.kind is p.VAR_KEYWORD for p in parameters.values())
