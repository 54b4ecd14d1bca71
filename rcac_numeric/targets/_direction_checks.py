"""Check of the NMP zeros and zero directions of a target model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import instance_of, number
from rcac_numeric.arrays._values import Result
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._zero_directions import (
    DirectionInformation,
    direction_information,
)

# Singular values below this share of the norm of G_f count as zero.
SINGULAR = 1e-6
VERDICTS = {
    "kept": "has the zero in the plant's direction",
    "not a zero": "has no zero there: the controller that matches it has a pole at the zero, "
    "which hides an instability",
    "in every channel": "is zero there in every direction and so requires more zeros than the "
    "plant has",
    "in one channel": "has the zero in one channel alone, which is not the plant's direction",
    "on the input side": "blocks the plant's input direction, as a left numerator of G_zu does; "
    "it is the output direction that must be kept",
    "in another direction": "has a zero there in a direction that is not the plant's",
}


@dataclass(frozen=True, eq=False)
class DirectionCheck(Result):
    """The angle and the kind of error of a target model at each NMP zero of G_zu.

    Attributes
    ----------
    zeros : array, shape (number of zeros,)
        The plant's; of a complex pair one.
    angles : array, shape (number of zeros,)
        arcsin of norm(eta' G_f(z0)) / (norm(eta) norm(G_f(z0))), in degrees: 0 where kept.
    forms : tuple of str
        "kept", "not a zero", "in every channel", "in one channel", "on the input side", or "in
        another direction".
    tolerance : float
        The largest angle that counts as kept, in degrees.
    """

    _ANSWER = "is_kept"

    zeros: ComplexArray
    angles: Array
    forms: tuple[str, ...]
    tolerance: float

    @property
    def is_kept(self) -> bool:
        """Whether every zero is kept in the plant's direction only."""
        return all(form == "kept" for form in self.forms)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence for each zero that is not kept."""
        rows = zip(self.zeros, self.angles, self.forms, strict=True)
        return tuple(
            f"at the NMP zero {_shown(zero)} the target model {VERDICTS[form]} "
            f"({angle:.3g} degrees off)"
            for zero, angle, form in rows
            if form != "kept"
        )

    def __str__(self) -> str:
        return "\n".join(self.warnings) or f"keeps {len(self.forms)} NMP zeros"


def check_directions(
    target: TargetModel, source: Plant | DirectionInformation, tolerance: float = 5.0
) -> DirectionCheck:
    """Check eta' G_f(z0) = 0 at every NMP zero of G_zu, and classify the errors.

    Parameters
    ----------
    target : TargetModel
    source : Plant or DirectionInformation
        Of a square G_zu.
    tolerance : float
        In degrees. Measured on plants with two inputs and outputs: a direction that is off by 5
        degrees costs 1 % or less, one that is off by 30 tens of percents, or the loop.

    Raises
    ------
    InputError
        If G_zu is not square, sizes do not fit, or a zero is a pole of the target.

    Notes
    -----
    What (4.18) becomes with several signals, q^n_c G_zu (D_c - N_c G_yu)^-1, has the left zero
    directions of G_zu unless the controller cancels them. A target without them can be matched
    only with a controller pole at the zero, which z does not show. A zero too many, or elsewhere,
    cannot be matched at all. The full left numerator of G_zu as a target is right only where the
    denominator is one scalar for all outputs: else its directions are not those of G_zu.

    Examples
    --------
    >>> from rcac_numeric import TargetModel
    >>> from rcac_numeric.targets import DirectionInformation, check_directions
    >>> known = DirectionInformation(H=[[1, 0], [0, 1]], zeros=[(1.5, [1, 1])])
    >>> delay = TargetModel([[[0, 0], [0, 0]], [[1, 0], [0, 1]]])
    >>> check_directions(delay, known).forms
    ('not a zero',)
    """
    instance_of(target, "target", TargetModel)
    if not isinstance(source, DirectionInformation):
        source = linear_plant(source, "source")
    known = direction_information(source) if isinstance(source, Plant) else source
    rows, columns = known.H.shape
    if rows != columns or (target.l_z, target.l_u) != (rows, columns):
        raise InputError(
            f"G_zu is {rows} x {columns} and G_f {target.l_z} x {target.l_u}; square matrices of "
            f"equal size are needed."
        )
    limit = number(tolerance, "tolerance")
    zeros = list(dict.fromkeys(z0 for z0, _ in known.zeros))
    angles, forms = [], []
    for z0 in zeros:
        G_f = _value(target, z0)
        etas = np.array([eta for other, eta in known.zeros if other == z0]).T
        angles.append(_angle(etas, G_f))
        inputs = _input_directions(source, z0) if isinstance(source, Plant) else None
        forms.append(_form(G_f, target, etas, inputs, angles[-1] <= limit))
    return DirectionCheck(np.array(zeros, dtype=complex), np.array(angles), tuple(forms), limit)


def _angle(etas: ComplexArray, G_f: ComplexArray) -> float:
    """Return the largest angle over the combinations of the directions, in degrees."""
    size = float(np.linalg.norm(G_f, 2))
    if size == 0.0:
        return 0.0
    basis, _ = np.linalg.qr(etas)
    worst = float(np.linalg.norm(basis.T @ G_f, 2)) / size
    return float(np.degrees(np.arcsin(min(worst, 1.0))))


def _form(
    G_f: ComplexArray,
    target: TargetModel,
    etas: ComplexArray,
    inputs: ComplexArray | None,
    has_zero: bool,
) -> str:
    scale = float(np.abs(target.numerator).sum(axis=0).max())
    U, singular, _ = np.linalg.svd(G_f)
    lost = int((singular <= SINGULAR * scale).sum())
    if lost > etas.shape[1]:
        return "in every channel" if lost == len(G_f) else "in another direction"
    if has_zero:
        return "kept"
    if lost == 0:
        return "not a zero"
    blocked = U[:, -lost:]
    if lost == 1 and np.abs(blocked).max() > 1 - SINGULAR:
        return "in one channel"
    if inputs is not None and np.linalg.norm(G_f @ inputs, 2) <= SINGULAR * scale:
        return "on the input side"
    return "in another direction"


def _value(target: TargetModel, z0: complex) -> ComplexArray:
    powers = z0 ** -np.arange(target.n_f + 1.0)
    numerator = np.tensordot(powers, target.numerator, 1)
    try:
        return np.asarray(
            scipy.linalg.solve(np.tensordot(powers, target.denominator, 1), numerator)
        )
    except np.linalg.LinAlgError:
        raise InputError(f"the zero {z0:.6g} of the plant is a pole of the target model.") from None


def _input_directions(plant: Plant, z0: complex) -> ComplexArray:
    """Return the right null vectors of G_zu(z0); z0 is no pole."""
    G = plant.E_1 @ np.linalg.solve(z0 * np.eye(plant.n) - plant.A, plant.B) + plant.E_2
    _, singular, V = np.linalg.svd(G)
    count = max(1, int((singular <= SINGULAR * singular[0]).sum()))
    return np.asarray(V[-count:].conj().T)


def _shown(zero: complex) -> str:
    return f"{zero.real:.6g}" if zero.imag == 0 else f"{zero:.6g}"
