// Bierman's rank-one update on tiles, written once for every vector width.
//
// With f = U' row and v_j = d_j f_j the recursion runs over the columns j = 1, ..., n:
//   alpha_j = alpha_{j-1} + v_j f_j,      d_j <- d_j alpha_{j-1} / alpha_j,
//   U_ij <- U_ij - (f_j / alpha_{j-1}) g_i,   g_i <- g_i + v_j U_ij (old),   i < j,   g_j = v_j.
// All f need the old U only and all alpha need f only, so a block of 8 columns is one pass of
// dot products, a few vector operations for 8 scalars at once, and one pass that carries g.
#pragma once

#include "levels.hpp"
#include "vectors.hpp"

namespace rcac::RCAC_LEVEL {

constexpr double epsilon = 2.220446049250313e-16;

// What the columns of a block need, kept from their scalars to the pass that carries the gain.
struct Block {
    alignas(64) double v[tile];
    alignas(64) double factor[tile];  // -f_j / alpha_{j-1}
    alignas(64) double before[tile];  // alpha_{j-1}
};

// One panel of rows of a block's dot products: eight columns, eight sums.
RCAC_INLINE void dot_panel(const double* U, const double* row, Vec* sum) {
    for (std::size_t p = 0; p < parts; ++p) {
        const Vec phi = load(row + p * width);
        for (std::size_t c = 0; c < tile; ++c)
            sum[c] = sum[c] + load(U + c * tile + p * width) * phi;
    }
}

// The columns of one block over P panels of rows, whose gain stays in registers, and the dot
// products of a later block over as many panels: within a panel every g waits for the one before
// it, and the dot products fill the gaps.
template <std::size_t P, bool with_dots>
RCAC_INLINE void advance_panels(double* RCAC_RESTRICT U, double* RCAC_RESTRICT gain, const Vec* v,
                                const Vec* factor, const double* RCAC_RESTRICT next,
                                const double* RCAC_RESTRICT row, Vec* sum) {
    constexpr std::size_t count = P * parts;
    Vec g[count], phi[count];
    for (std::size_t p = 0; p < count; ++p) g[p] = load(gain + p * width);
    if (with_dots)
        for (std::size_t p = 0; p < count; ++p) phi[p] = load(row + p * width);
    for (std::size_t c = 0; c < tile; ++c)
        for (std::size_t p = 0; p < count; ++p) {
            const std::size_t offset = p / parts * tile * tile + c * tile + p % parts * width;
            const Vec old = load(U + offset);
            store(U + offset, old + factor[c] * g[p]);
            g[p] = g[p] + v[c] * old;
            if (with_dots) sum[c] = sum[c] + load(next + offset) * phi[p];
        }
    for (std::size_t p = 0; p < count; ++p) store(gain + p * width, g[p]);
}

template <bool with_dots>
RCAC_INLINE void advance(double* RCAC_RESTRICT U, double* RCAC_RESTRICT gain, std::size_t panels,
                         const Vec* v, const Vec* factor, const double* RCAC_RESTRICT next,
                         const double* RCAC_RESTRICT row, Vec* sum) {
    constexpr std::size_t P = RCAC_PANELS;
    std::size_t I = 0;
    for (; I + P <= panels; I += P)
        advance_panels<P, with_dots>(U + I * tile * tile, gain + I * tile, v, factor,
                                     next + I * tile * tile, row + I * tile, sum);
    if constexpr (P > 1)
        for (; I < panels; ++I)
            advance_panels<1, with_dots>(U + I * tile * tile, gain + I * tile, v, factor,
                                         next + I * tile * tile, row + I * tile, sum);
}

// Whether f = row_j + sum U_ij row_i is no larger than the rounding errors of its terms while d_j
// is so large that an f of that size would decide the update: the data do not say whether this
// direction is excited, and with such a P(0) theta hangs on the answer.
inline bool lost_in_rounding(const double* row, const double* U, std::size_t j, double f, double d,
                             double alpha) {
    double size = magnitude(row[j]);
    for (std::size_t i = 0; i < j; ++i) size += magnitude(U[place_in_tiles(i, j)] * row[i]);
    const double error = 16.0 * epsilon * size;
    return magnitude(f) <= error && d * error * error > alpha;
}

// The scalars of block J from its f: D, and v and the factors for `advance`. Returns alpha.
RCAC_INLINE Vec scalars(const Vec* f, double* RCAC_RESTRICT D, Vec alpha, Block& block) {
    for (std::size_t p = 0; p < parts; ++p) {
        const Vec d = load(D + p * width), v = d * f[p];
        const Vec grown = alpha + running_sums(v * f[p]);
        const Vec previous = moved_up(grown, alpha);
        store(block.v + p * width, v);
        store(block.factor + p * width, -f[p] / previous);
        store(block.before + p * width, previous);
        store(D + p * width, where_zero(f[p], d, d * (previous / grown)));
        alpha = all(grown[width - 1]);
    }
    return alpha;
}

// Which columns of a block lost their excitation; D and U still as before the measurement.
inline bool any_lost(const UdFactors& factors, const double* row, std::size_t j, const Vec* f,
                     const Vec* d, const double* before, double noise) {
    alignas(64) double f_[tile], d_[tile];
    for (std::size_t p = 0; p < parts; ++p) {
        store(f_ + p * width, f[p]);
        store(d_ + p * width, d[p]);
    }
    for (std::size_t c = 0; c < tile; ++c)
        if (d_[c] * noise > before[c] &&
            lost_in_rounding(row, factors.U, j + c, f_[c], d_[c], before[c]))
            return true;
    return false;
}

// Three stages, so that the processor has columns to work on while it waits for the sums and
// divisions of the scalars: in turn J the dots of block J, the scalars of block J - 1 and the
// columns of block J - 2.
template <bool guarded>
inline double rank_one_loop(const UdFactors& factors, const double* RCAC_RESTRICT row, double r,
                            double* RCAC_RESTRICT gain, double noise, bool& lost) {
    const std::size_t blocks = padded_to_tiles(factors.n) / tile;
    double *D = factors.D, *columns = factors.U;
    const double* next = factors.U;
    Vec alpha = all(r), sum[tile], v[tile], factor[tile];
    for (std::size_t c = 0; c < tile; ++c) sum[c] = v[c] = factor[c] = zero();
    Block block;
    for (std::size_t J = 0; J < blocks + 2; ++J) {
        if (J >= 2)
            for (std::size_t c = 0; c < tile; ++c) {
                v[c] = all(block.v[c]);
                factor[c] = all(block.factor[c]);
            }
        if (J >= 1 && J <= blocks) {
            Vec f[parts], d[parts];
            for (std::size_t p = 0; p < parts; ++p) {
                f[p] = sums_of(sum + p * width);
                d[p] = load(D + p * width);
            }
            alpha = scalars(f, D, alpha, block);
            if (guarded && any_lost(factors, row, (J - 1) * tile, f, d, block.before, noise))
                lost = true;
            D += tile;
        }
        for (std::size_t c = 0; c < tile; ++c) sum[c] = zero();
        if (J < blocks) {
            std::size_t I = 0;
            if (J >= 2) {
                advance<true>(columns, gain, J - 1, v, factor, next, row, sum);
                I = J - 1;
            }
            for (; I <= J; ++I) dot_panel(next + I * tile * tile, row + I * tile, sum);
            next += (J + 1) * tile * tile;
        } else if (J >= 2) {
            advance<false>(columns, gain, J - 1, v, factor, next, row, sum);
        }
        if (J >= 2) columns += (J - 1) * tile * tile;
    }
    return alpha[0];
}

inline double rank_one(const UdFactors& factors, const double* row, double r, double* gain,
                       bool& lost) {
    const std::size_t padded = padded_to_tiles(factors.n);
    Vec largest = zero(), widest = zero();
    for (std::size_t j = 0; j < padded; j += width) {
        const Vec a = load(row + j), d = load(factors.D + j);
        largest = larger(larger(a, -a), largest);
        widest = larger(d, widest);
        store(gain + j, zero());
    }
    const double size = largest_of(largest), spread = largest_of(widest);
    // The guard's full test costs another pass over a column; a variance below alpha / noise
    // cannot need it, and alpha never falls below r.
    const double noise = (1024.0 * epsilon * size) * (1024.0 * epsilon * size);
    return spread * noise > r ? rank_one_loop<true>(factors, row, r, gain, noise, lost)
                              : rank_one_loop<false>(factors, row, r, gain, noise, lost);
}

inline bool measure(const UdFactors& factors, const double* row, double rhs, double r, double* gain,
                    double* theta, bool& lost) {
    const std::size_t n = factors.n, whole = n / width * width;
    Vec sum = zero();
    for (std::size_t j = 0; j < whole; j += width) sum = sum + load(row + j) * load(theta + j);
    double innovation = rhs + sum_of(sum);
    for (std::size_t j = whole; j < n; ++j) innovation += row[j] * theta[j];
    const double alpha = rank_one(factors, row, r, gain, lost);
    if (!(alpha - alpha == 0.0)) return false;
    const double scaled = innovation / alpha;
    for (std::size_t j = 0; j < whole; j += width)
        store(theta + j, load(theta + j) - load(gain + j) * all(scaled));
    for (std::size_t j = whole; j < n; ++j) theta[j] -= gain[j] * scaled;
    return true;
}

// x * 0 is 0 for every finite x and not a number for the others.
inline bool finite(const double* values, std::size_t count) {
    const std::size_t whole = count / width * width;
    Vec sum = zero();
    for (std::size_t j = 0; j < whole; j += width) sum = sum + load(values + j) * zero();
    double rest = sum_of(sum);
    for (std::size_t j = whole; j < count; ++j) rest += values[j] * 0.0;
    return rest == 0.0;
}

}  // namespace rcac::RCAC_LEVEL
