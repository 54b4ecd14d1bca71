// One RCAC controller: regressor, control, target-model filter and update.
#pragma once

#include <functional>
#include <memory>

#include "target_filter.hpp"
#include "update.hpp"

namespace rcac {

// The structure of a controller is nothing but tables of taps: signals 0..l_u-1 are the
// components of u, l_u..l_u+l_y-1 those of y.
struct Structure {
    std::size_t l_u, l_y;
    std::vector<Tap> regressor;  // phi(k), and Phi(k) = phi(k)' (x) I as in (2.30)
    std::vector<Tap> channels;   // what the target-model filter is fed with; u(k) comes first
    std::vector<Tap> filtered;   // phi_f: (channel, delay) for every entry of phi
};

struct Weights {
    double lambda;
    std::vector<double> R_z, R_u;  // l_z x l_z
    // Where set, R_u(k) = R_u_of_z(z(k)).
    std::function<void(const double* z, double* R_u)> R_u_of_z;
};

struct Schedule {
    std::int64_t k_w;       // u = 0 before it (2.29)
    std::int64_t k_update;  // first step of the update
    std::int64_t k_filter;  // the target-model filter sees zero before it
};

class Controller {
public:
    Controller(Structure structure, TargetModel model, Weights weights, Schedule schedule,
               std::unique_ptr<Update> update, std::vector<double> theta)
        : structure_(std::move(structure)),
          weights_(std::move(weights)),
          schedule_(schedule),
          update_(std::move(update)),
          theta_(std::move(theta)),
          signals_(structure_.l_u + structure_.l_y,
                   std::max(longest_delay(structure_.regressor), longest_delay(structure_.channels))),
          filter_(std::move(model), structure_.channels.size(), longest_delay(structure_.filtered)),
          phi_(structure_.regressor.size()),
          Phi_f_(filter_.model().l_z * theta_.size()),
          target_(filter_.model().l_z),
          u_(structure_.l_u) {}

    // A step is begin, then measure and control in the order that the plant's feedthrough
    // allows, then adapt.
    void begin() {
        signals_.advance();
        filter_.advance();
    }

    void measure(const double* y) {
        for (std::size_t i = 0; i < structure_.l_y; ++i) signals_.now(structure_.l_u + i) = y[i];
    }

    // u(k) = Phi(k) theta(k), (2.29).
    const double* control() {
        std::fill(u_.begin(), u_.end(), 0.0);
        if (step_ >= schedule_.k_w)
            for (std::size_t j = 0; j < phi_.size(); ++j) {
                const double tap = signals_(structure_.regressor[j]);
                for (std::size_t i = 0; i < u_.size(); ++i) u_[i] += theta_[j * u_.size() + i] * tap;
            }
        for (std::size_t i = 0; i < u_.size(); ++i) signals_.now(i) = u_[i];
        return u_.data();
    }

    // Filter this step's signals and replace theta(k) by theta(k+1); false where that overflowed.
    bool adapt(const double* z) {
        const bool filtering = step_ >= schedule_.k_filter;
        for (std::size_t c = 0; c < structure_.channels.size(); ++c)
            filter_.filter(c, filtering ? signals_(structure_.channels[c]) : 0.0);
        const bool done = step_ < schedule_.k_update || update(z);
        ++step_;
        return done;
    }

    const std::vector<double>& theta() const { return theta_; }
    const Structure& structure() const { return structure_; }
    std::size_t l_z() const { return filter_.model().l_z; }
    std::int64_t step() const { return step_; }
    const Update& arithmetic() const { return *update_; }
    bool measures_first() const {
        for (const Tap& tap : structure_.regressor)
            if (tap.delay == 0) return true;
        return false;
    }

private:
    bool update(const double* z) {
        const std::size_t l_z = this->l_z(), l_u = structure_.l_u, l_theta = theta_.size();
        for (std::size_t r = 0; r < l_z; ++r) {
            target_[r] = z[r];
            for (std::size_t i = 0; i < l_u; ++i)
                target_[r] -= filter_(i, 0, r, i);
            for (std::size_t j = 0; j < structure_.filtered.size(); ++j) {
                const Tap tap = structure_.filtered[j];
                for (std::size_t i = 0; i < l_u; ++i)
                    Phi_f_[r * l_theta + j * l_u + i] = filter_(tap.source, tap.delay, r, i);
            }
        }
        if (weights_.R_u_of_z) weights_.R_u_of_z(z, weights_.R_u.data());
        const Data data{l_z,           l_theta,
                        Phi_f_.data(), target_.data(),
                        weights_.R_z.data(), weights_.R_u.data(),
                        weights_.lambda};
        return (*update_)(data, step_, theta_.data());
    }

    Structure structure_;
    Weights weights_;
    Schedule schedule_;
    std::unique_ptr<Update> update_;
    std::vector<double> theta_;
    DelayLine signals_;
    TargetFilter filter_;
    std::vector<double> phi_, Phi_f_, target_, u_;
    std::int64_t step_ = 0;
};

}  // namespace rcac
