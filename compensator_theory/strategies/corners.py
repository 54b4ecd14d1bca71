"""The hard corners of exact compensator theory for Hypothesis, by construction."""

from __future__ import annotations

from math import prod

from hypothesis import strategies as st
from sympy import QQ, ImmutableMatrix, Poly, Rational, Symbol, diag

from compensator_theory.errors import InputError
from compensator_theory.polynomials._poly import canonical
from compensator_theory.strategies.plants import disguised, matrices, unimodular_matrices
from compensator_theory.strategies.polynomials import (
    coprime_pairs,
    coprime_to,
    nonzero_rationals,
    polynomials,
    rationals,
)
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction

# The signs of d, by turns, and whether the second factor is the first again.
_SIGNS = (
    [((1, 1), False)] * 4 + [((1, 1), True)] * 2
    + [((-1, -1), False)] * 4 + [((-1, -1), True)]
    + [((1, -1), False)] * 2 + [((-1, 1), False)] * 2
)  # fmt: skip
Triple = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]


@st.composite
def noncoprime_pairs(
    draw: st.DrawFn, variable: str = "s", max_degree: int = 3, max_common: int = 2
) -> tuple[Poly, Poly, Poly]:
    """Draw (a, b, g): a and b, not zero, deg b < deg a, with the monic greatest common divisor g.

    With the defaults four in five have g of degree 1, one in five of degree 2, and two in fifteen
    a g that is a square.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import noncoprime_pairs
    >>> @given(noncoprime_pairs())
    ... def check(drawn):
    ...     a, b, g = drawn
    ...     assert a.gcd(b).monic() == g and g.degree() >= 1
    >>> check()
    """
    kinds = [(1, False)] * max(1, 12 * (max_common - 1))
    kinds += [(k, square) for k in range(2, max_common + 1) for square in (k == 2, k == 2, False)]
    degree, is_square = draw(st.sampled_from(kinds))
    a, b = draw(coprime_pairs(variable, max_degree))
    if is_square:
        g = Poly([1, draw(rationals())], Symbol(variable), domain=QQ) ** 2
    else:
        g = draw(polynomials(variable, degree, degree, is_monic=True))
    return canonical(a * g), canonical(b * g), canonical(g)


@st.composite
def exactly_proper_plants(
    draw: st.DrawFn, variable: str = "s", max_order: int = 4
) -> TransferFunction:
    """Draw exactly proper plants of order 1 or more with coprime numerator and denominator.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import exactly_proper_plants
    >>> @given(exactly_proper_plants())
    ... def check(plant):
    ...     assert plant.is_coprime and plant.numerator.degree() == plant.order >= 1
    >>> check()
    """
    a, b = draw(coprime_pairs(variable, max_order))
    return TransferFunction(canonical(b + a.mul_ground(draw(nonzero_rationals()))), a)


@st.composite
def nearly_cancelling_plants(
    draw: st.DrawFn, variable: str = "s", max_order: int = 4
) -> TransferFunction:
    r"""Draw plants with a pole of multiplicity 1, 2 or 3 and a zero very close to it.

    .. math:: G = \frac{g\,(s - p - \epsilon)}{(s - p)^m \prod_j (s - p - j)}, \qquad
              \epsilon = \pm 10^{-k}, \quad 1 \le k \le 12

    Nine in twenty have m = 1, one in four m = 2, three in ten m = 3.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import nearly_cancelling_plants
    >>> @given(nearly_cancelling_plants())
    ... def check(plant):
    ...     assert plant.is_coprime and plant.is_strictly_proper
    >>> check()
    """
    s = Symbol(variable)
    m = draw(st.sampled_from([1] * 9 + [2] * 5 + [3] * 6))
    p = draw(rationals())
    others = draw(st.integers(1 if m == 1 else 0, max(1, max_order - m)))
    sign = -1 if draw(st.booleans()) else 1
    epsilon = sign * Rational(1, 10 ** draw(st.integers(1, 12)))
    D = Poly([1, -p], s, domain=QQ) ** m
    for j in range(1, others + 1):
        D *= Poly([1, -p - j], s, domain=QQ)
    N = Poly([1, -p - epsilon], s, domain=QQ).mul_ground(draw(nonzero_rationals()))
    return TransferFunction(canonical(N), canonical(D))


@st.composite
def irrational_polynomials(draw: st.DrawFn, pairs: int, variable: str = "s") -> Poly:
    r"""Draw monic rational polynomials of degree 2 `pairs` all of whose roots are irrational.

    .. math:: \prod_i \left((s - p_i)^2 \mp d_i\right), \qquad d_i \in \{2, 3, 5, 7\}

    Two in five have real roots only, a third none where there are two factors or more, and of those
    one in five has a repeated root.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import irrational_polynomials
    >>> @given(irrational_polynomials(2))
    ... def check(poly):
    ...     assert all(factor.degree() == 2 for factor, _ in poly.factor_list()[1])
    >>> check()
    """
    s = Symbol(variable)
    signs, is_repeated = draw(st.sampled_from(_SIGNS))
    factors: list[Poly] = []
    for k in range(pairs):
        p = draw(rationals(4, 2))
        d = (2, 3, 5, 7)[draw(st.integers(0, 3))] * signs[k % 2]
        factor = Poly([1, -2 * p, p**2 - d], s, domain=QQ)
        while factor in factors:
            p += 1
            factor = Poly([1, -2 * p, p**2 - d], s, domain=QQ)
        factors.append(factors[0] if is_repeated and k == 1 else factor)
    return canonical(prod(factors, start=Poly(1, s, domain=QQ)))


@st.composite
def minimal_mimo_plants(
    draw: st.DrawFn, mcmillan_degree: int, inputs: int = 2, outputs: int = 2, variable: str = "s"
) -> Realisation:
    """Draw minimal realisations with several signals, of given McMillan degree.

    One input and one output alone control and observe everything, so that A has one Jordan block
    for each eigenvalue; the other columns and rows are arbitrary.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import mcmillan_degree
    >>> from compensator_theory.strategies import minimal_mimo_plants
    >>> @given(minimal_mimo_plants(2))
    ... def check(plant):
    ...     assert mcmillan_degree(plant.transfer_matrix()) == 2
    >>> check()
    """
    if min(mcmillan_degree, inputs, outputs) < 1:
        raise InputError("a plant needs a state, an input and an output, one or more of each")
    n = mcmillan_degree
    D = draw(polynomials(min_degree=n, max_degree=n, is_monic=True))
    N = coprime_to(D, draw(polynomials(max_degree=n - 1)))
    A, b, c, _ = controllable_canonical_form(TransferFunction(N, D))
    B = ImmutableMatrix(b.row_join(draw(matrices(n, inputs - 1))))
    C = ImmutableMatrix(c.col_join(draw(matrices(outputs - 1, n))))
    return Realisation(*disguised(A, B, C, draw(unimodular_matrices(n))), variable=Symbol(variable))


@st.composite
def derogatory_loops(
    draw: st.DrawFn, max_order: int = 3, variable: str = "s"
) -> tuple[Realisation, Realisation]:
    """Draw a SISO plant and a compensator of its order with two Jordan blocks for one pole.

    The compensator has a mode that is both uncontrollable and unobservable, and the plant's last
    coefficient makes the visible loop have the same pole. Both are rational.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
    >>> from compensator_theory.matrices._invariant_subspaces import derogatory_factor
    >>> from compensator_theory.matrices._linear_algebra import characteristic_polynomial
    >>> from compensator_theory.strategies import derogatory_loops
    >>> @given(derogatory_loops())
    ... def check(loop):
    ...     A = closed_loop_matrix(*loop)
    ...     whole = characteristic_polynomial(A, loop[0].variable)
    ...     assert derogatory_factor(A, whole).degree() == 1
    >>> check()
    """
    n = draw(st.sampled_from(range(1, max_order + 1)))
    D = draw(polynomials(min_degree=n, max_degree=n, is_monic=True))
    N = coprime_to(D, draw(polynomials(max_degree=n - 1)))
    D_c = draw(polynomials(min_degree=n - 1, max_degree=n - 1, is_monic=True))
    N_c = draw(polynomials(max_degree=n - 2)) if n > 1 else Poly(0, D.gen, domain=QQ)
    mode = draw(st.integers(-5, 5))
    while D_c.eval(mode) == 0:
        mode += 1
    D -= D.eval(mode) - N.eval(mode) * N_c.eval(mode) / D_c.eval(mode)
    plant = controllable_canonical_form(TransferFunction(N, canonical(D)))[:3]
    if n == 1:
        visible: Triple = (ImmutableMatrix(0, 0, []), ImmutableMatrix(0, 1, []),
                           ImmutableMatrix(1, 0, []))  # fmt: skip
    else:
        visible = controllable_canonical_form(TransferFunction(N_c, D_c))[:3]
    A = ImmutableMatrix(diag(visible[0], mode))
    B, C = visible[1].col_join(ImmutableMatrix([[0]])), visible[2].row_join(ImmutableMatrix([[0]]))
    sides = (plant, (A, B, C))
    return tuple(  # type: ignore[return-value]
        Realisation(*disguised(*side, draw(unimodular_matrices(n))), variable=Symbol(variable))
        for side in sides
    )


@st.composite
def plants_with_gain(
    draw: st.DrawFn, max_order: int = 3, variable: str = "s"
) -> tuple[Realisation, ImmutableMatrix]:
    r"""Draw a minimal SISO plant and a gain K that may hide a mode of A + BK from C.

    .. math:: \det(sI - A - BK) = (s - z) \cdots, \qquad N(z) = 0

    Two in five move a pole onto a zero of the plant; one in five has K = 0.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import plants_with_gain
    >>> @given(plants_with_gain())
    ... def check(drawn):
    ...     plant, K = drawn
    ...     assert (plant.A + plant.B * K).shape == plant.A.shape and K.shape == plant.C.shape
    >>> check()
    """
    kind = draw(st.sampled_from(["any", "any", "zero", "onto a zero", "onto a zero"]))
    n = draw(st.sampled_from([1, *(k for k in range(2, max_order + 1) for _ in range(3))]))
    s = Symbol("s")
    D = draw(polynomials("s", n, n, is_monic=True))
    z = draw(rationals(4, 2))
    while D.eval(z) == 0:
        z += 1
    hides = kind == "onto a zero" and n > 1
    if hides:
        rest = coprime_to(D, draw(polynomials("s", 0, n - 2)))
        N = Poly([1, -z], s, domain=QQ) * rest
    else:
        N = coprime_to(D, draw(polynomials("s", 0, n - 1)))
    placed = draw(polynomials("s", n - 1, n - 1, is_monic=True)) * Poly(
        [1, -z if hides else draw(rationals())], s, domain=QQ
    )
    A, B, C, _ = controllable_canonical_form(TransferFunction(canonical(N), D))
    moved = [0] * n if kind == "zero" else _ascending(D, n) - _ascending(placed, n)
    # in these coordinates a gain adds its entries to one row of coefficients
    last = next(i for i in range(n) if B[i, 0] != 0)
    at = list(-A[last, :])
    order = range(n) if at == list(_ascending(D, n)) else range(n - 1, -1, -1)
    K = ImmutableMatrix(1, n, [moved[i] for i in order])
    S = draw(unimodular_matrices(n))
    plant = Realisation(*disguised(A, B, C, S), variable=Symbol(variable))
    return plant, ImmutableMatrix(K * S.inv())


def _ascending(p: Poly, n: int) -> ImmutableMatrix:
    return ImmutableMatrix(n, 1, [p.nth(i) for i in range(n)])


@st.composite
def plants_and_compensators(
    draw: st.DrawFn, variable: str = "s", max_order: int = 3
) -> tuple[TransferFunction, TransferFunction]:
    """Draw two coprime strictly proper transfer functions, every other time with a cancellation.

    The compensator cancels a zero of the plant with a pole (two in six), or a pole of the plant
    with a zero (one in six); the common factor may lie anywhere.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import plants_and_compensators
    >>> @given(plants_and_compensators())
    ... def check(drawn):
    ...     plant, compensator = drawn
    ...     assert plant.is_coprime and compensator.is_coprime
    >>> check()
    """
    kind = draw(st.sampled_from(["any", "any", "any", "zero", "zero", "pole"]))
    a, b = draw(coprime_pairs(variable, max_order))
    c, d = draw(coprime_pairs(variable, max_order))
    if kind == "any":
        return TransferFunction(b, a), TransferFunction(d, c)
    x = draw(rationals(4, 2))
    while 0 in (a.eval(x), b.eval(x), c.eval(x), d.eval(x)):
        x += 1
    root = Poly([1, -x], Symbol(variable), domain=QQ)
    other = Poly([1, -draw(rationals(4, 2))], Symbol(variable), domain=QQ)
    while (b * root * d).eval(other.nth(0) * -1) == 0:
        other += 1
    if kind == "zero":  # the plant has the zero x, the compensator the pole
        plant = TransferFunction(canonical(b * root), canonical(a * other))
        return plant, TransferFunction(d, canonical(c * root))
    compensator = TransferFunction(canonical(d * root), canonical(c * other))
    return TransferFunction(b, canonical(a * root)), compensator


@st.composite
def plants_with_common_factor(
    draw: st.DrawFn, variable: str = "s", max_order: int = 2
) -> tuple[TransferFunction, TransferFunction]:
    """Draw two coprime strictly proper plants, every other time with a pole in common.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import plants_with_common_factor
    >>> @given(plants_with_common_factor())
    ... def check(drawn):
    ...     assert all(plant.is_coprime and plant.is_strictly_proper for plant in drawn)
    >>> check()
    """
    a, b = draw(coprime_pairs(variable, max_order))
    c, d = draw(coprime_pairs(variable, max_order))
    if draw(st.booleans()):
        return TransferFunction(b, a), TransferFunction(d, c)
    x = draw(rationals(4, 2))
    while 0 in (b.eval(x), d.eval(x)):
        x += 1
    root = Poly([1, -x], Symbol(variable), domain=QQ)
    return TransferFunction(b, canonical(a * root)), TransferFunction(d, canonical(c * root))


# Irreducible over the rationals, all of whose roots are on the boundary of stability, at rational
# and irrational frequencies; the last of z has two on the circle, one inside and one outside.
_ON_THE_AXIS = ([1, 0], [1, 0, 1], [1, 0, 2], [1, 0, Rational(9, 4)], [1, 0, 3, 0, 1])
_ON_THE_CIRCLE = (
    [1, -1], [1, 1], [1, 0, 1], [1, Rational(-6, 5), 1], [1, Rational(1, 2), 1],
    [1, -1, -1, -1, 1],
)  # fmt: skip


def boundary_polynomials(variable: str = "s") -> st.SearchStrategy[Poly]:
    """Draw monic polynomials with roots on the boundary of stability, one in five a square.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import count_roots
    >>> from compensator_theory.strategies import boundary_polynomials
    >>> @given(boundary_polynomials("z"))
    ... def check(p):
    ...     assert count_roots(p, time="discrete").boundary > 0
    >>> check()
    """
    kinds = _ON_THE_AXIS if variable == "s" else _ON_THE_CIRCLE
    powers = st.sampled_from([1, 1, 1, 1, 2])
    return st.builds(
        lambda power, kind: canonical(Poly(kind, Symbol(variable), domain=QQ) ** power),
        powers,
        st.sampled_from(kinds),
    )


@st.composite
def boundary_loops(
    draw: st.DrawFn, variable: str = "s", max_order: int = 2
) -> tuple[TransferFunction, TransferFunction]:
    r"""Draw a plant and a compensator, both proper, whose loop is a corner of stability.

    Of nine: three hide a factor with roots on the boundary (a notch on a mode without damping, an
    integrator that a zero cancels, or both within the plant), one hides another factor, one has
    poles and zeros on the boundary, one is a constant, two are exactly proper with
    :math:`G G_c = -1` at infinity, so that 1 + L vanishes there, and one is real on the boundary.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import boundary_loops
    >>> @given(boundary_loops())
    ... def check(drawn):
    ...     assert all(part.is_proper for part in drawn)
    >>> check()
    """
    kind = draw(
        st.sampled_from(
            ["notch", "reset", "plant", "elsewhere", "shown", "constant", "at infinity",
             "at infinity, hidden", "real"]
        )
    )  # fmt: skip
    s = Symbol(variable)
    a, b = draw(coprime_pairs(variable, max_order))
    gain = Poly(draw(nonzero_rationals()), s, domain=QQ)
    one = Poly(1, s, domain=QQ)
    g, h = draw(boundary_polynomials(variable)), draw(boundary_polynomials(variable))
    off = draw(polynomials(variable, 1, 2, is_monic=True))

    def lag(size: int) -> Poly:
        pole = Rational(draw(st.integers(1, 4)), 5) if variable != "s" else draw(st.integers(1, 5))
        return Poly([1, pole], s, domain=QQ) ** size

    match kind:
        case "notch":
            sides = (b, a * g), (gain * g, lag(g.degree()))
        case "reset":
            sides = (b * g, a * lag(g.degree())), (gain, g)
        case "plant":
            sides = (b * g, a * g), (gain, one)
        case "elsewhere":
            sides = (b * off, a * off), (gain, one)
        case "shown":
            sides = (b, a * g), (gain * h, lag(h.degree()))
        case "constant":
            sides = (gain * off, off), (g, g)
        case "at infinity":
            sides = (b - a, a), (one, one)
        case "at infinity, hidden":
            sides = ((b - a) * g, a * g), (h, h)
        case _:  # L of s**2, or of z + 1/z
            x = Poly([1, 0, 0], s, domain=QQ)
            size = int(a.degree())
            if variable == "s":
                sides = (gain * b.compose(x), a.compose(x)), (one, one)
            else:
                sides = (gain * _reciprocal(b, size), _reciprocal(a, size)), (one, one)
    plant, compensator = sides
    return (
        TransferFunction(*map(canonical, plant)),
        TransferFunction(*map(canonical, compensator)),
    )


def _reciprocal(p: Poly, size: int) -> Poly:
    """z**size p(z + 1/z)."""
    z = p.gen
    both = Poly([1, 0, 1], z, domain=QQ)
    shifts = (Poly(z ** (size - k), z, domain=QQ) for k in range(size + 1))
    terms = (both**k * shift * p.nth(k) for k, shift in enumerate(shifts))
    return sum(terms, Poly(0, z, domain=QQ))
