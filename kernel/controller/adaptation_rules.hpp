// What acts on the update while it runs: scheduled events, and weights that are functions of the
// signals.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

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

}  // namespace rcac
