"""Overshoot, rise time and settling time of a response that settles, enclosed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush
from typing import TYPE_CHECKING, TypeAlias

import flint
import sympy
from sympy import Expr, Poly, Rational

from compensator_theory.errors import BudgetError, InputError
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.responses._modes import Mode
from compensator_theory.roots._certified import root_balls
from compensator_theory.roots._enclosures import Enclosure, ball_of_number

Condition: TypeAlias = Callable[[flint.arb], bool | None]
"""Whether a condition holds for all values in a ball, for none (False), or is undecided (None)."""

BITS = 40
"""Where a search ends: of a time, relative to the horizon; of an overshoot, absolute."""
ACCURATE = 60
"""Bits of a value of the response, so that its own ball decides nothing."""
MOST_BOXES = 20_000
LONGEST = 60
"""Of a response in continuous time, as a power of two, and the shortest as one."""
MOST_STEPS = 2**17
"""Of a response in discrete time until it is bounded by the band."""


class StepCharacteristics:
    """Characteristics of a step response that settles at a final value other than 0.

    Times are in the unit of t, in discrete time in steps and exact.
    """

    if TYPE_CHECKING:
        terms: tuple[Mode, ...]

        @property
        def final_value(self) -> Expr: ...

        @property
        def delay(self) -> Expr: ...

        @property
        def is_discrete(self) -> bool: ...

        def __call__(self, time: NumberLike) -> Expr: ...

    def overshoot(self) -> Enclosure:
        """Return the largest excess over the final value, as a fraction of it; 0 if there is none.

        Raises
        ------
        InputError
            If the response has symbols or its final value is 0.
        NoSolutionError
            If the response does not settle.

        Examples
        --------
        >>> from compensator_theory import step_response
        >>> step_response("1/(s**2 + s + 1)").overshoot()
        0.1630335348220 ± 4.5e-13
        """
        return self._searched(lambda error: error.largest(1), "the overshoot")

    def undershoot(self) -> Enclosure:
        """Return the largest excursion against the final value, as a fraction of it, or 0.

        Raises
        ------
        InputError, NoSolutionError
            As :meth:`overshoot`.

        Examples
        --------
        >>> from compensator_theory import step_response
        >>> step_response("(1 - s)/(s + 1)**2").undershoot()
        0.2130613194255 ± 2.1e-13
        """
        return self._searched(lambda error: error.largest(-1), "the undershoot")

    def settling_time(self, band: NumberLike = "0.02") -> Enclosure:
        """Return the time after which the response stays within a band about the final value.

        Parameters
        ----------
        band : number
            Half its width, as a fraction of the final value.

        Raises
        ------
        InputError, NoSolutionError
            As :meth:`overshoot`.

        Examples
        --------
        >>> from compensator_theory import step_response
        >>> step_response("1/(2*s + 1)").settling_time()  # 2 log(50)
        7.824046010854 ± 3.6e-12
        """
        width = _fraction(band, "band")
        late = self.delay
        if not late.is_Rational:
            raise InputError(f"the settling time needs a number for {late}; give it by subs(...)")
        settled = self._searched(lambda error: error.settled(width), "the settling time")
        return Enclosure(settled.centre + late, settled.radius)

    def rise_time(self, start: NumberLike = "0.1", end: NumberLike = "0.9") -> Enclosure:
        """Return the time from the first crossing of one fraction of the final value to another.

        Parameters
        ----------
        start, end : number
            Fractions of the final value, between 0 and 1.

        Raises
        ------
        InputError, NoSolutionError
            As :meth:`overshoot`.

        Examples
        --------
        >>> from compensator_theory import step_response
        >>> step_response("1/(s + 1)").rise_time()  # log(9)
        2.197224577336 ± 3.6e-12
        """
        low, high = _fraction(start, "start"), _fraction(end, "end")
        if not low < high:
            raise InputError(f"start = {low} must be less than end = {high}")
        return self._searched(lambda error: error.rise(low, high), "the rise time")

    def _searched(self, search: Callable[[_Error], Enclosure | None], subject: str) -> Enclosure:
        final = self.final_value
        parts = [p for mode in self.terms for p in (mode.factor, *mode.coefficients)]
        if not all(map(is_rational, parts)):
            raise InputError(f"{subject} needs rational coefficients; give values by subs(...)")
        if final == 0:
            raise InputError(f"{subject} is a fraction of the final value, which is 0")
        unit = Poly([1, -1] if self.is_discrete else [1, 0], self.terms[0].factor.gen, domain="QQ")
        others = [mode for mode in self.terms if mode.factor != unit]

        def exact(step: int) -> Expr:
            return self(step) / final - 1

        def attempt(bits: int) -> Enclosure | None:
            if self.is_discrete:
                return search(_Samples(others, final, bits, exact))
            return search(_Signal(others, final, bits))

        return at_growing_precision(attempt, 128, subject)


class _Error:
    """The relative error y/y_final - 1 of a response, in balls."""

    def __init__(self, modes: Sequence[Mode], final: Expr, bits: int) -> None:
        """Read the modes that decay."""
        below = ball_of_number(final)
        self.terms: list[tuple[flint.acb, list[flint.acb]]] = []
        for mode in modes:
            polynomials = [flint.acb_poly(to_flint_polynomial(c)) for c in mode.coefficients]
            for root, _ in root_balls(mode.factor, bits):
                self.terms.append((root, [c(root) / below for c in polynomials]))

    def largest(self, sign: int) -> Enclosure | None:
        """Enclose the largest error, or the largest of -1 - error; None at too low a precision."""
        raise NotImplementedError

    def settled(self, band: Rational) -> Enclosure | None:
        """Enclose the time after which the modulus of the error is at most the band."""
        raise NotImplementedError

    def rise(self, low: Rational, high: Rational) -> Enclosure | None:
        """Enclose the time between the first crossings of two fractions."""
        raise NotImplementedError


class _Signal(_Error):
    """The deviation from the final value in continuous time."""

    def value(self, t: flint.arb) -> flint.arb:
        """Return the error at the times in a ball."""
        total = flint.arb(0)
        for root, coefficients in self.terms:
            total += (_horner(coefficients, t) * (root * t).exp()).real
        return total

    def slope(self, t: flint.arb) -> flint.arb:
        """Return the derivative of the error at the times in a ball."""
        total = flint.arb(0)
        for root, coefficients in self.terms:
            following = [*coefficients[1:], flint.acb(0)]
            derived = [root * c + d for c, d in zip(coefficients, following, strict=True)]
            total += (_horner(derived, t) * (root * t).exp()).real
        return total

    def over(self, a: float, b: float) -> flint.arb:
        """Return a ball of the errors from a to b, by the mean value theorem."""
        if a == b:
            return self.value(flint.arb(a))
        box, middle = flint.arb(a).union(flint.arb(b)), flint.arb((a + b) / 2)
        return self.value(middle) + self.slope(box) * (box - middle)

    def horizon(self, limit: flint.arb) -> float:
        """Return a time after which the modulus of the error is less than a limit."""
        for exponent in range(-LONGEST, LONGEST):
            time = 2.0**exponent
            if self._is_bounded(flint.arb(time), limit):
                return time
        raise BudgetError(f"the response does not settle within 2**{LONGEST} s; scale the time")

    def _is_bounded(self, t: flint.arb, limit: flint.arb) -> bool:
        total = flint.arb(0)
        for root, coefficients in self.terms:
            rate = -root.real
            for j, c in enumerate(coefficients):
                if not t * rate >= j:  # else t**j exp(-rate t) decreases from here on
                    return False
                total += abs(c) * t**j / math.factorial(j) * (-rate * t).exp()
        return bool(total < limit)

    def _is_accurate(self, horizon: float) -> bool:
        error = max(float(self.value(flint.arb(t)).rad()) for t in (0.0, horizon / 7, horizon))
        return error < 2.0**-ACCURATE

    def settled(self, band: Rational) -> Enclosure | None:
        limit = ball_of_number(band)
        horizon = self.horizon(limit)
        if not self._is_accurate(horizon):
            return None
        ends = self._crossing(lambda e: _exceeds(abs(e), limit), horizon, is_backward=True)
        return _between(0.0, 0.0) if ends is None else _between(*ends)

    def rise(self, low: Rational, high: Rational) -> Enclosure | None:
        horizon = self.horizon(ball_of_number(1 - high))
        if not self._is_accurate(horizon):
            return None
        crossings = []
        for level in (low, high):
            limit = ball_of_number(level - 1)
            ends = self._crossing(partial(_exceeds, limit=limit), horizon, is_backward=False)
            crossings.append(_between(*(ends or (horizon, horizon))))
        first, second = crossings
        return Enclosure(second.centre - first.centre, second.radius + first.radius)

    def _crossing(
        self, condition: Condition, horizon: float, *, is_backward: bool
    ) -> tuple[float, float] | None:
        """Enclose the first or last time at which a condition holds; None if it never does."""
        boxes, smallest = [(0.0, horizon)], horizon * 2.0**-BITS
        for _ in range(MOST_BOXES):
            if not boxes:
                return None
            a, b = boxes.pop()
            holds = condition(self.over(a, b))
            if holds is False:
                continue
            outer, inner = (b, a) if is_backward else (a, b)
            if holds:
                return outer, outer
            if b - a <= smallest:
                inner = self._fulfilled(condition, inner, b - a, horizon, is_backward)
                return min(outer, inner), max(outer, inner)
            middle = (a + b) / 2
            halves = [(a, middle), (middle, b)]
            boxes += halves if is_backward else halves[::-1]
        raise BudgetError(
            f"the response crosses the band too often for {MOST_BOXES} intervals; widen the band"
        )

    def _fulfilled(
        self, condition: Condition, start: float, width: float, horizon: float, is_backward: bool
    ) -> float:
        """Return a time near the end of a box at which a condition holds for certain."""
        for exponent in range(BITS + 1):
            time = start + (-width if is_backward else width) * (2.0**exponent - 1)
            if not 0 <= time <= horizon:
                break
            if condition(self.over(time, time)):
                return time
        return 0.0 if is_backward else horizon

    def largest(self, sign: int) -> Enclosure | None:
        tolerance = flint.arb(2.0**-BITS)
        horizon = self.horizon(tolerance)
        if not self._is_accurate(horizon):
            return None

        def signed(error: flint.arb) -> flint.arb:
            return error if sign > 0 else -1 - error

        lower, upper = 0.0, 2.0**-BITS if sign > 0 else 0.0  # beyond the horizon
        boxes: list[tuple[float, float, float]] = [(-math.inf, 0.0, horizon)]
        for _ in range(MOST_BOXES):
            if not boxes or -boxes[0][0] <= lower + 2.0**-BITS:
                return _excess(lower, max([upper, *(-box[0] for box in boxes)]))
            a, b = heappop(boxes)[1:]
            slope = self.slope(flint.arb(a).union(flint.arb(b)))
            is_monotone = bool(slope > 0 or slope < 0)
            points = (a, b) if is_monotone else ((a + b) / 2,)
            for point in points:
                ball = signed(self.value(flint.arb(point)))
                lower = max(lower, _rounded(ball, -1))
                upper = max(upper, _rounded(ball, 1)) if is_monotone else upper
            if is_monotone:
                continue
            middle = (a + b) / 2
            for low, high in ((a, middle), (middle, b)):
                heappush(boxes, (-_rounded(signed(self.over(low, high)), 1), low, high))
        raise BudgetError(f"the response has too many extrema for {MOST_BOXES} intervals")


class _Samples(_Error):
    """The deviation from the final value in discrete time, which may equal a limit exactly."""

    def __init__(
        self, modes: Sequence[Mode], final: Expr, bits: int, exact: Callable[[int], Expr]
    ) -> None:
        """Read the modes that decay, and the function that returns the error at a step exactly."""
        super().__init__(modes, final, bits)
        self.exact = exact

    def _is_above(self, k: int, limit: Rational, *, or_equal: bool) -> bool | None:
        """Whether the error at a step exceeds a limit; where balls do not decide, exactly."""
        above = _exceeds(self.value(k), ball_of_number(limit))
        if above is None and (error := self.exact(k)).is_Rational:
            return bool(error >= limit if or_equal else error > limit)
        return above

    def _is_outside(self, k: int, band: Rational) -> bool | None:
        above = self._is_above(k, band, or_equal=False)
        inside = self._is_above(k, -band, or_equal=True)
        return None if above is None or inside is None else above or not inside

    def settled(self, band: Rational) -> Enclosure | None:
        limit = ball_of_number(band)
        last = -1
        for k in range(self._steps(limit), -1, -1):
            outside = self._is_outside(k, band)
            if outside is None:
                return None
            if outside:
                last = k
                break
        return Enclosure(sympy.Integer(last + 1), sympy.Integer(0))

    def rise(self, low: Rational, high: Rational) -> Enclosure | None:
        steps = self._steps(ball_of_number(1 - high))
        crossings = []
        for level in (low, high):
            for k in range(steps + 1):
                reached = self._is_above(k, level - 1, or_equal=True)
                if reached is None:
                    return None
                if reached:
                    crossings.append(k)
                    break
        return Enclosure(sympy.Integer(crossings[1] - crossings[0]), sympy.Integer(0))

    def largest(self, sign: int) -> Enclosure | None:
        steps = self._steps(flint.arb(2.0**-BITS))
        values = [self.value(k) if sign > 0 else -1 - self.value(k) for k in range(steps + 1)]
        if max(float(value.rad()) for value in values) > 2.0**-ACCURATE:
            return None
        lower = max(0.0, *(_rounded(value, -1) for value in values))
        upper = max(2.0**-BITS if sign > 0 else 0.0, *(_rounded(value, 1) for value in values))
        return _excess(lower, upper)

    def value(self, k: int) -> flint.arb:
        """Return the error at a step."""
        total = flint.arb(0)
        for root, coefficients in self.terms:
            for j, c in enumerate(coefficients):
                if k >= j:
                    total += (c * math.comb(k, j) * root ** (k - j)).real
        return total

    def _steps(self, limit: flint.arb) -> int:
        """Return a step after which the modulus of the error is less than a limit."""
        for exponent in range(3, MOST_STEPS.bit_length()):
            if self._is_bounded(2**exponent, limit):
                return int(2**exponent)
        raise BudgetError(
            f"the response has not settled after {MOST_STEPS} steps; sample it less often"
        )

    def _is_bounded(self, k: int, limit: flint.arb) -> bool:
        total = flint.arb(0)
        for root, coefficients in self.terms:
            modulus = abs(root)
            for j, c in enumerate(coefficients):
                if k < j or not (k + 1) * modulus <= k + 1 - j:  # else it decreases from here on
                    return False
                total += abs(c) * math.comb(k, j) * modulus ** (k - j)
        return bool(total < limit)


def _horner(coefficients: list[flint.acb], t: flint.arb) -> flint.acb:
    """Return the sum of c_j t^(j-1)/(j-1)!."""
    total = flint.acb(0)
    for j in range(len(coefficients) - 1, -1, -1):
        total = coefficients[j] + total * t / (j + 1)
    return total


def _exceeds(value: flint.arb, limit: flint.arb) -> bool | None:
    return True if value > limit else False if value < limit else None


def _rounded(ball: flint.arb, direction: int) -> float:
    """Return a float beyond the ball."""
    exact = ball.upper() if direction > 0 else ball.lower()
    end = float(exact)
    return end if (end - exact) * direction >= 0 else math.nextafter(end, direction * math.inf)


def _between(low: float, high: float) -> Enclosure:
    first, last = Rational(low), Rational(high)
    return Enclosure((first + last) / 2, (last - first) / 2)


def _excess(low: float, high: float) -> Enclosure:
    """Enclose a number that is not negative; about 0 where it may be 0."""
    if low > 0:
        return _between(low, max(low, high))
    return Enclosure(sympy.Integer(0), Rational(max(low, high)))


def _fraction(value: NumberLike, name: str) -> Rational:
    number = exact_number(value)
    if not (number.is_Rational and 0 < number < 1):
        raise InputError(f"{name} = {number} must be a rational number between 0 and 1")
    return number
