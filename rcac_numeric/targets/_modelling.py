"""Modelling information of RCAC: relative degree, leading coefficient, NMP zeros of G_zu."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

from sympy import Expr, Poly

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant

# A number of the user: exact; a float means its shortest decimal.
Number: TypeAlias = int | float | complex | Fraction | str | Expr


@dataclass(frozen=True, init=False)
class ModellingInformation:
    """Modelling information of RCAC about G_zu (section 2.4), for scalar z and u.

    Parameters
    ----------
    d_zu : int
        Relative degree, in steps.
    H : number
        First nonzero Markov parameter, the leading numerator coefficient. For the servo problem
        it is minus that of G_u, since G_zu = -G_u.
    nmp_zeros : sequence of numbers
        Zeros on or outside the unit circle, in conjugate pairs, with multiplicity.

    Raises
    ------
    InputError
        If a number cannot be read, H is zero, or a zero is inside the unit circle.

    Examples
    --------
    >>> from rcac_numeric import ModellingInformation
    >>> ModellingInformation(d_zu=1, H=-1.0, nmp_zeros=(1.2,))
    ModellingInformation(d_zu=1, H=-1.0, nmp_zeros=(1.2,))
    """

    d_zu: int
    H: Number
    nmp_zeros: tuple[Number, ...]
    # For irrational zeros of a plant: N_zu,u if it is rational, else the mark that the zeros are
    # rounded.
    _factor: Poly | None = field(default=None, init=False, repr=False)
    _is_rounded: bool = field(default=False, init=False, repr=False)

    def __init__(self, d_zu: int, H: Number, nmp_zeros: Sequence[Number] = ()) -> None:
        object.__setattr__(self, "d_zu", integer(d_zu, "d_zu", at_most=10_000))
        if not isinstance(nmp_zeros, Sequence) or isinstance(nmp_zeros, str):
            raise InputError(f"nmp_zeros = {nmp_zeros!r} must be a list of zeros.")
        for name, value in (("H", H), *(("nmp_zeros", zero) for zero in nmp_zeros)):
            if not exact.exact_number(value).is_number:
                raise InputError(f"{name} = {value} contains symbols; give numbers.")
        if not exact.exact_number(H):
            raise InputError("H = 0: the first nonzero Markov parameter cannot be zero.")
        for zero in nmp_zeros:
            modulus = abs(complex(exact.exact_number(zero)))
            if modulus < 1 - 1e-12:  # tolerance: a zero on the circle may be rounded
                raise InputError(
                    f"the zero {zero} has modulus {modulus:.6g} < 1 and is minimum phase; only "
                    "zeros on or outside the unit circle belong in nmp_zeros."
                )
        object.__setattr__(self, "_factor", None)
        object.__setattr__(self, "_is_rounded", False)
        object.__setattr__(self, "H", H)
        object.__setattr__(self, "nmp_zeros", tuple(nmp_zeros))

    def changed(
        self,
        *,
        d_zu: int | None = None,
        H: Number | None = None,
        nmp_zeros: Sequence[Number] | None = None,
    ) -> ModellingInformation:
        """Return a copy with another d_zu, H or nmp_zeros; unchanged zeros stay exact."""
        information = ModellingInformation(
            self.d_zu if d_zu is None else d_zu,
            self.H if H is None else H,
            self.nmp_zeros if nmp_zeros is None else nmp_zeros,
        )
        if nmp_zeros is None:
            object.__setattr__(information, "_factor", self._factor)
            object.__setattr__(information, "_is_rounded", self._is_rounded)
        return information

    @property
    def is_exact(self) -> bool:
        """Whether `nmp_polynomial` is exactly N_zu,u; False for irrational factors of a plant."""
        return not self._is_rounded

    def nmp_polynomial(self) -> Poly:
        """The monic polynomial N_zu,u in q with these zeros, exactly."""
        if self._factor is not None:
            return self._factor
        return exact.polynomial_from_roots(self.nmp_zeros, "q")


def modelling_information(plant: Plant) -> ModellingInformation:
    """Relative degree, leading coefficient and NMP zeros of a plant's G_zu; scalar z and u.

    Parameters
    ----------
    plant : Plant
        With scalar u and z.

    Raises
    ------
    InputError
        If a signal is not scalar, or the control does not act on z.

    Notes
    -----
    Which zeros are outside the unit circle is decided exactly, for the numerator over the unreduced
    denominator det(qI - A), so an uncontrollable or unobservable unstable mode counts as one.
    Irrational ones are shown in float64; their polynomial is kept exactly where it is rational,
    that is, where no conjugate of theirs lies inside.

    Examples
    --------
    >>> from rcac_numeric import servo_plant
    >>> from rcac_numeric.targets import modelling_information
    >>> plant = servo_plant("(q - 0.9)*(q - 1.1)/((q - 0.99)*(q**2 - 1.9*q + 0.9925))")
    >>> modelling_information(plant)
    ModellingInformation(d_zu=1, H=-1, nmp_zeros=(11/10,))
    """
    numerator, denominator = linear_plant(plant).scalar_map("zu")
    if numerator.is_zero:
        raise InputError(
            "G_zu = 0: the control does not act on z, so no controller can be adapted."
        )
    information = ModellingInformation(
        denominator.degree() - numerator.degree(), numerator.LC(), zeros_not_inside(numerator)
    )
    if any(isinstance(zero, float | complex) for zero in information.nmp_zeros):
        factor = factor_not_inside(numerator)
        object.__setattr__(information, "_factor", factor)
        object.__setattr__(information, "_is_rounded", factor is None)
    return information


def zeros_not_inside(polynomial: Poly) -> tuple[Number, ...]:
    """Return the roots of a rational polynomial on or outside the unit circle."""
    zeros: list[Number] = []
    for factor, multiplicity in polynomial.factor_list()[1]:
        zeros += multiplicity * _of_irreducible(factor)
    return tuple(zeros)


def factor_not_inside(polynomial: Poly) -> Poly | None:
    """Return the monic factor with the roots on or outside the circle; None if irrational."""
    product = polynomial.one
    for factor, multiplicity in polynomial.factor_list()[1]:
        count = _count_not_inside(factor)
        if 0 < count < factor.degree():
            return None
        if count:
            product *= factor**multiplicity
    return product.monic()


def _count_not_inside(factor: Poly) -> int:
    if factor.degree() == 1 and factor.domain.is_QQ:
        return 1 if abs(factor.nth(0)) >= abs(factor.nth(1)) else 0
    count = exact.locate_roots(factor, time="discrete")
    return int(count.boundary + count.unstable)


def _of_irreducible(factor: Poly) -> list[Number]:
    """Return the roots of an irreducible polynomial on or outside the circle, decided exactly."""
    count = _count_not_inside(factor)
    if count and factor.degree() == 1:
        return [-factor.monic().nth(0)]
    # The number of these roots is exact, and they are the largest.
    largest = sorted(exact.certified_roots(factor), key=lambda root: -abs(root.value))[:count]
    return [root.value.real if root.is_real else root.value for root in largest]
