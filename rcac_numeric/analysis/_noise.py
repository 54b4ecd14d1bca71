"""Noise models of w: intensities by name, slow bias, drifting oscillations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight, square_root_columns
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant

NoiseIntensities = Mapping[str, ArrayLike]


@dataclass(frozen=True, eq=False)
class NoiseInputs(Value):
    """Unit-intensity white noise inputs of a plant, in place of w.

    Attributes
    ----------
    names : tuple of str
        For each column the entry of the intensities that it belongs to.
    factor : array, shape (l_w, columns)
        w = factor @ noise.
    D_1, D_2, E_0 : arrays with one column for each noise
    """

    names: tuple[str, ...]
    factor: Array
    D_1: Array
    D_2: Array
    E_0: Array


def noise_inputs(plant: Plant, noise: NoiseIntensities | None = None) -> NoiseInputs:
    """Read noise intensities by the name of a block or a channel of w."""
    if noise is None:
        noise = dict.fromkeys(plant.channels, 1.0)
    if not isinstance(noise, Mapping):
        raise InputError(f"noise = {noise!r} must map names of blocks of w to intensities.")
    places = _places(plant)
    names: list[str] = []
    columns: list[Array] = []
    channels: set[int] = set()
    for name, intensity in noise.items():
        if name not in places:
            raise InputError(f"w has no block or channel {name!r}; it has {', '.join(places)}.")
        where = places[name]
        if channels & set(where):
            raise InputError(f"the noise {name!r} is given twice, as a block and as a channel.")
        channels |= set(where)
        root = square_root_columns(
            constant_weight(intensity, f"the intensity of {name}", len(where), definite=False)
        )
        if root.shape[1] == 0:  # a noise of zero intensity has a share of zero
            root = np.zeros((len(where), 1))
        placed = np.zeros((plant.l_w, root.shape[1]))
        placed[where] = root
        columns.append(placed)
        names += [name] * root.shape[1]
    factor = np.hstack(columns) if columns else np.zeros((plant.l_w, 0))
    maps = (np.asarray(m @ factor) for m in (plant.D_1, plant.D_2, plant.E_0))
    return NoiseInputs(tuple(names), factor, *maps)


def with_bias(plant: Plant, channel: str, *, pole: float, mean_square: float) -> Plant:
    """Return the plant with a slow disturbance b(k+1) = pole b(k) + noise on a channel of w.

    A design for it expects a bias of that mean square, which lasts about 1/(1 - pole) steps, and
    approaches a controller with an internal model at 1 as the pole goes there. A pole at 1 is an
    uncontrollable mode on the circle: LQG refuses it.

    Parameters
    ----------
    plant : Plant
    channel : str
        One of `plant.channels`.
    pole : float
        In (-1, 1).
    mean_square : float
        The stationary E[b(k)^2]; the noise that drives b has 1 - pole^2 times this intensity.

    Returns
    -------
    Plant
        Of order n + 1, with one more channel of w, the block ``channel + "_bias"``, of unit
        intensity.

    Examples
    --------
    >>> from rcac_numeric import standard_plant, with_bias
    >>> with_bias(standard_plant("1/(q - 0.5)"), "w", pole=0.99, mean_square=4.0).blocks
    {'w': 1, 'w_bias': 1}
    """
    plant = linear_plant(plant)
    if channel not in plant.channels:
        raise InputError(f"w has no channel {channel!r}; it has {', '.join(plant.channels)}.")
    if f"{channel}_bias" in plant.blocks:
        raise InputError(
            f"{channel} has a bias already, the block {channel}_bias; add one to another channel."
        )
    pole, power = number(pole, "pole"), number(mean_square, "mean_square")
    if not -1 < pole < 1:
        raise InputError(
            f"pole = {pole} must lie inside (-1, 1): the mode of the disturbance is "
            f"uncontrollable. "
            "For a constant bias take a pole near 1, such as 0.999."
        )
    if power < 0:
        raise InputError(f"mean_square = {power} must not be negative.")
    drive = np.sqrt((1 - pole**2) * power)
    return _with_model(plant, channel, np.array([[pole]]), np.array([[drive]]), "bias")


def with_oscillation(
    plant: Plant, channel: str, *, omega: float, radius: float, mean_square: float,
    name: str = "oscillation",
) -> Plant:  # fmt: skip
    """Return the plant with a sinusoid of drifting amplitude and phase on a channel of w.

    s(k+1) = radius [cos omega, sin omega; -sin omega, cos omega] s(k) + noise, b(k) = s_1(k): the
    model whose inverse LQG builds into the controller, as `with_bias` is that of a constant.
    """
    plant = linear_plant(plant)
    if channel not in plant.channels:
        raise InputError(f"w has no channel {channel!r}; it has {', '.join(plant.channels)}.")
    omega, radius = number(omega, "omega"), number(radius, "radius")
    if not 0 < radius < 1 or mean_square < 0:
        raise InputError(
            f"radius = {radius:g} must lie in (0, 1) and mean_square = {mean_square:g} must not "
            f"be negative: the mode of the disturbance is uncontrollable."
        )
    turn = np.array([[np.cos(omega), np.sin(omega)], [-np.sin(omega), np.cos(omega)]])
    drive = np.sqrt((1 - radius**2) * mean_square) * np.eye(2)
    return _with_model(plant, channel, radius * turn, drive, name)


def _with_model(plant: Plant, channel: str, S: Array, drive: Array, name: str) -> Plant:
    """Return the plant with the first state of s(k+1) = S s(k) + drive noise on a channel."""
    at, n, m = plant.channels.index(channel), plant.n, len(S)

    def beside(block: Array, from_channel: Array) -> Array:
        return np.hstack([block, from_channel, np.zeros((len(block), m - 1))])

    none = np.zeros
    return Plant(
        A=np.vstack([beside(plant.A, plant.D_1[:, [at]]), np.hstack([none((m, n)), S])]),
        B=np.vstack([plant.B, none((m, plant.l_u))]),
        D_1=np.block([[plant.D_1, none((n, m))], [none((m, plant.l_w)), drive]]),
        C=beside(plant.C, plant.D_2[:, [at]]),
        D_0=plant.D_0,
        D_2=np.hstack([plant.D_2, none((plant.l_y, m))]),
        E_1=beside(plant.E_1, plant.E_0[:, [at]]),
        E_2=plant.E_2,
        E_0=np.hstack([plant.E_0, none((plant.l_z, m))]),
        blocks={**plant.blocks, f"{channel}_{name}": m},
    )


def _places(plant: Plant) -> dict[str, list[int]]:
    """Return the indices of w of each block and channel."""
    places: dict[str, list[int]] = {}
    first = 0
    for name, width in plant.blocks.items():
        places[name] = list(range(first, first + width))
        first += width
    return {**places, **{name: [i] for i, name in enumerate(plant.channels)}}
