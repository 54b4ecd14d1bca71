#pragma once

#include <nanobind/nanobind.h>

// levels, replay_updates and replay_ud_lanes.
void bind_updates(nanobind::module_& m);
