"""What is wrong with the folder of a study, in words that help."""

from __future__ import annotations

from compensator_theory.errors import InputError


class StoreError(InputError):
    """The store of a study cannot be used: it is damaged, full, or of another study."""
