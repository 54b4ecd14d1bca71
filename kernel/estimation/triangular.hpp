// Triangular square roots of covariances: made, reduced by one vector, and solved with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace rcac {

// Row i of A has its norm on the diagonal and zeros behind it after one Householder reflection from
// the right, which the rows below take part in.
inline void reflect(double* A, std::size_t i, std::size_t rows, std::size_t columns) {
    double* row = A + i * columns;
    double largest = 0.0;
    for (std::size_t j = i; j < columns; ++j) largest = std::max(largest, std::fabs(row[j]));
    if (!(largest > 0.0)) return;
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

// L with L L' = A A'. A is rows x columns, row-major, with columns >= rows; its first `rows` columns
// become L, lower triangular with a diagonal >= 0, and the others zero. Nothing is subtracted from a
// square: L L' cannot become indefinite.
inline void triangularise(double* A, std::size_t rows, std::size_t columns) {
    for (std::size_t i = 0; i < rows; ++i) reflect(A, i, rows, columns);
}

// The same for the first `leading` rows alone, exchanged so that the rows which depend on others,
// each in its own scale, come last: the rank is returned, and order[i] is where row i was.
inline std::size_t eliminate(double* A, std::size_t leading, std::size_t rows, std::size_t columns,
                             std::size_t* order) {
    const auto norm = [&](std::size_t row, std::size_t first) {
        double largest = 0.0;
        for (std::size_t j = first; j < columns; ++j)
            largest = std::max(largest, std::fabs(A[row * columns + j]));
        return largest;
    };
    std::vector<double> scale(leading);
    for (std::size_t i = 0; i < leading; ++i) {
        order[i] = i;
        scale[i] = norm(i, 0);
    }
    for (std::size_t i = 0; i < leading; ++i) {
        std::size_t best = i;
        double share = 0.0;
        for (std::size_t m = i; m < leading; ++m)
            if (scale[m] > 0.0 && norm(m, i) / scale[m] > share) {
                best = m;
                share = norm(m, i) / scale[m];
            }
        if (!(share > 4.0 * static_cast<double>(columns) * 2.3e-16)) return i;
        if (best != i)
            std::swap_ranges(A + i * columns, A + (i + 1) * columns, A + best * columns);
        std::swap(order[i], order[best]);
        std::swap(scale[i], scale[best]);
        reflect(A, i, rows, columns);
    }
    return leading;
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
