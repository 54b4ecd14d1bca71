"""Defects of a store: an error for users, and an internal one among its readers."""

from __future__ import annotations

from compensator_theory.errors import InputError


class StoreError(InputError):
    """The store of a study cannot be used: it is damaged, full, or of another study."""


class Damaged(Exception):
    """A damaged file, with the reason."""
