// Model refinement as Python sees it.
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "bindings/owned.hpp"
#include "bindings/quick_read.hpp"
#include "estimation/refinement.hpp"

namespace rcac {
namespace {

struct OwnedRefinement {
    OwnedRefinement(RefinementPlan plan, std::unique_ptr<Subsystem> subsystem,
                    std::vector<double> P_0, std::vector<double> theta_0, std::vector<double> x_0)
        : refinement(std::move(plan), std::move(subsystem), std::move(P_0), std::move(theta_0),
                     std::move(x_0)),
          w(refinement.plan().l_w),
          y(refinement.plan().l_y),
          x(refinement.plan().n) {}
    void visit(Archive& archive) { refinement.visit(archive); }
    ModelRefinement refinement;
    std::vector<double> w, y, x;
    InUse use{"refinement"};
};

std::unique_ptr<OwnedRefinement> make_refinement(
    const std::vector<std::size_t>& sizes, const Array& A, const Array& D_1, const Array& B,
    const Array& C, const std::vector<std::size_t>& delays, const std::vector<std::size_t>& stack,
    const Array& H, const Array& R, const Array& lambda, const Array& V_d, const Array& W,
    std::size_t chosen, double eta_bar, double forgetting, bool direct, bool change,
    std::int64_t k_update, const Array& E_1, std::size_t n_c, bool strictly_proper,
    const Array& A_j, const Array& D_j, const Array& P_0, const Array& theta_0, const Array& x_0) {
    refuse_unless(sizes.size() == 5, "sizes are n, l_w, l_u, l_y and l_y0");
    const std::size_t n = sizes[0], l_w = sizes[1], l_u = sizes[2], l_y = sizes[3], l_y0 = sizes[4],
                      l_theta = theta_0.size();
    require_width(n, 1, "n");
    require_width(l_w, 0, "l_w");
    require_width(l_u, 1, "l_u");
    require_width(l_y, 1, "l_y");
    require_width(l_theta, 1, "l_theta");
    refuse_unless(!delays.empty() && !stack.empty(), "delays and stack may not be empty");
    for (std::size_t delay : delays) require_range<std::size_t>(delay, 1, most_numbers, "a delay");
    for (std::size_t k_j : stack) require_range<std::size_t>(k_j, 0, most_numbers, "k_j");
    refuse_unless(chosen < delays.size(), "d is not among the delays");
    require_forgetting(forgetting, "lambda");
    require_step(k_update, "k_update");
    refuse_unless(eta_bar >= 0.0, "eta_bar is negative");
    const std::size_t longest = *std::max_element(delays.begin(), delays.end());
    length_of({longest + 1, l_u, l_theta}, "the history of the regressor");
    length_of({*std::max_element(stack.begin(), stack.end()) + 1, l_y}, "the history of z");
    const std::size_t rows = length_of({stack.size(), l_y}, "Z"),
                      columns = length_of({delays.size(), l_u}, "U~"), m = lambda.size();
    RefinementPlan plan{n, l_w, l_u, l_y,
                        copied(A, length_of({n, n}, "A"), "A"),
                        copied(D_1, length_of({n, l_w}, "D_1"), "D_1"),
                        copied(B, length_of({n, l_u}, "B"), "B"),
                        copied(C, length_of({l_y, n}, "C"), "C"),
                        delays, stack,
                        copied(H, length_of({rows, columns}, "H"), "H"),
                        copied(R, length_of({rows, rows}, "R"), "R"),
                        copied(lambda, m, "lambda"),
                        copied(V_d, length_of({l_u, m}, "V_d"), "V_d"),
                        copied(W, length_of({m, rows}, "W"), "W"),
                        chosen, eta_bar, forgetting, direct, change, k_update};
    std::unique_ptr<Subsystem> subsystem;
    if (n_c > 0) {
        require_range<std::size_t>(l_theta, length_of({l_u, n_c, l_y0}, "theta"),
                                   length_of({l_u, n_c, l_y0}, "theta"), "l_theta");
        subsystem = std::make_unique<FirSubsystem>(
            copied(E_1, length_of({l_y0, n}, "E_1"), "E_1"), n, l_u, l_y0, n_c, strictly_proper);
    } else {
        refuse_unless(l_u == n, "a repeated parameter drives every state");
        subsystem = std::make_unique<RepeatedSubsystem>(
            copied(A_j, length_of({l_theta, n, n}, "A_j"), "A_j"),
            copied(D_j, length_of({l_theta, n, l_w}, "D_j"), "D_j"), n, l_w, l_theta);
    }
    return std::make_unique<OwnedRefinement>(
        std::move(plan), std::move(subsystem),
        copied(P_0, length_of({l_theta, l_theta}, "P_0"), "P_0"),
        copied(theta_0, l_theta, "theta_0"), copied(x_0, n, "x_0"));
}

bool step(OwnedRefinement& self, nb::handle w, nb::handle y, nb::handle x) {
    const bool given = !x.is_none();
    if (!quick_read(w, self.w) || !quick_read(y, self.y) || (given && !quick_read(x, self.x)))
        return false;
    const Hold hold(self.use);
    self.refinement.step(self.w.data(), self.y.data(), given ? self.x.data() : nullptr);
    return true;
}

// One half of a step: `given` is y(k), with x(k) or None, or else w(k).
bool half(OwnedRefinement& self, nb::handle given, nb::handle x, bool measures) {
    const bool has_x = !x.is_none();
    if (!quick_read(given, measures ? self.y : self.w) || (has_x && !quick_read(x, self.x)))
        return false;
    const Hold hold(self.use);
    if (measures)
        self.refinement.measure(self.y.data(), has_x ? self.x.data() : nullptr);
    else
        self.refinement.advance(self.w.data());
    return true;
}

void run(OwnedRefinement& self, const Array& w, const Array& y, const Array& x, Output& theta,
         Output& z, Output& u) {
    ModelRefinement& refinement = self.refinement;
    const RefinementPlan& plan = refinement.plan();
    const std::size_t steps = y.size() / plan.l_y, l_theta = refinement.theta().size();
    require(w.size(), steps * plan.l_w, "w");
    require(y.size(), steps * plan.l_y, "y");
    refuse_unless(x.size() == 0 || x.size() == steps * plan.n, "x has the wrong size");
    require(theta.size(), steps * l_theta, "theta");
    require(z.size(), steps * plan.l_y, "z");
    require(u.size(), steps * plan.l_u, "u");
    const Hold hold(self.use);
    for (std::size_t k = 0; k < steps; ++k) {
        refinement.step(w.data() + k * plan.l_w, y.data() + k * plan.l_y,
                        x.size() ? x.data() + k * plan.n : nullptr);
        std::copy_n(refinement.theta().data(), l_theta, theta.data() + k * l_theta);
        std::copy_n(refinement.z(), plan.l_y, z.data() + k * plan.l_y);
        std::copy_n(refinement.u(), plan.l_u, u.data() + k * plan.l_u);
        if (k % 1024 == 1023 && PyErr_CheckSignals() != 0) throw nb::python_error();
    }
}

}  // namespace

void bind_refinement(nb::module_& m) {
    const auto vector_of = [](const std::vector<double>& values) {
        return to_numpy(values.data(), values.size());
    };
    nb::class_<OwnedRefinement>(m, "Refinement")
        .def("step", &step, nb::arg("w").none(), nb::arg("y").none(), nb::arg("x").none())
        .def("half", &half, nb::arg("given").none(), nb::arg("x").none(), nb::arg("measures"))
        .def("run", &run, nb::arg("w"), nb::arg("y"), nb::arg("x"), nb::arg("theta"), nb::arg("z"),
             nb::arg("u"))
        .def("freeze",
             [](OwnedRefinement& self, bool frozen) {
                 const Hold hold(self.use);
                 self.refinement.frozen = frozen;
             })
        .def("save",
             [](OwnedRefinement& self) {
                 const Hold hold(self.use);
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore",
             [](OwnedRefinement& self, const Array& state) {
                 const Hold hold(self.use);
                 restore(self, copied(state, state.size(), "state"));
             })
        .def_prop_ro("k", [](const OwnedRefinement& self) { return self.refinement.k(); })
        .def_prop_ro("x", [=](const OwnedRefinement& s) { return vector_of(s.refinement.x()); },
                     nb::rv_policy::automatic)
        .def_prop_ro("theta",
                     [=](const OwnedRefinement& s) { return vector_of(s.refinement.theta()); },
                     nb::rv_policy::automatic)
        .def_prop_ro("z",
                     [](const OwnedRefinement& s) {
                         return to_numpy(s.refinement.z(), s.refinement.plan().l_y);
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("u",
                     [](const OwnedRefinement& s) {
                         return to_numpy(s.refinement.u(), s.refinement.plan().l_u);
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("P",
                     [](const OwnedRefinement& s) {
                         const std::size_t n = s.refinement.theta().size();
                         std::vector<double> P(n * n);
                         s.refinement.update().covariance(P.data());
                         return to_numpy(std::move(P), {n, n});
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("guard_count", [](const OwnedRefinement& s) {
            return s.refinement.update().guard().count;
        });
    m.def("refinement", &make_refinement, nb::kw_only(), nb::arg("sizes"), nb::arg("A"),
          nb::arg("D_1"), nb::arg("B"), nb::arg("C"), nb::arg("delays"), nb::arg("stack"),
          nb::arg("H"), nb::arg("R"), nb::arg("eigenvalues"), nb::arg("V_d"), nb::arg("W"),
          nb::arg("chosen"), nb::arg("eta_bar"), nb::arg("forgetting"), nb::arg("direct"),
          nb::arg("change"), nb::arg("k_update"), nb::arg("E_1"), nb::arg("n_c"),
          nb::arg("strictly_proper"), nb::arg("A_j"), nb::arg("D_j"), nb::arg("P_0"),
          nb::arg("theta_0"), nb::arg("x_0"));
}

}  // namespace rcac
