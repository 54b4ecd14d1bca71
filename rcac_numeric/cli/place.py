"""The command `rcac place`: exact pole placement on the command line."""

from __future__ import annotations

import json
import sys
import warnings
from typing import TYPE_CHECKING, Any

import click

from compensator_theory.errors import CompensatorError, InputError, RoundingWarning

if TYPE_CHECKING:
    from compensator_theory import PolePlacement


@click.command("place")
@click.option("--plant", required=True, help='N/D, for instance "4/((s + 1)*(s + 3))".')
@click.option(
    "--poles", required=True,
    help='The roots wanted, for instance "-6, -5, -4, -2" or "-1+2j, -1-2j".',
)  # fmt: skip
@click.option(
    "--order", "n_c", type=int, default=None,
    help="Order of the compensator; default: number of poles minus order of the plant.",
)  # fmt: skip
@click.option(
    "--feedback", type=click.Choice(["-1", "+1", "1"]), default="-1", show_default=True,
    help="-1 for u = -G_c y as in section 7.3, +1 for u = G_c y.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead.")
def place(plant: str, poles: str, n_c: int | None, feedback: str, as_json: bool) -> None:
    """Place closed-loop poles exactly, and say what float64 would have kept.

    Everything is a rational number: 0.1 is 1/10, and j is the imaginary unit.

    Exit status: 0 done; 2 bad input or no solution.
    """
    try:
        result = _place(plant, poles, n_c, int(feedback))
    except CompensatorError as error:
        click.echo(f"rcac: {error}", err=True)
        sys.exit(2)
    click.echo(json.dumps(result, indent=2) if as_json else _report(result))


def _place(plant: str, poles: str, n_c: int | None, feedback: int) -> dict[str, Any]:
    # Imported here, after the command line is known to be right: NumPy and SymPy take a while.
    from compensator_theory import place_poles

    wanted = [pole.strip() for pole in poles.split(",")]
    if not all(wanted):
        raise InputError(f"--poles {poles!r} has an empty entry; write for instance '-1, -2+1j'")
    placement = place_poles(plant, wanted, n_c, feedback=feedback)
    return _as_dict(placement) | {"float64": _conditioning(placement)}


def _as_dict(placement: PolePlacement) -> dict[str, Any]:
    from compensator_theory.polynomials.poly import is_rational

    def written(poly: Any) -> list[str]:
        return [str(c) for c in poly.all_coeffs()]

    is_numeric = all(map(is_rational, (placement.target, placement.numerator)))
    return {
        "plant": str(placement.plant),
        "feedback": placement.feedback,
        "order": int(placement.denominator.degree()),
        "compensator": str(placement.compensator),
        "numerator": written(placement.numerator),
        "denominator": written(placement.denominator),
        "closed_loop": written(placement.target),
        "is_unique": placement.is_unique,
        "residual_is_zero": bool(placement.residual.is_zero),
        "summary": str(placement),
        "is_rational": is_numeric,
    }


def _conditioning(placement: PolePlacement) -> dict[str, Any] | None:
    """Return what the float64 solve is worth; None where the question makes no sense."""
    from rcac_numeric.analysis.placement_conditioning import placement_conditioning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RoundingWarning)  # the report says it itself
        try:
            found = placement_conditioning(
                placement.plant, placement.target, feedback=placement.feedback
            )
        except CompensatorError:
            return None
    return {
        "condition_number": found.condition_number,
        "relative_error": found.relative_error,
        "digits": found.digits,
        "is_stable": found.float64_is_stable,
        "target_is_stable": found.target_is_stable,
        "summary": str(found),
    }


def _report(result: dict[str, Any]) -> str:
    text = str(result["summary"])
    if result["float64"] is not None:
        text += f"\nin float64: {result['float64']['summary']}"
    return text
