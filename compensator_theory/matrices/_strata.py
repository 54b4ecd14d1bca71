"""Size of a continuum of invariant subspaces: strata, dimensions, components."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

from compensator_theory.matrices._invariant_subspaces import PrimaryComponent
from compensator_theory.polynomials._budget import ask

Partition = tuple[int, ...]
"""Lengths of Jordan blocks, descending."""


@dataclass(frozen=True)
class Stratum:
    r"""The invariant subspaces of one type with quotients of one type, for one root.

    Attributes
    ----------
    subspace, quotient : tuple of int
        Lengths of the Jordan blocks of the restriction and of the quotient, :math:`\mu, \nu`.
    dimension : int
        :math:`n(\lambda) - n(\mu) - n(\nu)` with :math:`n(\lambda) = \sum_i (i - 1)\lambda_i`.
    components : int
        The Littlewood-Richardson coefficient :math:`c^\lambda_{\mu\nu}`: irreducible components,
        all of that dimension.
    """

    subspace: Partition
    quotient: Partition
    dimension: int
    components: int


def strata(blocks: Sequence[int], size: int) -> tuple[Stratum, ...]:
    r"""Return all strata of the invariant subspaces of a nilpotent matrix, largest first.

    .. math:: g^\lambda_{\mu\nu}(q) = c^\lambda_{\mu\nu}\,q^{n(\lambda)-n(\mu)-n(\nu)}
              + \text{lower powers}

    Notes
    -----
    The number of such subspaces over a field of q elements is Hall's polynomial above. Source: I.
    G. Macdonald, Symmetric Functions and Hall Polynomials (1995), II.4 and I.9; that each
    irreducible component has this dimension: N. Spaltenstein, Indagationes Mathematicae 38 (1976).
    """
    whole = tuple(sorted(blocks, reverse=True))
    rest = sum(whole) - size
    if whole[0] == 1:  # every subspace is invariant
        return (Stratum((1,) * size, (1,) * rest, size * rest, 1),)
    pairs = _number_of_partitions(size) * _number_of_partitions(rest)
    ask("terms", pairs, "the strata of invariant subspaces")
    strata_of_type = []
    for mu in partitions(size):
        if len(mu) > len(whole) or any(m > w for m, w in zip(mu, whole, strict=False)):
            continue
        for nu in partitions(rest):
            count = littlewood_richardson(whole, mu, nu)
            if count:
                dimension = _weight(whole) - _weight(mu) - _weight(nu)
                strata_of_type.append(Stratum(mu, nu, dimension, count))
    return tuple(sorted(strata_of_type, key=lambda s: (-s.dimension, s.subspace, s.quotient)))


def continuum_size(chosen: Sequence[tuple[PrimaryComponent, int]]) -> tuple[int, int]:
    r"""Return dimension and number of components of that dimension, of all subspaces together."""
    dimension, components = 0, 1
    for component, exponent in chosen:
        if component.has_continuum(exponent):
            every = strata(component.block_lengths, exponent)
            largest = every[0].dimension
            dimension += component.degree * largest
            components *= sum(s.components for s in every if s.dimension == largest)
    return dimension, components


@cache
def partitions(size: int, largest: int | None = None) -> tuple[Partition, ...]:
    """Return all partitions of a number, largest parts first."""
    if size == 0:
        return ((),)
    top = min(size, size if largest is None else largest)
    return tuple(
        (first, *rest) for first in range(top, 0, -1) for rest in partitions(size - first, first)
    )


@cache
def littlewood_richardson(whole: Partition, part: Partition, content: Partition) -> int:
    r"""Return the coefficient :math:`c^\lambda_{\mu\nu}`.

    The number of ways to fill :math:`\lambda/\mu` with :math:`\nu_i` entries i, weakly increasing
    along rows, strictly down columns, such that read from right to left, row by row, no i + 1 is
    ahead of the i.
    """
    inner = part + (0,) * (len(whole) - len(part))
    fits = len(part) <= len(whole) and all(map(int.__le__, inner, whole))
    if not fits or sum(whole) != sum(part) + sum(content):
        return 0
    cells = [(r, c) for r in range(len(whole)) for c in range(whole[r] - 1, inner[r] - 1, -1)]
    return sum(1 for _ in _fillings(cells, {}, [0] * len(content), content))


def _fillings(
    cells: list[tuple[int, int]],
    filled: dict[tuple[int, int], int],
    used: list[int],
    content: Partition,
) -> Iterator[None]:
    if len(filled) == len(cells):
        yield None
        return
    r, c = cells[len(filled)]
    least = filled.get((r - 1, c), -1) + 1
    most = filled.get((r, c + 1), len(content) - 1)
    for i in range(least, most + 1):
        if used[i] < content[i] and (i == 0 or used[i] < used[i - 1]):
            used[i] += 1
            yield from _fillings(cells, {**filled, (r, c): i}, used, content)
            used[i] -= 1


def is_irreducible(chosen: Sequence[tuple[PrimaryComponent, int]]) -> bool:
    """Tell whether the subspaces are known to be one irreducible variety.

    So they are where there is one stratum with one component, and where every factor has all lines
    of a space (e = 1), or all hyperplanes that contain the image.
    """
    return all(
        exponent in (0, 1, part.multiplicity - 1, part.multiplicity)
        or sum(s.components for s in strata(part.block_lengths, exponent)) == 1
        for part, exponent in chosen
    )


def _number_of_partitions(size: int) -> int:
    ways = [1] + [0] * size
    for part in range(1, size + 1):
        for total in range(part, size + 1):
            ways[total] += ways[total - part]
    return ways[size]


def _weight(blocks: Partition) -> int:
    return sum(i * length for i, length in enumerate(blocks))
