"""Realisations of compensators for Hypothesis, minimal or with hidden modes."""

from __future__ import annotations

from typing import Literal

from hypothesis import strategies as st
from sympy import ImmutableMatrix, Symbol, diag

from compensator_theory.errors import InputError
from compensator_theory.strategies.plants import disguised, unimodular_matrices
from compensator_theory.strategies.polynomials import (
    coprime_to,
    nonzero_rationals,
    polynomials,
    rationals,
)
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction

Hidden = Literal["uncontrollable", "unobservable", "both"]


@st.composite
def compensators(
    draw: st.DrawFn, order: int, hidden: tuple[Hidden, ...] = (), variable: str = "s"
) -> Realisation:
    """Draw strictly proper SISO compensators of the given order.

    Parameters
    ----------
    order : int
        n_c, hidden modes included.
    hidden : tuple of {"uncontrollable", "unobservable", "both"}
        One real mode for each: uncontrollable (but observable), unobservable (but controllable),
        or both. Default: none, so that the realisation is minimal.

    Returns
    -------
    strategy for Realisation
        The coordinates hide the structure. The visible part has order n_c - len(hidden); with order
        0 it is the zero compensator. No two modes are at the same number, so that each remains
        controllable or observable where it is to be.
    """
    kinds = ("uncontrollable", "unobservable", "both")
    visible = order - len(hidden)
    if visible < 0:
        raise InputError(f"order {order} is too low for {len(hidden)} hidden modes")
    if not set(hidden) <= set(kinds):
        raise InputError(f"hidden = {hidden} must name modes of {', '.join(kinds)}")
    A, B, C = draw(_minimal(visible))
    for kind in hidden:
        mode = draw(rationals())
        while A.rows and A.charpoly().eval(mode) == 0:
            mode += 1
        A = diag(A, mode)
        b = draw(nonzero_rationals()) if kind == "unobservable" else 0
        c = draw(nonzero_rationals()) if kind == "uncontrollable" else 0
        B, C = B.col_join(ImmutableMatrix([[b]])), C.row_join(ImmutableMatrix([[c]]))
    matrices = disguised(A, B, C, draw(unimodular_matrices(order)))
    return Realisation(*matrices, variable=Symbol(variable))


@st.composite
def _minimal(
    draw: st.DrawFn, order: int
) -> tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]:
    if order == 0:
        return ImmutableMatrix(0, 0, []), ImmutableMatrix(0, 1, []), ImmutableMatrix(1, 0, [])
    D_c = draw(polynomials(min_degree=order, max_degree=order, is_monic=True))
    N_c = coprime_to(D_c, draw(polynomials(max_degree=order - 1)))
    A, B, C, _ = controllable_canonical_form(TransferFunction(N_c, D_c))
    return A, B, C
