"""Compiled kernel objects from plants, updates and controllers."""

import sys
from importlib.util import find_spec

from compensator_theory.errors import CompensatorError


class KernelNotBuiltError(CompensatorError, ImportError):
    """The compiled kernel was not built, or not for this Python."""


if find_spec(f"{__name__}._kernel") is None:  # a checkout on the path, not installed
    raise KernelNotBuiltError(
        f"the compiled kernel of rcac_numeric is not built for {sys.executable}: in the checkout, "
        f"`{sys.executable} -m pip install -e .` builds it; that needs a C++17 compiler."
    )
