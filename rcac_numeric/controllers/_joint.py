"""Joint fit of theta and the denominator of the target model, section 9.2.2."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import instance_of, integer, number, reads, with_checks
from rcac_numeric.controllers._update import DEFINITE, Update, weight_like
from rcac_numeric.targets._model import TargetModel


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
class JointUD(Update):
    """The factorised recursion for theta and the coefficients of D_f together; scalar z.

    minimise  sum of (z + d_1 q^-1 z + ... + d_n q^-n z - N_f (u - Phi theta))^2
    + rho mean(z^2) d'd  +  (theta - theta(0))' R_theta (theta - theta(0))

    A trade-off, not a guarantee: the less rho, the sooner the controller is asymptotically stable,
    and the more it costs. Without the penalty the least squares only whiten z: they are blind to
    performance, and not unique (`joint_null_dimension`).

    Parameters
    ----------
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(0); P(0) is its inverse. Its mean is the weight of d too.
    n_d : int
        Number of coefficients of D_f; 0 is `UD`, bit for bit.
    rho : float
        Penalty on D_f = 1 at every step, relative to the mean square of z, positive.
        The larger it is, the nearer is `UD`.

    Raises
    ------
    InputError
        Where R_theta is not positive definite or rho not positive; in `ControllerSettings` where
        z is not scalar, the target model is not FIR, or there is an R_u.

    Notes
    -----
    Source: section 9.2.2, which calls the fit convex; strictly convex it is not. What stabilises
    depends on R_theta, n_c and the size of the noise as well.

    Examples
    --------
    >>> from rcac_numeric import JointUD
    >>> JointUD(R_theta=0.1, n_d=2, rho=2.0)
    JointUD(R_theta=0.1, n_d=2, rho=2.0)
    """

    name = "joint"

    R_theta: float | Array = attrs.field(converter=weight_like, metadata=DEFINITE)
    n_d: int = attrs.field(kw_only=True, metadata=reads(integer, at_most=1000))
    rho: float = attrs.field(kw_only=True, metadata=reads(number))

    def __attrs_post_init__(self) -> None:
        if self.rho < 0 or (self.rho == 0 and self.n_d == 0):
            raise InputError(f"rho = {self.rho:g} must be positive.")

    @property
    def keeps_covariance(self) -> bool:
        """True: P(k) of theta and d goes from step to step."""
        return True

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)

    def require_problem(self, targets: Sequence[TargetModel], n_c: int, penalises: bool) -> None:
        """Raise if the fit is undefined, or not unique for rho = 0."""
        if any(target.l_z != 1 for target in targets) or len(targets) > 1:
            raise InputError("JointUD is for one target model and scalar z.")
        if targets[0].denominator[1:].any():
            raise InputError("JointUD fits D_f; give an FIR target model.")
        if penalises:
            raise InputError("JointUD penalises D_f; R_u belongs to the other updates.")
        if self.rho == 0:
            lost = joint_null_dimension(targets[0], n_c, self.n_d)
            raise InputError(
                f"rho = 0: with z = y the cost does not change along {lost} directions of "
                "(theta, D_f), whatever the data, and along the others its minimiser whitens z "
                "and is blind to its size. Use rho > 0; 2 to 3 is a start."
            )


def joint_null_dimension(target: TargetModel, n_c: int, n_d: int) -> int:
    """Return the dimension of the null space of the joint fit without penalty, scalar y = z.

    max(0, min(n_c, n_d - n_f)):  D_f - 1 = -N_f Q,  n_f = d_zu + deg N_zu,u

    Parameters
    ----------
    target : TargetModel
        FIR; n_f is its last coefficient that is not zero.
    n_c : int
        Order of an IIR controller whose first lag of y is 1.
    n_d : int
        Number of coefficients of D_f.

    Raises
    ------
    InputError
        If the target model is not scalar and FIR.

    Notes
    -----
    For every Q = Q_1 q^-1 + ... with deg(N_f Q) <= n_d the control Q y and the denominator
    1 - N_f Q leave the retrospective performance as it is, whatever u and y are: no excitation
    cures that. `joint-null-space` in the ledger.

    Examples
    --------
    >>> from rcac_numeric import TargetModel, joint_null_dimension
    >>> joint_null_dimension(TargetModel([0, 1.0]), n_c=8, n_d=6)
    5
    """
    instance_of(target, "target", TargetModel)
    if (target.l_z, target.l_u) != (1, 1) or target.denominator[1:].any():
        raise InputError("the null space is known for scalar FIR target models only.")
    n_f = int(target.numerator[:, 0, 0].nonzero()[0][-1])
    return max(0, min(integer(n_c, "n_c"), integer(n_d, "n_d") - n_f))
