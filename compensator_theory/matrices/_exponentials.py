"""Exponentials of matrices, exact: exponentials of the eigenvalues stay symbols."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd, lcm
from typing import Any

import sympy
from sympy import QQ, Expr, ImmutableMatrix, Poly, Rational, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, proven
from compensator_theory.polynomials._budget import ask, quoted
from compensator_theory.polynomials._letters import fresh

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
    tangents : tuple of (Symbol, Expr)
        Each symbol y with its d stands for tan(w t/2)/w, w = sqrt(d), which is real for d < 0 too.
    certificate : Certificate
        The differential equation that it solves, and the initial value.
    """

    value: ImmutableMatrix
    rates: tuple[tuple[Symbol, Expr], ...]
    tangents: tuple[tuple[Symbol, Expr], ...]
    certificate: Certificate


def matrix_exponential(
    matrix: ImmutableMatrix, annihilator: Poly, t: Symbol, used: set[str]
) -> MatrixExponential:
    r"""Return the polynomial in a matrix that interpolates e^(st) on its spectrum.

    .. math:: e^{Mt} = r(M), \qquad r^{(k)}(\lambda) = t^k e^{\lambda t} \quad
              (k < \text{multiplicity of } \lambda)

    For a factor :math:`(s - \sigma)^2 + d` of the annihilator, d of either sign, :math:`e^{st}` is
    :math:`e^{\sigma t}(\cos\omega t + (s - \sigma)\sin(\omega t)/\omega)`, :math:`\omega^2 = d`,
    and both are rational in :math:`y = \tan(\omega t/2)/\omega`.
    """
    modes = _modes(annihilator)
    bases = _bases([centre for centre, _ in modes], used)
    angles = _angles([d for _, d in modes if d is not None], used)
    symbols = sorted(matrix.free_symbols | annihilator.free_symbols_in_domain, key=str)
    field = QQ.frac_field(
        *dict.fromkeys([t, *(x for x, _, _ in bases), *(a.symbol for a in angles), *symbols])
    )
    dense = DomainMatrix.from_Matrix(matrix).to_field().to_dense()
    interpolation = _interpolation(modes, bases, angles, t, field, annihilator.gen)
    value = _value_at_matrix(interpolation, dense, field)
    certificate = _certificate(value, dense, bases, angles, t, field)
    return MatrixExponential(
        ImmutableMatrix([[field.to_sympy(entry) for entry in row] for row in value]),
        tuple((x, rate) for x, rate, _ in bases),
        tuple((angle.symbol, angle.square) for angle in angles),
        certificate,
    )


@dataclass(frozen=True)
class _Angle:
    """tan(w t/2)/w for w**2 = square, a frequency of which others are whole multiples."""

    symbol: Symbol
    square: Expr


Base = tuple[Symbol, Expr, Expr]
"""A symbol x = exp(rate h), its rate, and the monomial that the rate is a multiple of."""


def _choose_symbol(name: str, used: set[str]) -> Symbol:
    """Return a new symbol and reserve its name."""
    symbol = fresh(used, name)
    used.add(symbol.name)
    return symbol


Mode = tuple[Expr, Expr | None]
"""A rational pole, or (s - centre)**2 + square with the square d."""


def _modes(poly: Poly) -> dict[Mode, int]:
    """Return the poles and the quadratic factors with multiplicity."""
    modes: dict[Mode, int] = {}
    for factor, multiplicity in poly.factor_list()[1]:
        if factor.degree() > 2:
            raise InputError(
                f"the factor {quoted(factor)} has a degree above 2, so that its roots have no "
                "closed form here; write symbols for the poles, or rational numbers close to them"
            )
        leading, *rest = (sympy.sympify(c) for c in factor.all_coeffs())
        centre = sympy.expand(sympy.cancel(-rest[0] / (int(factor.degree()) * leading)))
        square = None
        if factor.degree() == 2:
            square = sympy.factor(sympy.cancel(rest[1] / leading - centre**2))
        mode = (centre, square)
        modes[mode] = modes.get(mode, 0) + multiplicity
    return modes


def _angles(squares: Sequence[Expr], used: set[str]) -> list[_Angle]:
    """Return one symbol for all frequencies whose ratios are rational."""
    groups: list[tuple[Expr, list[Rational]]] = []
    for square in dict.fromkeys(squares):
        for first, multiples in groups:
            ratio = sympy.cancel(square / first)
            root = sympy.sqrt(ratio) if ratio.is_Rational and ratio > 0 else None
            if root is not None and root.is_Rational:
                multiples.append(root)
                break
        else:
            groups.append((square, [Rational(1)]))
    angles = []
    for first, multiples in groups:
        unit = Rational(gcd(*(int(c.p) for c in multiples)), lcm(*(int(c.q) for c in multiples)))
        ask("terms", sum(int(c / unit) for c in multiples) * 4, "the matrix exponential")
        angles.append(_Angle(_choose_symbol("y", used), sympy.factor(first * unit**2)))
    return angles


def _turn(square: Expr, angles: Sequence[_Angle], field: Domain) -> tuple[Any, Any]:
    """Return cos(w t) and sin(w t)/w by the symbol of its frequency."""
    for angle in angles:
        ratio = sympy.cancel(square / angle.square)
        if ratio.is_Rational and ratio > 0 and sympy.sqrt(ratio).is_Integer:
            count = int(sympy.sqrt(ratio))
            y, d = (field.from_sympy(value) for value in (angle.symbol, angle.square))
            below = 1 + d * y**2
            cosine, sine = (1 - d * y**2) / below, 2 * y / below
            c, s = field.one, field.zero
            for _ in range(count):  # (c + v s)(cosine + v sine) with v**2 = -d
                c, s = c * cosine - d * s * sine, c * sine + s * cosine
            return c, s / count
    raise AssertionError("every frequency is a whole multiple of one")


def _parts(pole: Expr) -> dict[Expr, Rational]:
    """Return the rational coefficients of a pole by monomials in the symbols."""
    parts = {}
    for term in sympy.Add.make_args(pole):
        coefficient, monomial = term.as_coeff_Mul()
        powers = monomial.as_powers_dict() if monomial != 1 else {}
        if not all(base.is_Symbol and power.is_Integer for base, power in powers.items()):
            raise InputError(f"the pole {pole} is no sum of monomials; write a symbol in its place")
        if coefficient != 0:
            parts[monomial] = coefficient
    return parts


def _bases(poles: Sequence[Expr], used: set[str]) -> list[Base]:
    rates: dict[Expr, list[Rational]] = {}
    for pole in poles:
        for monomial, coefficient in _parts(pole).items():
            rates.setdefault(monomial, []).append(coefficient)
    bases = []
    for monomial, multiples in rates.items():
        unit = Rational(gcd(*(int(c.p) for c in multiples)), lcm(*(int(c.q) for c in multiples)))
        sign = 1 if all(c > 0 for c in multiples) else -1
        name = "x" if monomial == 1 else f"x_{monomial}" if monomial.is_Symbol else "x_"
        bases.append((_choose_symbol(name, used), sign * unit * monomial, monomial))
        powers = sum(int(abs(c) / unit) for c in multiples)
        ask("terms", powers * (len(poles) + 1), "the matrix exponential")
    return bases


def _interpolation(
    modes: dict[Mode, int],
    bases: list[Base],
    angles: Sequence[_Angle],
    t: Symbol,
    field: Domain,
    s: Symbol,
) -> Poly:
    """Return the polynomial in s that equals exp(s t) at the poles, with its derivatives."""
    factors = {}
    for centre, square in modes:
        linear = Poly(s - centre, s, domain=field)
        factors[centre, square] = (
            linear if square is None else linear**2 + Poly(square, s, domain=field)
        )
    whole = Poly(1, s, domain=field)
    for mode, multiplicity in modes.items():
        whole *= factors[mode] ** multiplicity
    total = Poly(0, s, domain=field)
    for (centre, square), multiplicity in modes.items():
        factor = factors[centre, square]
        local = factor**multiplicity
        parts = _parts(centre)
        value = sympy.prod(x ** (parts.get(mono, 0) * mono / rate) for x, rate, mono in bases)
        series = Poly(0, s, domain=field)
        if square is None:
            for k in range(multiplicity):
                series += factor**k * Poly(t**k / sympy.factorial(k), s, domain=field)
        else:
            series = _quadratic_series(centre, square, multiplicity, factor, angles, t, field)
        cofactor = whole.exquo(local)
        series = (series * Poly(value, s, domain=field) * cofactor.invert(local)).rem(local)
        total += series * cofactor
    return total


def _quadratic_series(
    centre: Expr,
    square: Expr,
    multiplicity: int,
    factor: Poly,
    angles: Sequence[_Angle],
    t: Symbol,
    field: Domain,
) -> Poly:
    """Return exp((s - centre) t) modulo a power of the factor.

    It is C + v S at v = s - centre, where C and S are functions of u = v**2, expanded in powers of
    the factor u + d.
    """
    s = factor.gen
    time, u = field.from_sympy(t), -field.from_sympy(square)
    linear = Poly(s - centre, s, domain=field)
    cosine, sine = _turn(square, angles, field)
    C, S = expansion_of_turn(cosine, sine, time, u, multiplicity)
    total, power = Poly(0, s, domain=field), Poly(1, s, domain=field)
    for pair in zip(C, S, strict=True):
        even, odd = (Poly.from_list([x], s, domain=field) for x in pair)
        total += power * (even + linear * odd)
        power *= factor
    return total


def expansion_of_turn(
    cosine: Any, sine: Any, time: Any, u: Any, count: int
) -> tuple[list[Any], list[Any]]:
    """Return the Taylor coefficients of cos(w t) and sin(w t)/w as functions of u = -w**2.

    They obey C' = t S/2 and S' = (t C - S)/(2 u), which is (u + x) 2 S' = t C - S by powers of x.
    """
    C, S = [cosine], [sine]
    for k in range(1, count):
        C.append(time * S[k - 1] / (2 * k))
        S.append((time * C[k - 1] - S[k - 1] - 2 * (k - 1) * S[k - 1]) / (2 * k * u))
    return C, S


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
    angles: Sequence[_Angle],
    t: Symbol,
    field: Domain,
) -> Certificate:
    rates = [(t, field.one), *((x, field.from_sympy(rate * x)) for x, rate, _ in bases)]
    rates += [(a.symbol, field.from_sympy((1 + a.square * a.symbol**2) / 2)) for a in angles]
    start = [(field.field.ring(t), 0), *((field.field.ring(x), 1) for x, _, _ in bases)]
    start += [(field.field.ring(a.symbol), 0) for a in angles]
    rows = [[field.convert_from(entry, M.domain) for entry in row] for row in M.to_list()]
    left = []
    for i, row in enumerate(rows):
        for j in range(len(rows)):
            motion = sum((E[i][j].diff(field.field(x)) * rate for x, rate in rates), field.zero)
            for factor, other in zip(row, E, strict=True):
                motion -= factor * other[j]
            at_start = E[i][j].numer.evaluate(start) - int(i == j) * E[i][j].denom.evaluate(start)
            numeric = not hasattr(at_start, "as_expr")  # every symbol has a value
            left += [
                field.to_sympy(motion),
                QQ.to_sympy(at_start) if numeric else at_start.as_expr(),
            ]
    return proven(Certificate(IDENTITY, ImmutableMatrix(1, len(left), left)), "exponential")
