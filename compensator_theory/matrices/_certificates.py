"""Certificates of results: an identity and its residual."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._flint_matrices import RationalMatrix, from_flint
from compensator_theory.matrices._rational_functions import vanish
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class Certificate(ExactValue):
    """An exact identity between a result and its source, evaluated.

    Attributes
    ----------
    identity : str
        The identity that was checked.
    residual : sympy.ImmutableMatrix
        The residual, computed from the source; the identity holds if it is zero.

    Examples
    --------
    >>> from compensator_theory import realisation
    >>> G = realisation("(s + 3)/(s**2 + 2*s)").transfer_function()
    >>> G.certificate.holds, G.certificate.identity
    (True, 'adj(sI - A) B by (sI - A) adj(sI - A) B = det(sI - A) B')
    """

    _ANSWER = "holds"

    identity: str
    residual: ImmutableMatrix

    @property
    def holds(self) -> bool:
        """Whether the residual is zero."""
        return bool(self.residual.is_zero_matrix)

    def __str__(self) -> str:
        return f"{self.identity}: {'holds exactly' if self.holds else 'FAILS'}"

    def _repr_latex_(self) -> str:
        left = "" if self.holds else f"{words('residual:')} {latex(self.residual)}"
        return displayed(words(str(self)), left)


def proven(certificate: Certificate, subject: str = "result") -> Certificate:
    """Return a certificate that holds."""
    if not certificate.holds:
        raise NoSolutionError(f"{certificate}; the {subject} is wrong, please report it")
    return certificate


Residuals: TypeAlias = Iterable[Iterable[Expr] | Poly]
"""Matrices, lists of expressions and polynomials that vanish by an identity."""


def certificate_of(identity: str, residuals: Residuals, subject: str = "result") -> Certificate:
    """Return the certificate of residuals that must vanish; raise if one does not."""
    return proven(evaluated(identity, residuals), subject)


def evaluated(identity: str, residuals: Residuals) -> Certificate:
    """Return the certificate of an identity, whether it holds or not."""
    parts = [part.all_coeffs() if isinstance(part, Poly) else part for part in residuals]
    rational = [part.flint_form for part in parts if isinstance(part, RationalMatrix)]
    if len(rational) == len(parts):
        numbers = [entry for part in rational for entry in part.entries()]
        matrix = from_flint(flint.fmpq_mat(1, len(numbers), numbers))
        return Certificate(identity, matrix)
    entries = [entry for part in parts for entry in part]
    left = [
        sympy.Integer(0) if is_zero else sympy.cancel(entry)
        for entry, is_zero in zip(entries, vanish(entries), strict=True)
    ]
    return Certificate(identity, ImmutableMatrix(1, len(left), left))


class Certified:
    """Base of the results that can be compared with their source from their fields alone.

    A class defines its `identity`, and in `_residuals` the expressions that must vanish. The check
    uses nothing of the algorithm that computed the result.
    """

    identity: ClassVar[str]

    def _residuals(self) -> Residuals:
        raise NotImplementedError

    @property
    def certificate(self) -> Certificate:
        """The identity, evaluated anew from the fields of this result."""
        return evaluated(self.identity, self._residuals())

    @property
    def is_verified(self) -> bool:
        """Whether the certificate holds."""
        return self.certificate.holds
