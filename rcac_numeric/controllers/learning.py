"""Whether a controller can learn its target model."""

from __future__ import annotations

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.targets.data_driven import DataDriven


def require_learnable(learning: DataDriven, structure: Structure, l_z: int) -> None:
    """Raise where a target model cannot be learnt for a controller of this structure.

    Parameters
    ----------
    learning : DataDriven
    structure : Structure
    l_z : int

    Raises
    ------
    InputError
        Where u or z is not scalar, or the order that u~ needs is above that of the model.

    Examples
    --------
    >>> from rcac_numeric import DataDriven, iir
    >>> from rcac_numeric.controllers.learning import require_learnable
    >>> require_learnable(DataDriven(order=20, input="frozen u~", n=3), iir(n_c=15), 1)
    """
    instance_of(learning, "learning", DataDriven)
    widths = structure.l_u, l_z
    if widths != (1, 1):
        raise InputError(
            f"DataDriven learns a target model for scalar u and z; here (l_u, l_z) = {widths}."
        )
    if not learning.is_frozen or learning.n is None:
        return
    if structure.derived:
        raise InputError(
            f'input = "frozen u~" is for a regressor of u, y and r; this {structure.name} '
            'structure derives signals of its own. Use input = "u".'
        )
    if learning.order < (least := learning.n + structure.n_c):
        raise InputError(
            f"order = {learning.order} is below n + n_c = {learning.n} + {structure.n_c}: from u~ "
            "to z the loop has that order, and a model of a lower one is biased for good. Use "
            f'order = {least} or more, or input = "u".'
        )
