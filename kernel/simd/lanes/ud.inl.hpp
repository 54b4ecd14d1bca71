// Bierman's rank-one update on independent lanes, written once for every vector width.
//
// A vector holds the same entry of several runs, so nothing is ever summed across a vector and
// nothing is padded: short regressors run at full width. The recursion is that of
// ud_rank_one.inl.hpp; four columns share one pass over the rows, which reads and writes the gain
// once for all of them and takes the dots of a later block.
#pragma once

#include "simd/layout.hpp"
#include "simd/vectors.hpp"

#if defined(__clang__)  // a loop whose length is not known is not unrolled
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

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

// The columns of a block from column j on, a multiple of 4. Here and below every pointer but U points
// at the lanes of one vector, and u is the first entry of the block's columns.

// f = U' row of C columns over the rows before `end`.
template <std::size_t C>
RCAC_INLINE void lane_dots(std::size_t begin, std::size_t end, const double* u, const double* row,
                           Vec* f) {
    for (std::size_t i = begin; i < end; ++i) {
        const Vec phi = load(row + i * lanes);
        RCAC_UNROLL for (std::size_t c = 0; c < C; ++c)
            f[c] = f[c] + load(u + (i * C + c) * lanes) * phi;
    }
}

// The same over the triangle of the block and the unit diagonal.
template <std::size_t C>
RCAC_INLINE void lane_dots_of_triangle(std::size_t j, const double* u, const double* row, Vec* f) {
    u += C * j * lanes, row += j * lanes;
    RCAC_UNROLL for (std::size_t c = 0; c < C; ++c) {
        RCAC_UNROLL for (std::size_t k = 0; k < c; ++k)
            f[c] = f[c] + load(u + (c * (c - 1) / 2 + k) * lanes) * load(row + k * lanes);
        f[c] = f[c] + load(row + c * lanes);
    }
}

template <std::size_t C>
RCAC_INLINE void lane_whole_dots(std::size_t j, const double* u, const double* row, Vec* f) {
    RCAC_UNROLL for (std::size_t c = 0; c < C; ++c) f[c] = zero();
    if constexpr (C > 0) {  // else there may be no rows before j either
        lane_dots<C>(0, j, u, row, f);
        lane_dots_of_triangle<C>(j, u, row, f);
    }
}

// The C columns from j on with their v and factors, and on the way f of the N columns from j + 8 on:
// every g waits for the one before it and every entry is stored, and the dots fill the gaps.
template <std::size_t C, std::size_t N>
RCAC_INLINE void lane_advance(std::size_t j, double* RCAC_RESTRICT u, double* RCAC_RESTRICT gain,
                              const Vec* v, const Vec* factor, const double* RCAC_RESTRICT next,
                              const double* RCAC_RESTRICT row, Vec* f) {
    RCAC_UNROLL for (std::size_t c = 0; c < lane_block; ++c) f[c] = zero();
    for (std::size_t i = 0; i < j; ++i) {
        Vec g = load(gain + i * lanes);
        RCAC_UNROLL for (std::size_t c = 0; c < C; ++c) {
            double* place = u + (i * C + c) * lanes;
            const Vec old = load(place);
            store(place, old - factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + i * lanes, g);
        if constexpr (N > 0) lane_dots<N>(i, i + 1, next, row, f);
    }
    u += C * j * lanes;
    RCAC_UNROLL for (std::size_t k = 0; k < C; ++k) {
        Vec g = v[k];
        RCAC_UNROLL for (std::size_t c = k + 1; c < C; ++c) {
            double* place = u + (c * (c - 1) / 2 + k) * lanes;
            const Vec old = load(place);
            store(place, old - factor[c] * g);
            g = g + v[c] * old;
        }
        store(gain + (j + k) * lanes, g);
    }
    if constexpr (N > 0) {
        lane_dots<N>(j, j + 2 * lane_block, next, row, f);
        lane_dots_of_triangle<N>(j + 2 * lane_block, next, row, f);
    }
}

// D, v and the factors of the C columns from j on. One division to a column costs an ulp; two would
// be what short columns wait for. Returns alpha.
template <std::size_t C, bool guarded>
RCAC_INLINE Vec lane_scalars(const UdLaneFactors& factors, std::size_t j, std::size_t h,
                             const double* row, Vec alpha, const Vec* f, const double* noise,
                             Vec* v, Vec* factor, unsigned& lost) {
    Vec inverse = all(1.0) / alpha;
    double* D = factors.D + j * lanes + h;
    RCAC_UNROLL for (std::size_t c = 0; c < C; ++c) {
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
    return alpha;
}

template <std::size_t C>
struct Columns {
    static constexpr std::size_t count = C;
};
// Calls what with the number of columns, at most 4. Not by pointers to functions: without
// optimisation those cannot be inlined.
template <class What>
RCAC_INLINE void with_columns(std::size_t columns, const What& what) {
    switch (columns) {
        case 0: return what(Columns<0>{});
        case 1: return what(Columns<1>{});
        case 2: return what(Columns<2>{});
        case 3: return what(Columns<3>{});
        default: return what(Columns<4>{});
    }
}

// In turn the scalars of a block, and its columns beside the dots of the block after the next: those
// of the next are there, so that its scalars need not wait for these columns.
// N is the number of coefficients, or 0 where the compiler does not know it.
template <std::size_t N, bool guarded>
inline unsigned lanes_loop(const UdLaneFactors& factors, const double* row, const double* r,
                           double* gain, const double* noise, double* alpha) {
    constexpr std::size_t halves = lanes / width, block = lane_block;
    const std::size_t n = N > 0 ? N : factors.n;
    const auto left = [&](std::size_t j) { return j < n ? n - j : 0; };
    const auto entries = [&](std::size_t j) {  // of the block from column j on
        const std::size_t c = left(j) < block ? left(j) : block;
        return c * j + c * (c - (c > 0)) / 2;
    };
    unsigned lost = 0;
    Vec grown[halves], f[halves][block] = {}, f_next[halves][block] = {};
    double* u = factors.U;
    for (std::size_t k = 0, h = 0; k < halves; ++k, h += width) {
        grown[k] = load(r + h);
        with_columns(n, [&](auto c) { lane_whole_dots<c.count>(0, u + h, row + h, f[k]); });
        const double* next = u + entries(0) * lanes + h;
        with_columns(left(block), [&](auto c) {
            lane_whole_dots<c.count>(block, next, row + h, f_next[k]);
        });
    }
    RCAC_UNROLL for (std::size_t j = 0; j < n; u += entries(j) * lanes, j += block)
        for (std::size_t k = 0, h = 0; k < halves; ++k, h += width) {
            Vec v[block], factor[block], f_last[block];
            if (left(j) < block) {
                with_columns(left(j), [&](auto c) {
                    grown[k] = lane_scalars<c.count, guarded>(
                        factors, j, h, row + h, grown[k], f[k], noise + h, v, factor, lost);
                    lane_advance<c.count, 0>(j, u + h, gain + h, v, factor, u, row, f_last);
                });
                continue;
            }
            grown[k] = lane_scalars<block, guarded>(factors, j, h, row + h, grown[k], f[k],
                                                    noise + h, v, factor, lost);
            const double* next = u + (entries(j) + entries(j + block)) * lanes + h;
            with_columns(left(j + 2 * block), [&](auto c) {
                lane_advance<block, c.count>(j, u + h, gain + h, v, factor, next, row + h, f_last);
            });
            RCAC_UNROLL for (std::size_t c = 0; c < block; ++c) {
                f[k][c] = f_next[k][c];
                f_next[k][c] = f_last[c];
            }
        }
    for (std::size_t k = 0; k < halves; ++k) store(alpha + k * width, grown[k]);
    return lost;
}

// Up to here the size is known where this is compiled, which saves a seventh of the time at n = 20.
// Vectors of 2 gain nothing, and those of 4 beside AVX-512 are nobody's choice: see dispatch.cpp.
#if RCAC_WIDTH == 8 || (RCAC_WIDTH == 4 && !defined(__AVX512F__))
constexpr std::size_t most_lane_columns = 24;
#else
constexpr std::size_t most_lane_columns = 0;
#endif

using LanesLoop = decltype(lanes_loop<0, false>);
struct LanesLoops {
    LanesLoop* of[most_lane_columns + 1];
    constexpr LanesLoops() : of() { put<most_lane_columns>(); }
    template <std::size_t N>
    constexpr void put() {
        of[N] = &lanes_loop<N, false>;
        if constexpr (N > 0) put<N - 1>();
    }
};

inline unsigned lanes_columns(const UdLaneFactors& factors, const double* row, const double* r,
                              double* gain, const double* noise, bool guarded, double* alpha) {
    static constexpr LanesLoops loops;
    LanesLoop* const loop = guarded ? &lanes_loop<0, true>
                                    : loops.of[factors.n <= most_lane_columns ? factors.n : 0];
    return loop(factors, row, r, gain, noise, alpha);
}

// With theta the innovations are taken on the way, and theta moves at the end.
template <bool with_theta>
inline unsigned lanes_update(const UdLaneFactors& factors, const double* row, const double* rhs,
                             const double* r, double* gain, double* theta, double* alpha) {
    alignas(64) double noise[lanes], innovation[lanes];
    const std::size_t n = factors.n;
    bool guarded = false;
    for (std::size_t h = 0; h < lanes; h += width) {
        Vec size = zero(), spread = zero(), sum = zero(), odd = zero();
        for (std::size_t j = 0; j < n; ++j) {
            const Vec phi = load(row + j * lanes + h);
            size = larger(larger(phi, -phi), size);
            spread = larger(load(factors.D + j * lanes + h), spread);
            if (!with_theta) continue;
            if (j % 2)
                odd = odd + phi * load(theta + j * lanes + h);
            else
                sum = sum + phi * load(theta + j * lanes + h);
        }
        if (with_theta) store(innovation + h, load(rhs + h) + (sum + odd));
        size = size * all(1024.0 * lanes_epsilon);
        store(noise + h, size * size);
        // A lane's guard can only speak where spread * noise exceeds r.
        if (largest_of(spread * (size * size) - load(r + h)) > 0.0) guarded = true;
    }
    const unsigned lost = lanes_columns(factors, row, r, gain, noise, guarded, alpha);
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
