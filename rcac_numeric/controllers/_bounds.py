"""Bounds on the adapted coefficients, and the coefficient names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, cast

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    array_like,
    has_mask,
    instance_of,
    integer,
    number,
    one_of,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._structure import Structure

METHODS = ("metric", "clip")
MOST_LOST = 1e-3  # share of the radius that float64 may cost
Range = tuple[float | None, float | None]


def _bound(value: ArrayLike | None, name: str, unbounded: float) -> float | Array | None:
    """Converter: return a bound, a number or an array, infinite for no bound."""
    if value is None:
        return None
    if has_mask(value):
        raise InputError(f"{name} = {value!r} of the bounds has masked entries; give numbers.")
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r} of the bounds must be an array of numbers.") from None
    if array.ndim > 1 or np.isnan(array).any() or (array == -unbounded).any():
        raise InputError(
            f"{name} = {value!r} of the bounds must be a number or a list of numbers, one for each "
            f"coefficient; {unbounded:g} stands for none."
        )
    return array if array.ndim else float(array)


def _range(name: object, pair: Range) -> Range:
    if not isinstance(name, str) or not isinstance(pair, tuple | list) or len(pair) != 2:
        raise InputError(f"gains: {name!r} has the bounds {pair!r}; (low, high) are needed.")
    low, high = (None if v is None else number(v, f"a bound of {name}") for v in pair)
    if low is None and high is None:
        raise InputError(f"gains: {name!r} has neither a low nor a high bound.")
    if low is not None and high is not None and low > high:
        raise InputError(f"gains: the bounds of {name} are {low:g} and {high:g}: low exceeds high.")
    return low, high


def _gains(value: object, name: str) -> dict[str, Range]:
    gains = instance_of({} if value is None else value, name, Mapping)
    return {str(key): _range(key, pair) for key, pair in gains.items()}


def _bound_like(value: ArrayLike | None) -> float | Array | None:
    """Typing stub: argument type of `low` and `high`."""
    return cast(float, value)


def _gains_like(value: Mapping[str, Range] | None) -> Mapping[str, Range]:
    """Typing stub: argument type of `gains`."""
    return cast(Mapping[str, Range], value)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class CoefficientBounds(Value):
    """low <= theta(k) <= high, kept after every update.

    "metric":  minimise (t - theta)' P^-1 (t - theta) over low <= t <= high
    "clip":    t_i = min(max(theta_i, low_i), high_i)

    "metric" moves the other coefficients with those that are bounded as the data ask for, and is
    right where theta is small, as PID's. With many coefficients and bounds that most of them meet
    it can lose a loop that "clip" keeps. Neither promises stability under wrong bounds.

    Parameters
    ----------
    low, high : float or array, shape (l_theta,), optional
        None, or an infinite entry: no bound.
    gains : mapping from names to (low, high), optional
        Bounds of single coefficients by their names (`coefficient_names`), one or both None;
        they take the place of low and high there. A name without its number, such as "Q", is of
        all that begin with it.
    method : {"metric", "clip"}
    sweeps : int
        Most sweeps of "metric" in one step; what is outside after them is clipped.

    Raises
    ------
    InputError
        Where nothing is bounded, a low bound exceeds the high one, or sizes differ.

    Notes
    -----
    Source: "metric" is the projection of constrained recursive least squares (Goodwin and Sin,
    1984, section 3.7), solved by Hildreth's sweeps (1957), the columns of P made where a bound is
    met; P stays as it is.

    Examples
    --------
    >>> from rcac_numeric import CoefficientBounds, pid
    >>> bounds = CoefficientBounds(low=0, gains={"K_D": (None, 2)})
    >>> bounds.box(pid())
    (array([  0.,   0., -inf]), array([inf, inf,  2.]))
    """

    low: float | Array | None = attrs.field(
        default=None, converter=_bound_like, metadata=reads(_bound, unbounded=-np.inf)
    )
    high: float | Array | None = attrs.field(
        default=None, converter=_bound_like, metadata=reads(_bound, unbounded=np.inf)
    )
    gains: Mapping[str, Range] = attrs.field(
        default=None, kw_only=True, converter=_gains_like, metadata=reads(_gains)
    )
    method: Literal["metric", "clip"] = attrs.field(
        default="metric", kw_only=True, metadata=reads(one_of, choices=METHODS)
    )
    sweeps: int = attrs.field(
        default=100, kw_only=True, metadata=reads(integer, at_least=1, at_most=100_000)
    )

    def __attrs_post_init__(self) -> None:
        if self.low is None and self.high is None and not self.gains:
            raise InputError("nothing is bounded: give low, high or gains.")
        if not self.gains:  # gains may tighten a bound; `box` checks the result
            _require_order(self.low, self.high)

    def box(self, structure: Structure) -> tuple[Array, Array]:
        """Return (low, high) of every coefficient of a structure, infinite without a bound.

        Raises
        ------
        InputError
            Where a size or a name is not of the structure, or a low bound exceeds the high one.
        """
        size = structure.l_theta
        low, high = _sized(self.low, "low", -np.inf, size), _sized(self.high, "high", np.inf, size)
        names = coefficient_names(structure)
        for name, (least, most) in self.gains.items():
            rows = [i for i, one in enumerate(names) if one == name or one.startswith(f"{name}_")]
            if not rows:
                raise InputError(
                    f"no coefficient is called {name!r}; those of this {structure.name} structure "
                    f"are {', '.join(dict.fromkeys(names))}."
                )
            low[rows] = -np.inf if least is None else least
            high[rows] = np.inf if most is None else most
        wrong = np.flatnonzero(low > high)
        if len(wrong):
            i = int(wrong[0])
            raise InputError(
                f"the bounds of {names[i]} (coefficient {i}) are {low[i]:g} and {high[i]:g}: low "
                "exceeds high."
            )
        return low, high


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class CertifiedBounds(Value):
    """theta(k) = center + factor v with abs(v) <= 1, kept after every update.

    The ellipsoid (theta - center)' M^-1 (theta - center) <= 1 with M = factor factor'. In the loop
    of theta = center a change of theta is a memoryless gain around T, from the intercalated
    injection to the regressor; if T* M T < 1 on the unit circle, no motion of theta in the
    ellipsoid destabilises the loop. The certificate of the set proves that; the bounds keep theta
    in the ellipsoid.

    Parameters
    ----------
    center : array, shape (l_theta,)
    factor : array, shape (l_theta, l_theta)
        Lower triangular with a positive diagonal: the Cholesky factor of M.

    Raises
    ------
    InputError
        Where a shape or the triangle is wrong, or float64 cannot tell inside from outside to a
        thousandth of the radius.

    Notes
    -----
    Source of the projection: the minimiser of (t - theta)' P^-1 (t - theta) over the ellipsoid, by
    four linearised constraints n'(t - center) <= (e^2 + 1) / 2, n = M^-1 (theta - center), each
    met in the metric of P (Goodwin and Sin, 1984, section 3.7), and what these leave along the
    radius. Updates without a P, or with one that is not of theta alone, project along the radius.

    Examples
    --------
    >>> from rcac_numeric import CertifiedBounds
    >>> bounds = CertifiedBounds([0.5, -1.0], [[0.5, 0.0], [0.25, 0.5]])
    >>> float(bounds.radius_of([0.75, -0.875])), bounds.contains([0.75, -0.875])
    (0.5, True)
    """

    center: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    factor: Array = attrs.field(converter=array_like, metadata=reads(real_array))

    def __attrs_post_init__(self) -> None:
        size, shape = self.center.size, self.factor.shape
        if self.center.ndim != 1 or not size:
            raise InputError(
                f"center has the shape {self.center.shape}; a vector of l_theta entries is needed."
            )
        if shape != (size, size):
            raise InputError(f"factor has the shape {shape}; {(size, size)} is needed, as center.")
        if np.triu(self.factor, 1).any():
            raise InputError(
                "factor is not lower triangular; use np.linalg.cholesky of the ellipsoid's M."
            )
        if not (least := self.factor.diagonal().min()) > 0:
            raise InputError(f"factor has {least:g} on its diagonal; positive entries are needed.")
        error = 1 - ellipsoid_radii(self)[1]
        if not error <= MOST_LOST:
            raise InputError(
                f"in float64 the radius of a theta on the boundary has an error of up to "
                f"{error:.1g}; {MOST_LOST:g} is allowed. The ellipsoid's axes are too unequal, or "
                "too short for the size of center: cap the largest axes, or scale the signals."
            )

    def radius_of(self, theta: ArrayLike) -> Array:
        """Return abs(factor^-1 (theta - center)): 0 at the center, 1 on the boundary.

        Parameters
        ----------
        theta : array, shape (..., l_theta)

        Returns
        -------
        array, shape (...)

        Raises
        ------
        InputError
            Where theta has another number of coefficients.
        """
        thetas, size = real_array(theta, "theta"), self.center.size
        if thetas.ndim == 0 or thetas.shape[-1] != size:
            raise InputError(f"theta has the shape {thetas.shape}; (..., {size}) is needed.")
        moved = (thetas - self.center).reshape(-1, size).T
        v = _substituted(self.factor, moved)
        return cast(Array, np.linalg.norm(v, axis=0).reshape(thetas.shape[:-1])[()])

    def contains(self, theta: ArrayLike) -> bool:
        """Whether theta, or every theta of an array (..., l_theta), lies in the ellipsoid."""
        return bool((self.radius_of(theta) <= 1).all())


def ellipsoid_radii(bounds: CertifiedBounds, eps: float = 2.0**-52) -> tuple[float, float]:
    """Return (limit, aim): the computed radius that proves the true one <= 1, and its set point.

    L^-1 to the nearest numbers, the differences, the products and their sums in any order: at most
    (2 l_theta + 4) u cond, cond the Frobenius norm of abs(L^-1) abs(L), u = eps/2 (Higham 2002,
    section 3.1); the same holds for substitution. Twice that stays, so that any other check of
    abs(v) <= 1 passes too. A projected theta is rounded to the nearest number; its computed radius
    is at most the limit.
    """
    center, factor = bounds.center, bounds.factor
    size = len(center)
    with np.errstate(over="ignore", invalid="ignore"):
        inverse = np.abs(_substituted(factor, np.eye(size)))
        condition = float(np.linalg.norm(inverse @ np.abs(factor)))
        widths = np.linalg.norm(factor, axis=1)
        grain = float(np.linalg.norm(inverse @ (np.abs(center) + widths)))
    error = 2 * (size + 4) * eps * condition
    return 1 - error, 1 - 2 * error - 2 * eps * grain


def inverse_factor(bounds: CertifiedBounds) -> Array:
    """Return factor^-1, each entry the nearest number."""
    # Late: a controller without such bounds loads nothing of the exact half.
    import flint

    from compensator_theory.polynomials._ball_precision import at_growing_precision

    size, factor = len(bounds.center), bounds.factor

    def attempt(_: int) -> Array | None:
        try:
            inverse = flint.arb_mat(size, size, factor.ravel().tolist()).inv()
        except ZeroDivisionError:
            return None
        entries = inverse.entries()
        radii = np.array([float(entry.rad()) for entry in entries]).reshape(size, size)
        if not np.linalg.norm(np.tril(radii) @ np.abs(factor)) < 2.0**-60:  # of an error of 2^-53
            return None
        return np.tril(np.array([float(entry.mid()) for entry in entries]).reshape(size, size))

    return at_growing_precision(attempt, 256, "the inverse of a factor of CertifiedBounds")


def _substituted(L: Array, right: Array) -> Array:
    """Return L^-1 right, in the order of sums of the kernel.

    SciPy's takes milliseconds on a busy machine: its BLAS wakes its threads for a matrix of 8.
    """
    v = np.array(right)
    for j in range(len(v)):
        v[j] /= L[j, j]
        v[j + 1 :] -= np.outer(L[j + 1 :, j], v[j])
    return v


def coefficient_names(structure: Structure) -> tuple[str, ...]:
    """Return the names of the entries of theta.

    K_P, K_I and K_D of PID, (2.58)-(2.62); P_i, Q_i and R_i for the lag i of u, y and r, (2.28);
    K_i for the i-th derived signal. With several inputs or outputs the names repeat, in the order
    of theta.

    Parameters
    ----------
    structure : Structure

    Examples
    --------
    >>> from rcac_numeric import coefficient_names, fir_integrator, iir, pid
    >>> coefficient_names(iir(n_c=2))
    ('P_1', 'P_2', 'Q_1', 'Q_2')
    >>> coefficient_names(pid("PI")), coefficient_names(fir_integrator(n_c=2))
    (('K_P', 'K_I'), ('Q_1', 'Q_2', 'K_1'))
    """
    terms = instance_of(structure, "structure", Structure).name
    if set(terms) <= set("PID") and len(structure.taps) == len(terms) * structure.l_y:
        words = [f"K_{term}" for term in terms for _ in range(structure.l_y)]
    else:
        letters = {"u": "P", "y": "Q", "r": "R"}
        words = [
            f"K_{tap.component + 1}"
            if tap.signal == "derived"
            else f"{letters[tap.signal]}_{tap.delay}"
            for tap in structure.taps
        ]
    return tuple(word for word in words for _ in range(structure.l_u))


def _require_order(low: float | Array | None, high: float | Array | None) -> None:
    """Raise if low exceeds high, before the structure is known."""
    if low is None or high is None:
        return
    if 1 != np.size(low) != np.size(high) != 1:
        raise InputError(
            f"low has {np.size(low)} entries and high {np.size(high)}; one for each coefficient is "
            "needed in both, or a single number."
        )
    least, most = np.broadcast_arrays(np.ravel(low), np.ravel(high))
    wrong = np.flatnonzero(least > most)
    if len(wrong):
        i = int(wrong[0])
        raise InputError(
            f"the bounds of coefficient {i} are {least[i]:g} and {most[i]:g}: low exceeds high."
        )


def _sized(value: float | Array | None, name: str, default: float, size: int) -> Array:
    if value is None:
        return np.full(size, default)
    if np.size(value) not in (1, size):
        raise InputError(f"{name} has {np.size(value)} bounds; l_theta = {size}.")
    return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64).reshape(-1), size))
