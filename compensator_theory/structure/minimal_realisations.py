"""Minimal realisations and McMillan degrees, from Hankel matrices of Markov parameters."""

from dataclasses import dataclass

from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.matrices.certificates import Certificate
from compensator_theory.matrices.linear_algebra import solve
from compensator_theory.polynomial_matrices.echelon import echelon
from compensator_theory.polynomial_matrices.exceptional_sets import exceptional_factors
from compensator_theory.polynomials.budget import ask, shown
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.structure.kalman import kalman_decomposition
from compensator_theory.systems.canonical_forms import RealisationLike, realisation
from compensator_theory.systems.expansions import markov_parameters
from compensator_theory.systems.foreign import is_foreign
from compensator_theory.systems.matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems.realisations import Realisation
from compensator_theory.transfer_functions.transfer_functions import TransferFunction
from compensator_theory.transfer_functions.transfer_matrices import TransferMatrix

IDENTITY = "the transfer matrix of the realisation times D, less N times its denominator"


@dataclass(frozen=True)
class MinimalRealisation(ExactValue):
    """A realisation of the least order, and the check that its transfer matrix is the given one.

    Attributes
    ----------
    realisation : Realisation
        Controllable and observable, for symbols outside the exceptional set.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the realisation exists and is minimal where none of
        them is zero. Empty without symbols.
    certificate : Certificate
        Its transfer matrix against the source, multiplied out.
    """

    realisation: Realisation
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def order(self) -> int:
        """Number of states, the McMillan degree."""
        return self.realisation.n

    def __str__(self) -> str:
        return str(self.realisation)


def minimal_realisation(
    G: TransferMatrixLike | RealisationLike, variable: str | Symbol | None = None
) -> MinimalRealisation:
    r"""Realise a proper transfer matrix, or reduce a realisation, with the least number of states.

    .. math:: A = \mathcal H^{\uparrow}_{IJ} \mathcal H_{IJ}^{-1}, \qquad
              B = \mathcal H_{I1}, \qquad C = \mathcal H_{1J} \mathcal H_{IJ}^{-1}

    Parameters
    ----------
    G : transfer matrix or realisation
        Anything :func:`transfer_matrix` or :func:`realisation` reads; a tuple of three or four
        matrices is (A, B, C, D). A realisation is reduced by Kalman's decomposition; from a
        transfer matrix the first independent rows I and columns J of its block Hankel matrix are
        taken (Ho and Kalman), for one signal each a companion form.
    variable : str or Symbol, optional
        As for the readers.

    Raises
    ------
    ImproperError
        If an entry is improper.
    InputError, BudgetError
        If it cannot be read, or is too large.

    Notes
    -----
    Source: B. L. Ho and R. E. Kalman, Effective construction of linear state-variable models from
    input/output functions, Regelungstechnik 14 (1966).

    Examples
    --------
    >>> from compensator_theory import minimal_realisation
    >>> G = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]
    >>> print(minimal_realisation(G))
    A = [[-1, 0, 0], [0, 0, 1], [0, -2, -3]]
    B = [[1, 2], [0, 1], [-1, -2]]
    C = [[1, 0, 0], [0, 1, 0]]
    """
    if _is_state_space(G):
        given = realisation(G, variable)
        parts = kalman_decomposition(given)
        source = given.transfer_matrix()
        return _checked(parts.minimal, source, parts.exceptional)
    source = transfer_matrix(G, variable)
    size = _hankel_size(source)
    D = ImmutableMatrix(
        *source.shape, [markov_parameters(_entry(source, i, j), 1)[0] for i, j in _places(source)]
    )
    whole = hankel_matrix(source, size, size + 1) if size else ImmutableMatrix.zeros(0, 0)
    outputs, inputs = source.shape
    first = whole[:, : size * inputs]
    rows = echelon(first.T)
    columns = echelon(first[list(rows.pivots), :]) if rows.pivots else rows
    chosen = first[list(rows.pivots), :]
    square = chosen[:, list(columns.pivots)]
    shifted = whole[list(rows.pivots), [c + inputs for c in columns.pivots]]
    # x = the outputs I of the free motion: their rows of the Hankel matrix are the basis.
    A = solve(square.T, shifted.T).T if rows.pivots else square
    B = chosen[:, :inputs]
    C = solve(square.T, first[:outputs, list(columns.pivots)].T).T if rows.pivots else None
    n = len(rows.pivots)
    found = Realisation(
        A if n else ImmutableMatrix.zeros(0, 0),
        B if n else ImmutableMatrix.zeros(0, inputs),
        C if n else ImmutableMatrix.zeros(outputs, 0),
        D,
        source.variable,
        sample_time=source.sample_time,
    )
    return _checked(found, source, exceptional_factors([rows.divided_by, columns.divided_by]))


def hankel_matrix(
    G: TransferMatrixLike, rows: int, columns: int, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return the block Hankel matrix of the Markov parameters.

    .. math:: \mathcal H = \begin{bmatrix} H_1 & H_2 & \cdots \\ H_2 & H_3 & \cdots \\
              \vdots & \vdots & \ddots \end{bmatrix}, \qquad G = \sum_{k\ge 0} H_k s^{-k}

    Parameters
    ----------
    G : transfer matrix
        p x m and proper; anything :func:`transfer_matrix` reads.
    rows, columns : int
        Numbers of block rows and block columns.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Returns
    -------
    sympy.ImmutableMatrix
        (p rows) x (m columns). With as many of each as the common denominator has degree, its rank
        is the McMillan degree.

    Raises
    ------
    ImproperError
        If an entry is improper.
    InputError, BudgetError
        If G cannot be read, a number is not positive, or the matrix is too large.

    Examples
    --------
    >>> from compensator_theory import hankel_matrix
    >>> hankel_matrix("(s + 5)/(s**2 + 3*s + 2)", 2, 2)
    Matrix([
    [1,  2],
    [2, -8]])
    """
    for name, number in (("rows", rows), ("columns", columns)):
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise InputError(f"{name} = {shown(number)} must be a positive integer")
    source = transfer_matrix(G, variable)
    outputs, inputs = source.shape
    ask("entries", rows * outputs * columns * inputs, "the Hankel matrix")
    series = {
        (i, j): markov_parameters(_entry(source, i, j), rows + columns) for i, j in _places(source)
    }
    return ImmutableMatrix([
        [series[i, j][r + c + 1] for c in range(columns) for j in range(inputs)]
        for r in range(rows)
        for i in range(outputs)
    ])  # fmt: skip


def mcmillan_degree(G: TransferMatrixLike, variable: str | Symbol | None = None) -> int:
    r"""Return the number of poles with multiplicity, those at infinity included.

    .. math:: \delta(G) = \mathrm{rank}\,\mathcal H(G_{sp}) + \mathrm{rank}\,\mathcal H(P(1/s)),
              \qquad G = G_{sp} + P

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, improper ones too; with symbols, for generic values.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Notes
    -----
    Source: B. McMillan, Introduction to formal realizability theory, Bell System Technical Journal
    31 (1952). The order of :func:`minimal_realisation` and the degree of the denominators of
    :func:`smith_mcmillan_form` are the same number.

    Examples
    --------
    >>> from compensator_theory import mcmillan_degree
    >>> mcmillan_degree([["1/(s + 1)", "1/(s + 1)"], ["1/(s + 1)", "2/(s + 1)"]])
    2
    >>> mcmillan_degree("s**2 + 1/s", "s")
    3
    """
    source = transfer_matrix(G, variable)
    s, bottom = source.variable, source.denominator
    parts = [[entry.div(bottom) for entry in row] for row in source.numerators]
    rest = TransferMatrix(tuple(tuple(canonical(r) for _, r in row) for row in parts), bottom)
    degree = max((int(q.degree()) for row in parts for q, _ in row if not q.is_zero), default=0)
    total = 0
    if (size := _hankel_size(rest)) > 0:
        total += len(echelon(hankel_matrix(rest, size, size)).pivots)
    if degree > 0:
        blocks = [
            [q.coeff_monomial(s ** (r + c + 1)) for c in range(degree) for q, _ in row]
            for r in range(degree)
            for row in parts
        ]
        total += len(echelon(ImmutableMatrix(blocks)).pivots)
    return total


def _is_state_space(obj: object) -> bool:
    if isinstance(obj, Realisation) or (isinstance(obj, tuple) and len(obj) in (3, 4)):
        return True
    return is_foreign(obj) and all(hasattr(obj, name) for name in "ABCD")


def _hankel_size(G: TransferMatrix) -> int:
    """Return how many block rows are enough: the degree of the denominator without what cancels."""
    common = G.denominator
    for entry in (entry for row in G.numerators for entry in row):
        common = common.gcd(entry)
    return int(G.denominator.degree() - common.degree())


def _places(G: TransferMatrix) -> list[tuple[int, int]]:
    return [(i, j) for i in range(G.shape[0]) for j in range(G.shape[1])]


def _entry(G: TransferMatrix, i: int, j: int) -> TransferFunction:
    entry = G[i, j].reduced()
    if not entry.is_proper:
        raise ImproperError(
            f"the entry {i}, {j} of the transfer matrix, {entry}, is improper; only proper ones "
            "have a realisation"
        )
    return entry


def _checked(
    found: Realisation, source: TransferMatrix, exceptional: tuple[Expr, ...]
) -> MinimalRealisation:
    back = found.transfer_matrix()
    residual = [
        canonical(mine * source.denominator - given * back.denominator).as_expr()
        for my_row, row in zip(back.numerators, source.numerators, strict=True)
        for mine, given in zip(my_row, row, strict=True)
    ]
    certificate = Certificate(IDENTITY, ImmutableMatrix(1, len(residual), residual))
    if not certificate.holds:
        raise NoSolutionError(f"{certificate}; the realisation is wrong, please report it")
    return MinimalRealisation(found, exceptional, certificate)
