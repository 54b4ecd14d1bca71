from .forms._inverse_sampling import inverse_tustin as inverse_tustin
from .forms._inverse_sampling import inverse_zero_order_hold as inverse_zero_order_hold
from .forms._zero_order_hold import first_order_hold as first_order_hold
from .forms._zero_order_hold import matched as matched
from .forms._zero_order_hold import sampling_zero_polynomial as sampling_zero_polynomial
from .forms._zero_order_hold import tustin as tustin
from .forms._zero_order_hold import zero_order_hold as zero_order_hold
