// What an estimator asks of a model, and a linear one.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace rcac {

// Why a step of an estimator could not be made; the kinds are model, singular, indefinite and range.
struct EstimationError : std::runtime_error {
    EstimationError(const char* kind, const std::string& words)
        : std::runtime_error(words), kind(kind) {}

    const char* kind;  // a literal
};

inline void require_finite(const double* values, std::size_t count, const char* name) {
    for (std::size_t i = 0; i < count; ++i)
        if (!(values[i] - values[i] == 0.0))
            throw EstimationError{"model", std::string(name) + " has the entry " +
                                               std::to_string(values[i]) + " at position " +
                                               std::to_string(i)};
}

// x(k+1) = f(k, x, u) + noise, y(k) = h(k, x, u) + noise. Matrices are row-major.
class EstimationModel {
public:
    EstimationModel(std::size_t states, std::size_t inputs, std::size_t outputs)
        : n(states), l_u(inputs), l_y(outputs) {}
    virtual ~EstimationModel() = default;
    virtual void dynamics(std::int64_t k, const double* x, const double* u, double* next) = 0;
    virtual void output(std::int64_t k, const double* x, const double* u, double* y) = 0;
    // The same with the Jacobians F (n x n) and H (l_y x n) with respect to x.
    virtual void linear_dynamics(std::int64_t k, const double* x, const double* u, double* next,
                                 double* F) = 0;
    virtual void linear_output(std::int64_t k, const double* x, const double* u, double* y,
                               double* H) = 0;
    // How far y is from what was expected of it; an angle by the shorter way round.
    virtual void difference(const double* y, const double* expected, double* out) {
        for (std::size_t i = 0; i < l_y; ++i) {
            out[i] = y[i] - expected[i];
            if (!is_angle.empty() && is_angle[i])
                out[i] = std::remainder(out[i], 2.0 * 3.14159265358979323846);
        }
    }

    const std::size_t n, l_u, l_y;
    std::vector<bool> is_angle;  // of each measurement; empty where none is
};

class LinearEstimationModel final : public EstimationModel {
public:
    LinearEstimationModel(std::size_t n, std::size_t l_u, std::size_t l_y, std::vector<double> A,
                          std::vector<double> B, std::vector<double> C, std::vector<double> D)
        : EstimationModel(n, l_u, l_y),
          A_(std::move(A)),
          B_(std::move(B)),
          C_(std::move(C)),
          D_(std::move(D)) {}

    void dynamics(std::int64_t, const double* x, const double* u, double* next) override {
        affine(A_, B_, n, x, u, next);
    }
    void output(std::int64_t, const double* x, const double* u, double* y) override {
        affine(C_, D_, l_y, x, u, y);
    }
    void linear_dynamics(std::int64_t k, const double* x, const double* u, double* next,
                         double* F) override {
        dynamics(k, x, u, next);
        std::copy(A_.begin(), A_.end(), F);
    }
    void linear_output(std::int64_t k, const double* x, const double* u, double* y,
                       double* H) override {
        output(k, x, u, y);
        std::copy(C_.begin(), C_.end(), H);
    }

private:
    void affine(const std::vector<double>& M, const std::vector<double>& N, std::size_t rows,
                const double* x, const double* u, double* out) const {
        for (std::size_t i = 0; i < rows; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < n; ++j) sum += M[i * n + j] * x[j];
            for (std::size_t j = 0; j < l_u; ++j) sum += N[i * l_u + j] * u[j];
            out[i] = sum;
        }
    }
    std::vector<double> A_, B_, C_, D_;
};

}  // namespace rcac
