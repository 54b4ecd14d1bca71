// Plants as Python sees them.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "plants/linear_plant.hpp"

namespace rcac {
namespace {

using SizeTuple = std::tuple<std::size_t, std::size_t, std::size_t, std::size_t, std::size_t>;

Sizes sizes_of(const SizeTuple& t) {
    return {std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t), std::get<4>(t)};
}

std::unique_ptr<Plant> linear_plant(const SizeTuple& tuple, const nb::list& segments, const Array& x_0) {
    const Sizes size = sizes_of(tuple);
    static const char* names[9] = {"A", "B", "D_1", "C", "D_0", "D_2", "E_1", "E_2", "E_0"};
    std::vector<Segment> result;
    for (nb::handle item : segments) {
        auto [start, matrices, ramp, map, delay] =
            nb::cast<std::tuple<std::int64_t, std::vector<Array>, bool, Array, std::size_t>>(item);
        require(matrices.size(), 9, "matrices");
        Segment segment{start, {}, ramp, {}, delay};
        std::size_t n = 0;
        while (n * n < matrices[0].size()) ++n;
        segment.matrices.n = n;
        const std::size_t rows[3] = {n, size.l_y, size.l_z}, columns[3] = {n, size.l_u, size.l_w};
        for (std::size_t block = 0; block < 3; ++block) {
            for (std::size_t i = 3 * block; i < 3 * block + 3; ++i)
                require(matrices[i].size(), rows[block] * columns[i % 3], names[i]);
            for (std::size_t row = 0; row < rows[block]; ++row)
                for (std::size_t i = 0; i < 3; ++i) {
                    const double* entries = matrices[3 * block + i].data() + row * columns[i];
                    segment.matrices.rows.insert(segment.matrices.rows.end(), entries,
                                                 entries + columns[i]);
                }
        }
        const std::size_t before = result.empty() ? n : result.back().matrices.n;
        if (map.size() > 0)
            segment.state_map = copied(map, n * before, "state_map");
        else
            require(n, before, "state");
        if (!result.empty() && result.back().ramp) require(n, before, "state of a ramp");
        if (!result.empty() && segment.start <= result.back().start)
            throw std::invalid_argument("segments must be in order");
        result.push_back(std::move(segment));
    }
    if (result.empty() || result.back().ramp) throw std::invalid_argument("no last segment");
    require(x_0.size(), result.front().matrices.n, "x_0");
    return std::make_unique<LinearPlant>(size, std::move(result), copied(x_0, x_0.size(), "x_0"));
}

// Python functions advance(k, x, u, w) -> x(k+1) and output(k, x, w) -> (y, z), arrays of the
// right size or None where they failed.
std::unique_ptr<Plant> python_plant(const SizeTuple& tuple, nb::object advance, nb::object output,
                                    const Array& x_0) {
    const Sizes s = sizes_of(tuple);
    PlantFunctions functions;
    functions.advance = [advance, s](std::int64_t k, const double* x, const double* u,
                                     const double* w, double* next) {
        nb::gil_scoped_acquire gil;
        nb::object answer = advance(k, to_numpy(x, s.n), to_numpy(u, s.l_u), to_numpy(w, s.l_w));
        if (answer.is_none()) return false;
        const std::vector<double> values = copied(nb::cast<Array>(answer), s.n, "x(k+1)");
        std::copy(values.begin(), values.end(), next);
        return true;
    };
    functions.output = [output, s](std::int64_t k, const double* x, const double* w, double* y,
                                   double* z) {
        nb::gil_scoped_acquire gil;
        nb::object answer = output(k, to_numpy(x, s.n), to_numpy(w, s.l_w));
        if (answer.is_none()) return false;
        auto [y_k, z_k] = nb::cast<std::pair<Array, Array>>(answer);
        const std::vector<double> y_values = copied(y_k, s.l_y, "y"), z_values = copied(z_k, s.l_z, "z");
        std::copy(y_values.begin(), y_values.end(), y);
        std::copy(z_values.begin(), z_values.end(), z);
        return true;
    };
    require(x_0.size(), s.n, "x_0");
    return std::make_unique<FunctionPlant>(s, std::move(functions), copied(x_0, s.n, "x_0"));
}

// The same as two compiled functions behind scipy.LowLevelCallable:
//   int advance(int64_t k, double* x, double* u, double* w, double* x_next, void* user_data)
//   int output(int64_t k, double* x, double* w, double* y, double* z, void* user_data)
// They return 0, or anything else to end the run.
std::unique_ptr<Plant> compiled_plant(const SizeTuple& tuple, nb::object advance, nb::object output,
                                      const Array& x_0) {
    using Function = int (*)(std::int64_t, double*, double*, double*, double*, void*);
    const auto unpack = [](const nb::object& capsule) {
        const char* name = PyCapsule_GetName(capsule.ptr());
        void* pointer = PyCapsule_GetPointer(capsule.ptr(), name);
        if (!pointer) throw nb::python_error();
        return std::make_pair(reinterpret_cast<Function>(pointer), PyCapsule_GetContext(capsule.ptr()));
    };
    const Sizes s = sizes_of(tuple);
    const auto [advance_, advance_data] = unpack(advance);
    const auto [output_, output_data] = unpack(output);
    PlantFunctions functions;
    // The capsules are captured so that they live as long as the plant.
    functions.advance = [advance, f = advance_, data = advance_data](
                            std::int64_t k, const double* x, const double* u, const double* w,
                            double* next) {
        return f(k, const_cast<double*>(x), const_cast<double*>(u), const_cast<double*>(w), next,
                 data) == 0;
    };
    functions.output = [output, f = output_, data = output_data](
                           std::int64_t k, const double* x, const double* w, double* y, double* z) {
        return f(k, const_cast<double*>(x), const_cast<double*>(w), y, z, data) == 0;
    };
    require(x_0.size(), s.n, "x_0");
    return std::make_unique<FunctionPlant>(s, std::move(functions), copied(x_0, s.n, "x_0"));
}

}  // namespace

void bind_plants(nb::module_& m) {
    nb::class_<Plant>(m, "Plant")
        .def_prop_ro("x",
                     [](const Plant& self) { return to_numpy(self.x().data(), self.x().size()); },
                     nb::rv_policy::automatic)
        .def("output",
             [](Plant& self, std::int64_t k, const Array& u, const Array& w) {
                 const Sizes& size = self.sizes();
                 require(u.size(), size.l_u, "u");
                 require(w.size(), size.l_w, "w");
                 std::vector<double> y(size.l_y), z(size.l_z);
                 self.begin(k, w.data());
                 self.receive(u.data());
                 const bool works = self.y(y.data()) && self.z(z.data());
                 return std::make_tuple(works, to_numpy(std::move(y), {size.l_y}),
                                        to_numpy(std::move(z), {size.l_z}));
             },
             nb::arg("k"), nb::arg("u"), nb::arg("w"))
        .def("advance",
             [](Plant& self, std::int64_t k, const Array& u, const Array& w) {
                 require(u.size(), self.sizes().l_u, "u");
                 require(w.size(), self.sizes().l_w, "w");
                 self.begin(k, w.data());
                 self.receive(u.data());
                 return self.advance();
             },
             nb::arg("k"), nb::arg("u"), nb::arg("w"));
    m.def("linear_plant", &linear_plant, nb::arg("sizes"), nb::arg("segments"), nb::arg("x_0"));
    m.def("python_plant", &python_plant, nb::arg("sizes"), nb::arg("advance"), nb::arg("output"),
          nb::arg("x_0"));
    m.def("compiled_plant", &compiled_plant, nb::arg("sizes"), nb::arg("advance"),
          nb::arg("output"), nb::arg("x_0"));
}

}  // namespace rcac
