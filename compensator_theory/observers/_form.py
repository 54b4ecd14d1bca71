"""One observer-based form of a realisation, with everything needed to check it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
    multiplied,
    rank,
    solve,
)
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import total
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._realisations import Realisation


@dataclass(frozen=True)
class ObserverForm(Certified, ExactValue):
    r"""A change of basis that shows a compensator to be an observer with state feedback.

    .. math:: x_c = T\hat x, \qquad T^{-1} A_c T = A + BK - FC, \quad T^{-1} B_c = F,
              \quad C_c T = K

    Attributes
    ----------
    plant, compensator : Realisation
        As given, of orders n and :math:`n_c`.
    T : sympy.ImmutableMatrix
        :math:`n_c \times n` and of full rank; :math:`x_c \to Tx`. The columns of [I; T] span an
        invariant subspace of the closed loop.
    regulator : sympy.Poly
        :math:`p_R = \det(sI - A - B C_c T)`, of degree n.
    observer : sympy.Poly
        :math:`p_O = \det(sI - A_c + T B C_c)`, of degree :math:`n_c`: the error
        :math:`x_c - Tx`.
    parameters : tuple of Symbol
        Free parameters of a continuum of forms; empty for a single form.

    Notes
    -----
    For :math:`n_c < n` this is Luenberger's observer of the function Tx of the state, without F;
    for :math:`n_c > n` see :func:`youla_forms`. Source: (7.11)-(7.18).
    """

    identity = "B_c C + A_c T = T (A + B K), T of full rank, both spectra, F where n_c = n"

    plant: Realisation
    compensator: Realisation
    T: ImmutableMatrix
    regulator: Poly
    observer: Poly
    parameters: tuple[Symbol, ...] = ()

    @property
    def K(self) -> ImmutableMatrix:
        """Regulator gain C_c T; u = Kx on the invariant subspace."""
        return multiplied(self.compensator.C, self.T)

    @property
    def F(self) -> ImmutableMatrix | None:
        """Observer gain T^-1 B_c; None unless n_c = n."""
        square = self.T.rows == self.T.cols
        return solve(self.T, self.compensator.B) if square else None

    @property
    def residual(self) -> ImmutableMatrix:
        """The residual of B_c C + A_c T = T (A + B C_c T), recomputed; zero."""
        A, B, C = self.plant.A, self.plant.B, self.plant.C
        C_y = C + self.plant.D * self.compensator.C * self.T
        left = self.compensator.B * C_y + self.compensator.A * self.T
        return in_lowest_terms(left - self.T * (A + B * self.K))

    def _residuals(self) -> list[ImmutableMatrix | Poly]:
        A, B, C = self.plant.A, self.plant.B, self.plant.C
        A_c, s, K = self.compensator.A, self.plant.variable, self.K
        inner = A_c + self.compensator.B * self.plant.D * self.compensator.C
        spectra = (
            (A + B * K, self.regulator),
            (inner - self.T * B * self.compensator.C, self.observer),
        )
        left = [
            self.residual,
            ImmutableMatrix([[min(self.T.shape) - rank(self.T)]]),
            *(
                total(characteristic_polynomial(in_lowest_terms(matrix), s), poly * -1)
                for matrix, poly in spectra
            ),
        ]
        F = self.F
        if F is not None:
            built = A + B * K - F * C - F * self.plant.D * K
            left.append(in_lowest_terms(A_c * self.T - self.T * built))
        return left

    @property
    def squared_condition(self) -> Expr:
        r""":math:`\|T\|_F^2\,\|T^{+}\|_F^2`, exact; T amplifies errors by at most its root."""
        gram = self.T.T * self.T if self.T.rows >= self.T.cols else self.T * self.T.T
        return sympy.cancel(gram.trace() * solve(gram, identity_matrix(gram.rows)).trace())

    def at(self, values: Sequence[NumberLike]) -> ObserverForm:
        """Return the form for given values of the parameters.

        Parameters
        ----------
        values : sequence
            One number for each of :attr:`parameters`.

        Raises
        ------
        InputError
            If their number is wrong, or T has no full rank or no finite value there.
        """
        if len(values) != len(self.parameters):
            raise InputError(
                f"there are {len(values)} values for the {len(self.parameters)} parameters "
                f"{self.parameters}"
            )
        chosen = dict(zip(self.parameters, map(exact_number, values), strict=True))
        T = self.T.subs(chosen)
        if T.has(sympy.zoo, sympy.nan) or rank(T) < min(T.shape):
            raise InputError(f"at {chosen} the subspace gives no observer; choose other values")
        return ObserverForm(self.plant, self.compensator, T, self.regulator, self.observer)

    def __str__(self) -> str:
        gains = f"K = {text(self.K.tolist())}"
        if (F := self.F) is not None:
            gains += f", F = {text(F.tolist())}"
        free = f", for all values of {self.parameters}" if self.parameters else ""
        return (
            f"regulator {format_polynomial(self.regulator)}; "
            f"observer {format_polynomial(self.observer)}{free}\n"
            f"  {gains}, T = {text(self.T.tolist())}"
        )

    def _repr_latex_(self) -> str:
        F = "" if self.F is None else f"F = {latex(self.F)}"
        return displayed(
            f"p_R = {latex(self.regulator)}",
            f"p_O = {latex(self.observer)}",
            f"K = {latex(self.K)}",
            F,
            f"T = {latex(self.T)}",
        )


def form_of_subspace(
    plant: Realisation,
    compensator: Realisation,
    subspace: Matrix,
    spectra: tuple[Poly, Poly],
    parameters: tuple[Symbol, ...] = (),
) -> ObserverForm | str:
    r"""Return the form of an invariant subspace, or the reason why none exists.

    .. math:: T = V_2 V_1^{-1}, \qquad \mathrm{im} \begin{bmatrix} V_1 \\ V_2 \end{bmatrix}
              \text{ invariant under } \tilde A
    """
    n, n_c, siso = plant.n, compensator.n, plant.is_siso
    V_1, V_2 = subspace[:n, :], subspace[n:, :]
    try:
        T = solve(V_1.T, V_2.T).T
    except NoSolutionError:
        return (
            f"V_1 has rank {rank(V_1)} and not {n}: some compensator state in the subspace goes "
            "with no plant state" + (": an unobservable mode of the compensator" if siso else "")
        )
    if rank(T) < min(n, n_c):
        return (
            f"T has rank {rank(T)} and not {min(n, n_c)}: some compensator state follows no plant "
            "state" + (": an uncontrollable mode outside the regulator" if siso else "")
        )
    return ObserverForm(plant, compensator, ImmutableMatrix(T), *spectra, parameters)
