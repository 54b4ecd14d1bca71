"""What may come to a board: fuzzed inputs under sanitizers, and what the linked image holds."""

import re
import shutil
import subprocess
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.export import _header
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import core_tables, ellipsoid_constants, scaled
from tests.support import core_builds
from tests.support.core_builds import CORE, DIVERGED, OK, WARNINGS, Core
from tests.support.core_cases import Loop, core_settings
from tests.support.strategies import seeds

pytestmark = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3]), update=rn.UD(0.05), k_w=3
)
# A program of its own, so that the sanitizers are there before anything else.
FUZZER = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "rcac.h"

static uint64_t seed = SEED;
static uint64_t drawn(void) { /* splitmix64 */
    uint64_t x = seed += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}
static rcac_real number(int wild) {
    rcac_real x;
    uint64_t bits = drawn();
    memcpy(&x, &bits, sizeof x);
    if (wild == 2) return x; /* any pattern: NaN, infinite, denormal, huge */
    if (wild == 1) return (rcac_real)((double)(int64_t)drawn() * 1e-12);
    return (rcac_real)((double)(int64_t)drawn() / 9e18);
}
static int finite_(rcac_real x) { return x - x <= 0 && x - x >= 0; }
int main(void) {
    static rcac_state s;
    static unsigned char saved[RCAC_SAVED_SIZE];
    rcac_real y[RCAC_L_Y + 1], z[RCAC_L_Z], r[RCAC_L_R + 1], u[RCAC_L_U], f[64];
    long k;
    int i, counts[2] = {0, 0};
    rcac_init(&s);
    rcac_save(&s, saved);
    for (k = 0; k < STEPS; ++k) {
        const int wild = (int)(drawn() % 16) == 0 ? (int)(drawn() % 3) : 0;
        int status;
        for (i = 0; i < RCAC_L_Y; ++i) y[i] = number(wild);
        for (i = 0; i < RCAC_L_Z; ++i) z[i] = number(wild);
        for (i = 0; i < RCAC_L_R; ++i) r[i] = number(wild);
        switch (drawn() % 200) {
            case 0: rcac_freeze(&s, (int)(drawn() % 2)); break;
            case 1: rcac_reset_covariance(&s); break;
            case 2: rcac_set_lambda(&s, number(wild)); break;
            case 3: for (i = 0; i < RCAC_L_U; ++i) u[i] = number(wild); rcac_correct(&s, u); break;
            case 4: for (i = 0; i < 64; ++i) f[i] = number(wild);
                    for (i = 0; i < RCAC_L_Z * RCAC_L_Z; ++i) f[32 + i] = i % (RCAC_L_Z + 1) == 0;
                    rcac_set_target(&s, f, f + 32, (int)(drawn() % 5), (int)(drawn() % 4)); break;
            case 5: rcac_save(&s, saved); break;
            case 6: saved[drawn() % sizeof saved] ^= (unsigned char)(drawn() % 256); break;
            case 7: rcac_restore(&s, saved); break;
            default: break;
        }
        if (drawn() % 4 == 0) {
            status = rcac_control(&s, y, z, r, u);
            status |= rcac_adapt(&s, y, z, r, drawn() % 2 ? u : NULL);
        } else {
            status = rcac_step(&s, y, z, r, u);
        }
        ++counts[status != 0];
        for (i = 0; i < RCAC_L_U; ++i)
            if (!finite_(u[i]) || (LIMIT > 0 && (u[i] > LIMIT || u[i] < -LIMIT))) {
                printf("step %ld: u is %g, status %d\\n", k, (double)u[i], status);
                return 1;
            }
        if (!(status & RCAC_DIVERGED))
            for (i = 0; i < RCAC_L_THETA; ++i)
                if (!finite_(s.theta[i])) return printf("step %ld: theta\\n", k) > 0;
        if (status & RCAC_DIVERGED && drawn() % 8 == 0) rcac_init(&s);
    }
    printf("%d %d\\n", counts[0], counts[1]);
    return 0;
}
"""
RICH = replace(
    SETTINGS, structure=rn.pid(integral_limit=2.0),
    update=rn.UD(1e-6, lambda_=rn.VariableRateForgetting(3, 9, 0.2)),
    R_u=rn.SignalWeight(0.1, 0.2), z_normalization=rn.Normalization(2.0, 1.0, "root"), theta_0=None,
    fixed=rn.Compensator([[[0.5]]], [[[0.1]], [[0.2]]]), R_u_unfiltered=0.1,
)  # fmt: skip
FUZZED = {
    "iir": (SETTINGS, {"live_order": 4}),
    "rich": (RICH, {"saturation": rn.Saturation(low=-1, high=1)}),
    "watched": (
        RICH,
        {"saturation": rn.Saturation(low=-1, high=1), "supervision": rn.Supervision(limit=9.0)},
    ),
    "extreme": (replace(SETTINGS, update=rn.UD(1e-38, lambda_=0.5)), {}),
}


@pytest.mark.costly
@pytest.mark.long
@pytest.mark.parametrize("name", FUZZED)
def test_fuzzed_inputs_under_sanitizers(tmp_path, in_full, name):
    """10^5 steps in full: u stays finite and, where it is limited, bounded; the status says why."""
    for real in ["float64", "float32"] if in_full else ["float64" if name == "iir" else "float32"]:
        fuzz(tmp_path, name, real, 100_000 if in_full else 5000)


def fuzz(tmp_path, name, real, steps):
    controller, more = FUZZED[name]
    tables = core_tables(controller, **more)
    tables = scaled(tables) if real == "float32" else tables
    (tmp_path / "rcac_config.h").write_text(config_header(tables, real))
    (tmp_path / "fuzz.c").write_text(FUZZER)
    command = [
        "gcc", "-std=c99", "-O1", "-g", *WARNINGS, "-Wno-float-equal", "-Wno-conversion",
        "-fsanitize=address,undefined", "-fno-sanitize-recover=all",
        f"-DSTEPS={steps}L", f"-DSEED={len(name)}u",
        f"-DLIMIT={1 if 'saturation' in more else 0}", f"-I{tmp_path}", f"-I{CORE}",
        tmp_path / "fuzz.c", CORE / "rcac.c", "-o", tmp_path / "fuzz",
    ]  # fmt: skip
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode and "asan" in built.stderr:
        pytest.skip("this C compiler has no sanitizers")
    assert built.returncode == 0, built.stderr
    done = subprocess.run([tmp_path / "fuzz"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr[:3000]
    fine, refused = map(int, done.stdout.split())
    assert refused > 0 and (fine > 0 or name == "extreme")


@pytest.mark.costly
def test_the_linked_image_holds_nothing_but_itself(tmp_path):
    """No heap, no libm, no exceptions: what the core needs of others is what compilers call."""
    for number, (controller, more) in enumerate([FUZZED["iir"], FUZZED["rich"]]):
        (tmp_path / "rcac_config.h").write_text(config_header(core_tables(controller, **more)))
        for cc, standard in (("gcc", "c99"), ("g++", "c++17")):
            if shutil.which(cc) is None:
                continue
            target = tmp_path / f"{number}-{cc}.o"
            language = ["-x", "c++"] if cc == "g++" else []
            subprocess.run(
                [cc, f"-std={standard}", "-Os", "-fno-stack-protector", *WARNINGS, f"-I{tmp_path}",
                 f"-I{CORE}", *language, "-c", CORE / "rcac.c", "-o", target], check=True,
            )  # fmt: skip
            out = subprocess.run(
                ["nm", "--undefined-only", target], capture_output=True, text=True, check=True
            ).stdout
            names = set(re.findall(r"U (\w+)", out)) - {"_GLOBAL_OFFSET_TABLE_"}
            assert names <= {"memcpy", "memset", "memmove"}
            out = subprocess.run(["nm", target], capture_output=True, text=True, check=True).stdout
            assert not re.findall(r" [bBdD] (\w+)", out)  # no memory of its own


@pytest.mark.costly
@pytest.mark.long
@pytest.mark.skipif(shutil.which("clang") is None, reason="clang is not installed")
def test_the_analyser_of_clang_finds_nothing(tmp_path, in_full):
    """Its core checks, which clang-tidy runs, too; one controller where not all are asked for."""
    source = (CORE / "rcac.c").read_text()
    command = [
        "clang", "--analyze", "-std=c99", "-Xclang", "-analyzer-werror", f"-I{CORE}",
        f"-I{tmp_path}", "-o", tmp_path / "out", tmp_path / "rcac.c",
    ]  # fmt: skip
    for name in FUZZED if in_full else ["iir"]:
        controller, more = FUZZED[name]
        config = config_header(core_tables(controller, **more))
        (tmp_path / "rcac_config.h").write_text(config)
        # The positive control: what is nowhere is read.
        broken = source.replace("*numerator = NUMERATOR(s)", "*numerator = NULL")
        for text, clean in ((source, True), (broken, False)):
            (tmp_path / "rcac.c").write_text(text)
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert (done.returncode == 0) == clean, done.stderr


@pytest.mark.costly
@settings(max_examples=3, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(core_settings(), seeds, st.sampled_from(["gcc", "clang"]))
def test_float32_follows_float64(case, seed, cc):
    """Closed loops of all kinds: no NaN, and the signals of float64 as far as the loop allows.

    The measure is the same loop in float64 where w, and at each step all that the controller
    remembers, are moved by up to one rounding of float32.
    """
    controller, plant = case
    cc = cc if shutil.which(cc) else "gcc"
    tables = core_tables(controller)
    in_single = patch.object(
        _header, "ellipsoid_constants", lambda bounds, _: ellipsoid_constants(bounds, np.float32)
    )
    with in_single:  # float32 keeps theta in a smaller ellipsoid: the same one for all
        cores = [Core(scaled(tables), "float32", cc=cc), Core(tables)]
    cores.append(cores[1].another())
    loops = [Loop(plant, controller.l_r, 80, seed) for _ in cores]
    moved = 6e-8 * np.random.default_rng(seed).standard_normal(loops[2].w.shape)
    loops[2].w = loops[2].w * (1 + moved)
    largest, gaps = 1.0, np.zeros(2)
    # D <= D(0) is another rule where something is forgotten, and at R_theta = 1e-18 a direction
    # that float32 cannot see is learnt differently.
    is_bound = not tables.forgets and max(tables.D_0) < 1e3
    for k in range(80):
        answers = []
        for core, loop in zip(cores, loops, strict=True):
            status, u = core.step(*loop.signals(k))
            assert np.isfinite(u).all()
            if status & DIVERGED or np.abs(u).max() > 1e3:
                return
            answers.append(u.astype(float))
            loop.move(k, answers[-1])
        cores[2].move(seed % 2**31 + k, 2.0**-23)
        assert np.isfinite(cores[0].theta).all()
        largest = max(largest, np.abs(answers[1]).max())
        gaps = np.maximum(gaps, [np.abs(answers[i] - answers[1]).max() for i in (0, 2)])
        assert not is_bound or gaps[0] < 1e-4 * largest + 30 * gaps[1]


@pytest.mark.costly
@pytest.mark.long
def test_forgetting_without_excitation_does_not_leave_float32(in_full):
    """D <= D(0) holds where P would grow like lambda^-k."""
    tables = scaled(core_tables(replace(SETTINGS, update=rn.UD(0.05, lambda_=0.99))))
    core = Core(tables, "float32")
    for k in range(200_000 if in_full else 2000):
        status, _ = core.step([float(k < 5)], [float(k < 5)])
        assert status == OK
