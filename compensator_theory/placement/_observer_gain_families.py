"""Every observer gain that places given poles: the transposes of state feedbacks."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import NotControllableError, NotObservableError
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.placement._gain_families import (
    StateFeedbackFamily,
    state_feedback_family,
)
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike
from compensator_theory.polynomials._letters import variable_for_matrix
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._controllability import uncontrollable_polynomial


@dataclass(frozen=True)
class ObserverGainFamily(Certified, ExactValue):
    r"""All gains F that make A - F C similar to one matrix; the transpose of a state feedback.

    .. math:: A - F C = (A' + C' K)', \qquad F = -K'

    Attributes
    ----------
    dual : StateFeedbackFamily
        That of (A', C').
    """

    _CARRIES = True

    identity = "A' X + C' G = X Lambda for every parameter, det(sI - Lambda) = p"

    dual: StateFeedbackFamily

    def _residuals(self) -> Residuals:
        return self.dual._residuals()

    def gain(self, parameters: MatrixLike | None = None) -> ImmutableMatrix:
        """Return F, n x p, for the parameters of the dual; see :class:`StateFeedbackFamily`."""
        return ImmutableMatrix(-self.dual.gain(parameters).T)

    def __str__(self) -> str:
        p, n = self.dual.shape
        polynomial = format_polynomial(self.dual.polynomial)
        s, more = self.dual.polynomial.gen, self.dual.structure.replace("A + BK", "(A - FC)'")
        gains = f"all {n} x {p} gains with det({s}I - A + FC) = {polynomial}{more}"
        return f"{gains}, by {p} x {n} parameters"

    def _repr_latex_(self) -> str:
        s, (p, n) = latex(self.dual.polynomial.gen), self.dual.shape
        return displayed(
            rf"F = -\left(G(\Phi)\, X(\Phi)^{{-1}}\right)^T, \quad "
            rf"\Phi \in \mathbb{{R}}^{{{p} \times {n}}}",
            rf"\det({s} I - A + F C) = {latex(self.dual.polynomial)}",
            unless(self.dual.exceptional),
        )


@carrying()
def observer_gain_family(
    A: MatrixLike,
    C: MatrixLike,
    poles: SpectrumLike | None = None,
    *,
    Lambda: MatrixLike | None = None,
    variable: str | Symbol | None = None,
) -> ObserverGainFamily:
    r"""Find every F that places the eigenvalues of A - F C.

    Parameters
    ----------
    A, C : matrix
        n x n and p x n, observable.
    poles, variable, Lambda
        As for :func:`state_feedback_family`.

    Raises
    ------
    NotObservableError
        If (A, C) is not observable.
    InputError
        As for :func:`state_feedback_family`.

    Examples
    --------
    >>> from compensator_theory import observer_gain_family
    >>> observer_gain_family([[-1, 4], [0, -3]], [[1, 0]], [-2, -6]).gain().T  # Example 7.1
    Matrix([[4, -3/4]])
    """
    a, c = exact_matrix(A, "A"), exact_matrix(C, "C")
    try:
        return ObserverGainFamily(
            state_feedback_family(a.T, c.T, poles, variable=variable, Lambda=Lambda)
        )
    except NotControllableError as error:
        symbol = variable_for_matrix(variable, a, c)
        fixed = format_polynomial(uncontrollable_polynomial(a.T, c.T, variable=symbol))
        raise NotObservableError(
            f"(A, C) is not observable: every A - FC keeps the roots of {fixed}. Remove these "
            "modes from the plant, or measure more"
        ) from error
