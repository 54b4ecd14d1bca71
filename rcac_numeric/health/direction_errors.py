"""Where a target model for several inputs and outputs loses zeros and their directions."""

from __future__ import annotations

from rcac_numeric.health.target_errors import TargetError
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.directions.checks import check_directions
from rcac_numeric.targets.model import TargetModel

LARGEST = 10  # states of a plant whose zeros and directions are asked for, exactly, in a second
CODES = {
    "not a zero": "unmodelled zero",
    "in every channel": "zero in every channel",
    "in one channel": "zero in one channel",
    "on the input side": "zero on the input side",
    "in another direction": "zero in another direction",
}
MEND = 'zero_direction_target(plant), in a file model = "zero directions"'


def direction_errors(plant: Plant, target: TargetModel) -> tuple[TargetError, ...]:
    """What `check_directions` finds of a square G_zu with several inputs; nothing of others.

    They are said of loops that look well too: a zero that is lost hides an instability from z.

    Parameters
    ----------
    plant : Plant
    target : TargetModel

    Raises
    ------
    InputError, NoSolutionError
        Where zeros or directions cannot be found, as `check_directions`.

    Examples
    --------
    >>> from rcac_numeric import DirectionInformation, load_example, zero_direction_target
    >>> from rcac_numeric.health.direction_errors import direction_errors
    >>> plant = load_example("9.1").main_run.plant
    >>> direction_errors(plant, zero_direction_target(plant))
    ()
    >>> channels = DirectionInformation([[1, 0.5], [-0.3, 1.2]], [(1.5, [1, 0]), (1.5, [0, 1])])
    >>> [error.code for error in direction_errors(plant, zero_direction_target(channels))]
    ['zero in every channel']
    """
    if plant.l_u < 2 or plant.l_u != plant.l_z or plant.n > LARGEST:
        return ()
    check = check_directions(target, plant)
    forms = [form for form in check.forms if form != "kept"]
    return tuple(
        TargetError(CODES[form], f"{sentence}.", MEND)
        for form, sentence in zip(forms, check.warnings, strict=True)
    )
