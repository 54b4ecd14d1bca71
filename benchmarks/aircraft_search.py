"""The search behind the tuned settings of Examples 3.1 and 3.2.

Run with `python benchmarks/aircraft_search.py 3.2 "known, as printed"`; it takes minutes.

1. `--draws` settings at random: n_c among 4 to 40, lambda among 1, 0.9997 and 0.999, R_u = c z'z
   with log c uniform on [1e-1, 1e5] or 0 for one in eight, log R_theta uniform on [1e-6, 1e2].
2. Each runs from TRAINING initial states. Its score is the worst of them: the larger of the error
   before the transition and, where the zeros are known, of that at the end, both in root mean
   square, and a twentieth of the largest error.
3. The `--kept` best run again from SELECTION other initial states; the least worst score wins.
4. The winner, and the printed settings beside it, run from HELD_OUT initial states, in neither of
   the two, and the distribution is printed. The example itself has seeds of its own.
"""

from __future__ import annotations

import argparse

import numpy as np

from rcac_experiments.dissertation._examples import read_example
from rcac_experiments.files._builder import build
from rcac_experiments.files._documents import Raw

TRAINING, SELECTION, HELD_OUT = range(1000, 1008), range(2000, 2032), range(3000, 3100)
HEADS = "rms before", "peak before", "peak after", "rms at the end"


def settings_of(rng: np.random.Generator) -> dict[str, object]:
    """One setting, as it stands in a file."""
    weight = 0.0 if rng.random() < 0.125 else float(f"{10 ** rng.uniform(-1, 5):.2g}")
    return {
        "n_c": int(rng.choice([4, 6, 8, 10, 15, 20, 30, 40])),
        "lambda": float(rng.choice([1.0, 1.0, 0.9997, 0.999])),
        "R_u": {"z_squared": weight} if weight else 0,
        "R_theta": float(f"{10 ** rng.uniform(-6, 2):.2g}"),
    }


def errors(table: Raw, name: str, controller: dict[str, object], seeds: range) -> np.ndarray:
    """The four numbers of HEADS for the roll angle, a row for each initial state."""
    named = next(run for run in table["runs"] if run["name"] == name)
    tables = {**named, "controller": {**named.get("controller", {}), **controller}}
    run = {**table["run"], "seed": seeds[0], "seeds": len(seeds), "stride": 1000}
    whole = {key: table[key] for key in ("plant", "signals", "target", "controller")}
    specification = build({**whole, "run": run, "runs": [tables]}, "search").main_run
    return np.array([_of(result.run.z[:, -1]) for result in specification.execute().repetitions])


def _of(z: np.ndarray) -> tuple[float, float, float, float]:
    if len(z) < 8000 or not np.isfinite(z).all():
        return (np.inf,) * 4

    def rms(start: int, stop: int) -> float:
        return float(np.sqrt(np.mean(z[start:stop] ** 2)))

    return rms(2300, 2500), abs(z[:2500]).max(), abs(z[2500:]).max(), rms(7000, 8000)


def score(zeros: np.ndarray, known: bool) -> float:
    """The worst over initial states; less is better."""
    parts = [zeros[:, 0], 0.05 * zeros[:, 1:3].max(axis=1)]
    return float(np.max([*parts, zeros[:, 3]] if known else parts))


def printed(zeros: np.ndarray) -> str:
    """Median, nine tenths and worst of each number."""
    rows = zip(HEADS, np.quantile(zeros, [0.5, 0.9, 1.0], axis=0).T, strict=True)
    return "; ".join(f"{head} {' / '.join(f'{v:.3g}' for v in row)}" for head, row in rows)


def main() -> None:
    """Search, select, and tell the distribution over held-out initial states."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("number", choices=["3.1", "3.2"])
    parser.add_argument("name", help="a run of the example's file, whose settings are varied")
    parser.add_argument("--draws", type=int, default=600)
    parser.add_argument("--kept", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    table, _ = read_example(options.number)
    known, rng = options.name.startswith("known"), np.random.default_rng(options.seed)

    def scored(settings: dict[str, object], seeds: range) -> float:
        return score(errors(table, options.name, settings, seeds), known)

    drawn = [settings_of(rng) for _ in range(options.draws)]
    first = sorted(((scored(s, TRAINING), i) for i, s in enumerate(drawn)))[: options.kept]
    again = sorted((scored(drawn[i], SELECTION), i) for _, i in first)
    for value, index in again[:5]:
        print(f"worst score {value:.4g} of {len(SELECTION)} others: {drawn[index]}")
    print("median / 90 % / worst over", len(HELD_OUT), "held-out initial states")
    for name, settings in (("as printed", {}), ("best found", drawn[again[0][1]])):
        print(f"{name}: {printed(errors(table, options.name, settings, HELD_OUT))}")


if __name__ == "__main__":
    main()
