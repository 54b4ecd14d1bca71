// Runs in lock step, each in a lane of the processor's vectors.
#pragma once

#include "lanes/state.hpp"

namespace rcac {

// Feeds the compiled loop with pieces of w, hands out what it recorded, and decides what becomes
// of a lane that raised the alarm. A run that ends leaves an idle lane.
class LaneLoop {
public:
    explicit LaneLoop(const std::vector<Job*>& jobs, const InstructionSet& instructions)
        : instructions_(&instructions), state_(*jobs.front()->loop), jobs_(jobs), a_(state_.a) {
        for (std::size_t i = 0; i < jobs_.size(); ++i) state_.load(i, *jobs_[i]->loop);
        w_.assign(lane_rows * a_.l_w * lanes, 0.0);
        u_.assign(lane_rows * a_.l_u * lanes, 0.0);
        y_.assign(lane_rows * a_.l_y * lanes, 0.0);
        z_.assign(lane_rows * a_.l_z * lanes, 0.0);
        a_.owner = this;
        a_.bound = [](void* owner, unsigned others) {
            auto& self = *static_cast<LaneLoop*>(owner);
            for (std::size_t i = 0; i < self.jobs_.size(); ++i)
                if (others >> i & 1u && self.jobs_[i])
                    self.state_.bound(i, *self.jobs_[i]->loop->controllers().front());
        };
        a_.w = w_.data(), a_.u = u_.data(), a_.y = y_.data(), a_.z = z_.data();
        for (std::size_t i = 0; i < jobs_.size(); ++i) first_[i] = jobs_[i]->done;
    }

    // Until every run has ended or the time is up, and at least one step.
    void run(const TimeBudget& budget) {
        Watch watch(budget);
        while (const std::size_t count = piece(watch.steps_to_next_look())) {
            for (std::size_t i = 0; i < jobs_.size(); ++i)
                if (jobs_[i]) before(i, count);
            const std::size_t made = instructions_->lane_steps(a_, count);
            for (std::size_t i = 0; i < jobs_.size(); ++i)
                if (jobs_[i]) after(i, made);
            if (watch.time_is_up(static_cast<std::int64_t>(made))) break;
        }
        for (std::size_t i = 0; i < jobs_.size(); ++i)
            if (jobs_[i]) leave_intact(i);
    }

private:
    // Steps up to the end of the first run, up to the first theta to be kept after this one, or
    // `most`, whatever comes first.
    std::size_t piece(std::int64_t most) const {
        std::int64_t count = std::min<std::int64_t>(most, lane_rows);
        bool any = false;
        for (std::size_t i = 0; i < jobs_.size(); ++i) {
            if (!jobs_[i]) continue;
            any = true;
            const std::int64_t stride = jobs_[i]->record.stride;
            count = std::min({count, jobs_[i]->steps - jobs_[i]->done,
                              stride - jobs_[i]->done % stride});
            if (a_.forgets || a_.reach)
                count = std::min(count, Supervisor::interval - steps_of(i) % Supervisor::interval);
        }
        return any ? static_cast<std::size_t>(count) : 0;
    }

    std::int64_t steps_of(std::size_t lane) const {
        const Job& job = *jobs_[lane];
        return job.loop->controllers().front()->step() + job.done - first_[lane];
    }

    // What a supervised controller sees of an ellipsoid and of P; without forgetting nothing of P grows.
    void watch(std::size_t lane) {
        Controller& c = *jobs_[lane]->loop->controllers().front();
        if (!c.supervisor().is_on() || !Supervisor::is_due(steps_of(lane))) return;
        if (a_.reach)
            c.supervisor().see_radius(
                c.ellipsoid().radius(LaneState::taken(a_.theta, a_.factors.n, lane)));
        if (!a_.forgets) return;
        auto& ud = dynamic_cast<UdUpdate&>(c.update());
        for (std::size_t j = 0; j < ud.l_theta(); ++j) ud.d(j) = a_.factors.D[j * lanes + lane];
        c.supervisor().is_wound_up(ud, steps_of(lane) - 1);
    }

    void before(std::size_t lane, std::size_t count) {
        const Job& job = *jobs_[lane];
        const double* w = job.w + job.done * static_cast<std::int64_t>(job.l_w);
        for (std::size_t i = 0; i < count * a_.l_w; ++i) w_[i * lanes + lane] = w[i];
        if (job.done % job.record.stride != 0) return;
        const std::size_t l_theta = a_.factors.n;
        double* theta = job.record.theta +
                        job.done / job.record.stride * static_cast<std::int64_t>(l_theta);
        for (std::size_t j = 0; j < l_theta; ++j) theta[j] = a_.theta[j * lanes + lane];
    }

    void after(std::size_t lane, std::size_t made) {
        Job& job = *jobs_[lane];
        record(u_, a_.l_u, lane, made, job.record.u);
        if (job.record.u_applied) record(u_, a_.l_u, lane, made, job.record.u_applied);
        record(y_, a_.l_y, lane, made, job.record.y);
        record(z_, a_.l_z, lane, made, job.record.z);
        job.done += static_cast<std::int64_t>(made);
        if (a_.alarm) job.outcome = verdict(lane, made - 1);
        if (job.outcome != Outcome::completed) {
            --job.done;
            job.loop->has_failed(LaneState::taken(a_.theta_before, a_.factors.n, lane));
            leave(lane);
            return;
        }
        watch(lane);
        if (job.finished()) {
            leave_intact(lane);
        }
    }

    void record(const AlignedVector& from, std::size_t width, std::size_t lane, std::size_t made,
                double* to) const {
        to += jobs_[lane]->done * static_cast<std::int64_t>(width);
        for (std::size_t i = 0; i < made * width; ++i) to[i] = from[i * lanes + lane];
    }

    // What loop/closed_loop.hpp says of the last step, row `row` of the piece, in its order.
    Outcome verdict(std::size_t lane, std::size_t row) {
        const Job& job = *jobs_[lane];
        const double limit = job.loop->options().limit;
        const auto fine = [limit](const std::vector<double>& v) {
            return within(v.data(), v.size(), limit);
        };
        const auto real = [](const std::vector<double>& v) { return finite(v.data(), v.size()); };
        const auto signal = [&](const AlignedVector& values, std::size_t width) {
            return LaneState::taken(values.data() + row * width * lanes, width, lane);
        };
        const auto u = signal(u_, a_.l_u), y = signal(y_, a_.l_y), z = signal(z_, a_.l_z),
                   theta = LaneState::taken(a_.theta, a_.factors.n, lane),
                   D = LaneState::taken(a_.factors.D, a_.factors.n, lane),
                   x = LaneState::taken(a_.x, a_.n, lane);
        if (!fine(u) || !fine(y) || !fine(z))
            return real(u) && !(real(y) && real(z)) ? Outcome::plant_not_finite : Outcome::diverged;
        if (a_.updated) {
            Controller& c = *job.loop->controllers().front();
            for (std::size_t r = 0; r < a_.l_z; ++r) {
                if (a_.lost[r] >> lane & 1u)
                    dynamic_cast<UdUpdate&>(c.update())
                        .doubt(c.step() + job.done - 1 - first_[lane]);
                if (!std::isfinite(a_.alpha[r * lanes + lane])) return Outcome::overflow;
            }
            if (!real(theta) || !real(D)) return Outcome::overflow;
        }
        if (!fine(theta)) return Outcome::diverged;
        if (fine(x)) return Outcome::completed;
        return real(x) ? Outcome::diverged : Outcome::plant_not_finite;
    }

    void leave_intact(std::size_t lane) {
        Job& job = *jobs_[lane];
        state_.store(lane, job, job.done - first_[lane]);
        leave(lane);
    }
    void leave(std::size_t lane) {
        jobs_[lane] = nullptr;
        state_.clear(lane);
        for (std::size_t i = lane; i < w_.size(); i += lanes) w_[i] = 0.0;
    }

    const InstructionSet* instructions_;
    LaneState state_;
    std::vector<Job*> jobs_;  // null: has ended
    LaneArrays& a_;
    AlignedVector w_, u_, y_, z_;
    std::int64_t first_[lanes] = {};  // rows where this took over
};

// The jobs that fit in lanes, the others one after another. To find the lanes of thousands of jobs
// takes longer than the work between two answers, so it is done for a few, for more where these do
// not fill their lanes, and for the rest only if there is time.
inline void run_in_lanes(const std::vector<Job*>& jobs, std::size_t threads,
                         const TimeBudget& budget, const InstructionSet& instructions) {
    constexpr std::size_t most = 1024;
    std::size_t begin = 0, count = 8 * lanes * std::clamp<std::size_t>(threads, 1, most);
    while (begin < jobs.size() && (begin == 0 || !budget.is_over())) {
        const auto left = jobs.begin() + static_cast<std::ptrdiff_t>(begin);
        LaneGroups groups;
        for (;; count *= 2) {
            count = std::min(count, jobs.size() - begin);
            groups = lane_groups({left, left + static_cast<std::ptrdiff_t>(count)});
            if (groups.are_full() || begin + count == jobs.size() || count >= most) break;
        }
        const std::size_t first = groups.in_lanes.size();
        in_threads(first + groups.others.size(), threads, [&](std::size_t i) {
            if ((begin > 0 || i > 0) && budget.is_over()) return;
            if (i < first)
                LaneLoop(groups.in_lanes[i], instructions).run(budget);
            else
                groups.others[i - first]->run(budget);
        });
        begin += count;
        count *= 2;
    }
}

}  // namespace rcac
