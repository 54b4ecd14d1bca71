// The closed loop as Python sees it.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <thread>

#include "bindings.hpp"
#include "closed_loop.hpp"

namespace rcac {
namespace {

// A loop with everything that it refers to.
class OwnedLoop {
public:
    OwnedLoop(const std::vector<nb::object>& controllers, nb::object plant, const Array& low,
              const Array& high, const Array& rate, double limit, bool stop_where_unsupported,
              bool shared_u, std::size_t r_in_w)
        : objects_(controllers),
          plant_object_(plant),
          plant_(nb::cast<Plant*>(plant)),
          actuator_(copied(low, low.size(), "low"), copied(high, low.size(), "high"),
                    copied(rate, low.size(), "rate")),
          loop_(pointers(controllers), *plant_, actuator_,
                {limit, stop_where_unsupported, shared_u, r_in_w}) {
        const Sizes& size = plant_->sizes();
        if (!actuator_.is_ideal()) require(low.size(), size.l_u, "low");
        for (const Controller* c : loop_.controllers()) {
            require(c->structure().l_u, size.l_u, "l_u");
            require(c->structure().l_y, size.l_y, "l_y");
            require(c->l_z(), size.l_z, "l_z");
            if (r_in_w + c->structure().l_r > size.l_w) throw std::invalid_argument("r beyond w");
        }
    }

    // Rows first, ..., first + count - 1 of the arrays.
    std::pair<std::int64_t, int> run(const Array& w, const Output& u,
                                     const std::optional<Output>& u_applied, const Output& y,
                                     const Output& z, const Output& theta, std::int64_t stride,
                                     std::int64_t first, std::int64_t count) {
        const Sizes& size = plant_->sizes();
        const auto steps = static_cast<std::int64_t>(u.shape(0));
        if (stride < 1) throw std::invalid_argument("stride must be at least 1");
        if (first < 0 || count < 0 || first + count > steps || first % stride != 0)
            throw std::invalid_argument("no such rows");
        const auto rows = static_cast<std::size_t>(steps);
        require(w.size(), rows * size.l_w, "w");
        require(u.size(), rows * size.l_u, "u");
        require(y.size(), rows * size.l_y, "y");
        require(z.size(), rows * size.l_z, "z");
        if (u_applied) require(u_applied->size(), rows * size.l_u, "u_applied");
        require(theta.size(), static_cast<std::size_t>((steps + stride - 1) / stride) * loop_.l_theta(),
                "theta");
        const auto at = [first](double* data, std::size_t width) {
            return data + first * static_cast<std::int64_t>(width);
        };
        const Record record{at(u.data(), size.l_u),
                            u_applied ? at(u_applied->data(), size.l_u) : nullptr,
                            at(y.data(), size.l_y),
                            at(z.data(), size.l_z),
                            theta.data() + first / stride * static_cast<std::int64_t>(loop_.l_theta()),
                            stride};
        const double* start = w.data() + first * static_cast<std::int64_t>(size.l_w);
        Outcome outcome = Outcome::completed;
        nb::gil_scoped_release release;
        const std::int64_t done = simulate(loop_, start, size.l_w, count, record, outcome);
        return {done, static_cast<int>(outcome)};
    }

    const std::vector<double>& theta_before() const { return loop_.theta_before(); }

    void visit(Archive& archive) {
        for (Controller* c : loop_.controllers()) c->visit(archive);
        plant_->visit(archive);
        actuator_.visit(archive);
    }

private:
    static std::vector<Controller*> pointers(const std::vector<nb::object>& objects) {
        if (objects.empty()) throw std::invalid_argument("no controller");
        std::vector<Controller*> result;
        for (const nb::object& object : objects) result.push_back(nb::cast<Controller*>(object));
        return result;
    }

    std::vector<nb::object> objects_;
    nb::object plant_object_;
    Plant* plant_;
    Actuator actuator_;
    Loop loop_;
};

}  // namespace

void bind_loop(nb::module_& m) {
    nb::class_<OwnedLoop>(m, "Loop")
        .def(nb::init<const std::vector<nb::object>&, nb::object, const Array&, const Array&,
                      const Array&, double, bool, bool, std::size_t>(),
             nb::kw_only(), nb::arg("controllers"), nb::arg("plant"), nb::arg("low"),
             nb::arg("high"), nb::arg("rate"), nb::arg("limit"), nb::arg("stop_where_unsupported"),
             nb::arg("shared_u"), nb::arg("r_in_w"))
        .def("run", &OwnedLoop::run, nb::arg("w"), nb::arg("u"), nb::arg("u_applied").none(),
             nb::arg("y"), nb::arg("z"), nb::arg("theta"), nb::arg("stride"), nb::arg("first"),
             nb::arg("count"))
        .def("theta_before",
             [](const OwnedLoop& self) {
                 const auto& theta = self.theta_before();
                 return to_numpy(theta.data(), theta.size());
             })
        .def("save",
             [](OwnedLoop& self) {
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore", [](OwnedLoop& self, const Array& state) {
            Archive archive(copied(state, state.size(), "state"));
            self.visit(archive);
            archive.finish();
        });
}

}  // namespace rcac
