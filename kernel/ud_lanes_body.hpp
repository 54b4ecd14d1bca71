// Bierman's rank-one update on independent lanes, written once for every vector width.
//
// A vector holds the same entry of several runs, so nothing is ever summed across a vector and
// nothing is padded: short regressors run at full width. The recursion is that of
// ud_rank_one_body.hpp; four columns share one pass over the rows, which reads and writes the gain
// once for all of them.
#pragma once

#include "levels.hpp"
#include "vectors.hpp"

namespace rcac::RCAC_LEVEL {

constexpr double lanes_epsilon = 2.220446049250313e-16;

// The guard of ud_rank_one_body.hpp on one lane; u is the lane's column above the diagonal.
inline bool lane_lost(const double* row, const double* u, std::size_t j, double f, double d,
                      double alpha) {
    double size = magnitude(row[j * lanes]);
    for (std::size_t i = 0; i < j; ++i) size += magnitude(u[i * lanes] * row[i * lanes]);
    const double error = 16.0 * lanes_epsilon * size;
    return magnitude(f) <= error && d * error * error > alpha;
}

// C columns from j on, in the lanes of one vector. `U`, `D`, `row` and `gain` point at these lanes
// of the first of their entries, `u` at entry (0, j). Returns alpha.
template <std::size_t C>
RCAC_INLINE Vec lane_columns(double* RCAC_RESTRICT u, double* RCAC_RESTRICT D,
                             const double* RCAC_RESTRICT row, double* RCAC_RESTRICT gain,
                             std::size_t j, Vec alpha, const double* noise, unsigned& lost) {
    double* column[C];
    column[0] = u;
    for (std::size_t c = 1; c < C; ++c) column[c] = column[c - 1] + (j + c - 1) * lanes;
    Vec f[C], other[C], v[C], factor[C];
    for (std::size_t c = 0; c < C; ++c) f[c] = other[c] = zero();
    std::size_t i = 0;
    for (; i + 2 <= j; i += 2) {
        const Vec phi = load(row + i * lanes), below = load(row + (i + 1) * lanes);
        for (std::size_t c = 0; c < C; ++c) {
            f[c] = f[c] + load(column[c] + i * lanes) * phi;
            other[c] = other[c] + load(column[c] + (i + 1) * lanes) * below;
        }
    }
    for (; i < j; ++i)
        for (std::size_t c = 0; c < C; ++c)
            f[c] = f[c] + load(column[c] + i * lanes) * load(row + i * lanes);
    for (std::size_t c = 0; c < C; ++c) {
        f[c] = f[c] + other[c];
        for (std::size_t k = 0; k < c; ++k)
            f[c] = f[c] + load(column[c] + (j + k) * lanes) * load(row + (j + k) * lanes);
        f[c] = f[c] + load(row + (j + c) * lanes);
    }
    // One division to a column: it would otherwise be what a short column waits for.
    Vec inverse = all(1.0) / alpha;
    for (std::size_t c = 0; c < C; ++c) {
        const Vec d = load(D + (j + c) * lanes);
        v[c] = d * f[c];
        factor[c] = -f[c] * inverse;
        if (noise)
            for (std::size_t k = 0; k < width; ++k)
                if (d[k] * noise[k] > alpha[k] &&
                    lane_lost(row + k, column[c] + k, j + c, f[c][k], d[k], alpha[k]))
                    lost |= 1u << k;
        const Vec grown = alpha + v[c] * f[c];
        inverse = all(1.0) / grown;
        store(D + (j + c) * lanes, where_zero(f[c], d, d * (alpha * inverse)));
        alpha = grown;
    }
    for (i = 0; i < j; ++i) {
        Vec g = load(gain + i * lanes);
        for (std::size_t c = 0; c < C; ++c) {
            const Vec old = load(column[c] + i * lanes);
            store(column[c] + i * lanes, old + factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + i * lanes, g);
    }
    for (std::size_t k = 0; k < C; ++k) {  // the small triangle inside the block
        Vec g = v[k];
        for (std::size_t c = k + 1; c < C; ++c) {
            const Vec old = load(column[c] + (j + k) * lanes);
            store(column[c] + (j + k) * lanes, old + factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + (j + k) * lanes, g);
    }
    return alpha;
}

inline unsigned lanes_rank_one(const UdLaneFactors& factors, const double* row, const double* r,
                               double* gain, double* alpha) {
    constexpr std::size_t halves = lanes / width;
    const std::size_t n = factors.n;
    Vec grown[halves];
    double noise[lanes];
    bool guarded = false;
    for (std::size_t h = 0; h < halves; ++h) {
        Vec size = zero(), spread = zero();
        for (std::size_t j = 0; j < n; ++j) {
            const Vec a = load(row + j * lanes + h * width);
            size = larger(larger(a, -a), size);
            spread = larger(load(factors.D + j * lanes + h * width), spread);
        }
        grown[h] = load(r + h * width);
        size = size * all(1024.0 * lanes_epsilon);
        for (std::size_t k = 0; k < width; ++k) {
            noise[h * width + k] = size[k] * size[k];
            if (spread[k] * size[k] * size[k] > grown[h][k]) guarded = true;
        }
    }
    unsigned lost[halves] = {};
    double* u = factors.U;
    std::size_t j = 0;
    for (; j + 4 <= n; u += (4 * j + 6) * lanes, j += 4)
        for (std::size_t h = 0; h < halves; ++h)
            grown[h] = lane_columns<4>(u + h * width, factors.D + h * width, row + h * width,
                                       gain + h * width, j, grown[h],
                                       guarded ? noise + h * width : nullptr, lost[h]);
    for (; j < n; u += j * lanes, ++j)
        for (std::size_t h = 0; h < halves; ++h)
            grown[h] = lane_columns<1>(u + h * width, factors.D + h * width, row + h * width,
                                       gain + h * width, j, grown[h],
                                       guarded ? noise + h * width : nullptr, lost[h]);
    unsigned bits = 0;
    for (std::size_t h = 0; h < halves; ++h) {
        store(alpha + h * width, grown[h]);
        bits |= lost[h] << (h * width);
    }
    return bits;
}

inline unsigned lanes_measure(const UdLaneFactors& factors, const double* row, const double* rhs,
                              const double* r, double* gain, double* theta, double* alpha) {
    alignas(64) double innovation[lanes];
    for (std::size_t h = 0; h < lanes; h += width) {
        Vec even = load(rhs + h), odd = zero();
        for (std::size_t j = 0; j < factors.n; ++j) {
            const Vec term = load(row + j * lanes + h) * load(theta + j * lanes + h);
            if (j % 2 == 0) even = even + term;
            else odd = odd + term;
        }
        store(innovation + h, even + odd);
    }
    const unsigned lost = lanes_rank_one(factors, row, r, gain, alpha);
    for (std::size_t h = 0; h < lanes; h += width) {
        const Vec scaled = load(innovation + h) / load(alpha + h);
        for (std::size_t j = 0; j < factors.n; ++j) {
            double* place = theta + j * lanes + h;
            store(place, load(place) - load(gain + j * lanes + h) * scaled);
        }
    }
    return lost;
}

}  // namespace rcac::RCAC_LEVEL
