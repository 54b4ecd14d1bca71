// Forgetting and covariance resets that follow the performance variable.
#pragma once

#include <algorithm>
#include <cmath>

#include "memory/archive.hpp"
#include "updates/update.hpp"

namespace rcac {

struct ForgettingRule {
    std::size_t short_window = 0, long_window = 0;  // 0: no rule
    double gain = 0.0, smallest = 1.0;
};

struct ResetRule {
    std::int64_t every = 0;
    double trace_below = 0.0, growth = 0.0;
    std::size_t short_window = 1, long_window = 2;
};

// z'z of the last steps and its means over a short and a long window. The means are summed
// afresh: a running sum would never forget the rounding error of one large z.
class RecentPower {
public:
    explicit RecentPower(std::size_t length) : values_(std::max<std::size_t>(length, 1)) {}

    void add(const double* z, std::size_t l_z) {
        double power = 0.0;
        for (std::size_t i = 0; i < l_z; ++i) power += z[i] * z[i];
        values_[static_cast<std::size_t>(count_ % size())] = power;
        ++count_;
    }

    // Root mean square over the last `window` steps divided by that over the last `reach`.
    double growth(std::size_t window, std::size_t reach) const {
        const double recent = mean(window), past = mean(reach);
        return past > 0.0 ? std::sqrt(recent / past) : 1.0;
    }

    void visit(Archive& archive) {
        archive(count_, 0, Archive::longest);
        archive(values_);
    }

private:
    std::int64_t size() const { return static_cast<std::int64_t>(values_.size()); }
    double mean(std::size_t window) const {
        const std::int64_t length = std::min<std::int64_t>(static_cast<std::int64_t>(window), count_);
        double sum = 0.0;
        for (std::int64_t i = count_ - length; i < count_; ++i)
            sum += values_[static_cast<std::size_t>(i % size())];
        return length > 0 ? sum / static_cast<double>(length) : 0.0;
    }
    std::vector<double> values_;
    std::int64_t count_ = 0;
};

// Both rules and what they watch.
class PerformanceRules {
public:
    PerformanceRules(const ForgettingRule& forgetting, const ResetRule& reset, const Update& update)
        : forgetting_(forgetting),
          reset_(reset),
          power_(std::max(forgetting.long_window, reset.growth > 0.0 ? reset.long_window : 0)),
          watches_(forgetting.long_window > 0 || reset.growth > 0.0),
          initial_trace_(update.trace()) {}

    void see(const double* z, std::size_t l_z) {
        if (watches_) power_.add(z, l_z);
    }

    bool forgets() const { return forgetting_.long_window > 0; }
    // lambda(k): below one while z grows.
    double forgetting_factor() const {
        const double excess = power_.growth(forgetting_.short_window, forgetting_.long_window) - 1.0;
        return std::max(forgetting_.smallest, 1.0 / (1.0 + forgetting_.gain * std::max(0.0, excess)));
    }

    bool reset_is_due(std::int64_t step, std::int64_t k_update, std::int64_t last_reset,
                      const Update& update) const {
        const std::int64_t age = step - std::max(k_update, last_reset);
        return (reset_.every > 0 && age > 0 && (step - k_update) % reset_.every == 0) ||
               (reset_.trace_below > 0.0 &&
                update.trace() < reset_.trace_below * initial_trace_) ||
               (reset_.growth > 0.0 && age >= static_cast<std::int64_t>(reset_.long_window) &&
                power_.growth(reset_.short_window, reset_.long_window) > reset_.growth);
    }

    void visit(Archive& archive) { power_.visit(archive); }

private:
    ForgettingRule forgetting_;
    ResetRule reset_;
    RecentPower power_;
    bool watches_;
    double initial_trace_;
};

}  // namespace rcac
