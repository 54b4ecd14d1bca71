"""The exported folder on a Cortex-M4F and a Cortex-M7 under QEMU: the recorded bits."""

import pytest

from rcac_numeric import UD, ControllerSettings, TargetModel, export_controller, iir
from tests.support import core_builds, cortex

pytestmark = [
    pytest.mark.skipif(
        cortex.missing() is not None, reason="the tools for a Cortex-M are not installed"
    ),
    pytest.mark.skipif(
        core_builds.compiler() is None, reason="there is no C compiler on this machine"
    ),
]
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


@pytest.mark.cases(2)
@pytest.mark.parametrize("board", cortex.BOARDS)
@pytest.mark.parametrize("real", ["float32", "float64"])
def test_the_bits_of_the_host(tmp_path, board, real):
    settings = ControllerSettings(
        structure=iir(5), target=TargetModel([0, 1.0, -0.5], [1, 0.2, 0.1]), update=UD(1e-6)
    )
    export_controller(settings, tmp_path, real=real)
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
