from . import strategies as strategies
from .closed_loop_matrices import closed_loop_matrix as closed_loop_matrix
from .closed_loops import closed_loop_polynomial as closed_loop_polynomial
from .closed_loops import closed_loop_transfer_matrix as closed_loop_transfer_matrix
from .closed_loops import closed_loop_zero_polynomial as closed_loop_zero_polynomial
from .common_factors import BezoutIdentity as BezoutIdentity
from .common_factors import bezout_identity as bezout_identity
from .compensators import compensator_polynomials as compensator_polynomials
from .controllability import controllability_matrix as controllability_matrix
from .controllability import is_controllable as is_controllable
from .controllability import uncontrollable_polynomial as uncontrollable_polynomial
from .conversions import transfer_function as transfer_function
from .enclosures import Enclosure as Enclosure
from .enclosures import PolynomialEnclosure as PolynomialEnclosure
from .errors import CompensatorError as CompensatorError
from .errors import DivergedError as DivergedError
from .errors import ImproperError as ImproperError
from .errors import InputError as InputError
from .errors import NoSolutionError as NoSolutionError
from .errors import NotControllableError as NotControllableError
from .errors import NotCoprimeError as NotCoprimeError
from .errors import NotObservableError as NotObservableError
from .errors import NotReachableTargetError as NotReachableTargetError
from .errors import UnitCircleError as UnitCircleError
from .expressions import parse_expression as parse_expression
from .form_enumeration import observer_forms as observer_forms
from .high_authority import HighAuthorityLQG as HighAuthorityLQG
from .high_authority import high_authority_lqg as high_authority_lqg
from .high_authority_targets import HighAuthorityTarget as HighAuthorityTarget
from .high_authority_targets import high_authority_target as high_authority_target
from .intercalation import (
    control_perturbation_transfer_function as control_perturbation_transfer_function,
)
from .intercalation import (
    control_perturbation_transfer_matrix as control_perturbation_transfer_matrix,
)
from .intercalation import intercalated_transfer_function as intercalated_transfer_function
from .intercalation import intercalated_transfer_matrix as intercalated_transfer_matrix
from .lqg_suboptimality import is_lqg_suboptimal as is_lqg_suboptimal
from .numbers import exact_number as exact_number
from .observer_decisions import ObserverDecision as ObserverDecision
from .observer_design import ObserverBasedCompensator as ObserverBasedCompensator
from .observer_design import observer_based_compensator as observer_based_compensator
from .observer_form import ObserverForm as ObserverForm
from .observer_form_lists import ObserverForms as ObserverForms
from .observer_gains import observer_gain as observer_gain
from .observer_gains import regulator_gain as regulator_gain
from .observer_questions import pair_is_observer_based as pair_is_observer_based
from .observer_questions import (
    transfer_function_is_observer_based as transfer_function_is_observer_based,
)
from .placements import PolePlacement as PolePlacement
from .plants import servo_problem as servo_problem
from .plants import standard_problem as standard_problem
from .pole_placement import place_poles as place_poles
from .polynomials import monic as monic
from .polynomials import polynomial as polynomial
from .prescribed_roots import polynomial_from_roots as polynomial_from_roots
from .reachable_targets import target_characteristic_polynomial as target_characteristic_polynomial
from .real_factors import count_observer_forms as count_observer_forms
from .realisation_question import realisation_is_observer_based as realisation_is_observer_based
from .realisations import Realisation as Realisation
from .realisations import realisation as realisation
from .reciprocals import monic_reciprocal_polynomial as monic_reciprocal_polynomial
from .reciprocals import reciprocal_polynomial as reciprocal_polynomial
from .riccati_pencils import LQGPoles as LQGPoles
from .riccati_pencils import lqg_poles as lqg_poles
from .riccati_pencils import regulator_spectrum as regulator_spectrum
from .riccati_solutions import RiccatiSolution as RiccatiSolution
from .riccati_solutions import solve_riccati as solve_riccati
from .root_counts import RootCount as RootCount
from .root_counts import count_half_plane_roots as count_half_plane_roots
from .root_counts import number_of_real_roots as number_of_real_roots
from .root_regions import locate_half_plane_roots as locate_half_plane_roots
from .root_regions import locate_unit_disk_roots as locate_unit_disk_roots
from .roots import Root as Root
from .roots import certified_roots as certified_roots
from .schur_cohn import count_unit_disk_roots as count_unit_disk_roots
from .schur_cohn import reflection_coefficients as reflection_coefficients
from .spectral_factors import SpectralFactor as SpectralFactor
from .spectral_factors import spectral_factor as spectral_factor
from .stability import StabilityDecision as StabilityDecision
from .stability import decide_hurwitz as decide_hurwitz
from .stability import decide_schur as decide_schur
from .stability import hurwitz_determinants as hurwitz_determinants
from .standard_problems import StandardProblem as StandardProblem
from .sylvester import number_of_common_roots as number_of_common_roots
from .sylvester import resultant as resultant
from .sylvester import sylvester_m as sylvester_m
from .sylvester import sylvester_m1 as sylvester_m1
from .sylvester import sylvester_m2 as sylvester_m2
from .transfer_functions import TransferFunction as TransferFunction
from .transfer_matrices import TransferMatrix as TransferMatrix
from .unit_circle import split_at_unit_circle as split_at_unit_circle
from .unit_circle_enclosures import enclose_split_at_unit_circle as enclose_split_at_unit_circle
from .youla_forms import YoulaForm as YoulaForm
from .youla_forms import youla_forms as youla_forms
