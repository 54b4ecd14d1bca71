// The closed loop as Python sees it.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/bindings.hpp"
#include "bindings/owned.hpp"
#include "bindings/plan.hpp"
#include "lanes/loop.hpp"
#include "updates/ud.hpp"

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
          owned_plant_(object_of<OwnedPlant>(plant, "Plant")),
          owned_(owners(controllers)),
          actuator_(copied(low, low.size(), "low"), copied(high, low.size(), "high"),
                    copied(rate, low.size(), "rate")),
          loop_(pointers(owned_), this->plant(), actuator_,
                {limit, stop_where_unsupported, shared_u, r_in_w}) {
        const Sizes& size = this->plant().sizes();
        if (!actuator_.is_ideal()) require(low.size(), size.l_u, "low");
        for (std::size_t i = 0; i < low.size(); ++i) {
            refuse_unless(low.data()[i] <= high.data()[i], "low exceeds high");
            refuse_unless(rate.data()[i] >= 0.0, "a rate is negative");
        }
        refuse_unless(limit > 0.0, "limit is not positive");
        for (const Controller* c : loop_.controllers()) {
            require(c->structure().l_u, size.l_u, "l_u");
            require(c->structure().l_y, size.l_y, "l_y");
            require(c->l_z(), size.l_z, "l_z");
            refuse_unless(r_in_w <= size.l_w && c->structure().l_r <= size.l_w - r_in_w,
                          "the command lies beyond w");
        }
    }
    // Of copies of what another loop is made of.
    OwnedLoop(std::vector<nb::object> controllers, nb::object plant, const OwnedLoop& like,
              double limit)
        : objects_(std::move(controllers)),
          plant_object_(std::move(plant)),
          owned_plant_(object_of<OwnedPlant>(plant_object_, "Plant")),
          owned_(owners(objects_)),
          actuator_(like.actuator_),
          loop_(pointers(owned_), this->plant(), actuator_,
                {limit, like.loop_.options().stop_where_unsupported,
                 like.loop_.options().shared_u, like.loop_.options().r_in_w}) {}

    // Everything that a step of this loop changes.
    void hold(Hold& all) {
        all.add(owned_plant_.use);
        for (OwnedController* c : owned_) all.add(c->use);
    }

    const std::vector<nb::object>& objects() const { return objects_; }
    Loop& loop() { return loop_; }
    InUse& front() { return owned_.front()->use; }
    Plant& plant() { return *owned_plant_.plant; }

    void visit(Archive& archive) {
        for (Controller* c : loop_.controllers()) c->visit(archive);
        plant().visit(archive);
        actuator_.visit(archive);
    }

private:
    static std::vector<OwnedController*> owners(const std::vector<nb::object>& objects) {
        refuse_unless(!objects.empty(), "a loop has no controller");
        std::vector<OwnedController*> result;
        for (const nb::object& object : objects) {
            OwnedController& one = object_of<OwnedController>(object, "Controller");
            refuse_unless(std::find(result.begin(), result.end(), &one) == result.end(),
                          "a controller is in the loop twice");
            result.push_back(&one);
        }
        return result;
    }
    static std::vector<Controller*> pointers(const std::vector<OwnedController*>& owned) {
        std::vector<Controller*> result;
        for (OwnedController* one : owned) result.push_back(&one->controller);
        return result;
    }

    std::vector<nb::object> objects_;  // so that what the rest points at lives on
    nb::object plant_object_;
    OwnedPlant& owned_plant_;
    std::vector<OwnedController*> owned_;
    Actuator actuator_;
    Loop loop_;
};

// (P_0, theta_0, lambda, R_z, R_u, [(numerator, denominator)]).
using Numbers = std::tuple<Array, Array, double, nb::object, nb::object, nb::list>;

// A controller at step 0 with the plan, theta and P of this one, or with other numbers in it: then
// the update is UD, the weights are none of functions and the target model is the one that it keeps.
std::unique_ptr<OwnedController> copied_controller(const Controller& from,
                                                          const nb::object& numbers) {
    refuse_unless(!from.has_left_its_plan(), "its plan no longer says what this controller does");
    ControllerPlan plan = from.plan();
    refuse_unless(!plan.R_z.function && !plan.R_u.function,
                  "a controller with a weight that is a function cannot be copied");
    std::unique_ptr<Update> update = from.update().copy();
    std::vector<double> theta = from.theta();
    if (!numbers.is_none()) {
        const auto [P_0, theta_0, lambda, R_z, R_u, targets] =
            read<Numbers>(numbers, "numbers", "(P_0, theta_0, lambda, R_z, R_u, targets)");
        auto* ud = dynamic_cast<UdUpdate*>(update.get());
        refuse_unless(ud != nullptr && plan.targets.size() == 1,
                      "numbers are those of a UD update with one target model");
        for (const nb::object& R : {R_z, R_u})
            refuse_unless(!PyCallable_Check(R.ptr()), "a weight is a function");
        require_forgetting(lambda, "lambda");
        const std::size_t l_z = from.l_z(), order = plan.targets[0].order;
        plan.lambda = lambda;
        plan.R_z = weight_of(R_z, plan.structure, l_z, "R_z");
        plan.R_u = weight_of(R_u, plan.structure, l_z, "R_u");
        plan.targets = targets_of(targets, plan.structure, l_z);
        refuse_unless(plan.targets.size() == 1 && plan.targets[0].order == order,
                      "the target model is not one of the same order");
        theta = copied(theta_0, theta.size(), "theta_0");
        ud->begin_from(covariance_of(P_0, theta.size()).data());
    }
    return std::make_unique<OwnedController>(std::move(plan), std::move(update), std::move(theta));
}

// A loop at its first step, made of copies: with this limit, x(0) (zero: None) and, of its one
// controller, P(0), theta(0), lambda, R_z, R_u and G_f of the same order, where they are given.
// What steps have changed of `from` beside theta and P is not in it.
std::unique_ptr<OwnedLoop> copied_loop(OwnedLoop& from, double limit, nb::object x_0,
                                       nb::object numbers) {
    refuse_unless(limit > 0.0, "limit is not positive");
    Hold all;
    from.hold(all);
    const std::size_t n = from.plant().sizes().n;
    std::unique_ptr<Plant> plant = from.plant().copy(
        x_0.is_none() ? std::vector<double>(n)
                      : copied(read<Array>(x_0, "x_0", "an array"), n, "x_0"));
    refuse_unless(plant != nullptr, "a plant that is made of functions cannot be copied");
    refuse_unless(numbers.is_none() || from.objects().size() == 1,
                  "the numbers are those of one controller");
    std::vector<nb::object> controllers;
    for (const Controller* c : from.loop().controllers())
        controllers.push_back(nb::cast(copied_controller(*c, numbers)));
    return std::make_unique<OwnedLoop>(std::move(controllers),
                                       nb::cast(std::make_unique<OwnedPlant>(std::move(plant))),
                                       from, limit);
}

// Guards, the first step of one (-1: none), reflections, resets and moves into bounds, of all
// controllers together.
nb::tuple counts(OwnedLoop& self) {
    std::int64_t guards = 0, first = -1, reflections = 0, resets = 0, bounded = 0;
    for (const Controller* c : self.loop().controllers()) {
        const Guard& guard = c->update().guard();
        guards += guard.count;
        if (guard.first_step >= 0 && (first < 0 || guard.first_step < first))
            first = guard.first_step;
        reflections += c->reflections(), resets += c->resets(), bounded += c->bounded();
    }
    return nb::make_tuple(guards, first, reflections, resets, bounded);
}

// A job with the arrays that it reads and writes.
class OwnedJob {
public:
    OwnedJob(nb::object loop, Array w, Output u, std::optional<Output> u_applied, Output y, Output z,
             Output theta, std::int64_t stride)
        : loop_object_(loop), w_(w), u_(u), u_applied_(u_applied), y_(y), z_(z), theta_(theta) {
        owner = &object_of<OwnedLoop>(loop, "Loop");
        const Sizes& size = owner->plant().sizes();
        require_range<std::int64_t>(stride, 1, Archive::longest, "stride");
        refuse_unless(u.ndim() > 0, "u has no rows");
        const std::size_t steps = u.shape(0), per_row = static_cast<std::size_t>(stride);
        require_range<std::size_t>(steps, 0, most_steps, "the number of steps");
        require(w.size(), steps * size.l_w, "w");
        require(u.size(), steps * size.l_u, "u");
        require(y.size(), steps * size.l_y, "y");
        require(z.size(), steps * size.l_z, "z");
        if (u_applied) require(u_applied->size(), steps * size.l_u, "u_applied");
        require(theta.size(), (steps + per_row - 1) / per_row * owner->loop().l_theta(), "theta");
        const Record record{u.data(), u_applied ? u_applied->data() : nullptr, y.data(), z.data(),
                            theta.data(), stride};
        rows = static_cast<std::int64_t>(steps);
        job = {&owner->loop(), w.data(), size.l_w, record, rows};
    }

    Job job;
    OwnedLoop* owner = nullptr;
    std::int64_t rows = 0;  // of its arrays

private:
    nb::object loop_object_;
    Array w_;
    Output u_;
    std::optional<Output> u_applied_;
    Output y_, z_, theta_;
};

// Goes on with the jobs for about so many seconds, and at least by one step, in lanes (with that
// instruction set) where they are asked for and the job fits; whether there is anything left to do.
// The results are the same however the work is cut.
bool run_jobs(const std::vector<nb::object>& objects, std::size_t threads, double seconds,
              bool in_lanes, const std::string& set_name) {
    refuse_unless(seconds >= 0.0, "seconds is negative or not a number");
    const TimeBudget budget(seconds);
    const InstructionSet& instructions = instruction_set(set_name.c_str());
    Hold everything;
    std::vector<Job*> jobs;
    for (const nb::object& object : objects) {
        OwnedJob& owned = object_of<OwnedJob>(object, "Job");
        if (owned.job.finished()) continue;
        owned.owner->hold(everything);
        jobs.push_back(&owned.job);
    }
    {
        nb::gil_scoped_release release;
        if (in_lanes)
            run_in_lanes(jobs, threads, budget, instructions);
        else
            in_threads(jobs.size(), threads, [&](std::size_t i) {
                if (i == 0 || !budget.is_over()) jobs[i]->run(budget);
            });
    }
    return std::any_of(jobs.begin(), jobs.end(), [](const Job* job) { return !job->finished(); });
}

}  // namespace

void bind_loop(nb::module_& m) {
    nb::class_<OwnedLoop>(m, "Loop")
        .def(nb::init<const std::vector<nb::object>&, nb::object, const Array&, const Array&,
                      const Array&, double, bool, bool, std::size_t>(),
             nb::kw_only(), nb::arg("controllers"), nb::arg("plant"), nb::arg("low"),
             nb::arg("high"), nb::arg("rate"), nb::arg("limit"), nb::arg("stop_where_unsupported"),
             nb::arg("shared_u"), nb::arg("r_in_w"))
        .def("copy", &copied_loop, nb::arg("limit"), nb::arg("x_0").none() = nb::none(),
             nb::arg("numbers").none() = nb::none())
        .def_prop_ro("controllers", [](const OwnedLoop& self) { return self.objects(); })
        .def_prop_ro("counts", &counts)
        .def("theta_before",
             [](OwnedLoop& self) {
                 const std::vector<double>& theta = self.loop().theta_before();
                 return to_numpy(theta.data(), theta.size());
             })
        .def("save",
             [](OwnedLoop& self) {
                 Hold all;
                 self.hold(all);
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore", [](OwnedLoop& self, const Array& state) {
            Hold all;
            self.hold(all);
            restore(self, copied(state, state.size(), "state"));
        });
    nb::class_<OwnedJob>(m, "Job")
        .def(nb::init<nb::object, Array, Output, std::optional<Output>, Output, Output, Output,
                      std::int64_t>(),
             nb::arg("loop"), nb::arg("w"), nb::arg("u"), nb::arg("u_applied").none(), nb::arg("y"),
             nb::arg("z"), nb::arg("theta"), nb::arg("stride"))
        .def("pause_at",
             [](OwnedJob& self, std::int64_t step) {
                 const Hold hold(self.owner->front());
                 require_range<std::int64_t>(step, self.job.done, self.rows, "the step");
                 self.job.steps = step;
             })
        .def_prop_ro("done", [](const OwnedJob& self) { return self.job.done; })
        .def_prop_ro("outcome",
                     [](const OwnedJob& self) { return static_cast<int>(self.job.outcome); });
    m.def("run_jobs", &run_jobs, nb::arg("jobs"), nb::arg("threads"), nb::arg("seconds"),
          nb::arg("lanes") = false, nb::arg("instruction_set") = "");
}

}  // namespace rcac
