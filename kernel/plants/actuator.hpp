// Control magnitude and rate saturation (figure 2.13).
#pragma once

#include <algorithm>

#include "memory/archive.hpp"

namespace rcac {

// u_a(k) = u(k), moved first to within `rate` of u_a(k-1) and then into [low, high].
class Actuator {
public:
    Actuator() = default;  // passes everything
    Actuator(std::vector<double> low, std::vector<double> high, std::vector<double> rate)
        : low_(std::move(low)), high_(std::move(high)), rate_(std::move(rate)), applied_(low_.size()) {}

    bool is_ideal() const { return low_.empty(); }

    const double* apply(const double* u) {
        if (is_ideal()) return u;
        for (std::size_t i = 0; i < applied_.size(); ++i) {
            const double moved = std::clamp(u[i], applied_[i] - rate_[i], applied_[i] + rate_[i]);
            applied_[i] = std::clamp(moved, low_[i], high_[i]);
        }
        return applied_.data();
    }

    void visit(Archive& archive) { archive(applied_); }

private:
    std::vector<double> low_, high_, rate_, applied_;
};

}  // namespace rcac
