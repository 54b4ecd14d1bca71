"""The matrix R_theta of a prior that is worth so many samples."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.regressor import filtered_regressor, has_common_filter, regressor_of
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.controllers.updates.prior import PriorSamples
from rcac_numeric.targets.model import TargetModel

FLOOR = 1e-4  # of the diagonal of the mean of Phi_f' Phi_f
SLOWEST = 0.99  # an integral counts as a lag of so many steps
FREQUENCIES = 4097  # at which the size of G_f is summed


def prior_weight(prior: PriorSamples, structure: Structure, target: TargetModel) -> Array:
    """R_theta = samples * mean(Phi_f' Phi_f), of a record or of white signals of these sizes."""
    widths = structure.l_u, structure.l_y, structure.l_r
    for name, signal, width in zip("uyr", (prior.u, prior.y, prior.r), widths, strict=True):
        if signal is None:
            if name == "r" and width:
                raise InputError("the structure reads r: give PriorSamples its size or record.")
            continue
        if width and signal.shape[-1] not in ((width,) if prior.is_record else (1, width)):
            raise InputError(
                f"PriorSamples: {name} has {signal.shape[-1]} components, and the structure reads "
                f"{width}."
            )
    if not prior.is_record:
        return prior.samples * _of_sizes(prior, structure, target)
    if not has_common_filter(target):
        raise InputError(
            "the target model has a denominator of its own for each output: give PriorSamples "
            "the sizes of y and u, and no record."
        )
    assert prior.u is not None
    return prior.samples * mean_information(structure, target, prior.u, prior.y, prior.r)


def mean_information(
    structure: Structure, target: TargetModel, u: Array, y: Array, r: Array | None = None
) -> Array:
    """The mean of Phi_f' Phi_f over a record, with a floor of 1e-4 of its own diagonal."""
    phi = regressor_of(structure, {"u": u, "y": y, "r": r}, np.asarray)
    Phi_f = filtered_regressor(phi, target).reshape(-1, structure.l_theta)
    found = Phi_f.T @ Phi_f / len(phi)
    found = (found + found.T) / 2
    return found + FLOOR * np.diag(np.diag(found))


def _of_sizes(prior: PriorSamples, structure: Structure, target: TargetModel) -> Array:
    """The same of white signals of these sizes, each independent of the others."""
    omega = np.linspace(0, np.pi, FREQUENCIES)
    responses, past = target.frequency_response(omega), np.exp(-1j * omega)
    weights = np.r_[0.5, np.ones(FREQUENCIES - 2), 0.5] / (FREQUENCIES - 1)
    spectrum = np.einsum("w,wzi,wzj->wij", weights, responses.conj(), responses)
    through = np.linalg.norm(prior.y) / np.sqrt(np.diag(spectrum.sum(axis=0).real))
    sizes = np.concatenate([
        np.broadcast_to(through if prior.u is None else prior.u, structure.l_u),
        np.broadcast_to(prior.y, structure.l_y),
        np.broadcast_to(0.0 if prior.r is None else prior.r, structure.l_r),
    ])  # fmt: skip
    first = {"u": 0, "y": structure.l_u, "r": structure.l_u + structure.l_y}
    reads = np.zeros((len(sizes), len(structure.taps), FREQUENCIES), dtype=np.complex128)
    for i, tap in enumerate(structure.taps):
        late = past**tap.delay
        if tap.signal != "derived":
            reads[first[tap.signal] + tap.component, i] = late
            continue
        own = structure.derived[tap.component]
        lag = late / (1 - np.clip(own.pole, -SLOWEST, SLOWEST) * past)
        for j, (now, before) in enumerate(zip(own.now, own.before, strict=True)):
            reads[structure.l_u + j, i] = (now + before * past) * lag
    reads *= sizes[:, None, None]
    found = np.einsum("csw,ctw,wij->sitj", reads.conj(), reads, spectrum, optimize=True).real
    found = found.reshape(structure.l_theta, structure.l_theta)
    found = (found + found.T) / 2
    return np.asarray(found + FLOOR * np.diag(np.diag(found)))
