"""Exponentials of matrices, exact: exponentials of the eigenvalues stay symbols."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd, lcm

import sympy
from sympy import QQ, Expr, ImmutableMatrix, Poly, Rational, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError
from compensator_theory.matrices.certificates import Certificate, proven
from compensator_theory.polynomials.budget import ask, quoted

IDENTITY = "dE/dt = M E and E = I at t = 0, for E = exp(M t)"


@dataclass(frozen=True)
class MatrixExponential:
    """The exponential of M t.

    Attributes
    ----------
    value : sympy.ImmutableMatrix
        With t and the symbols of `rates` in its entries.
    rates : tuple of (Symbol, Expr)
        Each symbol x stands for exp(rate t).
    certificate : Certificate
        The differential equation that it solves, and the initial value.
    """

    value: ImmutableMatrix
    rates: tuple[tuple[Symbol, Expr], ...]
    certificate: Certificate


def matrix_exponential(
    matrix: ImmutableMatrix, annihilator: Poly, t: Symbol, used: set[str]
) -> MatrixExponential:
    r"""Return the polynomial in a matrix that interpolates e^(st) on its spectrum.

    .. math:: e^{Mt} = r(M), \qquad r^{(k)}(\lambda) = t^k e^{\lambda t} \quad
              (k < \text{multiplicity of } \lambda)

    Parameters
    ----------
    matrix : sympy.ImmutableMatrix
        M, square.
    annihilator : sympy.Poly
        A polynomial that is zero at M, with rational or symbolic roots.
    t : Symbol
        The time.
    used : set of str
        Names that no new symbol may have; they are added.

    Raises
    ------
    InputError
        If a root is neither rational nor a sum of monomials in symbols.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from sympy.abc import h
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.matrices.exponentials import matrix_exponential
    >>> M = ImmutableMatrix([[-1, 1], [0, 0]])
    >>> found = matrix_exponential(M, polynomial("s*(s + 1)"), h, {"h"})
    >>> found.value, found.rates
    (Matrix([
    [x, 1 - x],
    [0,     1]]), ((x, -1),))
    """
    poles = _poles(annihilator)
    bases = _bases(list(poles), used)
    own_symbols = sorted(matrix.free_symbols | annihilator.free_symbols_in_domain, key=str)
    field = QQ.frac_field(*dict.fromkeys([t, *(x for x, _, _ in bases), *own_symbols]))
    own = DomainMatrix.from_Matrix(matrix).to_field().to_dense()
    interpolation = _interpolation(poles, bases, t, field, annihilator.gen)
    value = _value_at_matrix(interpolation, own, field)
    certificate = _certificate(value, own, bases, t, field)
    return MatrixExponential(
        ImmutableMatrix([[field.to_sympy(entry) for entry in row] for row in value]),
        tuple((x, rate) for x, rate, _ in bases),
        certificate,
    )


Base = tuple[Symbol, Expr, Expr]
"""A symbol x = exp(rate h), its rate, and the monomial that the rate is a multiple of."""


def fresh_symbol(name: str, used: set[str]) -> Symbol:
    """Return a symbol whose name is not taken, and take it.

    Examples
    --------
    >>> from compensator_theory.matrices.exponentials import fresh_symbol
    >>> fresh_symbol("x", {"x", "a"})
    x_
    """
    while name in used:
        name += "_"
    used.add(name)
    return Symbol(name)


def _poles(poly: Poly) -> dict[Expr, int]:
    """Return the roots with multiplicity."""
    poles: dict[Expr, int] = {}
    for factor, multiplicity in poly.factor_list()[1]:
        if factor.degree() > 1:
            raise InputError(
                f"the roots of {quoted(factor)} are no rational poles; write the plant with "
                "symbols for its poles, or approximate them by rational numbers"
            )
        leading, constant = factor.all_coeffs()
        pole = sympy.expand(sympy.cancel(-constant / leading))
        poles[pole] = poles.get(pole, 0) + multiplicity
    return poles


def _parts(pole: Expr) -> dict[Expr, Rational]:
    """Return the rational coefficients of a pole by monomials in the symbols."""
    found = {}
    for term in sympy.Add.make_args(pole):
        coefficient, monomial = term.as_coeff_Mul()
        powers = monomial.as_powers_dict() if monomial != 1 else {}
        if not all(base.is_Symbol and power.is_Integer for base, power in powers.items()):
            raise InputError(f"the pole {pole} is no sum of monomials; write a symbol in its place")
        if coefficient != 0:
            found[monomial] = coefficient
    return found


def _bases(poles: Sequence[Expr], used: set[str]) -> list[Base]:
    rates: dict[Expr, list[Rational]] = {}
    for pole in poles:
        for monomial, coefficient in _parts(pole).items():
            rates.setdefault(monomial, []).append(coefficient)
    bases = []
    for monomial, found in rates.items():
        unit = Rational(gcd(*(int(c.p) for c in found)), lcm(*(int(c.q) for c in found)))
        sign = 1 if all(c > 0 for c in found) else -1
        name = "x" if monomial == 1 else f"x_{monomial}" if monomial.is_Symbol else "x_"
        bases.append((fresh_symbol(name, used), sign * unit * monomial, monomial))
        powers = sum(int(abs(c) / unit) for c in found)
        ask("terms", powers * (len(poles) + 1), "the matrix exponential")
    return bases


def _interpolation(
    poles: dict[Expr, int], bases: list[Base], t: Symbol, field: Domain, s: Symbol
) -> Poly:
    """Return the polynomial in s that equals exp(s t) at the poles, with its derivatives."""
    whole = Poly(1, s, domain=field)
    for pole, multiplicity in poles.items():
        whole *= Poly(s - pole, s, domain=field) ** multiplicity
    total = Poly(0, s, domain=field)
    for pole, multiplicity in poles.items():
        linear = Poly(s - pole, s, domain=field)
        local = linear**multiplicity
        parts = _parts(pole)
        value = sympy.prod(x ** (parts.get(mono, 0) * mono / rate) for x, rate, mono in bases)
        series = Poly(0, s, domain=field)
        for k in range(multiplicity):
            series += linear**k * Poly(t**k / sympy.factorial(k), s, domain=field)
        cofactor = whole.exquo(local)
        series = (series * Poly(value, s, domain=field) * cofactor.invert(local)).rem(local)
        total += series * cofactor
    return total


def _value_at_matrix(poly: Poly, M: DomainMatrix, field: Domain) -> list[list[FracElement]]:
    """Return the value of a polynomial at a matrix; its powers have no exponentials in them."""
    size = M.shape[0]
    total = [[field.zero] * size for _ in range(size)]
    power = DomainMatrix.eye(size, M.domain).to_dense()
    for coefficient in reversed(poly.rep.to_list()):
        for row, entries in zip(total, power.to_list(), strict=True):
            for j, entry in enumerate(entries):
                if entry:
                    row[j] += coefficient * field.convert_from(entry, M.domain)
        power = power * M
    return total


def _certificate(
    E: list[list[FracElement]],
    M: DomainMatrix,
    bases: list[Base],
    t: Symbol,
    field: Domain,
) -> Certificate:
    rates = [(t, field.one), *((x, field.from_sympy(rate * x)) for x, rate, _ in bases)]
    start = [(field.field.ring(t), 0), *((field.field.ring(x), 1) for x, _, _ in bases)]
    rows = [[field.convert_from(entry, M.domain) for entry in row] for row in M.to_list()]
    left = []
    for i, row in enumerate(rows):
        for j in range(len(rows)):
            motion = sum((E[i][j].diff(field.field(x)) * rate for x, rate in rates), field.zero)
            for factor, other in zip(row, E, strict=True):
                motion -= factor * other[j]
            at_start = E[i][j].numer.evaluate(start) - int(i == j) * E[i][j].denom.evaluate(start)
            numeric = not hasattr(at_start, "as_expr")  # where every symbol has got a value
            left += [
                field.to_sympy(motion),
                QQ.to_sympy(at_start) if numeric else at_start.as_expr(),
            ]
    return proven(Certificate(IDENTITY, ImmutableMatrix(1, len(left), left)), "exponential")
