"""SymPy matrices stored in python-flint; SymPy's entries are written on demand."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

from sympy import Expr, ImmutableMatrix, Integer, Matrix, Tuple

from compensator_theory._printing import long_representation, text

OF_SYMPY: dict[str, Callable[[Matrix, Matrix], ImmutableMatrix]] = {
    "add": ImmutableMatrix._eval_add,
    "multiply": ImmutableMatrix._eval_matrix_mul,
    "beside": ImmutableMatrix._eval_row_join,
    "below": ImmutableMatrix._eval_col_join,
}
"""SymPy's operations on two matrices, by name."""


class FlintBackedMatrix(ImmutableMatrix):  # type: ignore[misc]
    """Base of the matrices stored in python-flint, equal to the ImmutableMatrix of their entries.

    Hash, text and pickle are those of that matrix. A derived class defines how entries are written
    and which operations stay in python-flint.
    """

    _mhash: int | None
    _class_priority = ImmutableMatrix._class_priority + 1

    @classmethod
    def _of_shape(cls, rows: int, columns: int) -> Any:
        matrix = object.__new__(cls)
        matrix._rows, matrix._cols = rows, columns
        matrix._mhash = None
        matrix._assumptions = cls.default_assumptions
        return matrix

    @property
    @abstractmethod
    def _args(self) -> tuple[Integer, Integer, Tuple]:
        """SymPy's arguments, with the entries written."""

    @abstractmethod
    def _entry(self, row: int, column: int) -> Expr:
        """One entry, written."""

    def __hash__(self) -> int:
        if self._mhash is None:
            self._mhash = hash((ImmutableMatrix.__name__, *self._hashable_content()))
        return self._mhash

    def __eq__(self, other: object) -> bool:
        equal: bool = super().__eq__(other)  # or that SymPy does not know
        return equal

    def __reduce_ex__(self, protocol: Any) -> tuple[type, tuple[Any, ...]]:
        return ImmutableMatrix, self._args

    def __str__(self) -> str:
        try:
            return str(super().__str__())
        except ValueError:  # an integer that is longer than Python writes
            return f"Matrix({text(self.tolist())})"

    def __repr__(self) -> str:
        try:
            return str(super().__repr__())
        except ValueError:
            return long_representation(self)

    def _sympyrepr(self, printer: Any) -> str:
        """Return SymPy's representation of the equal ImmutableMatrix."""
        return str(printer.doprint(ImmutableMatrix(*self._args)))

    _pythoncode = _sympyrepr

    def __iter__(self) -> Iterator[Expr]:
        return iter(self._args[2].args)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, int):
            key = divmod(range(self._rows * self._cols)[key], self._cols)
        if not (isinstance(key, tuple) and all(isinstance(k, int | slice | list) for k in key)):
            return super().__getitem__(key)
        i, j = map(_places, key, (self._rows, self._cols))
        if isinstance(i, int) and isinstance(j, int):
            return self._entry(i, j)
        return self._eval_extract(*([k] if isinstance(k, int) else k for k in (i, j)))

    def _delegate(self, operation: str, other: Matrix) -> ImmutableMatrix:
        """Delegate an operation to the other matrix if it is in python-flint too, else to SymPy."""
        if isinstance(other, FlintBackedMatrix):
            return other._right_of(self, operation)
        return OF_SYMPY[operation](self, other)

    @abstractmethod
    def _right_of(self, left: Matrix, operation: str) -> ImmutableMatrix:
        """Do an operation that the left matrix, which has another type, cannot do."""


def _places(key: Any, size: int) -> Any:
    return [range(size)[k] for k in key] if isinstance(key, list) else range(size)[key]
