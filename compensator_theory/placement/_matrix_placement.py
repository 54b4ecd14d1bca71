"""Every compensator of given order that places the poles of a plant with several signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.forms._coprime_fractions import coprime_fractions
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
    polynomial_matrix,
)
from compensator_theory.forms._row_forms import row_reduced_form
from compensator_theory.loops._siso import require_sign
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._echelon import contradictions
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import solve, solve_affine
from compensator_theory.polynomials._budget import ask, integer, listed
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._from_roots import SpectrumLike, polynomial_or_roots
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical, from_coefficients, monic
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import require_no_other_operator
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class MatrixPlacement(Certified, ExactValue):
    r"""The compensators of :func:`place_matrix_poles`, :math:`G_c = N_c D_c^{-1}`.

    .. math:: D_l \Big(D_c + \sum_i \alpha_i\,\delta D_i\Big)
              - f N_l \Big(N_c + \sum_i \alpha_i\,\delta N_i\Big) = \mathrm{diag}(t_1, \ldots, t_p)

    Attributes
    ----------
    plant : TransferMatrix
        p x m, as given.
    feedback : {+1, -1}
        The sign f in u = f G_c y.
    D_l, N_l : PolynomialMatrix
        A left coprime fraction of the plant; D_l is row reduced, of row degrees r_i.
    targets : tuple of sympy.Poly
        Monic; their product is the closed-loop polynomial.
    N_c, D_c : PolynomialMatrix
        m x p and p x p: one compensator. The leading matrix of D_c, of degree q, is the
        inverse of that of D_l; the internal model, if requested, divides D_c.
    homogeneous : tuple of pairs of PolynomialMatrix
        (delta N_i, delta D_i); empty if the compensator is unique within these degrees.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the identity holds where none of them is zero.
    """

    _CARRIES = True

    identity = "D_l D_c - f N_l N_c = diag(targets)"

    plant: TransferMatrix
    feedback: int
    D_l: PolynomialMatrix
    N_l: PolynomialMatrix
    targets: tuple[Poly, ...]
    N_c: PolynomialMatrix
    D_c: PolynomialMatrix
    homogeneous: tuple[tuple[PolynomialMatrix, PolynomialMatrix], ...]
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        loop = (self.D_l @ self.D_c).as_matrix() - self.feedback * (self.N_l @ self.N_c).as_matrix()
        return [loop - sympy.diag(*(target.as_expr() for target in self.targets))]

    @property
    def compensator(self) -> TransferMatrix:
        """The compensator N_c D_c^-1, m x p, without common factors."""
        return _quotient(self.N_c, self.D_c, self.plant.sample_time)

    def member(self, parameters: Sequence[NumberLike]) -> TransferMatrix:
        """Return one compensator of the family, with a number or symbol for each parameter.

        Raises
        ------
        InputError
            If their number is not that of `homogeneous`.
        """
        if len(parameters) != len(self.homogeneous):
            raise InputError(
                f"there are {len(parameters)} parameters; this family has {len(self.homogeneous)}"
            )
        N_c, D_c, s = self.N_c, self.D_c, self.plant.variable
        for parameter, (d_N, d_D) in zip(parameters, self.homogeneous, strict=True):
            factor = polynomial(sympy.sympify(exact_number(parameter)), s)
            if factor.degree() > 0:
                raise InputError(f"the parameter {parameter} contains the variable {s}")
            N_c, D_c = N_c + multiple(d_N, factor), D_c + multiple(d_D, factor)
        return _quotient(N_c, D_c, self.plant.sample_time)

    def __str__(self) -> str:
        count = len(self.homogeneous)
        extent = "unique" if not count else f"one of a {count}-parameter family"
        return f"G_c = N_c D_c^-1, {extent}\nN_c = {self.N_c}\nD_c = {self.D_c}"

    def _repr_latex_(self) -> str:
        top, below = latex(self.N_c), latex(self.D_c)
        count = len(self.homogeneous)
        return displayed(
            rf"G_c = N_c D_c^{{-1}} = {top} {below}^{{-1}}",
            words(f"one of a {count}-parameter family") if count else "",
            unless(self.exceptional),
        )


@carrying()
def place_matrix_poles(
    plant: TransferMatrixLike,
    targets: Sequence[SpectrumLike],
    order: int,
    *,
    feedback: int,
    internal_model: PolynomialLike | None = None,
    variable: str | Symbol | None = None,
) -> MatrixPlacement:
    r"""Search exactly for all compensators of given degree that place given poles.

    .. math:: D_l D_c - f N_l N_c = \mathrm{diag}(t_1, \ldots, t_p), \qquad
              \deg D_c = q, \quad \deg N_c \le q, \quad D_c = \alpha(s)\,D_c'

    Parameters
    ----------
    plant : transfer matrix
        p x m and strictly proper; one signal each is allowed.
    targets : sequence of polynomials or lists of roots
        p of them, of degrees r_i + q, where r_i are the row degrees of the plant's left fraction,
        ascending: its observability indices. The loop has all their roots as poles.
    order : int
        q, the degree of D_c; the compensator has at most p q states.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.
    feedback : {+1, -1}
        The sign f.
    internal_model : polynomial, optional
        :math:`\alpha`, monic or not, of degree at most q: a factor of all entries of D_c. "s" asks
        for integrators, "s**2 + 4" for zero steady error at that frequency.

    Raises
    ------
    NoSolutionError
        If no compensator of this degree does; from q = nu - 1 + deg alpha on, nu the largest
        controllability index, there is one for every target, if no zero of the plant is a root of
        alpha.
    ImproperError
        If the plant is not strictly proper.
    InputError
        If degrees or numbers of targets do not fit.

    Notes
    -----
    The columns of D_c and N_c solve one linear system each, with free parameters where it has a
    null space; this is the matrix Diophantine equation with bounds of the degrees. Source: T.
    Kailath, Linear Systems (1980), Section 7.5; P. J. Antsaklis and A. N. Michel, Linear Systems
    (2006), Section 8.

    Examples
    --------
    >>> from compensator_theory import place_matrix_poles
    >>> G = [["1/(s - 1)", 0], ["1/(s + 2)", "1/(s + 1)"]]
    >>> rows = [[-1, -2, -3], [-1, -2, -3, -4]]
    >>> placement = place_matrix_poles(G, rows, 2, feedback=-1, internal_model="s")
    >>> len(placement.homogeneous), placement.certificate.holds
    (2, True)
    """
    require_sign(feedback)
    G = transfer_matrix(plant, variable)
    s, (p, m) = G.variable, G.shape
    if any(not G[i, j].is_strictly_proper for i in range(p) for j in range(m)):
        raise ImproperError(f"the plant {G} must be strictly proper")
    integer(order, "order", at_least=0)
    model = polynomial(1 if internal_model is None else internal_model, s)
    require_no_other_operator(model)
    if model.is_zero or model.degree() > order:
        raise InputError(
            f"the internal model {model.as_expr()} must be nonzero and of degree at most {order}"
        )
    model = monic(model)
    D_l, N_l, H, degrees = reduced_left_fraction(G)
    ask("entries", (max(degrees) + order + 1) * p * (order + 1) * (p + m), "the placement equation")
    goals = _targets(targets, degrees, order, s)
    signed, widened = N_l if feedback == -1 else -N_l, multiple(D_l, model)
    free, heights = order - int(model.degree()), [degree + order for degree in degrees]
    columns = coefficient_columns(widened, signed, free, order, heights)
    matrix = ImmutableMatrix(columns).T
    N_c, D_c = (
        in_column([Poly(0, s, domain=sympy.QQ)] * m, 0, p),
        multiple(polynomial_matrix(H, s), canonical(model * Poly(s**free, s))),
    )
    leading, homogeneous = D_l @ D_c, []
    for j, goal in enumerate(goals):
        right = [
            (goal if i == j else goal * 0).coeff_monomial(s**power)
            - leading[i, j].coeff_monomial(s**power)
            for i, height in enumerate(heights)
            for power in range(height)
        ]
        try:
            solution = solve_affine(matrix, ImmutableMatrix(right))
        except NoSolutionError as error:
            raise NoSolutionError(
                f"no compensator of degree {order} gives column {j} the target {goal.as_expr()}; "
                "raise the order, or change the targets"
            ).holding(
                contradictions(matrix, ImmutableMatrix(right)), denominators(D_l, N_l)
            ) from error
        D, N = pair_of_columns(solution.particular, (p, m), free, order, model)
        N_c, D_c = N_c + in_column(N, j, p), D_c + in_column(D, j, p)
        for vector in solution.nullspace:
            D, N = pair_of_columns(vector, (p, m), free, order, model)
            homogeneous.append((in_column(N, j, p), in_column(D, j, p)))
    every = [D_l, N_l, N_c, D_c, *(part for pair in homogeneous for part in pair)]
    exceptional = exceptional_factors(denominators(*every))
    result = MatrixPlacement(
        G, feedback, D_l, N_l, goals, N_c, D_c, tuple(homogeneous), exceptional
    )
    proven(result.certificate, "compensator")
    return result


def _targets(
    targets: Sequence[SpectrumLike], degrees: list[int], order: int, s: Symbol
) -> tuple[Poly, ...]:
    degrees_needed = [degree + order for degree in degrees]
    polynomials = (
        [] if isinstance(targets, str) else listed(targets, "degree", "the list of targets")
    )
    if len(polynomials) != len(degrees_needed):
        raise InputError(
            f"give {len(degrees_needed)} targets, of degrees {degrees_needed}, one for each output"
        )
    goals = [monic(polynomial_or_roots(target, s)) for target in polynomials]
    for goal in goals:
        require_no_other_operator(goal)
    if [int(goal.degree()) for goal in goals] != degrees_needed:
        raise InputError(
            f"the targets have the degrees {[goal.degree() for goal in goals]}; with this plant "
            f"and order they must be {degrees_needed}"
        )
    return tuple(goals)


def _quotient(
    N_c: PolynomialMatrix, D_c: PolynomialMatrix, sample_time: Rational | None
) -> TransferMatrix:
    one = Poly(1, N_c.variable, domain=sympy.QQ)
    above = TransferMatrix(N_c.rows, one, sample_time=sample_time)
    return (above @ TransferMatrix(D_c.rows, one).inverse()).reduced()


# The linear equations behind the placement of poles with several signals.


def reduced_left_fraction(
    G: TransferMatrix,
) -> tuple[PolynomialMatrix, PolynomialMatrix, ImmutableMatrix, list[int]]:
    """Return D_l and N_l with ascending row degrees, the inverse leading matrix, the degrees."""
    fractions = coprime_fractions(G)
    reduced = row_reduced_form(fractions.D_l)
    order = sorted(range(G.shape[0]), key=lambda i: reduced.row_degrees[i])
    N = reduced.U @ fractions.N_l
    D_l = PolynomialMatrix(tuple(reduced.form.rows[i] for i in order))
    N_l = PolynomialMatrix(tuple(N.rows[i] for i in order))
    leading = reduced.leading_matrix.extract(order, list(range(G.shape[0])))
    H = solve(ImmutableMatrix(leading), identity_matrix(G.shape[0]))
    return D_l, N_l, H, [reduced.row_degrees[i] for i in order]


def coefficient_columns(
    D: PolynomialMatrix, N: PolynomialMatrix, free: int, order: int, heights: list[int]
) -> list[list[Expr]]:
    """Return the columns that D s^k, k < free, and N s^k, k <= order, add to the equations."""
    s, columns = D.variable, []
    for matrix, count in ((D, free), (N, order + 1)):
        for entry in range(matrix.shape[1]):
            for k in range(count):
                columns.append([
                    matrix[i, entry].coeff_monomial(s ** (power - k)) if power >= k else 0
                    for i, height in enumerate(heights)
                    for power in range(height)
                ])  # fmt: skip
    return columns


def pair_of_columns(
    vector: ImmutableMatrix, shape: tuple[int, int], free: int, order: int, model: Poly
) -> tuple[list[Poly], list[Poly]]:
    """Return the columns (D_c without its leading term, N_c) of one solution."""
    p, m = shape
    entries, s = list(vector), model.gen
    below, top = entries[: p * free], entries[p * free :]
    parts = [below[i * free : (i + 1) * free][::-1] or [sympy.S.Zero] for i in range(p)]
    D = [canonical(from_coefficients(part, s) * model) for part in parts]
    width = order + 1
    N = [from_coefficients(top[i * width : (i + 1) * width][::-1], s) for i in range(m)]
    return D, N


def in_column(entries: list[Poly], column: int, width: int) -> PolynomialMatrix:
    """Return a matrix that is zero but for one column."""
    zero = Poly(0, entries[0].gen, domain=sympy.QQ)
    return PolynomialMatrix(
        tuple(tuple(e if j == column else zero for j in range(width)) for e in entries)
    )


def multiple(matrix: PolynomialMatrix, factor: Poly) -> PolynomialMatrix:
    """Multiply every entry by a polynomial."""
    return PolynomialMatrix(tuple(tuple(canonical(e * factor) for e in r) for r in matrix.rows))
