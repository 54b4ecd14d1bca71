"""Check exported certificates with the standard library alone.

    python proofs/recheck.py FILE...

The second harness imports nothing of what it judges, no SymPy and no FLINT. A certificate holds if
its equations vanish, identically in the symbols. `certificate_record` writes the files: one record
or a list of them, in JSON.

- ``symbols``: names, in the order of the exponents. ``extension``: the minimal polynomial of the
  last symbol, or null.
- ``matrices``: by name ``rows``, ``columns``, ``entries`` by rows, and ``over``, their denominator.
  A polynomial is a list of [coefficient, exponents].
- ``equations``: sums of [coefficient, names] that vanish; a name with ' is transposed.
- ``spectra``: ``of``, such a sum; ``is``, the name of its polynomial in the first symbol.
- ``regular``, ``definite``: names of matrices with a determinant, of positive definite ones of
  numbers. ``stable``: names of polynomials in the first symbol, with ``time``.
"""

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from typing import Any

Poly = dict[tuple[int, ...], Fraction]
Grid = list[list[Poly]]
MOST = 1000  # of an exponent


class RefusedError(Exception):
    """The record is no certificate."""


def polynomial(terms: Any, size: int) -> Poly:
    """Read a polynomial."""
    result: Poly = {}
    for coefficient, exponents in terms:
        if len(exponents) != size or not all(type(e) is int and 0 <= e <= MOST for e in exponents):
            raise RefusedError(f"{exponents} are no exponents of {size} symbols, at most {MOST}")
        if not re.fullmatch(r"-?[0-9]+(/[0-9]+)?", coefficient):  # 1e999999999 would fill memory
            raise RefusedError("a coefficient is no fraction of integers")
        result = plus(result, {tuple(exponents): Fraction(coefficient)})
    return result


def plus(p: Poly, q: Poly, factor: Fraction | int = 1) -> Poly:
    """Return p + factor q."""
    result = dict(p)
    for e, c in q.items():
        total = result.get(e, Fraction(0)) + factor * c
        if total:
            result[e] = total
        else:
            result.pop(e, None)
    return result


def times(p: Poly, q: Poly) -> Poly:
    """Return the product."""
    result: Poly = {}
    for e, c in p.items():
        for f, d in q.items():
            key = tuple(map(int.__add__, e, f))
            result[key] = result.get(key, Fraction(0)) + c * d
    return {e: c for e, c in result.items() if c}


class Record:
    """One record, read."""

    def __init__(self, record: dict[str, Any]) -> None:
        """Read the symbols and the matrices."""
        self.symbols = record["symbols"]
        self.size = len(self.symbols)
        self.one = {(0,) * self.size: Fraction(1)}
        self.data = record
        extension = record.get("extension")
        self.modulus = polynomial(extension, self.size) if extension else None
        self.matrices = {name: self.matrix(m) for name, m in record["matrices"].items()}

    def matrix(self, m: dict[str, Any]) -> tuple[int, int, Grid, Poly]:
        """Read a matrix: its shape, its rows, and the polynomial below them."""
        entries = [polynomial(p, self.size) for p in m["entries"]]
        rows, columns = m["rows"], m["columns"]
        below = polynomial(m["over"], self.size)
        if len(entries) != rows * columns or not below:
            raise RefusedError("a matrix has not as many entries as it says, or 0 below them")
        grid = [entries[i * columns : (i + 1) * columns] for i in range(rows)]
        return rows, columns, grid, below

    def named(self, name: str) -> tuple[int, int, Grid, Poly]:
        """Return a matrix, transposed where its name ends with '."""
        rows, columns, grid, below = matrix = self.matrices[name.rstrip("'")]
        if not name.endswith("'"):
            return matrix
        return columns, rows, [list(column) for column in zip(*grid, strict=True)] or [[]], below

    def product(self, names: list[str]) -> tuple[int, int, Grid, list[Poly]]:
        """Multiply matrices; their denominators are collected."""
        rows, columns, grid, below = self.named(names[0])
        under = [below]
        for name in names[1:]:
            inner, others, right, below = self.named(name)
            if inner != columns:
                raise RefusedError(f"{names} cannot be multiplied")
            grid = [
                [self.dot(row, [right[k][j] for k in range(inner)]) for j in range(others)]
                for row in grid
            ]
            columns = others
            under.append(below)
        return rows, columns, grid, under

    def dot(self, left: Sequence[Poly], right: Sequence[Poly]) -> Poly:
        """Return the sum of products."""
        total: Poly = {}
        for p, q in zip(left, right, strict=True):
            if p and q:
                total = plus(total, times(p, q))
        return self.reduced(total)

    def reduced(self, p: Poly) -> Poly:
        """Reduce modulo the minimal polynomial of the last symbol."""
        if self.modulus is None:
            return p
        degree = max(e[-1] for e in self.modulus)
        leading = (0,) * (self.size - 1) + (degree,)
        if self.modulus.get(leading) is None or any(sum(e[:-1]) for e in self.modulus):
            raise RefusedError("the extension is no polynomial with numbers in the last symbol")
        tail = {e: -c / self.modulus[leading] for e, c in self.modulus.items() if e != leading}
        while p and (most := max(e[-1] for e in p)) >= degree:
            high = {e: c for e, c in p.items() if e[-1] == most}
            p = {e: c for e, c in p.items() if e[-1] < most}
            shifted = {(*e[:-1], e[-1] - degree): c for e, c in high.items()}
            p = plus(p, times(shifted, tail))
        return p

    def total(self, terms: Any) -> tuple[Grid, Poly]:
        """Return a sum of products over one denominator."""
        parts = [(Fraction(c), *self.product(names)) for c, names in terms]
        shapes = {(rows, columns) for _, rows, columns, _, _ in parts}
        if len(shapes) != 1:
            raise RefusedError(f"the shapes {shapes} do not add")
        keys = [Counter(tuple(sorted(d.items())) for d in under) for *_, under in parts]
        common: Counter[Any] = Counter()
        for key in keys:
            common |= key
        ((rows, columns),) = shapes
        result: Grid = [[{} for _ in range(columns)] for _ in range(rows)]
        for (c, _, _, grid, _), key in zip(parts, keys, strict=True):
            factor = reduce(times, (dict(below) for below in (common - key).elements()), self.one)
            for i in range(rows):
                for j in range(columns):
                    if grid[i][j]:
                        result[i][j] = plus(result[i][j], times(grid[i][j], factor), c)
        below = reduce(times, (dict(factor) for factor in common.elements()), self.one)
        return [[self.reduced(p) for p in row] for row in result], below

    def characteristic(self, grid: Grid) -> list[Poly]:
        """Return c_0, ..., c_n of det(x I - M), by Faddeev and Leverrier."""
        n = len(grid)
        coefficients = [self.one]
        matrix: Grid = [[{} for _ in range(n)] for _ in range(n)]
        for k in range(1, n + 1):
            for i in range(n):
                matrix[i][i] = plus(matrix[i][i], coefficients[-1])
            matrix = [
                [self.dot(row, [matrix[t][j] for t in range(n)]) for j in range(n)] for row in grid
            ]
            trace: Poly = {}
            for i in range(n):
                trace = plus(trace, matrix[i][i])
            coefficients.append({e: c * Fraction(-1, k) for e, c in trace.items()})
        return coefficients

    def spectrum_holds(self, claim: dict[str, Any]) -> bool:
        """Compare det(s I - M/d) d^n with the polynomial, which is monic in the first symbol."""
        grid, below = self.total(claim["of"])
        _, _, [[p]], under = self.named(claim["is"])
        n = len(grid)
        s = {(1, *(0,) * (self.size - 1)): Fraction(1)}
        left: Poly = {}
        power, below_to = self.one, [reduce(times, [below] * k, self.one) for k in range(n + 1)]
        coefficients = self.characteristic(grid)
        for k in range(n + 1):  # s^k c_(n-k) d^k
            left = plus(left, times(times(power, coefficients[n - k]), below_to[k]))
            power = times(power, s)
        difference = plus(times(left, under), times(p, below_to[n]), -1)
        return not self.reduced(difference)

    def coefficients(self, name: str) -> list[Fraction]:
        """Return the descending rational coefficients of a polynomial in the first symbol alone."""
        _, _, [[p]], under = self.named(name)
        if any(sum(e[1:]) for e in [*p, *under]) or any(e[0] for e in under):
            raise RefusedError(f"{name} has other symbols, or a denominator")
        degree = max((e[0] for e in p), default=0)
        by_power = {e[0]: c for e, c in p.items()}
        return [by_power.get(k, Fraction(0)) for k in range(degree, -1, -1)]

    def numbers(self, name: str) -> list[list[Fraction]]:
        """Return a matrix of rational numbers."""
        _, _, grid, below = self.named(name)
        constant = (0,) * self.size
        if any(e != constant for row in grid for p in row for e in p) or set(below) != {constant}:
            raise RefusedError(f"{name} is no matrix of numbers")
        return [[p.get(constant, Fraction(0)) / below[constant] for p in row] for row in grid]

    def failures(self) -> Iterator[str]:
        """List the claims that do not hold."""
        for k, terms in enumerate(self.data.get("equations", ())):
            if any(p for row in self.total(terms)[0] for p in row):
                yield f"equation {k + 1} of {self.data['kind']}"
        for claim in self.data.get("spectra", ()):
            if not self.spectrum_holds(claim):
                yield f"the spectrum {claim['is']}"
        for name in self.data.get("regular", ()):
            rows, columns, grid, _ = self.named(name)
            if rows != columns or not self.characteristic(grid)[-1]:
                yield f"{name} is singular"
        for claim in self.data.get("stable", ()):
            if not is_stable(self.coefficients(claim["is"]), claim["time"]):
                yield f"{claim['is']} is not stable"
        for name in self.data.get("definite", ()):
            if not is_definite(self.numbers(name)):
                yield f"{name} is not positive definite"


def is_stable(row: list[Fraction], time: str) -> bool:
    """Decide by Routh's array, or by the numbers of Schur and Cohn, which never divide by zero."""
    if time == "discrete":
        while len(row) > 1:
            k = row[-1] / row[0]
            if abs(k) >= 1:
                return False
            row = [a - k * b for a, b in zip(row[:-1], row[:0:-1], strict=True)]
        return bool(row and row[0])
    above, row = row[0::2], row[1::2]
    while row:
        if above[0] * row[0] <= 0:
            return False
        ratio = above[0] / row[0]
        below = [a - ratio * b for a, b in zip(above[1:], [*row[1:], Fraction(0)], strict=False)]
        above, row = row, below
    return bool(above and above[0])


def is_definite(matrix: list[list[Fraction]]) -> bool:
    """Decide by elimination: every pivot of a symmetric matrix is positive."""
    n = len(matrix)
    if any(matrix[i][j] != matrix[j][i] for i in range(n) for j in range(i)):
        return False
    rows = [list(row) for row in matrix]
    for k in range(n):
        if rows[k][k] <= 0:
            return False
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [x - factor * y for x, y in zip(rows[i], rows[k], strict=True)]
    return True


CLAIMS = ("equations", "spectra", "regular", "stable", "definite")


def failures(record: dict[str, Any]) -> list[str]:
    """List what does not hold of a record, or why it is refused."""
    try:
        if not any(record.get(claim) for claim in CLAIMS):
            raise RefusedError("it claims nothing")
        return list(Record(record).failures())
    except (ArithmeticError, AttributeError, LookupError, RefusedError, TypeError, ValueError) as e:
        return [f"refused: {e}"]


def main(paths: list[str]) -> int:
    """Check files, print what fails, and return 1 if anything does."""
    sys.set_int_max_str_digits(0)  # certificates of adapting loops have long numbers
    checked, failed = Counter[str](), 0
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                read = json.load(file)
        except (OSError, ValueError, RecursionError) as error:
            read = {"kind": "unreadable file", "matrices": str(error)}
        for record in read if isinstance(read, list) else [read]:
            record = record if isinstance(record, dict) else {}  # noqa: PLW2901
            checked[str(record.get("kind", "without a kind"))] += 1
            for words in failures(record):
                failed += 1
                print(f"{path}: FAILS: {words}")
    print(", ".join(f"{count} {kind}" for kind, count in sorted(checked.items())) or "nothing")
    print("every certificate holds" if not failed else f"{failed} claims fail")
    return int(bool(failed) or not checked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
