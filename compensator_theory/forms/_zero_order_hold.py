"""Exact sampling with holds, by Tustin's rule, and with matched poles and zeros.

Exponentials of the poles stay symbols.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import sympy
from sympy import QQ, Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._exponentials import matrix_exponential
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
    solve,
)
from compensator_theory.polynomials._budget import (
    ask,
    ask_for_number,
    decimal_digits,
    integer,
    repr_of,
    unlimited,
)
from compensator_theory.polynomials._carrying import (
    carried_by,
    refusing,
    require_no_functions,
)
from compensator_theory.polynomials._letters import fresh, introduced, names_in_all
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical, from_coefficients
from compensator_theory.polynomials._sympy_trees import rational_floats, require_readable
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import (
    DISCRETE,
    as_symbol,
    is_discrete,
    require_discrete,
)
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._dead_times import with_dead_time
from compensator_theory.systems._delayed_transfer_functions import (
    DelayedTransferFunction,
    way_of_pade,
)
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_functions import TransferFunction


@dataclass(frozen=True)
class SampledPlant(ExactValue):
    r"""A continuous plant at its samples; the equations are those of a zero-order hold.

    .. math:: x_{k+1} = e^{Ah} x_k + \int_0^h e^{A\tau}\,d\tau\, B\, u_k, \qquad
              y_k = C x_k + D u_k

    Attributes
    ----------
    realisation : Realisation
        In the variable of discrete time, with the symbols of `exponentials` in its entries.
    step : sympy.Expr
        h, the time between samples.
    exponentials : tuple of (Symbol, Expr)
        The meaning of each new symbol, such as (x, exp(-h)), or (y, tan(h/2)) for poles at
        :math:`\pm\mathrm{j}`, in which :math:`\cos h = (1 - y^2)/(1 + y^2)`.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols that the matrices are divided by, such as a - b where
        poles a and b would be one.
    certificate : Certificate
        The differential equation of the matrix exponential, for a symbol h.
    """

    realisation: Realisation
    step: Expr
    exponentials: tuple[tuple[Symbol, Expr], ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def transfer_function(self) -> TransferFunction:
        """The reduced pulse transfer function; InputError if not scalar."""
        return self.realisation.transfer_function().reduced()

    def __str__(self) -> str:
        meaning = ", ".join(f"{x} = {text(value)}" for x, value in self.exponentials)
        return f"{self.realisation}" + (f"\n{meaning}" if meaning else "")

    def _repr_latex_(self) -> str:
        name = r"\begin{bmatrix} A_d & B_d \\ C & D \end{bmatrix}"
        meaning = [f"{latex(x)} = {latex(value)}" for x, value in self.exponentials]
        return displayed(f"{name} = {latex(self.realisation)}", *meaning, unless(self.exceptional))


@carried_by("none")
def zero_order_hold(
    plant: RealisationLike | DelayedTransferFunction,
    step: NumberLike | None = None,
    *,
    discrete_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> SampledPlant:
    r"""Sample a continuous plant exactly.

    .. math:: \exp\left(\begin{bmatrix} A & B \\ 0 & 0 \end{bmatrix} h\right)
              = \begin{bmatrix} A_d & B_d \\ 0 & I \end{bmatrix}

    Parameters
    ----------
    plant : Realisation, matrices, transfer function
        Anything :func:`realisation` reads, in s or another variable that is not z or q. Its
        denominator has factors of degree 1 and 2, with rational numbers or symbols, and the real
        parts (of real irrational poles: the means) are sums of monomials such as -a. A transfer
        function may have a dead time :math:`\theta`, of which :math:`\theta/h` is rational.
    step : number or symbol, optional
        h > 0: a symbol, by default h, or "step" where h is a symbol of the plant; a rational
        number; or a SymPy expression: log(2), which makes exponentials of whole poles rational
        numbers, or pi/2, where the frequencies are such that it makes the tangents rational or
        infinite.
    variable : str or Symbol, optional
        As for :func:`realisation`.
    discrete_variable : str or Symbol, optional
        z or q; by default z, or q where z is a symbol of the plant.

    Raises
    ------
    InputError
        If the plant is discrete, h is not positive or a symbol of the plant, an irreducible factor
        has degree 3 or more, or a real part is no sum of monomials.

    Notes
    -----
    The exponential is the polynomial in the matrix that interpolates e^(sh) on the spectrum.
    Exponentials of poles that are whole multiples of one number are powers of one symbol, so that
    no relation between them is lost; the same holds for the tangents of frequencies with rational
    ratios. (Exponentials of others are algebraically independent at every algebraic h > 0, by the
    theorem of Lindemann and Weierstrass.) At the steps :math:`h = (2l + 1)\pi/\omega` a tangent
    is infinite, and the matrices are the limits. For a short h the zeros beyond those of the plant
    tend to the roots of :func:`sampling_zero_polynomial`. Source: K. J. Astrom, P. Hagander and
    J. Sternby, Zeros of sampled systems, Automatica 20 (1984).

    With a dead time :math:`\theta = dh - \delta`, :math:`0 \le \delta < h`, the states include the
    last d inputs, and (the modified z-transform)

    .. math:: x_{k+1} = e^{Ah} x_k + \big(\Gamma(h) - \Gamma(\delta)\big) u_{k-d}
              + \Gamma(\delta)\, u_{k-d+1}, \qquad \Gamma(t) = \int_0^t e^{A\tau}\,d\tau\, B, \qquad
              y_k = C x_k + D u_{k-d}

    Exponentials are those of the largest step of which h and :math:`\delta` are multiples. Source:
    K. J. Astrom and B. Wittenmark, Computer-Controlled Systems (1997), Section 2.3.

    Examples
    --------
    >>> from sympy import log
    >>> from compensator_theory.sampling import zero_order_hold
    >>> print(zero_order_hold("1/((s + 1)*(s + 2))", log(2)).transfer_function)
    (z/8 + 1/16)/(z**2 - 3*z/4 + 1/8)
    >>> print(zero_order_hold("1/(s + 1)"))
    A = [[x]]
    B = [[1 - x]]
    C = [[1]]
    x = exp(-h)
    >>> sampled = zero_order_hold("1/(s**2 + 1)")
    >>> sampled.realisation.A[0, 0], sampled.exponentials  # cos(h)
    ((1 - y**2)/(y**2 + 1), ((y, tan(h/2)),))
    >>> from sympy import pi
    >>> print(zero_order_hold("1/(s**2 + 1)", pi / 2).transfer_function)
    (z + 1)/(z**2 + 1)
    >>> late = zero_order_hold("exp(-3/2*s)/(s + 1)", 1)  # a step and a half
    >>> print(late.transfer_function, late.exponentials)
    ((1 - x)*z + (-x**2 + x))/(z**3 - x**2*z**2) ((x, exp(-1/2)),)
    """
    system = with_dead_time(plant, variable)
    if isinstance(system, DelayedTransferFunction):
        return _late(system, step, discrete_variable)
    return _sampled_by_hold(plant, step, discrete_variable=discrete_variable, variable=variable)


@refusing
def _sampled_by_hold(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    discrete_variable: str | Symbol | None,
    variable: str | Symbol | None,
) -> SampledPlant:
    """Sample a plant without dead time."""
    return _sampled(plant, step, variable, discrete_variable, 1)


def _late(
    plant: DelayedTransferFunction, step: NumberLike | None, discrete_variable: str | Symbol | None
) -> SampledPlant:
    """Sample a plant with a dead time, at the steps of a clock that divides h and the fraction."""
    require_no_functions(plant.rational)
    system, z, h = _read(plant.rational, step, None, discrete_variable)
    steps = sympy.cancel(plant.delay / h)
    if not (steps.is_Rational and steps > 0):
        raise InputError(
            f"the dead time {text(plant.delay)} s in steps of {repr_of(h)} is no rational number; "
            "give both as numbers, as in zero_order_hold(G, '1/2'), or the dead time as a multiple "
            "of the symbol of the step, ",
            way_of_pade("or sample the approximation G.pade({order})"),
        )
    d = int(sympy.ceiling(steps))
    parts, fraction = int(steps.q), d - steps
    n, m = system.B.shape
    ask("degree", n + d, "the sampled plant with its dead time")
    ask("degree", max(1, n) * parts, "the sampled plant with its fraction of a step")
    M = ImmutableMatrix.vstack(system.A.row_join(system.B), zero_matrix(m, n + m))
    ask("entries", (n + m) ** 2 * (n + 1), "the matrix exponential")
    poles = characteristic_polynomial(system.A, system.variable)
    annihilator = canonical(poles * Poly(system.variable, system.variable, domain=QQ))
    E, meaning, certificate, squares = _exponential_of(M, annihilator, system, h / parts, z)
    powers = [ImmutableMatrix(identity_matrix(n + m)), ImmutableMatrix(E)]
    for _ in range(parts - 1):
        powers.append(in_lowest_terms(multiplied(powers[-1], E)))
    whole, late = powers[parts], powers[int(fraction * parts)]
    now = late[:n, n:]
    before = in_lowest_terms(whole[:n, n:] - now)
    A, B = sympy.zeros(n + d, n + d), sympy.zeros(n + d, 1)
    A[:n, :n], A[:n, n + d - 1] = whole[:n, :n], before
    for k in range(1, d):
        A[n + k, n + k - 1] = 1
    B[n, 0] = 1
    if d > 1:
        A[:n, n + d - 2] = now
    else:
        B[:n, 0] = now
    C = system.C.row_join(zero_matrix(1, d - 1)).row_join(system.D)
    with unlimited():
        result = Realisation(A, B, C, [[0]], z, sample_time=_period(h))
    divisors = [sympy.fraction(entry)[1] for entry in (*A, *B)]
    exceptional = _where_zero(divisors, h, meaning, squares)
    return SampledPlant(result, h, meaning, exceptional, certificate)


@refusing
def first_order_hold(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    discrete_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> SampledPlant:
    r"""Sample a continuous plant exactly whose input is a straight line between the samples.

    .. math:: \exp\left(\begin{bmatrix} A & B & 0 \\ 0 & 0 & I \\ 0 & 0 & 0 \end{bmatrix} h\right)
              = \begin{bmatrix} A_d & \Gamma_1 & h\,\Gamma_2 \\ 0 & I & hI \\ 0 & 0 & I
              \end{bmatrix}, \qquad B_d = \Gamma_1 - \Gamma_2 + A_d\Gamma_2, \quad
              D_d = D + C\,\Gamma_2

    Parameters
    ----------
    plant, step, variable, discrete_variable
        As for :func:`zero_order_hold`.

    Returns
    -------
    SampledPlant
        Its state is :math:`x - \Gamma_2 u`: the line to the next sample needs that one (a triangle
        hold, which no machine can run ahead of time; for signals that are known it is the better
        model).

    Raises
    ------
    InputError
        As for :func:`zero_order_hold`.

    Notes
    -----
    Source: G. F. Franklin, J. D. Powell and M. L. Workman, Digital Control of Dynamic Systems
    (1998), Section 6.3.

    Examples
    --------
    >>> from compensator_theory.sampling import first_order_hold
    >>> print(first_order_hold("1/s").transfer_function)
    (h*z/2 + h/2)/(z - 1)
    """
    return _sampled(plant, step, variable, discrete_variable, 2)


@refusing
def tustin(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    discrete_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> SampledPlant:
    r"""Replace s by a rational function of z that keeps stability: Tustin's rule.

    .. math:: s = \frac{2}{h}\,\frac{z - 1}{z + 1}, \qquad
              A_d = (I - Ah/2)^{-1}(I + Ah/2), \quad B_d = h\,(I - Ah/2)^{-1}B

    Parameters
    ----------
    plant, variable, discrete_variable
        As for :func:`zero_order_hold`, with poles of any kind.
    step : number or symbol, optional
        h > 0, a rational number or a symbol, by default the same. To keep the response at the
        frequency :math:`\omega_0`, put a rational number close to
        :math:`2\tan(\omega_0h/2)/\omega_0` in its place (prewarping).

    Raises
    ------
    NoSolutionError
        If 2/h is a pole for all values of the symbols: z is infinite there.
    InputError
        If the plant is discrete, or h is no positive rational number or symbol.

    Examples
    --------
    >>> from compensator_theory.sampling import tustin
    >>> print(tustin("1/(s + 1)", "1/2").transfer_function)
    (z/5 + 1/5)/(z - 3/5)
    """
    system, z, h = _read(plant, step, variable, discrete_variable)
    if not (h.is_Rational or isinstance(h, Symbol)):
        raise InputError(f"the step {repr_of(h)} must be a rational number or a symbol")
    n = system.n
    unit = identity_matrix(n)
    below = ImmutableMatrix(unit - system.A * h / 2)
    if n and determinant(below) == 0:
        raise NoSolutionError(
            f"the plant has a pole at 2/h = {2 / h}, which Tustin's rule maps to z = infinity; "
            "take another step"
        )
    inverse = solve(below, unit) if n else below
    A = in_lowest_terms(inverse * (unit + system.A * h / 2))
    B, C = in_lowest_terms(inverse * system.B * h), multiplied(system.C, inverse)
    D = in_lowest_terms(system.D + C * system.B * h / 2)
    left = [below * A - unit - system.A * h / 2, below * B - system.B * h, C * below - system.C]
    certificate = certificate_of(
        "(I - Ah/2) A_d = I + Ah/2, (I - Ah/2) B_d = B h, C_d (I - Ah/2) = C", left, "sampling"
    )
    result = Realisation(A, B, C, D, z, sample_time=_period(h))
    exceptional = exceptional_factors(sympy.fraction(e)[1] for m in (A, B, C, D) for e in m)
    return SampledPlant(result, h, (), exceptional, certificate)


@refusing
def matched(
    plant: RealisationLike,
    step: NumberLike | None = None,
    *,
    discrete_variable: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> SampledPlant:
    r"""Map poles and zeros by z = e^(sh), those at infinity to -1, and keep the gain at rest.

    .. math:: G_d = k\,(z + 1)^{r - 1} \frac{\prod_j (z - e^{\zeta_j h})}{\prod_i (z - e^{p_ih})}

    with r the relative degree: one zero stays at infinity, so that y(k) does not wait for u(k).

    Parameters
    ----------
    plant, step, variable, discrete_variable
        As for :func:`zero_order_hold`, with one input and one output; what is asked of its
        denominator there is asked of its numerator, too.

    Returns
    -------
    SampledPlant
        In controllable canonical form; common factors of the plant are cancelled.

    Raises
    ------
    InputError
        As for :func:`zero_order_hold`, or if the plant is 0 or not scalar.

    Notes
    -----
    Where the plant has integrators or zeros at 0, what is kept is the limit of s^i G(s), with
    (z - 1)/h in place of s. Source: G. F. Franklin, J. D. Powell and M. L. Workman, Digital
    Control of Dynamic Systems (1998), Section 6.2.

    Examples
    --------
    >>> from sympy import log
    >>> from compensator_theory.sampling import matched
    >>> print(matched("(s + 1)/(s + 2)", log(2)).transfer_function)
    (3*z/4 - 3/8)/(z - 1/4)
    >>> print(matched("1/(s*(s + 1))").transfer_function)
    ((-h*x/2 + h/2)*z + (-h*x/2 + h/2))/(z**2 + (-x - 1)*z + x)
    """
    system, z, h = _read(plant, step, variable, discrete_variable)
    if system.D.shape != (1, 1):
        raise InputError("poles and zeros are matched for one input and one output")
    G = system.transfer_function().reduced()
    if G.numerator.is_zero:
        raise InputError("the plant is 0: it has no zeros to be matched")
    polynomials = [p.monic() for p in (G.numerator, G.denominator)]
    companions = [
        sympy.Matrix.companion(p) if p.degree() > 0 else sympy.zeros(0, 0) for p in polynomials
    ]
    M = ImmutableMatrix(sympy.diag(*companions))
    ask("entries", M.rows**2 * (M.rows + 1), "the matrix exponential")
    annihilator = canonical(polynomials[0] * polynomials[1])
    E, meaning, certificate, squares = _exponential_of(M, annihilator, system, h, z)
    m = companions[0].rows
    N, D = (characteristic_polynomial(part, z) for part in (E[:m, :m], E[m:, m:]))
    unit, rule = Poly(z + 1, z), Poly(z - 1, z)
    N *= unit ** max(M.rows - 2 * m - 1, 0)
    at_rest, rest = sympy.S.One, sympy.S.One  # the first coefficients of G and of N/D there
    for sign, before, after in ((1, G.numerator, N), (-1, G.denominator, D)):
        zeros = next(i for i, c in enumerate(reversed(before.all_coeffs())) if c != 0)
        at_rest *= before.all_coeffs()[-1 - zeros] ** sign / h ** (sign * zeros)
        rest *= canonical(after).exquo(rule**zeros).eval(1) ** sign
    if rest.has(sympy.zoo, sympy.nan) or sympy.cancel(rest) == 0:
        raise InputError(
            f"with the step {repr_of(h)} a zero or a pole is mapped to 1; choose another step"
        )
    k = sympy.cancel(at_rest / rest)
    sampled = TransferFunction(canonical(N * k), canonical(D), sample_time=_period(h))
    divisors = [sympy.fraction(sympy.cancel(c))[1] for c in (*sampled.numerator.all_coeffs(), k)]
    exceptional = _where_zero(divisors, h, meaning, squares)
    return SampledPlant(realisation(sampled), h, meaning, exceptional, certificate)


def _period(h: Expr) -> Expr | None:
    return h if h.is_Rational else None


def _read(
    plant: RealisationLike,
    step: NumberLike | None,
    variable: str | Symbol | None,
    discrete_variable: str | Symbol | None,
) -> tuple[Realisation, Symbol, Expr]:
    """Read a continuous plant, the variable of the sampled one, and the step."""
    system = realisation(plant, variable)
    if system.variable.name in DISCRETE or is_discrete(system.variable, "sampling"):
        raise InputError(f"the plant in {system.variable} is already discrete; give a plant in s")
    plant_names = names_in_all(*system.matrices)
    if discrete_variable is None and plant_names.issuperset(DISCRETE):
        raise InputError(
            "z and q are symbols of the plant, and one of them has to be the variable of the "
            "sampled plant; name one otherwise"
        )
    z = introduced(
        discrete_variable, plant_names, *DISCRETE,
        meaning="the variable of the sampled plant", owner="a symbol of the plant",
    )  # fmt: skip
    require_discrete(z, "a sampled plant")
    variables = {system.variable.name, z.name}
    if step is None:
        return system, z, fresh(plant_names | variables, "h", "step")
    h = positive_step(step)
    if isinstance(h, Symbol):
        for names, owner in (
            (variables, "the variable of a plant"),
            (plant_names, "a symbol of the plant"),
        ):
            introduced(h, names, "h", "step", meaning="the step", owner=owner)
    return system, z, h


def _sampled(
    plant: RealisationLike,
    step: NumberLike | None,
    variable: str | Symbol | None,
    discrete_variable: str | Symbol | None,
    order: int,
) -> SampledPlant:
    """Sample with a hold of order 0 (`order` 1) or 1 (`order` 2)."""
    system, z, h = _read(plant, step, variable, discrete_variable)
    n, m = system.B.shape
    size = n + order * m
    ask("entries", size**2 * (system.n + 1), "the matrix exponential")
    rows = [system.A.row_join(system.B).row_join(zero_matrix(n, size - n - m))]
    if order == 2:
        rows.append(zero_matrix(m, n + m).row_join(identity_matrix(m)))
    rows.append(zero_matrix(m, size))
    M = ImmutableMatrix.vstack(*rows)
    poles = characteristic_polynomial(system.A, system.variable)
    annihilator = canonical(poles * Poly(system.variable**order, system.variable, domain=QQ))
    sampled, meaning, certificate, squares = _exponential_of(M, annihilator, system, h, z)
    B, D = sampled[:n, n : n + m], system.D
    if order == 2:
        slope = (sampled[:n, n + m :] / h).applyfunc(sympy.cancel)
        B = in_lowest_terms(B - slope + sampled[:n, :n] * slope)
        D = in_lowest_terms(system.D + system.C * slope)
    with unlimited():
        result = Realisation(sampled[:n, :n], B, system.C, D, z, sample_time=_period(h))
    divisors = [sympy.fraction(entry)[1] for entry in (*sampled, *B, *D)]
    exceptional = _where_zero(divisors, h, meaning, squares)
    return SampledPlant(result, h, meaning, exceptional, certificate)


Meaning: TypeAlias = tuple[tuple[Symbol, Expr], ...]


def _exponential_of(
    M: ImmutableMatrix, annihilator: Poly, plant: Realisation, h: Expr, z: Symbol
) -> tuple[ImmutableMatrix, Meaning, Certificate, Meaning]:
    """Return exp(M h), the meaning of its symbols, the certificate, and the tangents' y, w**2."""
    matrices = (plant.A, plant.B, plant.C, plant.D)
    used = {str(x) for matrix in matrices for x in matrix.free_symbols}
    used |= {str(x) for x in h.free_symbols} | {z.name}
    t = h if isinstance(h, Symbol) else fresh(used, "h", "step")
    used.add(t.name)
    exponential = matrix_exponential(M, annihilator, t, used)
    E = exponential.value
    values = {x: _exponential(rate * h) for x, rate in exponential.rates}
    if h.has(sympy.pi) and sum(rate.is_number for _, rate in exponential.rates) > 1:
        raise InputError(
            f"with the step {repr_of(h)} the exponentials of several poles may satisfy relations "
            "that no test decides; leave the step a symbol"
        )
    for y, square in exponential.tangents:
        omega = sympy.sqrt(square)
        if h.has(sympy.log):
            raise InputError(
                f"with poles of frequency {omega} and the step {repr_of(h)}, a logarithm, the "
                "entries may satisfy relations that no test decides; leave the step a symbol"
            )
        values[y] = _tangent(omega, h)
    known = {x: value for x, value in values.items() if value.is_Rational}
    sampled = E.subs({t: h, **known}) if t != h or known else E
    for y in [y for y, value in values.items() if value is sympy.zoo]:
        sampled = sampled.subs(y, 1 / y).applyfunc(sympy.cancel).subs(y, 0)
        del values[y]
    if any(e.has(sympy.log, sympy.exp, sympy.pi) for e in sampled):
        raise InputError(
            f"a multiple pole, or a hold of first order, makes the irrational step {repr_of(h)} an "
            "entry of the matrices; leave the step a symbol"
        )
    meaning = tuple((x, value) for x, value in values.items() if x not in known)
    return sampled, meaning, exponential.certificate, exponential.tangents


def _where_zero(
    divisors: Iterable[Expr], h: Expr, meaning: Meaning, squares: Meaning
) -> tuple[Expr, ...]:
    """Return the exceptional polynomials, in symbols of the plant where possible.

    With y = tan(w h/2)/w the square of a cosine, 1/(1 + w**2 y**2), is never infinite, and a
    product of exponentials is 1 where the sum of their exponents is 0.
    """
    never = [sympy.expand(1 + square * y**2) for y, square in squares]
    exponents = {x: value.args[0] / h for x, value in meaning
                 if isinstance(value, sympy.exp)}  # fmt: skip
    conditions: list[Expr] = []
    for factor in exceptional_factors(divisors):
        if factor == h or any(sympy.expand(factor - part) == 0 for part in never):
            continue
        monomial = factor + 1 if factor.subs(dict.fromkeys(exponents, 0)) == -1 else 1 - factor
        powers = monomial.as_powers_dict() if factor.free_symbols <= exponents.keys() else {}
        if powers and powers.keys() <= exponents.keys():
            conditions.append(sum(exponents[x] * power for x, power in powers.items()))
        else:
            conditions.append(factor)
    return exceptional_factors(conditions)


@refusing
def sampling_zero_polynomial(relative_degree: int, variable: str | Symbol = "z") -> Poly:
    r"""Return the polynomial whose roots the sampling zeros tend to as the step becomes short.

    .. math:: B_r(z) = \sum_{k=1}^{r} b_k z^{r-k}, \qquad
              b_k = \sum_{l=1}^{k} (-1)^{k-l} l^r \binom{r+1}{k-l}

    Parameters
    ----------
    relative_degree : int
        r of the continuous plant, at least 1.
    variable : str or Symbol, optional
        Of the result.

    Raises
    ------
    InputError
        If r is no positive integer.

    Notes
    -----
    It is that of 1/s**r for every step (Euler and Frobenius): from r = 3 on a root lies outside the
    unit circle. Source: as for :func:`zero_order_hold`.

    Examples
    --------
    >>> from compensator_theory.sampling import sampling_zero_polynomial
    >>> sampling_zero_polynomial(3)
    Poly(z**2 + 4*z + 1, z, domain='QQ')
    """
    r = relative_degree
    integer(r, "relative_degree", at_least=1)
    ask("degree", r, "the sampling zero polynomial")
    coefficients = [
        sum((-1) ** (k - j) * j**r * sympy.binomial(r + 1, k - j) for j in range(1, k + 1))
        for k in range(1, r + 1)
    ]
    return from_coefficients(coefficients, as_symbol(variable))


def positive_step(step: NumberLike) -> Expr:
    logarithm = isinstance(step, Expr) and step.is_number and bool(step.has(sympy.log))
    if isinstance(step, Expr) and step.has(sympy.pi) and (step / sympy.pi).is_Rational:
        h: Expr = step
    elif isinstance(step, Expr) and logarithm:
        require_readable(step)
        for number in step.atoms(sympy.Rational):
            ask_for_number(int(number.p), int(number.q), "a number in the step")
        h = rational_floats(step, binary=False)
    else:
        h = sympy.sympify(exact_number(step))
    allowed = h.is_Rational or logarithm or h.has(sympy.pi)
    if h.is_positive is False or (h.is_number and not allowed):
        raise InputError(
            f"the step {repr_of(step)} must be a symbol or a positive number: rational, with "
            "logarithms, or a rational multiple of pi"
        )
    if not (h.is_number or isinstance(h, Symbol)):
        raise InputError(
            f"the step {repr_of(step)} must be a symbol or a number, such as 'h' or 0.1"
        )
    return h


def _tangent(omega: Expr, h: Expr) -> Expr:
    """tan(omega h/2)/omega; of a multiple of pi a rational number or infinite, or refused."""
    value: Expr = sympy.tan(omega * h / 2) / omega
    if h.has(sympy.pi) and not (value.is_Rational or value is sympy.zoo):
        raise InputError(
            f"with poles of frequency {text(omega)} the step {repr_of(h)} makes irrational "
            "numbers; leave it a symbol, or take a multiple of a quarter of the period"
        )
    return value


def _exponential(exponent: Expr) -> Expr:
    """Return e to a multiple of the step, a rational number where that is one of logarithms."""
    bits = 0
    for term in sympy.Add.make_args(sympy.expand(exponent)):
        factor, logarithm = term.as_coeff_Mul()
        number = logarithm.args[0] if isinstance(logarithm, sympy.log) else sympy.Integer(1)
        if number.is_Rational:
            longer = max(int(number.p).bit_length(), int(number.q).bit_length())
            bits += int(abs(factor) * longer)
    ask("digits", decimal_digits(bits), "the exponential of a pole with this step")
    return sympy.exp(exponent)
