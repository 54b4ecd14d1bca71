"""Output-error models of scalar data: Steiglitz and McBride's iteration over orders and delays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.signal import lfilter

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._joint_stability import open_loop_gate
from rcac_numeric.identification._regressors import lagged
from rcac_numeric.identification._scalar_record import (
    SHARE,
    ScalarModel,
    ScalarRecord,
    Shape,
    information_criterion,
    inside,
    integrated_share,
    late,
    scalar_record,
    shapes,
)

ROUNDS = 10  # of the iteration; it settles in about 5
SETTLED = 1e-4  # relative change of the coefficients
REFINED = (5, 3)  # of the best, by the output error itself, in two passes
PENALTY = 3.0  # times that of BIC: coloured noise needs more
INTEGRATOR = np.array([1.0, -1.0])  # 1 - q^-1
COLOUR = 4  # order of the noise model under which a pole at 1 is compared with a free one

FitsByShape = dict[Shape, tuple[float, Array]]  # the criterion and the coefficients of each model


@dataclass(frozen=True, eq=False)
class OutputErrorModel(ScalarModel, Truth):
    """y(k) = q^-delay B(q)/A(q) u(k) + offset + e(k), strictly proper.

    Attributes
    ----------
    numerator : array, shape (n,)
        b_1, ..., b_n of B = b_1 q^-1 + ... + b_n q^-n.
    denominator : array, shape (n + 1,)
        1, a_1, ..., a_n of A = 1 + a_1 q^-1 + ... + a_n q^-n.
    delay : int
        Steps beside the one that every strictly proper model has.
    residual : array
        e, what the model, its initial state and the offset leave of y; without the first steps,
        as many as the longest order and delay, of which u before the record is a part.
    criterion : float
        N log(mean e^2) + 3 (2 n + 2) log N: the smallest of an order and delay is the best.
    explained : float
        1 - var(e)/var(y).
    integrators : int
        Poles of A that are 1 exactly; then the offset is one of u, too, and y may have a slope.
    """

    residual: Array
    criterion: float
    explained: float
    integrators: int = 0

    def errors(self, u: ArrayLike, y: ArrayLike) -> Array:
        """The residual of the model on another record, with fitted state, offset and slope."""
        record = scalar_record(u, y, self.order + self.delay, drifts=True)
        A = self.denominator
        for _ in range(self.integrators):
            A = np.polydiv(A, INTEGRATOR)[0]
        coefficients = np.r_[A[1:], self.numerator * record.units[0] / record.units[1]]
        shape = self.order, self.delay, self.integrators
        return record.units[1] * _residual(record, shape, coefficients)

    def __str__(self) -> str:
        pole = " with a pole at 1" if self.integrators else ""
        return (
            f"order {self.order}{pole}, delay {self.delay}, explains "
            f"{100 * self.explained:.4g} % of the variance of y in {len(self.residual)} steps"
        )


def identify_output_error(
    u: ArrayLike, y: ArrayLike, *, orders: Iterable[int] = range(1, 6),
    delays: Iterable[int] = range(12), integrators: Iterable[int] = (0,),
) -> OutputErrorModel:  # fmt: skip
    """Identify the output-error model of the order and delay that a record supports.

    Steiglitz and McBride's iteration: least squares of A y_f = q^-delay B u_f + c, both filtered by
    1/A of the round before; of the best, least squares of the error of the output itself. Of all
    orders and delays the smallest N log(mean e^2) + 3 (2 n + 2) log N. A pole at 1 is imposed by
    taking the sum of u for u, which leaves the noise as it is; it is kept where the BIC of the
    error, made white by an AR(4) model, is smaller than that of the best model with free poles,
    y having a slope of its own in both, and where it makes 0.3 of the gain at 0.02 rad/step.

    Parameters
    ----------
    u, y : arrays of shape (steps,) or (steps, 1)
        Of an open loop: u must not answer to y.
    orders, delays, integrators : iterables of int
        What is tried; 0 or 1 of the poles is 1 exactly.

    Raises
    ------
    InputError
        Where u does not excite, there are too few steps, or y does not answer to u.
    UndecidedError
        Where the plant seems unstable: a long regression has a root outside the unit circle.

    Notes
    -----
    Source: K. Steiglitz and L. E. McBride, IEEE Transactions on Automatic Control 10 (1965)
    461-464; its fixed points are those of the output error for white e: P. Stoica and
    T. Soderstrom, Automatica 17 (1981) 713-717.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> from rcac_numeric.identification import identify_output_error
    >>> rng = np.random.default_rng(1)
    >>> u = rng.standard_normal(500)
    >>> y = 3 + lfilter([0, 0, 0, 0.5], [1, -0.8], u) + 0.01 * rng.standard_normal(500)
    >>> model = identify_output_error(u, y)
    >>> model.order, model.delay, model.denominator.round(2)
    (1, 2, array([ 1. , -0.8]))
    """
    candidates = shapes(orders, delays, integrators)
    integrator_counts = sorted({sums for *_, sums in candidates})
    longest = max(n + d for n, d, _ in candidates)
    record = scalar_record(u, y, longest, drifts=integrator_counts != [0])
    fits: FitsByShape = {}
    for sums in integrator_counts:
        fits |= _fitted(record, [one for one in candidates if one[-1] == sums], fits)
    best = [
        min((one for one in fits if one[-1] == sums), key=lambda one: fits[one][0])
        for sums in integrator_counts
    ]
    models = [(shape, fits[shape][1]) for shape in best]
    shape, coefficients = models[0] if len(models) == 1 else _of_two(record, *models)
    n, d, sums = shape
    e = _residual(record, shape, coefficients)
    least = information_criterion(_residual(record, (0, 0, 0), np.zeros(0)), 1, PENALTY)
    if not _criterion(e, shape) < least:
        raise InputError(
            "the record shows no effect of u on y: no model is better than a constant. "
            "Excite u more, record longer, or try longer delays."
        )
    stability = open_loop_gate(record.u, record.y, d, e, 2 * n + 2)
    if not stability.passed:
        raise UndecidedError(f"{stability.words}. {stability.advice}")
    A, b = np.r_[1.0, coefficients[: n - sums]], coefficients[n - sums :]
    for _ in range(sums):
        A = np.convolve(A, INTEGRATOR)
    unit_u, unit_y = record.units
    left = float(np.mean(e**2))
    return OutputErrorModel(
        b * unit_y / unit_u, A, d, e * unit_y, _criterion(e, shape),
        1 - left / float(np.var(record.last_y)), sums,
    )  # fmt: skip


def _criterion(e: Array, shape: Shape) -> float:
    return information_criterion(e, 2 * shape[0] + 2, PENALTY)


def _of_two(
    record: ScalarRecord, free: tuple[Shape, Array], imposed: tuple[Shape, Array]
) -> tuple[Shape, Array]:
    """The better of a model with free poles and one with a pole at 1."""
    shape, coefficients = imposed
    A, B = np.split(coefficients, [shape[0] - 1])
    if not integrated_share(np.r_[1.0, A], B) > SHARE:
        return free
    e = [_residual(record, *one) for one in (free, imposed)]
    past = lagged(e[0][:, None], COLOUR + 1)
    colour = np.r_[1.0, -np.linalg.lstsq(past[:, 1:], past[:, 0], rcond=None)[0]]
    values = [
        information_criterion(lfilter(colour, [1.0], one)[COLOUR:], 2 * n - sums, 1.0)
        for one, ((n, _, sums), _) in zip(e, (free, imposed), strict=True)
    ]
    return imposed if values[1] < values[0] else free


def _fitted(record: ScalarRecord, candidates: list[Shape], free: FitsByShape) -> FitsByShape:
    """The best refined model of some shapes with one number of integrators.

    Where `free` has models without a pole at 1 they are tried with their slowest pole put there.
    """
    fits: FitsByShape = {}
    for shape in candidates:
        starts = [_iterated(record, shape)]
        starts += [_without_slowest(of) for one, (_, of) in free.items() if one[:2] == shape[:2]]
        refinements = [(_criterion(_residual(record, shape, one), shape), one) for one in starts]
        fits[shape] = min(refinements, key=lambda one: one[0])
    refined: set[Shape] = set()
    # Noise that is not white leads the iteration astray, and not at every delay alike.
    for count in REFINED:
        _share_poles(record, fits)
        for shape in sorted(fits, key=lambda one: fits[one][0])[:count]:
            if shape not in refined:
                coefficients = _refined(record, shape, fits[shape][1])
                e = _residual(record, shape, coefficients)
                fits[shape] = _criterion(e, shape), coefficients
                refined.add(shape)
    return {shape: fits[shape] for shape in refined}


def _without_slowest(coefficients: Array) -> Array:
    """A and B of a model without the pole nearest to 1."""
    n = len(coefficients) // 2
    poles = np.roots(np.r_[1.0, coefficients[:n]])
    rest = np.delete(poles, np.argmin(np.abs(poles - 1)))
    A = np.atleast_1d(np.poly(rest)).real
    return np.concatenate([A[1:], coefficients[n:]])


def _driving(record: ScalarRecord, sums: int) -> Array:
    """The input u, or its sum if a pole at 1 is imposed."""
    return np.cumsum(record.u) if sums else record.u


def _share_poles(record: ScalarRecord, fits: FitsByShape) -> None:
    """Try the poles of the best model of an order at every delay."""
    for n, sums in sorted({(n, sums) for n, _, sums in fits}):
        alike = [one for one in fits if one[0] == n]
        best = min(alike, key=lambda one: fits[one][0])
        A = inside(np.r_[1.0, fits[best][1][: n - sums]])
        u_f, y = lfilter([1.0], A, _driving(record, sums)), record.last_y
        free = _free(A, len(y), record.drifts)
        for shape in alike:
            forced = [late(u_f, shape[1] + i)[record.first :] for i in range(1, n + 1)]
            columns = np.stack([*forced, *free], axis=1)
            B = np.linalg.lstsq(columns, y, rcond=None)[0]
            value = _criterion(y - columns @ B, shape)
            if value < fits[shape][0]:
                fits[shape] = value, np.r_[A[1:], B[:n]]


def _iterated(record: ScalarRecord, shape: Shape) -> Array:
    """The coefficients a_1, ..., b_1, ..., b_n after Steiglitz and McBride's iteration."""
    n, d, sums = shape
    poles = n - sums
    A = np.zeros(poles + 1)
    A[0] = 1.0
    coefficients = np.zeros(poles + n)
    delayed = late(_driving(record, sums), d)
    known = [np.ones_like(record.u), *[np.linspace(-1, 1, len(record.u))] * record.drifts]
    for _ in range(ROUNDS):
        y_f, u_f, *c_f = (lfilter([1.0], A, signal) for signal in (record.y, delayed, *known))
        columns = [-late(y_f, i) for i in range(1, poles + 1)]
        columns += [late(u_f, i) for i in range(1, n + 1)]
        regressor = np.stack([*columns, *c_f], axis=1)[record.first :]
        coefficients = np.linalg.lstsq(regressor, y_f[record.first :], rcond=None)[0][: poles + n]
        new = inside(np.r_[1.0, coefficients[:poles]])
        if np.abs(new - A).max() < SETTLED * np.abs(new).max():
            break
        A = new
    return coefficients


def _residual(record: ScalarRecord, shape: Shape, coefficients: Array) -> Array:
    """The residual of y after B/A u, the offset and the initial state."""
    n, d, sums = shape
    A, B = inside(np.r_[1.0, coefficients[: n - sums]]), np.r_[0.0, coefficients[n - sums :]]
    columns = np.stack(_free(A, len(record.last_y), record.drifts), axis=1)
    e = record.last_y - lfilter(B, A, late(_driving(record, sums), d))[record.first :]
    return np.asarray(e - columns @ np.linalg.lstsq(columns, e, rcond=None)[0])


def _free(A: Array, steps: int, drifts: bool) -> list[Array]:
    """The free responses: an offset, a slope, and the responses to the initial state."""
    impulse = np.zeros(steps)
    impulse[0] = 1.0
    free = lfilter([1.0], A, impulse)
    slope = [np.linspace(-1, 1, steps)] * drifts
    return [np.ones(steps), *slope, *(late(free, i) for i in range(len(A) - 1))]


def _refined(record: ScalarRecord, shape: Shape, start: Array) -> Array:
    """Minimise the output error from the result of the iteration."""
    poles = shape[0] - shape[2]
    optimum = least_squares(
        lambda one: _residual(record, shape, one), start, x_scale="jac", max_nfev=25,
        ftol=1e-12, xtol=1e-10, gtol=1e-12,
    ).x  # fmt: skip
    optimum[:poles] = inside(np.r_[1.0, optimum[:poles]])[1:]
    return np.asarray(optimum)
