from .laurent import laurent_expansion as laurent_expansion
from .pade import pade_approximant as pade_approximant
from .partial_realisations import partial_realisation as partial_realisation
from .pick_interpolation import nevanlinna_pick as nevanlinna_pick
