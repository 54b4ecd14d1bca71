"""An exported controller: a folder of C with its test vector."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory._truth import Truth
from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import member, replacing
from rcac_numeric.arrays._validation import instance_of, items, one_of
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._runs import Run
from rcac_numeric.export._building import compiled, compiler, replayed
from rcac_numeric.export._header import REALS, config_header, vector_header
from rcac_numeric.export._readme import readme
from rcac_numeric.export._recording import Recording, compiled_recording, recorded
from rcac_numeric.export._tables import CoreTables, core_tables, scaled
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.targets._model import TargetModel

LAYOUTS = ("c", "arduino", "px4", "wasm", "mex")
# float32 may leave so much more of z than float64 does.
WORST_RATIO = 1.5
SMALLEST_R_THETA, LARGEST_R_THETA = 1e-40, 1e8
LONGEST_FOR_PX4 = 16 - len("_LAMBDA")  # letters of a prefix


@dataclass(frozen=True)
class Export(Truth):
    """The written files, and their comparison with the source.

    Attributes
    ----------
    folder : Path
    files : tuple of str
        Relative to the folder.
    real : str
    state_bytes, constant_bytes : int
        Of the state in RAM and of the constants in flash.
    replay : str
        The result of the replay of the recorded vector; empty without a compiler.
    agreement : str
        How the loop in float32 compares with that in float64; empty for float64.
    warnings : tuple of str
    """

    folder: Path
    files: tuple[str, ...]
    real: str
    state_bytes: int
    constant_bytes: int
    replay: str
    agreement: str
    warnings: tuple[str, ...]

    @property
    def is_verified(self) -> bool:
        """Whether the exported code was compiled and replayed the recorded vector here."""
        return bool(self.replay)

    def __str__(self) -> str:
        sentence = self.replay or "not compiled: there is no C compiler on this machine"
        return (
            f"{self.folder}: {len(self.files)} files, {self.real}, {self.state_bytes} bytes of "
            f"RAM; {sentence}"
        )


def export_controller(
    controller: ControllerSettings | FixedController | Compensator | Run,
    folder: str | Path,
    *,
    real: str = "float64",
    layout: str | Sequence[str] = "c",
    prefix: str = "rcac",
    saturation: Saturation | None = None,
    live_order: int | None = None,
    supervision: Supervision | None = None,
    run: Run | None = None,
) -> Export:
    """Write a controller as C that needs no library, with a test that replays a recorded vector.

    float64 gives the bits of the engine under RCAC_INSTRUCTION_SET=plain. Where this machine has a
    C compiler, the folder is compiled and its test runs before it is handed out.

    Parameters
    ----------
    controller : ControllerSettings, FixedController, Compensator or Run
        The adapting controller, or a fixed one such as ``run.compensator``. A run stands for its
        settings, its saturation and its signals.
    folder : path
        Made where it is not there; files of the same names are replaced.
    real : {"float64", "float32"}
        With float32 every coefficient has a carry, P is scaled by sqrt(R_theta), and D stays below
        D(0) where something is forgotten. It needs a C compiler: the loop is closed around the
        compiled code and compared with that in float64.
    layout : {"c", "arduino", "px4", "wasm", "mex"}, or several of them
        What is written beside the core, its test and a CMake project.
    prefix : str
        Of all names, for several controllers in one program.
    saturation : Saturation, optional
        Of the actuator; the core then applies it itself.
    live_order : int, optional
        With it the target model can be replaced while the controller runs, up to this order.
    supervision : Supervision, optional
        With the policy "warn": the core notes wind-up, missed samples, an actuator that does not
        follow and large z as `Controller` does, goes on from an overflow and never leaves the plant
        without u. Without it a missed sample moves nothing, an overflow ends the adaptation, and
        nothing of it is compiled.
    run : Run, optional
        Whose signals are replayed; without one a small plant stands in.

    Returns
    -------
    Export

    Raises
    ------
    InputError
        Where the controller has something that the core does not know, by name; where its numbers
        leave float32; or where the replay of the exported code does not agree.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_numeric import UD, ControllerSettings, TargetModel, export_controller, iir
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=TargetModel([0, 1]), update=UD(R_theta=0.1))
    >>> folder = export_controller(settings, tempfile.mkdtemp())
    >>> "src/rcac.c" in folder.files, folder.real
    (True, 'float64')
    """
    source: Any = controller
    if isinstance(controller, Run):
        run = controller if run is None else run
        saturation = controller.saturation if saturation is None else saturation
        source = controller.settings
    if run is not None:
        instance_of(run, "run", Run)
    layouts = [layout] if isinstance(layout, str) else items(layout, "layout")
    for one in layouts:
        one_of(one, "layout", LAYOUTS)
    if not isinstance(prefix, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", prefix):
        raise InputError(
            f"prefix = {prefix!r}: a name of C with small letters, digits and _ is needed, such as "
            "'roll'."
        )
    if "px4" in layouts and len(prefix) > LONGEST_FOR_PX4:
        raise InputError(
            f"prefix = {prefix!r} has {len(prefix)} letters; a parameter of PX4 has 16 at most, "
            f"_LAMBDA among them, so that {LONGEST_FOR_PX4} are left."
        )
    one_of(real, "real", REALS)
    tables = core_tables(source, saturation=saturation, live_order=live_order,
                         supervision=supervision)  # fmt: skip
    recording, agreement = recorded(source, tables, saturation, run), ""
    warnings: tuple[str, ...] = ()
    if real == "float32":
        warnings = _ranges(source, tables, recording)
        tables = scaled(tables)
        recording, agreement = _in_float32(tables, recording, run)
    texts = folder_texts(
        tables, recording, real, tuple(layouts), prefix, agreement, warnings,
        None if run is None else run.sample_time,
    )  # fmt: skip
    sentence = _verified(texts, prefix)
    target = Path(folder)
    for name, text in texts.items():
        with replacing(member(target, name)) as new:
            new.write_text(text, encoding="ascii", newline="\n")
    sizes = tables.sizes(real)
    return Export(target, tuple(sorted(texts)), real, *sizes, sentence, agreement, warnings)


def _verified(texts: Mapping[str, str], prefix: str) -> str:
    """Replay the recorded vector before the folder is written; return the message."""
    if compiler() is None:
        return ""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for file, text in texts.items():
            if file.startswith(("src/", "test/")):
                (place / file).parent.mkdir(exist_ok=True)
                (place / file).write_text(text, encoding="ascii", newline="\n")
        agrees, sentence = replayed(place / "src", place / "test", prefix)
    if not agrees:
        raise InputError(
            f"the exported code differs from its source: {sentence}. Nothing was written. "
            "Please report it, with the settings."
        )
    return sentence


def folder_texts(
    tables: CoreTables,
    recording: Recording,
    real: str,
    layouts: tuple[str, ...],
    prefix: str,
    agreement: str = "",
    warnings: Sequence[str] = (),
    sample_time: float | None = None,
) -> dict[str, str]:
    """The texts of a folder by their names; the same arguments give the same bytes."""
    core = core_texts()
    texts = {
        "src/rcac.c": core["rcac.c"],
        "src/rcac.h": core["rcac.h"],
        "src/rcac_config.h": config_header(tables, real),
        "test/replay.c": core["layouts/c/replay.c"],
        "test/rcac_vector.h": vector_header(tables, recording, real),
        "README.md": readme(tables, recording, real, layouts, agreement, warnings, sample_time),
        "CMakeLists.txt": core["layouts/c/CMakeLists.txt"],
        "examples/main.c": core["layouts/c/main.c"],
    }
    if "arduino" in layouts:
        texts["library.properties"] = core["layouts/arduino/library.properties"]
        texts["examples/rcac/rcac.ino"] = core["layouts/arduino/step.ino"]
    if "wasm" in layouts:
        for name in ("rcac_wasm.c", "rcac.js", "build.sh"):
            texts[f"wasm/{name}"] = core[f"layouts/wasm/{name}"]
    if "mex" in layouts:
        texts["mex/rcac_mex.c"] = core["layouts/mex/rcac_mex.c"]
    if "px4" in layouts:
        lambda_ = f"{np.float32(tables.lambda_)!s}f"
        for name in ("CMakeLists.txt", "Kconfig", "rcac_module.cpp", "rcac_params.c"):
            texts[f"px4/{name}"] = core[f"layouts/px4/{name}"].replace("@LAMBDA@", lambda_)
    return {_renamed(name, prefix): _renamed(text, prefix) for name, text in texts.items()}


def _renamed(text: str, prefix: str) -> str:
    """With another prefix; the command `rcac` and its environment variable keep their names."""
    if prefix == "rcac":
        return text
    text = re.sub(r"\brcac(?! (?:export|check|verify)\b)(?=\b|_)", prefix, text)
    text = re.sub(r"\bRCAC(?=_(?!INSTRUCTION_SET\b))", prefix.upper(), text)
    text = re.sub(r"(?<=MODULES_)RCAC\b", prefix.upper(), text)
    return re.sub(r"\bRcac\b", prefix.capitalize(), text)


def core_texts() -> Mapping[str, str]:
    """The texts of the core by their names: installed beside this module, or of the checkout."""
    module = Path(__file__).resolve()
    places = [module.parent / "core", module.parents[2] / "kernel" / "core"]
    for place in places:
        if (place / "rcac.c").is_file():
            files = (path for path in sorted(place.rglob("*")) if path.is_file())
            return {path.relative_to(place).as_posix(): path.read_text("ascii") for path in files}
    raise CompensatorError(
        "the text of the stand-alone core is not installed; install compensator-theory again."
    )


def _in_float32(tables: CoreTables, source: Recording, run: Run | None) -> tuple[Recording, str]:
    """The vector in float32, and how its loop compares with that in float64."""
    core = core_texts()
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        texts = {"rcac.c": core["rcac.c"], "rcac.h": core["rcac.h"]}
        texts |= {"driver.c": core["layouts/c/driver.c"]}
        texts |= {"rcac_config.h": config_header(tables, "float32")}
        for file, text in texts.items():
            (place / file).write_text(text, encoding="ascii")
        sources = [place / "rcac.c", place / "driver.c"]
        program = compiled(sources, place / "driver", includes=[place])
        recording = compiled_recording(program, tables, run, source.steps)
    if tables.adapts:
        names, signals, reached = (
            ("z", "theta"),
            (recording.z, source.z),
            (recording.theta, source.theta),
        )
    else:  # it reads no z, and its theta is given
        names, signals = ("u", "u"), (recording.u, source.u[: recording.steps])
        reached = signals
    rms, rms_64 = (float(np.sqrt(np.mean(np.square(s, dtype=np.float64)))) for s in signals)
    sentence = (
        f"rms {names[0]} {rms:.4g}, in float64 {rms_64:.4g}; {names[1]} differs by "
        f"{float(np.abs(reached[0] - reached[1]).max()):.2g} where its largest entry is "
        f"{float(np.abs(reached[1]).max()):.2g}"
    )
    largest = max(float(np.abs(s).max(initial=0.0)) for s in (source.y, source.u))
    if rms > WORST_RATIO * rms_64 and rms - rms_64 > 1e-6 * largest:
        raise InputError(
            f"in float32 the loop differs from that in float64 over {source.steps} steps: "
            f"{sentence}. Use float64, or a larger R_theta."
        )
    return recording, sentence


def _ranges(controller: Any, tables: CoreTables, recording: Recording) -> tuple[str, ...]:
    """Refusals and warnings of float32, as measured (docs/guide/board.md)."""
    if not isinstance(controller, ControllerSettings):
        return ()
    smallest, largest = 1 / max(tables.D_0), 1 / min(tables.D_0)
    if smallest < SMALLEST_R_THETA:
        raise InputError(
            f"R_theta = {smallest:.3g} is below {SMALLEST_R_THETA:g}, where float32 was measured "
            "to lose digits of theta; use float64, or a larger R_theta."
        )
    ranges = []
    if largest > LARGEST_R_THETA:
        ranges.append(
            f"R_theta = {largest:.3g} is above {LARGEST_R_THETA:g}, for which float32 was not "
            "tested."
        )
    floor = 1e-12 * _largest_row(controller, recording)
    if smallest < floor:
        ranges.append(
            f"R_theta = {smallest:.3g} is below {floor:.3g} = 1e-12 W max phi_f^2: rounding may "
            "decide updates; the status RCAC_UNSUPPORTED reports it."
        )
    return tuple(ranges)


def _largest_row(settings: ControllerSettings, recording: Recording) -> float:
    """W max phi_f^2 over the recorded steps, of what u, y and r become in the target models."""
    largest = 0.0
    with np.errstate(all="ignore"):
        for model in settings.targets:
            for signal in np.hstack([recording.u, recording.y, recording.r]).T:
                row = np.nan_to_num(np.abs(_filtered(model, signal)), nan=np.inf)
                largest = max(largest, float(row.max()))
    weights = [R for R in (settings.R_z, settings.R_u) if isinstance(R, np.ndarray)]
    root = min(largest, 1e150)
    return max([1.0, *(float(np.abs(R).max()) for R in weights)]) * root * root


def _filtered(model: TargetModel, signal: Array) -> Array:
    """G_f s, steps x l_z x l_u."""
    N, D = model.numerator, model.denominator
    F = np.zeros((len(signal), *N.shape[1:]))
    for k in range(len(signal)):
        for i in range(min(k + 1, len(N))):
            F[k] += N[i] * signal[k - i]
        for i in range(1, min(k + 1, len(D))):
            F[k] -= D[i] @ F[k - i]
    return F
