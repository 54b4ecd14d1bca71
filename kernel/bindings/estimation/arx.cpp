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
    OwnedArx(std::size_t order, double R_theta, double lambda)
        : arx(order, lambda, made(order, R_theta)) {}
    void visit(Archive& archive) { arx.visit(archive); }
    RecursiveArx arx;

private:
    static std::unique_ptr<Update> made(std::size_t order, double R_theta) {
        std::vector<double> P(length_of({2 * order, 2 * order}, "P"), 0.0);
        for (std::size_t i = 0; i < 2 * order; ++i) P[i * (2 * order + 1)] = 1.0 / R_theta;
        return std::make_unique<SubspaceUpdate>(P.data(), 2 * order);
    }
};

std::unique_ptr<OwnedArx> make_arx(std::size_t order, double R_theta, double lambda) {
    require_range<std::size_t>(order, 1, 1000, "the order");
    refuse_unless(R_theta > 0.0 && std::isfinite(1.0 / R_theta), "R_theta is not positive");
    require_forgetting(lambda, "lambda");
    return std::make_unique<OwnedArx>(order, R_theta, lambda);
}

}  // namespace

void bind_arx(nb::module_& m) {
    nb::class_<OwnedArx>(m, "Arx")
        .def("take",
             [](OwnedArx& self, const Array& u, const Array& z) {
                 require(z.size(), u.size(), "z");
                 return self.arx.take(u.data(), z.data(), u.size());
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
                     })
        .def_prop_ro("errors",
                     [](const OwnedArx& self) {
                         std::vector<double> errors(RecursiveArx::kept_errors);
                         for (std::size_t i = 0; i < errors.size(); ++i)
                             errors[i] = self.arx.error(errors.size() - 1 - i);
                         const std::size_t size = errors.size();
                         return to_numpy(std::move(errors), {size});
                     })
        .def_prop_ro("P", [](const OwnedArx& self) {
            const std::size_t n = self.arx.theta().size();
            std::vector<double> P(n * n);
            self.arx.update().covariance(P.data());
            return to_numpy(std::move(P), {n, n});
        });
    m.def("arx", &make_arx, nb::kw_only(), nb::arg("order"), nb::arg("R_theta"),
          nb::arg("forgetting_factor"));
}

}  // namespace rcac
