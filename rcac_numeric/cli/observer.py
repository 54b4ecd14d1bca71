"""The command `rcac observer`: is a compensator an observer with state feedback, and which."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from compensator_theory.errors import CompensatorError, InputError

if TYPE_CHECKING:
    from compensator_theory import ObserverDecision, ObserverForms
    from rcac_numeric.analysis.observer_forms import NumericObserverForms

FEW = 12


@click.command("observer")
@click.option("--plant", required=True, help='Transfer function, for instance "4/((s+1)*(s+3))".')
@click.option("--compensator", required=True, help="G_c, a transfer function.")
@click.option(
    "--feedback", type=click.Choice(["-1", "+1"]), default="-1", show_default=True,
    help="Sign f of the loop u = f G_c y.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a report.")
def observer_command(plant: str, compensator: str, feedback: str, as_json: bool) -> None:
    """Tell whether a compensator is observer-based, and list its observer-based forms.

    The answers are exact. The question has three readings: the pair of polynomials as it is
    written, the transfer function that it stands for, and its controllable canonical realisation.
    """
    try:
        report = _report(plant, compensator, int(feedback))
    except CompensatorError as error:
        click.echo(f"rcac: {error}", err=True)
        sys.exit(2)
    if as_json:
        click.echo(json.dumps(report.as_dict(), indent=2))
    else:
        click.echo(str(report))


class _Report:
    """What was asked and found, as text and as a dictionary."""

    def __init__(
        self,
        decisions: dict[str, ObserverDecision],
        exact: ObserverForms | None,
        numeric: NumericObserverForms | None,
        loop: tuple[Any, Any, int],
    ) -> None:
        self.decisions, self.exact, self.numeric, self.loop = decisions, exact, numeric, loop

    def as_dict(self) -> dict[str, Any]:
        """Return the report in JSON's types; exact numbers are strings."""
        plant, compensator, feedback = self.loop
        forms = () if self.exact is None else (*self.exact.forms, *self.exact.families)
        return {
            "plant": str(plant),
            "compensator": str(compensator),
            "feedback": feedback,
            "decisions": {
                name: {
                    "answer": decision.answer,
                    "reason": decision.reason,
                    "number_of_forms": decision.number_of_forms,
                }
                for name, decision in self.decisions.items()
            },
            "forms": [
                {
                    "regulator": str(form.regulator.as_expr()),
                    "observer": str(form.observer.as_expr()),
                    "K": _strings(form.K),
                    "F": None if form.F is None else _strings(form.F),
                    "T": _strings(form.T),
                    "parameters": [str(symbol) for symbol in form.parameters],
                }
                for form in forms
            ],
            "float64_forms": None if self.numeric is None else _numeric(self.numeric),
        }

    def __str__(self) -> str:
        from compensator_theory.polynomials.formatting import format_polynomial

        plant, compensator, feedback = self.loop
        sign = "" if feedback == 1 else "-"
        lines = [f"G = {plant}", f"G_c = {compensator}, u = {sign}G_c y", ""]
        loop = self.decisions["pair"].characteristic_polynomial
        if loop is not None:
            lines[-1:] = [f"closed loop {format_polynomial(loop)}", ""]
        lines += [decision.verdict for decision in self.decisions.values()]
        if self.exact is not None:
            forms = (*self.exact.forms, *self.exact.families)
            if forms:
                lines += [
                    "",
                    "In controllable canonical form, with A + BK, A - FC and u = K x_hat:",
                ]
            lines += [f"{number}. {form}" for number, form in enumerate(forms[:FEW], start=1)]
            if len(forms) > FEW:
                lines.append(f"... and {len(forms) - FEW} more (all with --json)")
        if self.numeric is not None:
            lines += ["", f"float64: {self.numeric}"]
        return "\n".join(lines)


def _report(plant_text: str, compensator_text: str, feedback: int) -> _Report:
    # Imported here, after the command line is known to be right: SymPy takes a while to load.
    from compensator_theory import (
        is_lqg_suboptimal,
        observer_forms,
        pair_is_observer_based,
        realisation,
        realisation_is_observer_based,
        transfer_function_is_observer_based,
    )
    from compensator_theory.loops.siso import siso_loop
    from compensator_theory.polynomials.poly import is_rational, scaled
    from compensator_theory.systems.transfer_functions import TransferFunction

    G, G_c = siso_loop(plant_text, compensator_text, feedback)
    decisions = {
        "pair": pair_is_observer_based(G, G_c, feedback=feedback),
        "transfer_function": transfer_function_is_observer_based(G, G_c, feedback=feedback),
        "lqg_suboptimal": is_lqg_suboptimal(G, G_c, feedback=feedback),
    }
    exact = numeric = None
    if G_c.order and G_c.is_strictly_proper:
        plant = realisation(G)
        signed = TransferFunction(scaled(G_c.numerator, feedback), G_c.denominator)
        compensator = realisation(signed)
        decisions["realisation"] = replace(
            realisation_is_observer_based(plant, compensator),
            question="Is its controllable canonical realisation observer-based?",
        )
        exact = observer_forms(plant, compensator)
        if exact.is_complete is False and is_rational(exact.characteristic_polynomial):
            from rcac_numeric.analysis.observer_forms import numeric_observer_forms

            try:
                numeric = numeric_observer_forms(plant, compensator)
            except InputError:  # a continuum of forms: the exact families show it
                numeric = None
    return _Report(decisions, exact, numeric, (G, G_c, feedback))


def _strings(matrix: Any) -> list[list[str]]:
    return [[str(entry) for entry in row] for row in matrix.tolist()]


def _numeric(forms: NumericObserverForms) -> list[dict[str, Any]]:
    return [
        {
            "regulator_roots": [[r.real, r.imag] for r in forms.regulator_roots[i]],
            "observer_roots": [[r.real, r.imag] for r in forms.observer_roots[i]],
            "K": forms.K[i].tolist(),
            "F": None if forms.F is None else forms.F[i].tolist(),
            "T": forms.T[i].tolist(),
            "condition": float(forms.condition[i]),
            "residual": float(forms.residual[i]),
        }
        for i in range(len(forms))
    ]
