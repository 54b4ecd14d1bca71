"""Checks of Propositions 3 and 4 on the matrix of the pole placement equation."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, words
from compensator_theory.bezout._sylvester import sylvester_m, sylvester_m1, sylvester_m2
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, integer, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class PropositionCheck(ExactValue):
    """Both sides of an equivalence, evaluated for one case.

    Attributes
    ----------
    statement : str
        The claim.
    left, right : bool
        Its two sides.
    printed_right : bool
        The right side as the text prints it.

    Examples
    --------
    >>> from compensator_theory.bezout import check_proposition_3
    >>> print(check_proposition_3("s**2 + 3*s + 2", "s + 5", n_c=4, m_hat=1))
    holds: M = M1(D, N) is True, m_hat = n - 1 is True
    as printed (with n_c <= n): does not hold
    """

    _ANSWER = "holds"

    statement: str
    left: bool
    right: bool
    printed_right: bool

    @property
    def holds(self) -> bool:
        """Whether the corrected equivalence is true of this case."""
        return self.left == self.right

    @property
    def printed_holds(self) -> bool:
        """Whether the equivalence as the text prints it is true of this case."""
        return self.left == self.printed_right

    def __str__(self) -> str:
        equation, condition = self.statement.split(" iff ")
        verdict = "holds" if self.holds else "does not hold"
        lines = [f"{verdict}: {equation} is {self.left}, {condition} is {self.right}"]
        if self.printed_right != self.right:
            printed = "holds" if self.printed_holds else "does not hold"
            lines.append(f"as printed (with n_c <= n): {printed}")
        return "\n".join(lines)

    def _repr_latex_(self) -> str:
        return displayed(words(str(self)))


@refusing
def check_proposition_3(
    D: PolynomialLike,
    N: PolynomialLike,
    n_c: int,
    m_hat: int,
    *,
    variable: str | Symbol | None = None,
) -> PropositionCheck:
    r"""Check when the matrix of (7.38) is the Sylvester matrix of D and N.

    .. math:: M = \mathcal M_1(D, N) \iff \hat m_c = n - 1

    Parameters
    ----------
    D, N : polynomial
        Of degrees n and :math:`m < n`.
    n_c, m_hat : int
        Order and formal numerator degree of the compensator, :math:`n_c \ge m`.
    variable : str or Symbol, optional
        Default: evident from D and N together.

    Raises
    ------
    InputError
        If deg N >= deg D, or n_c < deg N, so that N has no formal degree n_c, or a degree is no
        integer.

    Notes
    -----
    Source: Proposition 3, N read with formal degree n_c. The text adds :math:`n_c \le n` to the
    right side, because its :math:`\mathcal M_1` requires :math:`l \le k`; the equality holds
    without it.

    Examples
    --------
    >>> from compensator_theory.bezout import check_proposition_3
    >>> proposition = check_proposition_3("s**2 + 3*s + 2", "s + 5", n_c=2, m_hat=1)
    >>> proposition.left, proposition.holds, proposition.printed_holds
    (True, True, True)
    """
    d, b, n = _read(D, N, n_c, m_hat, variable)
    left = _matrix(d, b, n_c, m_hat) == sylvester_m1(d, b, n, n_c)
    right = m_hat == n - 1
    return PropositionCheck("M = M1(D, N) iff m_hat = n - 1", left, right, right and n_c <= n)


@refusing
def check_proposition_4(
    D: PolynomialLike,
    N: PolynomialLike,
    n_c: int,
    m_hat: int,
    *,
    variable: str | Symbol | None = None,
) -> PropositionCheck:
    r"""Check when the matrix of (7.38) is the 2n x 2n Sylvester matrix of D and N.

    .. math:: M = \mathcal M_2(D, N) \iff \hat m_c = n - 1 \text{ and } n_c = n

    Parameters
    ----------
    D, N, n_c, m_hat
        As for :func:`check_proposition_3`.

    Raises
    ------
    InputError
        As for :func:`check_proposition_3`.

    Notes
    -----
    Source: Proposition 4.

    Examples
    --------
    >>> from compensator_theory.bezout import check_proposition_4
    >>> print(check_proposition_4("s**2 + 3*s + 2", "s + 5", n_c=2, m_hat=1))
    holds: M = M2(D, N) is True, m_hat = n - 1 and n_c = n is True
    """
    d, b, n = _read(D, N, n_c, m_hat, variable)
    left = _matrix(d, b, n_c, m_hat) == sylvester_m2(d, b)
    right = m_hat == n - 1 and n_c == n
    return PropositionCheck("M = M2(D, N) iff m_hat = n - 1 and n_c = n", left, right, right)


def _read(
    D: PolynomialLike, N: PolynomialLike, n_c: int, m_hat: int, variable: str | Symbol | None
) -> tuple[Poly, Poly, int]:
    d, b = in_one_variable(D, N, variable=variable, default="s")
    n, m = int(d.degree()), int(max(b.degree(), 0))
    if m >= n:
        raise InputError(f"deg N = {m} must be below deg D = {n}, as for a strictly proper plant")
    if integer(n_c, "n_c") < m:
        raise InputError(f"n_c = {repr_of(n_c)} must be an integer of at least deg N = {m}")
    integer(m_hat, "the degree m_hat of a numerator")
    ask("entries", (n + n_c) ** 2, "the Sylvester matrix")
    return d, b, n


def _matrix(D: Poly, N: Poly, n_c: int, m_hat: int) -> ImmutableMatrix | None:
    """Return M, or None where a numerator of degree m_hat does not fit the equation."""
    try:
        return sylvester_m(D, N, n_c, m_hat)
    except InputError:
        return None
