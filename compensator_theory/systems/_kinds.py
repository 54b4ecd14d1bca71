"""Descriptions of a system: the forms of lists, mappings and foreign systems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sympy import Rational, Symbol


@dataclass(frozen=True)
class Pair:
    """Numerator and denominator, each a polynomial in any form; a foreign system has the rest."""

    numerator: Any
    denominator: Any
    variable: Symbol | None = None
    sample_time: Rational | None = None


@dataclass(frozen=True)
class Roots:
    """Zeros, poles and the leading coefficient."""

    zeros: Any = None
    poles: Any = None
    gain: Any = None
    variable: Symbol | None = None
    sample_time: Rational | None = None


@dataclass(frozen=True)
class Rows:
    """A matrix by rows; an entry is a transfer function in any form."""

    entries: list[list[Any]]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of outputs and inputs."""
        return len(self.entries), len(self.entries[0])


@dataclass(frozen=True)
class States:
    """Matrices of a state space; with a sample time, they are discrete."""

    A: Any
    B: Any
    C: Any
    D: Any = None
    variable: Symbol | None = None
    sample_time: Rational | None = None
