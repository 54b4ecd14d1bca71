"""The dials of the page for an experiment; settings without a dial are refused by name."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from typing import Any, NoReturn

import attrs
import numpy as np
from sympy import Poly, Rational

from compensator_theory import TransferFunction
from compensator_theory.errors import InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import Experiment, RunSpecification
from rcac_experiments.explorer._ellipsoids import ellipsoid_of, stored_ellipsoids
from rcac_experiments.explorer._encoding import in_base64
from rcac_experiments.explorer._modules import LARGEST_N_C, LARGEST_STEPS, LARGEST_TARGET
from rcac_experiments.files._builder import build
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._kinds import iir
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.signals._signal import exogenous
from rcac_numeric.signals._waveforms import Harmonic, Step, WhiteNoise

LARGEST_PLANT = 12
DIGITS = 12  # decimals of a pole or a zero
SCENES = ("tame", "untold", "unstable", "unasked", "servo", "certified")


def case_of(
    table: Mapping[str, Any],
    file: str,
    run: str | None = None,
    budget: ExperimentBudget | None = None,
    ellipsoid: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the dials of one run of an experiment's tables; its ellipsoid if that is known."""
    experiment = build(dict(table), file, budget)
    chosen = _chosen(experiment, run)
    settings, plant = chosen.settings, chosen.plant
    if not isinstance(plant, Plant):
        _refuse("a plant that changes, or of Python functions", "leave [[plant.changes]] out")
    if not isinstance(settings, ControllerSettings):
        _refuse(f"a {type(settings).__name__}", "one adaptive controller is needed")
    problem = _problem(plant)
    numerator, denominator = plant.scalar_map("zu")
    _require_order(numerator, denominator)
    known_zeros, poles, H = _target(settings)
    sign = -1 if problem == "servo" else 1
    gain = H / Rational(numerator.LC())
    _require_dials(chosen, settings)
    update = settings.update
    assert isinstance(update, UD)
    raw = _signals_table(table, chosen.name)
    G = f"({(sign * numerator).as_expr()})/({denominator.as_expr()})"
    return {
        "title": experiment.title,
        "G": G,
        "delay": 0,
        "problem": problem,
        "poles": poles,
        "told": known_zeros,
        "d_zu": settings.target.relative_degree - (denominator.degree() - numerator.degree()),
        "gain": str(gain),
        "n_c": settings.structure.n_c,
        "theta_0": settings.theta_0.tolist(),
        "ellipsoid": ellipsoid_of(plant, settings) if ellipsoid is None else ellipsoid,
        "kept": settings.bounds is not None,
        "k_w": settings.k_w,
        "R_theta": repr(float(update.R_theta)),
        "lambda": repr(update.lambda_),
        "bound": _bound(chosen.saturation),
        "steps": chosen.steps,
        "seed": chosen.seed,
        **_dialled(chosen, raw),
    }


def scene_texts() -> dict[str, str]:
    """Return the experiment files of the built-in scenes, by name."""
    folder = resources.files("rcac_experiments.explorer").joinpath("scenes")
    return {name: folder.joinpath(f"{name}.toml").read_text("utf-8") for name in SCENES}


def scenes() -> list[dict[str, Any]]:
    """Return the built-in cases of every page, from their experiment files."""
    import tomllib

    ellipsoids = stored_ellipsoids()["ellipsoids"]
    return [
        case_of(tomllib.loads(text), f"{name}.toml", ellipsoid=ellipsoids[name])
        for name, text in scene_texts().items()
    ]


def draws(steps: int, seeds: set[int]) -> dict[str, str]:
    """White noise as `exogenous` draws it, for each seed; one column per channel."""
    signals = [WhiteNoise(), WhiteNoise()]
    return {str(seed): in_base64(exogenous(signals, steps, seed)) for seed in sorted(seeds)}


def wave(steps: int) -> str:
    """Return the harmonic signal of the page, of amplitude 1."""
    return in_base64(Harmonic(WAVE, phase=-np.pi / 2).samples(steps))


WAVE = 0.3  # rad/sample


def _chosen(experiment: Experiment, name: str | None) -> RunSpecification:
    if name is not None and name not in experiment.runs:
        raise InputError(f"--run {name}: the runs are {', '.join(map(repr, experiment.runs))}.")
    return experiment.main_run if name is None else experiment.runs[name]


def _refuse(subject: str, instead: str) -> NoReturn:
    raise InputError(f"the explorer has no control for {subject}; {instead}.")


def _problem(plant: Plant) -> str:
    """Return whether the plant is the standard or the servo problem of a transfer function."""
    if (plant.l_u, plant.l_y, plant.l_z) != (1, 1, 1):
        _refuse(
            f"a plant with l_u = {plant.l_u}, l_y = {plant.l_y}, l_z = {plant.l_z}",
            "it runs plants with one u, one y and one z",
        )
    shared = np.array_equal(plant.C, plant.E_1) and not plant.D_0.any() and not plant.E_2.any()
    if shared and np.array_equal(plant.D_1, plant.B) and not (plant.D_2.any() or plant.E_0.any()):
        return "standard"
    beside = np.zeros_like(plant.B)
    if (
        shared
        and np.array_equal(plant.D_1, np.hstack([beside, plant.B, beside]))
        and np.array_equal(plant.D_2, [[1.0, 0.0, -1.0]])
        and np.array_equal(plant.E_0, plant.D_2)
    ):
        return "servo"
    raise InputError(
        "the explorer runs the standard problem of a strictly proper G (y = z, w at the plant's "
        "input) and the servo problem (z = e_n, d at the input); this plant is neither. Give "
        "[plant] a transfer function G."
    )


def _require_order(numerator: Poly, denominator: Poly) -> None:
    if numerator.is_zero:
        raise InputError("G_zu = 0: u does not act on z, so no controller can adapt.")
    if (n := denominator.degree()) > LARGEST_PLANT:
        _refuse(f"a plant of order {n}", f"it takes orders up to {LARGEST_PLANT}")
    if numerator.gcd(denominator).degree() > 0:
        _refuse("a hidden mode", "numerator and denominator of G must have no common factor")


def _target(settings: ControllerSettings) -> tuple[list[Any], list[Any], Rational]:
    """Return the known zeros, the requested poles and H of a scalar target model."""
    target = settings.target
    exact = target.exact
    if not isinstance(exact, TransferFunction):
        _refuse("a target model given by float coefficients", 'use model = "pole placement"')
    if exact.denominator.degree() > LARGEST_TARGET // 2:
        _refuse(
            f"a target model of order {exact.denominator.degree()}",
            f"it takes orders up to {LARGEST_TARGET // 2}",
        )
    known_zeros = [zero for zero in _roots(exact.numerator) if abs(complex(*zero)) > 0]
    inside = [zero for zero in known_zeros if abs(complex(*zero)) < 1 - 10.0**-DIGITS]
    if inside:
        _refuse(
            f"a target model with the zero {inside[0][0]:.6g} inside the unit circle",
            'use model = "pole placement"',
        )
    return known_zeros, _roots(exact.denominator), Rational(exact.numerator.LC())


def _roots(polynomial: Poly) -> list[list[float]]:
    """Return the roots on and above the real axis, with multiplicity."""
    roots: list[list[float]] = []
    for factor, times in polynomial.sqf_list()[1]:
        for root in factor.nroots(n=30, maxsteps=500):
            re, im = (round(part, DIGITS) for part in (complex(root).real, complex(root).imag))
            if im >= 0:
                roots += [[re + 0.0, im + 0.0]] * int(times)
    return sorted(roots, reverse=True)


def _require_dials(run: RunSpecification, settings: ControllerSettings) -> None:
    """Refuse a controller with settings for which the page has no dial."""
    update = settings.update
    if type(update) is not UD or not isinstance(update.lambda_, float):
        _refuse(f"the update {update!r}", "it runs UD with a number as lambda")
    assert isinstance(update, UD)
    if not isinstance(update.R_theta, float):
        _refuse("a matrix R_theta", "use a number")
    known = UD(update.R_theta, lambda_=update.lambda_)
    fields = attrs.asdict(update, recurse=False)
    for name, value in attrs.asdict(known, recurse=False).items():
        if not _same(value, fields[name]):
            _refuse(f"{name} of the update", "leave it out")
    n_c = settings.structure.n_c
    if settings.structure != iir(n_c):
        same = settings.structure.name == iir(n_c).name
        subject = "another k_c" if same else f"the structure {settings.structure.name!r}"
        _refuse(subject, 'it has structure = "iir" with k_c = 1')
    if n_c > LARGEST_N_C:
        _refuse(f"n_c = {n_c}", f"it takes orders up to {LARGEST_N_C}")
    if settings.bounds is not None and not isinstance(settings.bounds, CertifiedBounds):
        _refuse("bounds of single coefficients", "give bounds a center and a factor")
    plain = ControllerSettings(
        structure=iir(n_c), target=settings.target, update=known, k_w=settings.k_w,
        theta_0=settings.theta_0, bounds=settings.bounds,
    )  # fmt: skip
    fields = attrs.asdict(settings, recurse=False)
    for name, value in attrs.asdict(plain, recurse=False).items():
        if not _same(value, fields[name]):
            _refuse(name, "leave it out of [controller]")
    _bound(run.saturation)
    if run.x_0 is not None or run.x_0_deviation:
        _refuse("an initial state", "leave x_0 out of [run]")
    if run.reference:
        _refuse("ball arithmetic", "choose another run with --run")
    if run.steps > LARGEST_STEPS:
        _refuse(f"{run.steps} steps", f"--set run.steps={LARGEST_STEPS} or less")


def _bound(saturation: Saturation | None) -> str:
    """Return the limit of abs(u) as the text of its dial."""
    if saturation is None:
        return "none"
    low, high = saturation.low, saturation.high
    if saturation.rate is not None:
        _refuse("a saturation of the rate", "leave rate out of [saturation]")
    if low is None or high is None or float(low[0]) != -float(high[0]) or not high[0] > 0:
        _refuse("a saturation that is not the same in both directions", "give low = -high")
    assert high is not None
    return repr(float(high[0]))


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return bool(np.array_equal(a, b))
    return bool(a == b)


def _signals_table(table: Mapping[str, Any], run: str) -> Mapping[str, Any]:
    """Return [signals] with the entries that the run overrides."""
    overrides = [one for one in table.get("runs", []) if one.get("name") == run]
    of_run = overrides[0].get("signals", {}) if overrides else {}
    return {**table.get("signals", {}), **of_run}


def _dialled(run: RunSpecification, raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return a dial if the signal is one step; otherwise the samples of w and the file's table."""
    first, *others = run.signals
    is_still = all(type(one) is Step and one.height == 0 for one in others)
    if type(first) is Step and first.start == 0 and is_still:
        kind = "command" if len(run.signals) == 3 else "step"
        return {"signal": kind, "amplitude": repr(first.height), "noise": "0"}
    w = exogenous(run.signals, run.steps, run.seed)
    return {
        "signal": "file", "amplitude": "1", "noise": "0", "signals": dict(raw),
        "w": in_base64(w), "channels": w.shape[1],
    }  # fmt: skip
