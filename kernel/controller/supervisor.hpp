// What watches a controller while it runs: troubles that it counts, and what it does about them.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "controller/fixed_part.hpp"
#include "updates/update.hpp"

namespace rcac {

// The policy is what becomes of a controller in trouble. `off` notices nothing, and a number that
// leaves float64 ends it; `warn` notices, and keeps a device going.
struct SupervisionPlan {
    enum Policy { off, warn, freeze, bound, reset, fallback };
    Policy policy = warn;
    double growth = 1e6;  // of a variance over that of P(0): wound up
    double limit = std::numeric_limits<double>::infinity();  // of |z|
    double jump = 0.0;  // of |z| over its running rms, that makes a sample a missed one; 0: none
    std::int64_t patience = 100;  // steps without a break in which the actuator did not apply u
    double fade = 0.0;  // of what is left of a bump, from step to step
    FixedPlan fallback_plan;
    bool fallback_where_missed = false;
};

// The troubles, and what was done; Python knows them by these numbers.
struct Trouble {
    enum Kind : int {
        windup, large_z, saturated, missed, jump, overflow,            // troubles
        frozen, bounded, restored, reset, to_fallback, to_adaptive,    // what was done
    };
    static constexpr int kinds = 12;
};

class Supervisor {
public:
    // So many steps lie between two looks at P, which then costs next to nothing.
    static constexpr std::int64_t interval = 16;
    static constexpr std::size_t remembered = 64;
    static bool is_due(std::int64_t steps) { return (steps & (interval - 1)) == 0; }

    Supervisor(const SupervisionPlan& plan, const std::vector<double>& theta)
        : plan_(plan), good_(theta) {}

    const SupervisionPlan& plan() const { return plan_; }
    bool is_on() const { return plan_.policy != SupervisionPlan::off; }
    // Whether it changes what a run without trouble of the arithmetic would do.
    bool acts() const { return plan_.policy > SupervisionPlan::warn; }

    // A trouble at this step; true where it begins here.
    bool note(Trouble::Kind kind, std::int64_t step, double value) {
        Count& count = counts_[static_cast<std::size_t>(kind)];
        // A look comes every `interval` steps; what lasts from one to the next is one trouble.
        const bool at_looks = kind == Trouble::windup || kind >= Trouble::frozen;
        const std::int64_t gap = at_looks ? interval : 1;
        const bool begins = count.steps == 0 || step > count.last + gap;
        if (count.steps++ == 0) count.first = step;
        count.last = step;
        if (!(value <= count.worst)) count.worst = value;
        if (begins) {
            ++count.episodes;
            ring_[static_cast<std::size_t>(noted_++ % static_cast<std::int64_t>(remembered))] = {
                step, kind, value};
        }
        return begins;
    }

    // At a look: whether P has wound up.
    bool is_wound_up(const Update& update, std::int64_t step) {
        const double growth = update.growth();
        if (growth > worst_growth_) worst_growth_ = growth;
        wound_up_ = growth > plan_.growth;
        if (wound_up_) note(Trouble::windup, step, growth);
        return wound_up_;
    }
    bool is_beyond_limit(const double* z, std::size_t l_z, std::int64_t step) {
        if (plan_.limit == std::numeric_limits<double>::infinity()) return false;
        double largest = 0.0;
        for (std::size_t i = 0; i < l_z; ++i) largest = std::max(largest, std::fabs(z[i]));
        if (largest <= plan_.limit) return false;
        note(Trouble::large_z, step, largest);
        return true;
    }

    // Whether z jumps away from its past; after `most` in a row that is where it now is.
    bool jumps(const double* z, std::size_t l_z, std::int64_t step) {
        if (plan_.jump == 0.0) return false;
        double power = 0.0;
        for (std::size_t i = 0; i < l_z; ++i) power += z[i] * z[i];
        if (seen_ >= settled && in_a_row_ < most_in_a_row &&
            power > plan_.jump * plan_.jump * power_) {
            ++in_a_row_;
            note(Trouble::jump, step, std::sqrt(power));
            return true;
        }
        if (in_a_row_ == most_in_a_row) power_ = power;
        in_a_row_ = 0;
        power_ += (power - power_) / static_cast<double>(std::min(++seen_, settled));
        return false;
    }

    void see_actuator(bool applied, std::int64_t step) {
        saturated_ = applied ? 0 : saturated_ + 1;
        if (saturated_ >= plan_.patience)
            note(Trouble::saturated, step, static_cast<double>(saturated_));
    }

    // theta to go back to: of the last look at which nothing was wrong.
    void keep(const std::vector<double>& theta) {
        if (!wound_up_) good_ = theta;
    }
    const std::vector<double>& good() const { return good_; }

    std::int64_t noted() const { return noted_; }
    double worst_growth() const { return worst_growth_; }
    // The largest share of an ellipsoid's radius, at the same looks.
    void see_radius(double radius) { worst_radius_ = std::max(worst_radius_, radius); }
    double worst_radius() const { return worst_radius_; }
    double& worst_radius() { return worst_radius_; }

    struct Count {
        std::int64_t steps = 0, episodes = 0, first = -1, last = -1;
        double worst = 0.0;
    };
    struct Entry {
        std::int64_t step = 0, kind = 0;
        double value = 0.0;
    };
    const std::array<Count, Trouble::kinds>& counts() const { return counts_; }
    // The last entries, oldest first.
    std::vector<Entry> entries() const {
        std::vector<Entry> result;
        const auto size = static_cast<std::int64_t>(remembered);
        for (std::int64_t i = std::max<std::int64_t>(noted_ - size, 0); i < noted_; ++i)
            result.push_back(ring_[static_cast<std::size_t>(i % size)]);
        return result;
    }

    void visit(Archive& archive) {
        for (Count& count : counts_) {
            archive(count.steps, 0, Archive::longest);
            archive(count.episodes, 0, Archive::longest);
            archive(count.first, -1, Archive::longest);
            archive(count.last, -1, Archive::longest);
            archive(count.worst);
        }
        archive(noted_, 0, Archive::longest);
        for (Entry& entry : ring_) {
            archive(entry.step, 0, Archive::longest);
            archive(entry.kind, 0, Trouble::kinds - 1);
            archive(entry.value);
        }
        archive(good_);
        archive(worst_growth_);
        archive(power_);
        archive(seen_, 0, Archive::longest);
        archive(in_a_row_, 0, most_in_a_row);
        archive(saturated_, 0, Archive::longest);
        archive(wound_up_);
    }

private:
    static constexpr std::int64_t settled = 64, most_in_a_row = 5;

    SupervisionPlan plan_;
    std::array<Count, Trouble::kinds> counts_{};
    std::array<Entry, remembered> ring_{};
    std::vector<double> good_;
    std::int64_t noted_ = 0, seen_ = 0, in_a_row_ = 0, saturated_ = 0;
    double worst_growth_ = 0.0, worst_radius_ = 0.0, power_ = 0.0;
    bool wound_up_ = false;
};

}  // namespace rcac
