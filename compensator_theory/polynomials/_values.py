"""Base of the public data classes: pickling and printing."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, ClassVar

from sympy import Poly

from compensator_theory._few_lines import in_few_lines
from compensator_theory._latex import latex
from compensator_theory._terminal import result_repr
from compensator_theory._truth import Truth
from compensator_theory.polynomials._carrying import (
    MARK,
    carry_methods,
    has_functions,
    polynomial_with_functions,
)
from compensator_theory.polynomials._poly import canonical


class ExactValue(Truth):
    """Base of the frozen data classes: a pickle has the fields, without caches.

    SymPy rebuilds the domain of a pickled polynomial from its coefficients, ZZ[a] for QQ[a], so
    that it equals the original no more; it is put into canonical form again. What a result says of
    itself may hold integers that are longer than Python prints without being told.
    """

    _CARRIES: ClassVar[bool | str] = False
    """Whether its methods take functions of symbols; "reals": those of real values only."""
    _REST: ClassVar[str] = ""
    """The attributes that have the omitted lines of a printed result."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__str__" in vars(cls):
            cls.__str__ = in_few_lines(vars(cls)["__str__"])  # type: ignore[method-assign]
        carry_methods(cls, ExactValue)
        if "__repr__" not in vars(cls):
            cls.__repr__ = result_repr  # type: ignore[method-assign]

    def _latex(self, printer: object = None) -> str:
        """Return the LaTeX of the notebook for SymPy's `latex`."""
        return latex(self)

    def __getstate__(self) -> dict[str, object]:
        state = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return state | ({MARK: None} if MARK in vars(self) else {})

    def __setstate__(self, state: dict[str, object]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, _restored(value))


def _restored(value: Any) -> Any:
    if isinstance(value, Poly):
        if has_functions(value):
            return polynomial_with_functions(value.all_coeffs(), value.gen)
        return canonical(value)
    return tuple(map(_restored, value)) if isinstance(value, tuple) else value
