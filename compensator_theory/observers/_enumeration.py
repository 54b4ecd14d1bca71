"""Every observer-based form of a realisation, through its invariant subspaces."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from sympy import ImmutableMatrix, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.loops._siso import agreed_sign
from compensator_theory.matrices._cyclic_families import sample_subspaces
from compensator_theory.matrices._invariant_subspaces import (
    PrimaryComponent,
    divisors,
    joined,
    primary_components,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.matrices._open_cells import families as parametrised
from compensator_theory.matrices._strata import continuum_size, is_irreducible
from compensator_theory.observers._counting import number_of_selections
from compensator_theory.observers._form import ObserverForm, form_of_subspace
from compensator_theory.observers._form_lists import ObserverForms
from compensator_theory.polynomials._budget import ask, integer
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._realisations import Realisation

_SEARCH = "the search for invariant subspaces of the closed loop"


@refusing
def observer_forms(
    plant: RealisationLike,
    compensator: RealisationLike,
    *,
    feedback: int | None = None,
    limit: int = 20_000,
    variable: str | Symbol | None = None,
) -> ObserverForms:
    r"""Find every observer-based form of a compensator whose regulator polynomial is rational.

    .. math:: \mathrm{im}\begin{bmatrix} I \\ T \end{bmatrix} = \ker p_R(\tilde A), \qquad
              K = C_c T, \quad F = T^{-1} B_c

    Parameters
    ----------
    plant : realisation
        (A, B, C), of order n; anything :func:`realisation` reads; several inputs and outputs
        allowed.
    compensator : realisation
        :math:`(A_c, B_c, C_c)` with :math:`u = C_c x_c`, strictly proper, of any order
        :math:`n_c \ge 1`, in any basis, hidden modes included. A transfer function is realised in
        controllable canonical form.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1. With -1 the compensator of the result has
        the sign in its output matrix. A compensator of :func:`place_poles` knows its sign, and
        another one is refused.
    limit : int
        Largest number of regulator polynomials to test.
    variable : str or Symbol, optional
        Of both; default: evident, bare matrices need it.

    Returns
    -------
    ObserverForms
        Complete if every real regulator polynomial of degree n is rational.

    Raises
    ------
    InputError
        If signals or variables do not fit, the compensator has a direct term or no state, or there
        are more than `limit` candidates.

    Notes
    -----
    For a minimal SISO plant and a minimal compensator every real invariant subspace of dimension n
    gives a form, so that there are :func:`count_observer_forms` of them. With hidden modes or
    several signals there is no such theorem and each subspace is tested. Where the closed loop
    is derogatory the subspaces of one regulator polynomial form a continuum: cyclic ones, ones with
    a cyclic quotient, and Grassmannians between two kernels are parametrised, others are sampled,
    and `continua` names the dimension of all of them together.

    ``rcac_numeric.observer_forms`` has those of irrational regulator polynomials too, in float64.

    Source: (7.11)-(7.18), Theorem 1 in the strength that is true of realisations.

    Examples
    --------
    >>> from compensator_theory import observer_forms, realisation
    >>> plant = ([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])
    >>> G_c = realisation("-(33/4*s + 93/4)/(s**2 + 13*s + 49)")  # (7.31), u = G_c y
    >>> for form in observer_forms(plant, G_c, variable="s").forms:
    ...     print(form.K, form.F.T)
    Matrix([[-5, -7]]) Matrix([[2, -1/4]])
    Matrix([[-15/4, -6]]) Matrix([[3, -1/2]])
    Matrix([[-3, -5]]) Matrix([[4, -3/4]])
    Matrix([[-5/4, -4]]) Matrix([[5, 1/2]])
    Matrix([[-1, -3]]) Matrix([[6, 3/4]])
    Matrix([[-3/4, -2]]) Matrix([[7, 3/2]])
    """
    system = realisation(plant, variable)
    ask("entries", system.n**3, _SEARCH)  # before the slow reading of the compensator
    loop_compensator = realisation(compensator, variable)
    ask("entries", (system.n + loop_compensator.n) ** 3, _SEARCH)
    controller = loop_compensator.with_sign(agreed_sign(loop_compensator, feedback))
    loop = closed_loop_matrix(system, controller)
    if not (system.n and controller.n):
        raise InputError(
            f"the plant has {system.n} and the compensator {controller.n} states; an observer "
            "needs both to have some"
        )
    integer(limit, "limit")
    whole = characteristic_polynomial(loop, system.variable)
    components = primary_components(loop, whole)
    candidates = number_of_selections([(c.degree, c.multiplicity) for c in components], system.n)
    if candidates > limit:
        raise InputError(
            f"there are {candidates} regulator polynomials to test, more than limit = {limit}; "
            "raise the limit, use count_observer_forms, or call rcac_numeric.observer_forms for "
            "float64"
        )
    forms: list[ObserverForm] = []
    families: list[ObserverForm] = []
    rejections: list[tuple[Poly, str]] = []
    undecided: list[Poly] = []
    continua: list[tuple[Poly, int, int]] = []
    for exponents, p_R in divisors(components, system.n):
        p_O = canonical(whole.exquo(p_R))
        chosen = list(zip(components, exponents, strict=True))
        is_continuum = any(c.has_continuum(e) for c, e in chosen)
        result: ObserverForm | str | None
        if is_continuum:
            size = continuum_size(chosen)
            continua.append((p_R, *size))
            result = _of_continuum(system, controller, loop, chosen, (p_R, p_O), size[0])
        else:
            subspace = _stacked(loop.rows, chosen)
            result = form_of_subspace(system, controller, subspace, (p_R, p_O))
        if result is None:
            undecided.append(p_R)
        elif isinstance(result, str):
            rejections.append((p_R, result))
        else:
            (families if is_continuum else forms).append(result)
    return ObserverForms(
        system, controller, whole, tuple(forms), tuple(families), tuple(rejections),
        tuple(undecided), tuple(continua),
    )  # fmt: skip


_Chosen = Sequence[tuple[PrimaryComponent, int]]


def _stacked(rows: int, chosen: _Chosen) -> ImmutableMatrix:
    return joined(rows, [component.kernels[exponent] for component, exponent in chosen])


def _of_continuum(
    plant: Realisation,
    compensator: Realisation,
    loop: ImmutableMatrix,
    chosen: _Chosen,
    polynomials: tuple[Poly, Poly],
    dimension: int,
) -> ObserverForm | str | None:
    """Return a family of forms, one form, the reason why none exists, or None if undecided."""
    largest = _stacked(loop.rows, chosen)
    if rank(largest[: plant.n, :]) < plant.n:
        return (
            "every subspace with this polynomial holds a compensator state that no plant state "
            "accompanies"
        )
    if rank(largest[plant.n :, :]) < min(plant.n, compensator.n):
        return "in every subspace with this polynomial T lacks full rank"
    all_fail = is_irreducible(chosen)
    for subspace, parameters in parametrised(loop, chosen):
        form = form_of_subspace(plant, compensator, subspace, polynomials, parameters)
        if isinstance(form, ObserverForm):
            return form
        if all_fail and len(parameters) == dimension:
            return form  # the family is dense, so that a generic failure is a failure everywhere
    for subspace in _samples(loop, chosen):
        form = form_of_subspace(plant, compensator, subspace, polynomials)
        if isinstance(form, ObserverForm):
            return form
    return None


def _samples(loop: ImmutableMatrix, chosen: _Chosen) -> Iterator[ImmutableMatrix]:
    choices = [
        sample_subspaces(loop, component, exponent)
        if component.has_continuum(exponent)
        else [component.kernels[exponent]]
        for component, exponent in chosen
    ]
    few = [list(itertools.islice(choice, 20)) for choice in choices]
    for blocks in itertools.islice(itertools.product(*few), 200):
        yield joined(loop.rows, blocks)
