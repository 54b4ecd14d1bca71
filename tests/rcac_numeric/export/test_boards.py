"""The exported folder on boards that are simulated: the recorded bits."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from rcac_numeric import UD, ControllerSettings, TargetModel, export_controller, iir
from tests.support import core_builds, cortex

pytestmark = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)
SETTINGS = ControllerSettings(
    structure=iir(5), target=TargetModel([0, 1.0, -0.5], [1, 0.2, 0.1]), update=UD(1e-6)
)
# The folder's own test without a terminal: status 0 where all bits are those recorded.
RUN = """
#include <string.h>
#include "rcac.h"
#include "rcac_vector.h"
static rcac_state s;
int run(void) {
    rcac_real u[RCAC_L_U];
    int k;
    if (rcac_self_check() != 0) return 2;
    rcac_init(&s);
    for (k = 0; k < RCAC_VECTOR_STEPS; ++k) {
        if (rcac_step(&s, rcac_vector_y + k * RCAC_L_Y, rcac_vector_z + k * RCAC_L_Z,
                      rcac_vector_r + k * RCAC_L_R, u) & ~RCAC_UNSUPPORTED) return 3;
        if (memcmp(u, rcac_vector_u + k * RCAC_L_U, sizeof u)) return 4;
    }
    return memcmp(s.theta, rcac_vector_theta, sizeof s.theta) ? 5 : 0;
}
"""


@pytest.mark.costly
@pytest.mark.skipif(
    cortex.missing() is not None, reason="the tools for a Cortex-M are not installed"
)
@pytest.mark.cases(2)
@pytest.mark.parametrize("board", cortex.BOARDS)
@pytest.mark.parametrize("real", ["float32", "float64"])
def test_the_bits_of_the_host(tmp_path, board, real):
    """On a Cortex-M4F and a Cortex-M7."""
    export_controller(SETTINGS, tmp_path, real=real)
    (tmp_path / "run.c").write_text(RUN)
    includes = [tmp_path / "src", tmp_path / "test"]
    sources = [tmp_path / "run.c", tmp_path / "src" / "rcac.c"]
    for level in ("-Os", "-O2"):
        image = cortex.linked(tmp_path, sources, includes, board, level)
        assert cortex.run(image, board) == (0, "")
    # The positive control: with contraction the bits are others.
    source = (
        (tmp_path / "src" / "rcac.c").read_text().replace('"fp-contract=off"', '"fp-contract=fast"')
    )
    (tmp_path / "src" / "rcac.c").write_text(source)
    fused = ["-ffp-contract=fast"]
    status, _ = cortex.run(cortex.linked(tmp_path, sources, includes, board, "-O2", fused), board)
    assert status != 0 or (real == "float64" and board == "cortex-m4")  # which has no such unit


STACK = """
static void one_step(void) {
    rcac_real u[RCAC_L_U];
    rcac_step(&s, rcac_vector_y, rcac_vector_z, rcac_vector_r, u);
}
int deep(void) {
    uint32_t used = 0;
    int k;
    rcac_init(&s);
    for (k = 0; k < 20; ++k) {
        const uint32_t now = depth(one_step);
        used = now > used ? now : used;
    }
    return (int)(used / 16);
}
"""


@pytest.mark.skipif(
    cortex.missing() is not None, reason="the tools for a Cortex-M are not installed"
)
@pytest.mark.parametrize("real", ["float32", "float64"])
def test_the_stack_that_the_readme_says(tmp_path, real):
    export_controller(SETTINGS, tmp_path, real=real)
    text = RUN.replace("int run(", "int replay(") + STACK.replace("deep(", "run(")
    (tmp_path / "run.c").write_text(cortex.DEPTH + text)
    sources = [tmp_path / "run.c", tmp_path / "src" / "rcac.c"]
    image = cortex.linked(tmp_path, sources, [tmp_path / "src", tmp_path / "test"])
    used = 16 * cortex.run(image)[0]
    message = int(re.search(r"Stack: about (\d+) bytes", (tmp_path / "README.md").read_text())[1])
    assert 0.9 * used - 32 < message < 1.5 * used


# 8 bits, int of 16, and floats by subroutines; what it has to say goes to its serial port.
AVR = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
int run(void);
int main(void) {
    UCSR0B = 1 << TXEN0;
    UDR0 = (unsigned char)('0' + run());
    while (!(UCSR0A & 1 << UDRE0)) { }
    UDR0 = '\\n';
    while (!(UCSR0A & 1 << TXC0)) { }
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
"""


@pytest.mark.costly
@pytest.mark.skipif(
    not (shutil.which("avr-gcc") and shutil.which("simavr")),
    reason="the tools for an AVR are not installed",
)
def test_the_bits_of_the_host_on_an_avr(tmp_path):
    """An Arduino Mega 2560."""
    export_controller(SETTINGS, tmp_path, real="float32", layout="arduino")
    (tmp_path / "run.c").write_text(RUN + AVR)
    assert "0." in output_of_avr(tmp_path)
    # The positive control: an expected theta with another last digit.
    vector = tmp_path / "test" / "rcac_vector.h"
    head, theta = vector.read_text().split("rcac_vector_theta[")
    digits = re.search(r"= \{\s+([^\sf]+)f,", theta)[1]
    changed = np.nextafter(np.float32(digits), np.float32(np.inf))
    vector.write_text(f"{head}rcac_vector_theta[{theta.replace(digits, str(changed), 1)}")
    assert "5." in output_of_avr(tmp_path)


def output_of_avr(folder):
    command = [
        "avr-gcc", "-std=gnu11", "-Os", "-mmcu=atmega2560", "-Wall", "-Wextra", "-Isrc", "-Itest",
        "run.c", "src/rcac.c", "-o", "run.elf",
    ]  # fmt: skip
    subprocess.run(command, check=True, cwd=folder)
    command = ["simavr", "-m", "atmega2560", "-f", "16000000", "run.elf"]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=folder, timeout=100, check=False
    )
    return done.stdout + done.stderr
