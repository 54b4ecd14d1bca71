__version__: str
from . import bezout as bezout
from . import errors as errors
from . import forms as forms
from . import geometry as geometry
from . import interpolation as interpolation
from . import loops as loops
from . import observers as observers
from . import results as results
from . import roots as roots
from . import sampling as sampling
from . import strategies as strategies
from . import teaching as teaching
from .bezout._common_factors import bezout_identity as bezout_identity
from .bezout._resultants import resultant as resultant
from .certificates._coq import to_coq as to_coq
from .certificates._records import certificate_record as certificate_record
from .errors import CompensatorError as CompensatorError
from .errors import InputError as InputError
from .exceptional_sets._analysis import exceptional_cases as exceptional_cases
from .forms._coprime_fractions import coprime_fractions as coprime_fractions
from .forms._descriptor_realisations import descriptor_realisation as descriptor_realisation
from .forms._expansions import markov_parameters as markov_parameters
from .forms._expansions import partial_fractions as partial_fractions
from .forms._hankel_matrices import hankel_matrix as hankel_matrix
from .forms._hankel_matrices import mcmillan_degree as mcmillan_degree
from .forms._kalman import kalman_decomposition as kalman_decomposition
from .forms._matrix_equations import solve_matrix_diophantine as solve_matrix_diophantine
from .forms._minimal_realisations import minimal_realisation as minimal_realisation
from .forms._polynomial_equations import solve_diophantine as solve_diophantine
from .forms._polynomial_matrices import polynomial_matrix as polynomial_matrix
from .forms._zeros import input_decoupling_zeros as input_decoupling_zeros
from .forms._zeros import invariant_zeros as invariant_zeros
from .forms._zeros import output_decoupling_zeros as output_decoupling_zeros
from .forms._zeros import transmission_zeros as transmission_zeros
from .loops._closed_loop_maps import closed_loop_polynomial as closed_loop_polynomial
from .loops._closed_loop_matrix import closed_loop_matrix as closed_loop_matrix
from .loops._feedback import feedback_connection as feedback_connection
from .loops._intercalation import intercalated_transfer_function as intercalated_transfer_function
from .loops._intercalation import intercalated_transfer_matrix as intercalated_transfer_matrix
from .loops._sensitivity import sensitivity_function as sensitivity_function
from .loops._zero_directions import zero_direction_target as zero_direction_target
from .lqg._controllers import lqg_controller as lqg_controller
from .lqg._gramians import gramians as gramians
from .lqg._high_authority_limits import high_authority_limits as high_authority_limits
from .lqg._locus import regulator_locus as regulator_locus
from .lqg._poles import lqg_poles as lqg_poles
from .lqg._regulator_equations import (
    solve_regulator_equations as solve_regulator_equations,
)
from .lqg._regulator_spectra import regulator_spectrum as regulator_spectrum
from .lqg._riccati import solve_riccati as solve_riccati
from .lqg._riccati_formulas import riccati_formula as riccati_formula
from .lqg._sylvester_equations import solve_lyapunov as solve_lyapunov
from .lqg._sylvester_equations import solve_stein as solve_stein
from .lqg._sylvester_equations import solve_sylvester as solve_sylvester
from .lqg._targets import high_authority_target as high_authority_target
from .lqg._weighted_problems import lqg_problem as lqg_problem
from .observers._design import observer_based_compensator as observer_based_compensator
from .observers._enumeration import observer_forms as observer_forms
from .observers._functional import functional_observer as functional_observer
from .observers._functional import reduced_order_observer as reduced_order_observer
from .observers._gains import observer_gain as observer_gain
from .observers._gains import regulator_gain as regulator_gain
from .observers._predictive_cost import predictive_cost_compensator as predictive_cost_compensator
from .placement._brunovsky import brunovsky_form as brunovsky_form
from .placement._doubly_coprime import doubly_coprime_fractions as doubly_coprime_fractions
from .placement._eigenstructure import assign_eigenstructure as assign_eigenstructure
from .placement._eigenstructure import reachable_eigenvectors as reachable_eigenvectors
from .placement._gain_families import state_feedback_family as state_feedback_family
from .placement._matrix_placement import place_matrix_poles as place_matrix_poles
from .placement._observer_gain_families import observer_gain_family as observer_gain_family
from .placement._pole_placement import place_poles as place_poles
from .placement._stabilising_compensators import (
    stabilising_compensators as stabilising_compensators,
)
from .polynomials._ball_precision import ball_precision as ball_precision
from .polynomials._budget import Budget as Budget
from .polynomials._budget import budget as budget
from .polynomials._expressions import parse_expression as parse_expression
from .polynomials._from_roots import polynomial_from_roots as polynomial_from_roots
from .polynomials._from_roots import read_roots as read_roots
from .polynomials._numbers import exact_number as exact_number
from .polynomials._poly import monic as monic
from .polynomials._reading import polynomial as polynomial
from .responses._responses import impulse_response as impulse_response
from .responses._responses import step_response as step_response
from .responses._responses import time_response as time_response
from .responses._transition_matrices import transition_matrix as transition_matrix
from .roots._certified import certified_roots as certified_roots
from .roots._counts import count_roots as count_roots
from .roots._regions import locate_roots as locate_roots
from .roots._spectral_factors import spectral_factor as spectral_factor
from .roots._stability import decide_stability as decide_stability
from .stability._conditions import stability_conditions as stability_conditions
from .stability._delayed_margins import stability_margins as stability_margins
from .stability._delays import stability_delays as stability_delays
from .stability._interval_polynomials import (
    decide_interval_stability as decide_interval_stability,
)
from .stability._norms import h_infinity_norm as h_infinity_norm
from .stability._passivity import decide_bounded_real as decide_bounded_real
from .stability._passivity import decide_positive_real as decide_positive_real
from .stability._root_locus import root_locus as root_locus
from .stability._simultaneous import (
    decide_simultaneous_stabilisability as decide_simultaneous_stabilisability,
)
from .stability._stabilising_gains import stabilising_gains as stabilising_gains
from .stability._stability_arrays import jury_array as jury_array
from .stability._stability_arrays import routh_array as routh_array
from .stability._stability_intervals import stability_intervals as stability_intervals
from .stability._stability_regions import stability_region as stability_region
from .stability._stable_compensators import stable_compensator as stable_compensator
from .stability._strong_stabilisability import (
    decide_strong_stabilisability as decide_strong_stabilisability,
)
from .systems._canonical_forms import realisation as realisation
from .systems._canonical_text import canonical as canonical
from .systems._controllability import controllability_matrix as controllability_matrix
from .systems._controllability import is_controllable as is_controllable
from .systems._controllability import uncontrollable_polynomial as uncontrollable_polynomial
from .systems._dead_times import transfer_function as transfer_function
from .systems._delayed_transfer_functions import (
    DelayedTransferFunction as DelayedTransferFunction,
)
from .systems._descriptor_systems import DescriptorSystem as DescriptorSystem
from .systems._difference_equations import compensator_polynomials as compensator_polynomials
from .systems._matrix_conversions import transfer_matrix as transfer_matrix
from .systems._realisations import Realisation as Realisation
from .systems._standard_problems import StandardProblem as StandardProblem
from .systems._standard_problems import servo_problem as servo_problem
from .systems._standard_problems import standard_problem as standard_problem
from .systems._transfer_functions import TransferFunction as TransferFunction
from .systems._transfer_matrices import TransferMatrix as TransferMatrix
