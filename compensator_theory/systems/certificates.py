"""What a conversion leaves behind to be checked: an identity, and what is left of it."""

from dataclasses import dataclass

from sympy import ImmutableMatrix

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
