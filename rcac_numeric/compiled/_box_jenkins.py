"""Prediction errors of Box-Jenkins and ARMAX models, by the kernel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._kernel import BoxJenkinsErrors

__all__ = [
    "BoxJenkinsErrors", "BoxJenkinsStructure", "box_jenkins_errors", "confined",
    "least_box_jenkins_errors", "student_scale",
]  # fmt: skip


class _Arguments(TypedDict):
    y: Array
    u: Array
    levels: Array
    weights: Array
    orders: tuple[int, int, int, int]
    differences: bool
    armax: bool
    sinusoid: bool
    dependent: float


@dataclass(frozen=True, eq=False)
class BoxJenkinsStructure:
    """A record and the orders of A, B, C and D.

    `levels` are rows of a free size. Of a free row of which the others leave less than `dependent`
    of its norm nothing is projected out.
    """

    y: Array
    u: Array
    levels: Array
    weights: Array | None
    orders: tuple[int, int, int, int]
    differences: bool
    armax: bool
    sinusoid: bool
    dependent: float

    @property
    def arguments(self) -> _Arguments:
        """As the kernel reads them."""
        return {
            "y": _contiguous(self.y), "u": _contiguous(self.u),
            "levels": _contiguous(self.levels),
            "weights": np.zeros(0) if self.weights is None else _contiguous(self.weights),
            "orders": self.orders, "differences": self.differences, "armax": self.armax,
            "sinusoid": self.sinusoid, "dependent": self.dependent,
        }  # fmt: skip


def _contiguous(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def box_jenkins_errors(structure: BoxJenkinsStructure, theta: Array) -> BoxJenkinsErrors | None:
    """Errors at the coefficients of A, B, C, D and a frequency; None where they leave float64."""
    return _kernel.box_jenkins_errors(**structure.arguments, theta=_contiguous(theta))


def least_box_jenkins_errors(
    structure: BoxJenkinsStructure, theta: Array, *, kept: int, iterations: int, widths: int,
    decrease: float, settled: float, circle: float, of_C: float,
) -> tuple[BoxJenkinsErrors, Array] | None:  # fmt: skip
    """The least errors from some coefficients, and their derivatives; None where they fail there.

    By Levenberg and Marquardt: `widths` damping factors in an iteration, of which one that lowers
    N log(sum of squares) by less than `decrease` is the last, and one that promises less than
    `settled` of that is not tried. The first `kept` coefficients do not move. Roots of A and D are
    kept within `circle`, those of C within `of_C`; of an ARMAX model A is free.
    """
    return _kernel.least_box_jenkins_errors(
        **structure.arguments, theta=_contiguous(theta), kept=kept, iterations=iterations,
        widths=widths, decrease=decrease, settled=settled, circle=circle, of_C=of_C,
    )  # fmt: skip


def confined(A: Array, radius: float) -> Array:
    """A, of which the first is 1, with its roots outside a circle reflected into it.

    Those outside the circle but within the reciprocal of its radius are pulled onto it.
    """
    return _kernel.confined_roots(_contiguous(A), radius)


def student_scale(e: Array, degrees: float, least: float, passes: int) -> float:
    """The scale of Student's t of some degrees that errors show, not below the least one.

    By passes of reweighted squares from their median.
    """
    return _kernel.student_scale(_contiguous(e), degrees, least, passes)
