"""The report of an exact pole placement, with the accuracy of float64."""

from __future__ import annotations

from typing import Any

import compensator_theory as exact
from compensator_theory.errors import CompensatorError
from compensator_theory.polynomials._poly import is_rational
from rcac_numeric.analysis._placement_conditioning import PlacementConditioning, compared_solves
from rcac_numeric.reports._sheet import Section, Sheet, Text


def placement_sheet(placement: exact.results.PolePlacement) -> Sheet:
    """The compensator, the number of solutions, and the accuracy of the float64 solution."""
    section = _conditioning(placement)
    lines = [Text(line) for line in str(placement).splitlines()]
    if placement.numerator.is_zero:
        lines.insert(0, Text(_of_zero(placement), "warning"))
    if section is not None:
        is_worse = section.target_is_stable and not section.float64_is_stable
        lines.append(Text(f"in float64: {section}", "bad" if is_worse else "plain"))
    record = {
        "plant": str(placement.plant),
        "feedback": placement.feedback,
        "order": int(placement.denominator.degree()),
        "compensator": str(placement.compensator),
        "numerator": _written(placement.numerator),
        "denominator": _written(placement.denominator),
        "closed_loop": _written(placement.target),
        "is_unique": placement.is_unique,
        "residual_is_zero": bool(placement.residual.is_zero),
        "summary": str(placement),
        "is_rational": all(map(is_rational, (placement.target, placement.numerator))),
        "float64": None if section is None else {
            "condition_number": section.condition_number,
            "relative_error": section.relative_error,
            "digits": section.digits,
            "is_stable": section.float64_is_stable,
            "target_is_stable": section.target_is_stable,
            "summary": str(section),
        },
    }  # fmt: skip
    health: tuple[Text, ...] = ()
    if section is not None and not section.target_is_stable:
        z = placement.target.gen
        where = "left of the imaginary axis" if z.name == "s" else "inside the unit circle"
        health = (
            Text(f"The requested closed loop is UNSTABLE: stable poles in {z} are {where}.", "bad"),
        )
    return Sheet(
        f"G = {placement.plant}", health=health, sections=(Section("", tuple(lines), record),)
    )


def _of_zero(placement: exact.results.PolePlacement) -> str:
    """Explain the result G_c = 0, which a user does not expect."""
    n, n_c = placement.plant.denominator.degree(), placement.denominator.degree()
    parts = [f"the plant alone has {n} of the requested poles"] * (n > 0)
    parts += [f"D_c has {'the others' if n else 'them'}"] * (n_c > 0)
    several = "" if placement.is_unique else ", one of several solutions,"
    return f"G_c = 0{several} places the poles: {', '.join(parts)}. There is no feedback."


def _conditioning(placement: exact.results.PolePlacement) -> PlacementConditioning | None:
    """The accuracy of the float64 solution; None if it is undefined."""
    try:
        return compared_solves(placement)
    except CompensatorError:
        return None


def _written(polynomial: Any) -> list[str]:
    return [str(coefficient) for coefficient in polynomial.all_coeffs()]
