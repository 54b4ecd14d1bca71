"""How long Coq takes for the files that `to_coq` writes: seconds of one processor.

    python benchmarks/coq_certificates.py [2 4 10 20] [--symbols 3 4 5]

The theorems of proofs/rocq must be compiled. Loading them is measured alone, and taken off.
"""

import argparse
import random
import resource
import subprocess
import tempfile
from pathlib import Path

import flint
import sympy

import compensator_theory as ct

LIBRARY = Path(__file__).parents[1] / "proofs" / "rocq"
BITS = 40


def seconds(text: str) -> float:
    """Compile a file; return the processor's seconds."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "certificate.v"
        file.write_text(text, encoding="utf-8")
        command = ["coqc", "-q", "-w", "none", "-R", str(LIBRARY), "Compensators", str(file)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode or "Closed under the global context" not in run.stdout:
        raise SystemExit(run.stdout + run.stderr)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def record(kind: str, matrices: dict[str, list[list[list[list]]]], **claims: list) -> dict:
    """Return a record of matrices of polynomials in s."""
    written = {
        name: {"rows": len(m), "columns": len(m[0]), "entries": [e for row in m for e in row],
               "over": [["1", [0]]]}
        for name, m in matrices.items()
    }  # fmt: skip
    head = {"kind": kind, "statement": kind, "symbols": ["s"]}
    return head | {"matrices": written} | claims


def numbers(matrix: list[list[int]]) -> list[list[list[list]]]:
    """Write whole numbers as polynomials."""
    return [[[[str(e), [0]]] if e else [] for e in row] for row in matrix]


def polynomial(ascending: list[int]) -> list[list[list[list]]]:
    """Write a polynomial as a matrix of one entry."""
    return [[[[str(c), [k]] for k, c in enumerate(ascending) if c]]]


def cases(n: int, draw: random.Random) -> dict[str, str]:
    """Write certificates of order n with numbers of 40 bits."""
    G = [[draw.getrandbits(BITS) - 2 ** (BITS - 1) for _ in range(n)] for _ in range(n)]
    half = [[e >> BITS // 2 for e in row] for row in G]
    gram = [[sum(a * b for a, b in zip(r, q, strict=True)) for q in half] for r in half]
    for k in range(n):
        gram[k][k] += 1 << BITS
    chi = [int(c) for c in flint.fmpz_mat(G).charpoly().coeffs()]
    stable = flint.fmpz_poly([1])
    for _ in range(n // 2):  # the factors have about 40 bits in all
        digits = 2 * BITS // n + 1
        stable *= flint.fmpz_poly([draw.randrange(1, 1 << digits) for _ in range(3)])
    coefficients = [int(c) for c in stable.coeffs()]
    s = sympy.Symbol("s")
    N = sum(G[0][k] * s**k for k in range(n))
    plant = (N, 2 ** (BITS - 1) * s**n + sum(G[-1][k] * s**k for k in range(n)))
    poles = [-1 - sympy.Rational(k, 2) for k in range(2 * n - 1)]
    return {
        "placement": ct.to_coq(ct.place_poles(plant, poles, feedback=-1)),
        "definite": ct.to_coq(record("form", {"M": numbers(gram)}, definite=["M"])),
        "stable": ct.to_coq(record("polynomial", {"p": polynomial(coefficients)},
                                   stable=[{"is": "p", "time": "continuous"}])),
        "spectrum": ct.to_coq(record("spectrum", {"A": numbers(G), "p": polynomial(chi)},
                                     spectra=[{"is": "p", "of": [["1", ["A"]]]}])),
    }  # fmt: skip


def symbolic(n: int) -> str:
    """Place the poles of 1 / (s^n + a_1 s^(n-1) + ...), all with symbols."""
    s = sympy.Symbol("s")
    D = s**n + sum(sympy.Symbol(f"a{k}") * s ** (n - k) for k in range(1, n + 1))
    N = 1 + sum(sympy.Symbol(f"b{k}") * s**k for k in range(1, min(n, 2)))
    return ct.to_coq(ct.place_poles((N, D), (s + 1) ** (2 * n - 1), feedback=-1))


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("orders", nargs="*", type=int, default=[2, 4, 10, 20])
    parser.add_argument("--symbols", nargs="*", type=int, default=[2, 3])
    options = parser.parse_args()
    draw = random.Random(52)
    empty = seconds(ct.to_coq(ct.place_poles("1/s", [-1], feedback=-1)))
    print(f"the smallest file: {empty:.1f} s, which the others are less by")
    for n in options.orders:
        for name, text in cases(n, draw).items():
            print(f"{name}, order {n}: {seconds(text) - empty:.2f} s, {len(text)} long")
    for n in options.symbols:
        text = symbolic(n)
        print(f"placement with symbols, order {n}: {seconds(text) - empty:.2f} s, {len(text)} long")


if __name__ == "__main__":
    main()
