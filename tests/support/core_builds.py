"""The stand-alone core compiled for one controller and driven from Python."""

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from rcac_numeric.export._header import config_header

CORE = Path(__file__).resolve().parents[2] / "kernel" / "core"
WARNINGS = [
    "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Wdouble-promotion",
    "-Wfloat-equal", "-Werror",
]  # fmt: skip
OK, BAD_INPUT, DIVERGED, OUT_OF_ORDER, REFUSED, UNSUPPORTED, BOUNDED = 0, 1, 2, 4, 8, 16, 32
MISSED, WOUND_UP, LARGE_Z, HELD_BACK, RESTORED = 64, 128, 256, 512, 1024
TROUBLES = ("windup", "large z", "saturated", "missed sample", "overflow")
SHIM = """
#include <stdlib.h>
#include "rcac.h"
void *make(void) { rcac_state *s = (rcac_state *)malloc(sizeof *s); rcac_init(s); return s; }
rcac_real *theta(rcac_state *s) { return s->theta; }
#if RCAC_ADAPTS
rcac_real *D(rcac_state *s) { return s->D; }
#endif
#if RCAC_SUPERVISED
rcac_trouble *troubles(rcac_state *s) { return s->troubles; }
rcac_real *worst_growth(rcac_state *s) { return &s->worst_growth; }
#endif
/* Every real number that a step leaves, moved by up to a share of itself. */
static uint32_t drawn;
static void move_each(rcac_real *x, size_t bytes, double share) {
    for (size_t i = 0; i < bytes / sizeof *x; ++i) {
        drawn = drawn * 1664525u + 1013904223u;
        x[i] *= (rcac_real)(1 + share * ((double)(drawn >> 8) / 8388608.0 - 1));
    }
}
void move(rcac_state *s, unsigned seed, double share) {
    drawn = seed;
    move_each(s->u, sizeof s->u, share);
    move_each(&s->signals[0][0], sizeof s->signals, share);
    move_each(s->theta, sizeof s->theta, share);
#if RCAC_ADAPTS
    move_each(s->U, sizeof s->U, share);
    move_each(s->D, sizeof s->D, share);
    move_each(&s->inputs[0][0], sizeof s->inputs, share);
    move_each(&s->outputs[0][0], sizeof s->outputs, share);
#endif
}
int size(void) { return (int)sizeof(rcac_state); }
int saved_size(void) { return (int)RCAC_SAVED_SIZE; }
"""


@cache
def compiler(name="gcc"):
    return shutil.which(name)


class Core:
    """One controller in C, with the names of rcac.h."""

    def __init__(self, tables, real="float64", flags=("-std=c99", "-O2"), cc="gcc", edit=str):
        self.tables, self.real = tables, np.dtype(real)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder)
            (path / "rcac_config.h").write_text(config_header(tables, real))
            suffix = "cpp" if cc.endswith("++") else "c"
            (path / f"shim.{suffix}").write_text(
                f'extern "C" {{{SHIM}}}' if suffix == "cpp" else SHIM
            )
            (path / f"rcac.{suffix}").write_text(edit((CORE / "rcac.c").read_text()))
            # Linked without the flags: those of fast math would flush what is tiny to zero in all
            # of this process.
            sources = [f"rcac.{suffix}", f"shim.{suffix}"]
            included = [f"-I{path}", f"-I{CORE}"]
            subprocess.run(
                [cc, *flags, "-fPIC", "-c", *WARNINGS, *included, *sources], check=True, cwd=path
            )
            subprocess.run(
                [cc, "-shared", "rcac.o", "shim.o", "-o", "core.so"], check=True, cwd=path
            )
            self.library = ctypes.CDLL(str(path / "core.so"))
        self.library.make.restype = ctypes.c_void_p
        self.library.theta.restype = ctypes.c_void_p
        self.library.rcac_guard_count.restype = ctypes.c_int64
        self.state = ctypes.c_void_p(self.library.make())
        self.u = np.zeros(tables.l_u, self.real)

    def another(self):
        """A state of its own in the same library."""
        twin = object.__new__(Core)
        twin.tables, twin.real, twin.library = self.tables, self.real, self.library
        twin.state, twin.u = ctypes.c_void_p(self.library.make()), np.zeros_like(self.u)
        return twin

    def _array(self, values):
        if values is None:
            return None
        array = np.ascontiguousarray(np.atleast_1d(values), self.real)
        self._kept = [*getattr(self, "_kept", [])[-20:], array]
        return array.ctypes.data_as(ctypes.c_void_p)

    def call(self, name, *arguments):
        return getattr(self.library, f"rcac_{name}")(self.state, *arguments)

    def init(self):
        self.call("init")

    def step(self, y, z, r=None):
        """(status, u)."""
        out = self.u.ctypes.data_as(ctypes.c_void_p)
        status = self.call("step", self._array(y), self._array(z), self._array(r), out)
        return status, self.u.copy()

    def control(self, y=None, z=None, r=None):
        out = self.u.ctypes.data_as(ctypes.c_void_p)
        status = self.call("control", self._array(y), self._array(z), self._array(r), out)
        return status, self.u.copy()

    def adapt(self, y, z, r=None, u_applied=None):
        arguments = map(self._array, (y, z, r, u_applied))
        return self.call("adapt", *arguments)

    def correct(self, u_applied):
        return self.call("correct", self._array(u_applied))

    def set_lambda(self, value):
        kind = ctypes.c_double if self.real == np.float64 else ctypes.c_float
        return self.call("set_lambda", kind(value))

    def set_target(self, model, past):
        return self.call(
            "set_target", self._array(model.numerator), self._array(model.denominator),
            model.n_f, past,
        )  # fmt: skip

    @property
    def theta(self):
        size = self.tables.l_theta * self.real.itemsize
        bytes_ = ctypes.string_at(self.library.theta(self.state), size)
        return np.frombuffer(bytes_, self.real).copy()

    def move(self, seed, share):
        """Move all that is rounded between two steps by up to a share of itself."""
        self.library.move(self.state, ctypes.c_uint(seed), ctypes.c_double(share))

    @property
    def troubles(self):
        """(steps, episodes, first, last, worst) of what was noted, by the names of the engine."""
        number = ctypes.c_double if self.real == np.float64 else ctypes.c_float

        class Trouble(ctypes.Structure):
            _fields_ = [("counts", ctypes.c_int64 * 4), ("worst", number)]

        self.library.troubles.restype = ctypes.POINTER(Trouble)
        noted = self.library.troubles(self.state)
        result = {name: (*noted[i].counts, noted[i].worst) for i, name in enumerate(TROUBLES)}
        return {name: counts for name, counts in result.items() if counts[0]}

    @property
    def radius(self):
        """The share of the ellipsoid's radius."""
        of = self.library.rcac_radius
        of.restype = ctypes.c_double if self.real == np.float64 else ctypes.c_float
        return of(self.state)

    @property
    def growth(self):
        self.library.worst_growth.restype = ctypes.POINTER(ctypes.c_double)
        return self.library.worst_growth(self.state)[0]

    def save(self):
        buffer = ctypes.create_string_buffer(self.library.saved_size())
        self.call("save", buffer)
        return buffer.raw

    def restore(self, saved):
        return self.call("restore", ctypes.create_string_buffer(saved, len(saved)))
