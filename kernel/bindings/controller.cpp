// A controller as Python sees it.
#include <nanobind/stl/unique_ptr.h>

#include "bindings/bindings.hpp"
#include "bindings/owned.hpp"
#include "bindings/plan.hpp"
#include "bindings/quick_read.hpp"
#include "updates/covariance.hpp"
#include "updates/joint.hpp"
#include "updates/memoryless.hpp"
#include "updates/subspace.hpp"
#include "updates/window.hpp"

namespace rcac {
namespace {

using Forgetting = std::tuple<std::size_t, std::size_t, double, double>;
using Perturbation = std::tuple<std::uint64_t, double, double, std::int64_t>;
using Curve = std::tuple<int, double, double>;
using Reset = std::tuple<std::int64_t, double, double, std::size_t, std::size_t>;

void require_window(std::size_t steps, const char* name) {
    require_range<std::size_t>(steps, 0, most_numbers, name);
}

std::unique_ptr<Update> update_of(const std::string& name, const std::vector<double>& P,
                                  const std::vector<double>& theta, std::size_t l_z,
                                  std::size_t window, double step_size,
                                  const InstructionSet& instructions) {
    const std::size_t l_theta = theta.size();
    if (name == "ud") return std::make_unique<UdUpdate>(P.data(), l_theta, instructions);
    if (name == "ud, capped") {
        auto made = std::make_unique<UdUpdate>(P.data(), l_theta, instructions);
        made->cap();
        return made;
    }
    if (name == "ud, subspace") return std::make_unique<SubspaceUpdate>(P.data(), l_theta);
    if (name == "covariance") return std::make_unique<CovarianceUpdate>(P.data(), l_theta);
    if (name == "sliding window") {
        require_range<std::size_t>(window, 1, most_numbers, "window");
        length_of({window, (l_theta + 1) * l_z + 2 * l_z * l_z}, "the window");
        return std::make_unique<WindowUpdate>(P.data(), theta.data(), l_theta, l_z, window);
    }
    if (name == "joint") {  // with n_d in the place of the window and rho in that of the step size
        refuse_unless(l_z == 1, "the joint fit is for l_z = 1");
        refuse_unless(step_size > 0.0 || window == 0, "rho must be positive");
        require_range<std::size_t>(window, 0, 1000, "n_d");
        length_of({l_theta + window, l_theta + window}, "P");
        return std::make_unique<JointUpdate>(P.data(), l_theta, window, step_size);
    }
    if (name == "instantaneous") return std::make_unique<InstantaneousUpdate>(P.data(), l_theta);
    if (name == "gradient") return std::make_unique<GradientUpdate>(step_size, l_theta);
    throw std::invalid_argument("no update named " + name.substr(0, 200));
}

std::unique_ptr<OwnedController> make_controller(
    std::size_t l_u, std::size_t l_y, std::size_t l_r, std::size_t l_z, const nb::list& derived,
    const Pairs& regressor, const Pairs& channels, const Pairs& filtered, const nb::list& targets,
    nb::object R_z, nb::object R_u, double lambda, std::int64_t k_w, std::int64_t k_update,
    std::int64_t k_filter, bool filter_form, bool reflect_poles, const nb::list& events,
    const Forgetting& forgetting, const Reset& reset, const Array& noise, const std::string& update,
    const Array& P_0, const Array& theta_0, std::size_t window, double step_size,
    const Perturbation& dither, const Array& penalty, const Curve& normalization,
    const nb::tuple& bounds, const nb::tuple& ellipsoid, const nb::tuple& fixed,
    nb::object supervision, const nb::tuple& limits, const std::string& instructions) {
    ControllerPlan plan;
    require_width(l_z, 1, "l_z");
    plan.structure = structure_of(l_u, l_y, l_r, derived, regressor, channels, filtered);
    plan.targets = targets_of(targets, plan.structure, l_z);
    plan.R_z = weight_of(R_z, plan.structure, l_z, "R_z");
    plan.R_u = weight_of(R_u, plan.structure, l_z, "R_u");
    plan.penalty.base = square_or_zero(penalty, l_u, "penalty");
    plan.keeps_rows = update == "sliding window" || update == "joint";
    plan.normalization = normalization_of(std::get<0>(normalization), std::get<1>(normalization),
                                          std::get<2>(normalization));
    plan.fixed = fixed_of(fixed, l_u, l_y + l_r);
    plan.supervision = supervision_of(supervision, l_u, l_y + l_r);
    read_limits(limits, l_u, plan);
    require_forgetting(lambda, "lambda");
    plan.lambda = lambda;
    require_step(k_w, "k_w");
    require_step(k_update, "k_update");
    require_step(k_filter, "k_filter");
    plan.k_w = k_w;
    plan.k_update = k_update;
    plan.k_filter = k_filter;
    plan.filter_form = filter_form;
    plan.reflect_poles = reflect_poles;
    if (reflect_poles) require_reflectable(plan.structure);
    plan.events = events_of(events, plan.targets.size());
    plan.forgetting = {std::get<0>(forgetting), std::get<1>(forgetting), std::get<2>(forgetting),
                       std::get<3>(forgetting)};
    plan.reset = {std::get<0>(reset), std::get<1>(reset), std::get<2>(reset), std::get<3>(reset),
                  std::get<4>(reset)};
    for (std::size_t steps : {plan.forgetting.short_window, plan.forgetting.long_window,
                              plan.reset.short_window, plan.reset.long_window})
        require_window(steps, "the window of a rule");
    plan.dither = {std::get<0>(dither), std::get<1>(dither), std::get<2>(dither),
                   std::get<3>(dither)};
    const std::size_t l_theta = regressor.size() * l_u;
    const std::vector<double> P = covariance_of(P_0, l_theta);
    plan.bounds = bounds_of(bounds, l_theta);
    const InstructionSet& set = instruction_set(instructions.c_str());
    plan.bounds.ellipsoid = ellipsoid_of(ellipsoid, l_theta, set);
    refuse_unless(plan.bounds.low.empty() || plan.bounds.ellipsoid.center.empty(),
                  "bounds are a box or an ellipsoid");
    plan.noise = copied(noise, noise.size() / l_theta * l_theta, "noise");

    std::vector<double> theta = copied(theta_0, l_theta, "theta_0");
    bool penalises = false;
    for (const double s : plan.penalty.base) penalises = penalises || s != 0.0;
    const std::size_t rows = penalises ? l_z + l_u : l_z;
    std::unique_ptr<Update> arithmetic = update_of(update, P, theta, rows, window, step_size,
                                                  set);
    return std::make_unique<OwnedController>(std::move(plan), std::move(arithmetic),
                                             std::move(theta));
}

// u(k), and 0 where a number left the range of float64, 1 where nothing new is to be said, 2 where
// the supervisor has something to say; None where an argument is not of the right size, or not to be
// read at once, or not a number where nobody supervises, and the controller has not moved.
nb::object step(OwnedController& owned, nb::handle y_k, nb::handle z_k, nb::handle r_k,
                nb::handle u_applied) {
    Controller& controller = owned.controller;
    std::vector<double> y(controller.structure().l_y), z(controller.l_z()),
        r(controller.structure().l_r), applied(u_applied.is_none() ? 0 : controller.l_u());
    const bool gaps = controller.supervisor().is_on();
    if (!quick_read(y_k, y, gaps) || !quick_read(z_k, z, gaps) || !quick_read(r_k, r, gaps) ||
        !quick_read(u_applied, applied))
        return nb::none();
    const Hold hold(owned.use);
    const std::int64_t noted = controller.supervisor().noted();
    const bool done = controller.step(y.data(), z.data(), r.data(),
                                      applied.empty() ? nullptr : applied.data());
    std::vector<double> u(controller.u());
    const std::size_t size = u.size();
    const int status = !done || !finite(u.data(), size)             ? 0
                       : controller.supervisor().noted() == noted ? 1
                                                                  : 2;
    return nb::make_tuple(to_numpy(std::move(u), {size}), status);
}

// Counts by kind, (steps, episodes, first, last, worst), none where nothing was noted; the last entries, (step, kind, value); the
// largest growth of a variance; whether theta is held, and whether the fallback runs; the largest share
// of the radius of an ellipsoid.
nb::tuple troubles(const OwnedController& owned) {
    const Supervisor& supervisor = owned.controller.supervisor();
    nb::list counts, entries;
    const bool is_new = supervisor.noted() > 0;  // else a list of zeros would be made of every run
    for (const Supervisor::Count& c : supervisor.counts())
        if (is_new) counts.append(nb::make_tuple(c.steps, c.episodes, c.first, c.last, c.worst));
    for (const Supervisor::Entry& e : supervisor.entries())
        entries.append(nb::make_tuple(e.step, e.kind, e.value));
    return nb::make_tuple(counts, entries, supervisor.worst_growth(), owned.controller.stopped(),
                          owned.controller.in_fallback(), supervisor.worst_radius());
}

// How far the filtered signals moved. The controller stays as it was where that is refused.
double set_target(OwnedController& owned, const Array& numerator, const Array& denominator,
                  const std::string& past) {
    Controller& controller = owned.controller;
    const TargetModel model = target_of(numerator, denominator, controller.l_z(),
                                        controller.l_u(), controller.longest_order());
    const Past option = past_of(past);
    const Hold hold(owned.use);
    Archive before;
    if (option == Past::replay) owned.visit(before);
    if (!controller.set_target(model, option)) {
        Archive back(before.values());
        owned.visit(back);
        throw std::overflow_error("the replay left the range of float64");
    }
    return controller.target().rho();
}

// None leaves a weight as it is.
void set_weights(OwnedController& owned, nb::object R_z, nb::object R_u, nb::object penalty) {
    Controller& controller = owned.controller;
    const auto read_weight = [&](const nb::object& value, const char* name) {
        refuse_unless(!PyCallable_Check(value.ptr()), std::string(name) + " is a function");
        return weight_of(value, controller.structure(), controller.l_z(), name);
    };
    const Weight z = R_z.is_none() ? Weight() : read_weight(R_z, "R_z");
    const Weight u = R_u.is_none() ? Weight() : read_weight(R_u, "R_u");
    Weight S;
    if (!penalty.is_none())
        S.base = copied(read<Array>(penalty, "penalty", "a matrix"),
                        controller.l_u() * controller.l_u(), "penalty");
    const Hold hold(owned.use);
    if (!penalty.is_none()) controller.rows().set_penalty(S);  // which may be refused
    if (!R_z.is_none()) controller.rows().set_R_z(z);
    if (!R_u.is_none()) controller.rows().set_R_u(u);
}

void set_lambda(OwnedController& owned, double lambda) {
    require_forgetting(lambda, "lambda");
    const Hold hold(owned.use);
    owned.controller.set_lambda(lambda);
}

}  // namespace

void bind_controller(nb::module_& m) {
    const auto number = [](auto of) {
        return [of](const OwnedController& self) { return of(self.controller); };
    };
    nb::class_<OwnedController>(m, "Controller")
        .def("step", &step, nb::arg("y").none(), nb::arg("z").none(), nb::arg("r").none(),
             nb::arg("u_applied").none())
        .def("freeze",
             [](OwnedController& self, bool frozen) {
                 const Hold hold(self.use);
                 self.controller.set_frozen(frozen);
             })
        .def("reset_covariance",
             [](OwnedController& self) {
                 const Hold hold(self.use);
                 self.controller.reset_covariance();
             })
        .def("resume_from_trouble",
             [](OwnedController& self) {
                 const Hold hold(self.use);
                 self.controller.resume_from_trouble();
             })
        .def("take_over",
             [](OwnedController& self, const Array& u, double fade) {
                 const std::vector<double> last = copied(u, self.controller.l_u(), "u");
                 refuse_unless(finite(last.data(), last.size()) && fade >= 0.0 && fade < 1.0,
                               "u is not finite, or fade not in [0, 1)");
                 const Hold hold(self.use);
                 self.controller.take_over(last.data(), fade);
             },
             nb::arg("u"), nb::arg("fade"))
        .def_prop_ro("troubles", &troubles)
        .def("set_target", &set_target, nb::arg("numerator"), nb::arg("denominator"),
             nb::arg("past"))
        .def("set_weights", &set_weights, nb::arg("R_z").none(), nb::arg("R_u").none(),
             nb::arg("penalty").none() = nb::none())
        .def("set_lambda", &set_lambda, nb::arg("lambda_"))
        .def("save",
             [](OwnedController& self) {
                 const Hold hold(self.use);
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore",
             [](OwnedController& self, const Array& state) {
                 const Hold hold(self.use);
                 restore(self, copied(state, state.size(), "state"));
             })
        .def_prop_ro("theta", number([](const Controller& c) {
                         return to_numpy(c.theta().data(), c.theta().size());
                     }),
                     nb::rv_policy::automatic)
        .def_prop_ro("P", number([](const Controller& c) {
                         const std::size_t n = c.theta().size();
                         std::vector<double> P(n * n);
                         c.update().covariance(P.data());
                         return to_numpy(std::move(P), {n, n});
                     }),
                     nb::rv_policy::automatic)
        .def_prop_ro("also_fitted", number([](const Controller& c) {
                         std::vector<double> d = c.update().also_fitted();
                         const std::size_t n = d.size();
                         return to_numpy(std::move(d), {n});
                     }),
                     nb::rv_policy::automatic)
        .def_prop_ro("target", [](const OwnedController& self) {
                         const TargetModel& m = self.controller.target().model();
                         const std::size_t length = m.order + 1;
                         return nb::make_tuple(
                             to_numpy(std::vector<double>(m.numerator), {length, m.l_z, m.l_u}),
                             to_numpy(std::vector<double>(m.denominator), {length, m.l_z, m.l_z}));
                     })
        .def_prop_ro("longest_order",
                     number([](const Controller& c) { return c.longest_order(); }))
        .def_prop_ro("k", number([](const Controller& c) { return c.step(); }))
        .def_prop_ro("forgetting_factor", number([](const Controller& c) { return c.lambda(); }))
        .def_prop_ro("reflections", number([](const Controller& c) { return c.reflections(); }))
        .def_prop_ro("resets", number([](const Controller& c) { return c.resets(); }))
        .def_prop_ro("bounded", number([](const Controller& c) { return c.bounded(); }))
        .def_prop_ro("guard_count",
                     number([](const Controller& c) { return c.update().guard().count; }))
        .def_prop_ro("guard_first_step",
                     number([](const Controller& c) { return c.update().guard().first_step; }));
    const nb::object empty = nb::cast(to_numpy(nullptr, 0));
    m.def("controller", &make_controller, nb::kw_only(), nb::arg("l_u"), nb::arg("l_y"),
          nb::arg("l_r"), nb::arg("l_z"), nb::arg("derived"), nb::arg("regressor"),
          nb::arg("channels"), nb::arg("filtered"), nb::arg("targets"), nb::arg("R_z"),
          nb::arg("R_u"), nb::arg("forgetting_factor"), nb::arg("k_w"), nb::arg("k_update"),
          nb::arg("k_filter"), nb::arg("filter_form"), nb::arg("reflect_poles"), nb::arg("events"),
          nb::arg("forgetting"), nb::arg("reset"), nb::arg("noise"), nb::arg("update"),
          nb::arg("P_0"), nb::arg("theta_0"), nb::arg("window"), nb::arg("step_size"),
          nb::arg("dither") = Perturbation{0, 0.0, 0.0, 0}, nb::arg("penalty") = empty,
          nb::arg("normalization") = Curve{0, 1.0, 1.0},
          nb::arg("bounds") = nb::make_tuple(empty, empty, false, 0),
          nb::arg("ellipsoid") = nb::make_tuple(empty, empty, false, 1.0, 1.0),
          nb::arg("fixed") = nb::make_tuple(empty, empty), nb::arg("supervision") = nb::none(),
          nb::arg("limits") = nb::make_tuple(empty, empty, empty, empty),
          nb::arg("instruction_set") = "");
}

}  // namespace rcac
