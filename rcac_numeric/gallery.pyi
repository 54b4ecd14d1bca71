from .plants.gallery.aircraft import aircraft as aircraft
from .plants.gallery.aircraft import aircraft_matrices as aircraft_matrices
from .plants.gallery.aircraft import aircraft_plant as aircraft_plant
from .plants.gallery.aircraft import aircraft_transition as aircraft_transition
from .plants.gallery.boost_converter import BoostConverter as BoostConverter
from .plants.gallery.cart_pendulum import CartPendulum as CartPendulum
from .plants.gallery.continuous import ContinuousPlant as ContinuousPlant
from .plants.gallery.limited_margins import limited_delay_margin as limited_delay_margin
from .plants.gallery.limited_margins import no_guaranteed_margins as no_guaranteed_margins
from .plants.gallery.limited_margins import (
    no_guaranteed_margins_standard as no_guaranteed_margins_standard,
)
from .plants.gallery.mass_spring import MassSpringDamper as MassSpringDamper
from .plants.gallery.rohrs import critical_period as critical_period
from .plants.gallery.rohrs import rohrs_plant as rohrs_plant
from .plants.gallery.rohrs import sampling_zeros as sampling_zeros
from .plants.gallery.zeros import plant_zeros as plant_zeros
from .plants.gallery.zeros import zero_path as zero_path
from .plants.zero_order_hold import zero_order_hold as zero_order_hold
