"""A controller as an FMU for co-simulation, which Simulink, Dymola and OpenModelica run."""

from __future__ import annotations

import platform
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from compensator_theory.errors import InputError
from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._validation import one_of, positive_time
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._runs import Run
from rcac_numeric.export._building import compiled
from rcac_numeric.export._folder import core_texts, export_controller
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import CoreTables, core_tables
from rcac_numeric.plants._foreign import agreed_time
from rcac_numeric.plants._saturation import Saturation

VERSIONS = ("2.0", "3.0")
EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in it, so that the same settings give the same bytes
# For who builds it on another machine.
BUILD = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="rcac">
    <SourceFileSet language="C99">
      <SourceFile name="rcac.c"/>
      <SourceFile name="fmu.c"/>
    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""


def export_fmu(
    controller: ControllerSettings | FixedController | Compensator | Run,
    path: str | Path,
    *,
    sample_time: float,
    version: str = "2.0",
    saturation: Saturation | None = None,
    supervision: Supervision | None = None,
) -> Path:
    """Write a controller as an FMU: y, z and r in, u and theta out, one sample for each step.

    u(k) is there before y(k) comes, so that a loop around it has no delay but its own: the
    controller must be strictly proper. Its numbers are float64, and its bits those of the engine
    under RCAC_INSTRUCTION_SET=plain. The state can be saved and restored.

    With `supervision` a sample that is NaN is missed: theta waits, what was measured last stands in
    the regressor, and the output `status` says so, in the bits that rcac.h names. u(k) has gone out
    by then, so that it is not held as in `Controller.step`.

    Parameters
    ----------
    controller : ControllerSettings, FixedController, Compensator or Run
    path : path
        Whose name ends in .fmu.
    sample_time : float
        In seconds; the communication step of the simulator must be it.
    version : {"2.0", "3.0"}
        Of the Functional Mock-up Interface. 2.0 has scalars, y[1], y[2], ...; 3.0 has arrays.
    saturation : Saturation, optional
    supervision : Supervision, optional
        With the policy "warn", as `Controller` has by default.

    Raises
    ------
    InputError
        Where the controller reads y(k) for u(k), is of no kind that is exported, or there is no C
        compiler.

    Examples
    --------
    >>> from rcac_numeric import Compensator, export_fmu
    >>> gain = Compensator([[[0.0]]], [[[0.1]], [[0.0]]])
    >>> export_fmu(gain, "gain.fmu", sample_time=0.01)
    Traceback (most recent call last):
    ...
    compensator_theory.errors.InputError: u(k) uses y(k), and an FMU gives u(k) before y(k) comes...
    """
    target = Path(path)
    if target.suffix != ".fmu":
        raise InputError(f"{path}: the name of an FMU must end in .fmu.")
    one_of(version, "version", VERSIONS)
    is_fixed = isinstance(controller, FixedController)
    timed = controller.compensator if is_fixed else controller  # type: ignore[union-attr]
    agreed_time(timed, positive_time(sample_time, "sample_time"))
    source: Any = controller
    if isinstance(controller, Run):
        saturation = controller.saturation if saturation is None else saturation
        source = controller.settings
    tables = core_tables(source, saturation=saturation, supervision=supervision)
    if tables.measures_first:
        raise InputError(
            "u(k) uses y(k), and an FMU gives u(k) before y(k) comes. Use k_c = 1 and the "
            "predictor form, or the C interface of export_controller."
        )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # Which holds it to its source.
        export_controller(controller, folder, saturation=saturation, supervision=supervision)
        members = _members(tables, folder, version, float(sample_time))
    with replacing(target) as new, zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, content in sorted(members.items()):
            archive.writestr(zipfile.ZipInfo(member, EPOCH), content, zipfile.ZIP_DEFLATED)
    return target


def _members(
    tables: CoreTables, folder: Path, version: str, sample_time: float
) -> dict[str, bytes]:
    """The files of an FMU by their names."""
    core, config = core_texts(), config_header(tables)
    signature = next(line for line in config.splitlines() if "SIGNATURE" in line)
    token = "{rcac-" + "".join(c for c in signature.partition("(")[2] if c.isdigit()) + "}"
    source = f"fmi{version[0]}.c"
    definitions = f"""\
#define RCAC_FMU_TOKEN "{token}"
#define RCAC_FMU_STEP {sample_time!r}
#include "{source}"
"""
    texts = {
        "rcac.c": core["rcac.c"],
        "rcac.h": core["rcac.h"],
        "rcac_config.h": config,
        source: core[f"layouts/fmu/{source}"],
        "fmu.c": definitions,
    }
    place = folder / "fmu"
    place.mkdir()
    for name, text in texts.items():
        (place / name).write_text(text, encoding="ascii", newline="\n")
    suffix = {"win32": "dll", "darwin": "dylib"}.get(sys.platform, "so")
    library = compiled(
        [place / "rcac.c", place / "fmu.c"], place / f"rcac.{suffix}", "-shared", "-fPIC",
        "-fvisibility=hidden", f"-ffile-prefix-map={place}=.", "-Wl,--build-id=none", "-s",
        includes=[place],
    )  # fmt: skip
    binary = f"binaries/{_platform(version)}/rcac.{suffix}"
    described = _description_2 if version == "2.0" else _description_3
    if version == "3.0":  # 2.0 says it in modelDescription.xml
        texts["buildDescription.xml"] = BUILD
    return {
        "modelDescription.xml": described(tables, token, sample_time).encode(),
        binary: library.read_bytes(),
        **{f"sources/{name}": text.encode() for name, text in texts.items()},
    }


def _platform(version: str) -> str:
    """The name that FMI gives to this machine."""
    systems = {"linux": "linux", "win32": "win", "darwin": "darwin"}
    system = systems.get(sys.platform, sys.platform)
    if version == "2.0":
        return f"{system}64"
    machine = platform.machine().lower()
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    return f"{architecture}-{'windows' if system == 'win' else system}"


def _description_2(t: CoreTables, token: str, sample_time: float) -> str:
    """modelDescription.xml of FMI 2.0."""
    lines, number = [], 0
    outputs: list[int] = []
    for name, width, words in _variables(t):
        for i in range(width):
            start = "" if "output" in words or "local" in words else ' start="0"'
            lines.append(
                f'    <ScalarVariable name="{name}[{i + 1}]" valueReference="{number}" '
                f'variability="discrete" {words}><Real{start}/></ScalarVariable>'
            )
            number += 1
            if "output" in words:
                outputs.append(number)  # counted from 1
    lines.append(
        f'    <ScalarVariable name="status" valueReference="{number}" variability="discrete" '
        'causality="output" initial="calculated"><Integer/></ScalarVariable>'
    )
    outputs.append(number + 1)
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in outputs)
    step = f'stepSize="{sample_time!r}"'
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="rcac" guid="{token}" \
description={quoteattr(t.what)} generationTool="rcac export" variableNamingConvention="structured" \
numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="rcac" canHandleVariableCommunicationStepSize="false" \
canGetAndSetFMUstate="true" canSerializeFMUstate="true">
    <SourceFiles><File name="rcac.c"/><File name="fmu.c"/></SourceFiles>
  </CoSimulation>
  <DefaultExperiment startTime="0" {step}/>
  <ModelVariables>
{chr(10).join(lines)}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{unknowns}</Outputs>
    <InitialUnknowns>{unknowns}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _description_3(t: CoreTables, token: str, sample_time: float) -> str:
    """modelDescription.xml of FMI 3.0."""
    lines = []
    for reference, (name, width, words) in enumerate(_variables(t, empty=True), 1):
        if width == 0:
            continue
        start = f' start="{" ".join(["0"] * width)}"' if "input" in words else ""
        lines.append(
            f'    <Float64 name="{name}" valueReference="{reference}" variability="discrete" '
            f'{words}{start}><Dimension start="{width}"/></Float64>'
        )
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="rcac" instantiationToken="{token}" \
description={quoteattr(t.what)} generationTool="rcac export" variableNamingConvention="structured">
  <CoSimulation modelIdentifier="rcac" canHandleVariableCommunicationStepSize="false" \
fixedInternalStepSize="{sample_time!r}" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <DefaultExperiment startTime="0" stepSize="{sample_time!r}"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
{chr(10).join(lines)}
    <Int32 name="status" valueReference="6" variability="discrete" causality="output" \
initial="calculated"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="4"/><Output valueReference="6"/>
    <InitialUnknown valueReference="4"/><InitialUnknown valueReference="6"/>
  </ModelStructure>
</fmiModelDescription>
"""


def _variables(t: CoreTables, *, empty: bool = False) -> list[tuple[str, int, str]]:
    """(name, width, attributes) in the order of the value references."""
    entries = [
        ("y", t.l_y, 'causality="input"'),
        ("z", t.l_z, 'causality="input"'),
        ("r", t.l_r, 'causality="input"'),
        ("u", t.l_u, 'causality="output" initial="calculated"'),
        ("theta", t.l_theta, 'causality="local" initial="calculated"'),
    ]
    return [one for one in entries if one[1] or empty]
