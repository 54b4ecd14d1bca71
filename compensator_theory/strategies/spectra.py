"""Multisets of exact numbers, symmetric under conjugation, for Hypothesis."""

from __future__ import annotations

import sympy
from hypothesis import strategies as st
from sympy import Expr, Rational

from compensator_theory.errors import InputError
from compensator_theory.strategies.polynomials import nonzero_rationals, rationals


@st.composite
def spectra(draw: st.DrawFn, size: int, real_roots: bool | None = None) -> tuple[Expr, ...]:
    """Draw `size` exact numbers, real or in conjugate pairs, repetitions included.

    Parameters
    ----------
    size : int
        Number of roots, with multiplicity.
    real_roots : bool, optional
        True: at least one is real. False: none is. Default: either.
    """
    pairs = draw(_numbers_of_pairs(size, real_roots))
    roots: list[Expr] = []
    for _ in range(pairs):
        roots += _pair(draw(rationals()), draw(nonzero_rationals()))
    roots += draw(st.lists(rationals(), min_size=size - 2 * pairs, max_size=size - 2 * pairs))
    return tuple(draw(st.permutations(roots)))


@st.composite
def hurwitz_spectra(draw: st.DrawFn, size: int, real_roots: bool | None = None) -> tuple[Expr, ...]:
    """Draw `size` exact numbers with negative real part, real or in conjugate pairs.

    Parameters
    ----------
    size, real_roots
        As for :func:`spectra`.
    """
    negative = st.builds(Rational, st.integers(1, 9), st.integers(1, 4)).map(lambda x: -x)
    pairs = draw(_numbers_of_pairs(size, real_roots))
    roots: list[Expr] = []
    for _ in range(pairs):
        roots += _pair(draw(negative), draw(nonzero_rationals()))
    roots += draw(st.lists(negative, min_size=size - 2 * pairs, max_size=size - 2 * pairs))
    return tuple(draw(st.permutations(roots)))


@st.composite
def schur_spectra(draw: st.DrawFn, size: int, real_roots: bool | None = None) -> tuple[Expr, ...]:
    """Draw `size` exact numbers of modulus below 1, real or in conjugate pairs.

    Complex ones are scaled into the disk: a + jb is divided by 1 + abs(a) + abs(b).

    Parameters
    ----------
    size, real_roots
        As for :func:`spectra`.
    """
    pairs = draw(_numbers_of_pairs(size, real_roots))
    roots: list[Expr] = []
    for _ in range(pairs):
        a, b = draw(rationals()), draw(nonzero_rationals())
        scale = 1 + abs(a) + abs(b)
        roots += _pair(a / scale, b / scale)
    inside = rationals().map(lambda x: x / (1 + abs(x)))
    roots += draw(st.lists(inside, min_size=size - 2 * pairs, max_size=size - 2 * pairs))
    return tuple(draw(st.permutations(roots)))


def _pair(real: Expr, imaginary: Expr) -> list[Expr]:
    return [real + sympy.I * imaginary, real - sympy.I * imaginary]


def _numbers_of_pairs(size: int, real_roots: bool | None) -> st.SearchStrategy[int]:
    if real_roots is False:
        if size % 2:
            raise InputError(f"{size} roots cannot all be in conjugate pairs; choose an even size")
        return st.just(size // 2)
    if real_roots and size == 0:
        raise InputError("a spectrum without roots has no real root; choose size >= 1")
    return st.integers(0, (size - 1) // 2 if real_roots else size // 2)
