from .stability._laurent import laurent_expansion as laurent_expansion
from .stability._pade import pade_approximant as pade_approximant
from .stability._partial_realisations import partial_realisation as partial_realisation
from .stability._pick_interpolation import nevanlinna_pick as nevanlinna_pick
