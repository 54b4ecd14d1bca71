// What acts on the update while it runs: scheduled events, and weights that are functions of the
// signals.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

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

// What becomes of P when the target model changes while the controller runs: it stays; P(0); as
// uncertain as the share of the past that no longer holds; P(0) and the stored steps once more.
enum class Past { keep, reset, blend, replay };

// R(k) = (base + z_squared z'z I) / (1 + nu |z|)^2, or whatever a function of the step and the
// signals says.
struct Weight {
    using Function = std::function<void(std::int64_t k, const double* y, const double* z,
                                        const double* u, double* result)>;
    std::vector<double> base;  // l_z x l_z
    double z_squared = 0.0, nu = 0.0;
    Function function;

    bool is_constant() const { return z_squared == 0.0 && nu == 0.0 && !function; }
    void evaluate(std::int64_t k, const double* y, const double* z, const double* u,
                  std::size_t l_z, double* result) const {
        if (function) {
            function(k, y, z, u, result);
            return;
        }
        std::copy(base.begin(), base.end(), result);
        if (z_squared == 0.0 && nu == 0.0) return;
        double power = 0.0;
        for (std::size_t i = 0; i < l_z; ++i) power += z[i] * z[i];
        for (std::size_t i = 0; i < l_z; ++i) result[i * l_z + i] += z_squared * power;
        if (nu == 0.0) return;
        const double root = 1.0 + nu * std::sqrt(power);
        for (std::size_t i = 0; i < l_z * l_z; ++i) result[i] /= root * root;
    }
};

// What the performance variable goes through before it enters the retrospective cost:
// f(z) with f'(0) = slope and |f| < limit.
struct Normalization {
    enum Function { none, rational, root, arctan, tanh, erf };
    Function function = none;
    double limit = 1.0, slope = 1.0;

    double operator()(double z) const {
        constexpr double half_pi = 1.5707963267948966, root_of_pi = 1.7724538509055160;
        const double x = slope * z;
        switch (function) {
            case none: return z;
            case rational: return x / (1.0 + std::fabs(x) / limit);
            case root: return x / std::sqrt(1.0 + x / limit * (x / limit));
            case arctan: return limit / half_pi * std::atan(half_pi * x / limit);
            case tanh: return limit * std::tanh(x / limit);
            case erf: return limit * std::erf(0.5 * root_of_pi * x / limit);
        }
        return z;
    }
};

// A perturbation of u that is white and has two values, +-`first` before the step `until` and
// +-`after` from there on; a function of the seed and the step, so that it has no state.
struct Dither {
    std::uint64_t seed = 0;
    double first = 0.0, after = 0.0;
    std::int64_t until = 0;

    bool is_on() const { return first != 0.0 || after != 0.0; }
    double operator()(std::int64_t k, std::size_t i) const {
        // splitmix64 (Steele, Lea, Flood 2014) of the place in the sequence.
        std::uint64_t x = seed * 0xd1342543de82ef95u + (static_cast<std::uint64_t>(k) << 20) + i;
        for (std::uint64_t factor : {0xbf58476d1ce4e5b9u, 0x94d049bb133111ebu}) {
            x += 0x9e3779b97f4a7c15u;
            x = (x ^ (x >> 30)) * factor;
        }
        x ^= x >> 31;
        const double size = k < until ? first : after;
        return x >> 63 ? size : -size;
    }
};

// The weight in force: that of the plan, until another is set while the controller runs.
class CurrentWeight {
public:
    CurrentWeight(const Weight& planned) : planned_(&planned), now_(planned), value_(now_.base) {}

    void set(const Weight& weight) {
        now_ = weight;
        value_ = now_.base;
        is_own_ = true;
    }
    void evaluate(std::int64_t k, const double* y, const double* z, const double* u,
                  std::size_t l_z) {
        now_.evaluate(k, y, z, u, l_z, value_.data());
    }
    bool is_constant() const { return now_.is_constant(); }
    bool is_own() const { return is_own_; }
    const double* value() const { return value_.data(); }

    // A weight that was set is no function.
    void visit(Archive& archive) {
        archive(is_own_);
        if (archive.reading()) now_ = *planned_;
        if (is_own_) {
            now_.function = nullptr;
            archive(now_.base);
            archive(now_.z_squared);
            archive(now_.nu);
        }
        if (archive.reading()) value_ = now_.base;
    }

private:
    const Weight* planned_;
    Weight now_;
    std::vector<double> value_;
    bool is_own_ = false;
};

}  // namespace rcac
