"""The session behind the examples of a page, as its worker runs it."""

import ast
import contextlib
import io
from collections.abc import Callable
from typing import Any

FILE = "<example>"
scopes: dict[str, dict[str, Any]] = {}


def run(code: str, scope: str, show: Callable[[str, str, str | None], object]) -> str | None:
    r"""Run an example in its scope; return None, or the error in one line.

    Each statement that prints or has a value is shown as its source, which is empty if the example
    has one such statement alone, its text, and its formula in LaTeX.

    Examples
    --------
    >>> from docs.browser.static.try_it import run
    >>> run("x = 6\nx*7", "a page", lambda *answer: print(answer))
    ('', '42', None)
    >>> run("x/0", "a page", print)
    'ZeroDivisionError: division by zero (line 1)'
    """
    names = scopes.setdefault(scope, {"__name__": "__main__"})
    try:
        statements = ast.parse(code, FILE).body
    except SyntaxError as error:
        return f"SyntaxError: {error.msg} (line {error.lineno})"
    several = sum(isinstance(statement, ast.Expr) for statement in statements) > 1
    for statement in statements:
        printed, value, failure = io.StringIO(), None, None
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            try:
                if isinstance(statement, ast.Expr):
                    value = eval(compile(ast.Expression(statement.value), FILE, "eval"), names)
                else:
                    exec(compile(ast.Module([statement], []), FILE, "exec"), names)
                formula = None if value is None else _formula(value)
                if value is not None and formula is None:
                    print(repr(value))
            except BaseException as error:
                failure, formula = _line(error), None
        text = printed.getvalue().rstrip("\n")
        if text or formula is not None:
            show(ast.get_source_segment(code, statement) or "" if several else "", text, formula)
        if failure is not None:
            return failure
    return None


def _formula(value: Any) -> str | None:
    """A value in LaTeX, as a notebook asks for it, without the signs of a formula."""
    latex = getattr(value, "_repr_latex_", None)
    formula = None if latex is None or isinstance(value, type) else latex()
    return None if formula is None else formula.strip("$").removeprefix(r"\displaystyle ")


def _line(error: BaseException) -> str:
    """An error in one line, with the line of the example that raised it."""
    line, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == FILE:
            line = trace.tb_lineno
        trace = trace.tb_next
    words = " ".join(str(error).split())
    message = f"{type(error).__name__}: {words}" if words else type(error).__name__
    return message if line is None else f"{message} (line {line})"
