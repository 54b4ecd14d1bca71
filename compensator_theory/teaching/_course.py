"""The exercises of the course in exact control: ten steps, three exercises each.

A truth is computed independently of what an answer would call: ranks, determinants, root counts.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations, pairwise
from types import MappingProxyType
from typing import Any

import sympy
from sympy import Expr, ImmutableMatrix, Integer, Poly, Rational, Symbol, exp, sqrt

from compensator_theory import strategies
from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from compensator_theory.loops._feedback import feedback_connection
from compensator_theory.observers._questions import pair_is_observer_based
from compensator_theory.polynomials._reading import polynomial
from compensator_theory.roots._counts import count_roots
from compensator_theory.stability._delays import stability_delays
from compensator_theory.stability._strong_stabilisability import decide_strong_stabilisability
from compensator_theory.systems._dead_times import transfer_function
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.teaching._answers import written
from compensator_theory.teaching._exercises import Exercise, claim_exercise, function_exercise

_S, _Q = Symbol("s"), Symbol("q")


def course_exercises() -> MappingProxyType[str, Exercise]:
    """Return the exercises of the course by number, "1.1" to "10.3".

    Raises
    ------
    InputError
        If Hypothesis, which draws the cases, is not installed.

    Examples
    --------
    >>> from compensator_theory.teaching import course_exercises
    >>> exercises = course_exercises()
    >>> len(exercises)
    30
    >>> print(exercises["6.1"].question)
    For which k is the loop of k/(s (s + 1)(s + 2)) with u = -y stable? Write is_stable(k).
    """
    require_library("hypothesis")
    return _exercises()


@cache
def _exercises() -> MappingProxyType[str, Exercise]:
    steps = (
        _systems, _common_roots, _placement, _states_and_observers, _inside_a_compensator,
        _gains_and_delays, _all_compensators, _optimal_compensators, _sampling, _adaptive_control,
    )  # fmt: skip
    numbered = {
        f"{step}.{number}": exercise
        for step, make in enumerate(steps, 1)
        for number, exercise in enumerate(make(), 1)
    }
    return MappingProxyType(numbered)


def _systems() -> tuple[Exercise, ...]:
    """Step 1: hidden modes, and the final value."""
    from hypothesis import strategies as st

    small = st.integers(-2, 2)
    two = {
        "A": _matrices(2, 2, small),
        "B": _matrices(2, 1, small),
        "C": _matrices(1, 2, small),
    }

    def has_hidden_mode(A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix) -> bool:
        return bool((B.row_join(A * B)).rank() < 2 or (C.col_join(C * A)).rank() < 2)

    def final_value(G: TransferFunction) -> Expr | None:
        n = G.denominator.degree()
        if count_roots(G.denominator).stable < n:
            return None
        return Rational(G.numerator.eval(0), G.denominator.eval(0))

    def objection(A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix) -> str | None:
        A, B, C = map(ImmutableMatrix, (A, B, C))
        system = Realisation(A, B, C, variable="s")
        visible = system.transfer_function().reduced()
        if visible.numerator.is_zero:
            return None
        if _is_stable(visible.denominator) and not _is_stable(A.charpoly(_S)):
            return (
                f"the transfer function {written(visible)} is stable, and the eigenvalues of A, "
                f"roots of {written(A.charpoly(_S))}, are not"
            )
        return None

    return (
        function_exercise(
            "Has (A, B, C) of order 2 a mode that its transfer function hides? Write "
            "has_hidden_mode(A, B, C).",
            two,
            has_hidden_mode,
            subject="right answer, from the ranks of (B, AB) and (C, CA),",
        ),
        function_exercise(
            "To which value does the unit step response of a strictly proper plant converge? "
            "Write final_value(G), None where it does not converge.",
            {"G": strategies.strictly_proper_plants(max_order=2)},
            final_value,
            subject="final value",
        ),
        claim_exercise(
            "If the transfer function of (A, B, C) is stable and not zero, then A is stable.",
            two,
            objection,
            is_true=False,
        ),
    )


def _common_roots() -> tuple[Exercise, ...]:
    """Step 2: Sylvester's matrix."""
    from hypothesis import strategies as st

    small = st.integers(-4, 4)
    nonconstant = strategies.polynomials(min_degree=1, max_degree=3)

    def resultant(a: Poly, b: Poly) -> Expr:
        # b at the companion matrix of a: no Sylvester matrix.
        n, coefficients = a.degree(), a.monic().all_coeffs()
        companion = ImmutableMatrix(n, n, lambda i, j: Integer(j == i + 1))
        companion += ImmutableMatrix(n, n, lambda i, j: -coefficients[n - j] if i == n - 1 else 0)
        value = ImmutableMatrix.zeros(n, n)
        for coefficient in b.all_coeffs():
            value = value * companion + coefficient * ImmutableMatrix.eye(n)
        return a.LC() ** b.degree() * value.det()

    def objection(a: Poly, b: Poly) -> str | None:
        a, b = polynomial(a, "s"), polynomial(b, "s")
        if a.gcd(b).degree() > 0:
            raise InputError(f"a and b must be coprime; they share {a.gcd(b).as_expr()}")
        common = (a * b).gcd(a + b)
        return f"a b and a + b share {common.as_expr()}" if common.degree() > 0 else None

    return (
        function_exercise(
            "The determinant of Sylvester's matrix of a and b, the coefficients of a in the first "
            "deg b rows. Write resultant(a, b).",
            {"a": nonconstant, "b": nonconstant},
            resultant,
            subject="resultant",
        ),
        function_exercise(
            "For which b_0 and b_1 have s^2 + s and b_1 s + b_0 a common root? Write "
            "meets(b_0, b_1).",
            {"b_0": small, "b_1": small},
            lambda b_0, b_1: Poly(_S**2 + _S, _S).gcd(Poly([b_1, b_0], _S)).degree() > 0,
            subject="right answer",
        ),
        claim_exercise(
            "If a and b are coprime, so are a b and a + b.",
            {"a, b": strategies.coprime_pairs(max_degree=3)},
            objection,
            is_true=True,
        ),
    )


def _placement() -> tuple[Exercise, ...]:
    """Step 3: pole placement."""
    from hypothesis import strategies as st

    numbers, nonzero = st.integers(-4, 4), st.integers(1, 4) | st.integers(-4, -1)

    def order(n: int, is_strictly_proper: bool) -> int:
        """The least order for which unknowns are no fewer than equations."""
        n_c = 0
        while 2 * n_c + (0 if is_strictly_proper else 1) < n + n_c:
            n_c += 1
        return n_c

    return (
        Exercise(
            "Give the loop of 1/(s^2 + s) the closed-loop polynomial (s + 1)^3 by a compensator "
            "of order 1 with u = -G_c y.",
            _loop_fault("1/(s**2 + s)", "(s + 1)**3"),
        ),
        function_exercise(
            "Which gain k gives the loop of b/(s + a) with u = -k y the pole -p? Write "
            "gain(a, b, p).",
            {"a": numbers, "b": nonzero, "p": numbers},
            lambda a, b, p: Rational(p - a, b),
            subject="gain",
        ),
        function_exercise(
            "Which least order of a compensator lets every closed-loop polynomial be placed for "
            "every coprime, strictly proper plant of order n? Write order(n, is_strictly_proper), "
            "where the compensator is to be strictly proper or may have a direct term.",
            {"n": st.integers(1, 8), "is_strictly_proper": st.booleans()},
            order,
            subject="least order",
        ),
    )


def _states_and_observers() -> tuple[Exercise, ...]:
    """Step 4: state feedback and observers."""
    from hypothesis import strategies as st

    small = st.integers(-2, 2)
    companion = st.tuples(small, small).map(lambda a: ImmutableMatrix([[0, 1], [-a[0], -a[1]]]))
    b = st.sampled_from(
        [ImmutableMatrix([0, 1]), ImmutableMatrix([0, 2]), ImmutableMatrix([0, -1])]
    )
    target = st.tuples(small, small).map(lambda c: Poly([1, c[1], c[0]], _S))

    def gain_fault(answer: Any, A: ImmutableMatrix, B: ImmutableMatrix, p: Poly) -> str | None:
        K = _matrix(answer(A, B, p), (1, 2), "K")
        loop = (A + B * K).charpoly(_S)
        if _are_equal(loop, p):
            return None
        return (
            f"your K = {written(K)} gives A + B K the characteristic polynomial {written(loop)}, "
            f"not {written(p)}"
        )

    def observer_fault(answer: Any) -> str | None:
        A, C = ImmutableMatrix([[0, 1], [0, -1]]), ImmutableMatrix([[1, 0]])
        F = _matrix(answer, (2, 1), "F")
        error, target = (A - F * C).charpoly(_S), Poly((_S + 3) * (_S + 4), _S)
        if _are_equal(error, target):
            return None
        return f"the error obeys A - F C with {written(error)}, not {written(target)}"

    def objection(
        A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix, K: ImmutableMatrix,
        F: ImmutableMatrix,
    ) -> str | None:  # fmt: skip
        A, B, C, K, F = map(ImmutableMatrix, (A, B, C, K, F))
        loop = ImmutableMatrix.vstack(
            ImmutableMatrix.hstack(A, B * K), ImmutableMatrix.hstack(F * C, A + B * K - F * C)
        ).charpoly(_S)
        parts = (A + B * K).charpoly(_S) * (A - F * C).charpoly(_S)
        if _are_equal(loop, parts):
            return None
        return f"the loop has {written(loop)}, the designs {written(parts)}"

    return (
        Exercise(
            "Which K gives A + B K the characteristic polynomial p? Write gain(A, B, p) for "
            "controllable (A, B) of order 2 with one input.",
            gain_fault,
            {"A": companion, "B": b, "p": target},
        ),
        Exercise(
            "Give the error of the observer of the motor, A = [[0, 1], [0, -1]] and C = [[1, 0]], "
            "the poles -3 and -4: the matrix F of A - F C.",
            observer_fault,
        ),
        claim_exercise(
            "The loop of (A, B, C) with the observer-based compensator A + B K - F C, F, K has "
            "the eigenvalues of A + B K and of A - F C.",
            {
                "A": _matrices(2, 2, small), "B": _matrices(2, 1, small),
                "C": _matrices(1, 2, small), "K": _matrices(1, 2, small),
                "F": _matrices(2, 1, small),
            },
            objection,
            is_true=True,
        ),
    )  # fmt: skip


def _inside_a_compensator() -> tuple[Exercise, ...]:
    """Step 5: observer forms."""
    from hypothesis import strategies as st

    numbers = st.integers(0, 3)
    counts = st.tuples(numbers, numbers).map(lambda c: (2 * c[0], c[1])).filter(sum)

    def number_of_forms(real: int, pairs: int) -> int:
        sizes = [1] * real + [2] * pairs
        half = (real + 2 * pairs) // 2
        return sum(
            sum(part) == half
            for number in range(len(sizes) + 1)
            for part in combinations(sizes, number)
        )

    def objection(real: int, pairs: int) -> str | None:
        if real % 2 or min(real, pairs) < 0:
            raise InputError("a polynomial of even degree has an even number of real roots")
        if number_of_forms(real, pairs):
            return None
        n = real // 2 + pairs
        return f"the degree is {2 * n}, and no real factor has the odd degree {n}"

    def design_fault(answer: Any) -> str | None:
        servo = transfer_function("1/(s**3 + s)")
        compensator = transfer_function(answer, "s").reduced()
        if compensator.order != 3 or not compensator.is_strictly_proper:
            return f"the compensator {written(compensator)} must be strictly proper of order 3"
        loop = _loop(servo, compensator)
        if not _is_stable(loop):
            return (
                f"the loop is not stable: {written(loop)} has "
                f"{loop.degree() - count_roots(loop).stable} roots that are not"
            )
        decision = pair_is_observer_based(servo, compensator, feedback=-1)
        if not decision:
            return None
        real = _count_real_roots(loop)
        return (
            f"the compensator is observer-based: the closed-loop polynomial {written(loop)} has "
            f"{real} real roots, so that a real regulator of degree 3 divides it"
        )

    return (
        function_exercise(
            "A loop of a plant and a compensator of order n has 2n simple poles, so many real ones "
            "and so many conjugate pairs. How many real regulators of degree n divide its "
            "polynomial? Write number_of_forms(real, pairs).",
            {"real, pairs": counts},
            number_of_forms,
            subject="number of real divisors of half the degree",
        ),
        claim_exercise(
            "A real polynomial of even degree, with so many real roots and so many conjugate "
            "pairs, all simple, has a real divisor of half its degree.",
            {"real, pairs": counts},
            objection,
            is_true=False,
        ),
        Exercise(
            "Give a strictly proper compensator of order 3 that stabilises 1/(s^3 + s) with "
            "u = -G_c y and is not observer-based.",
            design_fault,
        ),
    )


def _gains_and_delays() -> tuple[Exercise, ...]:
    """Step 6: ranges of gains, regions, delays."""
    from hypothesis import strategies as st

    small = st.integers(-4, 12)
    quarters = st.integers(0, 12).map(lambda k: Rational(k, 4))
    delays = stability_delays(["s**2 + s", "1"])

    def stands(tau: Expr) -> bool:
        return tau == 0 or delays.unstable_roots(tau) == 0

    return (
        function_exercise(
            "For which k is the loop of k/(s (s + 1)(s + 2)) with u = -y stable? Write "
            "is_stable(k).",
            {"k": small},
            lambda k: _is_stable(Poly([1, 3, 2, k], _S)),
            subject="stability of the loop",
        ),
        function_exercise(
            "For which k_0 and k_1 is s^3 + 2 s^2 + k_1 s + k_0 a stable polynomial? Write "
            "is_stable(k_0, k_1).",
            {"k_0": small, "k_1": small},
            lambda k_0, k_1: _is_stable(Poly([1, 2, k_1, k_0], _S)),
            subject="stability of the polynomial",
        ),
        function_exercise(
            "Which dead times tau >= 0 does the loop of 1/(s^2 + s) with u(t) = -y(t - tau) stand? "
            "Write stands(tau).",
            {"tau": quarters},
            stands,
            subject="stability of the loop with this delay",
        ),
    )


def _all_compensators() -> tuple[Exercise, ...]:
    """Step 7: Youla and Kucera, strong stabilisability."""
    from hypothesis import strategies as st

    stable = st.tuples(st.integers(1, 3), st.integers(1, 3)).map(
        lambda c: transfer_function(f"{c[0]}/(s + {c[1]})")
    )
    lists = st.lists(st.integers(1, 4), max_size=3, unique=True).map(lambda r: tuple(sorted(r)))

    def fault(answer: Any, G: TransferFunction, Q: TransferFunction) -> str | None:
        C = transfer_function(answer(G, Q), "s")
        loop = G * C
        if (loop + 1).numerator.is_zero:
            return f"your compensator is {written(C)}, with which 1 + G C = 0"
        T = (loop / (loop + 1)).reduced()
        if (T - G * Q).numerator.is_zero:
            return None
        return (
            f"your compensator is {written(C.reduced())}; the loop maps r to y by {written(T)}, "
            f"not by G Q = {written((G * Q).reduced())}"
        )

    def can_be_stable(zeros: tuple[int, ...], poles: tuple[int, ...]) -> bool:
        # Between neighbouring real unstable zeros, infinity among them, an even number of poles.
        ends = [*zeros, 10**6]
        return all(sum(a < p < b for p in poles) % 2 == 0 for a, b in pairwise(ends))

    def objection(G: TransferFunction) -> str | None:
        G = transfer_function(G, "s")
        decision = decide_strong_stabilisability(G)
        if decision:
            return None
        return " ".join(str(decision).split())

    zeros_and_poles = st.tuples(lists, lists).map(
        lambda r: (r[0], tuple(p for p in r[1] if p not in r[0]))
    )
    return (
        Exercise(
            "For a stable plant G and a stable Q, which compensator C gives G C/(1 + G C) = G Q? "
            "Write compensator(G, Q).",
            fault,
            {"G": stable, "Q": stable},
        ),
        function_exercise(
            "A strictly proper plant has so many real zeros and poles in the right half plane, "
            "all simple and different. Does a stable compensator stabilise it? Write "
            "can_be_stable(zeros, poles).",
            {"zeros, poles": zeros_and_poles},
            can_be_stable,
            subject="right answer, by parity interlacing,",
        ),
        claim_exercise(
            "Every strictly proper plant is stabilised by a stable compensator.",
            {"G": strategies.strictly_proper_plants(max_order=2)},
            objection,
            is_true=False,
        ),
    )


def _optimal_compensators() -> tuple[Exercise, ...]:
    """Step 8: Riccati equations."""
    from hypothesis import strategies as st

    numbers, positive = st.integers(-3, 3), st.integers(1, 4)
    nonzero = positive | st.integers(-4, -1)
    nonnegative = st.integers(0, 4)

    def riccati_fault(answer: Any) -> str | None:
        A, B = ImmutableMatrix([[0, 1], [0, 0]]), ImmutableMatrix([0, 1])
        P = _matrix(answer, (2, 2), "P")
        residual = (A.T * P + P * A - P * B * B.T * P + ImmutableMatrix.eye(2)).applyfunc(
            sympy.simplify
        )
        if not residual.is_zero_matrix:
            return f"A' P + P A - P B B' P + I = {written(residual)}, not zero"
        loop = (A - B * B.T * P).charpoly(_S)
        if all(c.is_positive for c in loop.all_coeffs()):
            return None
        return (
            f"P solves the equation and does not stabilise: the loop has {written(loop)}; another "
            "solution does"
        )

    def objection(a: int, q: int) -> str | None:
        pole = a - (a + sqrt(Integer(a) ** 2 + q)) / 2
        if pole < 0:
            return None
        return f"the pole of the loop with half the optimal gain is {written(pole)}"

    return (
        function_exercise(
            "Where is the pole of the optimal loop of x' = a x + b u with the cost of "
            "q x^2 + r u^2? Write pole(a, b, q, r).",
            {"a": numbers, "b": nonzero, "q": positive, "r": positive},
            lambda a, b, q, r: -sqrt(a**2 + Rational(b**2 * q, r)),
            subject="pole of the optimal loop",
        ),
        Exercise(
            "Solve A' P + P A - P B B' P + I = 0 for the double integrator, A = [[0, 1], [0, 0]] "
            "and B = [[0], [1]]: the P that stabilises.",
            riccati_fault,
        ),
        claim_exercise(
            "The optimal loop of x' = a x + u with the cost of q x^2 + u^2, q >= 0, stays stable "
            "if the gain is halved.",
            {"a": st.integers(-3, 3).filter(bool), "q": nonnegative},
            objection,
            is_true=False,
        ),
    )


def _sampling() -> tuple[Exercise, ...]:
    """Step 9: zero-order hold."""
    from hypothesis import strategies as st

    numbers, steps = st.integers(-3, 3), st.integers(1, 4)

    def sampled(a: int, h: int) -> tuple[Expr, Expr]:
        gain = (1 - exp(-a * h)) / a if a else Integer(h)
        return gain, exp(-a * Integer(h))

    def objection(k: int) -> str | None:
        h = sympy.pi * k / 4
        A = ImmutableMatrix([[sympy.cos(h), sympy.sin(h)], [-sympy.sin(h), sympy.cos(h)]])
        B = ImmutableMatrix([1 - sympy.cos(h), sympy.sin(h)])
        if sympy.simplify(B.row_join(A * B).det()) != 0:
            return None
        return f"with h = {written(h)} the rank of (B, AB) of the sampled oscillator is below 2"

    def is_stable(k: int) -> bool:
        # s + k behind a hold with step log(2): the pole of the loop is 1/2 - k/2.
        pole = Rational(1, 2) - Rational(k, 2)
        return bool(abs(pole) < 1)

    return (
        function_exercise(
            "The plant 1/(s + a) behind a zero-order hold of step h is g/(z - p). Write "
            "sampled(a, h), which returns (g, p).",
            {"a": numbers, "h": steps},
            sampled,
            subject="pair (g, p)",
        ),
        function_exercise(
            "The plant 1/(s + 1) behind a zero-order hold of step log(2) is in a loop with "
            "u = -k y. For which k is the loop stable? Write is_stable(k).",
            {"k": st.integers(-4, 6)},
            is_stable,
            subject="stability of the sampled loop",
        ),
        claim_exercise(
            "The oscillator 1/(s^2 + 1), sampled with a zero-order hold of step h = k pi/4, is "
            "controllable for each k = 1, 2, 3, ...",
            {"k": st.integers(1, 12)},
            objection,
            is_true=False,
        ),
    )


def _adaptive_control() -> tuple[Exercise, ...]:
    """Step 10: the intercalated transfer function, with positive feedback as in chapter 4."""
    from hypothesis import strategies as st

    small = st.integers(-2, 2)
    plants = strategies.strictly_proper_plants("q", max_order=2)
    compensators = st.tuples(small, small, small).map(
        lambda c: TransferFunction(Poly([c[0], c[1]], _Q), Poly([1, c[2]], _Q))
    )

    def intercalated(G: TransferFunction, C: TransferFunction) -> TransferFunction:
        chi = G.denominator * C.denominator - G.numerator * C.numerator
        return TransferFunction(G.numerator * Poly(_Q ** C.denominator.degree(), _Q), chi)

    def objection(G: TransferFunction, C: TransferFunction) -> str | None:
        G, C = transfer_function(G, "q"), transfer_function(C, "q")
        zeros = intercalated(G, C).reduced().numerator
        allowed = G.numerator * Poly(_Q ** C.denominator.degree(), _Q)
        return None if allowed.rem(zeros).is_zero else f"it has the zeros of {written(zeros)}"

    def deadbeat_fault(answer: Any) -> str | None:
        G = transfer_function("(q - 1/2)/((q - 1)*(q - 2))")
        C = transfer_function(answer, "q")
        if C.denominator.degree() != 1:
            return f"the compensator {written(C)} must have order 1"
        C = TransferFunction(C.numerator, C.denominator).reduced()
        chi = (G.denominator * C.denominator - G.numerator * C.numerator).monic()
        if _are_equal(chi, Poly(_Q**3, _Q)):
            return None
        return f"the closed-loop polynomial with u = G_c y is {written(chi)}, not q**3"

    return (
        function_exercise(
            "The intercalated transfer function of a plant G and a compensator C with u = C y. "
            "Write intercalated(G, C), with the numerators and denominators of both.",
            {"G": plants, "C": compensators},
            intercalated,
            subject="intercalated transfer function",
        ),
        Exercise(
            "Give the loop of (q - 1/2)/((q - 1)(q - 2)) with u = G_c y three poles at 0 by a "
            "compensator of order 1.",
            deadbeat_fault,
        ),
        claim_exercise(
            "Each zero of the intercalated transfer function is 0 or a zero of the plant.",
            {"G": plants, "C": compensators},
            objection,
            is_true=True,
        ),
    )


def _matrices(rows: int, columns: int, elements: Any) -> Any:
    """Matrices whose least case is zero."""
    from hypothesis import strategies as st

    row = st.lists(elements, min_size=columns, max_size=columns)
    return st.lists(row, min_size=rows, max_size=rows).map(ImmutableMatrix)


def _matrix(answer: Any, shape: tuple[int, int], name: str) -> ImmutableMatrix:
    """Read a matrix of this shape."""
    if isinstance(answer, int | Expr):
        answer = [[answer]]
    matrix = ImmutableMatrix(answer)
    if matrix.shape != shape:
        raise InputError(
            f"{name} must be {shape[0]} x {shape[1]}, not {matrix.shape[0]} x {matrix.shape[1]}"
        )
    return matrix


def _are_equal(p: Poly, q: Poly) -> bool:
    return bool((Poly(p, p.gen) - Poly(q, q.gen)).is_zero)


def _is_stable(p: Poly) -> bool:
    return bool(count_roots(p, time="continuous").stable == p.degree())


def _count_real_roots(p: Poly) -> int:
    """The number of distinct real roots."""
    return int(p.count_roots())


def _loop(plant: TransferFunction, compensator: TransferFunction) -> Poly:
    return feedback_connection(plant, compensator, feedback=-1).denominator.monic()


def _loop_fault(plant: str, target: str) -> Callable[[Any], str | None]:
    """The fault of a compensator whose loop must have a polynomial."""

    def fault(answer: Any) -> str | None:
        compensator = transfer_function(answer, "s")
        goal = polynomial(target, "s")
        loop = _loop(transfer_function(plant, "s"), compensator)
        if _are_equal(loop, goal):
            return None
        return f"the closed-loop polynomial is {written(loop)}, not {written(goal)}"

    return fault
