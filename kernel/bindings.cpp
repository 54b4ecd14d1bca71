// The door between NumPy and the kernel. Shapes and ranges are checked in Python, where the
// messages can name the user's arguments; here every size is checked once more, so that no call
// can reach beyond an array.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings_updates.hpp"
#include "closed_loop.hpp"
#include "covariance_update.hpp"
#include "ud_update.hpp"

namespace nb = nanobind;
using namespace rcac;

namespace {

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

void require(std::size_t found, std::size_t wanted, const char* name) {
    if (found != wanted)
        throw std::invalid_argument(std::string(name) + ": " + std::to_string(found) +
                                    " numbers where " + std::to_string(wanted) + " belong");
}

std::vector<double> copied(const Array& array, std::size_t size, const char* name) {
    require(array.size(), size, name);
    return std::vector<double>(array.data(), array.data() + size);
}

nb::ndarray<nb::numpy, double> to_numpy(std::vector<double> values,
                                        const std::vector<std::size_t>& shape) {
    auto* data = new std::vector<double>(std::move(values));
    nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    return nb::ndarray<nb::numpy, double>(data->data(), shape.size(), shape.data(), owner);
}

std::vector<Tap> taps(const Pairs& pairs) {
    std::vector<Tap> result;
    for (const auto& [source, delay] : pairs) result.push_back({source, delay});
    return result;
}

Controller make_controller(std::size_t l_u, std::size_t l_y, std::size_t l_z, const Pairs& regressor,
                           const Pairs& channels, const Pairs& filtered,
                           const Array& numerator, const Array& denominator, double lambda, const Array& R_z,
                           const Array& R_u, nb::object R_u_of_z, std::int64_t k_w,
                           std::int64_t k_update, std::int64_t k_filter, const std::string& update,
                           const Array& P_0, const Array& theta_0) {
    Structure structure{l_u, l_y, taps(regressor), taps(channels), taps(filtered)};
    const std::size_t l_theta = regressor.size() * l_u;
    const std::size_t order = numerator.size() / (l_z * l_u) - 1;
    TargetModel model{l_z, l_u, order, copied(numerator, (order + 1) * l_z * l_u, "numerator"),
                      copied(denominator, (order + 1) * l_z * l_z, "denominator")};
    Weights weights{lambda, copied(R_z, l_z * l_z, "R_z"), copied(R_u, l_z * l_z, "R_u"), {}};
    if (!R_u_of_z.is_none())
        weights.R_u_of_z = [R_u_of_z, l_z](const double* z, double* result) {
            nb::gil_scoped_acquire gil;
            nb::object value = R_u_of_z(to_numpy(std::vector<double>(z, z + l_z), {l_z}));
            const std::vector<double> matrix =
                copied(nb::cast<Array>(value), l_z * l_z, "R_u(z)");
            std::copy(matrix.begin(), matrix.end(), result);
        };
    const std::vector<double> P = copied(P_0, l_theta * l_theta, "P_0");
    std::unique_ptr<Update> arithmetic;
    if (update == "ud")
        arithmetic = std::make_unique<UdUpdate>(P.data(), l_theta);
    else if (update == "covariance")
        arithmetic = std::make_unique<CovarianceUpdate>(P.data(), l_theta);
    else
        throw std::invalid_argument("no update named " + update);
    return Controller(std::move(structure), std::move(model), std::move(weights),
                      {k_w, k_update, k_filter}, std::move(arithmetic),
                      copied(theta_0, l_theta, "theta_0"));
}

Plant make_plant(const Array& A, const Array& B, const Array& D_1, const Array& C, const Array& D_0,
                 const Array& D_2, const Array& E_1, const Array& E_2, const Array& E_0,
                 const Array& x_0, std::size_t l_u, std::size_t l_w, std::size_t l_y,
                 std::size_t l_z) {
    const std::size_t n = x_0.size();
    PlantMatrices matrices{n,
                           l_u,
                           l_w,
                           l_y,
                           l_z,
                           copied(A, n * n, "A"),
                           copied(B, n * l_u, "B"),
                           copied(D_1, n * l_w, "D_1"),
                           copied(C, l_y * n, "C"),
                           copied(D_0, l_y * l_u, "D_0"),
                           copied(D_2, l_y * l_w, "D_2"),
                           copied(E_1, l_z * n, "E_1"),
                           copied(E_2, l_z * l_u, "E_2"),
                           copied(E_0, l_z * l_w, "E_0")};
    return Plant(std::move(matrices), copied(x_0, n, "x_0"));
}

// u(k), and whether the update stayed in the range of float64.
std::pair<nb::ndarray<nb::numpy, double>, bool> controller_step(Controller& controller,
                                                                const Array& y, const Array& z) {
    require(y.size(), controller.structure().l_y, "y");
    require(z.size(), controller.l_z(), "z");
    controller.begin();
    controller.measure(y.data());
    const double* u = controller.control();
    std::vector<double> result(u, u + controller.structure().l_u);
    const bool finite = controller.adapt(z.data());
    const std::size_t size = result.size();
    return {to_numpy(std::move(result), {size}), finite};
}

}  // namespace

NB_MODULE(_kernel, m) {
    nb::set_leak_warnings(false);  // objects alive at interpreter exit are not leaks

    bind_updates(m);

    nb::class_<Controller>(m, "Controller")
        .def("step", &controller_step, nb::arg("y"), nb::arg("z"))
        .def_prop_ro("theta",
                     [](const Controller& self) {
                         return to_numpy(self.theta(), {self.theta().size()});
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("P",
                     [](const Controller& self) {
                         const std::size_t n = self.theta().size();
                         std::vector<double> P(n * n);
                         self.arithmetic().covariance(P.data());
                         return to_numpy(std::move(P), {n, n});
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("k", &Controller::step)
        .def_prop_ro("guard_count",
                     [](const Controller& self) { return self.arithmetic().guard().count; })
        .def_prop_ro("guard_first_step",
                     [](const Controller& self) { return self.arithmetic().guard().first_step; });
    m.def("controller", &make_controller, nb::kw_only(), nb::arg("l_u"), nb::arg("l_y"),
          nb::arg("l_z"), nb::arg("regressor"), nb::arg("channels"), nb::arg("filtered"),
          nb::arg("numerator"), nb::arg("denominator"),
          nb::arg("forgetting"), nb::arg("R_z"), nb::arg("R_u"), nb::arg("R_u_of_z").none(),
          nb::arg("k_w"), nb::arg("k_update"), nb::arg("k_filter"), nb::arg("update"),
          nb::arg("P_0"), nb::arg("theta_0"));

    nb::class_<Plant>(m, "Plant")
        .def_prop_ro("x", [](const Plant& self) { return to_numpy(self.x(), {self.x().size()}); },
                     nb::rv_policy::automatic)
        .def("output",
             [](const Plant& self, const Array& u, const Array& w) {
                 const PlantMatrices& size = self.matrices();
                 require(u.size(), size.l_u, "u");
                 require(w.size(), size.l_w, "w");
                 std::vector<double> y(size.l_y), z(size.l_z);
                 self.y(u.data(), w.data(), y.data());
                 self.z(u.data(), w.data(), z.data());
                 return std::make_pair(to_numpy(std::move(y), {size.l_y}),
                                       to_numpy(std::move(z), {size.l_z}));
             },
             nb::arg("u"), nb::arg("w"))
        .def("advance",
             [](Plant& self, const Array& u, const Array& w) {
                 require(u.size(), self.matrices().l_u, "u");
                 require(w.size(), self.matrices().l_w, "w");
                 self.advance(u.data(), w.data());
             },
             nb::arg("u"), nb::arg("w"));
    m.def("plant", &make_plant, nb::kw_only(), nb::arg("A"), nb::arg("B"), nb::arg("D_1"),
          nb::arg("C"), nb::arg("D_0"), nb::arg("D_2"), nb::arg("E_1"), nb::arg("E_2"),
          nb::arg("E_0"), nb::arg("x_0"), nb::arg("l_u"), nb::arg("l_w"), nb::arg("l_y"),
          nb::arg("l_z"));

    m.def("simulate",
          [](Controller& controller, Plant& plant, const Array& w, double limit, const Output& u,
             const Output& y, const Output& z, const Output& theta, std::int64_t stride) {
              const PlantMatrices& size = plant.matrices();
              const auto steps = static_cast<std::int64_t>(u.shape(0));
              if (stride < 1) throw std::invalid_argument("stride must be at least 1");
              require(controller.structure().l_u, size.l_u, "l_u");
              require(controller.structure().l_y, size.l_y, "l_y");
              require(controller.l_z(), size.l_z, "l_z");
              require(w.size(), steps * size.l_w, "w");
              require(u.size(), steps * size.l_u, "u");
              require(y.size(), steps * size.l_y, "y");
              require(z.size(), steps * size.l_z, "z");
              require(theta.size(), (steps + stride - 1) / stride * controller.theta().size(),
                      "theta");
              const Record record{u.data(), y.data(), z.data(), theta.data(), stride};
              nb::gil_scoped_release release;
              return simulate(controller, plant, w.data(), steps, limit, record);
          },
          nb::arg("controller"), nb::arg("plant"), nb::arg("w"), nb::arg("limit"), nb::arg("u"),
          nb::arg("y"), nb::arg("z"), nb::arg("theta"), nb::arg("stride"));
}
