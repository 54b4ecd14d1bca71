// Prediction errors of Box-Jenkins models as Python sees them.
#include "bindings/bindings.hpp"
#include "bindings/numpy_arrays.hpp"
#include "identification/box_jenkins.hpp"

#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

namespace rcac {
namespace {

// None where the errors leave float64. An empty array of weights is that of ones.
std::unique_ptr<BoxJenkinsErrors> box_jenkins_errors(
    const Array& y, const Array& u, const Array& levels, const Array& weights, const Array& theta,
    const std::vector<std::size_t>& orders, bool differences, bool armax, bool sinusoid,
    double dependent) {
    const std::size_t steps = y.size();
    require_range<std::size_t>(steps, 1, most_numbers, "the steps");
    require(u.size(), steps, "u");
    refuse_unless(levels.size() % steps == 0, "the levels are not rows of the length of y");
    refuse_unless(weights.size() == 0 || weights.size() == steps, "weights has another length");
    refuse_unless(orders.size() == 4, "orders are those of A, B, C and D");
    for (const std::size_t order : orders) require_range<std::size_t>(order, 0, 64, "an order");
    const std::size_t coefficients = orders[0] + orders[1] + orders[2] + orders[3] + sinusoid;
    length_of({levels.size() / steps + 2 + 2 * std::size_t{sinusoid} + orders[0], steps},
              "the free rows");
    length_of({coefficients, steps}, "the derivatives");
    refuse_unless(dependent >= 0.0 && dependent < 1.0, "`dependent` lies outside [0, 1)");
    BoxJenkinsRecord record{copied(y, steps, "y"),
                            copied(u, steps, "u"),
                            copied(levels, levels.size(), "levels"),
                            copied(weights, weights.size(), "weights"),
                            orders[0],
                            orders[1],
                            orders[2],
                            orders[3],
                            differences,
                            armax,
                            sinusoid,
                            dependent};
    auto errors = std::make_unique<BoxJenkinsErrors>(std::move(record),
                                                     copied(theta, coefficients, "theta"));
    return errors->is_finite() ? std::move(errors) : nullptr;
}

}  // namespace

void bind_box_jenkins(nb::module_& m) {
    nb::class_<BoxJenkinsErrors>(m, "BoxJenkinsErrors")
        .def_prop_ro("theta",
                     [](const BoxJenkinsErrors& self) {
                         return to_numpy(self.theta().data(), self.theta().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("e",
                     [](const BoxJenkinsErrors& self) {
                         return to_numpy(self.e().data(), self.e().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("square",
                     [](const BoxJenkinsErrors& self) {
                         return dot(self.e().data(), self.e().data(), self.e().size());
                     })
        .def("remainder",
             [](const BoxJenkinsErrors& self, bool waves) {
                 std::vector<double> v = self.remainder(waves);
                 const std::size_t steps = v.size();
                 return to_numpy(std::move(v), {steps});
             },
             nb::arg("waves"))
        .def("jacobian", [](const BoxJenkinsErrors& self) -> nb::object {
            std::vector<double> J = self.jacobian();
            if (!BoxJenkinsErrors::are_finite(J.data(), J.size())) return nb::none();
            return nb::cast(to_numpy(std::move(J), {self.theta().size(), self.e().size()}));
        });
    m.def("box_jenkins_errors", &box_jenkins_errors, nb::kw_only(), nb::arg("y"), nb::arg("u"),
          nb::arg("levels"), nb::arg("weights"), nb::arg("theta"), nb::arg("orders"),
          nb::arg("differences"), nb::arg("armax"), nb::arg("sinusoid"), nb::arg("dependent"));
}

}  // namespace rcac
