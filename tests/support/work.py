"""What a block of a test costs, counted: the same numbers on every machine, quick or busy.

A refusal is held to the work that it is spared. What is counted are calls, draws from what is long
and bytes of objects. What one call of C does, inside flint for instance, nothing here sees: it is
bounded by the digits and degrees of its arguments, for which there is the budget and its own tests.
"""

import sys
import tracemalloc
from collections.abc import Sequence
from contextlib import contextmanager

import pytest


class at_most:  # a name that reads in a with
    """Fail as soon as the block has made more calls of Python and C functions than these.

    The failure is no Exception, so that nothing under test can take it for an error of its own.
    """

    def __init__(self, calls):
        self.limit, self.made = calls, 0

    def __enter__(self):
        self.before = sys.getprofile()
        sys.setprofile(self.count)
        return self

    def __exit__(self, *_):
        sys.setprofile(self.before)

    def count(self, frame, event, argument):
        if event in ("call", "c_call"):
            self.made += 1
            if self.made > self.limit:
                sys.setprofile(None)
                pytest.fail(f"this takes more than {self.limit} calls")


@contextmanager
def at_most_bytes(count):
    """Fail where the block at any moment holds more bytes of objects than these.

    Seen are those of Python and NumPy, whether or not the system had to give pages for them.
    """
    tracemalloc.start()
    try:
        yield
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak <= count, f"{peak} bytes at once, more than {count}"


class Long(Sequence):
    """A sequence that makes its entries as they are drawn, and counts them."""

    def __init__(self, length):
        self.length, self.drawn = length, 0

    def __len__(self):
        return self.length

    def __getitem__(self, index):
        if isinstance(index, slice):
            return Long(len(range(*index.indices(self.length))))
        if not -self.length <= index < self.length:
            raise IndexError(index)
        self.drawn += 1
        return index % self.length


class Endless:
    """An iterator that never ends, and counts what is drawn from it."""

    def __init__(self):
        self.drawn = 0

    def __iter__(self):
        return self

    def __next__(self):
        self.drawn += 1
        return self.drawn
