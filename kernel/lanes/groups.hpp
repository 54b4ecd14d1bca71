// Which runs may share the lanes of one loop.
#pragma once

#include <algorithm>
#include <map>

#include "loop/batch.hpp"
#include "plants/linear_plant.hpp"
#include "updates/ud.hpp"

namespace rcac {

// Whether the run is of the common kind that simd/lanes/loop.inl.hpp does: one controller with the
// factorised update in the predictor form, nothing that acts on it while it runs, and a plant that
// is nothing but constant matrices. Where l_z > 1 the weights are constant too.
// It depends on the run's own settings alone, so that neither its company nor the step that it has
// reached decides which loop makes its rounding errors.
inline bool fits_lanes(Loop& loop) {
    if (loop.controllers().size() != 1 || !loop.actuator().is_ideal() ||
        loop.options().stop_where_unsupported)
        return false;
    const auto* plant = dynamic_cast<const LinearPlant*>(&loop.plant());
    if (!plant || !plant->is_constant()) return false;
    Controller& c = *loop.controllers().front();
    const ControllerPlan& plan = c.plan();
    const auto* ud = dynamic_cast<const UdUpdate*>(&c.update());
    if (!ud || ud->is_capped() || plan.filter_form || plan.reflect_poles ||
        c.frozen() || c.stopped() || c.supervisor().acts() || c.has_limits() ||
        plan.dither.is_on() || c.has_left_its_plan() || !plan.events.empty() || !plan.noise.empty() ||
        c.rows().penalises() || plan.normalization.function != Normalization::none ||
        !plan.bounds.low.empty() || !plan.fixed.past_e.empty() || plan.R_z.nu != 0.0 ||
        plan.R_u.nu != 0.0 || !plan.structure.derived.empty() || plan.forgetting.long_window > 0 ||
        plan.reset.every > 0 || plan.reset.trace_below > 0.0 || plan.reset.growth > 0.0 ||
        plan.k_filter > 0 || plan.targets.size() > 1)
        return false;
    if (c.l_z() > 3 || plan.R_z.function || plan.R_u.function) return false;
    // A W that is not positive definite ends a run; that is the ordinary loop's business.
    std::vector<double> W(plan.R_z.base);
    for (std::size_t i = 0; i < W.size(); ++i) W[i] += plan.R_u.base[i];
    if (c.l_z() == 1)  // 1 / W must be a number
        return W[0] > 1e-100 && W[0] < 1e100 && plan.R_z.z_squared >= 0.0 &&
               plan.R_u.z_squared >= 0.0;
    return plan.R_z.is_constant() && plan.R_u.is_constant() && cholesky(W.data(), c.l_z());
}

inline bool is_recursive(const TargetModel& target) {
    for (std::size_t i = target.l_z * target.l_z; i < target.denominator.size(); ++i)
        if (target.denominator[i] != 0.0) return true;
    return false;
}

// What the lanes of one loop have in common, as numbers.
inline std::vector<std::int64_t> lane_key(Loop& loop) {
    const Controller& c = *loop.controllers().front();
    const ControllerPlan& plan = c.plan();
    const Structure& s = plan.structure;
    const Sizes& size = loop.plant().sizes();
    std::vector<std::int64_t> key;
    key.reserve(16 + 2 * (2 * s.regressor.size() + s.channels.size()));
    key.push_back(std::max<std::int64_t>(plan.k_w - c.step(), 0));
    key.push_back(std::max<std::int64_t>(plan.k_update - c.step(), 0));
    const std::size_t r_in_w = s.l_r > 0 ? loop.options().r_in_w : 0;
    for (std::size_t number : {loop.plant().x().size(), size.l_u, size.l_y, size.l_z, size.l_w,
                               s.l_r, r_in_w, plan.targets.front().order, s.regressor.size(),
                               s.channels.size()})
        key.push_back(static_cast<std::int64_t>(number));
    // A lane that needs none of these would add zeros because another one does, and a number beyond
    // 1e308 does not survive that.
    key.push_back(is_recursive(plan.targets.front()));
    key.push_back(!plan.R_z.is_constant() || !plan.R_u.is_constant());
    key.push_back(c.lambda() != 1.0);
    key.push_back(plan.bounds.are_there());
    for (const std::vector<Tap>* taps : {&s.regressor, &s.channels, &s.filtered})
        for (const Tap& tap : *taps) {
            key.push_back(static_cast<std::int64_t>(tap.source));
            key.push_back(static_cast<std::int64_t>(tap.delay));
        }
    return key;
}

struct LaneGroups {
    std::vector<std::vector<Job*>> in_lanes;  // up to eight runs each, one of them included
    std::vector<Job*> others;                 // for the ordinary loop

    // Whether on the average half of the lanes are taken.
    bool are_full() const {
        std::size_t taken = 0;
        for (const std::vector<Job*>& group : in_lanes) taken += group.size();
        return 2 * taken >= lanes * in_lanes.size();
    }
};

// Longest runs first, so that the lanes of a group end together.
inline LaneGroups lane_groups(const std::vector<Job*>& jobs) {
    std::map<std::vector<std::int64_t>, std::vector<Job*>> alike;
    LaneGroups groups;
    for (Job* job : jobs)
        if (fits_lanes(*job->loop))
            alike[lane_key(*job->loop)].push_back(job);
        else
            groups.others.push_back(job);
    for (auto& [key, same] : alike) {
        std::stable_sort(same.begin(), same.end(), [](const Job* a, const Job* b) {
            return a->steps - a->done > b->steps - b->done;
        });
        for (std::size_t i = 0; i < same.size(); i += lanes) {
            const std::size_t end = std::min(same.size(), i + lanes);
            groups.in_lanes.emplace_back(same.data() + i, same.data() + end);
        }
    }
    return groups;
}

}  // namespace rcac
