// A controller as Python sees it.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <limits>

#include "bindings/bindings.hpp"
#include "controller/controller.hpp"
#include "updates/covariance.hpp"
#include "updates/memoryless.hpp"
#include "updates/window.hpp"

namespace rcac {
namespace {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

std::vector<Tap> taps(const Pairs& pairs) {
    std::vector<Tap> result;
    for (const auto& [source, delay] : pairs) result.push_back({source, delay});
    return result;
}

// A matrix, or a table {"base", "z_squared"}, or a function R(k, y, z, u) that returns None where
// it failed; then the update meets a NaN and the run ends.
Weight weight(nb::handle value, std::size_t l_y, std::size_t l_z, std::size_t l_u, const char* name) {
    Weight result;
    result.base.assign(l_z * l_z, 0.0);
    if (nb::isinstance<nb::tuple>(value)) {
        auto [base, z_squared] = nb::cast<std::pair<Array, double>>(value);
        result.base = copied(base, l_z * l_z, name);
        result.z_squared = z_squared;
    } else if (PyCallable_Check(value.ptr())) {
        nb::object function = nb::borrow(value);
        result.function = [function, l_y, l_z, l_u, name](std::int64_t k, const double* y,
                                                          const double* z, const double* u,
                                                          double* matrix) {
            nb::gil_scoped_acquire gil;
            nb::object answer = function(k, to_numpy(y, l_y), to_numpy(z, l_z), to_numpy(u, l_u));
            if (answer.is_none()) {
                std::fill_n(matrix, l_z * l_z, std::numeric_limits<double>::quiet_NaN());
                return;
            }
            const std::vector<double> values = copied(nb::cast<Array>(answer), l_z * l_z, name);
            std::copy(values.begin(), values.end(), matrix);
        };
    } else {
        result.base = copied(nb::cast<Array>(value), l_z * l_z, name);
    }
    return result;
}

std::vector<Event> events(const nb::list& list) {
    static const std::vector<std::string> kinds{"freeze", "resume", "reset", "forgetting", "target"};
    std::vector<Event> result;
    for (nb::handle item : list) {
        auto [step, name, value] = nb::cast<std::tuple<std::int64_t, std::string, double>>(item);
        const auto kind = std::find(kinds.begin(), kinds.end(), name);
        if (kind == kinds.end()) throw std::invalid_argument("no event named " + name);
        result.push_back({step, static_cast<Event::Kind>(kind - kinds.begin()), value,
                          static_cast<std::size_t>(value > 0.0 ? value : 0.0)});
    }
    return result;
}

Controller make_controller(std::size_t l_u, std::size_t l_y, std::size_t l_r, std::size_t l_z,
                           const nb::list& derived, const Pairs& regressor, const Pairs& channels,
                           const Pairs& filtered, const nb::list& targets, nb::object R_z,
                           nb::object R_u, double lambda, std::int64_t k_w, std::int64_t k_update,
                           std::int64_t k_filter, bool filter_form, bool reflect_poles,
                           const nb::list& event_list, const std::tuple<std::size_t, std::size_t, double, double>& forgetting,
                           const std::tuple<std::int64_t, double, double, std::size_t, std::size_t>& reset,
                           const Array& noise, const std::string& update, const Array& P_0,
                           const Array& theta_0, std::size_t window, double step_size) {
    const std::size_t l_theta = regressor.size() * l_u;
    ControllerPlan plan;
    plan.structure = {l_u, l_y, l_r, {}, taps(regressor), taps(channels), taps(filtered)};
    for (nb::handle item : derived) {
        auto [now, before, pole] = nb::cast<std::tuple<Array, Array, double>>(item);
        plan.structure.derived.push_back(
            {copied(now, l_y + l_r, "now"), copied(before, l_y + l_r, "before"), pole});
    }
    for (const Tap& tap : plan.structure.regressor)
        if (tap.source >= plan.structure.signals()) throw std::invalid_argument("no such signal");
    for (const Tap& tap : plan.structure.channels)
        if (tap.source >= plan.structure.signals()) throw std::invalid_argument("no such signal");
    for (const Tap& tap : plan.structure.filtered)
        if (tap.source >= channels.size()) throw std::invalid_argument("no such channel");
    require(filtered.size(), regressor.size(), "filtered");
    std::size_t order = 0;
    for (nb::handle item : targets) {
        auto [numerator, denominator] = nb::cast<std::pair<Array, Array>>(item);
        if (plan.targets.empty()) order = numerator.size() / (l_z * l_u) - 1;
        plan.targets.push_back({l_z, l_u, order,
                                copied(numerator, (order + 1) * l_z * l_u, "numerator"),
                                copied(denominator, (order + 1) * l_z * l_z, "denominator")});
    }
    plan.R_z = weight(R_z, l_y, l_z, l_u, "R_z");
    plan.R_u = weight(R_u, l_y, l_z, l_u, "R_u");
    plan.lambda = lambda;
    plan.k_w = k_w;
    plan.k_update = k_update;
    plan.k_filter = k_filter;
    plan.filter_form = filter_form;
    plan.reflect_poles = reflect_poles;
    plan.events = events(event_list);
    for (const Event& event : plan.events)
        if (event.kind == Event::target && event.index >= plan.targets.size())
            throw std::invalid_argument("no such target model");
    plan.forgetting = {std::get<0>(forgetting), std::get<1>(forgetting), std::get<2>(forgetting),
                       std::get<3>(forgetting)};
    plan.reset = {std::get<0>(reset), std::get<1>(reset), std::get<2>(reset), std::get<3>(reset),
                  std::get<4>(reset)};
    plan.noise = copied(noise, noise.size() / std::max<std::size_t>(l_theta, 1) * l_theta, "noise");

    std::vector<double> theta = copied(theta_0, l_theta, "theta_0");
    const std::vector<double> P = copied(P_0, l_theta * l_theta, "P_0");
    std::unique_ptr<Update> arithmetic;
    if (update == "ud")
        arithmetic = std::make_unique<UdUpdate>(P.data(), l_theta);
    else if (update == "covariance")
        arithmetic = std::make_unique<CovarianceUpdate>(P.data(), l_theta);
    else if (update == "sliding window")
        arithmetic = std::make_unique<WindowUpdate>(P.data(), theta.data(), l_theta, l_z, window);
    else if (update == "instantaneous")
        arithmetic = std::make_unique<InstantaneousUpdate>(P.data(), l_theta);
    else if (update == "gradient")
        arithmetic = std::make_unique<GradientUpdate>(step_size, l_theta);
    else
        throw std::invalid_argument("no update named " + update);
    return Controller(std::move(plan), std::move(arithmetic), std::move(theta));
}

// u(k), and whether the update stayed in the range of float64.
std::pair<nb::ndarray<nb::numpy, double>, bool> step(Controller& controller, const Array& y,
                                                     const Array& z, const Array& r,
                                                     const Array& u_applied) {
    require(y.size(), controller.structure().l_y, "y");
    require(r.size(), controller.structure().l_r, "r");
    require(z.size(), controller.l_z(), "z");
    if (u_applied.size() > 0) require(u_applied.size(), controller.l_u(), "u_applied");
    controller.begin();
    if (u_applied.size() > 0) controller.correct_previous(u_applied.data());
    controller.measure(y.data(), r.data());
    bool done = true;
    if (controller.filter_form()) done = controller.adapt(z.data());
    std::vector<double> u(controller.l_u());
    std::copy_n(controller.control(), u.size(), u.begin());
    if (!controller.adapted()) done = controller.adapt(z.data());
    controller.finish();
    const std::size_t size = u.size();
    return {to_numpy(std::move(u), {size}), done};
}

}  // namespace

void bind_controller(nb::module_& m) {
    nb::class_<Controller>(m, "Controller")
        .def("step", &step, nb::arg("y"), nb::arg("z"), nb::arg("r"), nb::arg("u_applied"))
        .def("freeze", [](Controller& self, bool frozen) { self.set_frozen(frozen); })
        .def("reset_covariance", &Controller::reset_covariance)
        .def("save",
             [](Controller& self) {
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore",
             [](Controller& self, const Array& state) {
                 Archive archive(copied(state, state.size(), "state"));
                 self.visit(archive);
                 archive.finish();
             })
        .def_prop_ro("theta",
                     [](const Controller& self) {
                         return to_numpy(self.theta().data(), self.theta().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("P",
                     [](const Controller& self) {
                         const std::size_t n = self.theta().size();
                         std::vector<double> P(n * n);
                         self.update().covariance(P.data());
                         return to_numpy(std::move(P), {n, n});
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("k", &Controller::step)
        .def_prop_ro("forgetting_factor", &Controller::lambda)
        .def_prop_ro("reflections", &Controller::reflections)
        .def_prop_ro("resets", &Controller::resets)
        .def_prop_ro("guard_count",
                     [](const Controller& self) { return self.update().guard().count; })
        .def_prop_ro("guard_first_step",
                     [](const Controller& self) { return self.update().guard().first_step; });
    m.def("controller", &make_controller, nb::kw_only(), nb::arg("l_u"), nb::arg("l_y"),
          nb::arg("l_r"), nb::arg("l_z"), nb::arg("derived"), nb::arg("regressor"),
          nb::arg("channels"), nb::arg("filtered"), nb::arg("targets"), nb::arg("R_z"),
          nb::arg("R_u"), nb::arg("forgetting_factor"), nb::arg("k_w"), nb::arg("k_update"),
          nb::arg("k_filter"), nb::arg("filter_form"), nb::arg("reflect_poles"), nb::arg("events"),
          nb::arg("forgetting"), nb::arg("reset"), nb::arg("noise"), nb::arg("update"),
          nb::arg("P_0"), nb::arg("theta_0"), nb::arg("window"), nb::arg("step_size"));
}

}  // namespace rcac
