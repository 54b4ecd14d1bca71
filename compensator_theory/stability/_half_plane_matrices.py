"""A transfer matrix as a polynomial matrix over a polynomial in s, whatever its time is."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import QQ, Poly, Symbol

from compensator_theory.errors import ImproperError, InputError
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._poly import canonical, is_rational, way_to_rational
from compensator_theory.polynomials._variables import is_discrete
from compensator_theory.roots._counts import count_roots, half_plane_image
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix


@dataclass(frozen=True)
class HalfPlaneMatrix:
    """N/D with the imaginary axis as the boundary; of a discrete one z = (1 + s)/(1 - s).

    Attributes
    ----------
    numerators : tuple of tuples of sympy.Poly
    denominator : sympy.Poly
        Without factors common to all entries.
    poles : RootCount
        Of the least common denominator; what a degree of D below that of N shows, a pole at
        infinity, is a pole on the boundary (z = -1).
    is_discrete : bool
    """

    numerators: tuple[tuple[Poly, ...], ...]
    denominator: Poly
    poles: RootCount
    is_discrete: bool

    @property
    def variable(self) -> Symbol:
        """Variable of all polynomials."""
        return self.denominator.gen

    @property
    def is_stable(self) -> bool:
        """Whether all poles are left of the axis."""
        return self.poles.stable == self.poles.total


def half_plane_matrix(
    G: TransferMatrixLike, subject: str, variable: str | Symbol | None = None
) -> HalfPlaneMatrix:
    """Read a rational proper transfer matrix; factors common to all entries are left out."""
    source = transfer_matrix(G, variable)
    s = source.variable
    discrete = is_discrete(s, subject)
    entries = [entry for row in source.numerators for entry in row]
    if not all(map(is_rational, [*entries, source.denominator])):
        raise InputError(
            f"{subject} needs rational coefficients; "
            f"{way_to_rational(*entries, source.denominator, sources=(G,))}"
        )
    common = source.denominator
    for entry in entries:
        common = common.gcd(entry)
    bottom = canonical(source.denominator.exquo(common))
    tops = [[canonical(entry.exquo(common)) for entry in row] for row in source.numerators]
    size = int(bottom.degree())
    if any(not e.is_zero and e.degree() > size for row in tops for e in row):
        raise ImproperError(f"the transfer matrix {source} is improper, and {subject} infinite")
    ask("degree", size * min(source.shape) * 4, subject)
    if discrete:
        bottom = half_plane_image(bottom, size)
        tops = [[half_plane_image(entry, size) for entry in row] for row in tops]
    count = count_roots(bottom.replace(s, Symbol("s")))
    missing = size - int(bottom.degree())
    poles = RootCount(count.stable, count.boundary + missing, count.unstable)
    return HalfPlaneMatrix(tuple(map(tuple, tops)), bottom, poles, discrete)


def gram_of(G: HalfPlaneMatrix) -> list[list[Poly]]:
    """Return N(-s)' N(s), or N(s) N(-s)' where that is the smaller one."""
    N = G.numerators
    columns = [list(c) for c in zip(*N, strict=True)] if len(N[0]) <= len(N) else list(map(list, N))
    mirror = Poly(-G.variable, G.variable, domain=QQ)
    mirrored = [[entry.compose(mirror) for entry in column] for column in columns]
    zero = mirror.zero
    left, right = (mirrored, columns) if len(N[0]) <= len(N) else (columns, mirrored)
    return [[sum((x * y for x, y in zip(a, b, strict=True)), zero) for b in right] for a in left]
