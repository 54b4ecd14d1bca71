"""Output-error models of scalar data: Steiglitz and McBride's iteration over orders and delays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.signal import lfilter

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import integer, real_array
from rcac_numeric.arrays.values import Value

ROUNDS = 10  # of the iteration; it settles in about 5
SETTLED = 1e-4  # relative change of the coefficients
FASTEST = 1.0  # modulus: a pole of a filter outside the circle is reflected into it
REFINED = (5, 3)  # of the best, by the output error itself, in two passes
PENALTY = 3.0  # times that of BIC: noise that is not white asks for more


@dataclass(frozen=True, eq=False)
class OutputErrorModel(Value):
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
        N log(mean e^2) + 3 (2 n + 2) log N: the smallest is the best.
    explained : float
        1 - var(e)/var(y).
    """

    numerator: Array
    denominator: Array
    delay: int
    residual: Array
    criterion: float
    explained: float

    @property
    def order(self) -> int:
        """n, without the delay."""
        return len(self.numerator)

    @property
    def transfer_function(self) -> tuple[Array, Array]:
        """Coefficients of B and A in descending powers of q, without the delay."""
        return self.numerator, self.denominator

    def __str__(self) -> str:
        return (
            f"order {self.order}, delay {self.delay}, explains {100 * self.explained:.4g} % of the "
            f"variance of y in {len(self.residual)} steps"
        )


def identify_output_error(
    u: ArrayLike, y: ArrayLike, *, orders: Iterable[int] = range(1, 6),
    delays: Iterable[int] = range(12),
) -> OutputErrorModel:  # fmt: skip
    """The output-error model of the order and delay that a record supports.

    Steiglitz and McBride's iteration: least squares of A y_f = q^-delay B u_f + c, both filtered by
    1/A of the round before; of the best, least squares of the error of the output itself. Of all
    orders and delays the smallest N log(mean e^2) + 3 (2 n + 2) log N.

    Parameters
    ----------
    u, y : arrays of shape (steps,) or (steps, 1)
        Of an open loop: u must not answer to y.
    orders, delays : iterables of int
        What is tried.

    Raises
    ------
    InputError
        Where u does not excite, there are too few steps, or y does not answer to u.

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
    control, output = _signal(u, "u"), _signal(y, "y")
    tried = [(integer(n, "order", at_least=1), integer(d, "delay")) for n in orders for d in delays]
    if len(control) != len(output):
        raise InputError(f"u has {len(control)} steps and y {len(output)}; they belong together.")
    longest = max((n + d for n, d in tried), default=0)
    if not tried or len(control) < 10 * (longest + 2):
        raise InputError(
            f"there are {len(control)} steps, and for orders and delays of {longest} together at "
            f"least {10 * (longest + 2)} are needed. Record more, or try less."
        )
    unit_u, unit_y = float(np.std(control)), float(np.std(output))
    for name, one in (("u", unit_u), ("y", unit_y)):
        if not one > 0:
            raise InputError(f"{name} does not move: the record shows nothing of the plant.")
    record = _Record(
        (control - control.mean()) / unit_u, (output - output.mean()) / unit_y, longest
    )
    found = _best(record, tried)
    if found is None:
        raise InputError(
            "the record does not show that y answers to u: no model is better than a constant. "
            "Excite u more, record longer, or try longer delays."
        )
    n, d, coefficients = found
    e = _residual(record, n, d, coefficients)
    b = coefficients[n:] * unit_y / unit_u
    left = float(np.mean(e**2))
    return OutputErrorModel(
        b, np.r_[1.0, coefficients[:n]], d, e * unit_y, _criterion(e, n),
        1 - left / float(np.var(record.last_y)),
    )  # fmt: skip


@dataclass(frozen=True)
class _Record:
    """u and y in units of their own, and the first step at which no earlier u is missing."""

    u: Array
    y: Array
    first: int

    @property
    def last_y(self) -> Array:
        """Y from there on."""
        return self.y[self.first :]


def _signal(values: ArrayLike, name: str) -> Array:
    found = real_array(values, name)
    if found.ndim == 2 and found.shape[1] != 1:
        raise InputError(f"{name} has {found.shape[1]} columns; one signal is needed.")
    return found.ravel()


def _criterion(e: Array, n: int) -> float:
    size = max(float(np.mean(e**2)), np.finfo(float).tiny)
    return float(len(e) * np.log(size) + PENALTY * (2 * n + 2) * np.log(len(e)))


def _best(record: _Record, tried: list[tuple[int, int]]) -> tuple[int, int, Array] | None:
    """Order, delay and coefficients of the smallest criterion; None where a constant is."""
    found = {}
    for n, d in tried:
        coefficients = _iterated(record, n, d)
        found[n, d] = _criterion(_residual(record, n, d, coefficients), n), coefficients
    refined: set[tuple[int, int]] = set()
    # Noise that is not white leads the iteration astray, and not at every delay alike.
    for count in REFINED:
        _share_poles(record, found)
        for n, d in sorted(found, key=lambda one: found[one][0])[:count]:
            if (n, d) not in refined:
                coefficients = _refined(record, n, d, found[n, d][1])
                found[n, d] = _criterion(_residual(record, n, d, coefficients), n), coefficients
                refined.add((n, d))
    n, d = min(refined, key=lambda one: found[one][0])
    value, coefficients = found[n, d]
    y = record.last_y
    least = len(y) * np.log(np.mean((y - y.mean()) ** 2)) + PENALTY * np.log(len(y))
    return (n, d, coefficients) if value < least else None


def _share_poles(record: _Record, found: dict[tuple[int, int], tuple[float, Array]]) -> None:
    """At every delay the poles of the best one of that order, where they do better."""
    for n in sorted({n for n, _ in found}):
        best = min((one for one in found if one[0] == n), key=lambda one: found[one][0])
        A = _inside(np.r_[1.0, found[best][1][:n]])
        u_f, y = lfilter([1.0], A, record.u), record.last_y
        free = _free(A, len(y))
        for d in [d for order, d in found if order == n]:
            forced = [_late(u_f, d + i)[record.first :] for i in range(1, n + 1)]
            columns = np.stack([*forced, *free], axis=1)
            B = np.linalg.lstsq(columns, y, rcond=None)[0]
            value = _criterion(y - columns @ B, n)
            if value < found[n, d][0]:
                found[n, d] = value, np.r_[A[1:], B[:n]]


def _iterated(record: _Record, n: int, d: int) -> Array:
    """a_1, ..., a_n, b_1, ..., b_n where Steiglitz and McBride's iteration ends."""
    A = np.zeros(n + 1)
    A[0] = 1.0
    found = np.zeros(2 * n)
    late, one = _late(record.u, d), np.ones_like(record.u)
    for _ in range(ROUNDS):
        y_f, u_f, c_f = (lfilter([1.0], A, signal) for signal in (record.y, late, one))
        columns = [-_late(y_f, i) for i in range(1, n + 1)]
        columns += [_late(u_f, i) for i in range(1, n + 1)]
        regressor = np.stack([*columns, c_f], axis=1)[record.first :]
        found = np.linalg.lstsq(regressor, y_f[record.first :], rcond=None)[0][: 2 * n]
        new = _inside(np.r_[1.0, found[:n]])
        if np.abs(new - A).max() < SETTLED * np.abs(new).max():
            break
        A = new
    return found


def _late(signal: Array, steps: int) -> Array:
    """The signal so many steps later, at rest before."""
    return signal if not steps else np.r_[np.zeros(steps), signal[:-steps]]


def _inside(A: Array) -> Array:
    """A with every root outside the circle reflected into it."""
    roots = np.roots(A)
    size = np.abs(roots)
    if not (size > FASTEST).any():
        return A
    reflected = np.where(size > FASTEST, 1 / np.conj(np.where(size > 0, roots, 1.0)), roots)
    return np.asarray(np.poly(reflected).real)


def _residual(record: _Record, n: int, d: int, coefficients: Array) -> Array:
    """What B/A u, the offset and the initial state, fitted, leave of y."""
    A, B = _inside(np.r_[1.0, coefficients[:n]]), np.r_[0.0, coefficients[n:]]
    columns = np.stack(_free(A, len(record.last_y)), axis=1)
    e = record.last_y - lfilter(B, A, _late(record.u, d))[record.first :]
    return np.asarray(e - columns @ np.linalg.lstsq(columns, e, rcond=None)[0])


def _free(A: Array, steps: int) -> list[Array]:
    """What y may be without u: an offset, and the responses to the initial state."""
    impulse = np.zeros(steps)
    impulse[0] = 1.0
    free = lfilter([1.0], A, impulse)
    return [np.ones(steps), *(_late(free, i) for i in range(len(A) - 1))]


def _refined(record: _Record, n: int, d: int, start: Array) -> Array:
    """The smallest output error beside where the iteration ended."""
    found = least_squares(
        lambda one: _residual(record, n, d, one), start, x_scale="jac", max_nfev=25,
        ftol=1e-12, xtol=1e-10, gtol=1e-12,
    ).x  # fmt: skip
    found[:n] = _inside(np.r_[1.0, found[:n]])[1:]
    return np.asarray(found)
