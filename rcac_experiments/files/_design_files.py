"""Experiment files: read for a design, and written from one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypedDict

import attrs
import numpy as np

from compensator_theory.errors import CompensatorError, InputError, PrecisionError
from rcac_experiments.files._builder import FILE, build
from rcac_experiments.files._documents import named, parsed, read_file
from rcac_experiments.files._plants import read_plant
from rcac_experiments.files._signals import SIGNALS
from rcac_experiments.format._places import Location
from rcac_experiments.format._tables import Table
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.arrays._values import equal
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._kinds import feedforward, fir, fir_integrator, iir, pid
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.designing._design import Design
from rcac_numeric.designing._expected import Expected
from rcac_numeric.designing._trials import FIXED, RCAC
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.signals._recordings import Recorded
from rcac_numeric.signals._signal import Scaled, Signal, Sum, exogenous
from rcac_numeric.signals._waveforms import Harmonic, Pulse, Ramp, Step, WhiteNoise

# The word of each signal in a file, and the field that stands under it; the others are keys.
WORDS = {
    Step: ("step", "height"), Ramp: ("ramp", "slope"), Pulse: ("pulse", "height"),
    Harmonic: ("harmonic", "omega"), WhiteNoise: ("white_noise", "std"),
}  # fmt: skip
SHORT = 2000  # values of a record that a file holds itself
NAME = "design.toml"


def design_toml(design: Design) -> str:
    """A design as an experiment file, for `load_experiment`, with the decisions and their reasons.

    Parameters
    ----------
    design : Design
        From `rcac_numeric.design`.

    Raises
    ------
    PrecisionError
        Where what was read back is not what was written.

    Examples
    --------
    >>> from rcac_experiments import design_toml
    >>> from rcac_numeric import design
    >>> design_toml(design("0.1/(q - 0.9)", steps=500)).startswith("#")
    True
    """
    words = [str(design.verdict)]
    words += [f"Assumed: {q.name}: {q.assumed}; {q.words}." for q in design.questions]
    return experiment_file(
        design.plant, design.settings, design.expected, steps=design.steps,
        saturation=design.saturation, words=words,
        reasons={one.name: f"{one.value}: {one.words}" for one in design.reasons},
        adapts=design.verdict.use == RCAC,
    )  # fmt: skip


def save_design(design: Design, path: str | Path) -> None:
    """Write `design_toml(design)` into a file, whole or not at all.

    Examples
    --------
    >>> from rcac_experiments import save_design
    >>> from rcac_numeric import design
    >>> save_design(design("0.1/(q - 0.9)", steps=500), getfixture("tmp_path") / "design.toml")
    """
    text = design_toml(design)
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8")


def experiment_file(
    plant: Plant, settings: ControllerSettings, expected: Expected, *, steps: int,
    saturation: Saturation | None, words: Sequence[str], reasons: Mapping[str, str], adapts: bool,
) -> str:  # fmt: skip
    """A controller for a servo problem as an experiment file, for `load_experiment`.

    Its first run is what is to be used: RCAC, or the fixed controller, which is RCAC that is
    frozen at theta(0). The other one is the second run.

    Parameters
    ----------
    plant, settings, expected, steps, saturation
        Of the design.
    words : sequence of str
        The head of the file.
    reasons : mapping from names of settings
        The other tables.
    adapts : bool
        Whether RCAC is the first run.

    Raises
    ------
    PrecisionError
        Where what was read back is not what was written.
    """
    target, bounds, R_z = settings.target, settings.bounds, settings.R_z
    assert isinstance(R_z, SignalWeight) and isinstance(settings.update, UD)
    m = expected.m
    assert bounds is not None
    box: dict[str, Any]
    if isinstance(bounds, CertifiedBounds):
        box = {"center": bounds.center, "factor": bounds.factor}
    else:
        box = {"low": bounds.low, "high": bounds.high}
    of_theta = ", ".join(f"{name} = {_numbers(value)}" for name, value in box.items())
    written = [_signal(one, steps) for one in expected.signals(JUDGING)]
    r, d, v = (
        part[0] if m == 1 else f"[{', '.join(part)}]"
        for part in (written[i : i + m] for i in (0, m, 2 * m))
    )
    lines = [f"# {line}" for line in words]
    lines += [
        'title = "From a plant to a controller"',
        f"notes = {json.dumps(' '.join(words), ensure_ascii=False)}",
        "",
        "[plant]  # y = z = e = r - y_0 - v; d adds to u",
        'problem = "servo"',
        f"A = {_numbers(plant.A)}",
        f"B = {_numbers(plant.B)}",
        f"C = {_numbers(-plant.C)}",
    ]
    if plant.sample_time is not None:
        lines.append(f"sample_time = {plant.sample_time!r}")
    lines += ["", "[signals]"]
    lines += [f"r = {r}", f"d = {d}", f"v = {v}"]
    if saturation is not None:
        limits = attrs.asdict(saturation, recurse=False).items()
        lines += ["", "[saturation]"]
        lines += [f"{name} = {_numbers(value)}" for name, value in limits if value is not None]
    lines += [
        "",
        f"[target]  # {reasons['target']}",
        'model = "filter"',
        f"numerator = {_numbers(target.numerator if m > 1 else target.numerator.ravel())}",
        f"denominator = {_numbers(target.denominator if m > 1 else target.denominator.ravel())}",
        "",
        "[controller]",
        f"# {reasons['structure']}",
        *_structure_lines(settings.structure),
        f"# {reasons['R_theta']}",
        f"R_theta = {_numbers(settings.update.R_theta)}",
        f"lambda = {settings.update.lambda_!r}",
        f"# {reasons['theta_0']}",
        f"theta_0 = {_numbers(settings.theta_0)}",
        f"k_w = {settings.k_w}  # {reasons['k_w']}",
        f"k_update = {settings.k_update}  # {reasons['k_update']}",
        f"# {reasons['R_z']}",
        f"R_z = {{ constant = {R_z.constant!r}, nu = {R_z.nu!r} }}",
        f"# {reasons['bounds']}",
        f"bounds = {{ {of_theta} }}",
        "",
        "[run]",
        f"steps = {steps}",
        f"seed = {JUDGING}",
        "",
    ]
    rcac = ["[[runs]]", f'name = "{RCAC}"', ""]
    frozen = ["[[runs]]", f'name = "{FIXED}"', "controller = { freeze = [[0]] }", ""]
    text = "\n".join([*lines, *(rcac + frozen if adapts else frozen + rcac)])
    _require_same(text, plant, settings, exogenous(expected.signals(JUDGING), steps, JUDGING))
    return text


def _structure_lines(structure: Structure) -> list[str]:
    """A structure by its kind and its arguments; a table by its taps."""
    n_c, m, l_y, l_r = structure.n_c, structure.l_u, structure.l_y, structure.l_r
    terms, candidates = structure.name, []
    if set(terms) <= set("PID"):
        limit = min((one.limit for one in structure.derived), default=np.inf)
        lines = [f"terms = {json.dumps(terms)}"]
        lines += [f"integral_limit = {limit!r}"] if np.isfinite(limit) else []
        candidates.append(("pid", lines, pid(terms, m, l_y, integral_limit=limit)))
    else:
        order = [f"n_c = {n_c}"]
        candidates += [("iir", order, iir(n_c, m, l_y)), ("fir", order, fir(n_c, m, l_y))]
        later = [*order, "k_c = 1"]
        candidates.append(("fir + integrator", later, fir_integrator(n_c, None, m, l_y, 1)))
        if l_r:
            candidates.append(("feedforward", order, feedforward(n_c, m, l_y, l_r)))
    for kind, lines, one in candidates:
        if one == structure:
            return [f'structure = "{kind}"', *lines]
    taps = [[tap.signal, tap.component, tap.delay] for tap in structure.taps]
    derived = []
    for signal in structure.derived:
        line = f"now = {list(signal.now)}, before = {list(signal.before)}, pole = {signal.pole!r}"
        derived.append(line + (f", limit = {signal.limit!r}" if np.isfinite(signal.limit) else ""))
    return [
        'structure = "taps"', f"n_c = {n_c}", f"taps = {json.dumps(taps)}",
        f"derived = [{', '.join(f'{{ {one} }}' for one in derived)}]",
    ]  # fmt: skip


def _require_same(text: str, plant: Plant, settings: ControllerSettings, w: Array) -> None:
    """Refuse a file that does not read back as its design, signals compared by value."""
    run = build(parsed(text), NAME).runs[RCAC]
    read = linear_plant(run.plant)
    ours, theirs = (
        [p.A, p.B, p.D_1, p.C, p.D_0, p.D_2, p.E_1, p.E_2, p.E_0] for p in (plant, read)
    )
    same = all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))
    same &= np.array_equal(exogenous(run.signals, run.steps, JUDGING), w)
    if not (same and equal(run.settings, settings)):
        raise PrecisionError(
            "an experiment file cannot represent this design exactly; save the design by pickle."
        )


def _numbers(value: Any) -> str:
    """Numbers as TOML writes them, in lists as deep as the array; each reads back as it was."""
    return json.dumps(np.asarray(value, dtype=np.float64).tolist())


def _signal(signal: Signal, steps: int, factor: float = 1.0) -> str:
    """A signal as an inline table; a factor is multiplied into its signal."""
    if isinstance(signal, Scaled):
        return _signal(signal.signal, steps, factor * signal.factor)
    if isinstance(signal, Sum):
        return f"{{ sum = [{', '.join(_signal(one, steps, factor) for one in signal.parts)}] }}"
    if type(signal) not in WORDS:
        # Any other signal, by its values; what is drawn is drawn as it is in the design.
        known = signal.steps_known
        if known is None and steps > SHORT:
            raise InputError(
                f"a file holds at most {SHORT} values of {signal.description}, and the runs have "
                f"{steps} steps: use design(..., steps={SHORT}), or save the design by pickle."
            )
        values = factor * signal.samples(min(steps, SHORT if known is None else known))
        return f"{{ recorded = {_numbers(Recorded(values).samples(len(values)))} }}"
    word, first = WORDS[type(signal)]
    fields = attrs.asdict(signal, recurse=False)  # type: ignore[arg-type]
    amplitude = "amplitude" if isinstance(signal, Harmonic) else first
    fields[amplitude] *= abs(factor) if isinstance(signal, WhiteNoise) else factor
    keys = {word: fields.pop(first), **fields}
    return f"{{ {', '.join(f'{key} = {value!r}' for key, value in keys.items())} }}"


class DesignArguments(TypedDict):
    """The result of `design_arguments`: keyword arguments of `design`; None for a missing key."""

    plant: Any
    sample_time: float | None
    disturbance: Signal | None
    noise: float | None
    command: Signal | None
    u_limits: Saturation | None


def design_arguments(path: str | Path) -> DesignArguments:
    """Read plant and signals of an experiment file, for `design`.

    Parameters
    ----------
    path : path
        Of a TOML file with [plant], and where they are known [signals] r, d and v, and
        [saturation]; it needs no [run].

    Raises
    ------
    InputError
        Where the file cannot be read, or v is no white noise.

    Examples
    --------
    >>> from rcac_experiments.files._design_files import design_arguments
    >>> design_arguments("examples/boost_converter.toml")["noise"]
    0.002
    """
    table, file = read_file(path)
    try:
        FILE.require_known(table, Location(file))
        plant_of_file = read_plant(table.get("plant", {}), Location(file, "plant"))
        first = plant_of_file.arguments.get("first", plant_of_file)
        G, period = first.arguments.get("G"), first.arguments["sample_time"]
        plant: Any = plant_of_file.build()
        if first is plant_of_file and not (G is None or isinstance(G, list)):
            plant = G
        signals = SIGNALS.read(table.get("signals", {}), Location(file, "signals")).arguments
        limits = None
        if "saturation" in table:
            limits = Table(Saturation).read(table["saturation"], Location(file, "saturation"))
    except CompensatorError as error:
        raise named(error, file) from None
    for name in "rdv":
        blocks = list(signals.get(name, []))
        if any(not equal(one, blocks[0]) for one in blocks[1:]):
            raise InputError(
                f"{file}: the components of [signals] {name} differ, and design uses one for "
                "all: write the largest component."
            )
    d, v, r, w = (one[0] if (one := signals.get(name)) else None for name in "dvrw")
    d = w if d is None else d
    if v is not None and not isinstance(v, WhiteNoise):
        raise InputError(
            f"{file}: [signals] v is {v.description}, and design assumes white sensor noise: "
            "write v = { white_noise = 0.01 }."
        )
    return {
        "plant": plant,
        "sample_time": None if period is None else float(period),
        "disturbance": d,
        "noise": None if v is None else v.std,
        "command": r,
        "u_limits": limits,
    }
