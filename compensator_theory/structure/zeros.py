"""Invariant, transmission and decoupling zeros, with the directions in which they block."""

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.canonical_forms.smith import SmithForm, smith_form
from compensator_theory.matrices.certificates import Certificate
from compensator_theory.polynomial_matrices.exceptional_sets import exceptional_factors
from compensator_theory.polynomial_matrices.polynomial_matrices import PolynomialMatrix
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.roots.certified import Root, certified_roots
from compensator_theory.structure.coprime_fractions import coprime_fractions
from compensator_theory.systems.canonical_forms import RealisationLike, realisation
from compensator_theory.systems.matrix_conversions import TransferMatrixLike
from compensator_theory.systems.realisations import Realisation

IDENTITY = "the matrix at each zero times its directions"


@dataclass(frozen=True)
class ZeroDirection(ExactValue):
    """Where a system blocks at a zero: vectors that hold at every root of one irreducible factor.

    Attributes
    ----------
    factor : sympy.Poly
        Monic and irreducible; the zeros are its roots.
    state, input : sympy.ImmutableMatrix
        Columns: the motion x e^(zt) under the input u e^(zt) that does not show in the output. For
        a factor of higher degree their entries are polynomials in the variable, to be taken at a
        root. Empty where the kind of zero has none.
    costate, output : sympy.ImmutableMatrix
        Columns: the same of the transposed system, the combination of outputs in which no input
        with that exponent shows.
    """

    factor: Poly
    state: ImmutableMatrix
    input: ImmutableMatrix
    costate: ImmutableMatrix
    output: ImmutableMatrix

    def __str__(self) -> str:
        names = ("state", "input", "costate", "output")
        vectors = [(name, list(getattr(self, name))) for name in names]
        shown = ", ".join(f"{name} {vector}" for name, vector in vectors if vector)
        return f"{format_polynomial(self.factor)} = 0: {shown}"


@dataclass(frozen=True)
class Zeros(ExactValue):
    """The zeros of one kind, with multiplicity and directions.

    Attributes
    ----------
    invariant_polynomials : tuple of sympy.Poly
        Of the matrix whose rank falls at the zeros, those of degree 0 left out.
    polynomial : sympy.Poly
        Their product; 1 if there are no zeros.
    directions : tuple of ZeroDirection
        For each irreducible factor as many as the rank falls by.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        That the matrix annihilates each direction, modulo its factor.
    """

    invariant_polynomials: tuple[Poly, ...]
    polynomial: Poly
    directions: tuple[ZeroDirection, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def roots(self) -> tuple[Root, ...]:
        """Return the certified zeros with multiplicity; InputError with symbols."""
        return certified_roots(self.polynomial)

    def __str__(self) -> str:
        lines = [f"zeros of {format_polynomial(self.polynomial)}", *map(str, self.directions)]
        return "\n".join(lines)


def invariant_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find where Rosenbrock's system matrix loses rank.

    .. math:: P(s) = \begin{bmatrix} sI - A & -B \\ C & D \end{bmatrix}, \qquad
              P(z) \begin{bmatrix} x \\ u \end{bmatrix} = 0, \quad
              \begin{bmatrix} w' & y' \end{bmatrix} P(z) = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or what :func:`realisation` reads
        Hidden modes count. With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Notes
    -----
    Below the normal rank: a plant with more inputs than outputs has a kernel everywhere, and its
    directions are then unique only up to that. Source: H. H. Rosenbrock, State-space and
    Multivariable Theory (1970).

    Examples
    --------
    >>> from compensator_theory import invariant_zeros
    >>> print(invariant_zeros(([[0, 1], [-2, -3]], [[0], [1]], [[5, 1]])))
    zeros of s + 5
    s + 5 = 0: state [1, -5], input [12], costate [1, 0], output [1]
    """
    given = realisation(plant, variable)
    upper = _pencil(given).row_join(-given.B)
    matrix = upper.col_join(given.C.row_join(given.D))
    smith = smith_form(matrix, given.variable)
    n = given.n
    return _zeros(smith, smith, (n, given.B.cols), (n, given.C.rows))


def transmission_zeros(G: TransferMatrixLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find where a transfer matrix blocks a direction of the input.

    .. math:: G = N_r D_r^{-1} = D_l^{-1} N_l, \qquad N_r(z)\,v = 0, \quad u = D_r(z)\,v, \qquad
              w' N_l(z) = 0, \quad y' = w' D_l(z)

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, of any shape; of a realisation the hidden modes do
        not count. With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Notes
    -----
    If z is no pole, then G(z) u = 0 and y' G(z) = 0. A target model of retrospective cost adaptive
    control must have the zero in the output direction y, or the controller may cancel it.

    Source: C. A. Desoer and J. D. Schulman, IEEE Transactions on Circuits and Systems 21 (1974).

    Examples
    --------
    >>> from compensator_theory import transmission_zeros
    >>> G = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]
    >>> print(transmission_zeros(G))
    zeros of s + 3
    s + 3 = 0: input [2, -1], output [1, -1]
    """
    fractions = coprime_fractions(G, variable)
    right, left = smith_form(fractions.N_r), smith_form(fractions.N_l)
    found = _zeros(
        right,
        left,
        (0, fractions.D_r.shape[0]),
        (0, fractions.D_l.shape[0]),
        fractions.D_r,
        fractions.D_l,
    )
    every = exceptional_factors([*found.exceptional, *fractions.exceptional])
    return Zeros(
        found.invariant_polynomials, found.polynomial, found.directions, every, found.certificate
    )


def input_decoupling_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find the modes that the input does not reach.

    .. math:: w' \begin{bmatrix} zI - A & -B \end{bmatrix} = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or what :func:`realisation` reads
        With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Examples
    --------
    >>> from compensator_theory import input_decoupling_zeros
    >>> print(input_decoupling_zeros(([[-1, 0], [0, -2]], [[1], [0]], [[1, 1]])))
    zeros of s + 2
    s + 2 = 0: costate [0, 1]
    """
    given = realisation(plant, variable)
    if not given.n:
        return _none(given)
    smith = smith_form(_pencil(given).row_join(-given.B), given.variable)
    return _zeros(smith, smith, (0, 0), (given.n, 0))


def output_decoupling_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find the modes that the output does not show.

    .. math:: \begin{bmatrix} zI - A \\ C \end{bmatrix} x = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or what :func:`realisation` reads
        With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Examples
    --------
    >>> from compensator_theory import output_decoupling_zeros
    >>> print(output_decoupling_zeros(([[-1, 0], [0, -2]], [[1], [1]], [[1, 0]])))
    zeros of s + 2
    s + 2 = 0: state [0, 1]
    """
    given = realisation(plant, variable)
    if not given.n:
        return _none(given)
    smith = smith_form(_pencil(given).col_join(given.C), given.variable)
    return _zeros(smith, smith, (given.n, 0), (0, 0))


def _pencil(plant: Realisation) -> ImmutableMatrix:
    return plant.variable * ImmutableMatrix(sympy.eye(plant.n)) - plant.A


def _none(plant: Realisation) -> Zeros:
    smith = smith_form([[1]], plant.variable)
    return _zeros(smith, smith, (0, 0), (0, 0))


def _zeros(
    right: SmithForm,
    left: SmithForm,
    right_sizes: tuple[int, int],
    left_sizes: tuple[int, int],
    right_map: PolynomialMatrix | None = None,
    left_map: PolynomialMatrix | None = None,
) -> Zeros:
    """Read the zeros off the Smith forms: U M V = S makes column k of V a direction where s_k = 0.

    The vectors are multiplied by the maps, and split into state and signal by the sizes; what
    exceeds the sizes is not asked for.
    """
    s = right.matrix.variable
    invariants = tuple(p for p in right.invariant_polynomials if p.degree() > 0)
    whole = canonical(sympy.prod(invariants, start=Poly(1, s, domain=sympy.QQ)))
    directions: list[ZeroDirection] = []
    left_over: list[Expr] = []
    first = right.rank - len(invariants)
    offset = left.rank - right.rank
    for factor in (f.monic() for f, _ in whole.factor_list()[1]):
        for k, invariant in enumerate(invariants, first):
            if not _rest(invariant, factor).is_zero:
                continue
            v = _column(right.V, k)
            w = _column(left.U.T, k + offset)
            for remainder in (right.matrix @ v, left.matrix.T @ w):
                left_over += [_rest(row[0], factor).as_expr() for row in remainder.rows]
            v = v if right_map is None else right_map @ v
            w = w if left_map is None else left_map.T @ w
            state, signal = _split(v, factor, right_sizes)
            costate, output = _split(w, factor, left_sizes)
            directions.append(ZeroDirection(canonical(factor), state, signal, costate, output))
    residual = ImmutableMatrix(1, len(left_over), left_over)
    exceptional = exceptional_factors([*right.exceptional, *left.exceptional])
    certificate = Certificate(IDENTITY, residual)
    return Zeros(invariants, whole, tuple(directions), exceptional, certificate)


def _column(matrix: PolynomialMatrix, index: int) -> PolynomialMatrix:
    return PolynomialMatrix(tuple((row[index],) for row in matrix.rows))


def _rest(poly: Poly, factor: Poly) -> Poly:
    """Return a polynomial modulo a factor; its value at the root, if the factor is linear."""
    a, b = poly.unify(factor)
    field = a.domain.get_field()
    return canonical(a.set_domain(field).rem(b.set_domain(field)))


def _split(
    vector: PolynomialMatrix, factor: Poly, sizes: tuple[int, int]
) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    """Reduce a vector modulo the factor, without common denominators and factors, and split it."""
    n, m = sizes
    entries = [_rest(row[0], factor).as_expr() for row in vector.rows[: n + m]]
    if any(entry != 0 for entry in entries):
        common = sympy.lcm_list([sympy.fraction(sympy.together(e))[1] for e in entries])
        cleared = [sympy.cancel(e * common) for e in entries]
        divisor = sympy.gcd_list([e for e in cleared if e != 0])
        first = next(e for e in cleared if e != 0)
        sign = -1 if (first / divisor).could_extract_minus_sign() else 1
        entries = [sympy.expand(sympy.cancel(sign * e / divisor)) for e in cleared]
    return ImmutableMatrix(n, 1, entries[:n]), ImmutableMatrix(m, 1, entries[n:])
