"""Continuous plants from their samples: the inverses of a zero-order hold and of Tustin's rule."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import sympy
from sympy import QQ, Expr, ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.forms._jordan import jordan_form
from compensator_theory.forms._zero_order_hold import SampledPlant, positive_step
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._exponentials import Mode, expansion_of_turn
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
    rank,
    solve,
)
from compensator_theory.polynomials._budget import ask, integer, quoted, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._decidable import require_rational_functions
from compensator_theory.polynomials._letters import fresh, introduced, names_in_all, numbered
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import exact_quotient, over_coefficient_field
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import is_discrete
from compensator_theory.systems._canonical_forms import RealisationLike, timed_realisation
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_functions import TransferFunction

_LONGEST_POWER = 64
"""Largest exponent up to which powers of one number are recognised."""


@dataclass(frozen=True)
class InverseSampling(ExactValue):
    r"""A continuous plant that has a discrete one as its samples.

    Attributes
    ----------
    realisation : Realisation
        In the variable of continuous time, with the symbols of `logarithms` in its entries.
    step : sympy.Expr
        h, the time between samples.
    logarithms : tuple of (Symbol, Expr)
        The meaning of each new symbol: (a, log(1/2)/h), or (w, (pi/3 + 2*pi*k)/h) with an integer k
        of `branches`.
    branches : tuple of Symbol
        One integer for each pair of complex poles: its frequency is known up to multiples of the
        sampling frequency, and each integer is one plant with the same samples. 0 is the lowest
        frequency.
    is_every_branch : bool
        Whether the integers give every real plant of this order. Otherwise a pole has several
        Jordan blocks, and others exist that are no functions of the discrete matrix.
    positive : tuple of sympy.Expr
        Poles with symbols, which must be positive for a real plant.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols that the matrices are divided by.
    certificate : Certificate
        The answer, sampled again, is the discrete plant.
    """

    realisation: Realisation
    step: Expr
    logarithms: tuple[tuple[Symbol, Expr], ...]
    branches: tuple[Symbol, ...]
    is_every_branch: bool
    positive: tuple[Expr, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def transfer_function(self) -> TransferFunction:
        """The reduced transfer function; InputError if not scalar."""
        return self.realisation.transfer_function().reduced()

    def approximation(self, digits: int = 20, branch: Sequence[int] | None = None) -> Realisation:
        """Return a realisation with rational numbers: each entry rounded to decimal digits.

        Parameters
        ----------
        digits : int
            Significant decimal digits of every entry, 1 to 1000.
        branch : sequence of int, optional
            One integer for each of `branches`; by default 0, the lowest frequencies.

        Raises
        ------
        InputError
            If the plant or the step has symbols, or the numbers of integers differ.

        Examples
        --------
        >>> from compensator_theory.sampling import inverse_zero_order_hold
        >>> plant = inverse_zero_order_hold("1/(z - 1/2)", 1)
        >>> plant.approximation(5).A[0, 0]  # -0.69315
        -13863/20000
        """
        integer(digits, "digits", at_least=1)
        ask("digits", digits, "the approximation")
        turns = [0] * len(self.branches) if branch is None else [*branch]
        if len(turns) != len(self.branches):
            raise InputError(
                f"branch = {repr_of(branch)} must have one integer for each of the "
                f"{len(self.branches)} symbols {', '.join(map(text, self.branches))}"
            )
        for k in turns:
            integer(k, "branch")
        chosen = dict(zip(self.branches, turns, strict=True))
        values = {x: meaning.subs(chosen) for x, meaning in self.logarithms}

        def rounded(entry: Expr) -> Rational:
            number = entry.subs(values)
            if number.free_symbols:
                raise InputError(
                    f"the plant has the symbols {', '.join(sorted(map(str, number.free_symbols)))};"
                    " give numbers for them, and the step as a number"
                )
            return number if number.is_Rational else Rational(str(number.evalf(digits)))

        A, B, C, D = (part.applyfunc(rounded) for part in self.realisation.matrices)
        return Realisation(A, B, C, D, self.realisation.variable)

    def __str__(self) -> str:
        meaning = [f"{x} = {text(value)}" for x, value in self.logarithms]
        if self.branches:
            noun = "an integer" if len(self.branches) == 1 else "integers"
            meaning.append(f"{', '.join(map(text, self.branches))} {noun}")
        if self.positive:
            meaning.append(f"{', '.join(map(text, self.positive))} > 0")
        return f"{self.realisation}" + (f"\n{', '.join(meaning)}" if meaning else "")

    def _repr_latex_(self) -> str:
        name = r"\begin{bmatrix} A & B \\ C & D \end{bmatrix}"
        meaning = [f"{latex(x)} = {latex(value)}" for x, value in self.logarithms]
        meaning += [rf"{latex(k)} \in \mathbb{{Z}}" for k in self.branches]
        meaning += [f"{latex(pole)} > 0" for pole in self.positive]
        return displayed(f"{name} = {latex(self.realisation)}", *meaning, unless(self.exceptional))


@refusing
def inverse_tustin(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    continuous_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> InverseSampling:
    r"""Replace z by the rational function of s that Tustin's rule inverts.

    .. math:: z = \frac{2 + sh}{2 - sh}, \qquad A = \frac 2h (A_d + I)^{-1}(A_d - I), \quad
              B = \frac 2h (A_d + I)^{-1}B_d, \quad C = 2\,C_d(A_d + I)^{-1}

    Parameters
    ----------
    plant, step, continuous_variable, variable
        As for :func:`inverse_zero_order_hold`, with poles of any kind; the step is a rational
        number or a symbol.

    Raises
    ------
    NoSolutionError
        If -1 is a pole for all values of the symbols: s is infinite there.
    InputError
        If the plant is continuous, or h is no positive rational number or symbol.

    Examples
    --------
    >>> from compensator_theory.sampling import inverse_tustin
    >>> print(inverse_tustin("(z/5 + 1/5)/(z - 3/5)", "1/2").transfer_function)
    (1)/(s + 1)
    """
    system, s, h = _read(plant, step, variable, continuous_variable)
    if not (h.is_Rational or isinstance(h, Symbol)):
        raise InputError(f"the step {repr_of(h)} must be a rational number or a symbol")
    n = system.n
    unit = identity_matrix(n)
    below = ImmutableMatrix(system.A + unit)
    if n and determinant(below) == 0:
        raise NoSolutionError(
            "the plant has a pole at -1, which Tustin's rule maps to s = infinity: no proper "
            "continuous plant gives it"
        )
    inverse = solve(below, unit) if n else below
    A = in_lowest_terms(multiplied(inverse, system.A - unit) * 2 / h)
    B = in_lowest_terms(multiplied(inverse, system.B) * 2 / h)
    C = in_lowest_terms(multiplied(system.C, inverse) * 2)
    D = in_lowest_terms(system.D - multiplied(system.C, B) * h / 2)
    back = ImmutableMatrix(unit - A * h / 2)
    left = [
        back * system.A - unit - A * h / 2, back * system.B - B * h, system.C * back - C,
        D + system.C * B * h / 2 - system.D,
    ]  # fmt: skip
    certificate = certificate_of(
        "(I - Ah/2) A_d = I + Ah/2, (I - Ah/2) B_d = B h, C_d (I - Ah/2) = C, D_d = D + C_d B h/2",
        left,
        "continuous plant",
    )
    result = Realisation(A, B, C, D, s)
    return InverseSampling(result, h, (), (), True, (), _divisors(h, A, B, C, D), certificate)


@refusing
def inverse_zero_order_hold(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    continuous_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> InverseSampling:
    r"""Find the continuous plants that have a discrete one as their samples with a held input.

    .. math:: \begin{bmatrix} A & B \\ 0 & 0 \end{bmatrix} =
              \frac 1h \log \begin{bmatrix} A_d & B_d \\ 0 & I \end{bmatrix}

    Parameters
    ----------
    plant : Realisation, matrices, transfer function, SampledPlant
        Anything :func:`realisation` reads, in z or q. Its denominator has factors of degree 1, with
        rational numbers or symbols, and of degree 2 with rational numbers.
    step : number or symbol, optional
        h > 0, as for :func:`zero_order_hold`; by default the sample time of the plant, or a new
        symbol h.
    continuous_variable : str or Symbol, optional
        By default s.
    variable : str or Symbol, optional
        z or q; matrices need it.

    Returns
    -------
    InverseSampling
        In the states of the discrete one: logarithms of its poles are symbols, and so are the
        frequencies of complex ones, with an integer for each, so that one formula is every branch.

    Raises
    ------
    NoSolutionError
        If a pole is 0 (a dead time is no rational plant), or a negative pole has an odd number of
        Jordan blocks of one size: no real matrix has such an exponential.
    InputError
        If the plant is continuous, a factor has degree 3 or more, or is quadratic with symbols.

    Notes
    -----
    A pole r > 0 has the one real logarithm log(r); a complex pair has one for each integer; of two
    equal Jordan blocks of a negative pole -r a pair :math:`\log r \pm (2k + 1)\pi\mathrm j` is
    made, one of many. Powers of one number share a symbol. Other relations between the numbers
    that the symbols stand for (log(2), log(3), log(6)) are not looked for: the identities hold
    without them. Source: W. J. Culver, On the existence and uniqueness of the real logarithm of a
    matrix, Proceedings of the AMS 17 (1966); N. J. Higham, Functions of Matrices (2008), 1.6-1.7.

    Examples
    --------
    >>> from compensator_theory.sampling import inverse_zero_order_hold
    >>> plant = inverse_zero_order_hold("1/(z - 1/2)", "1/10")
    >>> print(plant)
    A = [[a]]
    B = [[-2*a]]
    C = [[1]]
    a = -10*log(2)
    >>> print(inverse_zero_order_hold("1/(z**2 - z + 1)", 1).logarithms)
    ((w, 2*sqrt(3)*(2*pi*k + pi/3)/3),)
    >>> from compensator_theory.sampling import zero_order_hold
    >>> print(inverse_zero_order_hold(zero_order_hold("1/(s + c)")).transfer_function)
    (1)/(s + c)
    """
    exponentials = dict(plant.exponentials) if isinstance(plant, SampledPlant) else {}
    system, s, h = _read(plant, step, variable, continuous_variable)
    for name, matrix in zip("ABCD", system.matrices, strict=True):
        require_rational_functions(matrix, name)
    n, m = system.B.shape
    ask("entries", (n + m) ** 2 * (n + 1), "the matrix logarithm")
    used = names_in_all(*system.matrices, s, h, *exponentials, *exponentials.values())
    t = h if h.is_Rational or isinstance(h, Symbol) else fresh(used, "h", "step")
    spectrum = _Spectrum(system, exponentials, h, used | names_in_all(t))
    A, generator = spectrum.logarithm(t)
    B = multiplied(generator, system.B)
    certificate = _certificate(A, B, system, spectrum, t)
    if t != h and (A.has(t) or B.has(t)):
        raise InputError(
            f"a multiple pole, or a pole at 1, makes the irrational step {repr_of(h)} an entry of "
            "the matrices; leave the step a symbol"
        )
    result = Realisation(A, B, system.C, system.D, s)
    remaining = {x for part in result.matrices for entry in part for x in entry.free_symbols}
    meaning = spectrum.meaning + [(x, value) for x, value in exponentials.items() if x in remaining]
    return InverseSampling(
        result,
        h,
        tuple(meaning),
        tuple(spectrum.branches),
        spectrum.is_cyclic,
        tuple(spectrum.positive),
        _divisors(h, A, B),
        certificate,
    )


def _read(
    plant: RealisationLike,
    step: NumberLike | None,
    variable: str | Symbol | None,
    continuous_variable: str | Symbol | None,
) -> tuple[Realisation, Symbol, Expr]:
    """Read a discrete plant, the variable of the continuous one, and the step."""
    system = timed_realisation(plant, variable, "the inverse of sampling")
    if not is_discrete(system.variable, "the inverse of sampling"):
        raise InputError(
            f"the plant in {system.variable} is already continuous; give a plant in z or q"
        )
    names = names_in_all(*system.matrices)
    s = introduced(
        continuous_variable, names | {system.variable.name}, "s", "s_",
        meaning="the variable of the continuous plant", owner="a symbol of the plant",
    )  # fmt: skip
    if is_discrete(s, "a continuous plant"):
        raise InputError(f"continuous_variable = {s} is discrete time; write s")
    known = plant.step if isinstance(plant, SampledPlant) else system.sample_time
    if step is None:
        return system, s, fresh(names | {s.name}, "h", "step") if known is None else known
    h = positive_step(step)
    if known is not None and sympy.cancel(known - h) != 0:
        raise InputError(
            f"the step {repr_of(step)} contradicts the sample time {text(known)} of the plant; "
            "leave one of them out"
        )
    if isinstance(h, Symbol):
        plant_names = {s.name, system.variable.name} | (names if known is None else set())
        introduced(h, plant_names, "h", "step", meaning="the step", owner="a symbol of the plant")
    return system, s, h


Start: TypeAlias = tuple[Expr, Expr]
"""Real part and imaginary part over w of exp(sh) at a pole of the continuous plant."""


class _Spectrum:
    """The poles of a discrete plant with their logarithms.

    `modes` are those of the continuous plant with multiplicities; `starts` their exponentials;
    `linear` gives c_0 and c_1 of the logarithm c_0 + c_1 S on the roots of each factor, where S is
    the semisimple part of the matrix.
    """

    def __init__(
        self, system: Realisation, exponentials: dict[Symbol, Expr], h: Expr, used: set[str]
    ) -> None:
        self.matrix, self.h, self.used = system.A, h, used
        self.exponentials = exponentials
        self.meaning: list[tuple[Symbol, Expr]] = []
        self.branches: list[Symbol] = []
        self.positive: list[Expr] = []
        self.modes: dict[Mode, int] = {}
        self.starts: dict[Mode, Start] = {}
        self.linear: list[tuple[Poly, Expr, Expr]] = []
        self.turned: list[tuple[Expr, Symbol]] = []
        self.bases: list[tuple[Rational, Expr]] = []
        self.variable = z = system.variable
        (p,) = over_coefficient_field(characteristic_polynomial(system.A, z))
        self.factors = [(f.monic(), int(count)) for f, count in p.factor_list()[1]]
        n, m = system.B.shape
        steps = (n + m) ** 2 * (n + 1) * (10 + 4 * len(self.factors))
        ask("entries", steps, "the matrix logarithm and its certificate")
        for factor, _ in self.factors:  # what has no answer is refused before a logarithm is taken
            self._require_logarithm(factor)
        pairs = [f for f, _ in self.factors if _is_pair(f)]
        negative = [-f.TC() for f, _ in self.factors if f.degree() == 1 and _is_negative(-f.TC())]
        count = len(pairs) + len(negative)
        if count == 1:
            self.integers = [fresh(used, "k")]
        else:
            self.integers = [*numbered(used, "k", count)]
        self.used |= {k.name for k in self.integers}
        self._blocks = _blocks_of(system.A, negative) if negative else {}
        for factor, multiplicity in self.factors:
            self._add(factor, multiplicity)

    @property
    def is_cyclic(self) -> bool:
        """Whether every pole has one Jordan block."""
        n = self.matrix.rows
        return all(
            rank(_at(factor, self.matrix)) == n - factor.degree()
            for factor, multiplicity in self.factors
            if multiplicity > 1
        )

    def _require_logarithm(self, factor: Poly) -> None:
        z = self.variable
        if factor.degree() > 2:
            raise InputError(
                f"the factor {quoted(factor)} has a degree above 2, so that its roots have no "
                "closed form here; write symbols for the poles, or rational numbers close to them"
            )
        if factor.degree() == 1:
            if factor.TC() == 0:
                raise NoSolutionError(
                    f"the plant has a pole at {z} = 0: a dead time of one step, which no "
                    f"continuous pole gives; multiply the transfer function by {z} for each such "
                    "pole, and add the dead time to the continuous plant, as in exp(-h*s)*G"
                )
            return
        if not all(c.is_Rational for c in factor.all_coeffs()):
            raise InputError(
                f"whether the roots of {quoted(factor)} are complex depends on its symbols; give "
                "values by subs(...), or write the plant with symbols for its real poles"
            )
        mean, square = _centre(factor)
        if square > 0 and not (mean > 0 and mean**2 > square):
            raise NoSolutionError(
                f"{quoted(factor)} has a negative root; a real continuous plant gives negative "
                "poles in pairs with equal Jordan blocks alone. Use inverse_tustin"
            )

    def _add(self, factor: Poly, multiplicity: int) -> None:
        zero = sympy.Integer(0)
        if factor.degree() == 2:
            mean, square = _centre(factor)
            product = factor.TC()
            centre = self._rate(product) / 2
            root = sympy.sqrt(abs(square))
            if square < 0:
                angle = sympy.acos(mean / sympy.sqrt(product))
                frequency = angle + 2 * sympy.pi * self._integer()
            else:
                frequency = sympy.log((mean + root) / (mean - root)) / 2
            # the symbol is the rate over the square root if that is irrational
            scale = root if root.is_Rational else sympy.Integer(1)
            slope = self._named(frequency * scale / (root * self.h), "w") / scale
            mode = (sympy.expand(centre), -square * slope**2)
            start = (mean, 1 / slope)
            self.linear.append((factor, centre - slope * mean, slope))
        elif _is_negative(pole := -factor.TC()):
            centre = self._rate(-pole)
            w = self._named((2 * self._integer() + 1) * sympy.pi / self.h, "w")
            mode, start = (centre, w**2), (pole, zero)
            self.linear.append((factor, centre, zero))
            self.turned.append((pole, w))
            multiplicity //= 2
        else:
            rate = self._rate(pole)
            mode, start = (rate, None), (pole, zero)
            self.linear.append((factor, rate, zero))
        self.modes[mode], self.starts[mode] = multiplicity, start

    def _integer(self) -> Symbol:
        k = self.integers[len(self.branches)]
        self.branches.append(k)
        return k

    def _named(self, value: Expr, name: str) -> Expr:
        """Return a rational number, or a symbol that stands for a real number."""
        value = _simple(value)
        if _is_plain(value, self.exponentials):
            return value
        symbol = fresh(self.used, name, *(f"{name}_{k}" for k in range(2, _LONGEST_POWER)))
        self.used.add(symbol.name)
        self.meaning.append((symbol, value))
        return symbol

    def _rate(self, pole: Expr) -> Expr:
        """Return log(pole)/h, by the symbol of a number of which the pole is a power."""
        if pole == 1:
            return sympy.Integer(0)
        if not pole.is_Rational:
            logarithm = _logarithm_of(pole, self.exponentials)
            if logarithm.has(sympy.log):
                self.positive.append(pole)
            return self._named(logarithm / self.h, "a")
        for base, rate in self.bases:
            if (power := _power_of(base, pole)) is not None:
                return power * rate
        rate = self._named(sympy.log(pole) / self.h, "a")
        self.bases.append((pole, rate))
        return rate

    def logarithm(self, t: Expr) -> tuple[ImmutableMatrix, ImmutableMatrix]:
        """Return A and the matrix that makes B of B_d."""
        n = self.matrix.rows
        unit = identity_matrix(n)
        if n == 0:
            return ImmutableMatrix(self.matrix), ImmutableMatrix(self.matrix)
        radical = sympy.prod((f for f, _, _ in self.linear), start=Poly(1, self.variable))
        S = _semisimple(self.matrix, radical)
        nilpotent = in_lowest_terms(ImmutableMatrix(solve(S, self.matrix) - unit))
        powers = [*_powers(nilpotent)]
        A, at_one = zero_matrix(n, n), zero_matrix(n, n)
        for factor, constant, slope in self.linear:
            projection = _projection(S, factor, radical)
            A = A + projection * constant
            if slope != 0:
                A = A + multiplied(projection, S) * slope
            if _is_at_one(factor):
                at_one = projection
        for pole, w in self.turned:
            A = A + self._blocks[pole] * w
        for k, power in enumerate(powers, 1):
            A = A + power * Rational((-1) ** (k + 1), k) / t
        A = in_lowest_terms(ImmutableMatrix(A))
        # on the pole 1: log(z)/(z - 1), a series; on the others the quotient
        below = ImmutableMatrix(self.matrix - unit + at_one)
        inverse = solve(below, ImmutableMatrix(unit - at_one))
        generator = multiplied(A, inverse) + at_one / t
        for k, power in enumerate(powers, 1):
            generator = generator + multiplied(at_one, power) * Rational((-1) ** k, k + 1) / t
        return A, in_lowest_terms(ImmutableMatrix(generator))


def _certificate(
    A: ImmutableMatrix, B: ImmutableMatrix, system: Realisation, spectrum: _Spectrum, t: Expr
) -> Certificate:
    """Sample the answer again: exp(Mh) on each spectral subspace, by the exponential of its pole.

    The columns of the projections Q fill the space; that M has one pole, or pair, on each of them
    is a part of the identity.
    """
    n, m = system.B.shape
    M = ImmutableMatrix.vstack(
        ImmutableMatrix(A).row_join(ImmutableMatrix(B)), zero_matrix(m, n + m)
    )
    target = ImmutableMatrix.vstack(
        ImmutableMatrix(system.A).row_join(ImmutableMatrix(system.B)),
        zero_matrix(m, n).row_join(identity_matrix(m)),
    )
    modes = list(zip(spectrum.linear, spectrum.modes, spectrum.starts.values(), strict=True))
    subspaces = [(factor, mode, start) for (factor, _, _), mode, start in modes]
    if not any(_is_at_one(factor) for factor, _, _ in subspaces):
        rest, zero = Poly(spectrum.variable - 1, spectrum.variable, domain=QQ), sympy.Integer(0)
        subspaces.append((rest, (zero, None), (sympy.Integer(1), zero)))
    radical = sympy.prod((f for f, _, _ in subspaces), start=Poly(1, spectrum.variable))
    S = _semisimple(target, radical)
    total, again, left = zero_matrix(n + m, n + m), zero_matrix(n + m, n + m), []
    for factor, mode, start in subspaces:
        Q = _projection(S, factor, radical)
        exponential, outside = _exponential_on(M, Q, mode, start, t)
        total, again = total + Q, again + exponential
        left.append(outside)
    left += [total - identity_matrix(n + m), again - target]
    return certificate_of(
        "exp([[A, B], [0, 0]] h) = [[A_d, B_d], [0, I]]", left, "continuous plant"
    )


def _exponential_on(
    M: ImmutableMatrix, Q: ImmutableMatrix, mode: Mode, start: Start, t: Expr
) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    """Return exp(Mt) Q, and a power times Q that is 0 if M has only this pole there."""
    centre, square = mode
    shifted = ImmutableMatrix(M - identity_matrix(M.rows) * centre)
    if square is None:
        nilpotent = shifted
    else:
        nilpotent = ImmutableMatrix(multiplied(shifted, shifted) + identity_matrix(M.rows) * square)
    powers = [ImmutableMatrix(Q)]
    while not powers[-1].is_zero_matrix and len(powers) <= M.rows:
        powers.append(in_lowest_terms(multiplied(nilpotent, powers[-1])))
    *powers, outside = powers
    total = zero_matrix(M.rows, M.rows)
    if square is None:
        for k, power in enumerate(powers):
            total = total + power * (start[0] * t**k / sympy.factorial(k))
    elif powers:
        C, S = expansion_of_turn(*start, t, -square, len(powers))
        for c, sine, power in zip(C, S, powers, strict=True):
            total = total + power * c + multiplied(shifted, power) * sine
    return in_lowest_terms(ImmutableMatrix(total)), outside


def _divisors(h: Expr, *matrices: ImmutableMatrix) -> tuple[Expr, ...]:
    """Return the factors of the denominators of matrices, without the step, which is positive."""
    factors = exceptional_factors(sympy.fraction(entry)[1] for part in matrices for entry in part)
    return tuple(factor for factor in factors if factor != h)


def _is_pair(factor: Poly) -> bool:
    return bool(factor.degree() == 2 and _centre(factor)[1] < 0)


def _is_at_one(factor: Poly) -> bool:
    return bool(factor.degree() == 1 and factor.TC() == -1)


def _is_negative(pole: Expr) -> bool:
    return bool(pole.is_Rational and pole < 0)


def _centre(factor: Poly) -> tuple[Expr, Expr]:
    """Return c and d of (z - c)**2 - d."""
    mean = -factor.coeff_monomial(factor.gen) / 2
    return mean, mean**2 - factor.TC()


def _simple(value: Expr) -> Expr:
    """Cancel logarithms, and pi, where that is possible altogether."""
    expanded = sympy.cancel(sympy.expand_log(value, force=True))
    return value if expanded.has(sympy.log, sympy.pi, sympy.acos) else expanded


def _is_plain(value: Expr, exponentials: dict[Symbol, Expr]) -> bool:
    """Whether a value is written by rational functions of the symbols of the plant."""
    if value.is_Rational:
        return True
    return bool(exponentials) and bool(value.is_rational_function()) and not value.has(sympy.pi)


def _logarithm_of(pole: Expr, exponentials: dict[Symbol, Expr]) -> Expr:
    """Return the logarithm of a pole with symbols, some of which are known exponentials."""
    coefficient, powers = pole.as_coeff_Mul()[0], pole.as_coeff_Mul()[1].as_powers_dict()
    known = {x: v.args[0] for x, v in exponentials.items() if isinstance(v, sympy.exp)}
    if coefficient > 0 and powers.keys() <= known.keys():
        exponent = sum((known[x] * power for x, power in powers.items()), sympy.Integer(0))
        return sympy.log(coefficient) + exponent
    return sympy.log(pole)


def _power_of(base: Rational, number: Rational) -> Rational | None:
    """Return r with base**r = number, if it is a rational number."""
    if base == 1:
        return None
    ratio = Fraction(_log(number) / _log(base)).limit_denominator(_LONGEST_POWER)
    p, q = ratio.numerator, ratio.denominator
    if abs(p) > _LONGEST_POWER or number**q != base**p:
        return None
    return Rational(p, q)


def _log(number: Rational) -> float:
    return math.log(int(number.p)) - math.log(int(number.q))


def _at(poly: Poly, matrix: ImmutableMatrix) -> ImmutableMatrix:
    """Return the value of a polynomial at a matrix."""
    unit = identity_matrix(matrix.rows)
    total = zero_matrix(matrix.rows, matrix.rows)
    for coefficient in poly.all_coeffs():
        total = ImmutableMatrix(multiplied(total, matrix) + unit * coefficient)
    return in_lowest_terms(total)


def _semisimple(matrix: ImmutableMatrix, radical: Poly) -> ImmutableMatrix:
    """Return the part S of matrix = S + N (Jordan, Chevalley): a root of the radical, by Newton."""
    S = ImmutableMatrix(matrix)
    slope = radical.diff()
    while not (left := _at(radical, S)).is_zero_matrix:
        S = in_lowest_terms(ImmutableMatrix(S - solve(_at(slope, S), left)))
    return S


def _powers(nilpotent: ImmutableMatrix) -> Iterator[ImmutableMatrix]:
    power = nilpotent
    while not power.is_zero_matrix:
        yield power
        power = multiplied(power, nilpotent)


def _projection(S: ImmutableMatrix, factor: Poly, radical: Poly) -> ImmutableMatrix:
    """Return the projection on the kernel of the value of a factor."""
    if factor.degree() == radical.degree():
        return identity_matrix(S.rows)
    cofactor = exact_quotient(radical, factor)
    first, second = over_coefficient_field(cofactor, factor)
    return _at((first * first.invert(second)).rem(second * first), S)


def _blocks_of(matrix: ImmutableMatrix, poles: Sequence[Expr]) -> dict[Expr, ImmutableMatrix]:
    """Return for each negative pole a matrix with the square -P that commutes: P the projection."""
    form = jordan_form(matrix)
    columns: dict[Expr, list[tuple[int, range]]] = {pole: [] for pole in poles}
    start = 0
    for factor, size in form.blocks:
        length = int(factor.degree()) * size
        pole = -factor.TC() / factor.LC() if factor.degree() == 1 else None
        if pole in columns:
            columns[pole].append((size, range(start, start + length)))
        start += length
    turns = {}
    for pole, blocks in columns.items():
        sizes = Counter(size for size, _ in blocks)
        if odd := [size for size, count in sizes.items() if count % 2]:
            raise NoSolutionError(
                f"the pole {text(pole)} is negative, and an odd number of its Jordan blocks has "
                f"size {odd[0]}; no real matrix has such an exponential. A continuous plant with "
                "one state more may exist: give a realisation that has the pole twice, "
                f"A_d = diag({text(pole)}, {text(pole)}), or take inverse_tustin"
            )
        turn = sympy.zeros(matrix.rows, matrix.rows)
        for size in sizes:
            places = [place for length, place in blocks if length == size]
            for one, other in zip(places[::2], places[1::2], strict=True):
                for i, j in zip(one, other, strict=True):
                    turn[j, i], turn[i, j] = 1, -1
        T = form.T
        turns[pole] = multiplied(T, ImmutableMatrix(turn), solve(T, identity_matrix(T.rows)))
    return turns
