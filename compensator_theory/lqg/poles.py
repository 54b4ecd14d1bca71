"""LQG closed-loop poles of plants with any number of signals, by an exact determinant."""

from collections.abc import Callable
from dataclasses import dataclass

import flint
import sympy
from sympy import Poly, Symbol

from compensator_theory.errors import (
    InputError,
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from compensator_theory.lqg.regulator_data import regulator_data
from compensator_theory.matrices.exact_matrices import MatrixLike
from compensator_theory.matrices.flint_matrices import rational, to_flint
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import as_symbol, require_discrete
from compensator_theory.roots.counts import RootCount
from compensator_theory.roots.enclosures import PolynomialEnclosure
from compensator_theory.roots.reciprocals import reciprocal_polynomial
from compensator_theory.roots.schur_cohn import count_unit_disk_roots
from compensator_theory.roots.spectral_factors import SpectralFactor, factor_palindrome
from compensator_theory.roots.unit_circle_enclosures import multiply_enclosures
from compensator_theory.systems.controllability import uncontrollable_polynomial
from compensator_theory.systems.standard_problems import StandardProblem


@dataclass(frozen=True)
class LQGPoles(ExactValue):
    r"""Where LQG puts the closed-loop poles.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    regulator, estimator : SpectralFactor
        The polynomials of :math:`A + BC_c` and :math:`A - B_cC`, each of degree n.

    Notes
    -----
    Source: (A.11).

    Examples
    --------
    >>> from compensator_theory import lqg_poles, standard_problem
    >>> print(lqg_poles(standard_problem("(q - 2)/(q**2 - 1/4)")))
    regulator: q**2 - q/2
    estimator: q**2 - q/2
    """

    regulator: SpectralFactor
    estimator: SpectralFactor

    @property
    def polynomial(self) -> Poly | None:
        """The closed-loop polynomial of degree 2n if it is rational, else None."""
        if self.regulator.polynomial is None or self.estimator.polynomial is None:
            return None
        return canonical(self.regulator.polynomial * self.estimator.polynomial)

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return multiply_enclosures(self.regulator.enclosure, self.estimator.enclosure)

    def __str__(self) -> str:
        names = (("regulator", self.regulator), ("estimator", self.estimator))
        return "\n".join(
            f"{name}: {f.enclosure if f.polynomial is None else format_polynomial(f.polynomial)}"
            for name, f in names
        )

    def _repr_latex_(self) -> str:
        product = self.polynomial
        text = self.enclosure.latex() if product is None else sympy.latex(product.as_expr())
        return rf"$\displaystyle \tilde D = {text}$"


def lqg_poles(plant: StandardProblem, *, digits: int = 30) -> LQGPoles:
    r"""Find the closed-loop poles of LQG without solving a Riccati equation.

    Parameters
    ----------
    plant : StandardProblem
        Rational, any number of signals; :math:`R_2 = E_2^TE_2` and :math:`V_2 = D_2D_2^T` may be
        singular or zero.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    LQGPoles

    Raises
    ------
    UnitCircleError
        If a zero of :func:`regulator_spectrum` is on the unit circle (an uncontrollable or
        unobservable mode there included).
    NoSolutionError
        If a spectrum is zero, for instance with :math:`N_{zu} = 0` or with more inputs u than
        outputs z and :math:`R_2 = 0`.
    InputError
        If an entry is symbolic, or the plant is not written in z or q.

    Notes
    -----
    Hidden modes inside the unit circle stay closed-loop poles; others are refused. Source:
    (A.4)-(A.12), with the assumptions ii) and iv) replaced by what :math:`R_2 = 0` needs: no zero
    on the unit circle.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, lqg_poles
    >>> plant = StandardProblem(A=[[2, 1], [0, "1/2"]], B=[[1, 0], [0, 1]], C=[[1, 0], [0, 1]],
    ...     D_1=[[1, 0], [0, 1]], D_0=None, D_2=None, E_1=[[1, 0], [0, 1]], E_2=None, E_0=None)
    >>> lqg_poles(plant).polynomial
    Poly(q**4, q, domain='QQ')
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    q = plant.variable
    require_discrete(q, "LQG")
    require_stable_hidden_modes(plant, count_unit_disk_roots, "inside the unit circle")
    regulator = regulator_spectrum(plant.A, plant.B, plant.E_1, plant.E_2, q)
    estimator = regulator_spectrum(plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, q)
    factors = []
    for name, spectrum in (("from u to z", regulator), ("from w to y", estimator)):
        try:
            factors.append(factor_palindrome(spectrum, plant.n, digits))
        except UnitCircleError as error:
            raise UnitCircleError(
                f"the transfer matrix {name} has a zero on the unit circle, so that no LQG "
                f"controller is stabilising: {error}"
            ) from error
        except NoSolutionError as error:
            raise NoSolutionError(
                f"the transfer matrix {name} has too small a rank: the weights do not determine "
                "the controller. Weight u (or add sensor noise), or drop a signal"
            ) from error
    return LQGPoles(*factors)


def regulator_spectrum(
    A: MatrixLike, B: MatrixLike, E_1: MatrixLike, E_2: MatrixLike, variable: str | Symbol
) -> Poly:
    r"""Return the palindromic polynomial whose stable roots are the regulator's poles.

    .. math:: p(z) = \pm\det\begin{bmatrix} A - zI & 0 & B \\ -R_1 & I - zA^T & -R_{12} \\
              R_{12}^T & zB^T & R_2 \end{bmatrix}
              = z^{n}\, \det\!\left(G^T(1/z)\,G(z)\right) D(z) D(1/z)

    with :math:`G = E_1(zI - A)^{-1}B + E_2` and :math:`D = \det(zI - A)`.

    Parameters
    ----------
    A, B, E_1, E_2 : matrix
        n x n, n x l_u, l_z x n, l_z x l_u, rational; :math:`R_1 = E_1^TE_1`,
        :math:`R_{12} = E_1^TE_2`, :math:`R_2 = E_2^TE_2`.
    variable : str or Symbol
        z or q: the equation is for discrete time.

    Returns
    -------
    sympy.Poly
        Of degree 2n or less, computed from its values at 2n + 1 integers. For the estimator give
        the transposes :math:`A^T, C^T, D_1^T, D_2^T`.

    Raises
    ------
    InputError
        If a shape does not fit or an entry is symbolic.

    Examples
    --------
    >>> from sympy.abc import z
    >>> from compensator_theory import regulator_spectrum
    >>> regulator_spectrum([[3]], [[1]], [[2]], [[0]], z).as_expr()
    4*z
    """
    a, b, e_1, e_2 = regulator_data(A, B, E_1, E_2)
    symbol = as_symbol(variable)
    require_discrete(symbol, "the spectrum of an LQG regulator")
    n, l_u = b.shape
    constant = sympy.BlockMatrix(
        [[a, sympy.zeros(n, n), b],
         [-e_1.T * e_1, sympy.eye(n), -e_1.T * e_2],
         [e_2.T * e_1, sympy.zeros(l_u, n), e_2.T * e_2]]
    ).as_explicit()  # fmt: skip
    slope = sympy.BlockMatrix(
        [[-sympy.eye(n), sympy.zeros(n, n), sympy.zeros(n, l_u)],
         [sympy.zeros(n, n), -a.T, sympy.zeros(n, l_u)],
         [sympy.zeros(l_u, n), b.T, sympy.zeros(l_u, l_u)]]
    ).as_explicit()  # fmt: skip
    pencil = [to_flint(matrix) for matrix in (constant, slope)]
    points = [flint.fmpq(k) for k in range(-n, n + 1)]
    values = [(pencil[0] + point * pencil[1]).det() for point in points]
    ascending = interpolated(points, values)
    sign = -1 if n % 2 else 1
    descending = [sign * rational(c) for c in reversed(ascending)]
    return canonical(Poly(descending, symbol))


def is_palindromic(poly: Poly) -> bool:
    """Tell whether a polynomial equals its reciprocal, roots at 0 aside.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.lqg.poles import is_palindromic
    >>> is_palindromic(polynomial("z**3 - 3*z**2 + z"))
    True
    """
    reflected = reciprocal_polynomial(poly)
    return bool(reciprocal_polynomial(reflected) == reflected)


def interpolated(points: list[flint.fmpq], values: list[flint.fmpq]) -> list[flint.fmpq]:
    """Return ascending coefficients through the points, by Newton's divided differences.

    Examples
    --------
    >>> import flint
    >>> from compensator_theory.lqg.poles import interpolated
    >>> interpolated([flint.fmpq(0), flint.fmpq(1)], [flint.fmpq(2), flint.fmpq(5)])
    [2, 3]
    """
    table = list(values)
    for order in range(1, len(points)):
        for i in range(len(points) - 1, order - 1, -1):
            table[i] = (table[i] - table[i - 1]) / (points[i] - points[i - order])
    result = flint.fmpq_poly([table[-1]])
    for i in range(len(points) - 2, -1, -1):
        result = result * flint.fmpq_poly([-points[i], 1]) + table[i]
    return list(result.coeffs())


def require_stable_hidden_modes(
    plant: StandardProblem, counted: Callable[[Poly], RootCount], region: str
) -> None:
    """Refuse a mode that no gain moves and that is not in the region of stability.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.lqg.poles import require_stable_hidden_modes
    >>> from compensator_theory.roots.schur_cohn import count_unit_disk_roots
    >>> plant = standard_problem("1/(q - 2)")
    >>> require_stable_hidden_modes(plant, count_unit_disk_roots, "inside the unit circle")
    """
    for error, matrices, what in (
        (NotControllableError, (plant.A, plant.B), "uncontrollable from u"),
        (NotObservableError, (plant.A.T, plant.C.T), "unobservable from y"),
    ):
        hidden = uncontrollable_polynomial(*matrices, plant.variable)
        count = counted(hidden)
        if count.boundary or count.unstable:
            raise error(
                f"the mode(s) {format_polynomial(hidden)} are {what} and not all {region}, so that "
                "no controller is stabilising; remove them from the plant"
            )
