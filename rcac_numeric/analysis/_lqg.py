"""Discrete-time LQG with every cross term, strictly or exactly proper."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import IllConditionedError, ImproperError, InputError
from rcac_numeric.analysis._agreement import ExactAgreement, exact_agreement
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._conversion import ConversionCertificate, converted
from rcac_numeric.analysis._costs import H2Cost, h2_cost
from rcac_numeric.analysis._equations import stabilising_solution
from rcac_numeric.analysis._noise import NoiseInputs, NoiseIntensities, noise_inputs
from rcac_numeric.analysis._obstacles import ESTIMATOR, REGULATOR
from rcac_numeric.analysis._solutions import StabilisingSolution
from rcac_numeric.analysis._square_roots import least_squares
from rcac_numeric.analysis._state_space import StateSpace, state_space_latex
from rcac_numeric.arrays import _frames as frames
from rcac_numeric.arrays._algebraic_loops import closes
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._showing import notebook_of
from rcac_numeric.arrays._validation import one_of
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant

FORMS = ("predictor", "filter")
LARGEST_GAP = 1e-6  # tolerance between the cost of the loop and that of the Riccati solutions


@dataclass(frozen=True, eq=False)
class LQG(Value):
    """An LQG controller u = G_c y with its cost and accuracy.

    Attributes
    ----------
    plant : Plant
    noise : NoiseIntensities or None
        As given.
    form : {"predictor", "filter"}
    regulator : StabilisingSolution
        (A.6), (A.7): P, and the gain K = C_c.
    estimator : StabilisingSolution
        (A.5), (A.8) as the dual regulator: its P is Q, its K is -B_c'.
    state_space : (A_c, B_c, C_c, D_c)
        Of order n; D_c is zero for the predictor form.
    cost : H2Cost
        Of this controller in a loop with the plant, from the loop's own Lyapunov equation.
    cost_from_riccati : float
        The same cost from traces of P and Q alone.
    """

    plant: Plant
    noise: NoiseIntensities | None
    form: str
    regulator: StabilisingSolution
    estimator: StabilisingSolution
    state_space: StateSpace
    cost: H2Cost
    cost_from_riccati: float

    @cached_property
    def compensator(self) -> Compensator:
        """The controller as the difference equation (2.28), verified against `state_space`.

        Raises
        ------
        IllConditionedError
            Where no difference equation with float64 coefficients has its response, or where the
            loop with `compensator` is not stable though that with `state_space` is.
        """
        conversion = self._converted[0]
        if np.isfinite(self.cost.value) and not ClosedLoop(self.plant, conversion).is_stable:
            raise IllConditionedError(
                "the difference equation of this LQG controller, rounded to float64, makes the "
                "loop unstable; its state space makes the loop stable. Use state_space or "
                "to_control()."
            )
        return conversion

    @property
    def certificate(self) -> ConversionCertificate:
        """The certificate that `compensator` reproduces `state_space`."""
        return self._converted[1]

    @cached_property
    def _converted(self) -> tuple[Compensator, ConversionCertificate]:
        return converted(self.state_space)

    @property
    def loop(self) -> ClosedLoop:
        """The closed loop of the plant with `compensator`."""
        return ClosedLoop(self.plant, self.compensator)

    def to_control(self) -> frames.StateSpace:
        """Return the python-control controller with the plant's sample time, or dt = True."""
        return frames.control_state_space(*self.state_space, self.plant.sample_time)

    @cached_property
    def poles(self) -> ComplexArray:
        """The 2n closed-loop poles, the eigenvalues of A + BC_c and of A - B_cC, (A.11)."""
        return np.concatenate([self.regulator.poles, self.estimator.poles])

    @property
    def spectral_radius(self) -> float:
        """Spectral radius of the controller: above 1 for an unstable controller."""
        return float(np.abs(np.linalg.eigvals(self.state_space[0])).max(initial=0.0))

    @cached_property
    def agreement(self) -> ExactAgreement:
        """The closed-loop poles compared with those of `compensator_theory.lqg_poles`."""
        inputs = noise_inputs(self.plant, self.noise)
        return exact_agreement(self.plant, inputs, self.regulator, self.estimator)

    @property
    def cost_gap(self) -> float:
        """Distance of `cost` and `cost_from_riccati`, relative to the terms of the cost."""
        size = sum(map(abs, self.cost.terms.values()))
        return abs(self.cost.value - self.cost_from_riccati) / (size or np.inf)

    def plot(self) -> figures.Figure:
        """Plot the regulator and estimator poles, and the gain and phase of the controller."""
        from rcac_numeric.plots._lqg import plot_lqg

        return plot_lqg(self)

    def _sheet(self) -> Any:
        from rcac_numeric.reports._lqg import lqg_sheet

        return lqg_sheet(self)

    def _repr_html_(self) -> str:
        """Return the notebook view: cost, margins and the plot."""
        return notebook_of(self._sheet(), self.plot)

    def _repr_latex_(self) -> str:
        return rf"$\displaystyle J = {self.cost.value:.6g}, {state_space_latex(self.state_space)}$"

    def __repr__(self) -> str:
        least = min(self.regulator.margin, self.estimator.margin)
        return f"LQG({self.form}, n={self.plant.n}, J={self.cost.value:.6g}, margin={least:.3g})"


def lqg_controller(
    plant: Plant, *, noise: NoiseIntensities | None = None, form: str = "predictor"
) -> LQG:
    """Compute the controller of order n that minimises J = lim E[z'z] for white noise w.

    With P and Q the stabilising solutions of (A.7) and (A.8), S = R_2 + B'PB, V = V_2 + CQC',

    C_c = -S^{-1} (R_12' + B'PA),  B_c = (AQC' + V_12) V^{-1}

    the predictor form is x_c(k+1) = A x_c + B u + B_c e, u = C_c x_c, with the innovation
    e = y - C x_c - D_0 u: the best strictly proper controller. The filter form,
    u = C_c x_c + D_f e with

    D_f = -S^{-1} [(R_12' + B'PA) Q C' + (E_2'E_0 + B'P D_1) D_2'] V^{-1},

    uses y(k) for u(k) and is the best exactly proper one.

    Parameters
    ----------
    plant : Plant, StandardProblem in discrete time, or a system that `plant_of` reads
        R_1, R_12, R_2 are E_1'E_1, E_1'E_2, E_2'E_2 and V_1, V_12, V_2 are D_1D_1', D_1D_2',
        D_2D_2'; all may be singular or zero. R_2 = 0 and V_2 = 0 is high-authority LQG.
    noise : mapping, optional
        Which blocks or channels of w are noise, with their intensities, for example
        ``{"d": 1.0, "v": 0.25}``; see `noise_inputs`. Every channel with intensity 1 by default.
    form : {"predictor", "filter"}

    Returns
    -------
    LQG

    Raises
    ------
    NotControllableError, NotObservableError
        Where (A, B) is not stabilisable or (A, C) not detectable; the mode is named.
    UnitCircleError
        Where G_zu or G_yw has a zero on the unit circle; it is named.
    NoSolutionError
        Where the inputs outnumber what z sees of them, or the measurements the noises, with R_2
        or V_2 singular; the rank is named.
    IllConditionedError
        Where rounding decides the cost of the loop, or the loop's own cost and that of the Riccati
        solutions differ by more than 1e-6: the controller is then not what was designed.
    ImproperError
        Where D_0 lets no exactly proper controller of the filter form exist.

    Notes
    -----
    `compensator_theory.lqg_controller` answers the same exactly, for the predictor form, in
    continuous time too.

    Source: (A.1)-(A.12). Errata: "independent of E_0", said after (A.12), is true of the
    predictor form only; the filter form depends on E_2'E_0D_2'. The assumptions ii) and iv) must
    be "no zero on the unit circle" where R_2 or V_2 is singular, since (A.9) and (A.10) then have
    no meaning; and with R_2 = 0 it is the stabilising solution that is unique, not the
    positive-semidefinite one.

    Examples
    --------
    >>> from rcac_numeric import lqg_controller, servo_plant, standard_plant
    >>> best = lqg_controller(standard_plant("(q - 2)/(q**2 - 1/4)"))
    >>> best
    LQG(predictor, n=2, J=5.12, margin=0.5)
    >>> best.compensator.denominator.round(12), best.agreement.coefficient_distance < 1e-14
    (array([ 1. , -1. ,  0.4]), True)
    >>> plant = servo_plant("1/(q - 2)", performance="true")
    >>> lqg_controller(plant, noise={"d": 1.0, "v": 0.25}, form="filter").cost
    H2Cost(1.88278: d 1.05816, v 0.824626)
    """
    plant = linear_plant(plant)
    one_of(form, "form", FORMS)
    inputs = noise_inputs(plant, noise)
    regulator = stabilising_solution(
        plant.A, plant.B, weights(plant.E_1, plant.E_2), (plant.E_1, plant.E_2), REGULATOR
    )
    estimator = stabilising_solution(
        plant.A.T,
        plant.C.T,
        weights(inputs.D_1.T, inputs.D_2.T),
        (inputs.D_1.T, inputs.D_2.T),
        ESTIMATOR,
    )
    D_f = np.zeros((plant.l_u, plant.l_y))
    if form == "filter":
        D_f = filter_gain(plant, inputs, regulator, estimator)
    parts = controller_matrices(plant, regulator.K, -estimator.K.T, D_f)
    return _verified(
        LQG(
            plant=plant,
            noise=noise,
            form=form,
            regulator=regulator,
            estimator=estimator,
            state_space=parts,
            cost=h2_cost(plant, parts, noise=noise),
            cost_from_riccati=cost_of_solutions(inputs, regulator, estimator, D_f, plant.E_2),
        )
    )


def _verified(design: LQG) -> LQG:
    """Return the design, or raise if the costs of loop and Riccati solutions differ."""
    if np.isfinite(design.cost_from_riccati) and not design.cost_gap <= LARGEST_GAP:
        raise IllConditionedError(
            f"the loop of this LQG controller costs {design.cost.value:.6g}, its Riccati solutions "
            f"say {design.cost_from_riccati:.6g}: rounding decides (condition of the regulator "
            f"{design.regulator.condition:.1e}, of the estimator {design.estimator.condition:.1e})."
            " Scale states and signals to similar magnitude."
        )
    return design


# The innovation gain, the controller and the cost from two Riccati solutions.


def weights(E_1: Array, E_2: Array) -> tuple[Array, Array, Array]:
    """Return (R_1, R_12, R_2) = (E_1'E_1, E_1'E_2, E_2'E_2); transposes give noise weights."""
    with np.errstate(over="ignore", invalid="ignore"):
        weights = E_1.T @ E_1, E_1.T @ E_2, E_2.T @ E_2
    if not all(np.isfinite(weight).all() for weight in weights):
        largest = max(np.abs(E).max(initial=0.0) for E in (E_1, E_2))
        raise InputError(
            f"the squares of the entries of E_1, E_2, D_1 or D_2 are beyond float64 (the largest "
            f"entry is {largest:.3g}); scale z and w to similar magnitude."
        )
    return weights


def filter_gain(
    plant: Plant, inputs: NoiseInputs, regulator: StabilisingSolution,
    estimator: StabilisingSolution,
) -> Array:  # fmt: skip
    """Return D_f, the gain of the best estimate of C_c x - S^{-1}(E_2'E_0 + B'PD_1) w."""
    # From factors: weights are not squared.
    if regulator.P_root is not None and estimator.P_root is not None:
        S, T = regulator.P_root, estimator.P_root
        from_w = least_squares(
            np.vstack([plant.E_2, S @ plant.B]), np.vstack([inputs.E_0, S @ inputs.D_1])
        )
        return -least_squares(
            np.vstack([inputs.D_2.T, T @ plant.C.T]), np.vstack([from_w.T, T @ regulator.K.T])
        ).T
    known: Array = plant.E_2.T @ inputs.E_0 + plant.B.T @ regulator.P @ inputs.D_1
    from_w = np.asarray(-np.linalg.solve(regulator.innovation, known), dtype=float)
    correlation = regulator.K @ estimator.P @ plant.C.T + from_w @ inputs.D_2.T
    return np.asarray(np.linalg.solve(estimator.innovation, correlation.T).T)


def controller_matrices(plant: Plant, C_c: Array, B_c: Array, D_f: Array) -> StateSpace:
    """Return (A.4) with the direct term; with D_0 the innovation depends on u."""
    if not closes(-D_f, plant.D_0):
        raise ImproperError(
            "I + D_f D_0 is singular, so that the filter form is no proper controller of y; use "
            'form = "predictor".'
        )
    loop = np.eye(plant.l_u) + D_f @ plant.D_0
    C = np.asarray(np.linalg.solve(loop, C_c - D_f @ plant.C), dtype=np.float64)
    D = np.asarray(np.linalg.solve(loop, D_f), dtype=np.float64)
    through = plant.B - B_c @ plant.D_0
    return plant.A - B_c @ plant.C + through @ C, B_c + through @ D, C, D


def cost_of_solutions(
    inputs: NoiseInputs, regulator: StabilisingSolution, estimator: StabilisingSolution,
    D_f: Array, E_2: Array,
) -> float:  # fmt: skip
    """Return tr(P V_1) + tr(S C_c Q C_c') + tr(E_0 E_0') - tr(S D_f V D_f')."""
    K, Q = regulator.K, estimator.P
    if regulator.P_root is not None and estimator.P_root is not None:
        # S and V are squares, in which much cancels with large gains: their roots are used.
        of_u = np.vstack([E_2, regulator.P_root @ regulator.B])
        of_y = np.vstack([inputs.D_2.T, estimator.P_root @ estimator.B])
        spent = np.sum((of_u @ K @ estimator.P_root.T) ** 2)
        saved = np.sum((of_u @ D_f @ of_y.T) ** 2)
    else:
        S, V = regulator.innovation, estimator.innovation
        spent, saved = np.trace(S @ K @ Q @ K.T), np.trace(S @ D_f @ V @ D_f.T)
    return float(
        np.trace(inputs.D_1.T @ regulator.P @ inputs.D_1) + spent + np.sum(inputs.E_0**2) - saved
    )
