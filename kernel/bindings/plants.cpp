// Plants as Python sees them.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/bindings.hpp"
#include "bindings/owned.hpp"
#include "plants/linear_plant.hpp"

namespace rcac {
namespace {

using SizeTuple = std::tuple<std::size_t, std::size_t, std::size_t, std::size_t, std::size_t>;

Sizes sizes_of(const SizeTuple& t) {
    const Sizes s{std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t), std::get<4>(t)};
    require_width(s.n, 0, "n");
    require_width(s.l_u, 1, "l_u");
    require_width(s.l_w, 0, "l_w");
    require_width(s.l_y, 0, "l_y");
    require_width(s.l_z, 1, "l_z");
    return s;
}

std::unique_ptr<OwnedPlant> owned(std::unique_ptr<Plant> plant) {
    return std::make_unique<OwnedPlant>(std::move(plant));
}

// One set of matrices [A B D_1; C D_0 D_2; E_1 E_2 E_0] as one array.
PlantMatrices matrices_of(const std::vector<Array>& matrices, const Sizes& size) {
    static const char* names[9] = {"A", "B", "D_1", "C", "D_0", "D_2", "E_1", "E_2", "E_0"};
    require(matrices.size(), 9, "matrices");
    PlantMatrices result{0, {}};
    std::size_t& n = result.n;
    while (n * n < matrices[0].size()) ++n;
    const std::size_t rows[3] = {n, size.l_y, size.l_z}, columns[3] = {n, size.l_u, size.l_w};
    for (std::size_t block = 0; block < 3; ++block) {
        for (std::size_t i = 3 * block; i < 3 * block + 3; ++i)
            require(matrices[i].size(), length_of({rows[block], columns[i % 3]}, names[i]), names[i]);
        for (std::size_t row = 0; row < rows[block]; ++row)
            for (std::size_t i = 0; i < 3; ++i) {
                const double* entries = matrices[3 * block + i].data() + row * columns[i];
                result.rows.insert(result.rows.end(), entries, entries + columns[i]);
            }
    }
    return result;
}

std::unique_ptr<OwnedPlant> linear_plant(const SizeTuple& tuple, const nb::list& segments,
                                         const Array& x_0) {
    using Parts = std::tuple<std::int64_t, std::vector<Array>, bool, Array, std::size_t>;
    const Sizes size = sizes_of(tuple);
    std::vector<Segment> result;
    for (nb::handle item : segments) {
        const auto [start, matrices, ramp, map, delay] =
            read<Parts>(item, "a segment", "(start, matrices, ramp, state_map, delay)");
        require_step(start, "start");
        length_of({size.l_u, delay, 2}, "the delayed input");
        Segment segment{start, matrices_of(matrices, size), ramp, {}, delay};
        const std::size_t n = segment.matrices.n;
        const std::size_t before = result.empty() ? n : result.back().matrices.n;
        if (map.size() > 0)
            segment.state_map = copied(map, length_of({n, before}, "state_map"), "state_map");
        else
            require(n, before, "state");
        if (!result.empty() && result.back().ramp) require(n, before, "state of a ramp");
        refuse_unless(result.empty() || segment.start > result.back().start,
                      "the segments are not in order");
        result.push_back(std::move(segment));
    }
    refuse_unless(!result.empty(), "a plant has no segment");
    refuse_unless(!result.back().ramp, "the last segment is a ramp towards nothing");
    require(result.front().matrices.n, size.n, "state of the first segment");
    require(x_0.size(), size.n, "x_0");
    return owned(std::make_unique<LinearPlant>(size, std::move(result),
                                               copied(x_0, x_0.size(), "x_0")));
}

// Python functions advance(k, x, u, w) -> x(k+1) and output(k, x, w) -> (y, z), arrays of the
// right size or None where they failed.
std::unique_ptr<OwnedPlant> python_plant(const SizeTuple& tuple, nb::callable advance,
                                         nb::callable output, const Array& x_0) {
    const Sizes s = sizes_of(tuple);
    PlantFunctions functions;
    functions.advance = [advance, s](std::int64_t k, const double* x, const double* u,
                                     const double* w, double* next) {
        nb::gil_scoped_acquire gil;
        nb::object answer = advance(k, to_numpy(x, s.n), to_numpy(u, s.l_u), to_numpy(w, s.l_w));
        if (answer.is_none()) return false;
        const std::vector<double> values = copied(read<Array>(answer, "x(k+1)", "an array"), s.n, "x(k+1)");
        std::copy(values.begin(), values.end(), next);
        return true;
    };
    functions.output = [output, s](std::int64_t k, const double* x, const double* w, double* y,
                                   double* z) {
        nb::gil_scoped_acquire gil;
        nb::object answer = output(k, to_numpy(x, s.n), to_numpy(w, s.l_w));
        if (answer.is_none()) return false;
        const auto [y_k, z_k] =
            read<std::pair<Array, Array>>(answer, "(y, z)", "a pair of arrays");
        const std::vector<double> y_values = copied(y_k, s.l_y, "y"),
                                  z_values = copied(z_k, s.l_z, "z");
        std::copy(y_values.begin(), y_values.end(), y);
        std::copy(z_values.begin(), z_values.end(), z);
        return true;
    };
    require(x_0.size(), s.n, "x_0");
    return owned(
        std::make_unique<FunctionPlant>(s, std::move(functions), copied(x_0, s.n, "x_0")));
}

// The same as two compiled functions behind scipy.LowLevelCallable:
//   int advance(int64_t k, double* x, double* u, double* w, double* x_next, void* user_data)
//   int output(int64_t k, double* x, double* w, double* y, double* z, void* user_data)
// They return 0, or anything else to end the run. A capsule of another signature is refused, for
// what it points at would be called all the same.
std::unique_ptr<OwnedPlant> compiled_plant(const SizeTuple& tuple, nb::object advance,
                                           nb::object output, const Array& x_0) {
    using Function = int (*)(std::int64_t, double*, double*, double*, double*, void*);
    const auto unpack = [](const nb::object& capsule) {
        if (!PyCapsule_CheckExact(capsule.ptr())) throw nb::type_error("this is not a capsule");
        const char* name = PyCapsule_GetName(capsule.ptr());
        std::string signature(name ? name : "");
        signature.erase(std::remove(signature.begin(), signature.end(), ' '), signature.end());
        bool known = false;
        for (const char* step : {"int64_t", "long", "longlong", "int64"})
            known = known || signature == std::string("int(") + step +
                                              ",double*,double*,double*,double*,void*)";
        refuse_unless(known, "a compiled function has the signature '" + signature.substr(0, 200) +
                                 "'; int (int64_t, double *, double *, double *, double *, void *) "
                                 "is needed");
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
    return owned(
        std::make_unique<FunctionPlant>(s, std::move(functions), copied(x_0, s.n, "x_0")));
}

void begin(Plant& plant, std::int64_t k, const Array& u, const Array& w) {
    require_step(k, "k");
    require(u.size(), plant.sizes().l_u, "u");
    require(w.size(), plant.sizes().l_w, "w");
    plant.begin(k, w.data());
    plant.receive(u.data());
}

// What `restore` reads into.
struct WithinStep {
    Plant& plant;
    void visit(Archive& archive) { plant.visit_within_step(archive); }
};

}  // namespace

void bind_plants(nb::module_& m) {
    nb::class_<OwnedPlant>(m, "Plant")
        .def_prop_ro("x",
                     [](OwnedPlant& self) {
                         const Hold hold(self.use);
                         return to_numpy(self.plant->x().data(), self.plant->x().size());
                     },
                     nb::rv_policy::automatic)
        .def("output",
             [](OwnedPlant& self, std::int64_t k, const Array& u, const Array& w) {
                 const Hold hold(self.use);
                 begin(*self.plant, k, u, w);
                 const Sizes& size = self.plant->sizes();
                 std::vector<double> y(size.l_y), z(size.l_z);
                 const bool works = self.plant->y(y.data()) && self.plant->z(z.data());
                 return std::make_tuple(works, to_numpy(std::move(y), {size.l_y}),
                                        to_numpy(std::move(z), {size.l_z}));
             },
             nb::arg("k"), nb::arg("u"), nb::arg("w"))
        .def("advance",
             [](OwnedPlant& self, std::int64_t k, const Array& u, const Array& w) {
                 const Hold hold(self.use);
                 begin(*self.plant, k, u, w);
                 return self.plant->advance();
             },
             nb::arg("k"), nb::arg("u"), nb::arg("w"))
        .def("save",
             [](OwnedPlant& self) {
                 const Hold hold(self.use);
                 Archive archive;
                 self.plant->visit_within_step(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore", [](OwnedPlant& self, const Array& state) {
            const Hold hold(self.use);
            WithinStep plant{*self.plant};
            restore(plant, copied(state, state.size(), "state"));
        });
    m.def("linear_plant", &linear_plant, nb::arg("sizes"), nb::arg("segments"), nb::arg("x_0"));
    m.def("python_plant", &python_plant, nb::arg("sizes"), nb::arg("advance"), nb::arg("output"),
          nb::arg("x_0"));
    m.def("compiled_plant", &compiled_plant, nb::arg("sizes"), nb::arg("advance"),
          nb::arg("output"), nb::arg("x_0"));
}

}  // namespace rcac
