// Formulas as a list of operations on numbered registers: a SymPy model without Python in the loop.
#pragma once

#include <cmath>

#include "estimation/model.hpp"

namespace rcac {

// The order is that of OPERATIONS in rcac_numeric/estimation/tape.py.
enum class Operation : std::int32_t {
    add, subtract, multiply, divide, power, negative, square_root, exponential, logarithm, sine,
    cosine, tangent, arc_sine, arc_cosine, arc_tangent, arc_tangent_2, hyperbolic_sine,
    hyperbolic_cosine, hyperbolic_tangent, magnitude, sign, least, greatest, count
};

inline double applied(Operation operation, double a, double b) {
    switch (operation) {
        case Operation::add: return a + b;
        case Operation::subtract: return a - b;
        case Operation::multiply: return a * b;
        case Operation::divide: return a / b;
        case Operation::power: return std::pow(a, b);
        case Operation::negative: return -a;
        case Operation::square_root: return std::sqrt(a);
        case Operation::exponential: return std::exp(a);
        case Operation::logarithm: return std::log(a);
        case Operation::sine: return std::sin(a);
        case Operation::cosine: return std::cos(a);
        case Operation::tangent: return std::tan(a);
        case Operation::arc_sine: return std::asin(a);
        case Operation::arc_cosine: return std::acos(a);
        case Operation::arc_tangent: return std::atan(a);
        case Operation::arc_tangent_2: return std::atan2(a, b);
        case Operation::hyperbolic_sine: return std::sinh(a);
        case Operation::hyperbolic_cosine: return std::cosh(a);
        case Operation::hyperbolic_tangent: return std::tanh(a);
        case Operation::magnitude: return std::fabs(a);
        case Operation::sign: return static_cast<double>((a > 0.0) - (a < 0.0));
        case Operation::least: return std::fmin(a, b);
        case Operation::greatest: return std::fmax(a, b);
        case Operation::count: break;
    }
    return std::nan("");
}

// Registers are, in this order: constants, x, u, k, and one for the result of each step.
class Tape {
public:
    struct Step {
        Operation operation;
        std::uint32_t a, b;
    };

    Tape(std::vector<double> constants, std::size_t n, std::size_t l_u, std::vector<Step> steps,
         std::vector<std::uint32_t> results)
        : first_(constants.size()),
          n_(n),
          l_u_(l_u),
          registers_(std::move(constants)),
          steps_(std::move(steps)),
          results_(std::move(results)) {
        registers_.resize(first_ + n_ + l_u_ + 1 + steps_.size(), 0.0);
    }

    std::size_t size() const { return results_.size(); }

    // The first `count` results go to `out`, the others to `rest`.
    void operator()(std::int64_t k, const double* x, const double* u, double* out,
                    std::size_t count, double* rest = nullptr) {
        double* place = std::copy_n(x, n_, registers_.data() + first_);
        place = std::copy_n(u, l_u_, place);
        *place++ = static_cast<double>(k);
        for (const Step& step : steps_)
            *place++ = applied(step.operation, registers_[step.a], registers_[step.b]);
        for (std::size_t i = 0; i < count; ++i) out[i] = registers_[results_[i]];
        for (std::size_t i = count; i < results_.size(); ++i)
            rest[i - count] = registers_[results_[i]];
    }

private:
    std::size_t first_, n_, l_u_;
    std::vector<double> registers_;
    std::vector<Step> steps_;
    std::vector<std::uint32_t> results_;
};

// Four tapes: f, h, [f, F] and [h, H]; the last two share their common subexpressions.
class TapeModel final : public EstimationModel {
public:
    TapeModel(std::size_t n, std::size_t l_u, std::size_t l_y, Tape f, Tape h, Tape f_F, Tape h_H)
        : EstimationModel(n, l_u, l_y),
          f_(std::move(f)),
          h_(std::move(h)),
          f_F_(std::move(f_F)),
          h_H_(std::move(h_H)) {}

    void dynamics(std::int64_t k, const double* x, const double* u, double* next) override {
        f_(k, x, u, next, n);
    }
    void output(std::int64_t k, const double* x, const double* u, double* y) override {
        h_(k, x, u, y, l_y);
    }
    void linear_dynamics(std::int64_t k, const double* x, const double* u, double* next,
                         double* F) override {
        f_F_(k, x, u, next, n, F);
    }
    void linear_output(std::int64_t k, const double* x, const double* u, double* y,
                       double* H) override {
        h_H_(k, x, u, y, l_y, H);
    }

private:
    Tape f_, h_, f_F_, h_H_;
};

}  // namespace rcac
