from .plants.gallery._aircraft import aircraft as aircraft
from .plants.gallery._aircraft import aircraft_matrices as aircraft_matrices
from .plants.gallery._aircraft import aircraft_plant as aircraft_plant
from .plants.gallery._aircraft import aircraft_transition as aircraft_transition
from .plants.gallery._boost_converter import BoostConverter as BoostConverter
from .plants.gallery._cart_pendulum import CartPendulum as CartPendulum
from .plants.gallery._continuous import ContinuousPlant as ContinuousPlant
from .plants.gallery._limited_margins import limited_delay_margin as limited_delay_margin
from .plants.gallery._limited_margins import no_guaranteed_margins as no_guaranteed_margins
from .plants.gallery._limited_margins import (
    no_guaranteed_margins_standard as no_guaranteed_margins_standard,
)
from .plants.gallery._mass_spring import MassSpringDamper as MassSpringDamper
from .plants.gallery._rohrs import critical_period as critical_period
from .plants.gallery._rohrs import rohrs_plant as rohrs_plant
from .plants.gallery._rohrs import sampling_zeros as sampling_zeros
from .plants.gallery._zeros import plant_zeros as plant_zeros
from .plants.gallery._zeros import zero_path as zero_path
