from ._laurent import laurent_expansion as laurent_expansion
from ._pade import pade_approximant as pade_approximant
from ._partial_realisations import partial_realisation as partial_realisation
from ._pick_interpolation import nevanlinna_pick as nevanlinna_pick
