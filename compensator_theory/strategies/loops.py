"""Loops whose closed-loop poles are drawn first, for Hypothesis."""

from __future__ import annotations

from math import prod
from typing import Literal

import sympy
from hypothesis import strategies as st
from sympy import QQ, Poly, Symbol

from compensator_theory.bezout._common_factors import bezout_identity
from compensator_theory.errors import InputError
from compensator_theory.polynomials._poly import canonical
from compensator_theory.strategies.plants import disguised, unimodular_matrices
from compensator_theory.strategies.polynomials import coprime_to, polynomials
from compensator_theory.strategies.spectra import hurwitz_spectra, schur_spectra, spectra
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction


@st.composite
def loops_with_spectrum(
    draw: st.DrawFn,
    order: int,
    real_roots: bool | None = None,
    *,
    region: Literal["any", "stable"] = "any",
    feedback: int = 1,
    variable: str = "s",
) -> tuple[Realisation, Realisation]:
    r"""Draw a minimal SISO plant and a minimal compensator of its order with a drawn spectrum.

    .. math:: D D_c - f\,N N_c = \prod_{i=1}^{2n} (s - \lambda_i), \qquad \deg N_c < n

    Parameters
    ----------
    order : int
        n, of plant and compensator.
    real_roots : bool, optional
        True: some of the 2n closed-loop poles are real. False: none is. By default one draw in
        three has none, one in three has all poles real, the others either.
    region : {"any", "stable"}
        Where the poles lie.
    feedback : {+1, -1}
        The sign f.
    variable : str
        s, or z or q for discrete time.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import certified_roots
    >>> from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
    >>> from compensator_theory.strategies import loops_with_spectrum
    >>> @given(loops_with_spectrum(3, real_roots=False))
    ... def check(loop):
    ...     plant, compensator = loop
    ...     poles = certified_roots(closed_loop_matrix(plant, compensator).charpoly("s"))
    ...     assert plant.is_minimal and compensator.is_minimal
    ...     assert not any(pole.is_real for pole in poles)
    >>> check()
    """
    if order < 1 or feedback not in (1, -1):
        raise InputError(f"order = {order} must be at least 1, and feedback = {feedback} +1 or -1")
    s = Symbol(variable)
    roots = draw(_spectrum(2 * order, real_roots, region, variable))
    target = prod((Poly(s - root, s) for root in roots), start=Poly(1, s))
    target = Poly(sympy.expand(target.as_expr()), s, domain=QQ)
    D = draw(polynomials(variable, order, order, is_monic=True))
    N = coprime_to(D, draw(polynomials(variable, 0, order - 1)))
    D_c, N_c = _compensator(D, N, target)
    while N_c.is_zero or D_c.gcd(N_c).degree() > 0:
        D = canonical(D + N)  # coprime to N as before; another compensator
        D_c, N_c = _compensator(D, N, target)
    sides = TransferFunction(N, D), TransferFunction(N_c * -feedback, D_c)
    plant, compensator = (
        Realisation(*disguised(*controllable_canonical_form(side)[:3], draw(
            unimodular_matrices(order))), variable=s)
        for side in sides
    )  # fmt: skip
    return plant, compensator


def _compensator(D: Poly, N: Poly, target: Poly) -> tuple[Poly, Poly]:
    """Return D_c and N_c with D D_c + N N_c = target, and N_c of lower degree than D."""
    identity = bezout_identity(D, N)
    N_c = canonical((identity.y * target).rem(D))
    return canonical((target - N * N_c).exquo(D)), N_c


@st.composite
def _spectrum(
    draw: st.DrawFn, size: int, real_roots: bool | None, region: str, variable: str
) -> tuple[sympy.Expr, ...]:
    stable = hurwitz_spectra if variable == "s" else schur_spectra
    strategy = spectra if region == "any" else stable
    if real_roots is not None:
        return draw(strategy(size, real_roots))
    kind = draw(st.sampled_from(["any", "complex", "real"]))
    if kind == "real":
        return tuple(root for _ in range(size) for root in draw(strategy(1, real_roots=True)))
    return draw(strategy(size, False if kind == "complex" else None))
