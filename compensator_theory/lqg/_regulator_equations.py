"""The regulator equations of Francis: steady states without error."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.lqg._solutions import solve_by_kronecker
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._letters import names_in_all, numbered
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation

IDENTITY = "Pi S = A Pi + B Gamma + P, 0 = C Pi + D Gamma + Q"


@dataclass(frozen=True)
class RegulatorSolution(ExactValue):
    r"""The steady state x = Pi w and the input u = Gamma w that keep the error zero.

    Attributes
    ----------
    Pi, Gamma : sympy.ImmutableMatrix
        n x r and m x r.
    homogeneous : tuple of (Pi, Gamma)
        Basis of the homogeneous solutions; empty where the solution is unique.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        Both equations, evaluated anew.
    """

    Pi: ImmutableMatrix
    Gamma: ImmutableMatrix
    homogeneous: tuple[tuple[ImmutableMatrix, ImmutableMatrix], ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def is_unique(self) -> bool:
        """Whether there is no other solution."""
        return not self.homogeneous

    def feedforward(self, K: MatrixLike) -> ImmutableMatrix:
        r"""Return L of u = K x + L w, :math:`L = \Gamma - K \Pi`: with A + BK stable e -> 0."""
        gain = exact_matrix(K, "K")
        if gain.shape != (self.Gamma.rows, self.Pi.rows):
            raise InputError(
                f"K is {gain.rows} x {gain.cols}; the plant needs a gain of "
                f"{self.Gamma.rows} x {self.Pi.rows}"
            )
        return ImmutableMatrix((self.Gamma - gain * self.Pi).applyfunc(sympy.cancel))

    def __str__(self) -> str:
        return f"Pi = {text(self.Pi.tolist())}, Gamma = {text(self.Gamma.tolist())}"

    def _repr_latex_(self) -> str:
        one, other = latex(self.Pi), latex(self.Gamma)
        letters = numbered(names_in_all(self), "alpha", len(self.homogeneous))
        for alpha, (state, control) in zip(letters, self.homogeneous, strict=True):
            one += f" + {latex(alpha)} {latex(state)}"
            other += f" + {latex(alpha)} {latex(control)}"
        return displayed(rf"\Pi = {one}", rf"\Gamma = {other}", unless(self.exceptional))


@carrying()
def solve_regulator_equations(
    plant: RealisationLike,
    S: MatrixLike,
    Q: MatrixLike,
    P: MatrixLike | None = None,
    *,
    variable: str | Symbol | None = None,
) -> RegulatorSolution:
    r"""Solve the regulator equations of a plant and an exosystem.

    .. math:: \dot w = S w, \quad \dot x = A x + B u + P w, \quad e = C x + D u + Q w

    .. math:: \Pi S = A \Pi + B \Gamma + P, \qquad 0 = C \Pi + D \Gamma + Q

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        n states, m inputs, p outputs; in discrete time the same equations hold.
    S : matrix
        r x r: the exosystem of commands and disturbances.
    Q : matrix
        p x r; a command y = H w to be followed is Q = -H.
    P : matrix, optional
        n x r, zero by default: how w drives the states.
    variable : str or Symbol, optional
        Of the plant; default: evident, bare matrices need it.

    Returns
    -------
    RegulatorSolution

    Raises
    ------
    NoSolutionError
        If the equations contradict each other: an eigenvalue of S is a zero of the plant.
    InputError, BudgetError
        If the shapes do not fit, or the matrices are too large.

    Notes
    -----
    There is a solution for every P and Q if and only if Rosenbrock's matrix has rank n + p at every
    eigenvalue of S. Source: B. A. Francis, SIAM J. Control and Optimization 15 (1977) 486-505.

    Examples
    --------
    >>> from compensator_theory import solve_regulator_equations
    >>> sine = [[0, 1], [-1, 0]]
    >>> solution = solve_regulator_equations("1/(s**2 + 3*s + 2)", sine, [[-1, 0]])
    >>> solution.Pi, solution.Gamma
    (Matrix([
    [1, 0],
    [0, 1]]), Matrix([[1, 3]]))
    """
    source = realisation(plant, variable)
    A, B, C, D = source.A, source.B, source.C, source.D
    s, q = exact_matrix(S, "S"), exact_matrix(Q, "Q")
    n, m, r = source.n, B.cols, s.rows
    p = zero_matrix(n, r) if P is None else exact_matrix(P, "P")
    if s.cols != r or not r or q.shape != (C.rows, r) or p.shape != (n, r):
        raise InputError(
            f"S is {s.rows} x {s.cols}, Q is {q.rows} x {q.cols} and P is {p.rows} x {p.cols}; for "
            f"this plant S must be square, r x r with r > 0, Q {C.rows} x r and P {n} x r"
        )

    states, no_input = identity_matrix(n), sympy.zeros(n, m)
    motion = [(states.row_join(no_input), s), (-A.row_join(B), identity_matrix(r))]
    solution, more, divisors = solve_by_kronecker(
        [motion, [(C.row_join(D), identity_matrix(r))]],
        (n + m, r),
        [*p, *(-q)],
        contradiction="the regulator equations have no solution: an eigenvalue of S is a zero of "
        "the plant (see invariant_zeros) or there are fewer inputs than outputs, and this command "
        "or disturbance cannot be met; change S, Q or P, or the plant's inputs and outputs",
        sources=(A, B, C, D, s, p, q),
    )
    Pi, Gamma = solution[:n, :], solution[n:, :]
    left = [Pi * s - A * Pi - B * Gamma - p, C * Pi + D * Gamma + q]
    for other in more:
        left += [other[:n, :] * s - A * other[:n, :] - B * other[n:, :]]
        left += [C * other[:n, :] + D * other[n:, :]]
    pairs = tuple((ImmutableMatrix(y[:n, :]), ImmutableMatrix(y[n:, :])) for y in more)
    return RegulatorSolution(
        ImmutableMatrix(Pi),
        ImmutableMatrix(Gamma),
        pairs,
        exceptional_factors(divisors),
        certificate_of(IDENTITY, left),
    )
