"""The lateral dynamics of the aircraft of Chapter 3, and its transition."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number, one_of
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._problems import servo_plant
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule
from rcac_numeric.plants._zero_order_hold import zero_order_hold
from rcac_numeric.plants.gallery._continuous import ContinuousPlant

CONDITIONS = ("nominal", "off-nominal")
MEASUREMENTS = ("roll angle", "state", "dummy commands")
SOURCES = ("sampled", "corrected", "printed")

STATES = ("sideslip angle, rad", "roll rate, rad/s", "yaw rate, rad/s", "roll angle, rad")
PERIOD = 0.1  # s, section 3.2.1

# (3.1) and (3.2) differ in these entries: the roll and yaw moments of sideslip, and the yaw
# moment of the aileron.
_MOMENTS = {"nominal": (-25.60, 0.6160, -0.0222), "off-nominal": (-108.8, 0.4107, -0.0665)}

_PRINTED = {
    "nominal": (  # (3.3)
        [
            [0.9553, 0.0265, -0.0934, 0.0039],
            [-2.5210, 0.9680, 0.1310, -0.0050],
            [0.0551, 0.0045, 0.9708, 0.0001],
            [-0.1282, 0.0989, -0.0369, 1.0004],
        ],
        [[0.0034], [0.2492], [-0.0017], [0.0126]],
    ),
    "off-nominal": (  # (3.4)
        [
            [0.9482, 0.0255, -0.0900, 0.0038],
            [-10.3212, 0.9595, 0.5152, -0.0210],
            [0.0186, 0.0041, 0.9723, 0.0001],
            [-0.5304, 0.0953, -0.0239, 0.9999],
        ],
        [[0.0036], [0.2390], [-0.0061], [0.0124]],
    ),
}


def aircraft(condition: str = "nominal") -> ContinuousPlant:
    """The lateral dynamics (3.1) or (3.2) in continuous time, output roll angle.

    x = [sideslip angle, roll rate, yaw rate, roll angle],  u = aileron,  y = x_4

    Parameters
    ----------
    condition : {"nominal", "off-nominal"}

    Notes
    -----
    The NMP zero at 1.274 that Example 1.2 gives is a zero of this plant, in rad/s; sampled at
    0.1 s it is at 1.1359.

    Examples
    --------
    >>> from rcac_numeric.gallery import aircraft
    >>> aircraft("off-nominal").zeros().round(3)
    array([-1.607+0.j,  1.274+0.j])
    """
    L_beta, N_beta, N_u = _MOMENTS[one_of(condition, "condition", CONDITIONS)]
    return ContinuousPlant(
        A=[
            [-0.0771, 0.269, -0.9631, 0.0397],
            [L_beta, 0.0218, 0.0995, 0],
            [N_beta, 0.0376, -0.2687, 0],
            [0, 1, -0.4202, 0.0058],
        ],
        B=[[-0.0002], [2.519], [N_u], [0.0]],
        C=[[0, 0, 0, 1]],
        states=STATES,
        inputs=["aileron, rad"],
        outputs=STATES[3:],
    )


def aircraft_matrices(condition: str = "nominal", source: str = "sampled") -> tuple[Array, Array]:
    """A_D and B_D of the aircraft sampled at 0.1 s, (3.3) or (3.4).

    Parameters
    ----------
    condition : {"nominal", "off-nominal"}
    source : {"sampled", "corrected", "printed"}
        The zero-order hold of (3.1) or (3.2) rounded once; (3.3) or (3.4) with the two wrong
        digits of (3.4) put right; or as printed.

    Notes
    -----
    Errata. The matrices are a zero-order hold to four decimals; Euler's method, which the text
    names, gives unstable ones for both conditions. (3.4) has 0.9482 and 0.9595 on its diagonal in
    place of 0.8482 and 0.8595, and is unstable as printed. The sampling zero is at -1.00038 and
    -1.00041 sampled, outside the circle in both conditions; -0.9959 and -1.0027, from
    which the text tells minimum phase from nonminimum phase, are what four decimals make of it.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.gallery import aircraft_matrices
    >>> [round(float(abs(np.linalg.eigvals(aircraft_matrices("off-nominal", source)[0])).max()), 4)
    ...  for source in ("printed", "corrected", "sampled")]
    [1.0838, 0.9975, 0.9977]
    """
    one_of(condition, "condition", CONDITIONS)
    if one_of(source, "source", SOURCES) == "sampled":
        plant = aircraft(condition)
        return zero_order_hold(plant.A, plant.B, PERIOD)
    A, B = (np.array(part) for part in _PRINTED[condition])
    if source == "corrected" and condition == "off-nominal":
        A[0, 0], A[1, 1] = 0.8482, 0.8595
    return A, B


def aircraft_plant(
    condition: str = "nominal", measured: str = "roll angle", source: str = "sampled"
) -> Plant:
    """The servo problem of the aircraft at 0.1 s: output feedback or full-state feedback.

    Parameters
    ----------
    condition : {"nominal", "off-nominal"}
        (3.1) or (3.2).
    measured : {"roll angle", "state", "dummy commands"}
        y = z = r - phi; r - x with four commands; or, with one command for the roll angle,
        (3.5)-(3.7): z_i(k) = x_i(k-1) - x_i(k) for the other three states, which become states.
    source : {"sampled", "corrected", "printed"}
        The zero-order hold rounded once; (3.3), (3.4) with two digits put right; or as printed.

    Returns
    -------
    Plant
        w = [r; d; v], and w = [r; d] with dummy commands; d adds to u.

    Examples
    --------
    >>> from rcac_numeric.targets import output_subspace_zeros
    >>> from rcac_numeric.gallery import aircraft_plant
    >>> plant = aircraft_plant("off-nominal", "dummy commands")
    >>> plant
    Plant(n=7, l_u=1, l_w=2, l_y=4, l_z=4)
    >>> float(abs(output_subspace_zeros(plant).zeros).max().round(3))
    1.146
    """
    A, B = aircraft_matrices(condition, source)
    if one_of(measured, "measured", MEASUREMENTS) == "dummy commands":
        return _with_dummy_commands(A, B)
    C = np.eye(4) if measured == "state" else np.eye(4)[3:]
    matrices = {"A": A, "B": B, "D_1": B, "C": C}
    return servo_plant(**{name: value.tolist() for name, value in matrices.items()})


def aircraft_transition(
    start: float = 250.0,
    duration: float = 10.0,
    measured: str = "roll angle",
    source: str = "sampled",
) -> PlantSchedule:
    """The aircraft on its way from nominal to off-nominal, section 3.2.

    The matrices of the sampled plant move linearly from `start` on, all at the same time.

    Parameters
    ----------
    start, duration : float
        In s, multiples of 0.1 s; the text has 250 s and 10 s, and 1 s where it discusses
        figure 3.9.
    measured : {"roll angle", "state", "dummy commands"}
        As for `aircraft_plant`.
    source : {"sampled", "corrected", "printed"}
        As for `aircraft_plant`.

    Raises
    ------
    InputError
        If a time is negative, not finite or no multiple of 0.1 s, or the duration is zero.

    Examples
    --------
    >>> from rcac_numeric.gallery import aircraft_transition
    >>> aircraft_transition()
    PlantSchedule(n=4, l_u=1, l_w=3, l_y=1, l_z=1, changes at 0, 2500, 2600)
    """
    first, count = _steps(start, "start"), _steps(duration, "duration")
    if count < 1:
        raise InputError("duration = 0: a transition takes at least one period of 0.1 s.")
    before, after = (aircraft_plant(condition, measured, source) for condition in CONDITIONS)
    changes = [
        *([PlantChange(start=0, plant=before)] if first else []),
        PlantChange(start=first, plant=before, ramp=True),
        PlantChange(start=first + count, plant=after),
    ]
    return PlantSchedule(changes)


def _with_dummy_commands(A: Array, B: Array) -> Plant:
    """Return the plant with the state x and the previous x_1, x_2, x_3."""
    whole, drive = np.zeros((7, 7)), np.zeros((7, 1))
    whole[:4, :4], whole[4:, :3], drive[:4] = A, np.eye(3), B
    C = np.zeros((4, 7))
    C[:, :4], C[:3, 4:] = -np.eye(4), np.eye(3)
    reads_command = np.zeros((4, 2))
    reads_command[3, 0] = 1.0
    D_1 = np.hstack([np.zeros((7, 1)), drive])
    return Plant(
        A=whole, B=drive, D_1=D_1, C=C, D_2=reads_command, E_0=reads_command,
        blocks={"r": 1, "d": 1},
    )  # fmt: skip


def _steps(time: float, name: str) -> int:
    value = number(time, name)
    count = round(value / PERIOD) if np.isfinite(value) else -1
    if count < 0 or abs(count * PERIOD - value) > 1e-9 * max(1.0, abs(value)):
        raise InputError(f"{name} = {value:g} s is no multiple of the sampling period of 0.1 s.")
    return count
