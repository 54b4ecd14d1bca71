// Control magnitude and rate saturation (figure 2.13).
#pragma once

#include <algorithm>

#include "memory/archive.hpp"

namespace rcac {

// u_a(k) = u(k), moved first into [u_a(k-1) - fall, u_a(k-1) + rise] and then into [low, high].
class Actuator {
public:
    Actuator() = default;  // passes everything
    Actuator(std::vector<double> low, std::vector<double> high, std::vector<double> rate)
        : Actuator(std::move(low), std::move(high), rate, rate) {}
    Actuator(std::vector<double> low, std::vector<double> high, std::vector<double> rise,
             std::vector<double> fall)
        : low_(std::move(low)),
          high_(std::move(high)),
          rise_(std::move(rise)),
          fall_(std::move(fall)),
          applied_(low_.size()) {}

    bool is_ideal() const { return low_.empty(); }

    const double* apply(const double* u) {
        if (is_ideal()) return u;
        for (std::size_t i = 0; i < applied_.size(); ++i) {
            const double moved = std::clamp(u[i], applied_[i] - fall_[i], applied_[i] + rise_[i]);
            applied_[i] = std::clamp(moved, low_[i], high_[i]);
        }
        return applied_.data();
    }

    // What was applied in its place, from which the next step is taken.
    void start_from(const double* u) { std::copy_n(u, applied_.size(), applied_.begin()); }

    void visit(Archive& archive) { archive(applied_); }

private:
    std::vector<double> low_, high_, rise_, fall_, applied_;
};

}  // namespace rcac
