// Prediction errors of Box-Jenkins models as Python sees them.
#include "bindings/bindings.hpp"
#include "bindings/numpy_arrays.hpp"
#include "identification/box_jenkins.hpp"
#include "identification/least_errors.hpp"
#include "identification/student_scale.hpp"

#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

namespace rcac {
namespace {

// An empty array of weights is that of ones.
std::shared_ptr<const BoxJenkinsRecord> record_of(
    const Array& y, const Array& u, const Array& levels, const Array& weights,
    const std::vector<std::size_t>& orders, bool differences, bool armax, bool sinusoid,
    double dependent) {
    const std::size_t steps = y.size();
    require_range<std::size_t>(steps, 1, most_numbers, "the steps");
    require(u.size(), steps, "u");
    refuse_unless(levels.size() % steps == 0, "the levels are not rows of the length of y");
    refuse_unless(weights.size() == 0 || weights.size() == steps, "weights has another length");
    refuse_unless(orders.size() == 4, "orders are those of A, B, C and D");
    for (const std::size_t order : orders) require_range<std::size_t>(order, 0, 64, "an order");
    length_of({levels.size() / steps + 2 + 2 * std::size_t{sinusoid} + orders[0], steps},
              "the free rows");
    length_of({orders[0] + orders[1] + orders[2] + orders[3] + sinusoid, steps},
              "the derivatives");
    refuse_unless(dependent >= 0.0 && dependent < 1.0, "`dependent` lies outside [0, 1)");
    return std::make_shared<const BoxJenkinsRecord>(
        BoxJenkinsRecord{copied(y, steps, "y"), copied(u, steps, "u"),
                         copied(levels, levels.size(), "levels"),
                         copied(weights, weights.size(), "weights"), orders[0], orders[1],
                         orders[2], orders[3], differences, armax, sinusoid, dependent});
}

// None where the errors leave float64.
std::unique_ptr<BoxJenkinsErrors> box_jenkins_errors(
    const Array& y, const Array& u, const Array& levels, const Array& weights, const Array& theta,
    const std::vector<std::size_t>& orders, bool differences, bool armax, bool sinusoid,
    double dependent) {
    auto record =
        record_of(y, u, levels, weights, orders, differences, armax, sinusoid, dependent);
    std::vector<double> start = copied(theta, record->coefficients(), "theta");
    auto errors = std::make_unique<BoxJenkinsErrors>(std::move(record), std::move(start));
    return errors->is_finite() ? std::move(errors) : nullptr;
}

nb::ndarray<nb::numpy, double> rows_of(std::vector<double> J, const BoxJenkinsErrors& errors) {
    return to_numpy(std::move(J), {errors.theta().size(), errors.e().size()});
}

// The point of least errors and its derivatives; None where those of the start leave float64.
nb::object least_box_jenkins_errors(
    const Array& y, const Array& u, const Array& levels, const Array& weights, const Array& theta,
    const std::vector<std::size_t>& orders, bool differences, bool armax, bool sinusoid,
    double dependent, std::size_t kept, std::size_t iterations, std::size_t widths,
    double decrease, double settled, double circle, double of_C) {
    auto record =
        record_of(y, u, levels, weights, orders, differences, armax, sinusoid, dependent);
    std::vector<double> start = copied(theta, record->coefficients(), "theta");
    require_range<std::size_t>(kept, 0, start.size(), "the number of coefficients that are kept");
    require_range<std::size_t>(iterations, 0, 1000, "the number of iterations");
    require_range<std::size_t>(widths, 0, 1000, "the number of damping factors");
    refuse_unless(circle > 0.0 && circle <= 1.0 && of_C > 0.0 && of_C <= 1.0,
                  "the largest modulus of a root lies outside (0, 1]");
    const auto check = [] {
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
    };
    LeastErrors least =
        LevenbergMarquardt(std::move(record),
                           {iterations, widths, kept, decrease, settled, circle, of_C}, check)
            .run(std::move(start));
    if (!least.point) return nb::none();
    auto J = rows_of(std::move(least.J), *least.point);
    return nb::make_tuple(std::move(least.point), std::move(J));
}

nb::ndarray<nb::numpy, double> confined_roots(const Array& A, double radius) {
    require_range<std::size_t>(A.size(), 1, 65, "the length of A");
    refuse_unless(A.data()[0] == 1.0, "A is not monic");
    refuse_unless(radius > 0.0 && radius <= 1.0, "the radius lies outside (0, 1]");
    return to_numpy(confined(copied(A, A.size(), "A"), radius), {A.size()});
}

double scale_of_student(const Array& e, double degrees, double least, std::size_t passes) {
    require_range<std::size_t>(e.size(), 1, most_numbers, "the number of errors");
    refuse_unless(degrees > 0.0, "degrees are not positive");
    refuse_unless(least > 0.0, "the least scale is not positive");
    require_range<std::size_t>(passes, 0, 1000, "the number of passes");
    return student_scale(e.data(), e.size(), degrees, least, passes);
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
                     [](const BoxJenkinsErrors& self) { return self.square(); })
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
            return nb::cast(rows_of(std::move(J), self));
        });
    m.def("box_jenkins_errors", &box_jenkins_errors, nb::kw_only(), nb::arg("y"), nb::arg("u"),
          nb::arg("levels"), nb::arg("weights"), nb::arg("theta"), nb::arg("orders"),
          nb::arg("differences"), nb::arg("armax"), nb::arg("sinusoid"), nb::arg("dependent"));
    m.def("least_box_jenkins_errors", &least_box_jenkins_errors, nb::kw_only(), nb::arg("y"),
          nb::arg("u"), nb::arg("levels"), nb::arg("weights"), nb::arg("theta"),
          nb::arg("orders"), nb::arg("differences"), nb::arg("armax"), nb::arg("sinusoid"),
          nb::arg("dependent"), nb::arg("kept"), nb::arg("iterations"), nb::arg("widths"),
          nb::arg("decrease"), nb::arg("settled"), nb::arg("circle"), nb::arg("of_C"));
    m.def("student_scale", &scale_of_student, nb::arg("e"), nb::arg("degrees"), nb::arg("least"),
          nb::arg("passes"));
    m.def("confined_roots", &confined_roots, nb::arg("A"), nb::arg("radius"));
}

}  // namespace rcac
