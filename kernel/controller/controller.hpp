// One RCAC controller: regressor, control, target-model filter and update.
#pragma once

#include <memory>

#include "controller/cost_rows.hpp"
#include "controller/pole_reflection.hpp"
#include "controller/regressor.hpp"
#include "controller/stored_signals.hpp"
#include "plants/actuator.hpp"
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
          supervisor_(plan_.supervision, theta_),
          fallback_(plan_.supervision.fallback_plan, l_u(), structure().l_y + structure().l_r),
          limits_(plan_.low, plan_.high, plan_.rise, plan_.fall),
          u_(l_u()),
          held_(l_u()),
          last_(l_u()),
          bump_(l_u()) {
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
        fallback_.advance();
        adapted_ = false;
    }

    void measure(const double* y, const double* r) {
        regressor_.measure(y, r);
        for (FixedPart* part : {&fixed_, &fallback_}) {
            if (!part->is_there()) continue;
            for (std::size_t i = 0; i < structure().l_y; ++i) part->measure(i, y[i]);
            for (std::size_t i = 0; i < structure().l_r; ++i)
                part->measure(structure().l_y + i, r[i]);
        }
    }

    // u(k) = Phi(k) theta(k), (2.29), and what a fixed compensator beside it adds.
    const double* control() {
        for (double& u : u_) u = 0.0;
        if (step_ >= plan_.k_w) regressor_.control(theta_, u_);
        if (plan_.dither.is_on())
            for (std::size_t i = 0; i < l_u(); ++i) u_[i] += plan_.dither(step_, i);
        for (std::size_t i = 0; i < l_u(); ++i) signals().now(i) = u_[i];
        if (fixed_.is_there()) fixed_.add_to(u_.data());
        if (fallback_.is_there() || hands_over_ || !limits_.is_ideal()) conduct();
        held_ = u_;
        return u_.data();
    }

    // u(k) = u(k-1), or that of the fallback, where y(k) is not known.
    const double* hold() {
        const bool runs_fallback = plan_.supervision.fallback_where_missed && !in_fallback_;
        if (!runs_fallback && !in_fallback_) {
            const std::vector<double> before = held_;
            control();
            u_ = before;
            take_the_place(u_.data());
            return u_.data();
        }
        if (runs_fallback) switch_fallback(true);
        control();
        if (runs_fallback) switch_fallback(false);
        return u_.data();
    }

    // What the actuator made of u(k), without the fixed part, takes its place in every later
    // regressor.
    void apply(const double* u, bool as_asked) {
        supervisor_.see_actuator(as_asked, step_);
        take_the_place(u);
    }

    // The same one step later, for a device that learns afterwards what was applied; G_f must be
    // strictly proper, so that nothing has used u(k-1) yet.
    void correct_previous(const double* u) {
        supervisor_.see_actuator(std::equal(u, u + l_u(), held_.begin()), step_ - 1);
        std::copy_n(u, l_u(), held_.begin());
        limits_.start_from(u);
        for (std::size_t i = 0; i < l_u(); ++i) {
            fallback_.replace_before(i, u[i]);
            const double own = u[i] - fixed_.before(i);
            signals().before(i) = own;
            for (std::size_t c = 0; c < structure().channels.size(); ++c) {
                const Tap& tap = structure().channels[c];
                if (tap.source == i && tap.delay == 0 && step_ > plan_.k_filter)
                    filter_.correct_previous_input(c, own);
            }
        }
    }

    // Filter this step's signals, and remember z.
    void take_in(const double* z) {
        if (step_ >= plan_.k_filter)
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        filter_.run();
        for (std::size_t i = 0; i < l_z(); ++i) performance_.now(i) = z[i];
        rules_.see(z, l_z());
        update_->see(z);
    }

    // Form this step's data; false where no update is due.
    bool prepare(const double* z) {
        take_in(z);
        if (step_ < plan_.k_update || frozen_ || stopped_ || in_fallback_) return false;

        filtered_.read(filter_.outputs().values(), rows_.Phi_f());
        for (std::size_t r = 0; r < l_z(); ++r) {
            rows_.set_target(r, z[r]);
            for (std::size_t i = 0; i < l_u(); ++i)
                rows_.target()[r] -= filter_.outputs()(filter_.index(i, r, i), 0);
        }
        if (rows_.penalises()) rows_.penalise(regressor_, 0);
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
        if (bounds_.are_there() && !keeps_bounds()) move_into_bounds();
    }
    bool keeps_bounds() { return bounds_.contain(theta_); }
    void move_into_bounds() {
        bounds_.apply(*update_, theta_);
        ++bounded_;
    }
    Ellipsoid& ellipsoid() { return bounds_.ellipsoid(); }

    // theta(k+1) from theta(k); false where that left the range of float64.
    bool adapt(const double* z) {
        adapted_ = true;
        if (supervisor_.is_on() && supervisor_.is_beyond_limit(z, l_z(), step_)) respond();
        if (!prepare(z)) return true;
        if (!(*update_)(rows_.data(lambda_), step_, theta_.data())) return recovers();
        conclude();
        return true;
    }
    // The same where z(k) is not known: signals move on, theta stays.
    void pass_by() {
        adapted_ = true;
        z_.resize(l_z());
        for (std::size_t i = 0; i < z_.size(); ++i) z_[i] = performance_.before(i);
        take_in(z_.data());
    }

    void finish() {
        if (plan_.filter_form && step_ >= plan_.k_filter)  // u(k) was not known to the filter yet
            for (std::size_t c = 0; c < structure().channels.size(); ++c)
                filter_.input(c) = signals()(structure().channels[c]);
        ++step_;
        if (supervisor_.is_on() && Supervisor::is_due(step_)) {
            if (supervisor_.is_wound_up(*update_, step_ - 1)) respond();
            if (bounds_.ellipsoid().is_there())
                supervisor_.see_radius(bounds_.ellipsoid().radius(theta_));
            if (keeps_going()) supervisor_.keep(theta_);
        }
    }

    // A whole step of a device, whose plant must not be left without a u. What is not known of y, z
    // and r is not a number, and is replaced by what was known last. False where the update failed
    // and nobody is to recover.
    bool step(double* y, double* z, double* r, const double* applied) {
        is_live_ = true;
        begin();
        if (applied)
            correct_previous(applied);
        else
            supervisor_.see_actuator(true, step_);
        const History& known = signals();
        bool y_missed = false, z_missed = false;
        if (supervisor_.is_on() && finite(z, l_z()) && supervisor_.jumps(z, l_z(), step_)) {
            y_missed = z_missed = true;
            for (std::size_t i = 0; i < structure().l_y; ++i) y[i] = known(l_u() + i, 1);
        }
        for (std::size_t i = 0; i < structure().l_y + structure().l_r; ++i) {
            double& value = i < structure().l_y ? y[i] : r[i - structure().l_y];
            if (std::isfinite(value)) continue;
            y_missed = true;
            value = known(l_u() + i, 1);
        }
        z_missed = z_missed || !finite(z, l_z());
        if (y_missed || z_missed) supervisor_.note(Trouble::missed, step_, 1.0);
        measure(y, r);
        bool done = true;
        if (filter_form()) z_missed ? pass_by() : void(done = adapt(z));
        y_missed ? hold() : control();
        if (supervisor_.is_on() && !finite(u_.data(), u_.size())) {
            recovers();
            u_ = last_;
            take_the_place(u_.data());
        }
        if (!adapted_) z_missed ? pass_by() : void(done = adapt(z));
        last_ = u_;
        finish();
        return done;
    }
    const std::vector<double>& u() const { return u_; }

    // Ends what the supervisor began; the controller goes on from P(0), without a bump.
    void resume_from_trouble() {
        if (!stopped_ && !in_fallback_) return;
        if (in_fallback_) hands_over_ = takes_up_ = true;
        stopped_ = in_fallback_ = false;
        reset_covariance();
        supervisor_.note(Trouble::to_adaptive, step_, 0.0);
    }
    // Another controller ran the plant up to here, and u was the last that it applied: what this one
    // asks for differs from that by a bump, of which `fade` is left from step to step.
    void take_over(const double* u, double fade) {
        std::copy_n(u, l_u(), held_.begin());
        limits_.start_from(u);
        fade_ = fade;
        hands_over_ = takes_up_ = true;
    }
    const Supervisor& supervisor() const { return supervisor_; }
    Supervisor& supervisor() { return supervisor_; }
    bool stopped() const { return stopped_; }
    bool in_fallback() const { return in_fallback_; }
    bool has_limits() const { return !limits_.is_ideal(); }
    void has_applied(const double* u) { std::copy_n(u, l_u(), held_.begin()); }

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
        std::int64_t format = archive_format;
        archive(format);
        if (format != archive_format)
            throw std::invalid_argument(
                "it was saved in another format than this version reads; run again from the start");
        archive(theta_);
        archive(lambda_);
        archive(step_, 0, Archive::longest);
        archive(next_event_, 0, events());
        archive(reflections_, 0, Archive::longest);
        archive(resets_, 0, Archive::longest);
        archive(last_reset_, -1, Archive::longest);
        archive(bounded_, 0, Archive::longest);
        if (bounds_.ellipsoid().is_there()) archive(supervisor_.worst_radius());
        archive(frozen_);
        archive(stopped_);
        archive(in_fallback_);
        archive(hands_over_);
        archive(takes_up_);
        archive(fade_);
        archive(held_);
        archive(last_);
        archive(bump_);
        limits_.visit(archive);
        supervisor_.visit(archive);
        fallback_.visit(archive);
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
    // Of what `visit` writes; 1 had no number at its head.
    static constexpr std::int64_t archive_format = 2;

    // Whether an overflow is survived: on a device wherever there is supervision, in a run only
    // where a policy was chosen, because there the overflow is what the run came to.
    bool keeps_going() const {
        return supervisor_.acts() || (is_live_ && supervisor_.is_on());
    }

    bool recovers() {
        if (!keeps_going()) return false;
        supervisor_.note(Trouble::overflow, step_, 0.0);
        theta_ = supervisor_.good();
        reset_covariance();
        signals().mend();
        performance_.mend();
        filter_.mend();
        fixed_.mend();
        fallback_.mend();
        supervisor_.note(Trouble::restored, step_, 0.0);
        respond();
        return true;
    }

    void respond() {
        const auto note = [this](Trouble::Kind kind) { supervisor_.note(kind, step_, 0.0); };
        switch (plan_.supervision.policy) {
            case SupervisionPlan::off:
            case SupervisionPlan::warn: return;
            case SupervisionPlan::freeze:
                if (!stopped_) note(Trouble::frozen);
                stopped_ = true;
                return;
            case SupervisionPlan::bound:
                update_->bound(plan_.supervision.growth);
                return note(Trouble::bounded);
            case SupervisionPlan::reset:
                reset_covariance();
                return note(Trouble::reset);
            case SupervisionPlan::fallback:
                if (!in_fallback_) note(Trouble::to_fallback);
                if (!in_fallback_) switch_fallback(true);
        }
    }

    void switch_fallback(bool on) {
        in_fallback_ = on;
        hands_over_ = takes_up_ = true;
        fade_ = plan_.supervision.fade;
    }

    // u(k) of another controller, without a bump, and within the limits.
    void conduct() {
        if (in_fallback_) {
            std::fill(u_.begin(), u_.end(), 0.0);
            fallback_.add_to(u_.data());
        }
        if (takes_up_)
            for (std::size_t i = 0; i < l_u(); ++i) bump_[i] = held_[i] - u_[i];
        takes_up_ = false;
        hands_over_ = false;
        for (std::size_t i = 0; i < l_u(); ++i) {
            u_[i] += bump_[i];
            bump_[i] *= fade_;
            if (!(std::fabs(bump_[i]) > 1e-16 * std::fabs(u_[i]))) bump_[i] = 0.0;
            hands_over_ = hands_over_ || bump_[i] != 0.0;
        }
        const double* allowed = limits_.apply(u_.data());
        if (allowed != u_.data()) std::copy_n(allowed, l_u(), u_.data());
        take_the_place(u_.data());
    }

    // This, and not what RCAC asked for, is u(k) in every later regressor.
    void take_the_place(const double* u) {
        limits_.start_from(u);
        for (std::size_t i = 0; i < l_u(); ++i) {
            signals().now(i) = u[i] - fixed_.now(i);
            fallback_.replace(i, u[i]);
            held_[i] = u[i];
        }
    }

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
            if (rows_.penalises()) rows_.penalise(regressor_, as_size(age));
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
    Supervisor supervisor_;
    FixedPart fallback_;  // runs along, on what was applied
    Actuator limits_;
    bool is_live_ = false, stopped_ = false, in_fallback_ = false;
    bool hands_over_ = false, takes_up_ = false;  // a bump fades; it begins with the next u
    double fade_ = 0.0;
    std::vector<double> u_, held_, last_, bump_, z_, polynomial_;
    std::int64_t step_ = 0, next_event_ = 0, reflections_ = 0, resets_ = 0, bounded_ = 0,
                 last_reset_ = -1;
};

}  // namespace rcac
