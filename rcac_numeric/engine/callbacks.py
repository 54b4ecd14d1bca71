"""Functions of the user that the kernel calls, and what becomes of their exceptions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Failures:
    """Holds the first exception that a user's function raised while the kernel ran."""

    def __init__(self) -> None:
        self.error: Exception | None = None

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """`function`, but an exception is kept here and None returned."""

        def guarded(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as error:
                self.error = self.error or error
                return None

        return guarded

    def take(self) -> Exception | None:
        """The exception, which is forgotten here."""
        error, self.error = self.error, None
        return error
