"""Hypothesis strategies for exact compensator theory: polynomials, spectra, plants, problems."""

import sympy
from hypothesis import assume
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Poly, Rational, Symbol

from .polynomials import canonical
from .standard_problems import StandardProblem
from .transfer_functions import TransferFunction


def rationals(max_numerator: int = 9, max_denominator: int = 4) -> st.SearchStrategy[Rational]:
    """Draw rational numbers with small numerators and denominators.

    Examples
    --------
    >>> from compensator_theory.strategies import rationals
    >>> rationals().filter(lambda x: x > 8).example() > 8  # doctest: +SKIP
    True
    """
    numerators = st.integers(-max_numerator, max_numerator)
    return st.builds(Rational, numerators, st.integers(1, max_denominator))


@st.composite
def polynomials(
    draw: st.DrawFn,
    variable: str = "s",
    min_degree: int = 0,
    max_degree: int = 4,
    is_monic: bool = False,
) -> Poly:
    """Draw rational polynomials whose degree lies in the given range (zero excluded).

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import polynomials
    >>> @given(polynomials(min_degree=2, is_monic=True))
    ... def check(p):
    ...     assert p.is_monic and p.degree() >= 2
    >>> check()
    """
    degree = draw(st.integers(min_degree, max_degree))
    leading = Rational(1) if is_monic else draw(rationals().filter(bool))
    rest = draw(st.lists(rationals(), min_size=degree, max_size=degree))
    return canonical(Poly([leading, *rest], Symbol(variable)))


@st.composite
def coprime_pairs(draw: st.DrawFn, variable: str = "s", max_degree: int = 4) -> tuple[Poly, Poly]:
    """Draw (a, b) without a common root; a is monic of degree 1 or more, deg b < deg a, b != 0.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import coprime_pairs
    >>> @given(coprime_pairs())
    ... def check(pair):
    ...     assert pair[0].gcd(pair[1]).degree() == 0
    >>> check()
    """
    a = draw(polynomials(variable, 1, max_degree, is_monic=True))
    b = draw(polynomials(variable, 0, int(a.degree()) - 1))
    assume(a.gcd(b).degree() == 0)
    return a, b


@st.composite
def spectra(draw: st.DrawFn, size: int) -> tuple[sympy.Expr, ...]:
    """Draw `size` exact numbers, real or in conjugate pairs, repetitions included.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import polynomial_from_roots
    >>> from compensator_theory.strategies import spectra
    >>> @given(spectra(3))
    ... def check(roots):
    ...     assert polynomial_from_roots(roots, "s").degree() == 3
    >>> check()
    """
    pairs = draw(st.integers(0, size // 2))
    roots: list[sympy.Expr] = []
    for _ in range(pairs):
        real, imaginary = draw(rationals()), draw(rationals().filter(bool))
        roots += [real + sympy.I * imaginary, real - sympy.I * imaginary]
    roots += draw(st.lists(rationals(), min_size=size - 2 * pairs, max_size=size - 2 * pairs))
    return tuple(draw(st.permutations(roots)))


@st.composite
def strictly_proper_plants(
    draw: st.DrawFn, variable: str = "s", max_order: int = 4
) -> TransferFunction:
    """Draw strictly proper plants of order 1 or more with coprime numerator and denominator.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import strictly_proper_plants
    >>> @given(strictly_proper_plants())
    ... def check(plant):
    ...     assert plant.is_strictly_proper and plant.is_coprime
    >>> check()
    """
    denominator, numerator = draw(coprime_pairs(variable, max_order))
    return TransferFunction(numerator, denominator)


@st.composite
def matrices(draw: st.DrawFn, rows: int, columns: int) -> ImmutableMatrix:
    """Draw rational matrices of the given shape.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import matrices
    >>> @given(matrices(2, 3))
    ... def check(matrix):
    ...     assert matrix.shape == (2, 3)
    >>> check()
    """
    size = rows * columns
    entries = draw(st.lists(rationals(3, 3), min_size=size, max_size=size))
    return ImmutableMatrix(rows, columns, entries)


@st.composite
def standard_problems(
    draw: st.DrawFn, max_order: int = 3, max_signals: int = 2, has_direct_term: bool = False
) -> StandardProblem:
    """Draw rational standard problems; D_0 = 0 unless `has_direct_term`.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import standard_problems
    >>> @given(standard_problems(max_order=2))
    ... def check(problem):
    ...     assert problem.denominator.degree() == problem.n
    >>> check()
    """
    n = draw(st.integers(1, max_order))
    l_u, l_y, l_w, l_z = (draw(st.integers(1, max_signals)) for _ in range(4))
    return StandardProblem(
        A=draw(matrices(n, n)),
        B=draw(matrices(n, l_u)),
        C=draw(matrices(l_y, n)),
        D_1=draw(matrices(n, l_w)),
        D_0=draw(matrices(l_y, l_u)) if has_direct_term else None,
        D_2=draw(matrices(l_y, l_w)),
        E_1=draw(matrices(l_z, n)),
        E_2=draw(matrices(l_z, l_u)),
        E_0=draw(matrices(l_z, l_w)),
    )
