// The closed loop as Python sees it.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "lanes/loop.hpp"

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

    Loop& loop() { return loop_; }
    const Sizes& sizes() const { return plant_->sizes(); }

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

// A job with the arrays that it reads and writes.
class OwnedJob {
public:
    OwnedJob(nb::object loop, Array w, Output u, std::optional<Output> u_applied, Output y, Output z,
             Output theta, std::int64_t stride)
        : loop_object_(loop), w_(w), u_(u), u_applied_(u_applied), y_(y), z_(z), theta_(theta) {
        OwnedLoop& owned = *nb::cast<OwnedLoop*>(loop);
        const Sizes& size = owned.sizes();
        if (stride < 1) throw std::invalid_argument("stride must be at least 1");
        const std::size_t steps = u.shape(0), per_row = static_cast<std::size_t>(stride);
        require(w.size(), steps * size.l_w, "w");
        require(u.size(), steps * size.l_u, "u");
        require(y.size(), steps * size.l_y, "y");
        require(z.size(), steps * size.l_z, "z");
        if (u_applied) require(u_applied->size(), steps * size.l_u, "u_applied");
        require(theta.size(), (steps + per_row - 1) / per_row * owned.loop().l_theta(), "theta");
        const Record record{u.data(), u_applied ? u_applied->data() : nullptr, y.data(), z.data(),
                            theta.data(), stride};
        job = {&owned.loop(), w.data(), size.l_w, record, static_cast<std::int64_t>(steps)};
    }

    Job job;

private:
    nb::object loop_object_;
    Array w_;
    Output u_;
    std::optional<Output> u_applied_;
    Output y_, z_, theta_;
};

// Each job at most `rows` steps further, in lanes (with that instruction set) where they are asked
// for and the job fits; whether there is anything left to do.
bool run_jobs(const std::vector<OwnedJob*>& owned, std::size_t threads, std::int64_t rows,
              bool in_lanes, const std::string& set_name) {
    const InstructionSet& instructions = instruction_set(set_name.c_str());
    std::vector<Job*> jobs;
    for (OwnedJob* one : owned)
        if (!one->job.finished()) jobs.push_back(&one->job);
    {
        nb::gil_scoped_release release;
        LaneGroups groups{{}, jobs};
        if (in_lanes) groups = lane_groups(jobs);
        const std::size_t first = groups.in_lanes.size();
        in_threads(first + groups.others.size(), threads, [&](std::size_t i) {
            if (i < first)
                LaneLoop(groups.in_lanes[i], instructions).run(rows);
            else
                groups.others[i - first]->run(rows);
        });
    }
    for (const Job* job : jobs)
        if (!job->finished()) return true;
    return false;
}

}  // namespace

void bind_loop(nb::module_& m) {
    nb::class_<OwnedLoop>(m, "Loop")
        .def(nb::init<const std::vector<nb::object>&, nb::object, const Array&, const Array&,
                      const Array&, double, bool, bool, std::size_t>(),
             nb::kw_only(), nb::arg("controllers"), nb::arg("plant"), nb::arg("low"),
             nb::arg("high"), nb::arg("rate"), nb::arg("limit"), nb::arg("stop_where_unsupported"),
             nb::arg("shared_u"), nb::arg("r_in_w"))
        .def("theta_before",
             [](OwnedLoop& self) {
                 const std::vector<double>& theta = self.loop().theta_before();
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
    nb::class_<OwnedJob>(m, "Job")
        .def(nb::init<nb::object, Array, Output, std::optional<Output>, Output, Output, Output,
                      std::int64_t>(),
             nb::arg("loop"), nb::arg("w"), nb::arg("u"), nb::arg("u_applied").none(), nb::arg("y"),
             nb::arg("z"), nb::arg("theta"), nb::arg("stride"))
        .def_prop_ro("done", [](const OwnedJob& self) { return self.job.done; })
        .def_prop_ro("outcome",
                     [](const OwnedJob& self) { return static_cast<int>(self.job.outcome); });
    m.def("run_jobs", &run_jobs, nb::arg("jobs"), nb::arg("threads"), nb::arg("rows"),
          nb::arg("lanes") = false, nb::arg("instruction_set") = "");
}

}  // namespace rcac
