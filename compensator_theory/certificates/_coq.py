"""Certificates as files of Coq, which its kernel checks against theorems of ``proofs/rocq``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

from sympy import QQ, ZZ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError
from sympy.polys.rings import PolyElement, PolyRing

from compensator_theory._printing import decimal, integer_of
from compensator_theory._wording import printable
from compensator_theory.certificates._records import Record, certificate_record
from compensator_theory.certificates._signs import (
    definite_factor,
    hurwitz_rows,
    schur_rows,
)
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import unlimited
from compensator_theory.polynomials._carrying import refusing

Terms: TypeAlias = list[tuple[int, tuple[int, ...]]]
Sum: TypeAlias = list[list[Any]]
"""Terms of [factor, names], as a record has them."""

_RESERVED = """
    as at cofix else end exists exists2 fix for forall fun if IF in let match mod Prop return Set
    SProp then Type using where with is of by rec Theorem Lemma Definition Proof Qed
    Field Real char0 root z values values_0 term nonzero nonzero_0 modulus certificate
    Entries Transpose Times Plus Minus Scale at_ integer agree char_poly
"""
_HEAD = """\
From mathcomp Require Import all_ssreflect all_algebra all_real_closed.
From Compensators.foundations Require Import PositiveDefinite.
From Compensators.theorems Require Import CertifiedEquations CertifiedSigns.
From Coq Require Import ZArith.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import GRing.Theory Num.Theory.
"""
_CHARACTERISTIC_0 = "[char Field]%R =i pred0"
_WIDTH = 100


@refusing
def to_coq(certificate: object) -> str:
    r"""Write the certificate of a result as a file of Coq, which proves what it claims.

    The theorems of the file are about these very numbers and symbols: equations between matrices
    and characteristic polynomials for all values of the symbols, signs for rational numbers. Each
    is an instance of a theorem of ``proofs/rocq`` (``CertifiedEquations``, ``CertifiedSigns``)
    whose hypothesis Coq's kernel evaluates; nothing is assumed.

    Parameters
    ----------
    certificate : PolePlacement, RiccatiSolution, ObserverForm, ... or dict
        A result that :func:`certificate_record` writes, or such a record.

    Returns
    -------
    str
        The file. Its head says in words what is proved and how it is compiled: ``coqc -w none -R
        CHECKOUT/proofs/rocq Compensators FILE.v``, with Coq 8.16 and MathComp 1.15.

    Raises
    ------
    InputError
        If the result has no certificate, or contains irrational numbers, except those of
        :class:`RiccatiSolution`; if a dict is no record; and if a claim of it is false where a
        witness (an inverse, a factor, Routh's array) is needed and does not exist.

    Examples
    --------
    >>> from compensator_theory import place_poles, to_coq
    >>> text = to_coq(place_poles("1/(s - a)", [-1], feedback=-1))
    >>> print(*(line for line in text.splitlines() if line.startswith("Theorem")), sep="\n")
    Theorem equation_1 (Field : fieldType) (s a : Field) (values := [:: s; a] : seq Field) :
    Theorem stable_p (Real : rcfType) (z : Real[i]) :
    """
    record = certificate if isinstance(certificate, dict) else certificate_record(certificate)
    try:
        with unlimited():
            return _CoqFile(record).text()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            "the dict is no record as certificate_record writes it; give a result, or its record"
        ) from error


@dataclass
class _Matrix:
    """Numerators over one denominator, with integers."""

    name: str
    rows: int
    columns: int
    entries: list[list[Terms]]
    over: Terms


@dataclass
class _Fractions:
    """A sum of products as CertifiedEquations.computed has it: a grid, and denominators."""

    grid: list[list[PolyElement]]
    below: list[PolyElement] = field(default_factory=list)


class _CoqFile:
    """The file of a record."""

    def __init__(self, record: Record) -> None:
        self.kind, self.statement = str(record["kind"]), str(record["statement"])
        self.claims = {
            name: list(record.get(name, ()))
            for name in ("equations", "spectra", "regular", "stable", "definite")
        }
        if not any(self.claims.values()):
            raise InputError("the record claims nothing, so that there is nothing to prove")
        self.symbols = [str(symbol) for symbol in record["symbols"]]
        self.idents = _identifiers(record["matrices"], frozenset())
        self.variables = _identifiers(
            self.symbols,
            frozenset(self.idents.values()) | {f"{i}_over" for i in self.idents.values()},
        )
        self.matrices = {
            name: self._matrix(name, data) for name, data in record["matrices"].items()
        }
        extension = record.get("extension")
        self.modulus = _integral([_terms(extension, len(self.symbols))])[0][0] if extension else []
        if self.modulus and any(self.claims[name] for name in self.claims if name != "equations"):
            raise InputError(
                "a spectrum or a sign of numbers in a field extension cannot be written for Coq; "
                "give rational data"
            )
        used = [0] * len(self.symbols)
        for matrix in self.matrices.values():
            for terms in [*(t for row in matrix.entries for t in row), matrix.over]:
                for _, exponents in terms:
                    for k, e in enumerate(exponents):
                        used[k] = max(used[k], e)
        self.used = [e > 0 for e in used]
        if self.modulus:
            self.used[-1] = True

    def _matrix(self, name: str, data: Record) -> _Matrix:
        rows, columns, size = int(data["rows"]), int(data["columns"]), len(self.symbols)
        entries = [_terms(p, size) for p in data["entries"]]
        over = _terms(data["over"], size)
        if len(entries) != rows * columns or not over:
            raise InputError(f"the matrix {name} of the record has wrong entries, or 0 below them")
        (*numerators, below), _ = _integral([*entries, over])
        grid = [numerators[i * columns : (i + 1) * columns] for i in range(rows)]
        return _Matrix(name, rows, columns, grid, below)

    # ---- the polynomials of Python, where a witness is computed

    @cached_property
    def ring(self) -> PolyRing:
        """The polynomials over the integers."""
        return PolyRing([f"x{k}" for k in range(len(self.symbols))], ZZ)

    def element(self, terms: Terms) -> PolyElement:
        """Return a polynomial of the ring."""
        size = len(self.symbols)
        return self.ring.from_dict({(*e, *(0,) * (size - len(e))): ZZ(c) for c, e in terms})

    def fractions(self, name: str) -> _Fractions:
        """Return a matrix, transposed where its name ends with '."""
        matrix = self.matrices[name.rstrip("'")]
        grid = [[self.element(terms) for terms in row] for row in matrix.entries]
        if name.endswith("'"):
            grid = [[row[j] for row in grid] for j in range(matrix.columns)]
        over = self.element(matrix.over)
        return _Fractions(grid, [] if over == self.ring.one else [over])

    def total(self, terms: Sum) -> _Fractions:
        """Return a sum of products, over the denominators that Coq finds."""
        parts = []
        for factor, names in terms:
            product = self.fractions(names[0])
            for name in names[1:]:
                other = self.fractions(name)
                columns = list(zip(*other.grid, strict=True))
                grid = [
                    [sum((a * b for a, b in zip(row, column, strict=True)), self.ring.zero)
                     for column in columns] for row in product.grid
                ]  # fmt: skip
                product = _Fractions(grid, product.below + other.below)
            product.grid = [[factor * e for e in row] for row in product.grid]
            parts.append(product)
        result = parts[0]
        for other in parts[1:]:
            only_b = list(other.below)
            only_a = []
            for p in result.below:
                if p in only_b:
                    only_b.remove(p)
                else:
                    only_a.append(p)
            lift_a, lift_b = (
                math.prod(only_b, start=self.ring.one),
                math.prod(only_a, start=self.ring.one),
            )
            grid = [
                [lift_a * x + lift_b * y for x, y in zip(row, row_b, strict=True)]
                for row, row_b in zip(result.grid, other.grid, strict=True)
            ]
            result = _Fractions(grid, result.below + only_b)
        return result

    # ---- the text

    def text(self) -> str:
        """Return the file."""
        theorems = list(self._theorems())
        names = [name for name, _, _ in theorems]
        lines = [self._comment([(name, words) for name, words, _ in theorems]), _HEAD]
        powers = _comment_text(", ".join(self.symbols))
        lines.append(
            f"(* A polynomial is its terms, each a coefficient and the exponents of {powers};\n"
            "   long numbers are hexadecimal. *)"
        )
        if self.modulus:
            lines.append(f"Definition modulus : polynomial := {_polynomial(self.modulus)}.")
        for name, matrix in self.matrices.items():
            ident = self.idents[name]
            lines.append(f"Definition {ident}_over : polynomial := {_polynomial(matrix.over)}.")
            rows = _list(_list(_polynomial(e) for e in row) for row in matrix.entries)
            shape = f"{matrix.rows} {matrix.columns}"
            lines.append(f"Definition {ident} : expression {shape} :=")
            lines.append(f"  Entries {shape} {rows} {ident}_over.")
        lines.append("")
        lines += [text for _, _, text in theorems]
        together = names[0] if len(names) == 1 else f"({', '.join(f'@{n}' for n in names)})"
        lines.append(f"Definition certificate := {together}.")
        lines.append("Print Assumptions certificate.  (* Closed under the global context *)")
        return "\n".join(lines) + "\n"

    def _comment(self, claims: list[tuple[str, str]]) -> str:
        head = [f"{self.kind[:1].upper()}{self.kind[1:]}: {self.statement}", ""]
        places = [symbol for symbol, used in zip(self.symbols, self.used, strict=True) if used]
        if places:
            head += [
                f"Proved below for all values of {', '.join(places)} in a field of",
                "characteristic 0 (rational, real or complex numbers), where the denominators that",
                "a theorem lists are not 0:",
            ]
        else:
            head += ["Proved below:"]
        if self.modulus:
            root = f"a root of {_readable(self.modulus, self.symbols)}"
            head[-1] = f"{head[-1][:-1]}, {self.symbols[-1]} {root}:"
        head += [""]
        head += [f"  {name}: {words}" for name, words in claims]
        head += ["", "where", ""]
        for name, matrix in self.matrices.items():
            head += [f"  {line}" for line in self._readable_matrix(name, matrix)]
        head += [
            "",
            "Compile, with Coq 8.16 and MathComp 1.15 (Debian 12: apt-get install coq",
            "libcoq-mathcomp libcoq-mathcomp-real-closed libcoq-mathcomp-algebra-tactics",
            "libcoq-mathcomp-zify), and a checkout of compensator-theory in CHECKOUT:",
            "",
            "  make -C CHECKOUT/proofs/rocq     (once)",
            "  coqc -w none -R CHECKOUT/proofs/rocq Compensators FILE.v",
            "",
            "It compiles only if every claim holds. Each rests on a theorem named certified_... of",
            "proofs/rocq/theorems (CertifiedEquations.v, CertifiedSigns.v), whose hypothesis is",
            "a boolean that Coq's kernel evaluates.",
        ]  # fmt: skip
        lines = (_comment_text(line) for part in head for line in part.split("\n"))
        text = "\n".join(f"   {line}".rstrip() for line in lines).strip()
        return f"(* {text} *)\n"

    def _readable_matrix(self, name: str, matrix: _Matrix) -> Iterator[str]:
        over = _readable(matrix.over, self.symbols)
        below = "" if over == "1" else f" / ({over})"
        if matrix.rows == matrix.columns == 1:
            top = _readable(matrix.entries[0][0], self.symbols)
            yield _shortened(f"{name} = {top}" if not below else f"{name} = ({top}){below}")
            return
        yield _shortened(f"{name}, {matrix.rows} x {matrix.columns}{below}:")
        for row in matrix.entries:
            yield _shortened("  [" + ", ".join(_readable(e, self.symbols) for e in row) + "]")

    # ---- the theorems

    def _theorems(self) -> Iterator[tuple[str, str, str]]:
        """Yield name, words and text of each."""
        for k, terms in enumerate(self.claims["equations"], start=1):
            yield self._equation(f"equation_{k}", terms)
        for claim in self.claims["spectra"]:
            yield self._spectrum(claim["is"], claim["of"])
        for name in self.claims["regular"]:
            yield self._regular(name)
        for name in self.claims["definite"]:
            yield self._definite(name)
        for claim in self.claims["stable"]:
            yield self._stable(claim["is"], claim["time"])

    def _equation(self, name: str, terms: Sum) -> tuple[str, str, str]:
        terms = _whole_factors(terms)
        sides = [[t for t in terms if t[0] > 0], [[-t[0], t[1]] for t in terms if t[0] < 0]]
        if not sides[0]:
            sides.reverse()
        left, right = sides
        expressions = [self._expression(left)]
        if right:
            expressions.append(self._expression(right))
            checker, theorem = "agree", "certified_equality"
            signed = left + [[-c, names] for c, names in right]
        else:
            checker, theorem, signed = "vanishes", "certified_equation", left
        quotients, scale = self._quotients(signed)
        divisors, names = self._denominators(terms), self._names(terms)
        arguments = f"{divisors} {'modulus' if self.modulus else '[::]'} ({scale})%Z {quotients}"
        check = f"{name}_check"
        root = "polynomial_at values modulus = 0%R" if self.modulus else ""
        statement = f"{self._sum(left)} = {self._sum(right) if right else '0'}"
        text = self._computed(check, f"{checker} {arguments}\n  {' '.join(expressions)}")
        text += self._over_fields(name, divisors, names, statement, root)
        hypotheses = (
            ["char0"] + (["nonzero"] if divisors != "[::]" else []) + (["root"] if root else [])
        )
        nonzero = "nonzero" if divisors != "[::]" else "isT"
        zero = "root" if root else "(big_nil _ _ _ _)"
        text += (
            f"Proof. by move=> {' '.join(hypotheses)}; exact: ({theorem} char0 "
            f"(given := {divisors}) {nonzero} {zero} {check}). Qed.\n"
        )
        words = f"{_words(left)} = {_words(right) if right else '0'}"
        return name, words, text

    def _spectrum(self, of: str, terms: Sum) -> tuple[str, str, str]:
        name, check = f"spectrum_{self.idents[of]}", f"spectrum_{self.idents[of]}_check"
        terms = _whole_factors(terms)
        matrix = self.matrices[of]
        if any(e[:1] > (0,) for _, e in matrix.over):
            raise InputError(f"the denominator of {of} contains {self.symbols[0]}")
        by_power: dict[int, Terms] = {}
        for c, e in matrix.entries[0][0]:
            by_power.setdefault(e[0] if e else 0, []).append((c, e[1:]))
        size = self.matrices[terms[0][1][0].rstrip("'")].rows
        coefficients = _list(_polynomial(by_power.get(k, [])) for k in range(size - 1, -1, -1))
        divisors = self._denominators([*terms, [1, [of]]])
        lead = _polynomial([(c, e[1:]) for c, e in matrix.over])
        text = self._computed(
            check,
            f"has_spectrum {divisors} {self._expression(terms)}\n"
            f"  {self.idents[of]} {lead} {coefficients}",
        )
        statement = f"(char_poly ({self._sum(terms)})).[{self._first}] = {self.idents[of]} 0 0"
        names = [n for n in self._names(terms) if n != of]
        bound = " ".join(self._bound)
        rest = "; ".join(["", *self._bound[1:]])
        text += (
            f"Theorem {name} (Field : fieldType) ({bound} : Field)\n"
            f"  (values_0 := [:: 0%R{rest}] : seq Field)\n"
            f"  (values := [:: {self._first}{rest}] : seq Field) :\n"
            f"  {_CHARACTERISTIC_0} ->\n"
        )
        moved = "char0"
        if divisors != "[::]":
            text += f"  nonzero_at values_0 {divisors} -> nonzero_at values {divisors} ->\n"
            moved += " nonzero_0 nonzero"
        lets = "".join(
            f"  let {self.idents[n]} := at_ values_0 {self.idents[n]} in\n" for n in names
        )
        lets += f"  let {self.idents[of]} := at_ values {self.idents[of]} in\n"
        text += f"{lets}  ({statement})%R.\n"
        premises = "nonzero_0 nonzero" if divisors != "[::]" else "isT isT"
        text += (
            f"Proof. by move=> {moved}; exact: (certified_spectrum char0 (given := {divisors}) "
            f"{premises} {check}). Qed.\n"
        )
        return name, f"det({self.symbols[0]} I - ({_words(terms)})) = {of}", text

    def _regular(self, name: str) -> tuple[str, str, str]:
        ident = self.idents[name]
        numerators = self.fractions(name).grid
        field_of = self.ring.to_domain()
        matrix = DomainMatrix(numerators, (len(numerators),) * 2, field_of) if numerators else None
        adjugate, determinant = (
            _inverse(matrix, name) if matrix is not None else ([], self.ring.one)
        )
        d = _from_element(determinant)
        is_number = all(not any(e) for _, e in d)
        divisors = self._denominators([[1, [name]]], [] if is_number else [f"{ident}_determinant"])
        text = f"Definition {ident}_determinant : polynomial := {_polynomial(d)}.\n"
        rows = _list(_list(_polynomial(_from_element(e)) for e in row) for row in adjugate)
        text += self._computed(
            f"regular_{ident}_check", f"is_regular {divisors} {rows}\n  {ident}_determinant {ident}"
        )
        text += self._over_fields(f"regular_{ident}", divisors, [name], f"{ident} \\in unitmx", "")
        nonzero = "nonzero" if divisors != "[::]" else "isT"
        moved = "char0 nonzero" if divisors != "[::]" else "char0"
        text += (
            f"Proof. by move=> {moved}; exact: (certified_regular char0 (given := {divisors}) "
            f"{nonzero} regular_{ident}_check). Qed.\n"
        )
        words = f"{name} is invertible"
        if not is_number:
            words += f" where {_readable(d, self.symbols)} is not 0"
        return f"regular_{ident}", words, text

    def _definite(self, name: str) -> tuple[str, str, str]:
        ident, matrix = self.idents[name], self.matrices[name]
        numbers = [[_number_of(e, name) for e in row] for row in matrix.entries]
        sign = 1 if _number_of(matrix.over, name) > 0 else -1
        if sign < 0:
            raise InputError(f"the denominator of {name} is negative")
        factor = definite_factor(numbers)
        if factor is None:
            raise InputError(f"the matrix {name} is not symmetric and positive definite")
        scale, weights, rows = factor
        factor_text = _list(_integers(row) for row in rows)
        text = self._computed(
            f"definite_{ident}_check",
            f"is_definite {ident} {_integer(scale)} {_integers(weights)}\n  {factor_text}",
        )
        text += (
            f"Theorem definite_{ident} (Real : realFieldType) :\n"
            f"  positive_definite (at_ ([::] : seq Real) {ident}).\n"
            f"Proof. exact: certified_definite definite_{ident}_check. Qed.\n"
        )
        return f"definite_{ident}", f"{name} is symmetric and positive definite", text

    def _stable(self, name: str, time: str) -> tuple[str, str, str]:
        ident, matrix = self.idents[name], self.matrices[name]
        _number_of(matrix.over, name)
        by_power = {}
        for c, e in matrix.entries[0][0]:
            if any(e[1:]):
                raise InputError(f"{name} has other symbols, so that its roots are not numbers")
            by_power[e[0] if e else 0] = c
        coefficients = [by_power.get(k, 0) for k in range(max(by_power, default=0) + 1)]
        if coefficients[-1] < 0:  # -p has the same roots
            coefficients = [-c for c in coefficients]
        discrete = time == "discrete"
        rows = (schur_rows if discrete else hurwitz_rows)(coefficients)
        if rows is None:
            raise InputError(f"{name} is not stable")
        check = f"stable_{ident}_check"
        row_text = _list(f"({_integer(g)}, {_integers(row)})" for g, row in rows)
        text = self._computed(
            f"stable_{ident}_coefficients", f"has_coefficients {ident} {_integers(coefficients)}"
        )
        text += self._computed(
            check,
            f"{'schur' if discrete else 'routh'}_rows {_integers(coefficients)}\n  {row_text}",
        )
        conclusion = "`|z| < 1" if discrete else "complex.Re z < 0"
        theorem = "certified_schur" if discrete else "certified_hurwitz"
        text += (
            f"Theorem stable_{ident} (Real : rcfType) (z : Real[i]) :\n"
            f"  at_ ([:: z] : seq [fieldType of Real[i]]) {ident} = 0%R -> ({conclusion})%R.\n"
            f"Proof. exact: ({theorem} stable_{ident}_coefficients {check}). Qed.\n"
        )
        where = "inside the unit circle" if discrete else "in the open left half-plane"
        return f"stable_{ident}", f"every complex root of {name} is {where}", text

    # ---- pieces

    @staticmethod
    def _computed(name: str, check: str) -> str:
        return f"Lemma {name} : {check} = true.\nProof. vm_cast_no_check (erefl true). Qed.\n"

    @cached_property
    def _bound(self) -> list[str]:
        return [self.variables[symbol] for symbol in self.symbols]

    @property
    def _first(self) -> str:
        return self._bound[0]

    def _over_fields(
        self, name: str, divisors: str, names: Sequence[str], statement: str, root: str
    ) -> str:
        """Return the statement of a theorem over fields of characteristic 0, up to its proof."""
        bound = [v for v, used in zip(self._bound, self.used, strict=True) if used]
        values = [v if used else "0%R" for v, used in zip(self._bound, self.used, strict=True)]
        quantified = f" ({' '.join(bound)} : Field)" if bound else ""
        vector = f"[:: {'; '.join(values)}]" if bound else "[::]"
        text = (
            f"Theorem {name} (Field : fieldType){quantified} (values := {vector} : seq Field) :\n"
        )
        text += f"  {_CHARACTERISTIC_0} ->\n"
        if divisors != "[::]":
            text += f"  nonzero_at values {divisors} ->\n"
        if root:
            text += f"  {root} ->\n"
        for n in dict.fromkeys(names):
            text += f"  let {self.idents[n]} := at_ values {self.idents[n]} in\n"
        return f"{text}  ({statement})%R.\n"

    def _names(self, terms: Sum) -> list[str]:
        return list(dict.fromkeys(n.rstrip("'") for _, names in terms for n in names))

    def _denominators(self, terms: Sum, more: Iterable[str] = ()) -> str:
        """List the denominators that are no numbers."""
        listed, unique = [], []
        for name in self._names(terms):
            over = self.matrices[name].over
            if any(any(e) for _, e in over) and over not in unique:
                unique.append(over)
                listed.append(f"{self.idents[name]}_over")
        return _list([*listed, *more])

    def _quotients(self, terms: Sum) -> tuple[str, int]:
        """Return the quotients by the modulus, and their common scale."""
        if not self.modulus:
            return "[::]", 1
        ring = self.ring.clone(domain=QQ)
        divisor = self.element(self.modulus).set_ring(ring)
        rows = []
        for row in self.total(terms).grid:
            parts = [entry.set_ring(ring).div(divisor) for entry in row]
            if any(remainder for _, remainder in parts):
                raise InputError("an equation of the record does not hold")
            rows.append([quotient for quotient, _ in parts])
        scale = math.lcm(*(int(c.denominator) for row in rows for q in row for c in q.values()))
        grid = _list(
            _list(_polynomial(_from_element((q * scale).set_ring(self.ring))) for q in row)
            for row in rows
        )
        return grid, scale

    def _expression(self, terms: Sum) -> str:
        """Write a sum of products for Coq."""
        result = ""
        for factor, names in terms:
            product = ""
            for name in names:
                ident = self.idents[name.rstrip("'")]
                one = f"(Transpose {ident})" if name.endswith("'") else ident
                product = f"(Times {product} {one})" if product else one
            size = abs(factor)
            if size != 1 or (factor < 0 and not result):
                product = f"(Scale {_integer(size if result else factor)} {product})"
            if not result:
                result = product
            else:
                result = f"({'Plus' if factor > 0 else 'Minus'} {result} {product})"
        return result

    def _sum(self, terms: Sum) -> str:
        """Write a sum of products as MathComp has it."""
        result = ""
        for factor, names in terms:
            product = " *m ".join(
                self.idents[n.rstrip("'")] + ("^T" if n.endswith("'") else "") for n in names
            )
            size = abs(factor)
            if size != 1 or (factor < 0 and not result):
                product = f"integer Field {_integer(size if result else factor)} *: ({product})"
            if not result:
                result = product
            else:
                result += f" {'+' if factor > 0 else '-'} {product}"
        return result


def _identifiers(names: Iterable[str], reserved: frozenset[str]) -> dict[str, str]:
    """Return different identifiers of Coq for names."""
    result: dict[str, str] = {}
    used = {*reserved, *_RESERVED.split()}
    for name in names:
        ident = re.sub(r"\W", "_", name, flags=re.ASCII).strip("_") or "x"
        ident = ident if ident[0].isalpha() else f"x{ident}"
        while ident in used or f"{ident}_over" in used:
            ident += "_"
        used.add(ident)
        result[name] = ident
    return result


def _fraction(text: str) -> Fraction:
    """Read a fraction of whole numbers of any length."""
    top, _, bottom = text.partition("/")
    return Fraction(integer_of(top), integer_of(bottom or "1"))


def _terms(read: Any, size: int) -> list[tuple[Fraction, tuple[int, ...]]]:
    """Read a polynomial of a record."""
    result = []
    for coefficient, exponents in read:
        powers = tuple(int(e) for e in exponents)
        if len(powers) != size or min(powers, default=0) < 0:
            raise ValueError("the exponents are not those of the symbols")
        while powers and not powers[-1]:
            powers = powers[:-1]
        result.append((_fraction(coefficient), powers))
    return result


def _integral(
    polynomials: list[list[tuple[Fraction, tuple[int, ...]]]],
) -> tuple[list[Terms], int]:
    """Multiply polynomials with one number that makes their coefficients whole."""
    scale = math.lcm(*(c.denominator for terms in polynomials for c, _ in terms))
    return [[(int(c * scale), e) for c, e in terms] for terms in polynomials], scale


def _whole_factors(terms: Sum) -> Sum:
    """Multiply an equation with one number that makes its factors whole."""
    factors = [_fraction(str(c)) for c, _ in terms]
    scale = math.lcm(*(c.denominator for c in factors))
    return [[int(c * scale), names] for c, (_, names) in zip(factors, terms, strict=True)]


def _inverse(matrix: DomainMatrix, name: str) -> tuple[list[list[PolyElement]], PolyElement]:
    """Return X and d with M X = d I."""
    try:
        numerators, denominator = matrix.inv_den()
    except DMNonInvertibleMatrixError as error:
        raise InputError(f"the matrix {name} is singular") from error
    return numerators.to_list(), denominator


def _from_element(element: PolyElement) -> Terms:
    terms = []
    for exponents, c in element.terms():
        powers = tuple(exponents)
        while powers and not powers[-1]:
            powers = powers[:-1]
        terms.append((int(c), powers))
    return [t for t in terms if t[0]]


def _number_of(terms: Terms, name: str) -> int:
    if any(any(e) for _, e in terms):
        raise InputError(f"{name} is no matrix of numbers, so that it has no sign")
    return sum(c for c, _ in terms)


def _literal(c: int) -> str:
    """Write a whole number; long ones in hexadecimal, which Coq reads 20 times faster."""
    size = abs(c)
    digits = decimal(size) if size.bit_length() <= 128 else f"0x{size:x}"
    return f"-{digits}" if c < 0 else digits


def _integer(c: int) -> str:
    return f"({_literal(c)})%Z" if c < 0 else f"{_literal(c)}%Z"


def _integers(row: Iterable[int]) -> str:
    return f"[:: {'; '.join(map(_literal, row))}]%Z" if row else "[::]"


def _list(items: Iterable[str]) -> str:
    text = "; ".join(items)
    return f"[:: {text}]" if text else "[::]"


def _polynomial(terms: Terms) -> str:
    numbers = (f"({_literal(c)})" if c < 0 else _literal(c) for c, _ in terms)
    return _list(
        f"term {number} {_list(map(str, e))}" for number, (_, e) in zip(numbers, terms, strict=True)
    )


def _readable(terms: Terms, symbols: Sequence[str]) -> str:
    """Write a polynomial for a reader."""
    text = ""
    for c, exponents in terms:
        powers = [
            symbol if e == 1 else f"{symbol}^{e}"
            for symbol, e in zip(symbols, exponents, strict=False)
            if e
        ]
        size = abs(c)
        product = "*".join([*([decimal(size)] if size != 1 or not powers else []), *powers])
        sign = "-" if c < 0 else "+"
        text += f" {sign} {product}" if text else f"{'-' if c < 0 else ''}{product}"
    return text or "0"


def _words(terms: Sum) -> str:
    """Write a sum of products for a reader."""
    text = ""
    for factor, names in terms:
        size = abs(factor)
        product = " ".join([*([decimal(size)] if size != 1 else []), *names])
        text += f" {'-' if factor < 0 else '+'} {product}" if text else (
            f"{'-' if factor < 0 else ''}{product}"
        )  # fmt: skip
    return text


def _shortened(line: str) -> str:
    return line if len(line) <= _WIDTH else f"{line[: _WIDTH - 30]} ... ({len(line)} characters)"


def _comment_text(line: str) -> str:
    """Keep a comment from ending early, or from opening a string or another comment."""
    return printable(line).replace("(*", "( *").replace("*)", "* )").replace('"', "'")
