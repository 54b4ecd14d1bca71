"""How much a file may hold, asked before it is read."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from compensator_theory.errors import InputError

# A million steps of thirty signals; 268 MB as float64.
MOST_NUMBERS = 2**25
MOST_BYTES = 8 * MOST_NUMBERS


class Budget:
    """What is left of the numbers that one file may hold.

    Examples
    --------
    >>> import pathlib
    >>> from rcac_numeric.signals.budget import Budget
    >>> Budget(pathlib.Path("log.mat")).take([1000, 10])
    10000
    >>> Budget(pathlib.Path("log.mat")).take([10**6, 10**6])
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: log.mat holds more than 33554432 numbers; cut it.
    """

    def __init__(self, file: Path) -> None:
        self.file, self.left = file, MOST_NUMBERS

    def take(self, shape: Iterable[int]) -> int:
        """The number of entries of a shape, which the budget must have room for."""
        count = math.prod(shape)
        if count > self.left:
            raise InputError(f"{self.file} holds more than {MOST_NUMBERS} numbers; cut it.")
        self.left -= count
        return count


def require_readable(file: Path) -> None:
    """Refuse what is no ordinary file, such as a device that never ends, and what is too large."""
    size = file.stat().st_size
    if not file.is_file():
        raise InputError(f"{file} cannot be read: it is no ordinary file.")
    if size == 0:
        raise InputError(f"{file} is empty.")
    if size > MOST_BYTES:
        raise InputError(f"{file} has {size} bytes; at most {MOST_BYTES} are read. Cut it.")
