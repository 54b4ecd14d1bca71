// One RCAC controller: regressor, control, target-model filter and update.
#pragma once

#include <memory>

#include "controller/plan.hpp"
#include "controller/pole_reflection.hpp"
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
          signals_(structure().signals(), std::max<std::size_t>(
                       {longest_delay(structure().regressor), longest_delay(structure().channels), 1})),
          filter_(plan_.targets.at(0), structure().channels.size(),
                  longest_delay(structure().filtered)),
          power_(std::max(plan_.forgetting.long_window,
                          plan_.reset.growth > 0.0 ? plan_.reset.long_window : 0)),
          watches_power_(plan_.forgetting.long_window > 0 || plan_.reset.growth > 0.0),
          Phi_f_(l_z() * theta_.size()),
          target_(l_z()),
          u_(l_u()),
          R_z_(plan_.R_z.base),
          R_u_(plan_.R_u.base) {
        std::vector<std::size_t> regressor, filtered;
        for (const Tap& tap : structure().regressor)
            regressor.push_back(signals_.offset(tap.source, tap.delay));
        for (std::size_t row = 0; row < l_z(); ++row)
            for (const Tap& tap : structure().filtered)
                for (std::size_t i = 0; i < l_u(); ++i)
                    filtered.push_back(
                        filter_.outputs().offset(filter_.index(tap.source, row, i), tap.delay));
        if (regressor.size() * l_u() != theta_.size() || filtered.size() != Phi_f_.size())
            throw std::invalid_argument("l_theta does not fit");
        regressor_ = TapReader(std::move(regressor));
        filtered_ = TapReader(std::move(filtered));
        phi_.resize(regressor_.size());
        initial_trace_ = update_->trace();
    }

    void begin() {
        while (next_event_ < events() && event().step <= step_) act(plan_.events[as_size(next_event_++)]);
        signals_.advance();
        filter_.advance();
        adapted_ = false;
    }

    void measure(const double* y, const double* r) {
        const std::size_t first = l_u(), l_y = structure().l_y, l_r = structure().l_r;
        for (std::size_t i = 0; i < l_y; ++i) signals_.now(first + i) = y[i];
        for (std::size_t i = 0; i < l_r; ++i) signals_.now(first + l_y + i) = r[i];
        std::size_t number = first + l_y + l_r;
        for (const DerivedSignal& signal : structure().derived) {
            double value = signal.pole * signals_.before(number);
            for (std::size_t i = 0; i < l_y + l_r; ++i)
                value += signal.now[i] * signals_.now(first + i) +
                         signal.before[i] * signals_.before(first + i);
            signals_.now(number++) = value;
        }
    }

    // u(k) = Phi(k) theta(k), (2.29).
    const double* control() {
        const std::size_t l_u = this->l_u();
        for (double& u : u_) u = 0.0;
        if (step_ >= plan_.k_w) {
            regressor_.read(signals_.values(), phi_.data());
            if (l_u == 1)
                u_[0] = answer();
            else
                for (std::size_t j = 0; j < phi_.size(); ++j)
                    for (std::size_t i = 0; i < l_u; ++i) u_[i] += theta_[j * l_u + i] * phi_[j];
        }
        apply(u_.data());
        return u_.data();
    }

    // What the actuator made of u(k) takes its place in every later regressor.
    void apply(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) signals_.now(i) = u[i];
    }

    // The same one step later, for a device that learns afterwards what was applied; G_f must be
    // strictly proper, so that nothing has used u(k-1) yet.
    void correct_previous(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) {
            signals_.before(i) = u[i];
            for (std::size_t c = 0; c < structure().channels.size(); ++c) {
                const Tap& tap = structure().channels[c];
                if (tap.source == i && tap.delay == 0 && step_ > plan_.k_filter)
                    filter_.previous_input(c) = u[i];
            }
        }
    }

    // Filter this step's signals and form its data; false where no update is due.
    bool prepare(const double* z) {
        if (step_ >= plan_.k_filter)
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals_(structure().channels[c]);
        filter_.run();
        if (watches_power_) power_.add(z, l_z());
        if (step_ < plan_.k_update || frozen_) return false;

        filtered_.read(filter_.outputs().values(), Phi_f_.data());
        for (std::size_t r = 0; r < l_z(); ++r) {
            target_[r] = z[r];
            for (std::size_t i = 0; i < l_u(); ++i)
                target_[r] -= filter_.outputs()(filter_.index(i, r, i), 0);
        }
        if (!plan_.R_z.is_constant() || !plan_.R_u.is_constant()) {
            for (std::size_t i = 0; i < l_u(); ++i) u_[i] = signals_(i, plan_.filter_form ? 1 : 0);
            const double* y = measured(z);
            plan_.R_z.evaluate(step_, y, z, u_.data(), l_z(), R_z_.data());
            plan_.R_u.evaluate(step_, y, z, u_.data(), l_z(), R_u_.data());
        }
        if (plan_.forgetting.long_window > 0) {
            const ForgettingRule& rule = plan_.forgetting;
            const double excess = power_.growth(rule.short_window, rule.long_window) - 1.0;
            lambda_ = std::max(rule.smallest, 1.0 / (1.0 + rule.gain * std::max(0.0, excess)));
        }
        if (reset_is_due()) {
            update_->reset();
            ++resets_;
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
                filter_.input(c) = signals_(structure().channels[c]);
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
    History& signals() { return signals_; }
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
        archive(reflections_);
        archive(resets_);
        archive(last_reset_, -1, Archive::longest);
        archive(target_number_, 0, static_cast<std::int64_t>(plan_.targets.size()) - 1);
        archive(frozen_);
        if (archive.reading()) filter_.replace(plan_.targets.at(as_size(target_number_)));
        signals_.visit(archive);
        filter_.visit(archive);
        power_.visit(archive);
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

    bool reset_is_due() {
        const ResetRule& rule = plan_.reset;
        const std::int64_t age = step_ - std::max(plan_.k_update, last_reset_);
        const bool due =
            (rule.every > 0 && age > 0 && (step_ - plan_.k_update) % rule.every == 0) ||
            (rule.trace_below > 0.0 && update_->trace() < rule.trace_below * initial_trace_) ||
            (rule.growth > 0.0 && age >= static_cast<std::int64_t>(rule.long_window) &&
             power_.growth(rule.short_window, rule.long_window) > rule.growth);
        if (due) last_reset_ = step_;
        return due;
    }

    // phi(k)' theta, in four sums, because one would wait for each addition before the next.
    double answer() const {
        const double *theta = theta_.data(), *phi = phi_.data();
        double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
        std::size_t j = 0;
        for (; j + 4 <= phi_.size(); j += 4) {
            a += theta[j] * phi[j];
            b += theta[j + 1] * phi[j + 1];
            c += theta[j + 2] * phi[j + 2];
            d += theta[j + 3] * phi[j + 3];
        }
        for (; j < phi_.size(); ++j) a += theta[j] * phi[j];
        return (a + b) + (c + d);
    }

    // y(k) in one piece, for weights that are functions of it.
    const double* measured(const double* otherwise) {
        y_.resize(structure().l_y);
        for (std::size_t i = 0; i < y_.size(); ++i) y_[i] = signals_(l_u() + i, 0);
        return y_.empty() ? otherwise : y_.data();
    }

    ControllerPlan plan_;
    std::unique_ptr<Update> update_;
    std::vector<double> theta_;
    double lambda_;
    History signals_;
    TargetFilter filter_;
    RecentPower power_;
    bool watches_power_, frozen_ = false, adapted_ = false;
    TapReader regressor_, filtered_;
    std::vector<double> phi_, Phi_f_, target_, u_, R_z_, R_u_, y_, polynomial_;
    double initial_trace_ = 0.0;
    std::int64_t step_ = 0, next_event_ = 0, reflections_ = 0, resets_ = 0, last_reset_ = -1,
                 target_number_ = 0;
};

}  // namespace rcac
