"""Arguments that fit, for every function and every method of the compiled module.

`FUNCTIONS[name](draw)` gives the keyword arguments of a function or a constructor, and
`METHODS[cls][name](draw, object)` the positional ones of a method: what is bound and stands in
neither is found by tests/fuzz/test_every_binding.py.
"""

from datetime import datetime_CAPI  # a capsule, and no function

import numpy as np
from hypothesis import strategies as st

from rcac_numeric.compiled import _kernel
from tests.support.kernel_arguments import (
    controller_arguments,
    plant_arguments,
    python_plant_arguments,
    seeds,
)

STEPS, N, L_U, L_Y = 6, 2, 1, 2  # of the estimators
ONES = (1, 1, 1, 1, 1)  # l_u, l_y, l_z, n, l_w


def some(draw, *shape):
    return np.random.default_rng(draw(seeds)).standard_normal(shape)


def functions_of_a_model(draw):
    """f and h, perhaps with a Jacobian, perhaps wrong from some step on."""
    wrong = draw(st.sampled_from([None, None, None, "text", np.nan, np.zeros(9), [1j, 2.0]]))
    first_wrong = draw(st.integers(0, 4))

    def f(k, x, u):
        return 0.5 * x if wrong is None or k < first_wrong else wrong

    def h(k, x, u):
        return np.resize(x, L_Y)

    return {
        "n": N, "l_u": L_U, "l_y": L_Y, "f": f, "h": h,
        "F": draw(st.sampled_from([None, lambda k, x, u: np.eye(N) / 2])),
        "H": draw(st.sampled_from([None, lambda k, x, u: np.eye(L_Y, N)])),
        "residual": draw(st.sampled_from([None, lambda y, expected: y - expected])),
        "scale": np.ones(N),
    }  # fmt: skip


def tape(draw, results):
    """2 and x_0 under every operation, their arguments among what is there before."""
    before = 1 + N + L_U + 1
    steps = [
        (draw(st.integers(0, 1)), draw(st.integers(0, before - 1 + i)), 1)
        for i in range(draw(st.integers(1, 5)))
    ]
    last = np.full(results, before + len(steps) - 1, dtype=np.int32)
    return np.array([2.0]), np.array(steps, dtype=np.int32), last


def model(draw):
    kind = draw(st.sampled_from(["linear", "function", "tape"]))
    name = f"{kind}_estimation_model"
    return getattr(_kernel, name)(**FUNCTIONS[name](draw))


def refinement_arguments(draw):
    """Two delays and two stacked outputs; an FIR subsystem or a repeated parameter."""
    l_w, delays, stack = 1, [1, 2], [0, 1]
    fir, n_c = draw(st.booleans()), draw(st.integers(1, 2))
    l_u = N
    l_theta = l_u * n_c * N if fir else draw(st.integers(1, 2))
    repeated = 0 if fir else l_theta
    rows, columns = len(stack) * L_Y, len(delays) * l_u
    return {
        "sizes": [N, l_w, l_u, L_Y, N if fir else 1],
        "A": np.eye(N) / 2, "D_1": np.ones((N, l_w)), "B": np.eye(N), "C": np.eye(L_Y, N),
        "delays": delays, "stack": stack, "H": some(draw, rows, columns), "R": np.eye(rows),
        "eigenvalues": np.ones(rows), "V_d": some(draw, l_u, rows), "W": some(draw, rows, rows),
        "chosen": draw(st.integers(0, 1)), "eta_bar": draw(st.sampled_from([0.0, 1.0])),
        "forgetting": draw(st.sampled_from([1.0, 0.9])), "direct": draw(st.booleans()),
        "change": draw(st.booleans()), "k_update": draw(st.integers(0, 3)),
        "E_1": np.eye(N), "n_c": n_c if fir else 0, "strictly_proper": draw(st.booleans()),
        "A_j": some(draw, repeated, N, N), "D_j": some(draw, repeated, N, l_w),
        "P_0": np.eye(l_theta), "theta_0": np.zeros(l_theta), "x_0": np.zeros(N),
    }  # fmt: skip


def filter_arguments(draw):
    return {
        "kind": draw(st.sampled_from(["extended", "joseph", "unscented"])), "model": model(draw),
        "x_0": np.zeros(N), "S_0": np.eye(N), "Q_root": np.eye(N), "R_root": np.eye(L_Y),
        "alpha": draw(st.sampled_from([0.5, 3.0])), "beta": draw(st.sampled_from([0.0, 2.0])),
    }  # fmt: skip


def interacting_arguments(draw):
    modes = draw(st.integers(1, 3))
    each = [
        (
            draw(st.sampled_from(["extended", "unscented"])),
            *list(filter_arguments(draw).values())[1:],
        )
        for _ in range(modes)
    ]
    return {
        "filters": each, "transitions": np.full((modes, modes), 1 / modes),
        "probabilities": np.full(modes, 1 / modes),
    }  # fmt: skip


def noise_arguments(draw):
    begins = filter_arguments(draw)
    return {
        **{name: begins[name] for name in ("model", "x_0", "S_0", "Q_root", "R_root")},
        "learns_Q": draw(st.booleans()), "learns_R": draw(st.booleans()),
        "diagonal": draw(st.booleans()),
    }  # fmt: skip


def sensitivity_arguments(draw):
    return {
        "model": model(draw), "x": some(draw, STEPS, N), "u": np.zeros((STEPS, L_U)),
        "measured": np.ones((STEPS, L_Y)), "scale": np.ones(N), "weight": np.ones(L_Y),
        "growth": 1e8,
    }  # fmt: skip


def controller(draw):
    arguments = controller_arguments(draw, 1, 1, 1, 0)
    if draw(st.booleans()):
        arguments["update"] = draw(st.sampled_from(["joint", "ud, subspace"]))
        arguments.pop("penalty", None)
    return arguments


def loop_arguments(draw):
    return {
        "controllers": [_kernel.controller(**controller_arguments(draw, 1, 1, 1, 0))],
        "plant": _kernel.linear_plant(**plant_arguments(draw, *ONES)),
        "low": -np.ones(1), "high": np.ones(1), "rate": np.full(1, 0.5), "limit": 1e100,
        "stop_where_unsupported": draw(st.booleans()), "shared_u": False, "r_in_w": 1,
    }  # fmt: skip


def job_arguments(draw):
    loop = _kernel.Loop(**loop_arguments(draw))
    row, stride = np.zeros((STEPS, 1)), draw(st.integers(1, 3))
    return {
        "loop": loop, "w": some(draw, STEPS, 1), "u": row.copy(), "u_applied": row.copy(),
        "y": row.copy(), "z": row.copy(),
        "theta": np.zeros((-(-STEPS // stride), len(loop.theta_before()))), "stride": stride,
    }  # fmt: skip


def lanes_arguments(draw):
    return {
        "Phi_f": some(draw, 4, 3, _kernel.lanes), "target": some(draw, 4, _kernel.lanes),
        "P_0": np.array([np.eye(3)] * _kernel.lanes), "theta_0": np.zeros((3, _kernel.lanes)),
        "forgetting": 0.99, "instruction_set": draw(st.sampled_from(_kernel.instruction_sets())),
    }  # fmt: skip


def replay_arguments(draw):
    return {
        "update": draw(st.sampled_from(["ud", "covariance"])), "Phi_f": some(draw, 4, 1, 3),
        "target": some(draw, 4, 1), "R_z": np.eye(1), "R_u": np.zeros((1, 1)), "P_0": np.eye(3),
        "theta_0": np.zeros(3), "forgetting": 0.99, "instruction_set": "",
    }  # fmt: skip


ARX = {"R_theta": 1e-3, "forgetting_factor": 0.99}


def arx(draw):
    """Arguments of a recursive ARX model with one or two inputs and outputs."""
    order, l_u, l_y = draw(st.integers(1, 6)), draw(st.integers(1, 2)), draw(st.integers(1, 2))
    theta_0 = np.zeros(order * (l_u + l_y))
    return {"order": order, **ARX, "l_u": l_u, "l_y": l_y, "target": 0, "theta_0": theta_0}


def box_jenkins_arguments(draw):
    """Arguments of the errors of a model, with more coefficients than the record may show."""
    orders = [draw(st.integers(0, 3)) for _ in range(4)]
    has_sinusoid, steps = draw(st.booleans()), draw(st.integers(1, 70))
    return {
        "y": some(draw, steps), "u": some(draw, steps),
        "levels": some(draw, draw(st.integers(0, 3)), steps),
        "weights": some(draw, steps if draw(st.booleans()) else 0),
        "theta": 0.3 * some(draw, sum(orders) + has_sinusoid), "orders": orders,
        "differences": draw(st.booleans()), "armax": draw(st.booleans()),
        "sinusoid": has_sinusoid, "dependent": 1e-9,
    }  # fmt: skip


def least_errors_arguments(draw):
    """The same, how to minimise them, and up to all coefficients kept."""
    arguments = box_jenkins_arguments(draw)
    return {
        **arguments, "kept": draw(st.integers(0, len(arguments["theta"]))),
        "iterations": draw(st.integers(0, 4)), "widths": draw(st.integers(0, 6)),
        "decrease": 1e-2, "settled": draw(st.sampled_from([0.0, 0.1])), "circle": 0.99999,
        "of_C": 0.995,
    }  # fmt: skip


FUNCTIONS = {
    "arx": arx,
    "mu_markov": lambda draw: {
        "mu": draw(st.integers(1, 6)), "n_mod": draw(st.integers(0, 3)), **ARX
    },
    "instruction_sets": lambda draw: {},
    "box_jenkins_errors": box_jenkins_arguments,
    "least_box_jenkins_errors": least_errors_arguments,
    "student_scale": lambda draw: {
        "e": some(draw, draw(st.integers(1, 9))), "degrees": 4.0, "least": 1e-3,
        "passes": draw(st.integers(0, 12)),
    },
    "confined_roots": lambda draw: {
        "A": np.concatenate([[1.0], some(draw, draw(st.integers(0, 6)))]),
        "radius": draw(st.sampled_from([0.9, 1.0])),
    },
    "errors_with_gaps": lambda draw: {
        "signals": some(draw, 2, 6), "whitener": np.array([1.0, -0.5]),
        "C": np.array([1.0, 0.3, 0.1]), "observed": np.array([1.0, 1, 0, 1, 0, 1]),
    },
    "controller": controller,
    "linear_plant": lambda draw: plant_arguments(draw, *ONES),
    "python_plant": lambda draw: python_plant_arguments(draw, *ONES),
    "compiled_plant": lambda draw: {
        "sizes": ONES, "advance": datetime_CAPI, "output": datetime_CAPI, "x_0": np.zeros(1)
    },
    "Loop": loop_arguments,
    "Job": job_arguments,
    "run_jobs": lambda draw: {
        "jobs": [_kernel.Job(**job_arguments(draw)) for _ in range(draw(st.integers(0, 2)))],
        "threads": draw(st.integers(0, 2)), "seconds": 1e-3, "lanes": draw(st.booleans()),
        "instruction_set": "",
    },
    "replay_updates": replay_arguments,
    "replay_ud_lanes": lanes_arguments,
    "linear_estimation_model": lambda draw: {
        "n": N, "l_u": L_U, "l_y": L_Y, "A": np.eye(N) / 2, "B": np.ones((N, L_U)),
        "C": np.eye(L_Y, N), "D": np.zeros((L_Y, L_U)),
    },
    "function_estimation_model": functions_of_a_model,
    "tape_estimation_model": lambda draw: {
        "n": N, "l_u": L_U, "l_y": L_Y, "f": tape(draw, N), "h": tape(draw, L_Y),
        "f_F": tape(draw, N + N * N), "h_H": tape(draw, L_Y + L_Y * N),
    },
    "filter": filter_arguments,
    "interacting_filters": interacting_arguments,
    "adaptive_filter": lambda draw: {
        **noise_arguments(draw), "window": draw(st.integers(2, 4)), "iterations": 2
    },
    "learn_noises": lambda draw: {
        **noise_arguments(draw), "u": np.zeros((STEPS, L_U)), "y": some(draw, STEPS, L_Y)
    },
    "sensitivity": sensitivity_arguments,
    "refinement": refinement_arguments,
}  # fmt: skip
# The first takes functions of a compiler, which the engine's tests give; the other one calls the
# functions of a model, which may answer with anything.
MAY_REFUSE = {"compiled_plant", "sensitivity", "learn_noises"}


def run_of_a_filter(draw, obj):
    there = [[draw(st.booleans())] for _ in range(STEPS)]
    return {
        "u": np.zeros((STEPS, L_U)), "y": np.where(there, some(draw, STEPS, L_Y), np.nan),
        "x": np.zeros((STEPS, N)), "deviation": np.zeros((STEPS, N)),
        "P": np.zeros((STEPS, N, N) if draw(st.booleans()) else 0),
        "innovation": np.zeros((STEPS, L_Y)), "nis": np.zeros(STEPS),
        "log_likelihood": np.zeros(STEPS),
        "probabilities": np.zeros((STEPS, len(obj.probabilities))),
    }  # fmt: skip


def run_of_a_refinement(draw, obj):
    return {
        "w": some(draw, STEPS, 1), "y": some(draw, STEPS, L_Y),
        "x": np.zeros((STEPS, N) if draw(st.booleans()) else 0),
        "theta": np.zeros((STEPS, len(obj.theta))), "z": np.zeros((STEPS, L_Y)),
        "u": np.zeros((STEPS, len(obj.u))),
    }  # fmt: skip


def new_target(draw, obj):
    order = draw(st.integers(0, obj.longest_order))
    denominator = np.zeros((order + 1, 1, 1))
    denominator[0] = 1.0
    past = draw(st.sampled_from(["keep", "reset", "blend", "replay"]))
    return {"numerator": some(draw, order + 1, 1, 1), "denominator": denominator, "past": past}


def copied_numbers(draw, obj):
    """P(0) or its diagonal, theta(0), lambda, weights and a target model of the same order."""
    (controller,) = obj.controllers
    numerator, denominator = controller.target
    l_theta = len(controller.theta)
    P_0 = draw(st.sampled_from([np.ones(l_theta), np.eye(l_theta)]))
    weights = np.eye(1), (np.eye(1), draw(st.sampled_from([0.0, 0.5])), 0.0)
    return (
        P_0, some(draw, l_theta), draw(st.sampled_from([1.0, 0.9])), *weights,
        [(numerator, denominator)],
    )  # fmt: skip


NOTHING = {"save": lambda draw, made: {}}
STATE = {**NOTHING, "restore": lambda draw, made: {"state": made.save()}}
FREEZE = {"freeze": lambda draw, made: {"frozen": draw(st.booleans())}}
ROW = {"k": 0, "u": np.ones(1), "w": np.ones(1)}
METHODS = {
    "BoxJenkinsErrors": {
        "remainder": lambda draw, errors: {"waves": draw(st.booleans())},
        "jacobian": lambda draw, errors: {},
    },
    "Arx": {
        **STATE,
        "take": lambda draw, made: {
            "u": some(draw, 12), "z": some(draw, 12) * draw(st.sampled_from([1.0, 1e150, 1e300]))
        },
    },
    "Controller": {
        **STATE,
        **FREEZE,
        "step": lambda draw, made: {
            "y": np.ones(1), "z": np.ones(1), "r": np.zeros(0), "u_applied": None
        },
        "reset_covariance": lambda draw, made: {},
        "resume_from_trouble": lambda draw, made: {},
        "take_over": lambda draw, made: {
            "u": np.ones(1), "fade": draw(st.sampled_from([0.0, 0.5, 0.999]))
        },
        "set_target": new_target,
        "set_weights": lambda draw, made: {"R_z": np.eye(1), "R_u": None, "penalty": np.eye(1)},
        "set_lambda": lambda draw, made: {"lambda_": draw(st.sampled_from([1.0, 0.5]))},
    },
    "EstimationModel": {
        "set_angles": lambda draw, made: {
            "is_angle": draw(st.lists(st.booleans(), min_size=L_Y, max_size=L_Y))
        }
    },
    "Filter": {
        **STATE,
        "move": lambda draw, made: {
            "y": np.ones(L_Y), "u": np.ones(L_U), "corrects": draw(st.booleans()),
            "predicts": draw(st.booleans()),
        },
        "run": run_of_a_filter,
        "set_noises": lambda draw, made: {"Q_root": np.eye(N), "R_root": np.zeros(0)},
    },
    "Job": {"pause_at": lambda draw, made: {"step": draw(st.integers(0, STEPS))}},
    "Loop": {
        **STATE,
        "theta_before": lambda draw, made: {},
        "copy": lambda draw, made: {
            "limit": draw(st.sampled_from([1.0, 1e100])),
            "x_0": draw(st.sampled_from([None, np.ones(1)])),
            "numbers": copied_numbers(draw, made) if draw(st.booleans()) else None,
        },
    },
    "Plant": {
        **STATE,
        "output": lambda draw, made: dict(ROW),
        "advance": lambda draw, made: dict(ROW),
    },
    "Refinement": {
        **STATE,
        **FREEZE,
        "step": lambda draw, made: {"w": np.ones(1), "y": np.ones(L_Y), "x": None},
        "half": lambda draw, made: {"given": np.ones(L_Y), "x": np.ones(N), "measures": True},
        "run": run_of_a_refinement,
    },
}  # fmt: skip
