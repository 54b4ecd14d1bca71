"""The result of a count of roots."""

from __future__ import annotations

from dataclasses import dataclass

from compensator_theory._latex import displayed, words
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class RootCount(ExactValue):
    """Numbers of roots with multiplicity on the two sides of a boundary and on it.

    Attributes
    ----------
    stable, boundary, unstable : int
        For the imaginary axis: real part below, equal to, above 0. For the unit circle: modulus
        below, equal to, above 1.

    Examples
    --------
    >>> from compensator_theory import count_roots
    >>> print(count_roots("(s + 1)*(s**2 + 1)**2", time="continuous"))
    1 stable, 4 on the boundary, 0 unstable
    """

    stable: int
    boundary: int
    unstable: int

    @property
    def total(self) -> int:
        """The degree."""
        return self.stable + self.boundary + self.unstable

    def __str__(self) -> str:
        return f"{self.stable} stable, {self.boundary} on the boundary, {self.unstable} unstable"

    def _repr_latex_(self) -> str:
        return displayed(words(str(self)))
