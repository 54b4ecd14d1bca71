"""Proofs in certified balls that irrational invariant subspaces give observer-based forms."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import flint
from sympy import ImmutableMatrix, Poly

from compensator_theory.matrices._flint_matrices import to_flint
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import root_balls

PRECISIONS = (128, 1024)
"""Bits; a determinant whose ball still holds 0 at the last is taken for a zero, unproved."""

MOST = 300
"""Real splits of the spectrum that are tried."""

Chain = list[list[flint.acb]]


@dataclass(frozen=True)
class BallProof(ExactValue):
    """Number of real splits of the closed-loop spectrum that provably give a form.

    Attributes
    ----------
    proved : int
        Splits whose determinants are certainly not 0.
    tried : int
        Splits that were tried; the others may or may not give a form.
    is_exhaustive : bool
        Whether these are all real splits.
    """

    proved: int
    tried: int
    is_exhaustive: bool


def prove_forms(loop: ImmutableMatrix, Dtilde: Poly, n: int) -> BallProof:
    r"""Try the real splits of a spectrum, irrational ones too, in balls.

    .. math:: w(\lambda) = \mu(\lambda)(\lambda I - \tilde A)^{-1} b, \qquad
              V = \begin{bmatrix} w & w' & \tfrac12 w'' & \cdots \end{bmatrix}, \qquad
              \det V_1 \ne 0

    Notes
    -----
    Here :math:`\mu` is the minimal polynomial and b a fixed vector. The first e Taylor coefficients
    of w at a root of multiplicity m >= e of it span an invariant subspace whenever they are
    independent, because :math:`(\lambda I - \tilde A)w = \mu b`; where the root has several Jordan
    blocks those of another b follow. A determinant of V_1 that is certainly not 0 proves that they
    are, and that T exists. T has full rank if
    :math:`\det V_2 V_2^* \ne 0` (:math:`V_2^* V_2` for n_c > n, with the Youla parameter's columns
    beside T). So "proved" needs no assumption on Jordan blocks. The converse is not true: a ball
    never proves that a number is 0.
    """
    minimal = from_flint_polynomial(to_flint(loop).minpoly(), Dtilde.gen)
    for precision in PRECISIONS:
        with ball_precision(precision):
            balls = root_balls(Dtilde, precision)
            longest = [
                next(length for other, length in root_balls(minimal, precision)
                     if other.overlaps(ball)) for ball, _ in balls
            ]  # fmt: skip
            chains = [
                _chains(loop, minimal, ball, m, length)
                for (ball, m), length in zip(balls, longest, strict=True)
            ]
            units = _real_units(balls)
            sizes = (n, loop.rows - 2 * n) if loop.rows > 2 * n else (n,)
            splits = list(itertools.islice(_splits(units, sizes), MOST + 1))
            splits_tried = splits[:MOST]
            proved = sum(_gives_form(chains, split, n) for split in splits_tried)
        if proved == len(splits_tried):
            break
    return BallProof(proved, len(splits_tried), len(splits) <= MOST)


def _chains(
    loop: ImmutableMatrix, minimal: Poly, root: flint.acb, multiplicity: int, longest: int
) -> Chain:
    """Return Taylor coefficients of w at a root, of several b for several Jordan blocks."""
    columns: Chain = []
    while len(columns) < multiplicity:
        columns += _chain(loop, minimal, root, longest, len(columns))
    return columns[:multiplicity]


def _chain(loop: ImmutableMatrix, minimal: Poly, root: flint.acb, length: int, seed: int) -> Chain:
    size, A = loop.rows, to_flint(loop)
    b = flint.fmpq_mat(size, 1, [3 + (k * k + (5 + seed) * k + seed) % 11 for k in range(size)])
    columns = [b]
    for c in minimal.all_coeffs()[1:-1]:
        columns.append(A * columns[-1] + b * flint.fmpq(int(c.p), int(c.q)))
    shifted = flint.acb_poly([root, 1])
    rows = []
    for i in range(size):
        entry = flint.acb_poly([flint.acb(flint.arb(w[i, 0])) for w in reversed(columns)])
        coefficients = entry(shifted).coeffs()
        rows.append(
            [coefficients[k] if k < len(coefficients) else flint.acb(0) for k in range(length)]
        )
    return [[row[k] for row in rows] for k in range(length)]


Unit = tuple[tuple[int, ...], int]
"""Indices of a real root or of a pair, and the multiplicity."""


def _real_units(balls: Sequence[tuple[flint.acb, int]]) -> list[Unit]:
    units: list[Unit] = []
    for i, (ball, multiplicity) in enumerate(balls):
        if ball.imag == 0:
            units.append(((i,), multiplicity))
        elif ball.imag > 0:
            mirror = ball.conjugate()
            partner = next(j for j, (other, _) in enumerate(balls) if other.overlaps(mirror))
            units.append(((i, partner), multiplicity))
    return units


Split = list[tuple[Unit, tuple[int, ...]]]


def _splits(units: Sequence[Unit], sizes: tuple[int, ...]) -> Iterator[Split]:
    """Yield, for each unit, how many of its roots go to each part of the given degrees."""
    if not units:
        if not any(sizes):
            yield []
        return
    (indices, multiplicity), rest = units[0], units[1:]
    if sum(sizes) > sum(len(i) * m for i, m in units):
        return
    for share in itertools.product(range(multiplicity + 1), repeat=len(sizes)):
        left = tuple(size - len(indices) * e for size, e in zip(sizes, share, strict=True))
        if sum(share) <= multiplicity and min(left) >= 0:
            for others in _splits(rest, left):
                yield [(units[0], share), *others]


def _gives_form(chains: Sequence[Chain], split: Split, n: int) -> bool:
    """Return whether certified nonzero determinants prove the form of this split."""
    inner, outer = [], []
    for (indices, _), share in split:
        for i in indices:
            inner += chains[i][: share[0]]
            outer += chains[i][share[0] : sum(share)]
    V_1, V_2 = _rows(inner, 0, n), _rows(inner, n, None)
    try:
        T = V_2 * V_1.inv()
    except ZeroDivisionError:
        return False
    if outer:
        rest = _rows(outer, n, None) - T * _rows(outer, 0, n)
        both = [t + r for t, r in zip(T.tolist(), rest.tolist(), strict=True)]
        return not flint.acb_mat(both).det().contains(0)
    adjoint = T.conjugate().transpose()
    gram = T * adjoint if T.nrows() <= T.ncols() else adjoint * T
    return not gram.det().contains(0)


def _rows(columns: Chain, first: int, last: int | None) -> flint.acb_mat:
    return flint.acb_mat([column[first:last] for column in columns]).transpose()
