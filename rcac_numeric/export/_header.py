"""The header of one controller, rcac_config.h: its sizes and its constants."""

from __future__ import annotations

import math
import zlib
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import one_of
from rcac_numeric.export._recording import Recording
from rcac_numeric.export._tables import CoreTables, Pairs, ellipsoid_constants, whitening

REALS = ("float64", "float32")


class _Writer:
    """Lines of C with numbers of one type."""

    def __init__(self, real: str, changing: Collection[str] = ()) -> None:
        self.real = np.dtype(real).type
        self.changing = changing
        self.suffix = "" if real == "float64" else "f"
        self.largest = float(np.finfo(real).max)
        self.lines: list[str] = []

    def number(self, value: float, name: str = "") -> str:
        """A decimal constant that reads back as the number rounded once."""
        if not abs(value) <= self.largest:  # an infinite bound is none
            if name not in ("least", "most", "low", "high") or math.isnan(value):
                raise InputError(f"{name} holds {value:g}, which {np.dtype(self.real)} does not.")
            value = math.copysign(self.largest, value)
        rounded = self.real(value)
        tiny = abs(float(rounded)) < float(np.finfo(self.real).tiny)
        if value and tiny and self.suffix and value != float(rounded):
            raise InputError(
                f"{name} holds {value:g}, below the normal numbers of float32. Use float64."
            )
        text = str(rounded)
        return (text if any(c in text for c in ".en") else f"{text}.0") + self.suffix

    def define(self, name: str, value: int | str) -> None:
        self.lines.append(f"#define RCAC_{name} {value}")

    def numbers(self, name: str, values: Sequence[float]) -> None:
        """An array; one zero where there is nothing, since C knows no empty arrays."""
        words = [self.number(v, name) for v in values] or [self.number(0.0)]
        self._array("rcac_real", name, words)

    def integers(self, name: str, values: Iterable[int], kind: str = "uint16_t") -> None:
        words = [f"INT64_C({v})" if kind == "int64_t" else str(v) for v in values]
        self._array(kind, name, words or ["0"])

    def pairs(self, name: str, pairs: Pairs) -> None:
        self.integers(name, [value for pair in pairs for value in pair])

    def _array(self, kind: str, name: str, words: list[str]) -> None:
        const = "" if name in self.changing else "const "
        self.lines.append(f"static {const}{kind} rcac_{name}[{len(words)}] = {{")
        line = "   "
        for word in words:
            if len(line) + len(word) > 96:
                self.lines.append(line)
                line = "   "
            line += f" {word},"
        self.lines += [line, "};"]


def config_header(tables: CoreTables, real: str = "float64", changing: Collection[str] = ()) -> str:
    """The text of rcac_config.h; the same tables give the same bytes."""
    out = _Writer(one_of(real, "real", REALS), changing)
    _define_sizes(out, tables, real)
    out.lines += ["", "#ifdef RCAC_TABLES /* which rcac.c defines */"]
    for name in ("K_W", "K_UPDATE"):
        if name in changing:
            out.lines.append(f"static int64_t rcac_{name};")
    _define_tables(out, tables)
    out.lines.append("#endif")
    body = "\n".join(out.lines)
    head = [
        f"/* {tables.what}; written by `rcac export`. */",
        "#ifndef RCAC_CONFIG_H",
        "#define RCAC_CONFIG_H",
        "",
        "#include <stdint.h>",
        "",
        f"typedef {'double' if real == 'float64' else 'float'} rcac_real;",
        "",
        f"#define RCAC_SIGNATURE UINT32_C({zlib.crc32(body.encode())})",
    ]
    return "\n".join([*head, body, "", "#endif", ""])


def _define_sizes(out: _Writer, t: CoreTables, real: str) -> None:
    single = real == "float32"
    every, trace_below, growth, short, long = t.reset
    forget_short, forget_long = t.forgetting[:2]
    steps = {"K_W": t.k_w, "K_UPDATE": t.k_update, "K_FILTER": t.k_filter}
    targets = [value for _, kind, value in t.events if kind == 4]
    block = t.l_z * t.l_z
    first = np.reshape(t.denominators, (-1, t.order + 1, block))
    sizes: dict[str, int | str] = {
        "FLOAT32": int(single),
        "L_U": t.l_u, "L_Y": t.l_y, "L_R": t.l_r, "L_Z": t.l_z, "L_E": t.l_e,
        "DERIVED": len(t.derived),
        "SIGNALS": t.l_u + t.l_e + len(t.derived),
        "DEPTH": t.reach + 1,
        "TAPS": len(t.regressor),
        "L_THETA": t.l_theta,
        "UPPER": t.upper,
        "CHANNELS": len(t.channels),
        "ORDER": t.order,
        "OUTPUT_DEPTH": t.output_depth,
        "ADAPTS": int(t.adapts),
        "FILTER_FORM": int(t.filter_form),
        "MEASURES_FIRST": int(t.measures_first),
        "STRICTLY_PROPER": int(t.strictly_proper),
        "RECURSIVE": int(t.live or bool(first[:, 1:].any())),
        "LIVE": int(t.live),
        "SOURCES": len(t.sources),
        "REMEMBERED": t.remembered,
        **{name: f"INT64_C({step})" for name, step in steps.items()},
        "ROWS": t.rows,
        "PENALTY": int(bool(t.penalty)),
        "VARYING_WEIGHTS": int(t.varying_weights),
        "NORMALIZATION": t.normalization[0],
        "SATURATED": int(bool(t.low)),
        "FIXED": int(bool(t.past_e)),
        "FIXED_ORDER": t.fixed_order,
        "BOUNDS": int(t.bounds is not None),
        "SWEEPS": t.bounds[2] if t.bounds else 0,
        "ELLIPSOID": int(t.ellipsoid is not None),
        "TOLERANCE": "5e-7f" if single else "1e-15",
        "NOISE": len(t.noise) // t.l_theta,
        "EVENTS": len(t.events),
        "VARIABLE_RATE": int(forget_long > 0),
        "FORGET_SHORT": forget_short, "FORGET_LONG": forget_long,
        "POWER_WINDOW": t.power_window,
        "RESET_EVERY": every,
        "TRACE_BELOW_RULE": int(trace_below > 0),
        "GROWTH_RULE": int(growth > 0),
        "RESET_SHORT": short, "RESET_LONG": long,
        "NEEDS_ROOT": int(
            t.power_window > 0 or t.varying_weights or t.normalization[0] == 2
            or t.ellipsoid is not None
        ),
        "DENSE_P_0": int(bool(t.U_0)),
        "CARRY": int(single), "CAP": int(single and t.forgets),
        "SUPERVISED": int(t.supervision is not None),
        "PATIENCE": f"INT64_C({t.supervision[2] if t.supervision else 0})",
        "SCALE": out.number(t.scale),
        "SMALLEST_NORMAL": out.number(float(np.finfo(real).tiny)),
    }  # fmt: skip
    for name, value in sizes.items():
        out.define(name, f"rcac_{name}" if name in out.changing else value)
    if targets and t.live:
        raise InputError("a live target model and scheduled ones exclude each other.")


def _define_tables(out: _Writer, t: CoreTables) -> None:
    out.pairs("regressor", t.regressor)
    out.numbers("theta_0", t.theta_0)
    out.numbers("now", [v for now, _, _, _ in t.derived for v in now])
    out.numbers("before", [v for _, before, _, _ in t.derived for v in before])
    out.numbers("pole", [pole for _, _, pole, _ in t.derived])
    out.numbers("limit", [limit if math.isfinite(limit) else -1.0 for *_, limit in t.derived])
    out.numbers("past_v", t.past_v)
    out.numbers("past_e", t.past_e)
    out.numbers("low", t.low)
    out.numbers("high", t.high)
    out.numbers("rate", [rate if math.isfinite(rate) else -1.0 for rate in t.rate])
    out.pairs("channels", t.channels)
    if not t.adapts:
        return
    out.pairs("filtered", t.filtered)
    out.integers("sources", t.sources)
    out.numbers("numerators", t.numerators)
    out.numbers("denominators", t.denominators)
    out.numbers("D_0", t.D_0)
    if t.U_0:
        out.numbers("U_0", t.U_0)
    out.numbers("lambda", [t.lambda_])
    if t.varying_weights:
        for name, (base, z_squared, nu) in (("R_z", t.R_z), ("R_u", t.R_u)):
            out.numbers(f"{name}_base", base)
            out.numbers(f"{name}_varying", [z_squared, nu])
    else:
        R_z, L = whitening(t)
        out.numbers("R_z", R_z)
        out.numbers("L", L)
    out.numbers("penalty", t.penalty)
    out.numbers("slope", [t.normalization[2]])
    out.numbers("supremum", [t.normalization[1]])
    if t.bounds:
        out.numbers("least", t.bounds[0])
        out.numbers("most", t.bounds[1])
    if t.ellipsoid is not None:
        center, inverse, radii = ellipsoid_constants(t.ellipsoid, out.real)
        if not t.ellipsoid.contains([float(out.real(v)) for v in t.theta_0]):
            raise InputError(
                f"theta_0, rounded to {np.dtype(out.real)}, is outside the CertifiedBounds; start "
                "inside, for example at theta_0 = center."
            )
        out.numbers("center", center)
        out.numbers("inverse", inverse)
        out.numbers("radii", radii)
    if t.supervision:
        out.numbers("windup", [t.supervision[0], t.supervision[1]])
    out.numbers("noise", t.noise)
    out.numbers("forgetting", t.forgetting[2:])
    out.numbers("trace_below", [t.reset[1]])
    out.numbers("growth", [t.reset[2]])
    out.integers("event_step", [step for step, _, _ in t.events], "int64_t")
    out.integers("event_kind", [kind for _, kind, _ in t.events], "uint8_t")
    out.numbers("event_value", [value for _, _, value in t.events])
    out.integers("event_target", [int(v) if kind == 4 else 0 for _, kind, v in t.events])


def vector_header(tables: CoreTables, recording: Recording, real: str = "float64") -> str:
    """The text of rcac_vector.h: inputs, u of every step and theta at the end."""
    out = _Writer(one_of(real, "real", REALS))
    out.define("VECTOR_STEPS", recording.steps)
    out.define("STATE_SIZE", tables.sizes(real)[0])
    vectors = {"y": recording.y, "z": recording.z, "r": recording.r, "u": recording.u}
    for name, values in {**vectors, "theta": recording.theta}.items():
        out.numbers(f"vector_{name}", values.reshape(-1).tolist())
    return "\n".join(["#ifndef RCAC_VECTOR_H", "#define RCAC_VECTOR_H", *out.lines, "#endif", ""])
