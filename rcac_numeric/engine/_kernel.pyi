"""The compiled kernel; the directory kernel is its source."""

from collections.abc import Callable, Sequence
from typing import Any

from rcac_numeric.arrays.array_types import Array

Pairs = Sequence[tuple[int, int]]
Sizes = tuple[int, int, int, int, int]

class Controller:
    def step(self, y: Array, z: Array, r: Array, u_applied: Array) -> tuple[Array, bool]: ...
    def freeze(self, frozen: bool) -> None: ...
    def reset_covariance(self) -> None: ...
    def save(self) -> Array: ...
    def restore(self, state: Array) -> None: ...
    @property
    def theta(self) -> Array: ...
    @property
    def P(self) -> Array: ...
    @property
    def k(self) -> int: ...
    @property
    def forgetting_factor(self) -> float: ...
    @property
    def reflections(self) -> int: ...
    @property
    def resets(self) -> int: ...
    @property
    def guard_count(self) -> int: ...
    @property
    def guard_first_step(self) -> int: ...

class Plant:
    @property
    def x(self) -> Array: ...
    def output(self, k: int, u: Array, w: Array) -> tuple[bool, Array, Array]: ...
    def advance(self, k: int, u: Array, w: Array) -> bool: ...

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
    derived: Sequence[tuple[Array, Array, float]],
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
) -> Controller: ...
def linear_plant(
    sizes: Sizes,
    segments: Sequence[tuple[int, Sequence[Array], bool, Array, int]],
    x_0: Array,
) -> Plant: ...
def python_plant(
    sizes: Sizes, advance: Callable[..., Any], output: Callable[..., Any], x_0: Array
) -> Plant: ...
def compiled_plant(sizes: Sizes, advance: Any, output: Any, x_0: Array) -> Plant: ...

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
