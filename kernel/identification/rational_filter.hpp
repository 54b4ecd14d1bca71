// Rational filters of the rows of a record: b(q^-1)/a(q^-1) with a_0 = 1, at rest before the first
// step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace rcac {

// The direct form II, transposed. A few rows at once, whose sums do not wait for one another.
class RationalFilter {
public:
    RationalFilter(std::vector<double> b, std::vector<double> a)
        : order_(std::max(a.size(), b.size()) - 1), b_(std::move(b)), a_(std::move(a)) {
        b_.resize(order_ + 1, 0.0);
        a_.resize(order_ + 1, 0.0);
        z_.resize((order_ + 1) * together);
    }

    // Rows stand one behind the other; `out` may be `in`.
    void rows(const double* in, double* out, std::size_t count, std::size_t steps) {
        std::size_t i = 0;
        for (; i + together <= count; i += together) some<together>(in, out, i, steps);
        if (i + 2 <= count) {
            some<2>(in, out, i, steps);
            i += 2;
        }
        if (i < count) some<1>(in, out, i, steps);
    }

private:
    static constexpr std::size_t together = 4, block = 64;
    // Of a decay: products of what follows would be denormal, and slow.
    static constexpr double negligible = 1e-140;

    template <std::size_t width>
    void some(const double* in, double* out, std::size_t first, std::size_t steps) {
        in += first * steps;
        out += first * steps;
        switch (order_) {  // of a known order the states stay in registers
            case 0: return known<width, 0>(in, out, steps);
            case 1: return known<width, 1>(in, out, steps);
            case 2: return known<width, 2>(in, out, steps);
            case 3: return known<width, 3>(in, out, steps);
            case 4: return known<width, 4>(in, out, steps);
            default: return run<width>(in, out, steps, order_, b_.data(), a_.data(), z_.data());
        }
    }

    template <std::size_t width, std::size_t order>
    void known(const double* in, double* out, std::size_t steps) {
        double b[order + 1], a[order + 1], z[(order + 1) * width];
        std::copy_n(b_.begin(), order + 1, b);
        std::copy_n(a_.begin(), order + 1, a);
        run<width>(in, out, steps, order, b, a, z);
    }

    template <std::size_t width>
    static inline void run(const double* in, double* out, std::size_t steps, std::size_t order,
                           const double* b, const double* a, double* z) {
        const std::size_t size = (order + 1) * width;
        std::fill_n(z, size, 0.0);
        for (std::size_t first = 0; first < steps; first += block) {
            const std::size_t last = std::min(first + block, steps);
            for (std::size_t k = first; k < last; ++k) {
                double x[width], y[width];
                for (std::size_t j = 0; j < width; ++j) x[j] = in[j * steps + k];
                for (std::size_t j = 0; j < width; ++j) y[j] = z[j] + b[0] * x[j];
                for (std::size_t i = 1; i <= order; ++i)
                    for (std::size_t j = 0; j < width; ++j)
                        z[(i - 1) * width + j] = z[i * width + j] + x[j] * b[i] - y[j] * a[i];
                for (std::size_t j = 0; j < width; ++j) out[j * steps + k] = y[j];
            }
            double largest = 0.0;
            for (std::size_t i = 0; i < size; ++i) largest = std::max(largest, std::fabs(z[i]));
            if (largest < negligible) std::fill_n(z, size, 0.0);
        }
    }

    std::size_t order_;
    std::vector<double> b_, a_, z_;
};

}  // namespace rcac
