"""Every compensator of given order that places the closed-loop poles at given points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Literal, cast

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.bezout._coprime_equations import solve_coprime_equation
from compensator_theory.bezout._sylvester import sylvester_m
from compensator_theory.errors import (
    Advice,
    ImproperError,
    InputError,
    NoSolutionError,
    NotCoprimeError,
)
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
)
from compensator_theory.loops._siso import require_sign
from compensator_theory.matrices._echelon import contradictions
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._linear_algebra import solve_affine
from compensator_theory.placement._solutions import PolePlacement
from compensator_theory.polynomials._budget import integer, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import (
    SpectrumLike,
    from_read_roots,
    lists_roots,
    read_roots,
)
from compensator_theory.polynomials._letters import names_in_all, numbered
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import canonical, from_coefficients, monic, scaled
from compensator_theory.polynomials._reading import PolynomialLike, is_one_of
from compensator_theory.polynomials._reading import polynomial as read_polynomial
from compensator_theory.polynomials._variables import require_no_other_operator
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._transfer_functions import (
    TransferFunction,
    require_proper,
)


@carrying()
def place_poles(
    plant: TransferFunctionLike,
    target: SpectrumLike | None = None,
    n_c: int | Literal["least"] | None = None,
    *,
    feedback: int,
    polynomial: PolynomialLike | None = None,
    numerator_degree: int | None = None,
    properness: str | None = None,
    variable: str | Symbol | None = None,
) -> PolePlacement:
    r"""Solve the pole placement equation exactly, for one compensator or for all of them.

    .. math:: D D_c - f\, N N_c = \tilde D, \qquad \deg D_c = n_c, \quad \deg N_c \le \hat m_c

    with :math:`f = +1` for positive feedback :math:`u = G_c y` and :math:`f = -1` for negative.

    Parameters
    ----------
    plant : transfer function
        :math:`N/D` of order n; anything :func:`transfer_function` reads; symbols allowed.
    target : polynomial or list of roots, also in a text: "-1, -2"
        :math:`\tilde D` of degree :math:`n + n_c`, up to a factor. A list holds its *roots*, and
        the result says so; coefficients go to `polynomial`. Roots may be irrational.
    n_c : int or "least", optional
        Order of the compensator; default deg(target) - n. With "least" the target is a list of
        roots, the most important first: the compensator has the least order n_c that places the
        first n + n_c roots, and ignores the others. An order that would split a complex-conjugate
        pair is skipped.
    feedback : {+1, -1}
        The sign f. Chapters 2 and 4 use +1, Section 7.3 and after -1.
    polynomial : polynomial, optional
        :math:`\tilde D` in place of `target`; here a list holds *coefficients*, descending.
    numerator_degree : int, optional
        :math:`\hat m_c \le n_c`, default min(n - 1, n_c).
    properness : {"strictly proper", "exactly proper"}, optional
        Ask for :math:`\deg N_c < n_c`, which lowers the default of `numerator_degree` to
        min(n - 1, n_c - 1), or for :math:`\deg N_c = n_c`, which makes it n_c and, in a family,
        chooses the member whose leading coefficient is 1.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    PolePlacement
        Unique with the default if N and D are coprime and :math:`n_c \ge n - 1`. From
        ``numerator_degree`` = n on a family whose numerator_degree - n + 1 parameters are the
        coefficients of N_c above degree n - 1; zeros give the unique compensator back.

    Raises
    ------
    NotCoprimeError
        If N and D share a factor that the target lacks; the message names it.
    ImproperError
        If the plant is improper or numerator_degree > n_c.
    NoSolutionError
        If n_c or numerator_degree is below n - 1 and the target is out of reach. The message
        gives the linear relation that every reachable target satisfies and this one does not.
        If no order up to the length of a list does; with 2n - 1 poles (2n for a strictly proper
        compensator) and a coprime plant one always does, pairs of complex poles permitting.
    InputError
        If degrees do not fit or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: (7.23), (7.32)-(7.38). Proposition 5 says this for :math:`n_c \in \{n-1, n\}`; existence
    and uniqueness hold for every :math:`n_c \ge n-1` with :math:`\deg N_c \le n-1`, also for
    exactly proper plants. For these, with :math:`\deg N_c = n_c` allowed, the leading coefficient
    of the left side is :math:`\lambda = 1 - f N_n N_{c,n_c}`; the solution satisfies
    :math:`D D_c - f N N_c = \lambda\tilde D`.

    Examples
    --------
    >>> from compensator_theory import place_poles
    >>> print(place_poles("4/((s + 1)*(s + 3))", [-6, -5, -4, -2], feedback=-1))  # Example 7.5
    G_c = (33*s/4 + 93/4)/(s**2 + 13*s + 49)
    unique: deg N_c <= 1, deg D_c = 2
    D D_c + N N_c = s**4 + 17*s**3 + 104*s**2 + 268*s + 240
    >>> placement = place_poles("1/(s*(s + 3))", [-1, -2, -5, -6], "least", feedback=-1)
    >>> print(placement.compensator)  # D + 2 = (s + 1)(s + 2), so that no dynamics are needed
    (2)/(1)
    """
    require_sign(feedback)
    G = transfer_function(plant, variable)
    require_proper(G, "plant")
    if isinstance(n_c, str):
        if n_c != "least" or polynomial is not None or numerator_degree is not None:
            raise InputError(
                f'n_c = {repr_of(n_c)} must be an integer or "least", which takes a list of roots '
                "and chooses the degrees itself"
            )
        return _of_least_order(G, target, feedback, properness)
    goal, roots = _goal(target, polynomial, G)
    n, degree = G.order, goal.degree()
    n_c = degree - n if n_c is None else n_c
    for name, value in (("n_c", n_c), ("numerator_degree", numerator_degree)):
        if value is not None:
            integer(value, name)
    if n_c < 0 or degree != n + n_c:
        raise InputError(
            f"the target has degree {degree}, but a plant of order {n} with a compensator "
            f"of order {max(n_c, 0)} has {n + max(n_c, 0)} closed-loop poles"
        )
    m_hat = _numerator_degree(n, n_c, numerator_degree, properness)
    _check_degrees(G, n_c, m_hat)
    homogeneous: tuple[Pair, ...] = ()
    pair = _solve_coprime(G, goal, n_c, m_hat, feedback)
    if pair is None:
        _check_fixed_poles(G, goal)
        pair, homogeneous = _solve(G, goal, n_c, m_hat, feedback)
    placement = _placement(G, goal, n_c, feedback, pair, homogeneous, roots)
    return _exactly_proper(placement) if properness == "exactly proper" else placement


def _of_least_order(
    G: TransferFunction, target: SpectrumLike | None, feedback: int, properness: str | None
) -> PolePlacement:
    poles = read_roots(cast(Iterable[NumberLike], target))
    if len(poles) < G.order:
        raise InputError(
            f"there are {len(poles)} poles, but the loop has at least {G.order}; give more"
        )
    from_read_roots(poles, G.variable)  # complain about the whole list first
    reason: Exception | None = None
    for count in range(G.order, len(poles) + 1):
        try:
            from_read_roots(poles[:count], G.variable)
        except InputError:
            continue  # a conjugate pair is divided here
        try:
            return place_poles(G, poles[:count], feedback=feedback, properness=properness)
        except (NoSolutionError, ImproperError) as error:
            reason = error
    raise NoSolutionError(
        f"no order n_c from 0 to {len(poles) - G.order} places the first n + n_c of these "
        f"{len(poles)} poles; with {2 * G.order} of them one would. Last reason: {reason}"
    ) from reason


def _goal(
    target: SpectrumLike | None, coefficients: PolynomialLike | None, G: TransferFunction
) -> tuple[Poly, tuple[Expr, ...] | None]:
    """Return the monic target, and its roots if a list of them was given."""
    if (target is None) == (coefficients is None):
        raise InputError(
            "give either the target (a polynomial or a list of roots) or, as polynomial= to "
            "place_poles, its coefficients"
        )
    roots = None
    if coefficients is not None:
        goal = read_polynomial(coefficients, G.variable)
    elif lists_roots(target):
        roots = read_roots(cast(Iterable[NumberLike], target))
        goal = from_read_roots(roots, G.variable)
    else:
        goal = read_polynomial(cast(PolynomialLike, target), G.variable)
    require_no_other_operator(goal)
    return monic(goal), roots


def _numerator_degree(n: int, n_c: int, degree: int | None, properness: str | None) -> int:
    known = ("strictly proper", "exactly proper")
    if properness is not None and not is_one_of(properness, known):
        raise InputError(
            f"properness = {repr_of(properness)} must be 'strictly proper' or 'exactly proper'"
        )
    if properness == "exactly proper":
        if degree not in (None, n_c):
            raise InputError(f"an exactly proper compensator has numerator_degree = n_c = {n_c}")
        return n_c
    limit = n_c - 1 if properness == "strictly proper" else n_c
    if degree is not None and degree > limit and properness == "strictly proper":
        raise InputError(f"a strictly proper compensator has numerator_degree <= {limit}")
    return min(n - 1, limit) if degree is None else degree


def _exactly_proper(placement: PolePlacement) -> PolePlacement:
    """Return the placement with a member of degree n_c in front."""
    order = int(placement.denominator.degree())
    if placement.numerator.degree() == order:
        return placement
    if placement.is_unique:
        raise NoSolutionError(
            f"the only compensator that places these poles, {placement.compensator}, is not "
            f"exactly proper. From n_c = {placement.plant.order} on there is a family with one"
        )
    last = [0] * (len(placement.homogeneous) - 1) + [1]  # the coefficient of s**n_c
    member = placement.member(last)
    return replace(placement, numerator=member.numerator, denominator=member.denominator)


def _check_degrees(G: TransferFunction, n_c: int, m_hat: int) -> None:
    if m_hat > n_c:
        raise ImproperError(
            f"numerator_degree = {m_hat} exceeds the order n_c = {n_c} and allows an improper "
            f"compensator; choose numerator_degree <= {n_c} or a target of higher degree"
        )
    if m_hat < -1:
        raise InputError(f"numerator_degree = {m_hat} must be at least 0 (or -1 for N_c = 0)")
    if m_hat == n_c >= G.order and not G.is_strictly_proper:
        raise InputError(
            f"the plant {G} is exactly proper; with numerator_degree = n_c = {n_c} the leading "
            "coefficient of the closed loop would depend on the free parameters. Choose "
            f"numerator_degree <= {n_c - 1}"
        )


def _check_fixed_poles(G: TransferFunction, goal: Poly) -> None:
    factor = G.common_factor()
    if factor.degree() > 0 and not (rest := canonical(goal.rem(factor))).is_zero:
        raise NotCoprimeError(
            f"numerator and denominator of {G} share the factor {format_polynomial(factor)}; its "
            "roots stay closed-loop poles whatever the compensator. Include them in the target ",
            Advice("TransferFunction.reduced", (), "or reduce the plant with .reduced()"),
        ).holding(rest.all_coeffs(), denominators(PolynomialMatrix(((factor, rest),))))


Pair = tuple[Poly, Poly]
"""(D_c, N_c)."""


def _solve_coprime(
    G: TransferFunction, goal: Poly, n_c: int, m_hat: int, feedback: int
) -> Pair | None:
    """Return the only pair there is of rational data without a common factor, else None."""
    if not 0 < G.order == m_hat + 1 <= n_c + 1 or G.numerator.is_zero:
        return None
    if not all(side.domain.is_QQ for side in (G.denominator, G.numerator, goal)):
        return None
    return solve_coprime_equation(G.denominator, scaled(G.numerator, -feedback), goal)


def _solve(
    G: TransferFunction, goal: Poly, n_c: int, m_hat: int, feedback: int
) -> tuple[Pair, tuple[Pair, ...]]:
    M = sylvester_m(G.denominator, scaled(G.numerator, -feedback), n_c + 1, m_hat)
    high_degrees_last = [*range(n_c + 1), *reversed(range(n_c + 1, M.cols))]  # so these are free
    M = M.extract(list(range(M.rows)), high_degrees_last)
    try:
        solution = solve_affine(M, ImmutableMatrix(goal.all_coeffs()))
    except NoSolutionError as error:
        n = G.order
        raise NoSolutionError(
            f"no compensator with n_c = {n_c} and deg N_c <= {m_hat} places these poles: "
            f"{_obstruction(M, goal)}. ",
            Advice(
                "place_poles",
                (("n_c", f"{n - 1}"), ("numerator_degree", f"{n - 1}")),
                "From n_c = {n_c} and numerator_degree = {numerator_degree} on",
            ),
            ", every target is reached",
        ).holding(contradictions(M, ImmutableMatrix(goal.all_coeffs()))) from error
    homogeneous = tuple(_pair(vector, G, n_c) for vector in solution.nullspace)
    return _pair(solution.particular, G, n_c), homogeneous


def _obstruction(M: ImmutableMatrix, goal: Poly) -> str:
    """Return the linear relation between target coefficients that proves there is no solution."""
    descending = goal.all_coeffs()
    for relation in solve_affine(M.T, zero_matrix(M.cols, 1)).nullspace:
        value = sympy.cancel(sum(y * c for y, c in zip(relation, descending, strict=True)))
        if value != 0:
            degree = len(descending) - 1
            letters = numbered(names_in_all(M, goal), "t", degree, first=0)[::-1]
            terms = sum(y * t for y, t in zip(relation, letters, strict=True))
            name = letters[0].name.rpartition("_")[0]
            return (
                f"with {name}_i the coefficient of {goal.gen}**i, every reachable target has "
                f"{terms} = 0, but this one gives {value}"
            )
    return "the equations contradict each other"


def _placement(
    G: TransferFunction,
    goal: Poly,
    n_c: int,
    feedback: int,
    pair: Pair,
    homogeneous: tuple[Pair, ...],
    roots: tuple[Expr, ...] | None,
) -> PolePlacement:
    D_c, N_c = pair
    if D_c.degree() < n_c:
        raise ImproperError(
            f"the only pair that places these poles is N_c = {format_polynomial(N_c)}, "
            f"D_c = {format_polynomial(D_c)}, which is improper as a compensator of order {n_c}; "
            "the loop would not be well posed. Change the target slightly or raise n_c"
        )
    leading = D_c.LC()
    if leading != 1:
        D_c, N_c = (scaled(side, 1 / leading) for side in pair)
    exchanged = tuple((d_numerator, d_denominator) for d_denominator, d_numerator in homogeneous)
    return PolePlacement(G, goal, feedback, N_c, D_c, exchanged, roots)


def _pair(vector: ImmutableMatrix, G: TransferFunction, n_c: int) -> tuple[Poly, Poly]:
    coefficients = list(vector)
    denominator, numerator = coefficients[: n_c + 1], coefficients[:n_c:-1]
    s = G.variable
    return from_coefficients(denominator, s), from_coefficients(numerator or [sympy.S.Zero], s)
