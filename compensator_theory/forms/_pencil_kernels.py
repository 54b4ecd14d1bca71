"""Polynomial null vectors of a pencil of whole numbers, from their residues modulo primes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import flint

from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._residues import large_prime, pivots, primes, whole
from compensator_theory.polynomials._budget import ask, decimal_digits

Relation: TypeAlias = dict[tuple[int, int], flint.nmod]
"""A column of a Krylov matrix by others: the factor of each F^k g_j, for pairs (j, k)."""
NullVectors: TypeAlias = list[list[list[int]]]
"""The coefficients of polynomial vectors by ascending powers, each a list of numbers."""
MEASURE = "a minimal basis with a left inverse, three digits as an entry,"
"""The subject of a budget error."""


class Pencil:
    r"""A pencil :math:`sE - A = R + (s - c)E` of whole numbers, R = cE - A of the normal rank.

    With t = 1/(s - c), the rows and columns of a nonsingular minor of R bring t R + E to diag(t I -
    F, 0) with the columns -G beside it, so that the null vectors are those of [t I - F, -G]. The
    right minimal indices are the controllability indices of (F, G): the least number of columns
    F^k g that one column depends on (Kailath, Linear Systems, 6.4).

    Attributes
    ----------
    R, E : flint.fmpz_mat
        p x m.
    point : int
        c.
    rank : int
        Of R, and the normal rank.
    """

    def __init__(self, A: flint.fmpz_mat, E: flint.fmpz_mat) -> None:
        self.E, self.shape = E, (E.nrows(), E.ncols())
        bits = max(int(x).bit_length() for x in [*A.entries(), *E.entries()])
        ask("digits", decimal_digits(bits), "the pencil over one denominator")
        prime = large_prime()
        size = min(self.shape)
        # A rank modulo a prime is never above the true one, and all but `size` points have that.
        probes = (3**40 + 7**k for k in range(3))
        self.rank = max(flint.nmod_mat(E * x - A, prime).rank() for x in probes)
        for k in range(size + 1):
            self.point = (k + 1) // 2 * (-1) ** k
            self.R = E * self.point - A
            if flint.nmod_mat(self.R, prime).rank() >= self.rank:
                break
        residues = flint.nmod_mat(self.R, prime)
        self.rows, self.columns = pivots(residues.transpose()), pivots(residues)
        self.rank = len(self.rows)

    @property
    def T(self) -> Pencil:
        """The transposed pencil, about the same point."""
        other = object.__new__(Pencil)
        other.E, other.R = self.E.transpose(), self.R.transpose()
        other.shape, other.point, other.rank = self.shape[::-1], self.point, self.rank
        other.rows, other.columns = self.columns, self.rows
        return other

    def null_vectors(self) -> NullVectors:
        """Return a minimal basis of {x : (sE - A) x = 0}, each by ascending powers of s."""
        if self.rank == self.shape[1]:
            return []
        modulus, structure, values, attempts = 1, None, [], 0
        for count, prime in enumerate(primes(), 1):
            reduced = self._residues(prime)
            if reduced is None:
                continue
            shape, residues = reduced
            if shape != structure:  # one of the two primes divides a minor that matters
                if structure is not None and sum(shape) < sum(structure):
                    continue
                modulus, structure, values, attempts = 1, shape, [0] * len(residues), 0
            inverse = pow(modulus, -1, prime)
            values = [
                v + modulus * ((x - v) * inverse % prime)
                for v, x in zip(values, residues, strict=True)
            ]
            modulus *= prime
            if count < attempts + 1 + attempts // 3:
                continue
            attempts = count
            vectors = self._reconstructed(values, modulus, structure)
            if vectors is not None and self._are_null(vectors):
                order = sorted(range(len(vectors)), key=lambda j: len(vectors[j]))
                return [self._about_zero(vectors[j]) for j in order]
            # Then numbers with more than half as many digits are in it, and a left inverse solves
            # a system of its coefficients.
            size, digits = len(values) // self.shape[1], decimal_digits(modulus.bit_length()) // 2
            ask("digits", digits, "a minimal basis of whole numbers")
            ask("entries", size**2 * (digits // 3), MEASURE)
        raise NoSolutionError("no null vectors of this pencil; please report it")

    def _residues(self, prime: int) -> tuple[list[int], list[int]] | None:
        """Return the indices, and the coefficients of all vectors in one list, modulo a prime."""
        m = self.shape[1]
        r, free = self.rank, [j for j in range(m) if j not in set(self.columns)]
        if not r:
            return [0] * m, [int(i == j) for j in range(m) for i in range(m)]
        R, E = self.R.tolist(), self.E.tolist()
        parts = [
            flint.nmod_mat([[int(grid[i][j]) % prime for j in chosen] for i in self.rows], prime)
            for grid, chosen in ((R, self.columns), (R, free), (E, self.columns), (E, free))
        ]
        try:
            X, F, H = (parts[0].solve(part) for part in parts[1:])
        except ZeroDivisionError:
            return None
        F, G = -F, F * X - H
        indices, relations = _krylov(F, G)
        places = {j: k for k, j in enumerate([*self.columns, *free])}
        result = []
        for index, coefficients in zip(indices, _states(F, G, X, indices, relations), strict=True):
            for column in coefficients[: index + 1]:
                result += [column[places[j]] for j in range(m)]
        return indices, result

    def _reconstructed(
        self, values: Sequence[int], modulus: int, indices: Sequence[int]
    ) -> NullVectors | None:
        """Return the vectors of whole numbers that have these residues, one denominator each."""
        m, start, result = self.shape[1], 0, []
        for index in indices:
            length = m * (index + 1)
            entries = whole(values[start : start + length], modulus)
            if entries is None:
                return None
            result.append([entries[k * m : (k + 1) * m] for k in range(index + 1)])
            start += length
        return result

    def _are_null(self, vectors: NullVectors) -> bool:
        """Whether (t R + E) x(t) is zero, in integer arithmetic."""
        zero = [0] * self.shape[1]
        for vector in vectors:
            by_R, by_E = _columns([zero, *vector]), _columns([*vector, zero])
            if any(x for row in (self.R * by_R + self.E * by_E).tolist() for x in row):
                return False
        return True

    def _about_zero(self, vector: list[list[int]]) -> list[list[int]]:
        """Return (s - c)^k x(1/(s - c)) by powers of s."""
        about_point = vector[::-1]
        if not self.point:
            return about_point
        shift = flint.fmpz_poly([-self.point, 1])
        entries = [flint.fmpz_poly(list(e))(shift) for e in zip(*about_point, strict=True)]
        return [[int(entry[k]) for entry in entries] for k in range(len(vector))]


def _krylov(F: flint.nmod_mat, G: flint.nmod_mat) -> tuple[list[int], list[Relation]]:
    """Return for each column g_j the least k with F^k g_j dependent, and the relation.

    Columns come in the order G, F G, F^2 G, ..., and more of them at a time.
    """
    prime = G.modulus()
    names: list[tuple[int, int]] = []
    basis: list[list[flint.nmod]] = []
    relations: dict[int, tuple[int, Relation]] = {}
    inputs, block, power, more = list(range(G.ncols())), G, 0, 1
    while inputs:
        names, columns = list(names), list(basis)
        for k in range(power, power + more):
            names += [(j, k) for j in inputs]
            columns += block.transpose().tolist()
            block = F * block
        reduced, rank = flint.nmod_mat(columns, prime).transpose().rref()
        rows = reduced.tolist()[:rank]
        leading = [next(k for k, e in enumerate(row) if int(e)) for row in rows]
        independent = set(leading)
        for column, (j, k) in enumerate(names):
            if column not in independent and j not in relations:
                factors = {names[c]: row[column] for c, row in zip(leading, rows, strict=True)}
                relations[j] = k, factors
        basis = [columns[k] for k in leading]
        ahead = dict(zip(inputs, block.transpose().tolist(), strict=True))
        names, power, more = [names[k] for k in leading], power + more, 2 * more
        inputs = [j for j in inputs if j not in relations]
        if inputs:
            block = flint.nmod_mat([ahead[j] for j in inputs], prime).transpose()
    residues = [relations[j] for j in range(G.ncols())]
    return [index for index, _ in residues], [relation for _, relation in residues]


def _states(
    F: flint.nmod_mat,
    G: flint.nmod_mat,
    X: flint.nmod_mat,
    indices: Sequence[int],
    relations: Sequence[Relation],
) -> list[list[list[int]]]:
    """Return (z - X d, d) for the null vectors (z, d) of [t I - F, -G], by ascending powers of t.

    d_j is t^k e_j less the relation of F^k g_j; and z_(l-1) = F z_l + G d_l, from the top down.
    """
    size, prime = len(indices), G.modulus()
    weights = [[[0] * size for _ in range(size)] for _ in range(max(indices) + 1)]
    for j, (index, relation) in enumerate(zip(indices, relations, strict=True)):
        weights[index][j][j] = 1
        for (i, power), factor in relation.items():
            weights[power][i][j] = -int(factor) % prime
    states: list[list[list[int]]] = [[] for _ in indices]
    z = flint.nmod_mat(F.nrows(), size, prime)
    for power in range(max(indices), -1, -1):
        d = flint.nmod_mat(weights[power], prime)
        whole_state = [*(z - X * d).transpose().tolist()], d.transpose().tolist()
        for j, (top, below) in enumerate(zip(*whole_state, strict=True)):
            states[j].append([int(e) for e in [*top, *below]])
        z = F * z + G * d
    return [columns[::-1] for columns in states]


def _columns(vectors: Sequence[Sequence[int]]) -> flint.fmpz_mat:
    return flint.fmpz_mat([list(row) for row in zip(*vectors, strict=True)])
