// Roots of real monic polynomials, and keeping them inside a circle.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

namespace rcac {

// Whether c_0 q^n + ... + c_n with c_0 = 1 has all roots inside the unit circle: every reflection
// coefficient of the Schur-Cohn recursion is below one in size.
inline bool is_schur(std::vector<double> c) {
    for (std::size_t n = c.size() - 1; n > 0; --n) {
        const double k = c[n] / c[0];
        if (!(std::fabs(k) < 1.0)) return false;
        for (std::size_t i = 0, j = n; i <= j; ++i, --j) {
            const double a = c[i], b = c[j];
            c[i] = a - k * b;
            if (i != j) c[j] = b - k * a;
        }
        c.pop_back();
    }
    return true;
}

// All roots of a monic polynomial: the quadratic formula where it serves, else the simultaneous
// iteration of Aberth (1973) from points on a circle that contains every root.
inline std::vector<std::complex<double>> polynomial_roots(const std::vector<double>& c) {
    using Complex = std::complex<double>;
    const std::size_t n = c.size() - 1;
    if (n == 1) return {-c[1]};
    if (n == 2) {
        const Complex root = std::sqrt(Complex(c[1] * c[1] / 4.0 - c[2]));
        const Complex larger = c[1] > 0.0 ? -c[1] / 2.0 - root : -c[1] / 2.0 + root;
        return {larger, larger == 0.0 ? Complex(0.0) : c[2] / larger};
    }
    double radius = 0.0;
    for (std::size_t i = 1; i <= n; ++i)
        radius = std::max(radius, 2.0 * std::pow(std::fabs(c[i]), 1.0 / static_cast<double>(i)));
    if (radius == 0.0) return std::vector<Complex>(n);
    std::vector<Complex> roots(n);
    for (std::size_t i = 0; i < n; ++i)
        roots[i] = std::polar(radius, (6.283185307179586 * static_cast<double>(i) + 0.4) /
                                          static_cast<double>(n));
    for (int sweep = 0; sweep < 200; ++sweep) {
        double moved = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            Complex value = c[0], slope = 0.0;
            for (std::size_t j = 1; j <= n; ++j) {
                slope = slope * roots[i] + value;
                value = value * roots[i] + c[j];
            }
            if (value == 0.0) continue;
            Complex others = 0.0;
            for (std::size_t j = 0; j < n; ++j)
                if (j != i && roots[j] != roots[i]) others += 1.0 / (roots[i] - roots[j]);
            const Complex step = value / (slope - value * others);
            if (!std::isfinite(step.real()) || !std::isfinite(step.imag())) continue;
            roots[i] -= step;
            moved = std::max(moved, std::abs(step) / std::max(std::abs(roots[i]), 1e-300));
        }
        if (moved < 1e-15) break;
    }
    return roots;
}

// Replaces every root outside the unit circle by the reciprocal of its conjugate, and pulls what is
// outside a circle within onto that; false where no root is outside it and nothing changes.
inline bool reflect(std::vector<double>& c, double radius = 1.0) {
    if (c.size() < 2) return false;
    std::vector<double> scaled = c;
    double power = 1.0;
    for (double& one : scaled) {
        one /= power;
        power *= radius;
    }
    if (is_schur(std::move(scaled))) return false;
    std::vector<std::complex<double>> product{1.0};
    bool reflected = false;
    for (std::complex<double> root : polynomial_roots(c)) {
        const double size = std::abs(root);
        if (size > radius) {
            root = size > 1.0 / radius ? 1.0 / std::conj(root) : root / size * radius;
            reflected = true;
        }
        product.push_back(0.0);
        for (std::size_t i = product.size() - 1; i > 0; --i) product[i] -= root * product[i - 1];
    }
    if (reflected)  // conjugate roots come in pairs, so the imaginary parts are rounding
        for (std::size_t i = 0; i < c.size(); ++i) c[i] = product[i].real();
    return reflected;
}

}  // namespace rcac
