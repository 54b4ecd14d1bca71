"""Zeros of an identified model, with their sampling uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import instance_of, integer, number
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._mu_markov import IdentifiedMarkovParameters
from rcac_numeric.identification._order import order_from_singular_values
from rcac_numeric.identification._zero_gradients import zeros_and_gradients


@dataclass(frozen=True, eq=False)
class IdentifiedZeros(Result):
    """Zeros of a model identified from data, and their accuracy.

    Attributes
    ----------
    zeros : complex array, shape (n,)
        Largest modulus first.
    covariance : array, shape (n, 2, 2)
        Of the real and imaginary part of each; of a real zero only the first entry is not 0.
    d_zu, order : int
        Index of the first significant Markov parameter, and number of states.
    leading : array, shape (l, l)
        That parameter.
    freedom : float
        Degrees of freedom of the covariance, from which Student's t and F follow.
    singular_values : array
        Of the Hankel matrix that was realised.
    """

    zeros: ComplexArray
    covariance: Array
    d_zu: int
    order: int
    leading: Array
    freedom: float
    singular_values: Array

    @property
    def modulus_error(self) -> Array:
        """Standard error of the modulus of each zero."""
        size = np.abs(self.zeros)
        direction = np.stack([self.zeros.real, self.zeros.imag], axis=1)
        direction = direction / np.where(size > 0, size, 1.0)[:, None]
        return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", direction, self.covariance, direction)))

    def contains(self, index: int, zero: complex, level: float = 0.95) -> bool:
        """Whether the confidence region of zeros[index] at this level contains a number.

        An interval for a real zero, an ellipse for a complex one.
        """
        if not -len(self.zeros) <= index < len(self.zeros):
            raise InputError(f"index = {index}; the model has {len(self.zeros)} zeros.")
        gap = complex(zero) - complex(self.zeros[index])
        covariance = self.covariance[index]
        if self.zeros[index].imag == 0:
            limit = _student(level, self.freedom)
            return gap.imag == 0 and abs(gap.real) <= limit * float(np.sqrt(covariance[0, 0]))
        vector = np.array([gap.real, gap.imag])
        distance = vector @ np.linalg.pinv(covariance, hermitian=True) @ vector
        # Hotelling's: two components from a covariance of this many degrees of freedom.
        nu = self.freedom
        from scipy.stats import f as fisher  # half a second of import time

        return bool(distance <= 2 * nu / (nu - 1) * fisher.ppf(_level(level), 2, nu - 1))

    def phases(self, level: float = 0.95) -> tuple[str, ...]:
        """Classify zeros: "nonminimum phase", "minimum phase" or, at this level, "undecided"."""
        limit = _student(level, self.freedom)
        distance, error = np.abs(self.zeros) - 1, limit * self.modulus_error
        return tuple(
            "undecided" if abs(gap) <= width else _phase(gap)
            for gap, width in zip(distance.tolist(), error.tolist(), strict=True)
        )

    def __str__(self) -> str:
        rows = zip(self.zeros.tolist(), self.modulus_error.tolist(), self.phases(), strict=True)
        lines = [f"{plain_number(z):.6g}, modulus {abs(z):.6g} +- {e:.2g}, {p}" for z, e, p in rows]
        return "\n".join([f"order {self.order}, relative degree {self.d_zu}", *lines])


def identified_zeros(
    markov: IdentifiedMarkovParameters,
    *,
    order: int | None = None,
    d_zu: int | None = None,
    significance: float = 5.0,
) -> IdentifiedZeros:
    """The zeros of a model identified from data, with their uncertainty by the delta method.

    cov [Re q_i; Im q_i] = J_i cov(H) J_i',  J_i = d [Re q_i; Im q_i]/dH

    Parameters
    ----------
    markov : IdentifiedMarkovParameters
        Of a square map.
    order : int, optional
        Number of states; by default as many as singular values stand out of their errors.
    d_zu : int, optional
        Relative degree; by default the index of the first significant parameter.
    significance : float
        A parameter is significant if it exceeds this many standard errors.

    Raises
    ------
    InputError
        If the map is not square, no parameter is significant, the first significant one is
        singular, or the Hankel matrix is too small for the order or has a smaller rank.
    IllConditionedError
        If two zeros coincide, or the order cuts between equal singular values.

    Notes
    -----
    The delta method is first order: it needs errors that are small against the distances between
    zeros and between the singular values kept and dropped. `bootstrap_zeros` needs less and takes
    longer; where the two disagree, believe neither. A map of relative degree d_zu has d_zu zeros
    less per input than states; they are at 0 in the realisation, and the smallest are left out.

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import identified_zeros, identify_markov_parameters
    >>> rng = np.random.default_rng(0)
    >>> u = rng.standard_normal(2000)
    >>> y = scipy.signal.lfilter([0, 1, -1.2], [1, -0.5, 0], u) + 0.1 * rng.standard_normal(2000)
    >>> found = identified_zeros(identify_markov_parameters(u, y, mu=12, n_mod=2), order=2)
    >>> found.phases(), found.contains(0, 1.2)
    (('nonminimum phase',), True)
    """
    instance_of(markov, "markov", IdentifiedMarkovParameters)
    H, error = markov.H, markov.standard_error
    l_y, l_u = H.shape[1:]
    if l_y != l_u:
        raise InputError(
            f"the identified map is {l_y} x {l_u}; a map that is not square has no zeros "
            "in general. Choose as many outputs as inputs."
        )
    first = leading_index(markov, significance) if d_zu is None else integer(d_zu, "d_zu")
    if first >= len(H) - 2:
        raise InputError(
            f"only {max(len(H) - 1 - first, 0)} Markov parameters follow H_{first}; zeros need at "
            "least 2. Estimate more of them: a larger mu."
        )
    _require_invertible(H[first], number(significance, "significance") * error[first], first)
    shifted = H[first:]
    n, size = order_from_singular_values(shifted, error[first:], order)
    zeros, gradients = zeros_and_gradients(shifted, n)
    keep = np.lexsort((-zeros.imag, -zeros.real, -np.abs(zeros)))[: max(n - first * l_u, 0)]
    zeros, flat = zeros[keep], gradients[keep].reshape(len(keep), shifted.size)
    J = np.stack([flat.real, flat.imag], axis=1)
    tail = markov.covariance[first * l_y * l_u :, first * l_y * l_u :]
    return IdentifiedZeros(
        zeros=zeros,
        covariance=np.asarray(np.einsum("nia,ab,njb->nij", J, tail, J)),
        d_zu=first,
        order=n,
        leading=H[first].copy(),
        freedom=markov.freedom,
        singular_values=size,
    )


def leading_index(markov: IdentifiedMarkovParameters, significance: float) -> int:
    """Return the index of the first significant Markov parameter, or raise an error."""
    cleared = markov.cleared(significance).any(axis=(1, 2))
    if not cleared.any():
        raise InputError(
            f"none of the {markov.mu} Markov parameters exceeds {significance:g} standard errors: "
            "the data show no effect of u on y. Record more data, or a stronger input."
        )
    return int(np.flatnonzero(cleared)[0])


def _require_invertible(leading: Array, error: Array, index: int) -> None:
    smallest = float(np.linalg.svd(leading, compute_uv=False)[-1])
    if smallest <= float(np.linalg.norm(error)):
        raise InputError(
            f"the smallest singular value of H_{index} is {smallest:.3g}, within "
            f"{float(np.linalg.norm(error)):.3g}, its possible error: it determines no zeros. "
            "Give d_zu, take outputs of one relative degree, or record more data."
        )


def _student(level: float, freedom: float) -> float:
    """Half the width of Student's interval, in standard errors."""
    from scipy.stats import t  # half a second of import time, paid only here

    return float(t.ppf(0.5 + _level(level) / 2, freedom))


def _level(level: float) -> float:
    value = number(level, "level")
    if not 0 < value < 1:
        raise InputError(f"level = {value:g}; a level of confidence is between 0 and 1.")
    return value


def plain_number(zero: complex) -> complex | float:
    """A complex number without imaginary part as a float."""
    return zero.real if zero.imag == 0 else zero


def _phase(gap: float) -> str:
    return "nonminimum phase" if gap > 0 else "minimum phase"
