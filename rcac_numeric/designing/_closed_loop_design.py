"""RCAC settings from a reference loop: target, theta(0), prior and bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sympy import Matrix, Symbol

import compensator_theory as exact
from compensator_theory.errors import CompensatorError, InputError, NoSolutionError
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import rounded
from rcac_numeric.controllers._bounds import CoefficientBounds
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._kinds import feedforward, iir
from rcac_numeric.controllers._prior import PriorSamples
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.designing._expected import Expected
from rcac_numeric.designing._plants import DesignPlant
from rcac_numeric.designing._reference import Reference
from rcac_numeric.designing._truncation import Balanced
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel, from_transfer_function

STEPS = 4000  # of the run of the reference loop from which R_theta follows
KNOWN, UNKNOWN = (
    1000.0,
    300.0,
)  # default prior weight in samples, for a known and an unknown spectrum
WIDTH = 0.2  # of the bounds, over the rms of the reference's coefficients of u or of y
# Shares of the largest Hankel singular value that a truncation leaves out; less needs more digits.
LEFT_OUT = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2)
# Shares of the response to u: a smaller one is negligible; the most that a target may miss.
NEGLIGIBLE, MISSED = 0.03, 0.1
SLOWER = 1.0  # nu times the size of z


@dataclass(frozen=True)
class TuningParameters:
    """The tuning parameters of a closed-loop design, and their defaults.

    Attributes
    ----------
    samples : float or None
        The prior weight N_0; None: 1000 if the spectrum of d is known, else 300, times
        m^2 of m inputs and outputs, whose theta has as many times the coefficients.
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
        """The prior weight N_0 in samples."""
        return self.samples or (KNOWN if expected.is_known else UNKNOWN) * expected.m**2


def settings_of(
    plant: DesignPlant,
    reference: Reference,
    expected: Expected,
    parameters: TuningParameters | None = None,
) -> ControllerSettings:
    """RCAC's settings from a reference loop.

    G_f = N_zu q^n_c / chi_cl, the intercalated transfer function (4.18) of the reference loop;
    theta(0) the reference controller; R_theta = N_0 mean(Phi_f' Phi_f) in the reference loop under
    the expected signals, so that the prior is worth N_0 samples.
    """
    parameters = TuningParameters() if parameters is None else parameters
    G_c, servo, l_r = reference.compensator, plant.servo(), reference.commands
    if reference.structure is not None and reference.theta is not None:
        structure, theta_0 = reference.structure, reference.theta
    else:
        G_c = with_spare_order(G_c, parameters.spare)
        order, m = G_c.n_c, plant.m
        structure = feedforward(order, m, m, l_r) if l_r else iir(order, m, m)
        theta_0 = coefficients_of(G_c, plant.m)
    w = expected.prior_w(STEPS, reads_command=bool(l_r))
    run = simulate(servo, FixedController(G_c, l_r=l_r), w)
    target = intercalated_target(servo, G_c, run.u, structure)
    prior = PriorSamples(parameters.worth(expected), run.y, run.u, run.w[:, :l_r] if l_r else None)
    size = float(np.sqrt(np.mean(np.sum(run.z**2, axis=1))))
    return ControllerSettings(
        structure=structure, target=target, theta_0=theta_0,
        update=UD(R_theta=prior, lambda_=parameters.forgetting),
        R_z=SignalWeight(constant=1.0, nu=parameters.nu / size),
        k_w=0, k_update=max(structure.n_c, target.n_f),
        bounds=_box(theta_0, structure, parameters.width),
    )  # fmt: skip


def intercalated_target(
    servo: Plant, G_c: Compensator, u: Array, structure: Structure | None = None
) -> TargetModel:
    """The target model (4.18) of a loop, each coefficient rounded once; (4.16) for several inputs.

    The latter is close where u has power, and its delay exact. What a structure integrates by
    itself is not in its regressor of u: u~ enters behind it, and G_f has a zero at each pole of a
    derived signal.
    """
    if servo.l_u > 1:
        return _intercalated_matrix(servo, G_c, u)
    of_e = Compensator(G_c.past_u, G_c.past_y[:, :, :1], G_c.sample_time)
    exactly = exact.intercalated_transfer_function(
        servo.problem,
        exact.polynomial(of_e.numerator.tolist(), "q"),
        exact.polynomial(of_e.denominator.tolist(), "q"),
    )
    poles = {one.pole for one in structure.derived} - {0.0} if structure is not None else set()
    for pole in sorted(poles):
        exactly = exactly * exact.transfer_function(f"(q - {exact.exact_number(pole)})/q")
    try:
        rounded = from_transfer_function(exactly)
        # The rounded poles are checked again, since the controller runs with them.
        return TargetModel(rounded.numerator, rounded.denominator)
    except InputError:
        raise _marginal(ClosedLoop(servo, G_c).spectral_radius) from None


def _marginal(radius: float) -> NoSolutionError:
    """The error for a loop whose stability is within rounding."""
    return NoSolutionError(
        f"the best loop around this plant has a pole of modulus {radius:.9g}, which rounding moves "
        "out of the unit circle: a pole of the plant is close to a zero near z = 1, or its "
        "dynamics are slow for the sample time. Sample more slowly; give the disturbance as "
        "noise, WhiteNoise(...), if it has no constant part; or leave the slow pole out of the "
        "plant."
    )


def _intercalated_matrix(servo: Plant, G_c: Compensator, u: Array) -> TargetModel:
    """Return (4.16) over one denominator, of an order that float64 coefficients support.

    Its delay is exact, and the rest is truncated in balanced coordinates: to the highest order
    whose `miss` is below 0.03, or that of the least, below 0.1.
    """
    loop = ClosedLoop(servo, G_c)
    A, B, C, _ = loop.matrices
    B, C = B[:, servo.l_w :], C[: servo.l_z]  # u_tilde acts inside the compensator
    delay = 1
    while delay < len(A) and not np.abs(C @ B).max() > np.finfo(float).eps * np.linalg.norm(C):
        C, delay = C @ A, delay + 1
    omega = np.linspace(0, np.pi, len(u) // 2 + 1)
    response = loop.intercalated_response(omega)
    coefficients = []
    for share in LEFT_OUT:
        try:
            one = _over_one_denominator(advanced(A, B, C, share), delay)
        except CompensatorError:  # rounded to float64 it is unstable
            continue
        coefficients.append((miss(one.frequency_response(omega), response, u), one))
        if coefficients[-1][0] < NEGLIGIBLE:
            return one
    least, target = min(coefficients, key=lambda one: one[0], default=(np.inf, None))
    if target is None or not least < MISSED:
        raise NoSolutionError(
            f"no target model with float64 coefficients is close to the loop of order {len(A)} of "
            "this plant; sample more slowly, or take a fixed controller, `lqg_controller`."
        )
    return target


def miss(response: ComplexArray, reference: ComplexArray, u: Array) -> float:
    """Return the relative error of a response to u against the target, the largest of all octaves.

    max over octaves of norm((G - G_wanted) U)/norm(G_wanted U), and the same over all frequencies;
    octaves with less than 0.03 of the response count in the latter alone.
    """
    U = np.fft.rfft(np.hanning(len(u))[:, None] * u, axis=0)[:, :, None]
    error, size = (
        np.sum(np.abs(G @ U) ** 2, axis=(1, 2)) for G in (response - reference, reference)
    )
    k = np.maximum(np.arange(len(U)), 1)
    octave = np.floor(np.log2(k[-1] / k)).astype(int)
    errors, sizes = (np.bincount(octave, one) for one in (error, size))
    is_significant = sizes > NEGLIGIBLE**2 * sizes.sum()
    worst = max(errors.sum() / sizes.sum(), np.max(errors[is_significant] / sizes[is_significant]))
    return float(np.sqrt(worst))


def advanced(A: Array, B: Array, C: Array, share: float) -> StateSpace:
    """Realise C(qI - A)^-1 B q without states below a share of the largest Hankel singular value.

    In balanced coordinates: the states that are reached and seen least are left out, and what is
    left is stable.
    """
    balanced = Balanced(A, B, C @ A)
    hankel = balanced.hankel
    order = max(int((hankel > share * hankel[0]).sum()), 1)
    return *balanced.truncated(order), C @ B


def _over_one_denominator(parts: StateSpace, delay: int) -> TargetModel:
    """Return q^-delay (D + C(qI - A)^-1 B), each coefficient computed exactly and rounded once."""
    a, b, c, d = (
        Matrix(*m.shape, [exact.exact_number(float(entry), binary=True) for entry in m.ravel()])
        for m in parts
    )
    transfer = transfer_matrix_of_realisation(a, b, c, d, Symbol("q"))
    powers = range(transfer.denominator.degree(), -1, -1)
    chi = rounded([transfer.denominator.nth(k) for k in powers], "the target model's denominator")
    entries = [entry for row in transfer.numerators for entry in row]
    N = rounded([entry.nth(k) for k in powers for entry in entries], "the target model's numerator")
    N = np.reshape(N, (len(powers), *transfer.shape))
    late = np.zeros((delay, *transfer.shape))
    return TargetModel(np.concatenate([late, N]), np.multiply.outer(chi, np.eye(transfer.shape[0])))


def coefficients_of(G_c: Compensator, l_y: int) -> Array:
    """Return theta of a strictly proper compensator: for each tap the coefficients of every u.

    Its taps are past u, past y, and the past commands behind the l_y measurements.
    """
    blocks = [*G_c.past_u, *G_c.past_y[1:, :, :l_y], *G_c.past_y[1:, :, l_y:]]
    return np.concatenate([block.T.ravel() for block in blocks])


def with_spare_order(G_c: Compensator, spare: int) -> Compensator:
    """Raise the order of a controller by poles and zeros at 0."""
    if not spare:
        return G_c
    padding = [(0, spare), (0, 0), (0, 0)]
    return Compensator(np.pad(G_c.past_u, padding), np.pad(G_c.past_y, padding), G_c.sample_time)


def _box(theta_0: Array, structure: Structure, width: float) -> CoefficientBounds:
    """Bounds around theta(0), wide in proportion to the rms of the coefficients of each signal."""
    groups = [(tap.signal, tap.component * (tap.signal == "derived")) for tap in structure.taps]
    rows = theta_0.reshape(-1, structure.l_u)
    margin = np.zeros_like(rows)
    for group in dict.fromkeys(groups):
        members = [i for i, one in enumerate(groups) if one == group]
        margin[members] = width * np.sqrt(np.mean(rows[members] ** 2))
    low, high = theta_0 - margin.ravel(), theta_0 + margin.ravel()
    return CoefficientBounds(low, high, method="metric")
