"""Reading of systems in any form, for every function that takes one.

It comes down to a `Description`, which `_conversions` makes a transfer function of,
`_matrix_conversions` a transfer matrix, and `_canonical_forms` a realisation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from numbers import Number
from typing import Any, NoReturn, TypeAlias

from sympy import Expr, MatrixBase, Poly, Rational, Symbol, Tuple

from compensator_theory.errors import Advice, CompensatorError, InputError
from compensator_theory.polynomials._budget import ask, is_array, repr_of
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._quotients import Quotient
from compensator_theory.polynomials._reading import is_list, read_quotient
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_operator
from compensator_theory.systems._delayed_transfer_functions import (
    DelayedTransferFunction,
    refuse_dead_time,
)
from compensator_theory.systems._foreign import contents_of, is_foreign
from compensator_theory.systems._kinds import Pair, Roots, Rows, States
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import System

Description: TypeAlias = Pair | Roots | Rows | States | System | Poly | Quotient
"""All that a description comes down to."""

FORMS = Advice(
    "transfer_matrix",
    (("rows", ""),),
    "give a text, a pair (num, den), matrices (A, B, C, D), rows of transfer functions such as "
    "[['1/s', 0]], or a system",
)


def described(obj: Any, variable: str | Symbol | None = None) -> Any:
    """Return the description of an object of several parts; other objects unchanged.

    There is one reading, whichever function asks. A tuple of two is (num, den); a list of lists of
    equal length is a matrix by rows, in which a tuple is the fraction of an entry; two nested lists
    of three levels are the numerators and denominators of a matrix, as python-control has them;
    matrices are (A, B, C) or (A, B, C, D), and (A, B, C, D) may be followed by a sample time.
    """
    if isinstance(obj, DelayedTransferFunction):
        raise refuse_dead_time(obj)
    if isinstance(obj, ExactValue) and not isinstance(obj, System):
        content = getattr(obj, "realisation", obj)  # of a sampled plant, a minimal realisation
        return content if isinstance(content, Realisation) else obj
    if isinstance(obj, Description | str):
        return obj
    if isinstance(obj, MatrixBase):
        return _rows(obj.tolist())
    if isinstance(obj, list | tuple | Tuple):
        return _of_parts(obj, variable)
    if is_array(obj):
        if not is_array(obj, dimensions=2) or not hasattr(obj, "tolist"):
            _refuse(obj)
        ask("entries", obj.size, "the transfer matrix")
        return _rows([[obj[i, j] for j in range(obj.shape[1])] for i in range(obj.shape[0])])
    read = in_our_order(obj)  # an element of SymPy's rings is a mapping, and a polynomial
    if isinstance(read, Mapping):
        if unknown := sorted(map(str, set(read) - {"zeros", "poles", "gain"})):
            raise InputError(f"unknown keys {unknown}; a transfer function has zeros, poles, gain")
        return Roots(**read)
    return Pair(read, 1) if isinstance(read, list) else read


def read_system(obj: Any, variable: str | Symbol | None = None) -> Description:
    """Return the description of a system; a text or an expression is read in the same pass."""
    if obj is None:
        return Roots()
    source = opened(described(obj, variable), variable)
    return source if isinstance(source, Description) else read_quotient(source)


def opened(obj: Any, variable: str | Symbol | None = None) -> Any:
    """Read a text or a foreign system; return other objects unchanged."""
    if isinstance(obj, str):
        return read_quotient(obj)
    return contents_of(obj, variable) if is_foreign(obj) else obj


def realised(source: States, variable: str | Symbol | None) -> Realisation:
    """The realisation of matrices, whose time domain has to be known."""
    symbol = variable if source.variable is None else source.variable
    if symbol is None and source.sample_time is None:
        raise InputError(
            "matrices (A, B, C) do not show the time domain; give Realisation(A, B, C, D, "
            "'s') for continuous time, with 'z' or 'q' for discrete time"
        )
    symbol = "z" if symbol is None else symbol
    return Realisation(
        source.A, source.B, source.C, source.D, symbol, sample_time=source.sample_time
    )


def is_description(obj: object) -> bool:
    """Return whether the type of an object can describe a system; its reader decides."""
    kinds = (str, list, tuple, Tuple, Mapping, Expr, Poly, MatrixBase, ExactValue)
    if isinstance(obj, kinds) or is_foreign(obj) or is_array(obj):
        return True
    return in_our_order(obj) is not obj


def has_states(obj: Any, variable: str | Symbol | None = None) -> bool:
    """Return whether an object is in state space."""
    description = described(obj, variable)
    if not is_foreign(description):
        return isinstance(description, States | Realisation)
    if all(hasattr(description, name) for name in "ABCD"):
        return True
    joined = type(description).__module__.startswith("sympy") and shape_of(description) == (1, 1)
    return joined and isinstance(contents_of(description, variable), States)


def shape_of(obj: Any, variable: str | Symbol | None = None) -> tuple[int, int]:
    """Numbers of outputs and inputs, as far as they show; (1, 1) of whatever is scalar."""
    description = described(obj, variable)
    if isinstance(description, States):
        return _sizes(description.C)[0], _sizes(description.B)[1]
    if is_foreign(description):
        counts: tuple[Any, Any] = (None, None)
        if hasattr(description, "noutputs"):  # of python-control, SymPy and SciPy
            counts = description.noutputs, description.ninputs
        elif hasattr(description, "num_outputs"):
            counts = description.num_outputs, description.num_inputs
        elif hasattr(description, "outputs") and hasattr(description, "inputs"):
            counts = description.outputs, description.inputs
        if all(isinstance(count, int) for count in counts):
            return counts
    matrix = getattr(description, "D", description)  # of a realisation, a descriptor system
    if isinstance(matrix, Rows | System | MatrixBase) and hasattr(matrix, "shape"):
        outputs, inputs = matrix.shape
        return int(outputs), int(inputs)
    return 1, 1


def _of_parts(parts: Sequence[Any], variable: str | Symbol | None) -> Pair | Rows | States:
    ask("entries", len(parts), "the system")
    ask("entries", sum(len(p) for p in parts if isinstance(p, list | tuple)), "the transfer matrix")
    if (states := _states(parts, variable)) is not None:
        return states
    levels = [*map(_level, parts)]
    is_tuple = not isinstance(parts, list)
    if len(parts) == 2:
        first, second = parts
        if _is_nested(first) and (_is_nested(second) or levels[1] == 1):
            if not any(isinstance(row, tuple) for part in parts for row in part):
                return _of_nested_lists(first, second)
            if is_tuple or levels[1] == 1:
                _refuse(parts)
        if levels[0] == 2 and levels[1] < 2:
            _refuse_rows_of_numerators()
        if is_tuple and max(levels) <= 1 and not (levels == [1, 1] and _shows(parts, variable)):
            return Pair(first, second)
    if len(parts) in (3, 4) and 0 not in levels[:2] and not any(levels[2:]):
        if max(levels) == 1:
            raise InputError(
                f"{repr_of(parts)} may be zeros, poles and a gain, or numerator, denominator and a "
                "sample time; write transfer_function(zeros=z, poles=p, gain=k, variable='s'), or "
                "transfer_function((num, den), 'z', sample_time=dt)"
            )
        if levels[:2] == [2, 1]:
            _refuse_rows_of_numerators()
        if levels[0] == 3:
            raise InputError(
                f"{repr_of(parts)} ends in a number; give (num, den), and the sample time as "
                "transfer_matrix((num, den), 'z', sample_time=dt)"
            )
    if not parts or not all(is_list(row) for row in parts):
        _refuse(parts)
    return _rows([[*row] for row in parts])


def _rows(rows: list[list[Any]]) -> Rows:
    lengths = {len(row) for row in rows}
    if len(lengths) != 1 or 0 in lengths:
        raise InputError(
            "a transfer matrix needs rows of one and the same nonzero length, as in "
            "[['1/s', 0], [0, '1/(s + 1)']]; numerator and denominator as lists of coefficients "
            "are one tuple, as in ([1], [1, 2])"
        )
    ask("entries", len(rows) * len(rows[0]), "the transfer matrix")
    for entry in (entry for row in rows for entry in row):
        if isinstance(entry, list) or is_array(entry):
            raise InputError(
                f"the entry {repr_of(entry)} of a matrix by rows is an ambiguous list; write the "
                "fraction of an entry as a tuple, as in [[([1], [1, 2])]]"
            )
    return Rows(rows)


def _level(part: Any) -> int:
    """How many levels of lists: 0 of a text, a number, a system; 2 of a matrix; -1 of none."""
    if isinstance(part, Number | str | System):
        return 0
    if isinstance(part, MatrixBase):
        return 2
    if is_array(part):
        return len(part.shape)
    if not isinstance(part, list | tuple | Tuple):
        return 0
    inner = {_level(entry) for entry in part[:1000]} or {0}
    return 1 + inner.pop() if len(inner) == 1 else 1 + max(inner)


def _is_nested(part: Any) -> bool:
    """Whether this is a matrix of lists of coefficients, by rows."""
    return _is_list_of(part, lambda row: _is_list_of(row, lambda entry: _level(entry) == 1)) or (
        is_array(part, dimensions=3)
    )


def _is_list_of(value: Any, is_right: Callable[[Any], bool]) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(map(is_right, value))


def _of_nested_lists(numerators: Any, denominators: Any) -> Rows:
    """The matrix whose numerators, and denominators, stand in nested lists by rows."""
    tops = [[*row] for row in numerators]
    if _level(denominators) == 1:
        bottoms = [[denominators] * len(row) for row in tops]
    else:
        bottoms = [[*row] for row in denominators]
    sizes = [[len(row) for row in rows] for rows in (tops, bottoms)]
    if sizes[0] != sizes[1]:
        raise InputError(
            f"the numerators stand in rows of {repr_of(sizes[0])} lists and the denominators in "
            f"rows of {repr_of(sizes[1])}; each entry needs both"
        )
    return _rows([
        [*zip(top, bottom, strict=True)] for top, bottom in zip(tops, bottoms, strict=True)
    ])  # fmt: skip


def _states(parts: Sequence[Any], variable: str | Symbol | None) -> States | None:
    """(A, B, C), (A, B, C, D) or (A, B, C, D, dt); one-dimensional B and C by the order of A."""
    if len(parts) not in (3, 4, 5):
        return None
    A, B, C, *rest = parts
    D = rest[0] if rest else None
    if not _is_matrix(A) or not (_is_matrix(D) or D is None or _is_zero(D) or _level(D) == 1):
        return None
    n, _ = _sizes(A)
    B = [[entry] for entry in B] if is_list(B) and not _is_matrix(B) and len(B) == n else B
    C = [[*C]] if is_list(C) and not _is_matrix(C) and len(C) == n else C
    if not (_is_matrix(B) and _is_matrix(C)):
        return None
    if isinstance(parts, list) and len(rest) < 2 and all(map(_holds_pairs, parts)):
        entries = [[*pair] for row in parts for pair in row]
        if {len(A), len(B)} != {2} or _shows(entries, variable):
            return None
        raise InputError(
            f"{repr_of(parts)} may be the matrices A, B and C or three rows of fractions; give the "
            "tuple (A, B, C), or transfer_function(...) in the entries of the rows"
        )
    if D is not None and not _is_matrix(D):
        D = None if _is_zero(D) else [[*D]]
    period = None if len(rest) < 2 else exact_number(rest[1])
    if period is not None and not (isinstance(period, Rational) and period > 0):
        raise InputError(
            f"the sample time {repr_of(rest[1])} beside (A, B, C, D) is no positive number of "
            "seconds; leave it out, and name the variable"
        )
    return States(A, B, C, D, sample_time=period)


def _is_matrix(obj: object) -> bool:
    if isinstance(obj, list | tuple):
        rows = [row for row in obj if isinstance(row, list | tuple)]
        return bool(obj) and len(rows) == len(obj) and not any(
            isinstance(entry, list | tuple) for row in rows for entry in row
        )  # fmt: skip
    return isinstance(obj, MatrixBase) or getattr(obj, "ndim", 0) == 2


def _sizes(matrix: Any) -> tuple[int, int]:
    shape = matrix.shape if hasattr(matrix, "shape") else (len(matrix), len(matrix[0]))
    return int(shape[0]), int(shape[1])


def _is_zero(D: object) -> bool:
    return isinstance(D, int | float | Expr) and not isinstance(D, bool) and D == 0


def _holds_pairs(matrix: Any) -> bool:
    """Whether every row is a list of tuples of two, which are fractions among rows."""
    return isinstance(matrix, list) and all(isinstance(r, tuple) and len(r) == 2 for r in matrix)


def _shows(lists: Sequence[Any], variable: str | Symbol | None) -> bool:
    """Whether two lists are rows: an entry contains the variable, or is a system."""
    named = None if variable is None else as_symbol(variable)

    def is_variable(symbol: Symbol) -> bool:
        return is_operator(symbol) if named is None else symbol == named

    for entry in (entry for one in lists for entry in one):
        if isinstance(entry, Number):
            continue
        if isinstance(entry, System | tuple) or is_foreign(entry):
            return True
        if isinstance(entry, Poly) and any(map(is_variable, entry.gens)):
            return True
        if isinstance(entry, str | Expr):
            try:
                read = exact_number(entry)
            except CompensatorError:  # the reader raises with the reason
                continue
            if any(map(is_variable, read.free_symbols)):
                return True
    return False


def _refuse_rows_of_numerators() -> NoReturn:
    raise InputError(
        "the numerator has rows, as scipy.signal.ss2tf gives one for each output, while "
        "python-control reads one entry for each input; give (num[0], den) for one output, and "
        "for several [[(num[0], den)], [(num[1], den)]]"
    )


def _refuse(parts: object) -> NoReturn:
    raise InputError(f"{repr_of(parts)} describes no system in a supported form; ", FORMS)
