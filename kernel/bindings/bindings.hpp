// The parts of the module, one file each.
#pragma once

#include "bindings/numpy_arrays.hpp"

namespace rcac {
void bind_controller(nb::module_& m);
void bind_plants(nb::module_& m);
void bind_loop(nb::module_& m);
void bind_updates(nb::module_& m);
void bind_filters(nb::module_& m);
void bind_arx(nb::module_& m);
void bind_box_jenkins(nb::module_& m);
void bind_gaps(nb::module_& m);
void bind_refinement(nb::module_& m);
}  // namespace rcac
