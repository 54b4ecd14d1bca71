"""A target model that the controller learns from u -> z while it runs."""

from __future__ import annotations

from typing import Literal

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, number, one_of
from rcac_numeric.targets._model import TargetModel

COVARIANCES = ("blend", "keep", "reset", "replay")
INPUTS = ("u", "frozen u~")
LITERAL = ("u~", "literal", "literal u~")


@attrs.frozen(slots=False)
class DataDriven:
    """Replaces the target model: RCAC learns d_zu, H and the NMP zeros from u -> z.

    For `start` steps u is a white dither; from there on the controller runs with

        G_f(q) = H q^{-d_zu} prod (1 - z_i q^{-1}),  z_i the NMP zeros,

    the modelling information being that of an ARX(order) model of u -> z, which goes on learning.
    Every `every` steps G_f is replaced where it changed by more than `changed` of its
    coefficients; theta is kept. Scalar u and z.

    A zero is NMP where its modulus exceeds 1 by `level` standard errors (delta method) and is
    between 1.02 and 10. What is undecided keeps the side that it was on, at the beginning that of
    the estimate. This is dual control: u serves the loop and the model.

    Parameters
    ----------
    order : int
        p of the ARX model; generous, since one that does not cover the plant and its noise is
        biased for good. For a plant that is unstable small (p = n), and `start` short.
    start : int
        Steps of open loop with the dither alone, above the order.
    every : int
        Steps between two looks at the model; 5 for zeros that cross the unit circle.
    lambda_ : float
        Forgetting factor of the model (`SubspaceForgetting`); 1 for a plant that does not change.
    dither, running_dither : float
        Size of the dither before and after `start`. Ten times the sensor noise before; after, for
        a plant that changes, the size of w, and for one that does not, 0.
    d_zu : int, optional
        The relative degree where it is known; estimated otherwise.
    H : float, optional
        The leading coefficient where it is known; estimated otherwise.
    R_theta : float
        Regularisation of the model.
    level : float
        Standard errors between a zero and the circle from which on it is decided.
    changed : float
        Relative change of the coefficients of G_f from which on it is replaced.
    covariance : {"blend", "keep", "reset", "replay"}
        What becomes of P, see `Controller.set_target`: a model that was not good enough yet was
        wrong rather than moved, so "reset"; "replay" for zeros that cross the circle.
    seed : int
        Of the dither.
    input : {"u", "frozen u~"}
        What z is modelled from: u, or the virtual perturbation u - Phi theta over the last `window`
        steps, with the theta of the look in all of them.
    window : int
        Steps, more than 2 order; of "frozen u~" only.
    n : int, optional
        The order of the plant, which "frozen u~" needs: u~ -> z has the order n + n_c, and
        a model of a lower one is refused.

    Raises
    ------
    InputError
        Where a setting is out of range, or the input is the literal u~.

    Notes
    -----
    Section 9.2.3 proposes to identify from the virtual perturbation u~(k) = u(k) - Phi(k)
    theta(k+1). As literally generated it does not work, so it is no option: without dither its
    size falls to 1e-3 of u, and it mixes as many controllers as steps. With theta frozen it holds
    what u holds, no more. docs/beyond-the-text.md has the figures.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, DataDriven, WhiteNoise, exogenous, iir, simulate,
    ...     standard_plant)
    >>> plant = standard_plant("(q - 1.5)/((q - 0.5)*(q - 0.7))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=6), update=UD(R_theta=1e-3), target=DataDriven(order=10, dither=1))
    >>> run = simulate(plant, settings, exogenous([WhiteNoise(0.1)], 2000))
    >>> run.outcome, run.changes[0].k, run.changes[0].change.target.n_f
    ('completed', 300, 2)
    """

    order: int = 20
    start: int = 300
    every: int = 50
    lambda_: float = 1.0
    dither: float = 0.01
    running_dither: float = 0.0
    d_zu: int | None = None
    H: float | None = None
    R_theta: float = 1e-6
    level: float = 1.96
    changed: float = 0.05
    covariance: Literal["blend", "keep", "reset", "replay"] = "reset"
    seed: int = 0
    input: Literal["u", "frozen u~"] = "u"
    window: int = 2000
    n: int | None = None

    def __attrs_post_init__(self) -> None:
        integer(self.order, "order", at_least=1, at_most=200)
        integer(self.start, "start", at_least=self.order + 1)
        integer(self.every, "every", at_least=1)
        integer(self.seed, "seed", at_most=2**63 - 1)
        if self.d_zu is not None:
            integer(self.d_zu, "d_zu", at_least=1, at_most=self.order)
        for name in ("lambda_", "dither", "running_dither", "R_theta", "level", "changed"):
            value = number(getattr(self, name), name)
            object.__setattr__(self, name, value)
            if value < 0 or (value == 0 and name in ("lambda_", "dither", "R_theta")):
                raise InputError(f"{name} = {value} must be positive.")
        if self.lambda_ > 1:
            raise InputError(f"lambda_ = {self.lambda_} is not in (0, 1].")
        if self.H is not None:
            object.__setattr__(self, "H", number(self.H, "H"))
            if self.H == 0:
                raise InputError("H = 0: the leading coefficient cannot be zero.")
        one_of(self.covariance, "covariance", COVARIANCES)
        self._require_input()

    def _require_input(self) -> None:
        if self.input in LITERAL:
            raise InputError(
                f'input = "{self.input}": the virtual perturbation as section 9.2.3 writes it, '
                "u(k) - Phi(k) theta(k+1), is not offered: it fades as theta converges and belongs "
                "to another controller at every step, so that the zeros found from it are wrong "
                '(docs/beyond-the-text.md has the runs). Use "u", or "frozen u~".'
            )
        one_of(self.input, "input", INPUTS)
        integer(self.window, "window", at_least=1, at_most=10**6)
        if not self.is_frozen:
            if self.n is not None:
                raise InputError(f'n = {self.n} belongs to input = "frozen u~"; leave it out.')
            return
        if self.n is None:
            raise InputError(
                'input = "frozen u~" models a loop of order n + n_c: give n, that of the plant.'
            )
        integer(self.n, "n", at_least=1)
        if self.window <= 2 * self.order:
            raise InputError(
                f"window = {self.window}: an ARX({self.order}) has {2 * self.order} coefficients, "
                "and more steps than that determine them."
            )

    @property
    def is_frozen(self) -> bool:
        """Whether z is modelled from the virtual perturbation with theta frozen."""
        return self.input == INPUTS[1]

    @property
    def first_target(self) -> TargetModel:
        """Placeholder of G_f before the first target update; no update uses it."""
        return TargetModel([0.0, 1.0])
