from . import strategies as strategies
from .closed_loops import closed_loop_polynomial as closed_loop_polynomial
from .closed_loops import closed_loop_transfer_matrix as closed_loop_transfer_matrix
from .closed_loops import closed_loop_zero_polynomial as closed_loop_zero_polynomial
from .compensators import compensator_polynomials as compensator_polynomials
from .conversions import transfer_function as transfer_function
from .errors import CompensatorError as CompensatorError
from .errors import DivergedError as DivergedError
from .errors import ImproperError as ImproperError
from .errors import InputError as InputError
from .errors import NoSolutionError as NoSolutionError
from .errors import NotCoprimeError as NotCoprimeError
from .errors import NotReachableTargetError as NotReachableTargetError
from .errors import UnitCircleError as UnitCircleError
from .expressions import parse_expression as parse_expression
from .intercalation import (
    control_perturbation_transfer_function as control_perturbation_transfer_function,
)
from .intercalation import (
    control_perturbation_transfer_matrix as control_perturbation_transfer_matrix,
)
from .intercalation import intercalated_transfer_function as intercalated_transfer_function
from .intercalation import intercalated_transfer_matrix as intercalated_transfer_matrix
from .numbers import exact_number as exact_number
from .placements import PolePlacement as PolePlacement
from .plants import servo_problem as servo_problem
from .plants import standard_problem as standard_problem
from .pole_placement import place_poles as place_poles
from .polynomials import monic as monic
from .polynomials import polynomial as polynomial
from .prescribed_roots import polynomial_from_roots as polynomial_from_roots
from .reachable_targets import target_characteristic_polynomial as target_characteristic_polynomial
from .roots import Root as Root
from .roots import certified_roots as certified_roots
from .standard_problems import StandardProblem as StandardProblem
from .sylvester import number_of_common_roots as number_of_common_roots
from .sylvester import resultant as resultant
from .sylvester import sylvester_m as sylvester_m
from .sylvester import sylvester_m1 as sylvester_m1
from .sylvester import sylvester_m2 as sylvester_m2
from .transfer_functions import TransferFunction as TransferFunction
from .transfer_matrices import TransferMatrix as TransferMatrix
from .unit_circle import split_at_unit_circle as split_at_unit_circle
from .common_factors import BezoutIdentity as BezoutIdentity
from .common_factors import bezout_identity as bezout_identity
from .enclosures import Enclosure as Enclosure
from .enclosures import PolynomialEnclosure as PolynomialEnclosure
from .reciprocals import monic_reciprocal_polynomial as monic_reciprocal_polynomial
from .reciprocals import reciprocal_polynomial as reciprocal_polynomial
from .root_counts import RootCount as RootCount
from .root_counts import count_half_plane_roots as count_half_plane_roots
from .root_counts import number_of_real_roots as number_of_real_roots
from .root_regions import locate_half_plane_roots as locate_half_plane_roots
from .root_regions import locate_unit_disk_roots as locate_unit_disk_roots
from .schur_cohn import count_unit_disk_roots as count_unit_disk_roots
from .schur_cohn import reflection_coefficients as reflection_coefficients
from .spectral_factors import SpectralFactor as SpectralFactor
from .spectral_factors import spectral_factor as spectral_factor
from .stability import StabilityDecision as StabilityDecision
from .stability import decide_hurwitz as decide_hurwitz
from .stability import decide_schur as decide_schur
from .stability import hurwitz_determinants as hurwitz_determinants
from .unit_circle_enclosures import enclose_split_at_unit_circle as enclose_split_at_unit_circle
