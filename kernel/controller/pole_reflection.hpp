// Keeping the poles of a scalar controller inside the unit circle (section 6.2.2).
#pragma once

#include <algorithm>
#include <vector>

#include "memory/history.hpp"
#include "polynomials/roots.hpp"

namespace rcac {

// Reflects the roots of D_c for the coefficients of a scalar controller whose taps on u, which is
// signal 0, are u(k-1), ..., u(k-n); `polynomial` is room for D_c. False where nothing changes.
inline bool reflect(const std::vector<Tap>& taps, std::vector<double>& theta,
                    std::vector<double>& polynomial) {
    std::size_t order = 0;
    for (const Tap& tap : taps)
        if (tap.source == 0) order = std::max(order, tap.delay);
    polynomial.assign(order + 1, 0.0);
    polynomial[0] = 1.0;
    for (std::size_t j = 0; j < theta.size(); ++j)
        if (taps[j].source == 0) polynomial[taps[j].delay] = -theta[j];
    if (!reflect(polynomial)) return false;
    for (std::size_t j = 0; j < theta.size(); ++j)
        if (taps[j].source == 0) theta[j] = -polynomial[taps[j].delay];
    return true;
}

}  // namespace rcac
