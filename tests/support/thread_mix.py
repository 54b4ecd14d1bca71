"""Many threads at once: each answer must be what one thread alone gives, bit for bit.

``python -m tests.support.thread_mix SECONDS`` prints how many answers were compared.
"""

import random
import stat
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path

import flint

import compensator_theory as exact
import rcac_numeric as rcac
from compensator_theory.roots._certified import decided_balls
from rcac_numeric.plants._zero_order_hold import zero_order_hold
from rcac_numeric.signals._text_tables import read_text_columns

LONG = 10**5000 + 7
PLANT = rcac.standard_plant("(q - 0.5)/(q*(q - 0.9))")
SETTINGS = rcac.ControllerSettings(
    structure=rcac.iir(n_c=2), target=rcac.fir_target(PLANT), update=rcac.UD(R_theta=1e-20)
)
RUN = rcac.simulate(PLANT, SETTINGS, rcac.exogenous([rcac.Step()], steps=20))
FOLDER = Path(tempfile.mkdtemp())
EMPTY = FOLDER / "empty.csv"
EMPTY.write_text("u,y\n\n")


def reference(steps):
    w = rcac.exogenous([rcac.Step()], steps=steps)
    run = rcac.simulate_reference(PLANT, SETTINGS, w)
    return run.digits, run.theta.tobytes(), run.theta_final.tobytes()


def shown(result):
    return str(result), repr(result), result._repr_latex_()


def written():
    """A run in a file of its own, with the permissions that the umask leaves."""
    file = FOLDER / f"{threading.get_ident()}.npz"
    file.unlink(missing_ok=True)
    RUN.save(file)
    return stat.S_IMODE(file.stat().st_mode), rcac.load_run(file) == RUN


def refused():
    try:
        read_text_columns(EMPTY)
    except exact.InputError as error:
        return str(error)


def riccati(digits):
    solution = exact.solve_riccati(
        [[1, 1], [0, 2]], [[0], [1]], E_1=[[1, 0]], E_2=[[1]], time="discrete", digits=digits
    )
    return *shown(solution), solution.residual


CUBIC = exact.polynomial("3*q**5 - 2*q**3 + q**2/7 - 5*q + 1")
DISCRETE = exact.standard_problem("(q - 2)/(q**2 - 1/4)")
CONTINUOUS = exact.StandardProblem(  # its estimator has sqrt(8) in it: enclosures
    A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]], D_1=[[0, 0], [4, 0]], D_0=None, D_2=[[0, 1]],
    E_1=[[1, 0], [0, 0]], E_2=[[0], ["1/2"]], E_0=None, variable="s",
)  # fmt: skip
TASKS = [
    lambda: reference(6),
    lambda: reference(12),
    lambda: shown(exact.place_poles("1/((s+1)*(s+2)*(s+3))", [-1, -2, -3, -4, -5], feedback=-1)),
    lambda: shown(exact.place_poles(f"1/(s + {10**900})", [-1], feedback=-1)),
    lambda: shown(
        exact.results.Enclosure(exact.exact_number(2) ** 9000 * LONG, exact.exact_number(0))
    ),
    lambda: tuple(map(repr, exact.certified_roots(CUBIC))),
    lambda: [ball.real.mid() for ball, _, _ in decided_balls(CUBIC, lambda b: True, 700)],
    lambda: riccati(20),
    lambda: riccati(200),
    lambda: shown(exact.spectral_factor("z - 2", "z", 3, time="discrete")),
    lambda: shown(exact.spectral_factor("s + 3", "s**2 + 1", "1/7", time="continuous")),
    lambda: shown(exact.observer_forms("1/(s - 1)", "-6/(s + 4)", feedback=1)),
    lambda: shown(exact.lqg_controller(DISCRETE)),
    lambda: shown(exact.lqg_controller(CONTINUOUS)),
    lambda: exact.canonical("sqrt(2) + sqrt(3) + 2**(1/3)*s"),
    lambda: [m.tobytes() for m in zero_order_hold([[0.0, 1.0], [-2.0, -0.3]], [[0.0], [1.0]], 0.1)],
    written,
    refused,
]


def state():
    """What belongs to the whole process: the limit of digits, the umask and the filters."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    umask = [line for line in lines if line.startswith("Umask")]
    return sys.get_int_max_str_digits(), umask, list(warnings.filters)


def mix(seconds, threads=8):
    """Compare until the time is over, each task at least once; the number of answers."""
    before, precision = state(), flint.ctx.prec
    alone = [task() for task in TASKS]
    counts, wrong, ends = [0] * threads, [], time.monotonic() + seconds
    done = threading.Event()

    def work(number):
        order, draw = list(range(len(TASKS))), random.Random(number)
        while not wrong:
            draw.shuffle(order)
            for place in order:
                try:
                    answer = TASKS[place]()
                except Exception as error:
                    answer = error
                if answer != alone[place]:
                    wrong.append((place, answer, alone[place]))
                    return
                counts[number] += 1
                if time.monotonic() > ends and counts[number] >= len(TASKS):
                    return

    def watch():
        while not done.wait(0.001):
            if (now := state()) != before:
                wrong.append(("state", now, before))
                return

    workers = [threading.Thread(target=work, args=(number,)) for number in range(threads)]
    watcher = threading.Thread(target=watch)
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        for thread in (watcher, *workers):
            thread.start()
        for thread in workers:
            thread.join()
        done.set()
        watcher.join()
    finally:
        sys.setswitchinterval(usual)
    assert not wrong, wrong[0]
    assert state() == before and flint.ctx.prec == precision
    return sum(counts)


if __name__ == "__main__":
    print(mix(float(sys.argv[1])))
