"""Everything that determines an RCAC controller, checked and as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric import _kernel
from rcac_numeric.structures import Structure
from rcac_numeric.target_models import TargetModel
from rcac_numeric.validation import Array, Read, integer, matrix, number, one_of, real_array

UPDATES = ("ud", "covariance")


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
    R_z, R_u : float or array, shape (l_z, l_z)
        Weights of (2.41); R_z positive definite, R_u positive semidefinite. R_u may be a
        function of z(k).
    lambda_ : float
        Forgetting factor, in (0, 1].
    k_w : int, optional
        First step with u = Phi theta; u = 0 before. At least max(n_c, n_f), the default.
    k_update : int, optional
        First step of the update; k_w by default.
    k_filter : int
        First step that the target-model filter sees; 0 by default.
    update : {"ud", "covariance"}
        Arithmetic of (2.42)-(2.45): factorised P = U D U', or P as printed.
    theta_0 : array, shape (l_theta,), optional
        theta(0); zero by default.

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

    def __post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        structure, target = self.structure, self.target
        if not isinstance(structure, Structure):
            raise InputError(f"structure = {structure!r}: use iir(...) or fir(...).")
        if not isinstance(target, TargetModel):
            raise InputError(
                f"target = {target!r}: use fir_target, pole_placement_target or target_model."
            )
        if target.l_u != structure.l_u:
            raise InputError(
                f"the target model has {target.l_u} columns and the structure {structure.l_u} "
                "control inputs; G_f must be l_z x l_u."
            )
        l_z, l_theta = target.l_z, structure.l_theta
        set_("R_theta", _weight(self.R_theta, "R_theta", l_theta, definite=True))
        set_("R_z", _weight(self.R_z, "R_z", l_z, definite=True))
        if not callable(self.R_u):
            set_("R_u", _weight(self.R_u, "R_u", l_z, definite=False))
        set_("lambda_", number(self.lambda_, "lambda"))
        if not 0 < self.lambda_ <= 1:
            raise InputError(f"lambda = {self.lambda_} is not in (0, 1].")
        shortest = max(structure.n_c, target.n_f)
        set_("k_w", shortest if self.k_w is None else integer(self.k_w, "k_w"))
        if self.k_w < shortest:
            raise InputError(
                f"k_w = {self.k_w} is shorter than max(n_c, n_f) = max({structure.n_c}, "
                f"{target.n_f}) = {shortest}: the regressor and the target-model filter would not "
                f"be filled with data. Use k_w >= {shortest}."
            )
        set_("k_update", self.k_w if self.k_update is None else integer(self.k_update, "k_update"))
        set_("k_filter", integer(self.k_filter, "k_filter"))
        one_of(self.update, "update", UPDATES)
        theta_0 = np.zeros(l_theta) if self.theta_0 is None else self.theta_0
        theta_0 = real_array(theta_0, "theta_0").reshape(-1)
        if theta_0.size != l_theta:
            raise InputError(f"theta_0 has {theta_0.size} entries; l_theta = {l_theta} are needed.")
        set_("theta_0", theta_0)

    @property
    def P_0(self) -> Array:
        """P(0) = R_theta^{-1}, exactly diagonal where R_theta is."""
        R = np.asarray(self.R_theta)
        diagonal = np.diag(R)
        if np.array_equal(R, np.diag(diagonal)):
            return np.diag(1.0 / diagonal)
        return np.ascontiguousarray(np.linalg.inv(R))

    def kernel(self) -> _kernel.Controller:
        """A compiled controller at step 0."""
        structure, target = self.structure, self.target
        regressor = [(structure.index(tap), tap.delay) for tap in structure.taps]
        if self.k_filter == 0:
            # From zero initial conditions the filter commutes with the delays: one channel for
            # each scalar signal serves all taps on it.
            channels = [(i, 0) for i in range(structure.l_u + structure.l_y)]
            filtered = regressor
        else:
            # A filter that is switched on later does not: each tap is a channel of its own.
            channels = [*((i, 0) for i in range(structure.l_u)), *regressor]
            filtered = [(structure.l_u + j, 0) for j in range(len(regressor))]
        return _kernel.controller(
            l_u=structure.l_u,
            l_y=structure.l_y,
            l_z=target.l_z,
            regressor=regressor,
            channels=channels,
            filtered=filtered,
            numerator=target.numerator,
            denominator=target.denominator,
            forgetting=self.lambda_,
            R_z=self.R_z,
            R_u=np.zeros((target.l_z, target.l_z)) if callable(self.R_u) else self.R_u,
            R_u_of_z=self._checked_weight if callable(self.R_u) else None,
            k_w=self.k_w,
            k_update=self.k_update,
            k_filter=self.k_filter,
            update=self.update,
            P_0=self.P_0,
            theta_0=self.theta_0,
        )

    def _checked_weight(self, z: Array) -> Array:
        return _weight(self.R_u(z), "R_u(z)", self.target.l_z, definite=False)


def _weight(value: ArrayLike, name: str, size: int, *, definite: bool) -> Array:
    """A symmetric weight, positive definite or semidefinite; a number means a multiple of I."""
    array = real_array(value, name)
    array = float(array) * np.eye(size) if array.ndim == 0 else matrix(array, name, (size, size))
    if not np.array_equal(array, array.T):
        raise InputError(f"{name} is not symmetric; use ({name} + {name}') / 2.")
    diagonal = np.diag(array)
    is_diagonal = np.array_equal(array, np.diag(diagonal))
    eigenvalues = diagonal if is_diagonal else np.linalg.eigvalsh(array)
    smallest = eigenvalues.min()
    if definite and smallest <= 0:
        raise InputError(f"{name} has the eigenvalue {smallest:.6g}; it must be positive definite.")
    if smallest < -1e-12 * max(abs(eigenvalues.max()), np.finfo(float).tiny):
        raise InputError(
            f"{name} has the eigenvalue {smallest:.6g}; it must be positive semidefinite."
        )
    with np.errstate(over="ignore"):
        invertible = not (definite and is_diagonal) or np.isfinite(1.0 / diagonal).all()
    if not invertible:
        raise InputError(f"{name} = {smallest:.3g} has no float64 inverse; use a larger weight.")
    return real_array(array, name)
