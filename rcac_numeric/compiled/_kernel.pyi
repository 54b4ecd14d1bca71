"""The compiled kernel; the directory kernel is its source."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcac_numeric.arrays._array_types import Array

Pairs = Sequence[tuple[int, int]]
Sizes = tuple[int, int, int, int, int]

class Controller:
    def step(self, y: object, z: object, r: object, u_applied: object) -> tuple[Array, int] | None:
        """u(k) and 0 out of range, 1 fine, 2 something was noted; None where it cannot be read."""
    def resume_from_trouble(self) -> None: ...
    def take_over(self, u: Array, fade: float) -> None: ...
    @property
    def troubles(self) -> tuple[list[Any], list[Any], float, bool, bool, float]: ...
    def freeze(self, frozen: bool) -> None: ...
    def reset_covariance(self) -> None: ...
    def set_target(self, numerator: Array, denominator: Array, past: str) -> float:
        """How far the filtered signals moved; nothing has changed where it raises."""
    def set_weights(self, R_z: Any, R_u: Any, penalty: Array | None = ...) -> None: ...
    def set_lambda(self, lambda_: float) -> None: ...
    @property
    def target(self) -> tuple[Array, Array]: ...
    @property
    def longest_order(self) -> int: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...
    @property
    def theta(self) -> Array: ...
    @property
    def P(self) -> Array: ...
    @property
    def also_fitted(self) -> Array:
        """Coefficients d_1, d_2, ... of D_f that the update fits beside theta; empty for most."""
    @property
    def k(self) -> int: ...
    @property
    def forgetting_factor(self) -> float: ...
    @property
    def reflections(self) -> int: ...
    @property
    def resets(self) -> int: ...
    @property
    def bounded(self) -> int: ...
    @property
    def guard_count(self) -> int: ...
    @property
    def guard_first_step(self) -> int: ...

class Plant:
    @property
    def x(self) -> Array: ...
    def output(self, k: int, u: Array, w: Array) -> tuple[bool, Array, Array]: ...
    def advance(self, k: int, u: Array, w: Array) -> bool: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...

class Loop:
    def __init__(
        self,
        *,
        controllers: Sequence[Controller],
        plant: Plant,
        low: Array,
        high: Array,
        rate: Array,
        limit: float,
        stop_where_unsupported: bool,
        shared_u: bool,
        r_in_w: int,
    ) -> None: ...
    def copy(
        self, limit: float, x_0: Array | None = ..., numbers: tuple[Any, ...] | None = ...
    ) -> Loop:
        """A loop at its first step, made of copies.

        The numbers, of its one controller, are P(0) or its diagonal, theta(0), lambda, R_z, R_u
        and a list of one target model of the same order.
        """
    @property
    def controllers(self) -> list[Controller]: ...
    @property
    def counts(self) -> tuple[int, int, int, int, int]:
        """Guards, the first step of one or -1, reflections, resets and moves into bounds."""
    def theta_before(self) -> Array: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...

class Job:
    def __init__(
        self,
        loop: Loop,
        w: Array,
        u: Array,
        u_applied: Array | None,
        y: Array,
        z: Array,
        theta: Array,
        stride: int,
    ) -> None: ...
    def pause_at(self, step: int) -> None: ...
    @property
    def done(self) -> int: ...
    @property
    def outcome(self) -> int: ...

def run_jobs(
    jobs: Sequence[Job],
    threads: int,
    seconds: float,
    lanes: bool = False,
    instruction_set: str = "",
) -> bool:
    """Go on for about `seconds` and at least one step; whether there is anything left to do.

    The results do not depend on where the work is cut. Releases the interpreter lock.
    """

def controller(
    *,
    l_u: int,
    l_y: int,
    l_r: int,
    l_z: int,
    derived: Sequence[tuple[Array, Array, float, float]],
    regressor: Pairs,
    channels: Pairs,
    filtered: Pairs,
    targets: Sequence[tuple[Array, Array]],
    R_z: Any,
    R_u: Any,
    forgetting_factor: float,
    k_w: int,
    k_update: int,
    k_filter: int,
    filter_form: bool,
    reflect_poles: bool,
    events: Sequence[tuple[int, str, float]],
    forgetting: tuple[int, int, float, float],
    reset: tuple[int, float, float, int, int],
    noise: Array,
    update: str,
    P_0: Array,
    theta_0: Array,
    window: int,
    step_size: float,
    dither: tuple[int, float, float, int] = ...,
    penalty: Array = ...,
    normalization: tuple[int, float, float] = ...,
    bounds: tuple[Array, Array, bool, int] = ...,
    ellipsoid: tuple[Array, Array, bool, float, float] = ...,
    fixed: tuple[Array, Array] = ...,
    supervision: tuple[Any, ...] | None = ...,
    limits: tuple[Array, Array, Array, Array] = ...,
    instruction_set: str = ...,
) -> Controller: ...

class Arx:
    def take(self, u: Array, z: Array) -> bool: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...
    @property
    def k(self) -> int: ...
    @property
    def variance(self) -> float: ...
    @property
    def weight(self) -> float: ...
    @property
    def theta(self) -> Array: ...
    @property
    def errors(self) -> Array:
        """The last 256 errors of prediction, oldest first, each of the same variance."""
    @property
    def P(self) -> Array: ...

def arx(
    *,
    order: int,
    R_theta: float,
    forgetting_factor: float,
    l_u: int,
    l_y: int,
    target: int,
    theta_0: Array,
) -> Arx: ...
def mu_markov(*, mu: int, n_mod: int, R_theta: float, forgetting_factor: float) -> Arx: ...

class BoxJenkinsErrors:
    @property
    def theta(self) -> Array: ...
    @property
    def e(self) -> Array: ...
    @property
    def square(self) -> float: ...
    def remainder(self, waves: bool) -> Array:
        """What plant, levels, initial state and, on request, the sinusoid leave of y."""
    def jacobian(self) -> Array | None:
        """Shape (coefficients, steps); None where they leave float64."""

def box_jenkins_errors(
    *,
    y: Array,
    u: Array,
    levels: Array,
    weights: Array,
    theta: Array,
    orders: Sequence[int],
    differences: bool,
    armax: bool,
    sinusoid: bool,
    dependent: float,
) -> BoxJenkinsErrors | None:
    """None where the errors leave float64; an empty array of weights is that of ones."""

def least_box_jenkins_errors(
    *,
    y: Array,
    u: Array,
    levels: Array,
    weights: Array,
    theta: Array,
    orders: Sequence[int],
    differences: bool,
    armax: bool,
    sinusoid: bool,
    dependent: float,
    kept: int,
    iterations: int,
    widths: int,
    decrease: float,
    settled: float,
    circle: float,
    of_C: float,
) -> tuple[BoxJenkinsErrors, Array] | None: ...
def student_scale(e: Array, degrees: float, least: float, passes: int) -> float: ...
def confined_roots(A: Array, radius: float) -> Array: ...
def errors_with_gaps(
    *, signals: Array, whitener: Array, C: Array, observed: Array
) -> tuple[Array, float]: ...
def linear_plant(
    sizes: Sizes,
    segments: Sequence[tuple[int, Sequence[Array], bool, Array, int]],
    x_0: Array,
) -> Plant: ...
def python_plant(
    sizes: Sizes, advance: Callable[..., Any], output: Callable[..., Any], x_0: Array
) -> Plant: ...
def compiled_plant(sizes: Sizes, advance: Any, output: Any, x_0: Array) -> Plant: ...

class EstimationError(Exception): ...

class EstimationModel:
    def set_angles(self, is_angle: Sequence[bool]) -> None: ...

class Filter:
    def move(self, y: object, u: object, corrects: bool, predicts: bool) -> bool:
        """Whether the arguments could be read at once; then the filter has moved."""
    def run(
        self,
        u: Array,
        y: Array,
        x: Array,
        deviation: Array,
        P: Array,
        innovation: Array,
        nis: Array,
        log_likelihood: Array,
        probabilities: Array,
    ) -> None: ...
    def set_noises(self, Q_root: Array, R_root: Array) -> None: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...
    @property
    def k(self) -> int: ...
    @property
    def nis(self) -> float: ...
    @property
    def probabilities(self) -> Array: ...
    @property
    def noises(self) -> tuple[Array, Array]:
        """The roots of Q and R, in one dimension."""
    @property
    def innovation(self) -> Array: ...
    @property
    def corrected(self) -> Array: ...
    @property
    def x(self) -> Array: ...
    @property
    def P(self) -> Array: ...

class Refinement:
    def step(self, w: object, y: object, x: object) -> bool:
        """Whether the arguments could be read at once; then the model has moved."""
    def half(self, given: object, x: object, measures: bool) -> bool:
        """Measuring y(k), or else advancing with w(k); the same answer."""
    def run(self, w: Array, y: Array, x: Array, theta: Array, z: Array, u: Array) -> None: ...
    def freeze(self, frozen: bool) -> None: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...
    @property
    def k(self) -> int: ...
    @property
    def x(self) -> Array: ...
    @property
    def theta(self) -> Array: ...
    @property
    def z(self) -> Array: ...
    @property
    def u(self) -> Array: ...
    @property
    def P(self) -> Array: ...
    @property
    def guard_count(self) -> int: ...

Tape = tuple[Array, NDArray[np.int32], NDArray[np.int32]]

def linear_estimation_model(
    n: int, l_u: int, l_y: int, A: Array, B: Array, C: Array, D: Array
) -> EstimationModel: ...
def function_estimation_model(
    n: int,
    l_u: int,
    l_y: int,
    f: Callable[..., Any],
    h: Callable[..., Any],
    F: Callable[..., Any] | None,
    H: Callable[..., Any] | None,
    residual: object,
    scale: Array,
) -> EstimationModel: ...
def tape_estimation_model(
    n: int, l_u: int, l_y: int, f: Tape, h: Tape, f_F: Tape, h_H: Tape
) -> EstimationModel: ...
def filter(
    kind: str,
    model: EstimationModel,
    x_0: Array,
    S_0: Array,
    Q_root: Array,
    R_root: Array,
    alpha: float,
    beta: float,
) -> Filter: ...
def interacting_filters(
    filters: list[tuple[str, EstimationModel, Array, Array, Array, Array, float, float]],
    transitions: Array,
    probabilities: Array,
) -> Filter: ...
def adaptive_filter(
    model: EstimationModel,
    x_0: Array,
    S_0: Array,
    Q_root: Array,
    R_root: Array,
    window: int,
    iterations: int,
    learns_Q: bool,
    learns_R: bool,
    diagonal: bool,
) -> Filter: ...
def learn_noises(
    model: EstimationModel,
    x_0: Array,
    S_0: Array,
    Q_root: Array,
    R_root: Array,
    u: Array,
    y: Array,
    learns_Q: bool,
    learns_R: bool,
    diagonal: bool,
) -> tuple[Array, Array, float]:
    """Roots of Q and R after one iteration, and the log-likelihood under those given."""

def sensitivity(
    model: EstimationModel,
    x: Array,
    u: Array,
    measured: Array,
    scale: Array,
    weight: Array,
    growth: float,
) -> Array:
    """T, lower triangular, with TT' = O'O for the scaled and weighed observability matrix O."""

def refinement(
    *,
    sizes: Sequence[int],
    A: Array,
    D_1: Array,
    B: Array,
    C: Array,
    delays: Sequence[int],
    stack: Sequence[int],
    H: Array,
    R: Array,
    eigenvalues: Array,
    V_d: Array,
    W: Array,
    chosen: int,
    eta_bar: float,
    forgetting: float,
    direct: bool,
    change: bool,
    k_update: int,
    E_1: Array,
    n_c: int,
    strictly_proper: bool,
    A_j: Array,
    D_j: Array,
    P_0: Array,
    theta_0: Array,
    x_0: Array,
) -> Refinement: ...

lanes: int

def instruction_sets() -> list[str]:
    """The instruction sets compiled in that this processor runs, the chosen one first."""

def replay_updates(
    update: str,
    Phi_f: Array,
    target: Array,
    *,
    R_z: Array,
    R_u: Array,
    forgetting: float = 1.0,
    P_0: Array,
    theta_0: Array,
    repeat: int = 1,
    instruction_set: str = "",
) -> tuple[Array, Array, int, int, bool]:
    """Recorded Phi_f (steps, l_z, l_theta) and z - u_f (steps, l_z) given to an update again.

    `update` is "ud" or "covariance", `instruction_set` one of `instruction_sets()` or "" for the
    chosen one; the record is run through `repeat` times. Returns theta, P, the guard's count and
    first step, and whether all stayed in the range of float64. Releases the interpreter lock.
    """

def replay_ud_lanes(
    Phi_f: Array,
    target: Array,
    *,
    forgetting: float = 1.0,
    P_0: Array,
    theta_0: Array,
    repeat: int = 1,
    instruction_set: str = "",
) -> tuple[Array, Array, list[int], bool]:
    """`lanes` independent runs in lock step, with R_z = 1 and R_u = 0.

    Shapes: Phi_f (steps, l_theta, lanes), target (steps, lanes), P_0 (lanes, l_theta, l_theta),
    theta_0 (l_theta, lanes). Returns theta, P, each lane's guard count, and whether all stayed
    in the range of float64. Releases the interpreter lock.
    """
