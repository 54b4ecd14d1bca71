// What every update of the controller coefficients sees and what it reports.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "memory/archive.hpp"

namespace rcac {

// One step's data of the retrospective cost (2.41): rows of Phi_f, z - u_f and the weights.
struct Data {
    std::size_t l_z, l_theta;
    const double* Phi_f;   // l_z x l_theta, row-major
    const double* target;  // z(k) - u_f(k), l_z
    const double* R_z;     // l_z x l_z
    const double* R_u;     // l_z x l_z
    double lambda;
};

// Evidence about the arithmetic: how often, and at which step first, an update was decided by
// rounding errors instead of by data.
struct Guard {
    std::int64_t count = 0;
    std::int64_t first_step = -1;
    void raise(std::int64_t step) {
        if (count++ == 0) first_step = step;
    }
};

// From this rho on nothing of P is kept.
constexpr double no_past_left = 0.999;

class Update {
public:
    virtual ~Update() = default;
    virtual std::unique_ptr<Update> copy() const = 0;
    // theta(k) -> theta(k+1) and P(k) -> P(k+1), (2.42)-(2.45). False where a number has left the
    // range of float64; nothing is valid afterwards.
    virtual bool operator()(const Data& data, std::int64_t step, double* theta) = 0;
    // z(k), at every step, also where no update is due.
    virtual void see(const double* /*z*/) {}
    // P(k), l_theta x l_theta row-major.
    virtual void covariance(double* P) const = 0;
    // Column i of P(k), or of the metric in which a bound on theta is kept.
    virtual void covariance_column(std::size_t i, double* column) const = 0;
    // P(k) x, in that metric; both have padded_to_tiles(l_theta) entries, x zeros behind its own.
    virtual void covariance_times(const double* x, double* product) const = 0;
    // What is fitted beside theta: the coefficients d_1, d_2, ... of D_f, where there are any.
    virtual std::vector<double> also_fitted() const { return {}; }
    // P <- P(0).
    virtual void reset() {}
    // The data that come are no longer those that P was made of: rho is how far the filtered signals
    // moved, |new - old|^2 / |new|^2.
    virtual void doubt_past(double rho) {
        if (!(rho < no_past_left)) reset();
    }
    // P <- P + sum of a a' over the `count` rows a of `noise` (2.46).
    virtual void inflate(const double* /*noise*/, std::size_t /*count*/) {}
    // The largest variance over that of P(0); 0 where there is no P that could grow.
    virtual double growth() const { return 0.0; }
    // No variance above so many times that of P(0): P only becomes smaller.
    virtual void bound(double /*growth*/) {}
    // trace P, for rules that watch it.
    virtual double trace() const { return 0.0; }
    // What the next update depends on, beside the settings.
    virtual void visit(Archive& archive) {
        archive(guard_.count, 0, Archive::longest);
        archive(guard_.first_step, -1, Archive::longest);
    }
    const Guard& guard() const { return guard_; }

protected:
    Guard guard_;
};

inline bool finite(const double* values, std::size_t count) {
    bool all = true;  // without a branch, so that it runs over vectors
    for (std::size_t i = 0; i < count; ++i) all &= values[i] - values[i] == 0.0;
    return all;
}

// Lower Cholesky factor in place (row-major, n x n); false where A is not positive definite.
inline bool cholesky(double* A, std::size_t n) {
    for (std::size_t j = 0; j < n; ++j) {
        double pivot = A[j * n + j];
        for (std::size_t m = 0; m < j; ++m) pivot -= A[j * n + m] * A[j * n + m];
        if (!(pivot > 0.0)) return false;
        A[j * n + j] = std::sqrt(pivot);
        for (std::size_t i = j + 1; i < n; ++i) {
            double sum = A[i * n + j];
            for (std::size_t m = 0; m < j; ++m) sum -= A[i * n + m] * A[j * n + m];
            A[i * n + j] = sum / A[j * n + j];
        }
    }
    return true;
}

// Solve A X = B in place by Gaussian elimination with partial pivoting; A is n x n and B is
// n x columns, both row-major. Used where A need not be positive definite.
inline void solve(double* A, double* B, std::size_t n, std::size_t columns) {
    for (std::size_t j = 0; j < n; ++j) {
        std::size_t pivot = j;
        for (std::size_t i = j + 1; i < n; ++i)
            if (std::fabs(A[i * n + j]) > std::fabs(A[pivot * n + j])) pivot = i;
        if (pivot != j) {
            for (std::size_t m = 0; m < n; ++m) std::swap(A[j * n + m], A[pivot * n + m]);
            for (std::size_t m = 0; m < columns; ++m)
                std::swap(B[j * columns + m], B[pivot * columns + m]);
        }
        for (std::size_t i = j + 1; i < n; ++i) {
            const double factor = A[i * n + j] / A[j * n + j];
            for (std::size_t m = j; m < n; ++m) A[i * n + m] -= factor * A[j * n + m];
            for (std::size_t m = 0; m < columns; ++m)
                B[i * columns + m] -= factor * B[j * columns + m];
        }
    }
    for (std::size_t j = n; j-- > 0;)
        for (std::size_t m = 0; m < columns; ++m) {
            for (std::size_t i = j + 1; i < n; ++i)
                B[j * columns + m] -= A[j * n + i] * B[i * columns + m];
            B[j * columns + m] /= A[j * n + j];
        }
}

}  // namespace rcac
