"""Everything that determines an RCAC controller, checked and as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight, inverse
from rcac_numeric.arrays.validation import (
    Read,
    instance_of,
    integer,
    items,
    number,
    one_of,
    real_array,
)
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.rules import CovarianceReset, SignalWeight, VariableRateForgetting
from rcac_numeric.controllers.setting_checks import (
    changes_by_step,
    forgetting_factor,
    interval,
    require_covariance,
    require_target,
)
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.targets.model import TargetModel

UPDATES = ("ud", "covariance", "sliding window", "instantaneous", "gradient")
FORMS = ("predictor", "filter")


@dataclass(frozen=True, eq=False, kw_only=True)
class ControllerSettings:
    """Everything that determines an RCAC controller, as plain data.

    Parameters
    ----------
    structure : Structure
        What the regressor is made of, for example ``iir(n_c=4)``.
    target : TargetModel
        G_f, with l_z rows and l_u columns.
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(0) in (2.41); P(0) is its inverse. A number stands for that
        multiple of the identity.
    R_z, R_u : float, array of shape (l_z, l_z), SignalWeight, or function
        Weights of (2.41); R_z positive definite, R_u positive semidefinite. A function is called
        as R(k, y, z, u) at every update and returns a number or a matrix; u is u(k), or u(k-1) in
        the filter form.
    lambda_ : float
        Forgetting factor, in (0, 1].
    k_w : int, optional
        First step with u = Phi theta; u = 0 before. At least max(n_c, n_f), the default.
    k_update : int, optional
        First step of the update; k_w by default.
    k_filter : int
        First step that the target-model filter sees; 0 by default.
    update : str
        "ud" (2.42)-(2.45) with P = U D U' factorised; "covariance", P as printed;
        "sliding window", the batch minimiser over the last `window` updates and of (theta -
        theta(0))' R_theta (theta - theta(0)), which is not forgotten; "instantaneous", the
        cost of one step plus (theta - theta(k))' R_theta (theta - theta(k)); "gradient",
        theta(k+1) = theta(k) - step_size Phi_f' [R_z zhat + R_u Phi_f theta(k)], half the gradient
        of the cost of this step.
    theta_0 : array, shape (l_theta,), optional
        theta(0); zero by default.
    process_noise : float or array, shape (l_theta, l_theta), optional
        Q of (2.46), added to P after every update; for "ud" and "covariance" with lambda = 1.
    form : {"predictor", "filter"}
        "filter" is (2.47)-(2.48): the update with z(k) comes before the control u(k) of the same
        step. (As printed, (2.47) mixes Phi_f(k+1) with Upsilon(k); both belong to k+1 here.)
    window : int
        Steps that "sliding window" remembers.
    step_size : float
        Of "gradient".
    forgetting : VariableRateForgetting, optional
        In place of a constant lambda.
    lambda_changes : mapping from steps to numbers
        lambda from that step on.
    target_changes : mapping from steps to TargetModel
        G_f from that step on. The filter keeps the past inputs and outputs of the old one.
    reset : CovarianceReset, optional
    freeze : sequence of (start, stop)
        Steps start <= k < stop without update; stop = None: to the end.
    reflect_poles : bool
        Replace unstable controller poles by their reciprocals after every update (section
        6.2.2); l_u = 1.
    stop_where_unsupported : bool
        End the run at the first update that rounding decides (see `Run.guard_count`).

    Raises
    ------
    InputError
        Where a setting is out of range or has the wrong shape.

    Examples
    --------
    >>> from rcac_numeric import ControllerSettings, TargetModel, iir
    >>> settings = ControllerSettings(structure=iir(n_c=3), target=TargetModel([0, 1]), R_theta=0.2)
    >>> settings.k_w, settings.k_update, settings.update
    (3, 3, 'ud')
    """

    structure: Structure
    target: TargetModel
    R_theta: Read
    R_z: Read = 1.0
    R_u: Read = 0.0
    lambda_: float = 1.0
    k_w: Read = None
    k_update: Read = None
    k_filter: int = 0
    update: str = "ud"
    theta_0: Read = None
    process_noise: Read = None
    form: str = "predictor"
    window: int = 0
    step_size: float = 0.0
    forgetting: VariableRateForgetting | None = None
    lambda_changes: Mapping[int, float] | None = None
    target_changes: Mapping[int, TargetModel] | None = None
    reset: CovarianceReset | None = None
    freeze: Sequence[tuple[int, int | None]] = ()
    reflect_poles: bool = False
    stop_where_unsupported: bool = False

    def __post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        structure, target = self.structure, self.target
        if not isinstance(structure, Structure):
            raise InputError(f"structure = {structure!r}: use iir(...), fir(...) or another kind.")
        set_("target_changes", changes_by_step(self.target_changes, "target_changes"))
        for model in (target, *self.target_changes.values()):  # type: ignore[union-attr]
            require_target(model, structure, target)
        l_z, l_theta = target.l_z, structure.l_theta
        set_("R_theta", constant_weight(self.R_theta, "R_theta", l_theta, definite=True))
        for name, definite in (("R_z", True), ("R_u", False)):
            value = getattr(self, name)
            if not (callable(value) or isinstance(value, SignalWeight)):
                set_(name, constant_weight(value, name, l_z, definite=definite))
        if isinstance(self.R_z, SignalWeight) and self.R_z.constant == 0:
            raise InputError(
                "R_z = z_squared z'z is not positive definite at z = 0; give constant."
            )
        set_("lambda_", forgetting_factor(self.lambda_))
        changes = changes_by_step(self.lambda_changes, "lambda_changes")
        set_("lambda_changes", {k: forgetting_factor(v) for k, v in changes.items()})
        self._require_start(set_)
        theta_0 = np.zeros(l_theta) if self.theta_0 is None else self.theta_0
        theta_0 = real_array(theta_0, "theta_0").reshape(-1)
        if theta_0.size != l_theta:
            raise InputError(f"theta_0 has {theta_0.size} entries; l_theta = {l_theta} are needed.")
        set_("theta_0", theta_0)
        set_("freeze", tuple(interval(pair) for pair in items(self.freeze, "freeze")))
        self._require_update(set_)

    def _require_start(self, set_: Any) -> None:
        longest = max(self.target.n_f, *(t.n_f for t in self.later_targets.values()), 0)
        shortest = max(self.structure.n_c, longest)
        set_("k_w", shortest if self.k_w is None else integer(self.k_w, "k_w"))
        if self.k_w < shortest:
            raise InputError(
                f"k_w = {self.k_w} is shorter than max(n_c, n_f) = max({self.structure.n_c}, "
                f"{longest}) = {shortest}: the regressor and the target-model filter would not "
                f"be filled with data. Use k_w >= {shortest}."
            )
        set_("k_update", self.k_w if self.k_update is None else integer(self.k_update, "k_update"))
        set_("k_filter", integer(self.k_filter, "k_filter"))

    def _require_update(self, set_: Any) -> None:
        one_of(self.update, "update", UPDATES)
        one_of(self.form, "form", FORMS)
        recursive = self.update in ("ud", "covariance")
        if self.forgetting is not None:
            instance_of(self.forgetting, "forgetting", VariableRateForgetting)
        if self.reset is not None:
            instance_of(self.reset, "reset", CovarianceReset)
        for name in ("reflect_poles", "stop_where_unsupported"):
            instance_of(getattr(self, name), name, bool)
        if self.process_noise is not None:
            Q = constant_weight(
                self.process_noise, "process_noise", self.structure.l_theta, definite=False
            )
            set_("process_noise", Q)
            if not recursive or self.lambda_ != 1 or self.later_lambdas or self.forgetting:
                raise InputError(
                    'process_noise belongs to (2.46), that is to update = "ud" or "covariance" '
                    "with lambda = 1."
                )
        if self.forgetting is not None and (self.lambda_ != 1 or self.later_lambdas):
            raise InputError("give either forgetting or lambda and its changes, not both.")
        forgets = self.lambda_ != 1 or self.later_lambdas or self.forgetting
        if forgets and self.update in ("instantaneous", "gradient"):
            raise InputError(
                f'update = "{self.update}" keeps no past, so nothing can be forgotten.'
            )
        if self.reset is not None:
            require_covariance(self.update)
        changing = self.later_lambdas or self.forgetting
        if changing and self.update == "sliding window":
            raise InputError('update = "sliding window" needs a constant lambda.')
        set_("window", integer(self.window, "window", at_most=1_000_000))
        if (self.update == "sliding window") != (self.window > 0):
            raise InputError('update = "sliding window" and window >= 1 belong together.')
        set_("step_size", number(self.step_size, "step_size"))
        if (self.update == "gradient") != (self.step_size > 0):
            raise InputError('update = "gradient" and step_size > 0 belong together.')
        targets = (self.target, *self.later_targets.values())
        if self.form == "filter" and any(t.relative_degree == 0 for t in targets):
            raise ImproperError(
                'form = "filter" updates before u(k) is known, so the target model must be '
                "strictly proper."
            )
        if self.reflect_poles and self.structure.l_u != 1:
            raise InputError(
                f"reflect_poles needs l_u = 1; this structure has l_u = {self.structure.l_u}, "
                "where reflecting the roots of det D_c does not determine the coefficients."
            )
        if self.reflect_poles:
            lags = sorted(tap.delay for tap in self.structure.taps if tap.signal == "u")
            if not lags or lags != list(range(1, len(lags) + 1)):
                raise InputError(
                    "reflect_poles needs the taps u(k-1), ..., u(k-n) without gaps; this "
                    f"{self.structure.name} structure has the lags {lags} of u."
                )

    def compensator(self, theta: ArrayLike) -> Compensator:
        """The fixed compensator that the coefficients `theta` describe."""
        return self.structure.compensator(theta)

    @property
    def later_targets(self) -> Mapping[int, TargetModel]:
        """The target models that replace `target`, by step."""
        return self.target_changes or {}

    @property
    def later_lambdas(self) -> Mapping[int, float]:
        """The forgetting factors that replace `lambda_`, by step."""
        return self.lambda_changes or {}

    @property
    def P_0(self) -> Array:
        """P(0) = R_theta^{-1}, exactly diagonal where R_theta is."""
        return inverse(np.asarray(self.R_theta))
