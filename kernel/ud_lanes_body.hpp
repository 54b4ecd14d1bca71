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

// A block of up to 8 columns from column j on, in the lanes of one vector; all pointers below point
// at these lanes. `u` is entry (0, j).
struct LaneBlock {
    std::size_t j, columns;
    Vec f[8], v[8], factor[8];
};

// Entry (0, j + c) of a block whose entry (0, j) is u.
RCAC_INLINE std::size_t lane_column(std::size_t j, std::size_t c) {
    return (c * j + c * (c - (c > 0)) / 2) * lanes;
}

template <std::size_t C>
RCAC_INLINE void lane_dots(LaneBlock& block, const double* u, const double* row) {
    const std::size_t j = block.j;
    Vec f[C];
    for (std::size_t c = 0; c < C; ++c) f[c] = load(row + (j + c) * lanes);
    for (std::size_t i = 0; i < j; ++i) {
        const Vec phi = load(row + i * lanes);
        for (std::size_t c = 0; c < C; ++c)
            f[c] = f[c] + load(u + lane_column(j, c) + i * lanes) * phi;
    }
    for (std::size_t c = 1; c < C; ++c)
        for (std::size_t k = 0; k < c; ++k)
            f[c] = f[c] + load(u + lane_column(j, c) + (j + k) * lanes) * load(row + (j + k) * lanes);
    for (std::size_t c = 0; c < C; ++c) block.f[c] = f[c];
}

// D, and v and the factors -f_j / alpha_{j-1} for the columns. One division to a column, which
// costs an ulp: two would be what short columns wait for.
RCAC_INLINE Vec lane_scalars(LaneBlock& block, const double* u, double* RCAC_RESTRICT D,
                             const double* row, Vec alpha, const double* noise, unsigned& lost) {
    Vec inverse = all(1.0) / alpha;
    for (std::size_t c = 0; c < block.columns; ++c) {
        const std::size_t j = block.j + c;
        const Vec f = block.f[c], d = load(D + j * lanes), v = d * f;
        block.v[c] = v;
        block.factor[c] = -f * inverse;
        if (noise)
            for (std::size_t k = 0; k < width; ++k)
                if (d[k] * noise[k] > alpha[k] &&
                    lane_lost(row + k, u + lane_column(block.j, c) + k, j, f[k], d[k], alpha[k]))
                    lost |= 1u << k;
        const Vec grown = alpha + v * f;
        inverse = all(1.0) / grown;
        store(D + j * lanes, where_zero(f, d, d * (alpha * inverse)));
        alpha = grown;
    }
    return alpha;
}

template <std::size_t C>
RCAC_INLINE void lane_advance(const LaneBlock& block, double* RCAC_RESTRICT u,
                              double* RCAC_RESTRICT gain) {
    const std::size_t j = block.j;
    Vec v[C], factor[C];
    for (std::size_t c = 0; c < C; ++c) v[c] = block.v[c], factor[c] = block.factor[c];
    for (std::size_t i = 0; i < j; ++i) {
        Vec g = load(gain + i * lanes);
        for (std::size_t c = 0; c < C; ++c) {
            double* place = u + lane_column(j, c) + i * lanes;
            const Vec old = load(place);
            store(place, old + factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + i * lanes, g);
    }
    for (std::size_t k = 0; k < C; ++k) {  // the small triangle inside the block
        Vec g = v[k];
        for (std::size_t c = k + 1; c < C; ++c) {
            double* place = u + lane_column(j, c) + (j + k) * lanes;
            const Vec old = load(place);
            store(place, old + factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + (j + k) * lanes, g);
    }
}

RCAC_INLINE void lane_dots(LaneBlock& block, const double* u, const double* row, std::size_t n) {
    const std::size_t left = n - block.j;
    block.columns = left >= 8 ? 8 : left >= 4 ? 4 : left >= 2 ? 2 : left;
    switch (block.columns) {
        case 8: return lane_dots<8>(block, u, row);
        case 4: return lane_dots<4>(block, u, row);
        case 2: return lane_dots<2>(block, u, row);
        case 1: return lane_dots<1>(block, u, row);
    }
}

RCAC_INLINE void lane_advance(const LaneBlock& block, double* u, double* gain) {
    switch (block.columns) {
        case 8: return lane_advance<8>(block, u, gain);
        case 4: return lane_advance<4>(block, u, gain);
        case 2: return lane_advance<2>(block, u, gain);
        case 1: return lane_advance<1>(block, u, gain);
    }
}

inline unsigned lanes_rank_one(const UdLaneFactors& factors, const double* row, const double* r,
                               double* gain, double* alpha) {
    constexpr std::size_t halves = lanes / width;
    const std::size_t n = factors.n;
    Vec grown[halves];
    alignas(64) double noise[lanes];
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
        store(noise + h * width, size * size);
        // A lane's guard can only speak where spread * noise exceeds r.
        if (largest_of(spread * size * size - grown[h]) > 0.0) guarded = true;
    }
    unsigned lost[halves] = {};
    // Scalars of one block, dots of the next, then columns of the first: the dots, which need
    // neither, run while the scalars wait for their divisions.
    LaneBlock block[2][halves];
    double* u = factors.U;
    for (std::size_t h = 0; h < halves; ++h) {
        block[0][h].j = 0;
        lane_dots(block[0][h], u + h * width, row + h * width, n);
    }
    for (std::size_t now = 0;; now = 1 - now) {
        const std::size_t j = block[now][0].j, columns = block[now][0].columns;
        double* next = u + lane_column(j, columns);
        for (std::size_t h = 0; h < halves; ++h)
            grown[h] = lane_scalars(block[now][h], u + h * width, factors.D + h * width,
                                    row + h * width, grown[h],
                                    guarded ? noise + h * width : nullptr, lost[h]);
        if (j + columns < n)
            for (std::size_t h = 0; h < halves; ++h) {
                block[1 - now][h].j = j + columns;
                lane_dots(block[1 - now][h], next + h * width, row + h * width, n);
            }
        for (std::size_t h = 0; h < halves; ++h)
            lane_advance(block[now][h], u + h * width, gain + h * width);
        u = next;
        if (j + columns == n) break;
    }
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
