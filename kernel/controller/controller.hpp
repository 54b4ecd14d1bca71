// One RCAC controller: regressor, control, target-model filter and update.
#pragma once

#include <memory>

#include "controller/cost_rows.hpp"
#include "controller/pole_reflection.hpp"
#include "controller/regressor.hpp"
#include "controller/stored_signals.hpp"
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
          remembered_(plan_.k_update < Archive::longest ? remembered_steps : 0),
          regressor_(structure(), remembered_ > 0 ? remembered_ + plan_.targets.at(0).order : 0),
          filter_(plan_.targets.at(0), structure().channels.size(), longest_delay(structure().filtered)),
          model_(plan_.targets, sources_of(structure()), regressor_.signals().depth()),
          performance_(l_z(), remembered_),
          rules_(plan_.forgetting, plan_.reset, *update_),
          rows_(plan_, l_z(), theta_.size()),
          bounds_(plan_.bounds, theta_.size()),
          fixed_(plan_.fixed, l_u(), structure().l_y + structure().l_r),
          u_(l_u()) {
        place_taps();
        if (regressor_.size() * l_u() != theta_.size() || filtered_.size() != rows_.size_of_Phi_f())
            throw std::invalid_argument("l_theta does not fit");
    }
    // The regressor refers to the plan.
    Controller(const Controller&) = delete;
    Controller& operator=(const Controller&) = delete;

    void begin() {
        while (next_event_ < events() && event().step <= step_) act(plan_.events[as_size(next_event_++)]);
        signals().advance();
        filter_.advance();
        performance_.advance();
        fixed_.advance();
        adapted_ = false;
    }

    void measure(const double* y, const double* r) {
        regressor_.measure(y, r);
        if (!fixed_.is_there()) return;
        for (std::size_t i = 0; i < structure().l_y; ++i) fixed_.measure(i, y[i]);
        for (std::size_t i = 0; i < structure().l_r; ++i) fixed_.measure(structure().l_y + i, r[i]);
    }

    // u(k) = Phi(k) theta(k), (2.29), and what a fixed compensator beside it adds.
    const double* control() {
        for (double& u : u_) u = 0.0;
        if (step_ >= plan_.k_w) regressor_.control(theta_, u_);
        if (plan_.dither.is_on())
            for (std::size_t i = 0; i < l_u(); ++i) u_[i] += plan_.dither(step_, i);
        for (std::size_t i = 0; i < l_u(); ++i) signals().now(i) = u_[i];
        fixed_.add_to(u_.data());
        return u_.data();
    }

    // What the actuator made of u(k), without the fixed part, takes its place in every later
    // regressor.
    void apply(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) signals().now(i) = u[i] - fixed_.now(i);
    }

    // The same one step later, for a device that learns afterwards what was applied; G_f must be
    // strictly proper, so that nothing has used u(k-1) yet.
    void correct_previous(const double* u) {
        for (std::size_t i = 0; i < l_u(); ++i) {
            const double own = u[i] - fixed_.before(i);
            signals().before(i) = own;
            for (std::size_t c = 0; c < structure().channels.size(); ++c) {
                const Tap& tap = structure().channels[c];
                if (tap.source == i && tap.delay == 0 && step_ > plan_.k_filter)
                    filter_.correct_previous_input(c, own);
            }
        }
    }

    // Filter this step's signals and form its data; false where no update is due.
    bool prepare(const double* z) {
        if (step_ >= plan_.k_filter)
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        filter_.run();
        for (std::size_t i = 0; i < l_z(); ++i) performance_.now(i) = z[i];
        rules_.see(z, l_z());
        update_->see(z);
        if (step_ < plan_.k_update || frozen_) return false;

        filtered_.read(filter_.outputs().values(), rows_.Phi_f());
        for (std::size_t r = 0; r < l_z(); ++r) {
            rows_.set_target(r, z[r]);
            for (std::size_t i = 0; i < l_u(); ++i)
                rows_.target()[r] -= filter_.outputs()(filter_.index(i, r, i), 0);
        }
        rows_.penalise(regressor_, 0);
        rows_.weigh(z, signals(), step_, 0);
        if (rules_.forgets()) lambda_ = rules_.forgetting_factor();
        if (rules_.reset_is_due(step_, plan_.k_update, last_reset_, *update_)) {
            last_reset_ = step_;
            reset_covariance();
        }
        return true;
    }

    // What follows an update: process noise, pole reflection and bounds.
    void conclude() {
        if (!plan_.noise.empty())
            update_->inflate(plan_.noise.data(), plan_.noise.size() / theta_.size());
        if (plan_.reflect_poles && reflect(structure().regressor, theta_, polynomial_))
            ++reflections_;
        if (bounds_.are_there() && bounds_.apply(*update_, theta_)) ++bounded_;
    }

    // theta(k+1) from theta(k); false where that left the range of float64.
    bool adapt(const double* z) {
        adapted_ = true;
        if (!prepare(z)) return true;
        if (!(*update_)(rows_.data(lambda_), step_, theta_.data())) return false;
        conclude();
        return true;
    }

    void finish() {
        if (plan_.filter_form && step_ >= plan_.k_filter)  // u(k) was not known to the filter yet
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        ++step_;
    }

    // Between two steps: G_f from the next step on, and as if it had filtered what is remembered.
    // theta stays. Nothing is allocated where the order is not above that of the models before.
    // False where a replay left the range of float64.
    bool set_target(const TargetModel& model, Past past) {
        if (model.order > filter_.order()) resize_filter(model.order);
        const bool replays = past == Past::replay;
        model_.take(model, signals(), replays ? signals().depth()
                                              : filter_.outputs().depth() + regressor_.reach());
        filter_.replace(model);
        refill_outputs(filter_, model_.past(), structure());
        if (past == Past::reset || replays) reset_covariance();
        if (past == Past::blend) update_->doubt_past(model_.rho());
        return !replays || replay();
    }
    const CurrentTarget& target() const { return model_; }
    std::size_t longest_order() const { return signals().depth() - 1 - regressor_.reach(); }

    void set_lambda(double lambda) { lambda_ = lambda; }
    CostRows& rows() { return rows_; }
    const CostRows& rows() const { return rows_; }
    // Whether the plan no longer says what this controller does.
    bool has_left_its_plan() const { return model_.is_own() || rows_.has_left_its_plan(); }

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
    std::int64_t bounded() const { return bounded_; }
    bool frozen() const { return frozen_; }
    // For whoever makes its steps elsewhere (lanes/state.hpp).
    History& signals() { return regressor_.signals(); }
    const History& signals() const { return regressor_.signals(); }
    std::size_t reach() const { return regressor_.reach(); }
    History& performance() { return performance_; }
    TargetFilter& filter() { return filter_; }
    void has_stepped(std::int64_t steps) { step_ += steps; }
    bool measures_first() const {
        if (plan_.filter_form || fixed_.is_direct()) return true;
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
        archive(bounded_, 0, Archive::longest);
        archive(frozen_);
        auto order = static_cast<std::int64_t>(filter_.order());
        archive(order, 0, static_cast<std::int64_t>(longest_order()));
        if (archive.reading() && as_size(order) != filter_.order()) resize_filter(as_size(order));
        model_.visit(archive, filter_.order());
        if (archive.reading()) filter_.replace(model_.model());
        rows_.visit(archive);
        fixed_.visit(archive);
        signals().visit(archive);
        performance_.visit(archive);
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
                filter_.replace(model_.take_planned(event.index));
                break;
        }
    }

    void place_taps() {
        std::vector<std::size_t> filtered;
        for (std::size_t row = 0; row < l_z(); ++row)
            for (const Tap& tap : structure().filtered)
                for (std::size_t i = 0; i < l_u(); ++i)
                    filtered.push_back(
                        filter_.outputs().offset(filter_.index(tap.source, row, i), tap.delay));
        filtered_ = TapReader(std::move(filtered));
    }

    void resize_filter(std::size_t order) {
        TargetModel room{l_z(), l_u(), order, std::vector<double>((order + 1) * l_z() * l_u()),
                         std::vector<double>((order + 1) * l_z() * l_z())};
        filter_ = TargetFilter(room, structure().channels.size(),
                               longest_delay(structure().filtered));
        refill_inputs(filter_, signals(), structure());
        place_taps();
    }

    // The remembered steps at which an update was due, once more.
    bool replay() {
        const std::int64_t known = std::min(step_ - plan_.k_update,
                                            static_cast<std::int64_t>(remembered_));
        std::vector<double> z(l_z());
        --step_;  // the last step, as weights that are functions know it
        bool fine = true;
        for (std::int64_t age = known; fine && age-- > 0;) {
            for (std::size_t i = 0; i < z.size(); ++i) z[i] = performance_(i, as_size(age));
            for (std::size_t i = 0; i < z.size(); ++i) rows_.set_target(i, z[i]);
            data_of_age(model_.past(), structure(), as_size(age), rows_.Phi_f(), rows_.target());
            rows_.penalise(regressor_, as_size(age));
            rows_.weigh(z.data(), signals(), step_, as_size(age));
            fine = (*update_)(rows_.data(lambda_), step_ - age, theta_.data());
            if (fine) conclude();
        }
        ++step_;
        return fine;
    }

    ControllerPlan plan_;
    std::unique_ptr<Update> update_;
    std::vector<double> theta_;
    double lambda_;
    std::size_t remembered_;
    Regressor regressor_;
    TargetFilter filter_;
    CurrentTarget model_;
    History performance_;  // z
    PerformanceRules rules_;
    bool frozen_ = false, adapted_ = false;
    TapReader filtered_;
    CostRows rows_;
    CoefficientBounds bounds_;
    FixedPart fixed_;
    std::vector<double> u_, polynomial_;
    std::int64_t step_ = 0, next_event_ = 0, reflections_ = 0, resets_ = 0, bounded_ = 0,
                 last_reset_ = -1;
};

}  // namespace rcac
