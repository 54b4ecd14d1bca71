// Rules that act on the update while it runs: scheduled events, forgetting and resets that
// follow the performance variable, weights that are functions of the signals.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "memory/archive.hpp"

namespace rcac {

// Something that is scheduled for the beginning of a step.
struct Event {
    enum Kind { freeze, resume, reset, forgetting, target };
    std::int64_t step;
    Kind kind;
    double value;       // forgetting: lambda
    std::size_t index;  // target: which model
};

// R(k) = base + z_squared z'z I, or whatever a function of the step and the signals says.
struct Weight {
    using Function = std::function<void(std::int64_t k, const double* y, const double* z,
                                        const double* u, double* result)>;
    std::vector<double> base;  // l_z x l_z
    double z_squared = 0.0;
    Function function;

    bool is_constant() const { return z_squared == 0.0 && !function; }
    void evaluate(std::int64_t k, const double* y, const double* z, const double* u,
                  std::size_t l_z, double* result) const {
        if (function) {
            function(k, y, z, u, result);
            return;
        }
        std::copy(base.begin(), base.end(), result);
        if (z_squared == 0.0) return;
        double power = 0.0;
        for (std::size_t i = 0; i < l_z; ++i) power += z[i] * z[i];
        for (std::size_t i = 0; i < l_z; ++i) result[i * l_z + i] += z_squared * power;
    }
};

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

}  // namespace rcac
