"""The command `rcac place`: exact pole placement on the command line."""

from __future__ import annotations

import re
from pathlib import Path

import click
from sympy import Poly

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.systems._conversions import transfer_function
from rcac_experiments.cli._output import (
    as_json_option,
    budget_option,
    show,
    variable_option,
    writable,
)
from rcac_numeric.arrays._files import replacing
from rcac_numeric.reports._placement import placement_sheet


@click.command("place")
@click.option("--plant", required=True, help='N/D, for instance "4/((s + 1)*(s + 3))".')
@click.option(
    "--poles", required=True,
    help='Requested poles, separated by commas or spaces: "-6, -5, -4, -2" or "-1+2j -1-2j"; or '
         'the '
    'characteristic polynomial: "(s + 1)**3".',
)  # fmt: skip
@click.option(
    "--order", "n_c", type=click.IntRange(min=0), default=None,
    help="Order of the compensator; default: number of poles minus order of the plant.",
)  # fmt: skip
@click.option(
    "--feedback", type=click.Choice(["-1", "+1", "1"]), default="-1", show_default=True,
    help="-1 for u = -G_c y as in section 7.3, +1 for u = G_c y.",
)  # fmt: skip
@variable_option
@budget_option()
@click.option(
    "--coq", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE.v",
    callback=writable(".v"),
    help="Write the certificate as a file of Coq, which proves this design.",
)  # fmt: skip
@as_json_option
def place(
    plant: str, poles: str, n_c: int | None, feedback: str, variable: str | None,
    coq: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Place closed-loop poles exactly, and compare the result with float64.

    All numbers are rational: 0.1 is 1/10, and j is the imaginary unit. Without a solution the
    status is 2.
    """
    system = transfer_function(plant, variable)
    target = _target(poles, str(system.variable))
    _require_degree(int(target.degree()), int(system.denominator.degree()), n_c)
    result = exact.place_poles(system, target, n_c, feedback=int(feedback))
    certificate = "" if coq is None else exact.to_coq(result)

    def write() -> list[str]:
        if coq is None:
            return []
        with replacing(coq) as new:
            new.write_text(certificate, encoding="utf-8")
        return [f"Coq: {coq}; its head says how it is compiled"]

    show(placement_sheet(result), as_json, write=write)


def _target(poles: str, variable: str) -> Poly:
    """Return the characteristic polynomial of --poles: of its roots, or as it is written."""
    written = set(re.findall(r"(?<!\w)[szq](?!\w)", poles))
    if not written:
        return exact.polynomial_from_roots(exact.read_roots(poles), variable)
    if written != {variable}:
        names = " and ".join(sorted(written))
        raise InputError(
            f"--poles {poles} is in {names}, and the plant in {variable}; write both in "
            "one variable, or give --poles as a list of roots."
        )
    if re.search("[,;]", poles):
        raise InputError(
            f"--poles {poles} is a list with an entry in the variable {variable}; give "
            f"numbers, such as -1, -2+1j, -2-1j, or one polynomial, such as ({variable} + 1)**3."
        )
    target = exact.polynomial(poles, variable)
    if target.degree() < 1:
        raise InputError(f"--poles {poles} is the constant {target.as_expr()}, which has no roots.")
    return target


def _require_degree(degree: int, n: int, n_c: int | None) -> None:
    """Refuse a number of poles that differs from the order of the closed loop."""
    if n_c is not None and degree != n + n_c:
        other = f", or write --order {degree - n}" if degree >= n else ""
        raise InputError(
            f"--poles gives {degree} poles; a plant of order {n} with a compensator of order {n_c} "
            f"has {n + n_c}. Give {n + n_c} poles{other}."
        )
    if degree < n:
        raise InputError(
            f"--poles gives {degree} poles; the plant alone has {n}. Give {n} poles, and "
            "one more for each order of the compensator."
        )
