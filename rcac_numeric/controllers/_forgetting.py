"""Forgetting rules other than a constant factor."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import by_step, integer, number, reads, with_checks


def forgetting_factor(value: object, name: str = "lambda_") -> float:
    """Return a forgetting factor in (0, 1]."""
    factor = number(value, name)
    if not 0 < factor <= 1:
        raise InputError(f"{name} = {factor} is not in (0, 1].")
    return factor


def _factors(changes: object, name: str) -> dict[int, float]:
    return {k: forgetting_factor(value) for k, value in by_step(changes, name).items()}


@attrs.frozen(slots=False, field_transformer=with_checks)
class ScheduledForgetting:
    """A forgetting factor that changes at given steps.

    Attributes
    ----------
    changes : mapping from steps to numbers
        lambda from that step on, in (0, 1].
    initial : float
        lambda before the first change.

    Examples
    --------
    >>> from rcac_numeric import ScheduledForgetting
    >>> ScheduledForgetting({1000: 0.98, 1200: 1})
    ScheduledForgetting(changes={1000: 0.98, 1200: 1.0}, initial=1.0)
    """

    changes: Mapping[int, float] = attrs.field(hash=False, metadata=reads(_factors))
    initial: float = attrs.field(default=1.0, metadata=reads(forgetting_factor))


@attrs.frozen(slots=False, field_transformer=with_checks)
class VariableRateForgetting:
    """A forgetting factor that falls while z is larger than it was of late.

    lambda(k) = 1 / (1 + gain * max(0, rms_short(k) / rms_long(k) - 1))

    where the root mean squares of z run over the last `short` and `long` steps (fewer at the
    beginning). At rest lambda = 1, so nothing is forgotten without a reason and P does not wind up
    (Bruce, Goel, Bernstein, "Convergence and consistency of recursive least squares with
    variable-rate forgetting", Automatica 119, 2020).

    Attributes
    ----------
    short, long : int
        Numbers of steps, short < long.
    gain : float
        Positive.
    smallest : float
        lambda(k) is never below it.

    Examples
    --------
    >>> from rcac_numeric import VariableRateForgetting
    >>> VariableRateForgetting(short=10, long=100, gain=0.1)
    VariableRateForgetting(short=10, long=100, gain=0.1, smallest=0.5)
    """

    short: int = attrs.field(metadata=reads(integer, at_least=1))
    long: int = attrs.field(metadata=reads(integer, at_least=2, at_most=1_000_000))
    gain: float
    smallest: float = 0.5

    def __attrs_post_init__(self) -> None:
        if self.short >= self.long:
            raise InputError(f"short = {self.short} must be less than long = {self.long}.")
        if number(self.gain, "gain") <= 0:
            raise InputError(f"gain = {self.gain} must be positive.")
        if not 0 < number(self.smallest, "smallest") <= 1:
            raise InputError(f"smallest = {self.smallest} is not in (0, 1].")


@attrs.frozen(slots=False, field_transformer=with_checks)
class SubspaceForgetting:
    """Forgetting in excited directions alone, down to R_theta and no further; for `UD`.

    Before each row phi of the update

        P <- P + c phi phi',  c = min((1 - lambda_d)/(lambda_d q), max(0, 1/f - 1/q)),
        q = phi' P^{-1} phi,  f = phi' R_theta phi,
        lambda_d = max(1/2, 1 - (l_theta/l_z) (1 - lambda)),

    so that the information along phi is multiplied by lambda_d, unless it would fall below
    that of P(0). Directions without excitation keep theirs: at rest nothing winds up, whatever the
    scale of the noise, which exponential forgetting does within 1/(1 - lambda) steps. Where all
    directions are excited the memory is that of exponential forgetting by lambda. R_theta bounds
    the information of each row, not the eigenvalues of the matrix, which rows of changing direction
    may take a little lower: choose it as large as the excitation permits, for instance 1e-2 of
    phi'phi over the memory.

    Sources: subspace of information forgetting; for one row L. Cao and H. Schwartz, A directional
    forgetting algorithm based on the decomposition of the information matrix, Automatica 36 (2000).
    The floor is ours.

    Attributes
    ----------
    lambda_ : float
        In (0, 1].

    Examples
    --------
    >>> from rcac_numeric import UD, SubspaceForgetting
    >>> UD(R_theta=0.01, lambda_=SubspaceForgetting(0.99))
    UD(R_theta=0.01, lambda_=SubspaceForgetting(lambda_=0.99))
    """

    lambda_: float = attrs.field(metadata=reads(forgetting_factor))


@attrs.frozen(slots=False, field_transformer=with_checks)
class CappedForgetting:
    """Exponential forgetting that stops at P(0); for `UD`.

    With P = U D U', after every update

        d_j <- min(d_j / lambda, d_j(0)),

    so that no variance exceeds what R_theta allowed at the beginning. Where the data excite theta
    it is exponential forgetting by lambda; where they do not nothing winds up. Like every bound on
    P it relies on R_theta: with 1e-10 the cap is 1e10. The cap is ours; `SubspaceForgetting` does
    more, and costs twice as much.

    Attributes
    ----------
    lambda_ : float
        In (0, 1].

    Examples
    --------
    >>> from rcac_numeric import UD, CappedForgetting
    >>> UD(R_theta=0.01, lambda_=CappedForgetting(0.99))
    UD(R_theta=0.01, lambda_=CappedForgetting(lambda_=0.99))
    """

    lambda_: float = attrs.field(metadata=reads(forgetting_factor))


# Rules in place of a constant forgetting factor.
Forgetting = ScheduledForgetting | VariableRateForgetting | SubspaceForgetting | CappedForgetting
