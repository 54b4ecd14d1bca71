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
