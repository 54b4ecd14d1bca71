// Bierman's rank-one update on independent lanes, written once for every vector width.
//
// A vector holds the same entry of several runs, so nothing is ever summed across a vector and
// nothing is padded: short regressors run at full width. The recursion is that of
// ud_rank_one.inl.hpp; four columns share one pass over the rows, which reads and writes the gain
// once for all of them.
#pragma once

#include "simd/layout.hpp"
#include "simd/vectors.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

constexpr double lanes_epsilon = 2.220446049250313e-16;

// The guard of ud_rank_one.inl.hpp on one lane; U and row point at it.
inline bool lane_lost(const double* row, const double* U, std::size_t n, std::size_t j, double f,
                      double d, double alpha) {
    double size = magnitude(row[j * lanes]);
    for (std::size_t i = 0; i < j; ++i)
        size += magnitude(U[lane_place(n, i, j)] * row[i * lanes]);
    const double error = 16.0 * lanes_epsilon * size;
    return magnitude(f) <= error && d * error * error > alpha;
}

// f of the C columns from column j on, a multiple of 4; here and below every pointer but U points
// at the lanes of one vector, and u is the first entry of the columns' block.
template <std::size_t C>
RCAC_INLINE void lane_dots(std::size_t j, const double* u, const double* row, Vec* result) {
    const double *phi = row, *end = row + j * lanes;
    Vec f[C], odd[C];
    for (std::size_t c = 0; c < C; ++c) {
        f[c] = load(end + c * lanes);
        odd[c] = zero();
    }
    for (; phi != end; phi += 2 * lanes, u += 2 * C * lanes)
        for (std::size_t c = 0; c < C; ++c) {
            f[c] = f[c] + load(u + c * lanes) * load(phi);
            odd[c] = odd[c] + load(u + (C + c) * lanes) * load(phi + lanes);
        }
    for (std::size_t c = 0; c < C; ++c) {
        for (std::size_t k = 0; k < c; ++k)
            f[c] = f[c] + load(u + (c * (c - 1) / 2 + k) * lanes) * load(phi + k * lanes);
        result[c] = f[c] + odd[c];
    }
}

RCAC_INLINE void lane_dots(std::size_t j, std::size_t n, const double* u, const double* row,
                           Vec* f) {
    if (n - j >= 4) return lane_dots<4>(j, u, row, f);
    switch (n - j) {
        case 3: return lane_dots<3>(j, u, row, f);
        case 2: return lane_dots<2>(j, u, row, f);
        case 1: return lane_dots<1>(j, u, row, f);
    }
}

template <std::size_t C>
RCAC_INLINE void lane_advance(std::size_t j, double* RCAC_RESTRICT u, double* RCAC_RESTRICT gain,
                              const Vec* v, const Vec* factor) {
    const double* end = gain + j * lanes;
    for (; gain != end; gain += lanes, u += C * lanes) {
        Vec g = load(gain);
        for (std::size_t c = 0; c < C; ++c) {
            const Vec old = load(u + c * lanes);
            store(u + c * lanes, old - factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain, g);
    }
    for (std::size_t k = 0; k < C; ++k) {  // the triangle of the block
        Vec g = v[k];
        for (std::size_t c = k + 1; c < C; ++c) {
            double* place = u + (c * (c - 1) / 2 + k) * lanes;
            const Vec old = load(place);
            store(place, old - factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + k * lanes, g);
    }
}

// Scalars of the C columns from j on, dots of the next block, then these columns: the dots, which
// need neither, run while the scalars wait for their divisions. One division to a column costs an
// ulp; two would be what short columns wait for. Returns alpha; f is replaced by the next.
template <std::size_t C, bool guarded>
RCAC_INLINE Vec lane_block_step(const UdLaneFactors& factors, std::size_t j, std::size_t h,
                                double* u, const double* row, double* gain, Vec alpha, Vec* f,
                                const double* noise, unsigned& lost) {
    Vec v[C], factor[C], inverse = all(1.0) / alpha;
    double* D = factors.D + j * lanes + h;
    for (std::size_t c = 0; c < C; ++c) {
        const Vec d = load(D + c * lanes);
        v[c] = d * f[c];
        const Vec grown = alpha + v[c] * f[c];
        factor[c] = f[c] * inverse;
        if (guarded)
            for (std::size_t k = 0; k < width; ++k)
                if (d[k] * noise[k] > alpha[k] &&
                    lane_lost(row + k, factors.U + h + k, factors.n, j + c, f[c][k], d[k],
                              alpha[k]))
                    lost |= 1u << (h + k);
        inverse = all(1.0) / grown;
        store(D + c * lanes, where_zero(f[c], d, d * (alpha * inverse)));
        alpha = grown;
    }
    if (j + C < factors.n)
        lane_dots(j + C, factors.n, u + (C * j + C * (C - 1) / 2) * lanes, row, f);
    lane_advance<C>(j, u, gain, v, factor);
    return alpha;
}

template <std::size_t C>
struct Columns {
    static constexpr std::size_t count = C;
};

template <bool guarded>
inline unsigned lanes_loop(const UdLaneFactors& factors, const double* row, const double* r,
                           double* gain, const double* noise, double* alpha) {
    constexpr std::size_t halves = lanes / width;
    const std::size_t n = factors.n, whole = n / lane_block * lane_block;
    unsigned lost = 0;
    Vec grown[halves], f[halves][lane_block];
    double* u = factors.U;
    for (std::size_t k = 0; k < halves; ++k) {
        grown[k] = load(r + k * width);
        lane_dots(0, n, u + k * width, row + k * width, f[k]);
    }
    for (std::size_t j = 0; j < whole; u += (lane_block * j + 6) * lanes, j += lane_block)
        for (std::size_t k = 0, h = 0; k < halves; ++k, h += width)
            grown[k] = lane_block_step<lane_block, guarded>(
                factors, j, h, u + h, row + h, gain + h, grown[k], f[k], noise + h, lost);
    for (std::size_t k = 0, h = 0; k < halves; ++k, h += width) {
        // Not by pointers to functions: without optimisation those cannot be inlined.
        const auto last = [&](auto columns) {
            grown[k] = lane_block_step<decltype(columns)::count, guarded>(
                factors, whole, h, u + h, row + h, gain + h, grown[k], f[k], noise + h, lost);
        };
        switch (n - whole) {
            case 3: last(Columns<3>{}); break;
            case 2: last(Columns<2>{}); break;
            case 1: last(Columns<1>{}); break;
        }
        store(alpha + h, grown[k]);
    }
    return lost;
}

// With theta the innovations are taken on the way, and theta moves at the end.
template <bool with_theta>
inline unsigned lanes_update(const UdLaneFactors& factors, const double* row, const double* rhs,
                             const double* r, double* gain, double* theta, double* alpha) {
    alignas(64) double noise[lanes], innovation[lanes];
    const std::size_t n = factors.n;
    bool guarded = false;
    for (std::size_t h = 0; h < lanes; h += width) {
        Vec size = zero(), spread = zero(), sum = zero();
        for (std::size_t j = 0; j < n; ++j) {
            const Vec phi = load(row + j * lanes + h);
            size = larger(larger(phi, -phi), size);
            spread = larger(load(factors.D + j * lanes + h), spread);
            if (with_theta) sum = sum + phi * load(theta + j * lanes + h);
        }
        if (with_theta) store(innovation + h, load(rhs + h) + sum);
        size = size * all(1024.0 * lanes_epsilon);
        store(noise + h, size * size);
        // A lane's guard can only speak where spread * noise exceeds r.
        if (largest_of(spread * (size * size) - load(r + h)) > 0.0) guarded = true;
    }
    const unsigned lost = guarded ? lanes_loop<true>(factors, row, r, gain, noise, alpha)
                                  : lanes_loop<false>(factors, row, r, gain, noise, alpha);
    if (with_theta)
        for (std::size_t h = 0; h < lanes; h += width) {
            const Vec step = load(innovation + h) / load(alpha + h);
            for (std::size_t j = 0; j < n; ++j) {
                double* place = theta + j * lanes + h;
                store(place, load(place) - load(gain + j * lanes + h) * step);
            }
        }
    return lost;
}

inline unsigned lanes_rank_one(const UdLaneFactors& factors, const double* row, const double* r,
                               double* gain, double* alpha) {
    return lanes_update<false>(factors, row, nullptr, r, gain, nullptr, alpha);
}

inline unsigned lanes_measure(const UdLaneFactors& factors, const double* row, const double* rhs,
                              const double* r, double* gain, double* theta, double* alpha) {
    return lanes_update<true>(factors, row, rhs, r, gain, theta, alpha);
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
