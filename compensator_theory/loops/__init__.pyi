from .closed_loop_maps import closed_loop_transfer_matrix as closed_loop_transfer_matrix
from .closed_loop_maps import closed_loop_zero_polynomial as closed_loop_zero_polynomial
from .intercalation import (
    control_perturbation_transfer_function as control_perturbation_transfer_function,
)
from .intercalation import (
    control_perturbation_transfer_matrix as control_perturbation_transfer_matrix,
)
from .reachable_targets import target_characteristic_polynomial as target_characteristic_polynomial
from .sensitivity import compensator_from_sensitivity as compensator_from_sensitivity
from .zero_directions import direction_residual as direction_residual
