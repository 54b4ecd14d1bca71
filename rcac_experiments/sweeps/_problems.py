"""What can be wrong with a store: an error for who calls, and a word among its readers."""

from __future__ import annotations

from compensator_theory.errors import InputError


class StoreError(InputError):
    """The store of a study cannot be used: it is damaged, full, or of another study."""


class Damaged(Exception):
    """A file is not what was written; why."""
