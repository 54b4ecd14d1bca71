"""From a model as data to a model that the kernel runs.

A new kind of model is registered here: `@compiled_model.register(YourModel)`.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.engine.compiled.estimators import (
    EstimationModel,
    function_estimation_model,
    linear_estimation_model,
    tape_estimation_model,
)
from rcac_numeric.estimation.models.linear import LinearModel
from rcac_numeric.estimation.models.nonlinear import NonlinearModel
from rcac_numeric.estimation.models.symbolic import SymbolicModel
from rcac_numeric.estimation.models.tape import NoTapeError, tape


@singledispatch
def compiled_model(model: object) -> EstimationModel:
    """The model for the kernel.

    Parameters
    ----------
    model : LinearModel, SymbolicModel or NonlinearModel

    Raises
    ------
    InputError
        Where it is of no kind that is registered.
    """
    kinds = [kind.__name__ for kind in compiled_model.registry if kind is not object]
    raise InputError(f"model = {model!r} is not a {' or '.join(kinds)}.")


@compiled_model.register(LinearModel)
def _(model: LinearModel) -> EstimationModel:
    return linear_estimation_model(
        model.n, model.l_u, model.l_y, model.A, model.B, model.C, model.D
    )


@compiled_model.register(NonlinearModel)
def _(model: NonlinearModel) -> EstimationModel:
    return function_estimation_model(
        model.n,
        model.l_u,
        model.l_y,
        model.joint_dynamics if model.l_p else model.dynamics,
        model.joint_output if model.l_p else model.output,
        None if model.dynamics_jacobian is None else model.joint_dynamics_jacobian,
        None if model.output_jacobian is None else model.joint_output_jacobian,
        model.scale,
    )


@compiled_model.register(SymbolicModel)
def _(model: SymbolicModel) -> EstimationModel:
    f, h, F, H = model.f, model.h, model.F, model.H
    given = [*model.x, *model.inputs, model.step]
    sizes = model.n, model.l_u, model.l_y
    try:
        return tape_estimation_model(
            *sizes, tape(f, given), tape(h, given), tape([*f, *F], given), tape([*h, *H], given)
        )
    except NoTapeError:  # Piecewise, special functions: Python calls for each step
        f_, h_, F_, H_ = map(model.function, (f, h, F, H))
        return function_estimation_model(*sizes, f_, h_, F_, H_, np.ones(model.n))
