// Plant, actuator and controllers in a loop.
#pragma once

#include "plants/actuator.hpp"
#include "controller/controller.hpp"
#include "plants/plant.hpp"

namespace rcac {

enum class Outcome : int {
    completed,
    diverged,         // a signal, a state or a coefficient exceeded the limit
    overflow,         // the update left the range of float64
    plant_not_finite, // the plant returned a NaN or an infinity
    plant_failed,     // a function of the plant failed
    unsupported,      // an update was decided by rounding, and the run was to end there
};

// Where the run is written: arrays of `steps` rows; theta has a row for every `stride` steps,
// row j holding theta(j * stride), the coefficients that made u(j * stride). u is what the
// controllers asked for, u_applied (may be null) what the actuator made of it.
struct Record {
    double *u, *u_applied, *y, *z, *theta;
    std::int64_t stride;
};

struct LoopOptions {
    double limit;
    bool stop_where_unsupported;
    bool shared_u;          // several controllers: each one's regressor holds the sum, not its own u
    std::size_t r_in_w;     // where the command begins in w
};

inline bool within(const double* values, std::size_t count, double limit) {
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) all &= std::fabs(values[i]) <= limit;  // NaN: false
    return all;
}

class Loop {
public:
    Loop(std::vector<Controller*> controllers, Plant& plant, Actuator& actuator,
         const LoopOptions& options)
        : controllers_(std::move(controllers)),
          plant_(plant),
          actuator_(actuator),
          options_(options),
          u_a_(plant.sizes().l_u) {
        for (const Controller* c : controllers_) {
            y_first_ = y_first_ || c->measures_first();
            adapt_first_ = adapt_first_ || c->filter_form();
            l_theta_ += c->theta().size();
        }
        theta_before_.resize(l_theta_);
    }

    // Step k of the record up to the point where the predictor's update is due.
    Outcome move(std::int64_t row, const double* w, const Record& record) {
        const Sizes& size = plant_.sizes();
        double *u = record.u + row * static_cast<std::int64_t>(size.l_u),
               *y = record.y + row * static_cast<std::int64_t>(size.l_y);
        z_ = record.z + row * static_cast<std::int64_t>(size.l_z);
        const double* r = w + options_.r_in_w;
        keep_theta(theta_before_.data(), 0);
        for (Controller* c : controllers_) c->begin();
        if (!plant_.begin(controllers_.front()->step(), w)) return Outcome::plant_failed;
        if (y_first_) {
            // Before u(k) is known it acts on nothing: an order that needs it was refused.
            std::fill(u_a_.begin(), u_a_.end(), 0.0);
            plant_.receive(u_a_.data());
            if (!plant_.y(y)) return Outcome::plant_failed;
            for (Controller* c : controllers_) c->measure(y, r);
        }
        if (adapt_first_) {
            if (!plant_.z(z_)) return Outcome::plant_failed;
            if (!finite(z_, size.l_z) || !finite(y, size.l_y)) return Outcome::plant_not_finite;
            for (Controller* c : controllers_)
                if (c->filter_form() && !c->adapt(z_)) return Outcome::overflow;
        }
        // After the update of the filter form: these coefficients make u(k).
        if (row == 0) next_kept_ = 0;
        if (row == next_kept_) {
            keep_theta(record.theta, row / record.stride);
            next_kept_ += record.stride;
        }
        copy_few(controllers_.front()->control(), size.l_u, u);
        for (std::size_t number = 1; number < controllers_.size(); ++number) {
            const double* own = controllers_[number]->control();
            for (std::size_t i = 0; i < size.l_u; ++i) u[i] += own[i];
        }
        copy_few(actuator_.apply(u), size.l_u, u_a_.data());
        if (!actuator_.is_ideal() || (options_.shared_u && controllers_.size() > 1)) {
            const bool as_asked = std::equal(u_a_.begin(), u_a_.end(), u);
            for (Controller* c : controllers_) c->apply(u_a_.data(), as_asked);
        }
        if (record.u_applied)
            std::copy(u_a_.begin(), u_a_.end(),
                      record.u_applied + row * static_cast<std::int64_t>(size.l_u));
        plant_.receive(u_a_.data());
        if (!y_first_) {
            if (!plant_.y(y)) return Outcome::plant_failed;
            for (Controller* c : controllers_) c->measure(y, r);
        }
        if (!plant_.z(z_)) return Outcome::plant_failed;
        if (within(u, size.l_u, options_.limit) && within(y, size.l_y, options_.limit) &&
            within(z_, size.l_z, options_.limit))
            return Outcome::completed;
        const bool of_the_plant = finite(u, size.l_u) && finite_state() &&
                                  !(finite(y, size.l_y) && finite(z_, size.l_z));
        return of_the_plant ? Outcome::plant_not_finite : Outcome::diverged;
    }

    Outcome adapt() {
        for (Controller* c : controllers_)
            if (!c->adapted() && !c->adapt(z_)) return Outcome::overflow;
        return Outcome::completed;
    }

    Outcome finish() {
        for (Controller* c : controllers_) {
            c->finish();
            if (!within(c->theta().data(), c->theta().size(), options_.limit))
                return Outcome::diverged;
            if (options_.stop_where_unsupported && c->update().guard().count > 0)
                return Outcome::unsupported;
        }
        if (!plant_.advance()) return Outcome::plant_failed;
        if (within(plant_.x().data(), plant_.x().size(), options_.limit)) return Outcome::completed;
        return finite_state() ? Outcome::diverged : Outcome::plant_not_finite;
    }

    // For whoever makes its steps elsewhere (lanes/state.hpp): one failed, after these coefficients.
    void has_failed(const std::vector<double>& theta_before) { theta_before_ = theta_before; }

    Plant& plant() { return plant_; }
    const Actuator& actuator() const { return actuator_; }
    const LoopOptions& options() const { return options_; }
    const std::vector<Controller*>& controllers() const { return controllers_; }
    // The coefficients at the beginning of the last step, which are valid where it failed.
    const std::vector<double>& theta_before() const { return theta_before_; }
    std::size_t l_theta() const { return l_theta_; }

private:
    bool finite_state() const { return finite(plant_.x().data(), plant_.x().size()); }

    void keep_theta(double* kept, std::int64_t row) const {
        double* place = kept + row * static_cast<std::int64_t>(l_theta_);
        for (const Controller* c : controllers_)
            place = std::copy(c->theta().begin(), c->theta().end(), place);
    }

    std::vector<Controller*> controllers_;
    Plant& plant_;
    Actuator& actuator_;
    LoopOptions options_;
    std::vector<double> u_a_, theta_before_;
    std::size_t l_theta_ = 0;
    double* z_ = nullptr;
    std::int64_t next_kept_ = 0;
    bool y_first_ = false, adapt_first_ = false;
};

}  // namespace rcac
