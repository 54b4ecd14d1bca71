// An orthonormal basis of a few long rows, by modified Gram and Schmidt, repeated.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace rcac {

// The order of the sum is written out, so that no instruction set changes it.
inline double dot(const double* a, const double* b, std::size_t size) {
    double first = 0.0, second = 0.0, third = 0.0, fourth = 0.0;
    std::size_t k = 0;
    for (; k + 4 <= size; k += 4) {
        first += a[k] * b[k];
        second += a[k + 1] * b[k + 1];
        third += a[k + 2] * b[k + 2];
        fourth += a[k + 3] * b[k + 3];
    }
    for (; k < size; ++k) first += a[k] * b[k];
    return (first + third) + (second + fourth);
}

inline void subtract(double* from, double factor, const double* row, std::size_t size) {
    for (std::size_t k = 0; k < size; ++k) from[k] -= factor * row[k];
}

// Rows F = R' Q, each row of F scaled to norm 1. A row of which the others leave less than
// `dependent` is not in the basis.
class OrthogonalRows {
public:
    // The basis takes the place of the rows.
    OrthogonalRows(std::vector<double> rows, std::size_t count, std::size_t size, double dependent)
        : count_(count), size_(size), Q_(std::move(rows)), R_(count * count), norm_(count),
          is_needed_(count) {
        for (std::size_t i = 0; i < count; ++i) {
            double* row = Q_.data() + i * size;
            norm_[i] = std::sqrt(dot(row, row, size));
            if (!(norm_[i] > 0.0)) continue;
            for (std::size_t k = 0; k < size; ++k) row[k] /= norm_[i];
            double rest = 1.0, before = 1.0;
            do {  // again where digits were lost (Daniel, Gragg, Kaufman and Stewart)
                before = rest;
                for (std::size_t j = 0; j < i; ++j) {
                    if (!is_needed_[j]) continue;
                    const double share = dot(row, basis(j), size);
                    subtract(row, share, basis(j), size);
                    R_[j * count + i] += share;
                }
                rest = std::sqrt(dot(row, row, size));
            } while (rest > dependent && rest < before / 2);
            is_needed_[i] = rest > dependent;  // false for NaN
            if (!is_needed_[i]) continue;
            R_[i * (count + 1)] = rest;
            for (std::size_t k = 0; k < size; ++k) row[k] /= rest;
        }
    }

    // Takes its projection on the basis out of a row, and returns the coefficients of that.
    std::vector<double> project_out(double* row) const {
        std::vector<double> shares(count_, 0.0);
        for (std::size_t i = 0; i < count_; ++i)
            if (is_needed_[i]) shares[i] = dot(row, basis(i), size_);
        for (std::size_t i = 0; i < count_; ++i)
            if (is_needed_[i]) subtract(row, shares[i], basis(i), size_);
        return shares;
    }

    // The same projection as a combination of the rows themselves; 0 of those not in the basis.
    std::vector<double> combination(const std::vector<double>& shares) const {
        std::vector<double> x(count_, 0.0);
        for (std::size_t i = count_; i-- > 0;) {
            if (!is_needed_[i]) continue;
            double sum = shares[i];
            for (std::size_t j = i + 1; j < count_; ++j) sum -= R_[i * count_ + j] * x[j];
            x[i] = sum / R_[i * (count_ + 1)];
        }
        for (std::size_t i = 0; i < count_; ++i)
            if (is_needed_[i]) x[i] /= norm_[i];
        return x;
    }

private:
    const double* basis(std::size_t i) const { return Q_.data() + i * size_; }

    std::size_t count_, size_;
    std::vector<double> Q_, R_, norm_;
    std::vector<char> is_needed_;
};

}  // namespace rcac
