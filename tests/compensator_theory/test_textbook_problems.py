"""Textbook problems with answers that were worked without us: textbook_problems.toml."""

import tomllib
from pathlib import Path

import pytest
import sympy
from sympy import Symbol, sympify

import compensator_theory as exact
from compensator_theory.results import Enclosure
from tests.support.exercises import equal

FILE = Path(__file__).parent / "textbook_problems.toml"
PROBLEMS = [
    (kind, problem)
    for kind, problems in tomllib.loads(FILE.read_text("utf-8")).items()
    for problem in problems
]
NAMES = {name: Symbol(name) for name in ("t", "k", "s", "z", "h", "S", "C", "L", "R", "N", "Q")}
POINTS = ("1/3", "1", "7/2"), (2, 3, 9)
"""Times, in continuous and in discrete time."""
DIGITS = 40


def read(text):
    """A formula as the file writes it, with its numbers exact."""
    return sympy.nsimplify(sympify(text, locals=NAMES), rational=True)


def is_zero_at(difference, points, variable):
    """Whether a difference vanishes at points, to 30 digits."""
    for point in points:
        value = sympy.N(difference.subs(variable, sympify(point)), DIGITS)
        if not abs(value) < 10 ** sympy.Integer(-30):
            return False
    return True


def same_function(answer, text, is_discrete, first=0):
    """Whether a closed form is that of the file, at points after its beginning."""
    answer = sympify(answer)
    variable = NAMES["k" if is_discrete else "t"]
    for symbol in answer.free_symbols:  # t of the package may be assumed real
        answer = answer.subs(symbol, variable)
    points = [point for point in POINTS[is_discrete] if sympify(point) >= first]
    return is_zero_at(answer - read(text), points, variable)


def close(answer, text):
    """Whether a certified or exact number is that of the file, given to 15 digits."""
    centre = answer.centre if isinstance(answer, Enclosure) else sympify(answer)
    radius = answer.radius if isinstance(answer, Enclosure) else 0
    expected = sympy.N(read(text), 20)
    return abs(sympy.N(centre, 20) - expected) <= radius + abs(expected) * sympy.Float("1e-12")


def step_response(G, y):
    result = exact.step_response(G)
    return same_function(result.expression, y, result.is_discrete) and result.is_verified


def impulse_response(G, y, first=0):
    result = exact.impulse_response(G)
    return same_function(result.expression, y, result.is_discrete, first) and result.is_verified


def time_response(G, U, y, says):
    result = exact.time_response(G, U)
    return same_function(result.expression, y, result.is_discrete) and result.is_verified


def delayed_step(G, y, delay):
    result = exact.step_response(G)
    shifted = result.expression
    variable = next(iter(shifted.free_symbols))
    difference = shifted.subs(variable, Symbol("t")) - read(y)
    return result.delay == delay and is_zero_at(difference, (delay + 1, delay + 4), Symbol("t"))


def overshoot(G, value):
    return close(exact.step_response(G).overshoot(), value)


def settling_time(G, value):
    return close(exact.step_response(G).settling_time(), value)


def rise_time(G, value):
    return close(exact.step_response(G).rise_time(), value)


def matrices_agree(answer, text, is_discrete):
    expected = sympy.Matrix(sympify(text, locals=NAMES))
    return answer.shape == expected.shape and all(
        same_function(entry, str(value), is_discrete)
        for entry, value in zip(answer, expected, strict=True)
    )


def transition_matrix(A, value):
    return matrices_agree(exact.transition_matrix(A, "s").expression, value, False)


def matrix_power(A, value):
    return matrices_agree(exact.transition_matrix(A, "z").expression, value, True)


def routh_array(p, counts):
    count = exact.routh_array(p).count
    return [count.stable, count.boundary, count.unstable] == counts


def jury_array(p, counts):
    count = exact.jury_array(p).count
    return [count.stable, count.boundary, count.unstable] == counts


def routh_conditions(p, conditions):
    answer = exact.routh_array(p, "s").conditions
    expected = [read(text) for text in conditions]
    return len(answer) == len(expected) and all(
        any((sympify(one) / other).expand().is_positive for other in expected) for one in answer
    )


def stabilising_gains(G, interval):
    answer = exact.stabilising_gains(G, feedback=-1).intervals
    if interval == "none":
        return answer == ()
    ends = [part.split(", ") for part in interval.strip("()").split(") (")]
    return len(answer) == len(ends) and all(
        equal(cell.lower, lower) and equal(cell.upper, upper)
        if "oo" not in lower + upper
        else (str(cell.lower) == lower or equal(cell.lower, lower))
        for cell, (lower, upper) in zip(answer, ends, strict=True)
    )


def pade(G, order, P):
    answer = exact.transfer_function(G).pade(order).as_expr()
    return sympy.cancel(answer - read(P)) == 0


def delay_margin(G, frequency, degrees, delay):
    margins = exact.stability_margins(G, feedback=-1)
    (crossing,) = margins.gain_crossovers
    return (
        close(crossing.frequency, frequency)
        and close(crossing.degrees, degrees)
        and close(margins.delay.value, delay)
    )


def gain_margin(G, frequency, gain):
    margins = exact.stability_margins(G, feedback=-1)
    answer = margins.gain_up
    return close(answer.value, gain) and close(answer.frequency, frequency)


def same_set(answer, expected):
    """Whether two lists of formulas agree at values of their symbols."""
    expected = [read(text) for text in expected]
    symbols = sorted(set().union(*(one.free_symbols for one in (*answer, *expected))), key=str)
    values = {symbol: sympy.Rational(number, 7) for number, symbol in enumerate(symbols, 3)}
    numbers = [sympy.N(one.subs(values), DIGITS) for one in answer]
    for one in expected:
        value = sympy.N(one.subs(values), DIGITS)
        near = [number for number in numbers if abs(number - value) < sympy.Float("1e-30")]
        if not near:
            return False
        numbers.remove(near[0])
    return not numbers


def poles_and_zeros(G, variable, poles, zeros):
    system = exact.transfer_function(G, variable)
    answer = [[sympify(root.value) for root in part for _ in range(root.multiplicity)]
             for part in (system.poles(), system.zeros())]  # fmt: skip
    return same_set(answer[0], poles) and same_set(answer[1], zeros)


def root_locus(G, centroid, breaks):
    locus = exact.root_locus(G, feedback=-1)
    answer = [(one.value, one.gain) for one in locus.breaks if sympy.N(one.gain) > 0]
    expected = [(sympy.N(read(point)), read(gain)) for point, gain in breaks]
    return (
        (centroid == "none" or equal(locus.centroid, centroid))
        and len(answer) == len(expected)
        and all(
            any(
                abs(value - complex(point)) < 1e-12 and close(gain, str(exact_gain))
                for point, exact_gain in expected
            )
            for value, gain in answer
        )
    )


def locus_crossing(G, gain, frequency):
    crossings = exact.root_locus(G, feedback=-1).crossings
    return any(
        equal(one.gain, gain) and close(one.frequency, frequency)
        for one in crossings
        if one.frequency != 0
    )


def place_poles(G, target, compensator):
    answer = exact.place_poles(G, target, feedback=-1).compensator
    return sympy.cancel(answer.as_expr() - read(compensator)) == 0


def regulator_gain(A, B, target, K):
    return equal(exact.regulator_gain(A, B, target), [[read(x) for x in row] for row in K])


def sampled(answer, text):
    difference = sympify(answer) - read(text)
    points = (sympy.Rational(5, 3), sympy.Rational(-7, 2))
    difference = difference.subs(NAMES["h"], sympy.Rational(3, 4))
    return all(abs(sympy.N(difference.subs(NAMES["z"], z), DIGITS)) < 1e-30 for z in points)


def zero_order_hold(G, step, H):
    answer = exact.sampling.zero_order_hold(G, sympify(step, locals=NAMES))
    system = answer.transfer_function
    values = dict(answer.exponentials)
    return sampled(system.as_expr().subs(values), H)


def tustin(G, step, H):
    return sampled(exact.sampling.tustin(G, step).transfer_function.as_expr(), H)


def response_at(G, U, times, values):
    result = exact.time_response(G, U)
    answer = [result.expression.subs(result.time, sympify(time)).evalf(25) for time in times]
    return all(
        abs(one - sympy.Float(value, 25)) < 1e-15 for one, value in zip(answer, values, strict=True)
    )


def vanishes(difference):
    """Whether an expression is zero where its symbols are different fractions."""
    symbols = sorted(sympify(difference).free_symbols, key=str)
    values = {one: sympy.Rational(n, 7) for n, one in enumerate(symbols, 3)}
    for time in symbols:
        if time.name == "k":
            values[time] = sympy.Integer(5)
    return bool(abs(sympy.N(sympify(difference).subs(values), DIGITS)) < 1e-30)


def plain(expression):
    """The expression with symbols of no assumptions."""
    return expression.subs({one: Symbol(one.name) for one in expression.free_symbols})


def symbolic_step(G, variable, y):
    result = exact.step_response(G, variable)
    return vanishes(plain(result.expression) - read(y)) and result.is_verified


def symbolic_transition(A, variable, value):
    answer = exact.transition_matrix(A, variable).expression
    expected = sympy.Matrix(sympify(value, locals=NAMES))
    pairs = zip(answer, expected, strict=True)
    return all(vanishes(plain(one) - other) for one, other in pairs)


def undershoot(G, value):
    return close(exact.step_response(G).undershoot(), value)


def stability_intervals(p, parameter, interval):
    answer = exact.stability_intervals(p, parameter).intervals
    if interval == "none":
        return answer == ()
    (cell,) = answer
    lower, upper = interval.strip("()").split(", ")
    return close_end(cell.lower, lower) and close_end(cell.upper, upper)


def close_end(answer, text):
    """Whether an end of an interval, which may be infinite, is that of the file."""
    if "oo" in text:
        return str(answer) == text
    return bool(abs(sympy.N(answer, DIGITS) - sympy.N(read(text), DIGITS)) < 1e-30)


def stability_delays(coefficients, largest):
    ((lower, upper),) = exact.stability_delays(coefficients).windows
    return lower.centre == lower.radius == 0 and (
        upper is None if largest == "oo" else close(upper, largest)
    )


def matrix_poles_and_zeros(G, poles, zeros):
    system = exact.transfer_matrix(G)
    answer = [
        [sympy.nsimplify(sympify(root.value), rational=True) for root in part
         for _ in range(root.multiplicity)]
        for part in (system.poles(), system.zeros())
    ]  # fmt: skip
    return same_set(answer[0], poles) and same_set(answer[1], zeros)


def discrete_gain_margin(G, gain):
    return equal(exact.stability_margins(G, feedback=-1).gain_up.value, gain)


def observer_gain(A, C, target, F):
    answer = exact.observer_gain(A, C, target, variable="s")
    return equal(answer, [[read(x) for x in row] for row in F])


def symbolic_hold(G, step, H):
    answer = exact.sampling.zero_order_hold(G, step, variable="s")
    system = answer.transfer_function.as_expr().subs(dict(answer.exponentials))
    return vanishes(plain(system) - read(H))


def departure(G, angle):
    locus = exact.root_locus(G, feedback=-1)
    upper = [one for one in locus.departures if sympy.im(sympify(one.at.value)) > 0]
    (answer,) = upper[0].angles
    difference = (answer.centre - sympy.Float(angle, 20)) / (2 * sympy.pi)
    return bool(abs(difference - round(float(difference))) < 1e-14) and len(upper) == 1


def initial_and_final_value(G, initial, final):
    response = exact.step_response(G)
    try:
        value = response.final_value
    except exact.errors.NoSolutionError:
        return final == "none" and equal(response.initial_value, initial)
    return final != "none" and equal(value, final) and equal(response.initial_value, initial)


RUN = {name: globals()[name] for name in dict.fromkeys(kind for kind, _ in PROBLEMS)}


def identified(entry):
    kind, problem = entry
    subject = next(str(problem[key]) for key in ("G", "p", "A", "coefficients") if key in problem)
    return f"{kind}: {subject}"


@pytest.mark.parametrize("entry", PROBLEMS, ids=identified)
def test_an_answer_is_that_of_the_book(entry):
    kind, problem = entry
    arguments = {key: value for key, value in problem.items() if key not in ("source", "worked")}
    assert RUN[kind](**arguments), problem


def test_each_problem_says_where_it_is_from_and_how_it_was_worked():
    assert all(problem["source"] and problem["worked"] for _, problem in PROBLEMS)
    assert len({identified(entry) + str(entry[1]) for entry in PROBLEMS}) == len(PROBLEMS) >= 200
