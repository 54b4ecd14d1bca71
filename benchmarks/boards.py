"""The stand-alone core on boards: sizes, instructions, and float32 against float64.

`python benchmarks/boards.py sizes` needs gcc-arm-none-eabi, libnewlib-arm-none-eabi and
qemu-system-arm (Debian 12): flash, RAM, stack and instructions of a step of an IIR controller with
n_c = 2, 4 and 10 on a Cortex-M4F, the loop of the measurement included. Instructions, not cycles:
QEMU counts one nanosecond for each, and SysTick 40 of them.

`python benchmarks/boards.py float32` closes the loops of the examples around the compiled core in
float32 and in float64.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_experiments.dissertation import load_example
from rcac_numeric import UD, ControllerSettings, Supervision, TargetModel, iir
from rcac_numeric.arrays._values import replaced
from rcac_numeric.export._building import compiled
from rcac_numeric.export._folder import core_texts
from rcac_numeric.export._header import config_header
from rcac_numeric.export._recording import compiled_recording
from rcac_numeric.export._tables import core_tables, scaled
from tests.support import cortex

STEPS = 2000
EXAMPLES = "1.3 2.1 2.2 2.3 2.4 2.7 2.8 4.1 4.2 4.3 4.4 4.5 4.6 4.7 4.8 6.1 6.2 6.3"
RUN = """
#include "rcac.h"
void say(const char *);
static rcac_state s;
static rcac_real y[RCAC_L_Y], z[RCAC_L_Z], u[RCAC_L_U];
static void step(void) { rcac_step(&s, y, z, 0, u); }
static void number(uint32_t value) {
    char text[12];
    int i;
    for (i = 9; i >= 0; --i, value /= 10) text[i] = (char)('0' + value % 10);
    text[10] = '\\n'; text[11] = 0;
    say(text);
}
int run(void) {
    volatile uint32_t *tick = (volatile uint32_t *)0xE000E010;
    int k;
    rcac_init(&s);
    y[0] = z[0] = 1;
    tick[1] = 0xFFFFFF; tick[2] = 0; tick[0] = 5;
    for (k = 0; k < COUNT; ++k) {
        step();
        y[0] = (rcac_real)0.5 * y[0] + (rcac_real)0.1 * u[0];
        z[0] = y[0] += (rcac_real)(k % 7) * (rcac_real)0.1;
    }
    number(0xFFFFFF - tick[2]);
    number(depth(step));
    return 0;
}
"""


def sizes() -> None:
    """A row for each order and number type."""
    core = core_texts()
    print("real     n_c  level  flash  RAM  stack  instructions a step")
    for real, supervision, n_c in product(
        ("float32", "float64"), (None, Supervision()), (2, 4, 10)
    ):
        settings = ControllerSettings(
            structure=iir(n_c), target=TargetModel([0, 1.0, -0.5]), update=UD(1e4)
        )
        tables = core_tables(settings, supervision=supervision)
        tables = scaled(tables) if real == "float32" else tables
        for level in ("-Os", "-O2"):
            with tempfile.TemporaryDirectory() as name:
                print(
                    f"{real}  {n_c:3d}  {level:5}",
                    *_measured(Path(name), core, config_header(tables, real), level),
                    "supervised" if supervision else "",
                    sep="  ",
                    flush=True,
                )


def _measured(place: Path, core: dict[str, str], config: str, level: str) -> list[int]:
    for name, text in (
        ("rcac.c", core["rcac.c"]), ("rcac.h", core["rcac.h"]), ("rcac_config.h", config),
    ):  # fmt: skip
        (place / name).write_text(text)
    (place / "run.c").write_text(cortex.DEPTH + RUN)
    flags = [*cortex.BOARDS["cortex-m4"][1].split(), *cortex.FLAGS.split(), "-std=gnu99", level]
    subprocess.run(
        ["arm-none-eabi-gcc", *flags, "-c", "rcac.c", "-o", "rcac.o"], check=True, cwd=place
    )
    sections = subprocess.run(
        ["arm-none-eabi-size", "-A", "rcac.o"],
        check=True,
        cwd=place,
        capture_output=True,
        text=True,
    ).stdout
    used = r"^\.(?:text|rodata)\.?[a-zA-Z_0-9.]*\s+(\d+)"
    extra = r"rcac_(self_check|save|restore|set_target|correct|freeze|reset_covariance|set_lambda)"
    flash = sum(
        int(match[1])
        for line in sections.splitlines()
        if (match := re.match(used, line)) and not re.search(extra, line)
    )
    ram = int(re.search(r"STATE (\d+)", _state(place, flags))[1])  # type: ignore[index]
    counts = []
    for count in (STEPS, 2 * STEPS):
        image = cortex.linked(
            place, [place / "run.c", place / "rcac.c"], [place], "cortex-m4", level,
            [f"-DCOUNT={count}"],
        )  # fmt: skip
        ticks, stack = map(int, cortex.run(image)[1].split())
        counts.append(ticks)
    return [flash, ram, stack, round((counts[1] - counts[0]) * 40 / STEPS)]


def _state(place: Path, flags: list[str]) -> str:
    (place / "state.c").write_text('#include "rcac.h"\nchar state[sizeof(rcac_state)] = {1};\n')
    subprocess.run(["arm-none-eabi-gcc", *flags, "-c", "state.c"], check=True, cwd=place)
    out = subprocess.run(
        ["arm-none-eabi-size", "-A", "state.o"],
        check=True,
        cwd=place,
        capture_output=True,
        text=True,
    ).stdout
    data = re.findall(r"\.data\S*\s+(\d+)", out)
    return f"STATE {sum(map(int, data))}"


def float32(most: int) -> None:
    """A row for each example whose first run the core knows."""
    core = core_texts()
    print("example  l_theta  R_theta  steps  rms z float64  rms z float32  theta gap/largest")
    for number in EXAMPLES.split():
        try:
            chosen = load_example(number).main_run
            steps = min(chosen.steps, most)
            run = replaced(chosen, steps=steps, seeds=1, repetitions=1).execute().first.run
            tables = scaled(core_tables(run.settings, saturation=run.saturation))
            with tempfile.TemporaryDirectory() as name:
                place = Path(name)
                for file in ("rcac.c", "rcac.h", "layouts/c/driver.c"):
                    (place / Path(file).name).write_text(core[file])
                (place / "rcac_config.h").write_text(config_header(tables, "float32"))
                sources = [place / "rcac.c", place / "driver.c"]
                program = compiled(sources, place / "driver", includes=[place])
                recording = compiled_recording(program, tables, run, run.steps)
        except (CompensatorError, AttributeError) as error:
            print(f"{number:7}  {str(error)[:100]}")
            continue
        tail = slice(run.steps - run.steps // 5, None)
        rms = [
            float(np.sqrt(np.mean(np.square(z[tail].astype(float))))) for z in (run.z, recording.z)
        ]
        gap = np.abs(recording.theta - run.theta_final).max() / np.abs(run.theta_final).max()
        R_theta = 1 / max(core_tables(run.settings, saturation=run.saturation).D_0)
        print(f"{number:7}  {tables.l_theta:7d}  {R_theta:7.1e}  {run.steps:5d}  {rms[0]:13.2e}  "
              f"{rms[1]:13.2e}  {gap:.1e}")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["sizes", "float32"])
    parser.add_argument("--most", type=int, default=10_000, help="steps of a loop")
    arguments = parser.parse_args()
    if arguments.what == "sizes":
        sizes()
    else:
        float32(arguments.most)
