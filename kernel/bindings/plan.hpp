// A controller's plan from what Python gives, checked.
#pragma once

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bindings/numpy_arrays.hpp"
#include "controller/stored_signals.hpp"

namespace rcac {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

inline std::vector<Tap> taps_of(const Pairs& pairs, std::size_t sources, const char* name) {
    std::vector<Tap> result;
    for (const auto& [source, delay] : pairs) {
        refuse_unless(source < sources, std::string(name) + ": signal " + std::to_string(source) +
                                            " of " + std::to_string(sources));
        length_of({delay, 2}, name);
        result.push_back({source, delay});
    }
    return result;
}

// The tables of taps. Channel i < l_u of the filter is u_i(k), which every update reads.
inline Structure structure_of(std::size_t l_u, std::size_t l_y, std::size_t l_r,
                              const nb::list& derived, const Pairs& regressor,
                              const Pairs& channels, const Pairs& filtered) {
    require_width(l_u, 1, "l_u");
    require_width(l_y, 0, "l_y");
    require_width(l_r, 0, "l_r");
    Structure result{l_u, l_y, l_r, {}, {}, {}, {}};
    for (nb::handle item : derived) {
        const auto [now, before, pole, limit] = read<std::tuple<Array, Array, double, double>>(
            item, "a derived signal", "(now, before, pole, limit)");
        refuse_unless(limit >= 0.0, "the limit of a derived signal is negative");
        result.derived.push_back(
            {copied(now, l_y + l_r, "now"), copied(before, l_y + l_r, "before"), pole, limit});
    }
    refuse_unless(!regressor.empty(), "the regressor is empty");
    require(filtered.size(), regressor.size(), "filtered");
    result.regressor = taps_of(regressor, result.signals(), "regressor");
    result.channels = taps_of(channels, result.signals(), "channels");
    result.filtered = taps_of(filtered, channels.size(), "filtered");
    for (std::size_t i = 0; i < l_u; ++i)
        refuse_unless(i < channels.size() && channels[i] == Pairs::value_type(i, 0),
                      "channel " + std::to_string(i) + " is not that entry of u(k)");
    const std::size_t delay =
        std::max(longest_delay(result.regressor), longest_delay(result.channels));
    length_of({result.signals(), 2 * (delay + remembered_steps) + 64}, "the history of the signals");
    return result;
}

inline std::vector<TargetModel> targets_of(const nb::list& list, const Structure& structure,
                                           std::size_t l_z) {
    const std::size_t l_u = structure.l_u, block = length_of({l_z, l_u}, "a target model");
    std::vector<TargetModel> result;
    for (nb::handle item : list) {
        const auto [numerator, denominator] =
            read<std::pair<Array, Array>>(item, "a target model", "(numerator, denominator)");
        if (result.empty())
            refuse_unless(numerator.size() >= block, "numerator: a target model has no coefficient");
        const std::size_t order = result.empty() ? numerator.size() / block - 1 : result[0].order;
        result.push_back({l_z, l_u, order,
                          copied(numerator, length_of({order + 1, block}, "numerator"), "numerator"),
                          copied(denominator, length_of({order + 1, l_z, l_z}, "denominator"),
                                 "denominator")});
    }
    refuse_unless(!result.empty(), "a controller has no target model");
    const std::size_t delay = std::max(result[0].order, longest_delay(structure.filtered));
    length_of({structure.channels.size(), block, 2 * (delay + remembered_steps) + 64},
              "the filtered signals");
    length_of({structure.signals(), 2 * (delay + remembered_steps) + 64}, "the stored signals");
    length_of({structure.regressor.size(), l_u, l_z}, "the filtered regressor");
    return result;
}

// A target model of any order that is set while the controller runs.
inline TargetModel target_of(const Array& numerator, const Array& denominator, std::size_t l_z,
                             std::size_t l_u, std::size_t longest_order) {
    const std::size_t block = length_of({l_z, l_u}, "a target model");
    refuse_unless(numerator.size() >= block && numerator.size() % block == 0,
                  "numerator: no whole number of l_z x l_u coefficients");
    const std::size_t order = numerator.size() / block - 1;
    require_range<std::size_t>(order, 0, longest_order, "the order of the target model");
    return {l_z, l_u, order, copied(numerator, numerator.size(), "numerator"),
            copied(denominator, length_of({order + 1, l_z, l_z}, "denominator"), "denominator")};
}

inline Past past_of(const std::string& name) {
    static const std::vector<std::string> names{"keep", "reset", "blend", "replay"};
    const auto found = std::find(names.begin(), names.end(), name);
    refuse_unless(found != names.end(), "P cannot " + name.substr(0, 200));
    return static_cast<Past>(found - names.begin());
}

// A matrix, or (base, z_squared, nu), or a function R(k, y, z, u) that returns None where it failed;
// then the update meets a NaN and the run ends.
inline Weight weight_of(nb::handle value, const Structure& structure, std::size_t l_z,
                        const char* name) {
    const std::size_t l_y = structure.l_y, l_u = structure.l_u, size = length_of({l_z, l_z}, name);
    Weight result;
    result.base.assign(size, 0.0);
    if (nb::isinstance<nb::tuple>(value)) {
        const auto [base, z_squared, nu] = read<std::tuple<Array, double, double>>(
            value, name, "(matrix, factor of z'z, nu)");
        result.base = copied(base, size, name);
        result.z_squared = z_squared;
        result.nu = nu;
    } else if (PyCallable_Check(value.ptr())) {
        nb::object function = nb::borrow(value);
        result.function = [=](std::int64_t k, const double* y, const double* z, const double* u,
                              double* matrix) {
            nb::gil_scoped_acquire gil;
            nb::object answer = function(k, to_numpy(y, l_y), to_numpy(z, l_z), to_numpy(u, l_u));
            if (answer.is_none()) {
                std::fill_n(matrix, size, std::numeric_limits<double>::quiet_NaN());
                return;
            }
            const std::vector<double> values =
                copied(read<Array>(answer, name, "an array"), size, name);
            std::copy(values.begin(), values.end(), matrix);
        };
    } else {
        result.base = copied(read<Array>(value, name, "a matrix, a pair or a function"), size, name);
    }
    return result;
}

inline std::vector<Event> events_of(const nb::list& list, std::size_t targets) {
    static const std::vector<std::string> kinds{"freeze", "resume", "reset", "forgetting", "target"};
    std::vector<Event> result;
    for (nb::handle item : list) {
        const auto [step, name, value] = read<std::tuple<std::int64_t, std::string, double>>(
            item, "an event", "(step, kind, value)");
        const auto kind = std::find(kinds.begin(), kinds.end(), name);
        refuse_unless(kind != kinds.end(), "no event named " + name.substr(0, 200));
        require_step(step, "the step of an event");
        refuse_unless(result.empty() || step >= result.back().step, "the events are not in order");
        Event event{step, static_cast<Event::Kind>(kind - kinds.begin()), value, 0};
        if (event.kind == Event::forgetting) require_forgetting(value, "lambda");
        if (event.kind == Event::target) {
            refuse_unless(value >= 0.0 && value < static_cast<double>(targets) &&
                              value == std::floor(value),
                          "no such target model");
            event.index = static_cast<std::size_t>(value);
        }
        result.push_back(event);
    }
    return result;
}

// A square matrix; of zeros where nothing is given.
inline std::vector<double> square_or_zero(const Array& values, std::size_t size, const char* name) {
    const std::size_t length = length_of({size, size}, name);
    return values.size() == 0 ? std::vector<double>(length) : copied(values, length, name);
}

// P(0), l_theta x l_theta, or its diagonal.
inline std::vector<double> covariance_of(const Array& P_0, std::size_t l_theta) {
    const std::size_t length = length_of({l_theta, l_theta}, "P_0");
    if (P_0.size() != l_theta) return copied(P_0, length, "P_0");
    std::vector<double> P(length, 0.0);
    for (std::size_t j = 0; j < l_theta; ++j) P[j * (l_theta + 1)] = P_0.data()[j];
    return P;
}

inline Normalization normalization_of(int function, double limit, double slope) {
    require_range<int>(function, Normalization::none, Normalization::erf, "the normalisation");
    refuse_unless(limit > 0.0 && slope > 0.0, "limit and slope of a normalisation are not positive");
    return {static_cast<Normalization::Function>(function), limit, slope};
}

inline BoundsPlan bounds_of(const nb::tuple& given, std::size_t l_theta) {
    const auto [low, high, in_metric, sweeps] = read<std::tuple<Array, Array, bool, std::size_t>>(
        given, "bounds", "(low, high, in_metric, sweeps)");
    if (low.size() == 0 && high.size() == 0) return {};
    BoundsPlan plan{copied(low, l_theta, "low"), copied(high, l_theta, "high"), in_metric, sweeps,
                    {}};
    for (std::size_t i = 0; i < l_theta; ++i)
        refuse_unless(plan.low[i] <= plan.high[i], "a low bound exceeds the high one");
    require_range<std::size_t>(sweeps, 0, 1000000, "sweeps");
    if (in_metric) length_of({l_theta, l_theta}, "P");
    return plan;
}

// (center, inverse of the factor, in_metric, limit, aim), or nothing in them.
inline EllipsoidPlan ellipsoid_of(const nb::tuple& given, std::size_t l_theta,
                                  const InstructionSet& instructions) {
    const auto [center, inverse, in_metric, limit, aim] =
        read<std::tuple<Array, Array, bool, double, double>>(
            given, "ellipsoid", "(center, inverse, in_metric, limit, aim)");
    if (center.size() == 0 && inverse.size() == 0) return {};
    const std::size_t n = l_theta;
    EllipsoidPlan plan{copied(center, n, "center"),
                       copied(inverse, length_of({n, n}, "inverse"), "inverse"), in_metric, limit,
                       aim, &instructions};
    refuse_unless(limit > 0.5 && limit < 1.0 && aim > 0.5 && aim <= limit,
                  "limit and aim of an ellipsoid");
    refuse_unless(finite(plan.center.data(), n) && finite(plan.inverse.data(), n * n),
                  "an ellipsoid is not finite");
    for (std::size_t i = 0; i < n; ++i)
        refuse_unless(plan.inverse[i * n + i] > 0.0, "the diagonal of a factor is not positive");
    return plan;
}

inline FixedPlan fixed_of(const nb::tuple& given, std::size_t l_v, std::size_t l_e) {
    const auto [past_v, past_e] =
        read<std::pair<Array, Array>>(given, "fixed", "(past_u, past_y)");
    const std::size_t block = length_of({l_v, l_e}, "past_y");
    if (past_e.size() == 0 && past_v.size() == 0) return {};
    refuse_unless(block > 0 && past_e.size() >= block && past_e.size() % block == 0,
                  "past_y: no whole number of l_u x (l_y + l_r) coefficients");
    const std::size_t order = past_e.size() / block - 1;
    length_of({l_v + l_e, 2 * order + 64}, "the past of the fixed part");
    return {order, copied(past_v, length_of({order, l_v, l_v}, "past_u"), "past_u"),
            copied(past_e, past_e.size(), "past_y")};
}

// (policy, growth, limit, jump, patience, fade, past_u, past_y, fallback_where_missed).
using Supervision =
    std::tuple<int, double, double, double, std::int64_t, double, Array, Array, bool>;
inline SupervisionPlan supervision_of(nb::handle given, std::size_t l_u, std::size_t l_e) {
    if (given.is_none()) return {};
    const auto [policy, growth, limit, jump, patience, fade, past_u, past_y, where_missed] =
        read<Supervision>(given, "supervision", "nine entries");
    require_range<int>(policy, SupervisionPlan::off, SupervisionPlan::fallback, "the policy");
    refuse_unless(growth > 0.0 && limit > 0.0 && jump >= 0.0, "a bound of the supervision");
    refuse_unless(fade >= 0.0 && fade < 1.0, "fade is not in [0, 1)");
    require_range<std::int64_t>(patience, 1, most_steps, "patience");
    SupervisionPlan plan;
    plan.policy = static_cast<SupervisionPlan::Policy>(policy);
    plan.growth = growth, plan.limit = limit, plan.jump = jump, plan.patience = patience;
    plan.fade = fade;
    plan.fallback_plan = fixed_of(nb::make_tuple(past_u, past_y), l_u, l_e);
    plan.fallback_where_missed = where_missed;
    refuse_unless(!plan.fallback_plan.past_e.empty() ||
                      (plan.policy != SupervisionPlan::fallback && !where_missed),
                  "there is no fallback");
    return plan;
}

// (low, high, rise, fall) of u, or four empty arrays.
inline void read_limits(const nb::tuple& given, std::size_t l_u, ControllerPlan& plan) {
    const auto [low, high, rise, fall] = read<std::tuple<Array, Array, Array, Array>>(
        given, "limits", "(low, high, rise, fall)");
    if (low.size() == 0) return;
    plan.low = copied(low, l_u, "low"), plan.high = copied(high, l_u, "high");
    plan.rise = copied(rise, l_u, "rise"), plan.fall = copied(fall, l_u, "fall");
    for (std::size_t i = 0; i < l_u; ++i) {
        refuse_unless(plan.low[i] <= plan.high[i], "a low limit exceeds the high one");
        refuse_unless(plan.rise[i] > 0.0 && plan.fall[i] > 0.0, "a rate is not positive");
    }
}

// The roots of D_c are those of q^n - theta_1 q^(n-1) - ...: one u, and no u(k) among its taps.
inline void require_reflectable(const Structure& structure) {
    refuse_unless(structure.l_u == 1, "poles are reflected for l_u = 1 only");
    for (const Tap& tap : structure.regressor)
        refuse_unless(tap.source != 0 || tap.delay > 0, "u(k) is in its own regressor");
}

}  // namespace rcac
