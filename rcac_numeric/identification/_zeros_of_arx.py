"""The zeros of an identified ARX model, with their errors and phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._values import Result

PHASES = ("nonminimum phase", "minimum phase", "undecided")
# A leading coefficient counts where it exceeds so many standard errors.
SIGNIFICANCE = 5.0
LAGS_OF_WHITENESS = 20


@dataclass(frozen=True, eq=False)
class OnlineZeros(Result):
    """Relative degree, leading coefficient and zeros of an ARX model of u -> z.

    Attributes
    ----------
    zeros : complex array, shape (n,)
        Largest modulus first.
    modulus_error : array, shape (n,)
        Standard error of each modulus, by the delta method.
    phases : tuple of str
        "nonminimum phase" where abs(z) - level s > 1, "minimum phase" where abs(z) + level s < 1,
        else "undecided".
    d_zu : int
        Relative degree: the first coefficient of more than five standard errors.
    H, H_error : float
        That coefficient and its standard error.
    order : int
        p of the model.
    samples : float
        Equations that it remembers.
    whiteness : float
        Probability that white residuals would be as correlated as these (Ljung and Box, 20 lags).
    """

    zeros: ComplexArray
    modulus_error: Array
    phases: tuple[str, ...]
    d_zu: int
    H: float
    H_error: float
    order: int
    samples: float
    whiteness: float

    def __str__(self) -> str:
        rows = zip(self.zeros.tolist(), self.modulus_error.tolist(), self.phases, strict=True)
        outside = [
            f"{z if z.imag else z.real:.4g} (modulus +- {s:.2g}, {phase})"
            for z, s, phase in rows
            if phase != "minimum phase"
        ]
        return (
            f"ARX({self.order}) of {self.samples:.0f} equations, d_zu = {self.d_zu}, H = "
            f"{self.H:.4g} +- {self.H_error:.2g}, whiteness {self.whiteness:.2g}; zeros not "
            f"inside: {', '.join(outside) or 'none'}"
        )


def zeros_of(
    b: Array,
    covariance: Array,
    *,
    errors: Array,
    samples: float,
    level: float = 1.96,
    d_zu: int | None = None,
) -> OnlineZeros:
    """The zeros of b_1 q^-1 + ... + b_p q^-p and their errors, d z/d b_j = -z^(p-j)/b'(z)."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if d_zu is None:
        significant = np.flatnonzero(np.abs(b) > SIGNIFICANCE * deviation)
        if significant.size == 0:
            raise InputError(
                f"none of the {len(b)} coefficients of u exceeds {SIGNIFICANCE:g} standard errors: "
                "the data show no effect of u on z. Perturb u more, or wait."
            )
        d_zu = int(significant[0]) + 1
    numerator, part = b[d_zu - 1 :], covariance[d_zu - 1 :, d_zu - 1 :]
    zeros = np.roots(numerator) if numerator[0] != 0 else np.zeros(0)
    zeros = zeros[np.argsort(-np.abs(zeros))].astype(np.complex128)
    powers = zeros[:, None] ** np.arange(len(numerator) - 1, -1, -1)
    with np.errstate(all="ignore"):
        slopes = -powers / np.polyval(np.polyder(numerator), zeros)[:, None]
        along = (slopes * (zeros.conj() / np.abs(zeros))[:, None]).real
        spread = np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", along, part, along), 0.0))
    spread = np.where(np.isfinite(spread), spread, np.inf)
    return OnlineZeros(
        zeros=zeros,
        modulus_error=spread,
        phases=tuple(_phase(abs(z), level * s) for z, s in zip(zeros, spread, strict=True)),
        d_zu=d_zu,
        H=float(b[d_zu - 1]),
        H_error=float(deviation[d_zu - 1]),
        order=len(b),
        samples=float(samples),
        whiteness=whiteness(errors),
    )


def whiteness(errors: Array) -> float:
    """The Ljung-Box probability that white noise is as correlated over 20 lags as these errors."""
    n = len(errors)
    lags = min(LAGS_OF_WHITENESS, n // 5)
    power = float(errors @ errors)
    if lags == 0 or power == 0:
        return 1.0
    correlation = np.array([errors[i:] @ errors[: n - i] for i in range(1, lags + 1)]) / power
    statistic = n * (n + 2) * float(np.sum(correlation**2 / (n - np.arange(1, lags + 1))))
    from scipy.special import chdtrc  # a sixth of a second

    return float(chdtrc(lags, statistic))


def _phase(modulus: float, width: float) -> str:
    if modulus - width > 1:
        return PHASES[0]
    return PHASES[1] if modulus + width < 1 else PHASES[2]
