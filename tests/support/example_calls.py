"""The calls of a public function or class in its own example: what a generated test begins with."""

import contextlib
import doctest
import inspect
import io
import os
import sys
import tempfile
import threading
import warnings
from functools import cache

import numpy as np

from tests.support.public import public_objects


def code_of(one):
    """The code that runs when a public function or class is called."""
    function = inspect.unwrap(one.__init__ if inspect.isclass(one) else one)
    return getattr(function, "__code__", None)


class _Located(BaseException):
    """Ends an example where the call that it leads to is known."""


def call_of(one):
    """The keyword arguments of the first call of `one` in its own example; None without one."""
    code, result, me = code_of(one), [], threading.get_ident()
    if code is None or not one.__doc__ or ">>>" not in one.__doc__:
        return None

    def look(frame, event, _):
        if event == "call" and frame.f_code is code and threading.get_ident() == me:
            values = frame.f_locals
            names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
            if not code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS):
                result.append({n: values[n] for n in names if n != "self"})
            raise _Located

    examples = doctest.DocTestParser().get_examples(one.__doc__)
    space, before = {"np": np, "__name__": "example"}, os.getcwd()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        os.chdir(folder)
        sys.setprofile(look)
        try:
            with warnings.catch_warnings(), contextlib.suppress(_Located):
                warnings.simplefilter("ignore")
                for example in examples:
                    with contextlib.suppress(Exception):  # an example may end in its error
                        exec(compile(example.source, "example", "single"), space)
        finally:
            sys.setprofile(None)
            os.chdir(before)
    return result[0] if result else None


def numeric_array(value):
    """What is given as float64, if it is a non-empty array or list of real numbers; else None."""
    if not isinstance(value, list | np.ndarray):
        return None
    try:
        array = np.array(value)
    except ValueError:  # rows of several lengths, or of objects
        return None
    return array.astype(np.float64) if array.dtype.kind in "iuf" and array.size else None


def doors(package, takes):
    """Name -> (callable, arguments, names of those that `takes` is true of) of what is public."""
    result = {}
    for name, (one, call) in example_calls(package).items():
        names = [k for k, v in call.items() if takes(v)]
        if names:
            result[name] = one, call, names
    return result


@cache
def example_calls(package):
    """Name -> (callable, arguments of the first call in its example) of all that is public."""
    result = {}
    for name, one in public_objects(package).items():
        call = call_of(one) if callable(one) else None
        if call:
            result[name] = one, call
    return result


def is_array(value):
    """Whether it is a non-empty array or list of real numbers."""
    return numeric_array(value) is not None
