"""A loop asked in every way that the exact half has: what two answers contradict each other."""

import cmath
import math
import time as clock

import sympy

import compensator_theory as exact
from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.loops._siso import closed_loop_of_pair

CLOSE = 1e-9  # of two floats of one number that is known to 30 digits


class Requests:
    """Answers or refusals, and the seconds that each took."""

    def __init__(self):
        self.seconds = {}

    def __call__(self, name, door, *arguments, **keywords):
        start = clock.perf_counter()
        try:
            return door(*arguments, **keywords)
        except exact.CompensatorError as error:
            return error
        finally:
            self.seconds[name] = clock.perf_counter() - start


def refused(answer):
    return isinstance(answer, exact.CompensatorError)


def contradictions(G, G_c, requests=None):
    """Ask margins, gains, locus, delays, norms and connections of the loop 1 + G G_c."""
    requests = requests or Requests()
    result = []

    def require(condition, sentence):
        if not condition:
            result.append(sentence)

    closed = closed_loop_of_pair(G, G_c, -1)
    N, D = G.numerator * G_c.numerator, G.denominator * G_c.denominator
    L = exact.TransferFunction(*(exact.polynomial(p) for p in (N, D)))
    is_posed = not closed.is_zero and closed.degree() == D.degree()
    is_stable = is_posed and exact.decide_stability(closed).is_stable
    gains = requests("gains", exact.stabilising_gains, G, G_c, feedback=-1)
    locus = requests("locus", exact.root_locus, G, G_c, feedback=-1)
    margins = requests("margins", exact.stability_margins, G, G_c, feedback=-1)
    loop = requests("connection", exact.feedback_connection, G, G_c, feedback=-1)
    shown = requests("sensitivity", exact.sensitivity_function, G, G_c, feedback=-1)
    require(refused(loop) == refused(shown) == (not is_posed), "well posed")
    require(is_posed or isinstance(loop, ImproperError), "the refusal of what is not well posed")
    require((1 in gains) == is_stable, "the gains at 1")
    if refused(margins):
        unit = sympy.simplify(N.as_expr() ** 2 - D.as_expr() ** 2) == 0
        allpass = "at all frequencies" in str(margins)
        require(allpass and (not closed.is_zero or unit), "the refusal of margins")
    else:
        require(margins.is_stable == is_stable, "stable by its margins")
        require(margins.is_well_posed == is_posed, "well posed by its margins")
        around = gains.around(1) if is_stable else None
        require(margins.gains == around, "the gains around 1")
        require(("the loop is stable" in str(margins)) == is_stable, "the sentence")
        require(("comes with" not in str(margins)) or not _unpaired(margins), "the pairs of poles")
        for crossing in margins.gain_crossovers:
            value = _value(margins, float(crossing.frequency))
            require(abs(abs(value) - 1) < CLOSE, "|L| at a gain crossover")
            lag = cmath.phase(-value) - float(crossing.phase_margin)
            turn = abs(math.remainder(lag, 2 * math.pi))
            require(turn < 1e-6, "the phase margin")
    if not refused(locus):
        require(locus.stable.intervals == gains.intervals, "the gains of the locus")
        require((1 in locus.stable) == is_stable, "the locus at 1")
        crossings = {} if locus.crossings is None else {c.gain for c in locus.crossings}
        if not refused(margins):
            require((locus.crossings is None) == margins.is_real, "real on the boundary")
            phase = {c.gain for c in margins.phase_crossovers}
            require(phase == {k for k in crossings if k.is_positive}, "phase crossovers")
        ends = {e for cell in gains.intervals for e in (cell.lower, cell.upper) if e.is_finite}
        reached = [float(c.gain_enclosure) for c in locus.crossings or ()]
        for end in ends:  # the same number may have two exact forms
            at = float(sympy.N(end))
            near = any(abs(at - k) <= CLOSE * max(1, abs(k)) for k in reached)
            require(locus.crossings is None or near or _is_drop(end, L), "ends of the gains")
    elif L.reduced().denominator.degree() != 0 and not N.is_zero:
        result.append("the refusal of the locus")
    if G.variable.name == "s":
        _delays(requests, require, N, D, closed, margins, is_stable, gains)
    if not refused(loop):
        is_reduced_stable = exact.decide_stability(loop.reduced().denominator).is_stable
        norm = requests("norm", exact.h_infinity_norm, loop)
        require(refused(norm) != is_reduced_stable, "the norm of what is stable")
        require(not is_stable or not refused(norm), "the norm of a stable loop")
        if not refused(norm):
            at = loop.reduced()(1 if G.variable.name == "z" else 0)
            require(abs(float(at)) <= float(norm.enclosure) * (1 + CLOSE), "the norm")
    return result


def _delays(requests, require, N, D, closed, margins, is_stable, gains):
    delays = requests("delays", exact.stability_delays, [D, N])
    if N.degree() >= D.degree() and not N.is_zero:
        require(refused(delays), "delays of what is not strictly proper")
        return
    hidden = exact.count_roots(exact.polynomial(N.gcd(D)), time="continuous")
    if hidden.boundary:
        require(isinstance(delays, NoSolutionError) or not delays.windows, "a mode that stays")
    if refused(delays):
        return
    counted = exact.count_roots(closed, time="continuous")
    if not counted.boundary:
        require(delays.unstable_without == counted.unstable, "unstable roots without delay")
        begins = bool(delays.windows) and float(delays.windows[0][0]) == 0
        require(begins == is_stable, "the first window")
        if is_stable and not refused(margins):
            end = delays.windows[0][1]
            margin = margins.delay
            same = (end is not None) == margin.is_reached
            touches = any(c.tendency == 0 for c in delays.crossings)
            near = same and (
                end is None or abs(float(end) - float(margin.value)) < CLOSE * float(end)
            )
            require(near or touches, "the delay margin")


def _value(margins, omega):
    s = 1j * omega if margins.time == "continuous" else cmath.exp(1j * omega)
    top, bottom = (
        [complex(c) for c in p.all_coeffs()] for p in (margins.numerator, margins.denominator)
    )
    value = [0j, 0j]
    for k, coefficients in enumerate((top, bottom)):
        for c in coefficients:
            value[k] = value[k] * s + c
    return value[0] / value[1]


def _unpaired(margins):
    """Whether D + N without what is hidden is not even, or not its own reciprocal."""
    p = margins.denominator + margins.numerator
    s = p.gen
    coefficients = p.all_coeffs()
    if margins.time == "continuous":
        return any(c != 0 for c in coefficients[1::2])
    mirrored = [0] * (margins.denominator.degree() - p.degree()) + coefficients
    return s.name == "z" and mirrored != mirrored[::-1]


def _is_drop(gain, L):
    """Whether the degree drops at a gain: a root passes through infinity."""
    top, bottom = L.numerator, L.denominator
    return top.degree() == bottom.degree() and sympy.simplify(bottom.LC() + gain * top.LC()) == 0
