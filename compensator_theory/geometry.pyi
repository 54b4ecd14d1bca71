from .placement._decoupling import decouple as decouple
from .placement._disturbance_decoupling import decouple_disturbance as decouple_disturbance
from .placement._fixed_modes import decentralised_fixed_modes as decentralised_fixed_modes
from .placement._interactors import interactor as interactor
from .placement._invariant_subspaces import (
    controlled_invariant_subspaces as controlled_invariant_subspaces,
)
