// Everything that determines a controller, beside theta(0) and the arithmetic of its update.
#pragma once

#include <limits>

#include "controller/adaptation_rules.hpp"
#include "controller/coefficient_bounds.hpp"
#include "controller/fixed_part.hpp"
#include "controller/performance_rules.hpp"
#include "controller/supervisor.hpp"
#include "controller/target_filter.hpp"

namespace rcac {

// s(k) = pole s(k-1) + now [y; r](k) + before [y; r](k-1), held within +-limit
struct DerivedSignal {
    std::vector<double> now, before;
    double pole;
    double limit = std::numeric_limits<double>::infinity();
};

// The structure of a controller is nothing but tables of taps on scalar signals, numbered
// u, y, r, derived signals.
struct Structure {
    std::size_t l_u, l_y, l_r;
    std::vector<DerivedSignal> derived;
    std::vector<Tap> regressor;  // phi(k), and Phi(k) = phi(k)' (x) I as in (2.30)
    std::vector<Tap> channels;   // what the target-model filter is fed with; u(k) comes first
    std::vector<Tap> filtered;   // phi_f: (channel, delay) for every entry of phi

    std::size_t signals() const { return l_u + l_y + l_r + derived.size(); }
};

struct ControllerPlan {
    Structure structure;
    std::vector<TargetModel> targets;  // of one order; the first one is there from step 0
    Weight R_z, R_u;
    Weight penalty;  // S, l_u x l_u, with S' S = R_u_unfiltered
    bool keeps_rows = false;  // the update has room for the rows of this plan alone
    Normalization normalization;
    BoundsPlan bounds;
    FixedPlan fixed;
    double lambda;
    std::int64_t k_w;       // u = 0 before it (2.29)
    std::int64_t k_update;  // first step of the update
    std::int64_t k_filter;  // the target-model filter sees zero before it
    bool filter_form;       // update before control, (2.47)-(2.48)
    bool reflect_poles;
    std::vector<Event> events;  // by step
    ForgettingRule forgetting;
    ResetRule reset;
    Dither dither;
    SupervisionPlan supervision;
    std::vector<double> low, high, rise, fall;  // of u, where the controller keeps to limits
    std::vector<double> noise;  // rows a with Q = sum a a', (2.46)
};

}  // namespace rcac
