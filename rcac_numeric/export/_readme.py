"""The README of an exported folder."""

from __future__ import annotations

from collections.abc import Sequence

from rcac_numeric.export._recording import Recording
from rcac_numeric.export._tables import CoreTables


def readme(
    tables: CoreTables,
    recording: Recording,
    real: str,
    layouts: tuple[str, ...],
    agreement: str,
    warnings: Sequence[str],
    sample_time: float | None = None,
) -> str:
    """Sizes, operations, units, and how the folder is used."""
    t = tables
    period = "one sample of them" if sample_time is None else f"one sample, {sample_time:g} s"
    state, constants = t.sizes(real)
    products, quotients = t.operations()
    exact = (
        "the bits of the engine under RCAC_INSTRUCTION_SET=plain"
        if real == "float64"
        else "the bits that the export recorded in a closed loop around this code"
    )
    paragraphs = [
        "# A controller in C",
        "",
        f"Written by `rcac export`: {t.what}; l_u = {t.l_u}, l_y = {t.l_y}, l_r = {t.l_r}, "
        f"l_z = {t.l_z}, l_theta = {t.l_theta}; {real}.",
        "",
        "```c",
        '#include "rcac.h"',
        "",
        "rcac_state s;",
        "rcac_init(&s);",
        "/* every sample: */",
        "status = rcac_step(&s, y, z, r, u);  /* y(k), z(k), r(k) in; u(k) out */",
        "```",
        "",
        f"y, z, r and u have {t.l_y}, {t.l_z}, {t.l_r} and {t.l_u} entries. Their units are those "
        f"of the data that the settings were tuned with; a step is {period}. rcac.h says what a "
        "status means, and how to freeze, save and restore.",
        "",
        "## Sizes",
        "",
        f"- RAM: {state} bytes, all of it in `rcac_state`.",
        f"- Flash: {constants} bytes of constants, and the code: "
        + ("2 to 6 kB" if real == "float32" else "5 to 10 kB, with libgcc's double precision,")
        + " on a Cortex-M4.",
        f"- Stack: about {t.stack(real)} bytes on a Cortex-M4, estimated; -fstack-usage measures.",
        f"- Operations of a step, at most: {products} multiplications with as many additions, "
        f"{quotients} divisions.",
        "",
        "## Test",
        "",
        f"`test/replay.c` replays {recording.steps} steps of {recording.source}, and holds u of "
        f"each and theta at the end against {exact}:",
        "",
        "```sh",
        "cmake -S . -B build && cmake --build build && ctest --test-dir build",
        "```",
        "",
        "Compile src/rcac.c without contraction (-ffp-contract=off) and without fast math. Pragmas "
        "in it ask for that; `rcac_self_check()` says whether the compiler obeyed.",
    ]
    if agreement:
        paragraphs += ["", f"float32 against float64 over these steps: {agreement}."]
    if t.low:
        paragraphs += ["", "u is held within its bounds by the core: send it out as it is."]
    if t.supervision:
        growth, limit, patience = t.supervision
        paragraphs += [
            "",
            "## Supervision",
            "",
            "A missed sample (NaN, infinite or NULL) holds u or theta, and numbers that leave "
            "their range give theta of the last good look back, with P(0); u is always a number. "
            f"The status says RCAC_WOUND_UP where a variance is more than {growth:g} times that of "
            "P(0), looked at every 16 steps; RCAC_HELD_BACK where u was not applied for "
            f"{patience} steps, which it learns by `rcac_correct` or from its own bounds; "
            + (f"RCAC_LARGE_Z where abs(z) exceeds {limit:g}; " if limit else "")
            + "RCAC_MISSED and RCAC_RESTORED. What was noted since `rcac_init` is in `troubles` of "
            "the state; `rcac_save` keeps it. It acts on none of this: your program does.",
        ]
    if "arduino" in layouts:
        paragraphs += [
            "",
            "Arduino: this folder is a library; the sketch is in examples/. An AVR keeps the "
            "constants in RAM, too, and its double is a float: it needs float32.",
        ]
    if "wasm" in layouts:
        paragraphs += ["", "A page: `sh wasm/build.sh` makes the module, wasm/rcac.js loads it."]
    if "mex" in layouts:
        paragraphs += ["", "MATLAB and Octave: `mkoctfile --mex -Isrc mex/rcac_mex.c src/rcac.c`."]
    if "px4" in layouts:
        paragraphs += [
            "",
            "PX4: px4/ is a module, a skeleton, whose two marks are for your topics.",
            "",
            "```sh",
            "mkdir PX4-Autopilot/src/modules/rcac",
            "cp px4/* src/* PX4-Autopilot/src/modules/rcac/",
            "echo CONFIG_MODULES_RCAC=y >> PX4-Autopilot/boards/px4/fmu-v6x/default.px4board",
            "```",
            "",
            "Then `rcac start` in its shell; RCAC_SW and RCAC_LAMBDA are its parameters.",
        ]
    if warnings:
        paragraphs += ["", "## Warnings", "", *(f"- {warning}" for warning in warnings)]
    return "\n".join([*paragraphs, ""])
