"""The closed loop in ball arithmetic: what RCAC does when rounding plays no part.

An independent transcription of section 2.3, without the kernel's taps and filters: Phi(k) is
built from (2.30), filtered as a matrix by (2.40), and theta updated by (2.42)-(2.45) as printed.
Every number is a ball that contains the exact result on the given float64 data.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.plants import MATRICES, Plant
from rcac_numeric.prepared_runs import check_sizes
from rcac_numeric.runs import Run
from rcac_numeric.structures import Structure
from rcac_numeric.validation import Array, integer, signal_array


@dataclass(frozen=True, eq=False)
class ReferenceRun(Run):
    """A run in ball arithmetic, rounded once to float64 at the end.

    Attributes
    ----------
    digits : float
        Certified correct digits of the least accurate entry of theta_final, relative to the
        largest entry.
    """

    digits: float = float("nan")


def simulate_reference(
    plant: Plant, settings: ControllerSettings, w: ArrayLike, *, digits: int = 250
) -> ReferenceRun:
    """The run that `simulate` approximates, with `digits` decimal digits.

    Parameters
    ----------
    plant, settings, w
        As for `simulate`; the float64 data are taken as exact. The update is the recursive one
        with constant weights and nothing that changes on the way.
    digits : int
        Working precision. Balls grow by about one digit every few steps, so a few hundred digits
        serve a few hundred steps.

    Raises
    ------
    InputError
        Where sizes do not fit, or the settings ask for something that the reference does not do.
    DivergedError
        Where the balls have grown until nothing is certain.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), R_theta=1e-20)
    >>> w = exogenous([step()], steps=20)
    >>> reference = simulate_reference(plant, settings, w)
    >>> reference.digits > 100
    True
    """
    require_supported(plant, settings)
    check_sizes(plant, settings)
    w = signal_array(w, "w", plant.l_w)
    precision, ctx.prec = ctx.prec, int(integer(digits, "digits", at_least=16) * 3.33) + 8
    try:
        return _run(plant, settings, w)
    finally:
        ctx.prec = precision


def require_supported(
    plant: Any, settings: Any, saturation: Any = None
) -> tuple[Plant, ControllerSettings]:
    """Refuse what the reference would otherwise leave out of the run without a word."""
    if not isinstance(plant, Plant):
        raise InputError(f"the reference needs a plant that does not change, not {plant!r}.")
    if not isinstance(settings, ControllerSettings):
        raise InputError("the reference runs one controller, not a decentralised one.")
    if saturation is not None:
        raise InputError("the reference runs without saturation.")
    other = [tap.signal for tap in settings.structure.taps if tap.signal not in ("u", "y")]
    if other:
        raise InputError(
            f"the reference knows regressors of u and y; this {settings.structure.name} structure "
            f"has taps on {', '.join(sorted(set(other)))}."
        )
    for name in ("R_z", "R_u"):
        if not isinstance(getattr(settings, name), np.ndarray):
            raise InputError(f"the reference needs a constant {name}, not a function of signals.")
    if settings.update not in ("ud", "covariance") or settings.form != "predictor":
        raise InputError(
            "the reference runs the recursive update (2.42)-(2.45) in predictor form, not "
            f'update = "{settings.update}" with form = "{settings.form}".'
        )
    for name in (
        "process_noise", "forgetting", "lambda_changes", "target_changes", "reset", "freeze",
        "reflect_poles",
    ):  # fmt: skip
        value = getattr(settings, name)
        if value is not None and not (isinstance(value, bool | dict | tuple) and not value):
            raise InputError(f"the reference does not know {name}; leave it out.")
    return plant, settings


def _run(plant: Plant, settings: ControllerSettings, w: Array) -> ReferenceRun:
    m = {name: _balls(getattr(plant, name)) for name in MATRICES}
    structure, target, n_f = settings.structure, settings.target, settings.target.n_f
    l_u, l_z, l_theta = plant.l_u, plant.l_z, structure.l_theta
    N = [_balls(c) for c in target.numerator]
    D = [_balls(c) for c in target.denominator]
    R_z, R_u = _balls(settings.R_z), _balls(settings.R_u)
    W_inv = (R_z + R_u).inv()
    lam = arb(settings.lambda_)
    theta = _balls(settings.theta_0.reshape(-1, 1))
    P = _balls(settings.R_theta).inv()

    x = arb_mat(plant.n, 1)
    record: dict[str, list[arb_mat]] = {name: [] for name in ("u", "y", "z", "theta")}
    past: dict[str, list[arb_mat]] = {"Phi": [], "u": [], "Phi_f": [], "u_f": []}
    for k, row in enumerate(w):
        w_k = _balls(row.reshape(-1, 1))
        record["theta"].append(theta)
        if structure.measures_first:
            record["y"].append(m["C"] * x + m["D_2"] * w_k)
        Phi = _regressor(structure, record, k)
        u = Phi * theta if k >= settings.k_w else arb_mat(l_u, 1)
        record["u"].append(u)
        if not structure.measures_first:
            record["y"].append(m["C"] * x + m["D_0"] * u + m["D_2"] * w_k)
        z = m["E_1"] * x + m["E_2"] * u + m["E_0"] * w_k
        record["z"].append(z)

        seen = k >= settings.k_filter
        past["Phi"].append(Phi if seen else arb_mat(l_u, l_theta))
        past["u"].append(u if seen else arb_mat(l_u, 1))
        for name, columns in (("Phi", l_theta), ("u", 1)):
            output = arb_mat(l_z, columns)
            for i in range(min(k, n_f) + 1):
                output = output + N[i] * past[name][k - i]
                if i > 0:
                    output = output - D[i] * past[f"{name}_f"][k - i]
            past[f"{name}_f"].append(output)
        if k >= settings.k_update:
            Phi_f, u_f = past["Phi_f"][k], past["u_f"][k]
            PPhi = P * Phi_f.transpose()
            try:
                gain = PPhi * (W_inv * lam + Phi_f * PPhi).inv()
            except ZeroDivisionError:
                raise DivergedError(
                    f"the balls have lost every digit at step {k}: Upsilon cannot be told from a "
                    "singular matrix. Use more digits or fewer steps, and look whether the loop "
                    "diverges in float64."
                ) from None
            theta = theta - gain * (Phi_f * theta + W_inv * R_z * (z - u_f))
            P = (P - gain * (Phi_f * P)) * (1 / lam)
        x = m["A"] * x + m["B"] * u + m["D_1"] * w_k

    rounded = {
        name: np.array([[float(b.mid()) for b in v.entries()] for v in values])
        for name, values in record.items()
    }
    final = theta.entries()
    size = max(abs(float(b.mid())) for b in final) or 1.0
    worst = max(float(b.rad()) for b in final)
    return ReferenceRun(
        plant=plant,
        settings=settings,
        w=w,
        u=rounded["u"],
        y=rounded["y"],
        z=rounded["z"],
        theta=rounded["theta"],
        theta_final=np.array([float(b.mid()) for b in final]),
        stride=1,
        outcome="completed",
        guard_count=0,
        guard_first_step=-1,
        u_applied=rounded["u"],
        digits=float("inf") if worst == 0 else float(-np.log10(worst / size)),
    )


def _regressor(structure: Structure, record: dict[str, list[arb_mat]], k: int) -> arb_mat:
    """Phi(k) = phi(k)' (x) I of (2.30), with zeros before step 0."""
    l_u = structure.l_u
    Phi = arb_mat(l_u, structure.l_theta)
    for j, tap in enumerate(structure.taps):
        if k >= tap.delay:
            value = record[tap.signal][k - tap.delay][tap.component, 0]
            for i in range(l_u):
                Phi[i, j * l_u + i] = value
    return Phi


def _balls(values: Any) -> arb_mat:
    array = np.asarray(values, dtype=np.float64)
    return arb_mat(*array.shape, [arb(float(v)) for v in array.ravel()])
