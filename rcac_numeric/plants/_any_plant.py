"""Interface of plants: sizes, and the blocks of the exogenous input."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import instance_of, integer


class AnyPlant(Protocol):
    """Protocol of plants: `Plant`, `PlantSchedule`, `FunctionPlant`, or a custom class.

    The engine runs the classes that are registered in `rcac_numeric.compiled._plants`.
    """

    @property
    def n(self) -> int:
        """Number of states."""

    @property
    def l_u(self) -> int:
        """Number of control inputs."""

    @property
    def l_w(self) -> int:
        """Number of exogenous inputs."""

    @property
    def l_y(self) -> int:
        """Number of measurements."""

    @property
    def l_z(self) -> int:
        """Number of performance variables."""

    @property
    def blocks(self) -> Mapping[str, int]:
        """Names and widths of the blocks of w."""

    @property
    def y_needs_u(self) -> bool:
        """Whether y(k) depends on u(k) at some step."""

    @property
    def z_needs_u(self) -> bool:
        """Whether z(k) depends on u(k) at some step."""


def blocks_of_w(blocks: object, l_w: int) -> dict[str, int]:
    """Return names and widths of the blocks of w; one block "w" by default."""
    named_blocks = instance_of(blocks, "blocks", Mapping)
    read = {
        instance_of(name, "the name of a block", str): integer(width, f"the width of {name!r}")
        for name, width in named_blocks.items()
    } or {"w": l_w}
    if sum(read.values()) != l_w:
        raise InputError(f"the blocks {read} of w do not add up to l_w = {l_w}.")
    return read


def block_start(plant: AnyPlant, name: str) -> int:
    """Return the index of the first channel of a block of w."""
    names = list(plant.blocks)
    return sum(plant.blocks[before] for before in names[: names.index(name)])
