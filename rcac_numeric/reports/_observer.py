"""The report of the observer-based forms of a compensator."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.loops._siso import siso_loop
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import is_rational, scaled
from rcac_numeric.analysis._observer_forms import NumericObserverForms, observer_forms
from rcac_numeric.reports._sheet import Section, Sheet, Text

FEW = 12
Decisions = dict[str, exact.results.ObserverDecision]


def observer_sheet(
    plant: str | exact.TransferFunction, compensator: str | exact.TransferFunction, feedback: int
) -> Sheet:
    """The decisions on three definitions, and the observer-based forms."""
    G, G_c = siso_loop(plant, compensator, feedback)
    decisions: Decisions = {
        "pair": exact.observers.pair_is_observer_based(G, G_c, feedback=feedback),
        "transfer_function": exact.observers.transfer_function_is_observer_based(
            G, G_c, feedback=feedback
        ),
        "lqg_suboptimal": exact.observers.is_lqg_suboptimal(G, G_c, feedback=feedback),
    }
    forms, numeric = None, None
    if G_c.order and G_c.is_strictly_proper:
        system = exact.realisation(G)
        signed = exact.TransferFunction(scaled(G_c.numerator, feedback), G_c.denominator)
        controller = exact.realisation(signed)
        decisions["realisation"] = replace(
            exact.observers.realisation_is_observer_based(system, controller),
            question="Is its controllable canonical realisation observer-based?",
        )
        forms = exact.observer_forms(system, controller)
        if forms.is_complete is False and is_rational(forms.characteristic_polynomial):
            numeric = _numeric(system, controller)
    lines = [Text(f"G_c = {G_c}, u = {'' if feedback == 1 else '-'}G_c y")]
    loop = decisions["pair"].characteristic_polynomial
    if loop is not None:
        lines.append(Text(f"closed loop {format_polynomial(loop)}"))
    record = {"plant": str(G), "compensator": str(G_c), "feedback": feedback}
    return Sheet(
        f"G = {G}",
        sections=(
            Section("", tuple(lines), record),
            _answers(decisions),
            _forms(forms),
            _float64(numeric),
        ),
    )


def _numeric(
    system: exact.Realisation, controller: exact.Realisation
) -> NumericObserverForms | None:
    try:
        return observer_forms(system, controller)
    except InputError:  # a continuum of forms: the exact families show it
        return None


def _answers(decisions: Decisions) -> Section:
    record = {
        name: {
            "answer": decision.answer,
            "reason": decision.reason,
            "number_of_forms": decision.number_of_forms,
        }
        for name, decision in decisions.items()
    }
    verdicts = tuple(Text(decision.verdict) for decision in decisions.values())
    return Section("Answers", verdicts, {"decisions": record})


def _forms(observers: exact.results.ObserverForms | None) -> Section:
    forms = () if observers is None else (*observers.forms, *observers.families)
    record = [
        {
            "regulator": str(form.regulator.as_expr()),
            "observer": str(form.observer.as_expr()),
            "K": _strings(form.K),
            "F": None if form.F is None else _strings(form.F),
            "T": _strings(form.T),
            "parameters": [str(symbol) for symbol in form.parameters],
        }
        for form in forms
    ]
    lines = [Text(f"{number}. {form}") for number, form in enumerate(forms[:FEW], start=1)]
    if len(forms) > FEW:
        lines.append(Text(f"... and {len(forms) - FEW} more (all with --json)"))
    remark = " in controllable canonical form, with A + BK, A - FC and u = K x_hat"
    title, remark = ("Forms", remark) if forms else ("", "")
    return Section(title, tuple(lines), {"forms": record}, remark)


def _float64(forms: NumericObserverForms | None) -> Section:
    if forms is None:
        return Section(record={"float64_forms": None})
    record = [
        {
            "regulator_roots": form.regulator_roots,
            "observer_roots": form.observer_roots,
            "K": form.K,
            "F": form.F,
            "T": form.T,
            "condition": form.condition,
            "residual": form.residual,
        }
        for form in forms.forms
    ]
    return Section("", (Text(f"float64: {forms}"),), {"float64_forms": record})


def _strings(matrix: Any) -> list[list[str]]:
    return [[str(entry) for entry in row] for row in matrix.tolist()]
