"""The compiled kernel; kernel/bindings.cpp is its source."""

from collections.abc import Callable, Sequence

from rcac_numeric.validation import Array

Pairs = Sequence[tuple[int, int]]

class Controller:
    def step(self, y: Array, z: Array) -> tuple[Array, bool]: ...
    @property
    def theta(self) -> Array: ...
    @property
    def P(self) -> Array: ...
    @property
    def k(self) -> int: ...
    @property
    def guard_count(self) -> int: ...
    @property
    def guard_first_step(self) -> int: ...

class Plant:
    @property
    def x(self) -> Array: ...
    def output(self, u: Array, w: Array) -> tuple[Array, Array]: ...
    def advance(self, u: Array, w: Array) -> None: ...

def controller(
    *,
    l_u: int,
    l_y: int,
    l_z: int,
    regressor: Pairs,
    channels: Pairs,
    filtered: Pairs,
    numerator: Array,
    denominator: Array,
    forgetting: float,
    R_z: Array,
    R_u: Array,
    R_u_of_z: Callable[[Array], Array] | None,
    k_w: int,
    k_update: int,
    k_filter: int,
    update: str,
    P_0: Array,
    theta_0: Array,
) -> Controller: ...
def plant(
    *,
    A: Array,
    B: Array,
    D_1: Array,
    C: Array,
    D_0: Array,
    D_2: Array,
    E_1: Array,
    E_2: Array,
    E_0: Array,
    x_0: Array,
    l_u: int,
    l_w: int,
    l_y: int,
    l_z: int,
) -> Plant: ...
def simulate(
    controller: Controller,
    plant: Plant,
    w: Array,
    limit: float,
    u: Array,
    y: Array,
    z: Array,
    theta: Array,
    stride: int,
) -> int: ...

lanes: int

def levels() -> list[str]:
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
    level: str = "",
) -> tuple[Array, Array, int, int, bool]:
    """Recorded Phi_f (steps, l_z, l_theta) and z - u_f (steps, l_z) given to an update again.

    `update` is "ud", "covariance" or "symmetric covariance", `level` one of `levels()` or "" for
    the chosen one; the record is run through `repeat` times. Returns theta, P, the guard's count
    and first step, and whether all stayed in the range of float64. Releases the interpreter lock.
    """

def replay_ud_lanes(
    Phi_f: Array,
    target: Array,
    *,
    forgetting: float = 1.0,
    P_0: Array,
    theta_0: Array,
    repeat: int = 1,
    level: str = "",
) -> tuple[Array, Array, list[int], bool]:
    """`lanes` independent runs in lock step, with R_z = 1 and R_u = 0.

    Shapes: Phi_f (steps, l_theta, lanes), target (steps, lanes), P_0 (lanes, l_theta, l_theta),
    theta_0 (l_theta, lanes). Returns theta, P, each lane's guard count, and whether all stayed
    in the range of float64. Releases the interpreter lock.
    """
