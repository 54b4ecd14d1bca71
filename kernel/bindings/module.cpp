// The compiled module.
#include "bindings/bindings.hpp"

NB_MODULE(_kernel, m) {
    nb::set_leak_warnings(false);  // objects alive at interpreter exit are not leaks
    rcac::bind_controller(m);
    rcac::bind_plants(m);
    rcac::bind_loop(m);
    rcac::bind_updates(m);
    rcac::bind_filters(m);
    rcac::bind_arx(m);
    rcac::bind_box_jenkins(m);
    rcac::bind_gaps(m);
    rcac::bind_refinement(m);
}
