// One RCAC controller: regressor, control, target-model filter and update.
#pragma once

#include <memory>

#include "controller/pole_reflection.hpp"
#include "controller/regressor.hpp"
#include "updates/update.hpp"

namespace rcac {

// A step is: begin; measure and control in the order that the feedthrough of the plant allows;
// apply; adapt; finish. In the filter form adapt comes before control.
class Controller {
public:
    Controller(ControllerPlan plan, std::unique_ptr<Update> update, std::vector<double> theta)
        : plan_(std::move(plan)),
          update_(std::move(update)),
          theta_(std::move(theta)),
          lambda_(plan_.lambda),
          regressor_(structure()),
          filter_(plan_.targets.at(0), structure().channels.size(),
                  longest_delay(structure().filtered)),
          rules_(plan_.forgetting, plan_.reset, *update_),
          Phi_f_(l_z() * theta_.size()),
          target_(l_z()),
          u_(l_u()),
          R_z_(plan_.R_z.base),
          R_u_(plan_.R_u.base) {
        std::vector<std::size_t> filtered;
        for (std::size_t row = 0; row < l_z(); ++row)
            for (const Tap& tap : structure().filtered)
                for (std::size_t i = 0; i < l_u(); ++i)
                    filtered.push_back(
                        filter_.outputs().offset(filter_.index(tap.source, row, i), tap.delay));
        if (regressor_.size() * l_u() != theta_.size() || filtered.size() != Phi_f_.size())
            throw std::invalid_argument("l_theta does not fit");
        filtered_ = TapReader(std::move(filtered));
    }
    // The regressor refers to the plan.
    Controller(const Controller&) = delete;
    Controller& operator=(const Controller&) = delete;

    void begin() {
        while (next_event_ < events() && event().step <= step_) act(plan_.events[as_size(next_event_++)]);
        signals().advance();
        filter_.advance();
        adapted_ = false;
    }

    void measure(const double* y, const double* r) { regressor_.measure(y, r); }

    // u(k) = Phi(k) theta(k), (2.29).
    const double* control() {
        for (double& u : u_) u = 0.0;
        if (step_ >= plan_.k_w) regressor_.control(theta_, u_);
        apply(u_.data());
        return u_.data();
    }

    // What the actuator made of u(k) takes its place in every later regressor.
    void apply(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) signals().now(i) = u[i];
    }

    // The same one step later, for a device that learns afterwards what was applied; G_f must be
    // strictly proper, so that nothing has used u(k-1) yet.
    void correct_previous(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) {
            signals().before(i) = u[i];
            for (std::size_t c = 0; c < structure().channels.size(); ++c) {
                const Tap& tap = structure().channels[c];
                if (tap.source == i && tap.delay == 0 && step_ > plan_.k_filter)
                    filter_.correct_previous_input(c, u[i]);
            }
        }
    }

    // Filter this step's signals and form its data; false where no update is due.
    bool prepare(const double* z) {
        if (step_ >= plan_.k_filter)
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        filter_.run();
        rules_.see(z, l_z());
        update_->see(z);
        if (step_ < plan_.k_update || frozen_) return false;

        filtered_.read(filter_.outputs().values(), Phi_f_.data());
        for (std::size_t r = 0; r < l_z(); ++r) {
            target_[r] = z[r];
            for (std::size_t i = 0; i < l_u(); ++i)
                target_[r] -= filter_.outputs()(filter_.index(i, r, i), 0);
        }
        if (!plan_.R_z.is_constant() || !plan_.R_u.is_constant()) {
            for (std::size_t i = 0; i < l_u(); ++i) u_[i] = signals()(i, plan_.filter_form ? 1 : 0);
            const double* y = measured(z);
            plan_.R_z.evaluate(step_, y, z, u_.data(), l_z(), R_z_.data());
            plan_.R_u.evaluate(step_, y, z, u_.data(), l_z(), R_u_.data());
        }
        if (rules_.forgets()) lambda_ = rules_.forgetting_factor();
        if (rules_.reset_is_due(step_, plan_.k_update, last_reset_, *update_)) {
            last_reset_ = step_;
            reset_covariance();
        }
        return true;
    }

    Data data() const {
        return {l_z(), theta_.size(), Phi_f_.data(), target_.data(), R_z_.data(), R_u_.data(), lambda_};
    }

    // What follows an update: process noise and pole reflection.
    void conclude() {
        if (!plan_.noise.empty())
            update_->inflate(plan_.noise.data(), plan_.noise.size() / theta_.size());
        if (plan_.reflect_poles && reflect(structure().regressor, theta_, polynomial_))
            ++reflections_;
    }

    // theta(k+1) from theta(k); false where that left the range of float64.
    bool adapt(const double* z) {
        adapted_ = true;
        if (!prepare(z)) return true;
        if (!(*update_)(data(), step_, theta_.data())) return false;
        conclude();
        return true;
    }

    void finish() {
        if (plan_.filter_form && step_ >= plan_.k_filter)  // u(k) was not known to the filter yet
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        ++step_;
    }

    void set_frozen(bool frozen) { frozen_ = frozen; }
    void reset_covariance() {
        update_->reset();
        ++resets_;
    }

    const ControllerPlan& plan() const { return plan_; }
    const Structure& structure() const { return plan_.structure; }
    std::size_t l_u() const { return plan_.structure.l_u; }
    std::size_t l_z() const { return plan_.targets.front().l_z; }
    const std::vector<double>& theta() const { return theta_; }
    std::vector<double>& theta() { return theta_; }
    std::int64_t step() const { return step_; }
    bool adapted() const { return adapted_; }
    bool filter_form() const { return plan_.filter_form; }
    const Update& update() const { return *update_; }
    Update& update() { return *update_; }
    double lambda() const { return lambda_; }
    std::int64_t reflections() const { return reflections_; }
    std::int64_t resets() const { return resets_; }
    bool frozen() const { return frozen_; }
    // For whoever makes its steps elsewhere (lanes/state.hpp).
    History& signals() { return regressor_.signals(); }
    TargetFilter& filter() { return filter_; }
    void has_stepped(std::int64_t steps) { step_ += steps; }
    bool measures_first() const {
        if (plan_.filter_form) return true;
        for (const Tap& tap : structure().regressor)
            if (tap.delay == 0) return true;
        return false;
    }

    void visit(Archive& archive) {
        archive(theta_);
        archive(lambda_);
        archive(step_, 0, Archive::longest);
        archive(next_event_, 0, events());
        archive(reflections_, 0, Archive::longest);
        archive(resets_, 0, Archive::longest);
        archive(last_reset_, -1, Archive::longest);
        archive(target_number_, 0, static_cast<std::int64_t>(plan_.targets.size()) - 1);
        archive(frozen_);
        if (archive.reading()) filter_.replace(plan_.targets.at(as_size(target_number_)));
        signals().visit(archive);
        filter_.visit(archive);
        rules_.visit(archive);
        update_->visit(archive);
    }

private:
    static std::size_t as_size(std::int64_t i) { return static_cast<std::size_t>(i); }
    std::int64_t events() const { return static_cast<std::int64_t>(plan_.events.size()); }
    const Event& event() const { return plan_.events[as_size(next_event_)]; }

    void act(const Event& event) {
        switch (event.kind) {
            case Event::freeze: frozen_ = true; break;
            case Event::resume: frozen_ = false; break;
            case Event::reset: reset_covariance(); break;
            case Event::forgetting: lambda_ = event.value; break;
            case Event::target:
                target_number_ = static_cast<std::int64_t>(event.index);
                filter_.replace(plan_.targets.at(event.index));
                break;
        }
    }

    // y(k) in one piece, for weights that are functions of it.
    const double* measured(const double* otherwise) {
        y_.resize(structure().l_y);
        for (std::size_t i = 0; i < y_.size(); ++i) y_[i] = signals()(l_u() + i, 0);
        return y_.empty() ? otherwise : y_.data();
    }

    ControllerPlan plan_;
    std::unique_ptr<Update> update_;
    std::vector<double> theta_;
    double lambda_;
    Regressor regressor_;
    TargetFilter filter_;
    PerformanceRules rules_;
    bool frozen_ = false, adapted_ = false;
    TapReader filtered_;
    std::vector<double> Phi_f_, target_, u_, R_z_, R_u_, y_, polynomial_;
    std::int64_t step_ = 0, next_event_ = 0, reflections_ = 0, resets_ = 0, last_reset_ = -1,
                 target_number_ = 0;
};

}  // namespace rcac
