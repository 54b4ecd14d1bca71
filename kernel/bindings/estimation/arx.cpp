// Recursive identification as Python sees it.
#include <nanobind/stl/unique_ptr.h>

#include "bindings/bindings.hpp"
#include "bindings/owned.hpp"
#include "bindings/numpy_arrays.hpp"
#include "estimation/recursive_arx.hpp"
#include "updates/subspace.hpp"

namespace rcac {
namespace {

struct OwnedArx {
    OwnedArx(std::vector<Tap> taps, double R_theta, double lambda, std::vector<double> theta_0,
             std::size_t inputs, std::size_t outputs, std::size_t target)
        : arx(taps, lambda, made(taps.size(), R_theta), std::move(theta_0), inputs, outputs,
              target) {}
    void visit(Archive& archive) { arx.visit(archive); }
    RecursiveArx arx;

private:
    static std::unique_ptr<Update> made(std::size_t n, double R_theta) {
        std::vector<double> P(length_of({n, n}, "P"), 0.0);
        for (std::size_t i = 0; i < n; ++i) P[i * (n + 1)] = 1.0 / R_theta;
        return std::make_unique<SubspaceUpdate>(P.data(), n);
    }
};

std::unique_ptr<OwnedArx> made(std::vector<Tap> taps, double R_theta, double lambda,
                               std::vector<double> theta_0, std::size_t inputs = 1,
                               std::size_t outputs = 1, std::size_t target = 0) {
    refuse_unless(R_theta > 0.0 && std::isfinite(1.0 / R_theta), "R_theta is not positive");
    require_forgetting(lambda, "lambda");
    return std::make_unique<OwnedArx>(std::move(taps), R_theta, lambda, std::move(theta_0), inputs,
                                      outputs, target);
}

// An empty theta_0 is zero.
std::unique_ptr<OwnedArx> make_arx(std::size_t order, double R_theta, double lambda,
                                   std::size_t l_u, std::size_t l_y, std::size_t target,
                                   const Array& theta_0) {
    require_range<std::size_t>(order, 1, 1000, "the order");
    require_range<std::size_t>(l_u, 1, 1000, "l_u");
    require_range<std::size_t>(l_y, 1, 1000, "l_y");
    require_range<std::size_t>(target, 0, l_y - 1, "the target");
    std::vector<Tap> taps = delayed_taps(1, 1, order, l_u, l_y);
    std::vector<double> first(taps.size(), 0.0);
    if (theta_0.size() > 0) first = copied(theta_0, taps.size(), "theta_0");
    return made(std::move(taps), R_theta, lambda, std::move(first), l_u, l_y, target);
}

// The output's delays begin where the Markov parameters end.
std::unique_ptr<OwnedArx> make_mu_markov(std::size_t mu, std::size_t n_mod, double R_theta,
                                         double lambda) {
    require_range<std::size_t>(mu, 1, 1000, "mu");
    require_range<std::size_t>(n_mod, 0, 500, "n_mod");
    std::vector<Tap> taps = delayed_taps(0, mu, mu + n_mod - 1);
    std::vector<double> first(taps.size(), 0.0);
    return made(std::move(taps), R_theta, lambda, std::move(first));
}

}  // namespace

void bind_arx(nb::module_& m) {
    nb::class_<OwnedArx>(m, "Arx")
        .def("take",
             [](OwnedArx& self, const Array& u, const Array& z) {
                 const std::size_t steps = u.size() / self.arx.inputs();
                 require(u.size(), steps * self.arx.inputs(), "u");
                 require(z.size(), steps * self.arx.outputs(), "z");
                 return self.arx.take(u.data(), z.data(), steps);
             })
        .def("save",
             [](OwnedArx& self) {
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore",
             [](OwnedArx& self, const Array& state) {
                 restore(self, copied(state, state.size(), "state"));
             })
        .def_prop_ro("k", [](const OwnedArx& self) { return self.arx.count(); })
        .def_prop_ro("variance", [](const OwnedArx& self) { return self.arx.variance(); })
        .def_prop_ro("weight", [](const OwnedArx& self) { return self.arx.weight(); })
        .def_prop_ro("theta",
                     [](const OwnedArx& self) {
                         const std::vector<double>& theta = self.arx.theta();
                         return to_numpy(theta.data(), theta.size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("errors",
                     [](const OwnedArx& self) {
                         std::vector<double> errors(RecursiveArx::kept_errors);
                         for (std::size_t i = 0; i < errors.size(); ++i)
                             errors[i] = self.arx.error(errors.size() - 1 - i);
                         const std::size_t size = errors.size();
                         return to_numpy(std::move(errors), {size});
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("P", [](const OwnedArx& self) {
            const std::size_t n = self.arx.theta().size();
            std::vector<double> P(n * n);
            self.arx.update().covariance(P.data());
            return to_numpy(std::move(P), {n, n});
        }, nb::rv_policy::automatic);
    m.def("arx", &make_arx, nb::kw_only(), nb::arg("order"), nb::arg("R_theta"),
          nb::arg("forgetting_factor"), nb::arg("l_u"), nb::arg("l_y"), nb::arg("target"),
          nb::arg("theta_0"));
    m.def("mu_markov", &make_mu_markov, nb::kw_only(), nb::arg("mu"), nb::arg("n_mod"),
          nb::arg("R_theta"), nb::arg("forgetting_factor"));
}

}  // namespace rcac
