"""Target models G_f of the intercalated transfer function."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import compensator_theory as exact_theory
from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import instance_of, real_array, rounded
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import polynomial_latex, sum_latex

if TYPE_CHECKING:  # imported here: an FIR target needs neither SymPy nor FLINT
    import flint
    from sympy import Poly


@dataclass(frozen=True, eq=False, init=False)
class TargetModel(Value):
    """The filter G_f = D_f^{-1} N_f of (2.38), with coefficients in powers of q^{-1}.

    Parameters
    ----------
    numerator : array, shape (n_f + 1, l_z, l_u)
        numerator[i] multiplies q^{-i}; a 1-D array stands for a scalar filter.
    denominator : array, shape (n_f + 1, l_z, l_z), optional
        denominator[0] is the identity; an FIR filter by default.
    exact : TransferFunction or TransferMatrix, optional
        The filter that the coefficients were rounded from.

    Raises
    ------
    InputError
        If sizes do not fit, the filter is zero or not what `exact` is, or a pole lies outside the
        unit circle, which is decided exactly: Phi_f of (2.40) would grow without bound. A pole on
        the circle is allowed.

    Examples
    --------
    >>> from rcac_numeric import TargetModel
    >>> delayed_gain = TargetModel([0.0, 2.0])
    >>> delayed_gain.relative_degree, delayed_gain.n_f
    (1, 1)
    """

    numerator: Array
    denominator: Array
    exact: exact_theory.TransferFunction | exact_theory.TransferMatrix | None = field(repr=False)

    def __init__(
        self,
        numerator: ArrayLike,
        denominator: ArrayLike | None = None,
        exact: exact_theory.TransferFunction | exact_theory.TransferMatrix | None = None,
    ) -> None:
        N = real_array(numerator, "numerator")
        N = N.reshape(-1, 1, 1) if N.ndim == 1 else N
        if N.ndim != 3 or N.size == 0:
            raise InputError(
                f"the numerator of the target model has shape {N.shape}; (n_f + 1, l_z, l_u), or "
                "(n_f + 1,) for a scalar filter, is needed."
            )
        identity = np.eye(N.shape[1])[None]
        D = identity if denominator is None else real_array(denominator, "denominator")
        D = D.reshape(-1, 1, 1) if D.ndim == 1 else D
        if D.ndim != 3 or len(D) == 0 or D.shape[1:] != identity.shape[1:]:
            raise InputError(
                f"the denominator of the target model has shape {D.shape}; (n_f + 1, l_z, l_z) "
                f"with l_z = {N.shape[1]} is needed."
            )
        if not np.array_equal(D[0], identity[0]):
            raise InputError(
                "the leading coefficient of the target model's denominator must be the identity; "
                "divide numerator and denominator by it."
            )
        order = max(len(N), len(D)) - 1
        for name, value in (("numerator", N), ("denominator", D)):
            padding = [(0, order + 1 - len(value)), (0, 0), (0, 0)]
            object.__setattr__(self, name, real_array(np.pad(value, padding), name))
        if not self.numerator.any():
            raise InputError("the target model is zero: no controller could be adapted with it.")
        if exact is not None:
            kinds = exact_theory.TransferFunction | exact_theory.TransferMatrix
            instance_of(exact, "exact", kinds)
            _require_same(self.numerator, self.denominator, exact)
        object.__setattr__(self, "exact", exact)
        require_no_pole_outside(self.denominator, exact)

    @property
    def l_z(self) -> int:
        """Number of performance variables."""
        return int(self.numerator.shape[1])

    @property
    def l_u(self) -> int:
        """Number of control inputs."""
        return int(self.numerator.shape[2])

    @property
    def n_f(self) -> int:
        """Order of the filter."""
        return int(self.numerator.shape[0]) - 1

    @property
    def relative_degree(self) -> int:
        """Number of steps after which the output first reacts to the input."""
        return int(np.flatnonzero(self.numerator.any(axis=(1, 2)))[0])

    def frequency_response(self, omega: ArrayLike) -> ComplexArray:
        """G_f(exp(j omega)); shape (len(omega), l_z, l_u), omega in rad/sample."""
        powers = np.exp(-1j * np.outer(real_array(omega, "omega"), np.arange(self.n_f + 1)))
        numerator = np.einsum("wi,izu->wzu", powers, self.numerator)
        return np.asarray(
            np.linalg.solve(np.einsum("wi,izy->wzy", powers, self.denominator), numerator)
        )

    def _repr_latex_(self) -> str:
        if self.l_z == self.l_u == 1:
            sides = (polynomial_latex(side.ravel()) for side in (self.numerator, self.denominator))
            return r"$\displaystyle G_f = \frac{{{}}}{{{}}}$".format(*sides)
        past = ((i, -D) for i, D in enumerate(self.denominator) if i)
        parts = (sum_latex(enumerate(self.numerator), "u"), sum_latex(past, "z_f"))
        return rf"$\displaystyle z_f(k) = {' + '.join(filter(None, parts))}$"


def _require_same(
    numerator: Array,
    denominator: Array,
    exact: exact_theory.TransferFunction | exact_theory.TransferMatrix,
) -> None:
    """Raise if the coefficients differ from `exact` by more than rounding.

    N_f d = D_f N for G = N / d, at points where no power of q^{-1} is lost.
    """
    if isinstance(exact, exact_theory.TransferFunction):
        entries, shape = [exact.numerator], (1, 1)
    else:
        entries, shape = [n for row in exact.numerators for n in row], exact.shape
    if shape != numerator.shape[1:]:
        raise InputError(
            f"the target model is {numerator.shape[1]} x {numerator.shape[2]}, and its exact form "
            f"{shape[0]} x {shape[1]}."
        )
    degree = exact.denominator.degree()
    d, *N = (
        rounded([entry.nth(degree - i) for i in range(degree + 1)], "the target model")
        for entry in (exact.denominator, *entries)
    )
    z = np.exp(1j * np.array([0.3, 1.3, 2.3]))
    left = np.einsum("iab,zi->zab", numerator, z[:, None] ** -np.arange(len(numerator)))
    right = np.einsum("iab,zi->zab", denominator, z[:, None] ** -np.arange(len(denominator)))
    powers = z[:, None] ** -np.arange(degree + 1)
    values = np.stack([powers @ part for part in N], axis=-1).reshape(len(z), *shape)
    gap = np.abs(left * (powers @ d)[:, None, None] - right @ values)
    size = np.abs(numerator).sum() * np.abs(d).sum()
    size += np.abs(denominator).sum() * sum(np.abs(part).sum() for part in N)
    if not gap.max() <= 1e-12 * size:
        raise InputError(
            "the coefficients of the target model are not those of its exact form; leave `exact` "
            "out, or build the target from the exact filter with target_model."
        )


def from_transfer_function(exact: exact_theory.TransferFunction) -> TargetModel:
    """Return the target model of an exact transfer function, each coefficient rounded once."""
    require_causal(exact)
    order = exact.denominator.degree()
    padded = [0] * (order - exact.numerator.degree()) + exact.numerator.all_coeffs()
    return TargetModel(
        rounded(padded, "the target model's numerator"),
        rounded(exact.denominator.all_coeffs(), "the target model's denominator"),
        exact=exact,
    )


def require_causal(exact: exact_theory.TransferFunction) -> None:
    """Raise if a filter is improper or not in q."""
    if exact.denominator.degree() < exact.numerator.degree():
        raise ImproperError(
            f"the target model {exact} has more zeros than poles; it would use future values. "
            "Multiply its denominator by a power of q."
        )
    if str(exact.variable) not in ("q", "z"):
        raise InputError(f"the target model {exact} is not a transfer function in q.")


# Whether a filter has a pole outside the unit circle: decided exactly.

# Up to this degree the message says how many poles there are outside, and where the largest is.
NAMED = 200


def require_no_pole_outside(
    denominator: Array,
    exact: exact_theory.TransferFunction | exact_theory.TransferMatrix | None = None,
) -> None:
    """Raise if a filter D_f^{-1} N_f has a pole of modulus greater than 1.

    Phi_f of (2.40) would grow without bound, and a loop that matches the filter would be unstable.
    A pole on the circle is allowed. No tolerance is involved: the poles are those of
    `exact` where the denominator was rounded from it, else the roots of det D_f with the shortest
    decimals of its entries.
    """
    if not denominator[1:].any():
        return
    from compensator_theory.roots._schur_cohn import has_root_outside

    poles = _determinant(denominator) if exact is None else exact.denominator
    if not has_root_outside(poles):
        return
    if poles.degree() > NAMED:
        obstacle = "a pole outside the unit circle"
    else:
        count = exact_theory.locate_roots(poles, time="discrete").unstable
        largest = max(exact_theory.certified_roots(poles), key=lambda root: abs(root.value))
        obstacle = (
            f"{count} pole{'s' * (count > 1)} outside the unit circle, the largest at {largest}"
        )
    raise InputError(
        f"the target model has {obstacle}: the filtered regressor would grow without bound, and a "
        "loop that matched this target would be unstable. Use poles inside or on the unit circle; "
        "unstable poles of the plant do not belong in G_f."
    )


def _determinant(denominator: Array) -> Poly:
    """Return a multiple of q^(l n_f) det D_f(q) with integer coefficients."""
    import flint
    from sympy import QQ, Poly, Symbol

    from compensator_theory.polynomials._budget import ask

    size, subject = denominator.shape[1], "the denominator of the target model"
    degree = size * (len(denominator) - 1)
    ask("degree", degree, subject)
    if (denominator * (1 - np.eye(size))).any():  # size of the elimination; 1 s at most
        ask("entries", size**3 * degree // 3, subject)
    rows = [_integers(denominator[:, i]) for i in range(size)]
    previous = flint.fmpz_poly([1])
    for k in range(size - 1):
        # D_f(infinity) = I: every leading minor has its full degree, so that no pivot is zero.
        for i in range(k + 1, size):
            for j in range(k + 1, size):
                minor = rows[k][k] * rows[i][j] - rows[i][k] * rows[k][j]
                rows[i][j] = minor // previous
        previous = rows[k][k]
    coefficients = [int(c) for c in reversed(rows[-1][-1].coeffs())]
    return Poly(coefficients, Symbol("q"), domain=QQ)


def _integers(row: Array) -> list[flint.fmpz_poly]:
    """Return a row of D_f times q^n_f and the common denominator of its decimals."""
    import flint

    decimals = [[Fraction(repr(float(value))) for value in entry] for entry in row.T]
    common = lcm(*(value.denominator for entry in decimals for value in entry))
    return [flint.fmpz_poly([int(value * common) for value in entry[::-1]]) for entry in decimals]
