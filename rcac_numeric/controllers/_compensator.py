"""Fixed compensators of the form (2.28), and their conversions."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._frames import StateSpace, control_state_space
from rcac_numeric.arrays._validation import (
    array_like,
    positive_time,
    reads,
    real_array,
    require_dense,
    rounded,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import polynomial_latex, sum_latex
from rcac_numeric.signals._text_tables import as_number


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class Compensator(Value):
    """The difference equation (2.28) with constant coefficients.

    u(k) = P_1 u(k-1) + ... + P_nc u(k-n_c) + Q_0 y(k) + Q_1 y(k-1) + ... + Q_nc y(k-n_c)

    Parameters
    ----------
    past_u : array, shape (n_c, l_u, l_u)
        past_u[i-1] is P_i.
    past_y : array, shape (n_c + 1, l_u, l_y)
        past_y[i] is Q_i; past_y[0] is zero for a strictly proper compensator.
    sample_time : float, optional
        In seconds, where one is known: that of the plant for the compensator of a run. It goes out
        to other packages, and is no part of what is compared.

    Examples
    --------
    >>> from rcac_numeric import Compensator
    >>> integrator = Compensator(past_u=[[[1.0]]], past_y=[[[0.0]], [[0.5]]])
    >>> integrator.denominator, integrator.numerator
    (array([ 1., -1.]), array([0. , 0.5]))
    """

    past_u: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    past_y: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    sample_time: float | None = attrs.field(
        default=None, eq=False, repr=False, metadata=reads(positive_time, optional=True)
    )

    def __attrs_post_init__(self) -> None:
        P, Q = self.past_u, self.past_y
        fits = (
            P.ndim == 3
            and Q.ndim == 3
            and P.shape[1] == P.shape[2] == Q.shape[1]
            and Q.shape[0] == P.shape[0] + 1
        )
        if not fits:
            raise InputError(
                f"past_u has shape {P.shape} and past_y {Q.shape}; (n_c, l_u, l_u) and "
                "(n_c + 1, l_u, l_y) are needed."
            )

    @property
    def n_c(self) -> int:
        """The order of the difference equation."""
        return int(self.past_u.shape[0])

    @property
    def l_u(self) -> int:
        """Number of outputs of the compensator."""
        return int(self.past_y.shape[1])

    @property
    def l_y(self) -> int:
        """Number of inputs of the compensator."""
        return int(self.past_y.shape[2])

    @property
    def denominator(self) -> Array:
        """D_c of (2.33), descending powers of q; scalar compensators only."""
        self._require_scalar()
        return np.concatenate([[1.0], -self.past_u[:, 0, 0]])

    @property
    def numerator(self) -> Array:
        """N_c of (2.33) with n_c + 1 coefficients, descending powers of q; scalar only."""
        self._require_scalar()
        return np.concatenate(self.past_y[:, 0])

    def state_space(self) -> tuple[Array, Array, Array, Array]:
        """The observer canonical realisation of D_c^{-1} N_c, of order l_u n_c.

        Its state update reads u(k) itself, x_i(k+1) = x_{i+1}(k) + P_i u(k) + Q_i y(k) with
        u(k) = x_1(k) + Q_0 y(k): a signal added to u there is injected inside the compensator,
        which is the intercalated injection of chapter 4.
        """
        shift, outputs, P, Q = self.observer_form()
        return (
            shift + P @ outputs,
            Q + P @ self.past_y[0],
            outputs,
            self.past_y[0],
        )

    def observer_form(self) -> tuple[Array, Array, Array, Array]:
        """(S, H, P, Q) of x(k+1) = S x(k) + P u(k) + Q y(k), u(k) = H x(k) + Q_0 y(k).

        Raises
        ------
        BudgetError
            Where the compensator has more states than full matrices are computed for.
        """
        order = require_dense(self.n_c * self.l_u, "the compensator")
        shift = np.eye(order, k=self.l_u)
        outputs = np.eye(self.l_u, order)
        return (
            shift,
            outputs,
            self.past_u.reshape(order, self.l_u),
            self.past_y[1:].reshape(order, self.l_y),
        )

    def poles(self) -> NDArray[np.complex128]:
        """The l_u n_c roots of det D_c."""
        shift, outputs, P, _ = self.observer_form()
        return np.linalg.eigvals(shift + P @ outputs).astype(np.complex128)

    def to_control(self, sample_time: float | None = None) -> StateSpace:
        """Return the compensator as a discrete-time python-control system.

        The sample time, in seconds, is its own where none is given; where it has none either,
        the period is unspecified, dt = True. Another one than its own is refused.
        """
        from compensator_theory.systems._sample_times import agreed_period

        advice = "leave sample_time out, or resample it"
        period = agreed_period(self.sample_time, sample_time, at="the compensator", remedy=advice)
        return control_state_space(*self.state_space(), period)

    def _repr_latex_(self) -> str:
        if self.l_u == self.l_y == 1:
            parts = polynomial_latex(self.numerator), polynomial_latex(self.denominator)
            return r"$\displaystyle G_c = \frac{{{}}}{{{}}}$".format(*parts)
        u = sum_latex(((i, P) for i, P in enumerate(self.past_u, 1)), "u")
        y = sum_latex(enumerate(self.past_y), "y")
        return rf"$\displaystyle u(k) = {' + '.join(filter(None, (u, y)))}$"

    def _require_scalar(self) -> None:
        if self.past_y.shape[1:] != (1, 1):
            raise InputError(
                f"the compensator has {self.l_y} inputs and {self.l_u} outputs; numerator and "
                "denominator polynomials exist for a scalar one. Use state_space() instead."
            )


def compensator_of(system: Any, name: str = "compensator") -> Compensator:
    """Convert a transfer function in q to the compensator u = G_c y."""
    if isinstance(system, Compensator):
        return system
    from compensator_theory.systems._conversions import transfer_function
    from compensator_theory.systems._descriptions import is_description

    if not is_description(system):
        raise InputError(f"{name} = {system!r} is not a Compensator.")
    variable = "q" if isinstance(system, str) and as_number(system) is not None else None
    G_c = transfer_function(system, variable)
    if str(G_c.variable) == "s":
        raise InputError(
            f"the {name} is in continuous time; discretise it first, for instance by "
            "compensator_theory.sampling.tustin."
        )
    if not G_c.is_proper:
        raise ImproperError(f"the {name} {G_c} is improper: it would use future values of y.")
    D_c = G_c.denominator.all_coeffs()
    N_c = [0] * (len(D_c) - len(G_c.numerator.all_coeffs())) + G_c.numerator.all_coeffs()
    denominator, numerator = (
        rounded([c / D_c[0] for c in coefficients], name) for coefficients in (D_c, N_c)
    )
    return Compensator(-denominator[1:, None, None], numerator[:, None, None])


def parallel(a: Compensator, b: Compensator) -> Compensator:
    """Return the parallel connection N_a / D_a + N_b / D_b of compensators with one output."""
    if a.l_u > 1:
        if a.past_u.any() or b.past_u.any():
            raise InputError("the sum has one difference equation for l_u = 1 only.")
        order = max(a.n_c, b.n_c)
        padded = [np.pad(c.past_y, [(0, order - c.n_c), (0, 0), (0, 0)]) for c in (a, b)]
        return Compensator(np.zeros((order, a.l_u, a.l_u)), padded[0] + padded[1])
    D_a, D_b = (np.concatenate([[1.0], -c.past_u[:, 0, 0]]) for c in (a, b))
    inputs = [
        np.convolve(a.past_y[:, 0, i], D_b) + np.convolve(b.past_y[:, 0, i], D_a)
        for i in range(a.l_y)
    ]
    denominator = np.convolve(D_a, D_b)
    return Compensator(-denominator[1:, None, None], np.stack(inputs, axis=1)[:, None, :])
