"""The settings of RCAC that a reference loop leads to: target, start, prior and bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import compensator_theory as exact
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.checks.regressor import regressor_of
from rcac_numeric.controllers.bounds import CoefficientBounds
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.controllers.kinds import iir
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.controllers.updates.recursive import UD
from rcac_numeric.controllers.weights import SignalWeight
from rcac_numeric.engine.simulation import simulate
from rcac_numeric.health.excitation import filtered_regressor
from rcac_numeric.plants.linear import Plant
from rcac_numeric.synthesis.expected import Expected
from rcac_numeric.synthesis.plants import DesignPlant
from rcac_numeric.synthesis.reference import Reference
from rcac_numeric.targets.model import TargetModel, from_transfer_function

STEPS = 4000  # of the run of the reference loop that R_theta is made of
KNOWN, UNKNOWN = 1000.0, 300.0  # samples that the prior is worth, with the spectrum known or not
FLOOR = 1e-4  # of the diagonal of the mean of Phi_f' Phi_f
WIDTH = 0.2  # of the bounds, over the rms of the reference's coefficients of u or of y
SLOWER = 1.0  # nu times the size of z


@dataclass(frozen=True)
class Knobs:
    """What of the settings is a choice, and what the road chooses.

    Attributes
    ----------
    samples : float or None
        N_0, what the prior is worth; None: 1000 where the spectrum of d is known, else 300.
    nu : float
        Of R_z = 1/(1 + nu abs(z))^2, times the size of z.
    width : float
        Of the bounds, over the rms of the coefficients of u or of y.
    spare : int
        Order beyond that of the reference.
    forgetting : float
        lambda of the update.
    """

    samples: float | None = None
    nu: float = SLOWER
    width: float = WIDTH
    spare: int = 0
    forgetting: float = 1.0

    def worth(self, expected: Expected) -> float:
        """N_0, in samples."""
        return self.samples or (KNOWN if expected.is_known else UNKNOWN)


def settings_of(
    plant: DesignPlant, reference: Reference, expected: Expected, knobs: Knobs | None = None
) -> ControllerSettings:
    """RCAC's settings from a reference loop.

    G_f = N_zu q^n_c / chi_cl, the intercalated transfer function (4.18) of the reference loop;
    theta(0) the reference controller; R_theta = N_0 mean(Phi_f' Phi_f) in the reference loop under
    the expected signals, so that the prior is worth N_0 samples.

    Parameters
    ----------
    plant : DesignPlant
    reference : Reference
    expected : Expected
    knobs : Knobs, optional
    """
    knobs = Knobs() if knobs is None else knobs
    G_c = with_spare_order(reference.compensator, knobs.spare)
    structure, servo = iir(G_c.n_c), plant.servo()
    target = intercalated_target(servo, G_c)
    theta_0 = np.concatenate([G_c.past_u.ravel(), G_c.past_y[1:].ravel()])
    run = simulate(servo, FixedController(G_c), expected.prior_w(STEPS))
    information = mean_information(structure, target, run.u, run.y)
    size = float(np.sqrt(np.mean(run.z**2)))
    return ControllerSettings(
        structure=structure, target=target, theta_0=theta_0,
        update=UD(R_theta=knobs.worth(expected) * information, lambda_=knobs.forgetting),
        R_z=SignalWeight(constant=1.0, nu=knobs.nu / size),
        k_w=0, k_update=max(structure.n_c, target.n_f),
        bounds=_box(theta_0, G_c.n_c, knobs.width),
    )  # fmt: skip


def intercalated_target(servo: Plant, G_c: Compensator) -> TargetModel:
    """(4.18) of a loop with scalar u and z, each coefficient rounded once."""
    exactly = exact.intercalated_transfer_function(
        servo.problem,
        exact.polynomial(G_c.numerator.tolist(), "q"),
        exact.polynomial(G_c.denominator.tolist(), "q"),
    )
    rounded = from_transfer_function(exactly)
    # Its poles are asked for once more, as the controller runs it: rounded.
    return TargetModel(rounded.numerator, rounded.denominator)


def mean_information(structure: Structure, target: TargetModel, u: Array, y: Array) -> Array:
    """The mean of Phi_f' Phi_f over a run, with a floor of 1e-4 of its own diagonal."""
    phi = regressor_of(structure, {"u": u, "y": y, "r": None}, np.asarray)
    Phi_f = filtered_regressor(phi, target)[:, 0]
    found = Phi_f.T @ Phi_f / len(Phi_f)
    found = (found + found.T) / 2
    return found + FLOOR * np.diag(np.diag(found))


def with_spare_order(G_c: Compensator, spare: int) -> Compensator:
    """The same controller of a higher order: its new poles and zeros are at 0."""
    if not spare:
        return G_c
    padding = [(0, spare), (0, 0), (0, 0)]
    return Compensator(np.pad(G_c.past_u, padding), np.pad(G_c.past_y, padding), G_c.sample_time)


def _box(theta_0: Array, n_c: int, width: float) -> CoefficientBounds:
    """theta(0) with a margin of the rms of the coefficients of u, and of those of y."""
    margin = np.concatenate([
        np.full(n_c, width * np.sqrt(np.mean(block**2))) for block in np.split(theta_0, [n_c])
    ])  # fmt: skip
    return CoefficientBounds(theta_0 - margin, theta_0 + margin, method="metric")
