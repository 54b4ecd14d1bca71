// Triangular square roots of covariances: made, reduced by one vector, and solved with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace rcac {

// L with L L' = A A', by Householder reflections from the right. A is rows x columns, row-major,
// with columns >= rows; its first `rows` columns become L, lower triangular with a diagonal >= 0,
// and the others zero. Nothing is subtracted from a square: L L' cannot become indefinite.
inline void triangularise(double* A, std::size_t rows, std::size_t columns) {
    for (std::size_t i = 0; i < rows; ++i) {
        double* row = A + i * columns;
        double largest = 0.0;
        for (std::size_t j = i; j < columns; ++j) largest = std::max(largest, std::fabs(row[j]));
        if (!(largest > 0.0)) continue;
        double sum = 0.0;
        for (std::size_t j = i; j < columns; ++j) {
            const double scaled = row[j] / largest;
            sum += scaled * scaled;
        }
        const double norm = largest * std::sqrt(sum);
        const double pivot = row[i] > 0.0 ? row[i] + norm : row[i] - norm;
        const bool turned = pivot > 0.0;  // the reflection makes the diagonal negative
        const double beta = 1.0 / (norm * std::fabs(pivot));
        row[i] = pivot;
        for (std::size_t m = i + 1; m < rows; ++m) {
            double* other = A + m * columns;
            double product = 0.0;
            for (std::size_t j = i; j < columns; ++j) product += row[j] * other[j];
            product *= beta;
            for (std::size_t j = i; j < columns; ++j) other[j] -= product * row[j];
            if (turned) other[i] = -other[i];
        }
        row[i] = norm;
        std::fill(row + i + 1, row + columns, 0.0);
    }
}

// L <- the square root of L L' - v v'; false where that is not positive definite. L is the leading
// n x n part of a matrix with `stride` columns; v is used up.
inline bool downdate(double* L, std::size_t n, std::size_t stride, double* v) {
    for (std::size_t j = 0; j < n; ++j) {
        double& pivot = L[j * stride + j];
        const double sine = v[j] / pivot;
        const double square = (1.0 - sine) * (1.0 + sine);
        if (!(square > 0.0)) return false;
        const double cosine = std::sqrt(square);
        pivot *= cosine;
        for (std::size_t i = j + 1; i < n; ++i) {
            double& entry = L[i * stride + j];
            entry = (entry - sine * v[i]) / cosine;
            v[i] = cosine * v[i] - sine * entry;
        }
    }
    return true;
}

// b <- L^-1 b; false where a pivot is zero.
inline bool solve_lower(const double* L, std::size_t n, std::size_t stride, double* b) {
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < i; ++j) b[i] -= L[i * stride + j] * b[j];
        if (!(L[i * stride + i] > 0.0)) return false;
        b[i] /= L[i * stride + i];
    }
    return true;
}

}  // namespace rcac
