"""Logs of programs with other conventions: named right, false alarms, missed faults.

    python benchmarks/conventions.py [LOGS] [SEED] [WORD]

29 kinds of programs, or those with WORD in their name, each by LOGS closed loops (20): coefficients
that adapt, in float64 and in float32, written with 6 to 17 digits or as NumPy writes them shortest.
Every log is checked as it is, and with one coefficient changed by 0.1 %: its convention must be
named and no other, a log in our convention must agree, and the change must not replay. The program
that makes a log shares no code with the check.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from rcac_numeric import ControllerLog, check_controller, fir, iir

FORMATS = ("%.6g", "%.7g", "%.8g", "%.9g", "%.12g", "%.15g", "%.17g", "shortest")


@dataclass(frozen=True)
class Kind:
    """How a program makes u, and how it logs.

    `words` are those of --convention, and `limits` whether limits of u are to be found.
    """

    name: str
    words: str = ""
    l_u: int = 1
    l_y: int = 1
    sign_u: float = 1.0
    sign_y: float = 1.0
    reads: str = "y"
    order: str = "ours"
    shift: int = 0
    limit: float = 0.0
    limited: str = ""  # which u is logged and which is in the regressor
    is_fir: bool = False
    logs: tuple[str, ...] = ("z", "r")


KINDS = (
    Kind("ours"),
    Kind("ours, 2 x 2", l_u=2, l_y=2),
    Kind("ours, FIR", is_fir=True),
    Kind("theta on -y", "-y", sign_y=-1),
    Kind("theta on -u, as D_c", "-u", sign_u=-1),
    Kind("u = -Phi theta", "-u, -y", sign_u=-1, sign_y=-1),
    Kind("FIR on -y", "-y", sign_y=-1, is_fir=True),
    Kind("y first", "y first", order="y first"),
    Kind("y first, on -y", "-y, y first", sign_y=-1, order="y first"),
    Kind("interleaved", "interleaved", order="interleaved"),
    Kind("interleaved, y before u", "y first, interleaved", order="interleaved y first"),
    Kind("interleaved, on -y", "-y, interleaved", sign_y=-1, order="interleaved"),
    Kind("oldest first", "oldest first", order="oldest first"),
    Kind("oldest first, y first", "y first, oldest first", order="oldest first, y first"),
    Kind("row k after the update", shift=1),
    Kind("row k one step late", shift=-1),
    Kind("after the update, on -y", "-y", sign_y=-1, shift=1),
    Kind("reads z", "z for y", reads="z"),
    Kind("reads -z", "-y, z for y", reads="z", sign_y=-1),
    Kind("reads r - y", "r - y for y", reads="r - y"),
    Kind("reads y - r, y first", "-y, r - y for y, y first", reads="r - y", sign_y=-1,
         order="y first"),
    Kind("reads r + y", "r + y for y", reads="r + y"),
    Kind("u after its limits", limit=0.3, limited="after"),
    Kind("u after, Phi before", "own u", limit=0.3, limited="own"),
    Kind("u before its limits", limit=0.3, limited="before"),
    Kind("2 x 2, by rows", "by rows", l_u=2, l_y=2, order="by rows"),
    Kind("2 x 2, lags by rows", "lags by rows", l_u=2, l_y=2, order="lags by rows"),
    Kind("2 x 2, y first, on -y", "-y, y first", l_u=2, l_y=2, sign_y=-1, order="y first"),
    Kind("2 x 1, by component", "by component", l_u=2, l_y=1, order="by component"),
)  # fmt: skip


def log_of(kind: Kind, seed: int, dtype=np.float64, n_c: int = 3, steps: int = 240) -> dict:
    """Run one program: float arrays u, y, z, r, theta as it logs them."""
    rng = np.random.default_rng(seed)
    l_u, l_y = kind.l_u, kind.l_y
    # Matrices of each lag that move as those of an adaptive controller do, and settle.
    blocks = {}
    for name, width in (("u", l_u), ("y", l_y)):
        ends = rng.uniform(0.2, 1, (2, n_c, l_u, width)) * rng.choice((-1, 1), (2, n_c, l_u, width))
        ends *= (0.8 if name == "u" else 1.5) / (n_c * width)
        speed = rng.uniform(30, 80)
        fade = np.exp(-np.arange(steps) / speed)[:, None, None, None]
        jitter = 0.02 * rng.standard_normal((steps, n_c, l_u, width)) * fade
        blocks[name] = ((1 - fade) * ends[0] + fade * ends[1] * (1 + jitter)).astype(dtype)
    if kind.is_fir:
        blocks["u"] = blocks["u"][:, :0]
    A = rng.uniform(-0.4, 0.4, (l_y, l_y))
    B = rng.uniform(0.3, 1, (l_y, l_u)) * rng.choice((-1, 1), (l_y, l_u)) * 0.5
    x = np.zeros(l_y)
    r = np.where(np.arange(steps)[:, None] % 60 < 30, 1.0, -0.5) * np.ones(l_y)
    u, u_logged, y, z = (np.zeros((steps, width), dtype) for width in (l_u, l_u, l_y, l_y))
    read = np.zeros((steps, l_y), dtype)
    for k in range(steps):
        y[k] = (x + 0.5 * rng.standard_normal(l_y)).astype(dtype)
        z[k] = (x - 0.3 * rng.standard_normal(l_y)).astype(dtype)
        source = {"y": y[k], "z": z[k], "r - y": r[k].astype(dtype) - y[k],
                  "r + y": r[k].astype(dtype) + y[k]}[kind.reads]  # fmt: skip
        read[k] = source
        u_k = np.zeros(l_u, dtype)
        if k >= n_c:
            for i in range(n_c):
                if not kind.is_fir:
                    u_k = u_k + dtype(kind.sign_u) * (blocks["u"][k, i] @ u_logged[k - 1 - i])
                u_k = u_k + dtype(kind.sign_y) * (blocks["y"][k, i] @ read[k - 1 - i])
        inside = np.clip(u_k, -dtype(kind.limit), dtype(kind.limit)) if kind.limit else u_k
        u[k] = u_k if kind.limited == "before" else inside
        u_logged[k] = u_k if kind.limited == "own" else inside
        x = A @ x + B @ inside + 0.1 * rng.standard_normal(l_y)
    theta = ordered(kind.order, blocks, l_u)
    if kind.shift == 1:
        theta = np.vstack([theta[1:], theta[-1:] * dtype(1.01)])
    elif kind.shift == -1:
        theta = np.vstack([theta[:1], theta[:-1]])
    logged = {"u": u, "y": y, "theta": theta}
    logged |= {n: v for n, v in (("z", z), ("r", r.astype(dtype))) if n in kind.logs}
    return {name: values.astype(np.float64) for name, values in logged.items()}


def ordered(order: str, blocks: dict, l_u: int) -> np.ndarray:
    """Theta of each step in a program's order, from its matrices of each lag."""
    names = [n for n in ("u", "y") if blocks[n].shape[1]]
    if "y first" in order:
        names = names[::-1]
    lags = {n: list(np.moveaxis(blocks[n], 1, 0)) for n in names}
    if "oldest first" in order:
        lags = {n: each[::-1] for n, each in lags.items()}
    if order.startswith("interleaved"):
        matrices = [m for pair in zip(*(lags[n] for n in names), strict=True) for m in pair]
    elif order == "by component":
        matrices = [
            m[:, :, j : j + 1] for n in names for j in range(blocks[n].shape[3]) for m in lags[n]
        ]
    else:
        matrices = [m for n in names for m in lags[n]]
    steps = len(matrices[0])
    if order == "by rows":
        return np.concatenate(matrices, axis=2).reshape(steps, -1)
    if order == "lags by rows":
        return np.concatenate([m.reshape(steps, -1) for m in matrices], axis=1)
    return np.concatenate([m.transpose(0, 2, 1).reshape(steps, -1) for m in matrices], axis=1)


def written(values: np.ndarray, text: str, dtype) -> np.ndarray:
    """The numbers of a text file."""
    if text == "shortest":
        return values.astype(dtype).astype("U32").astype(np.float64)
    return np.array([float(text % v) for v in values.ravel()]).reshape(values.shape)


@dataclass
class Outcome:
    """Counts of one kind."""

    logs: int = 0
    named: int = 0
    ambiguous: int = 0
    wrong: int = 0
    missed: int = 0
    examples: list[str] = field(default_factory=list)


def verdict(kind: Kind, logged: dict) -> str:
    """Check a log: "right", "ambiguous", "wrong" or "none"."""
    structure = fir(3, kind.l_u, kind.l_y) if kind.is_fir else iir(3, kind.l_u, kind.l_y)
    check = check_controller(ControllerLog(**logged), structure=structure)
    if check.is_consistent:
        return "right" if not kind.words and not kind.limited else "agrees"
    search = check.conventions
    if not search.matches:
        return "none"
    names = [str(one.convention) for one in search.matches]
    has_limits = search.matches[0].u_limits is not None
    if (kind.words or "ours") not in names or has_limits != bool(kind.limited):
        return f"wrong: {names}"
    return "right" if search.is_unique else f"ambiguous: {names}"


def changed(logged: dict, seed: int) -> dict:
    """The log with one coefficient larger by 0.1 % at every step."""
    theta = logged["theta"].copy()
    j = np.random.default_rng(seed).integers(theta.shape[1])
    theta[:, j] *= 1.001
    return {**logged, "theta": theta}


def measure(number: int, logs: int, seed: int) -> Outcome:
    """One kind by every precision, format and log."""
    kind, one = KINDS[number], Outcome()
    for trial in range(logs):
        for dtype in (np.float64, np.float32):
            log = log_of(kind, seed + 1000 * number + trial, dtype)
            faulty = changed(log, seed + trial)
            for text in FORMATS:
                words = verdict(kind, {n: written(v, text, dtype) for n, v in log.items()})
                one.logs += 1
                one.named += words == "right"
                one.ambiguous += words.startswith("ambiguous")
                one.wrong += words != "right" and not words.startswith("ambiguous")
                if words != "right":
                    one.examples.append(f"{trial} {dtype.__name__} {text}: {words}")
                words = verdict(kind, {n: written(v, text, dtype) for n, v in faulty.items()})
                one.missed += words != "none"
                if words != "none":
                    one.examples.append(f"0.1 %: {trial} {dtype.__name__} {text}: {words}")
    return one


def main() -> None:
    """Print the table."""
    logs = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 49
    start = time.perf_counter()
    total: Counter[str] = Counter()
    print(f"{'kind':26} {'logs':>6} {'named':>6} {'two':>5} {'wrong':>6} {'missed 0.1 %':>13}")
    word = sys.argv[3] if len(sys.argv) > 3 else ""
    for number, kind in enumerate(KINDS):
        if word not in kind.name:
            continue
        one = measure(number, logs, seed)
        counts = f"{one.logs:6} {one.named:6} {one.ambiguous:5} {one.wrong:6} {one.missed:13}"
        print(f"{kind.name:26} {counts}", flush=True)
        for example in one.examples[:3]:
            print("    ", example)
        total.update(logs=one.logs, named=one.named, ambiguous=one.ambiguous, wrong=one.wrong,
                     missed=one.missed)  # fmt: skip
    print(f"{dict(total)}; {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
