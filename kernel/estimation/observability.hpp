// How measurements along a trajectory depend on where it began.
#pragma once

#include <cmath>

#include "estimation/model.hpp"
#include "estimation/triangular.hpp"

namespace rcac {

// A lower triangular T with T T' = O' O for O = [W H(0) S; W H(1) F(0) S; ...], S = diag(scale) and
// W = diag(weight). Ends where the transition has grown by `growth`, which would hide what does not
// grow. x, u and `measured` hold one row for each step, 0 where an entry of y(k) is missing.
inline std::vector<double> sensitivity(EstimationModel& model, std::size_t steps, const double* x,
                                       const double* u, const double* measured,
                                       const double* scale, const double* weight, double growth) {
    const std::size_t n = model.n, p = model.l_y, columns = n + p;
    std::vector<double> T(n * columns, 0.0), transition(n * n, 0.0), moved(n * n), next(n),
        F(n * n), y(p), H(p * n);
    const double first = *std::max_element(scale, scale + n);
    for (std::size_t i = 0; i < n; ++i) transition[i * n + i] = scale[i];
    for (std::size_t k = 0; k < steps; ++k) {
        const auto step = static_cast<std::int64_t>(k);
        model.linear_dynamics(step, x + k * n, u + k * model.l_u, next.data(), F.data());
        const double* there = measured + k * p;
        if (std::any_of(there, there + p, [](double entry) { return entry != 0.0; })) {
            model.linear_output(step, x + k * n, u + k * model.l_u, y.data(), H.data());
            require_finite(H.data(), p * n, "the Jacobian H of h");
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j < p; ++j) {
                    double sum = 0.0;
                    for (std::size_t m = 0; m < n; ++m) sum += H[j * n + m] * transition[m * n + i];
                    T[i * columns + n + j] = there[j] != 0.0 ? weight[j] * sum : 0.0;
                }
            triangularise(T.data(), n, columns);
        }
        require_finite(F.data(), n * n, "the Jacobian F of f");
        double largest = 0.0;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) {
                double sum = 0.0;
                for (std::size_t m = 0; m < n; ++m) sum += F[i * n + m] * transition[m * n + j];
                moved[i * n + j] = sum;
                largest = std::max(largest, std::fabs(sum));
            }
        transition = moved;
        if (k >= n && !(largest < growth * first)) break;
    }
    std::vector<double> square(n * n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) square[i * n + j] = T[i * columns + j];
    return square;
}

}  // namespace rcac
