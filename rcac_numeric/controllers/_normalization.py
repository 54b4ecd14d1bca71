"""The performance variable through a saturation function before it enters the cost."""

from __future__ import annotations

from typing import Literal

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import number, one_of, reads, with_checks

# In the order of the kernel's numbers, which begin with 0 for none.
FUNCTIONS = ("rational", "root", "arctan", "tanh", "erf")


def _positive(value: object, name: str) -> float:
    read = number(value, name)
    if read <= 0:
        raise InputError(f"{name} = {read:g} of a normalisation must be positive.")
    return read


@attrs.frozen(slots=False, field_transformer=with_checks)
class Normalization:
    """A bound on the effect of one step's error: z in the cost becomes f(z), entry by entry.

    f'(0) = slope, abs f < limit; with x = slope z::

        "rational"  x / (1 + |x|/limit)
        "root"      x / sqrt(1 + (x/limit)^2)
        "arctan"    (2 limit/pi) arctan(pi x / (2 limit))
        "tanh"      limit tanh(x/limit)
        "erf"       limit erf(sqrt(pi) x / (2 limit))

    Only z is replaced, neither y nor Phi: the published form. z/(1 + nu abs z) is ``limit = 1/nu``.
    As z shrinks and Phi_f theta - u_f does not, it can take a loop its stability where the weight
    ``R_z = SignalWeight(constant=1, nu=nu)`` of the same row does not: prefer that one, and
    this for settings of others.

    Parameters
    ----------
    limit : float
        Supremum of abs f(z), positive.
    slope : float
        f'(0), positive.
    function : {"rational", "root", "arctan", "tanh", "erf"}

    Raises
    ------
    InputError
        Where a number is not positive.

    Notes
    -----
    Source: the five functions of the RCAC class of the PX4 fork by Goel and others, with its mu as
    limit and its nu as slope (both 1 there; its arctan has nu in place of the outer mu), and
    z/(1 + nu abs(z)) of rcacESC.

    Examples
    --------
    >>> from rcac_numeric import Normalization
    >>> Normalization(limit=5.0)
    Normalization(limit=5.0, slope=1.0, function='rational')
    """

    limit: float = attrs.field(metadata=reads(_positive))
    slope: float = attrs.field(default=1.0, metadata=reads(_positive))
    function: Literal["rational", "root", "arctan", "tanh", "erf"] = attrs.field(
        default="rational", metadata=reads(one_of, choices=FUNCTIONS)
    )
