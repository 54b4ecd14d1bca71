"""What a conversion leaves behind to be checked: an identity, and what is left of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix

from compensator_theory.errors import NoSolutionError
from compensator_theory.latex import displayed, latex, words
from compensator_theory.matrices.fraction_free import vanish
from compensator_theory.polynomials.values import ExactValue


@dataclass(frozen=True)
class Certificate(ExactValue):
    """An exact identity between a result and what it was made from, evaluated.

    Attributes
    ----------
    identity : str
        What was checked.
    residual : sympy.ImmutableMatrix
        What is left of it, computed from the source; the identity holds if it is zero.

    Examples
    --------
    >>> from compensator_theory import realisation
    >>> G = realisation("(s + 3)/(s**2 + 2*s)").transfer_function()
    >>> G.certificate.holds, G.certificate.identity
    (True, 'adj(sI - A) B by (sI - A) adj(sI - A) B = det(sI - A) B')
    """

    identity: str
    residual: ImmutableMatrix

    @property
    def holds(self) -> bool:
        """Whether nothing is left."""
        return bool(self.residual.is_zero_matrix)

    def __str__(self) -> str:
        return f"{self.identity}: {'holds exactly' if self.holds else 'FAILS'}"

    def _repr_latex_(self) -> str:
        left = "" if self.holds else f"{words('left is')} {latex(self.residual)}"
        return displayed(words(str(self)), left)


def proven(certificate: Certificate, what: str = "result") -> Certificate:
    """Return a certificate that holds.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.matrices.certificates import Certificate, proven
    >>> print(proven(Certificate("1 - 1 = 0", ImmutableMatrix([[0]])), "difference"))
    1 - 1 = 0: holds exactly
    """
    if not certificate.holds:
        raise NoSolutionError(f"{certificate}; the {what} is wrong, please report it")
    return certificate


def certificate_of(
    identity: str, residuals: Iterable[Iterable[Expr]], what: str = "result"
) -> Certificate:
    """Return the certificate of matrices, or lists of expressions, that must vanish.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.certificates import certificate_of
    >>> certificate_of("0 = 0", [Matrix([[0]])]).holds
    True
    """
    entries = [entry for matrix in residuals for entry in matrix]
    left = [
        entry if entry.is_Rational else sympy.Integer(0) if is_zero else sympy.cancel(entry)
        for entry, is_zero in zip(entries, vanish(entries), strict=True)
    ]
    return proven(Certificate(identity, ImmutableMatrix(1, len(left), left)), what)
