// Bierman's rank-one update on tiles, written once for every vector width.
//
// With f = U' row and v_j = d_j f_j the recursion runs over the columns j = 1, ..., n:
//   alpha_j = alpha_{j-1} + v_j f_j,      d_j <- d_j alpha_{j-1} / alpha_j,
//   U_ij <- U_ij - (f_j / alpha_{j-1}) g_i,   g_i <- g_i + v_j U_ij (old),   i < j,   g_j = v_j.
// All f need the old U only and all alpha need f only, so a block of 8 columns is one pass of
// dot products, a few vector operations for 8 scalars at once, and one pass that carries g.
#pragma once

#include "simd/layout.hpp"
#include "simd/vectors.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

constexpr double epsilon = 2.220446049250313e-16;

// What the columns of a block need, kept from their scalars to the pass that carries the gain.
struct Block {
    alignas(64) double v[tile];
    alignas(64) double factor[tile];  // f_j / alpha_{j-1}
    alignas(64) double before[tile];  // alpha_{j-1}, for the guard
};

// Whether rows p * width, ... of column c of a tile hold anything: on the diagonal they are zero
// below it, and nothing ever changes there.
template <bool diagonal>
constexpr bool occupied(std::size_t p, std::size_t c) {
    return !diagonal || c >= p * width;
}

// One tile of a block's dot products: eight columns, eight sums.
template <bool diagonal>
RCAC_INLINE void dot_tile(const double* U, const double* row, Vec* sum) {
    for (std::size_t p = 0; p < parts; ++p) {
        const Vec phi = load(row + p * width);
        for (std::size_t c = 0; c < tile; ++c)
            if (occupied<diagonal>(p, c))
                sum[c] = sum[c] + load(U + c * tile + p * width) * phi;
    }
}

// The columns of one tile, whose rows of the gain stay in registers, and the dot products of one
// tile of a later block: every g waits for the one before it, and the dot products fill the gaps.
template <bool diagonal, bool with_dots>
RCAC_INLINE void advance_tile(double* RCAC_RESTRICT U, double* RCAC_RESTRICT gain, const Vec* v,
                              const Vec* factor, const double* RCAC_RESTRICT next,
                              const double* RCAC_RESTRICT row, Vec* sum) {
    Vec g[parts], phi[parts];
    for (std::size_t p = 0; p < parts; ++p) g[p] = load(gain + p * width);
    if (with_dots)
        for (std::size_t p = 0; p < parts; ++p) phi[p] = load(row + p * width);
    for (std::size_t c = 0; c < tile; ++c)
        for (std::size_t p = 0; p < parts; ++p) {
            const std::size_t offset = c * tile + p * width;
            if (occupied<diagonal>(p, c)) {
                const Vec old = load(U + offset);
                store(U + offset, old - factor[c] * g[p]);
                g[p] = g[p] + v[c] * old;
            }
            if (with_dots) sum[c] = sum[c] + load(next + offset) * phi[p];
        }
    for (std::size_t p = 0; p < parts; ++p) store(gain + p * width, g[p]);
}

// Block J's columns, and the dot products of a later block over as many tiles.
template <bool with_dots>
RCAC_INLINE void advance(double* RCAC_RESTRICT U, double* RCAC_RESTRICT gain, std::size_t J,
                         const Vec* v, const Vec* factor, const double* RCAC_RESTRICT next,
                         const double* RCAC_RESTRICT row, Vec* sum) {
    for (std::size_t I = 0; I < J; ++I, U += tile * tile, gain += tile) {
        advance_tile<false, with_dots>(U, gain, v, factor, next, row, sum);
        if (with_dots) next += tile * tile, row += tile;
    }
    advance_tile<true, with_dots>(U, gain, v, factor, next, row, sum);
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

// The scalars of a block from its f: D, and v and the factors for `advance`. alpha holds its value
// before and after the block in its last lane.
template <bool guarded>
RCAC_INLINE Vec scalars(const Vec* f, double* RCAC_RESTRICT D, Vec alpha, Block& block) {
    for (std::size_t p = 0; p < parts; ++p) {
        const Vec d = load(D + p * width), v = d * f[p];
        const Vec grown = all(alpha[width - 1]) + running_sums(v * f[p]);
        const Vec previous = moved_up(grown, alpha);
        store(block.v + p * width, v);
        store(block.factor + p * width, f[p] / previous);
        if (guarded) store(block.before + p * width, previous);
        store(D + p * width, where_zero(f[p], d, d * (previous / grown)));
        alpha = grown;
    }
    return alpha;
}

// Whether a column of a block lost its excitation; d as before the measurement, and U too.
inline bool any_lost(const UdFactors& factors, const double* row, std::size_t j, const Vec* f,
                     const double* d, const double* before, double noise) {
    alignas(64) double f_[tile];
    for (std::size_t p = 0; p < parts; ++p) store(f_ + p * width, f[p]);
    for (std::size_t c = 0; c < tile; ++c)
        if (d[c] * noise > before[c] &&
            lost_in_rounding(row, factors.U, j + c, f_[c], d[c], before[c]))
            return true;
    return false;
}

// Three stages, so that the processor has columns to work on while it waits for the sums and
// divisions of the scalars: in turn J the dots of block J, the scalars of block J - 1 and the
// columns of block J - 2. `gain` is zero at the start.
template <bool guarded>
inline double rank_one_loop(const UdFactors& factors, const double* RCAC_RESTRICT row, double r,
                            double* RCAC_RESTRICT gain, double noise, bool& lost) {
    const std::size_t blocks = padded_to_tiles(factors.n) / tile;
    double *D = factors.D, *columns = factors.U;
    const double* next = factors.U;
    Vec alpha = all(r);
    Vec sum[tile], v[tile], factor[tile];
    for (std::size_t c = 0; c < tile; ++c) sum[c] = v[c] = factor[c] = zero();
    Block block;
    for (std::size_t J = 0; J < blocks + 2; ++J) {
        if (J >= 2)
            for (std::size_t c = 0; c < tile; ++c) {
                v[c] = all(block.v[c]);
                factor[c] = all(block.factor[c]);
            }
        if (J >= 1 && J <= blocks) {
            Vec f[parts];
            for (std::size_t p = 0; p < parts; ++p) f[p] = sums_of(sum + p * width);
            alignas(64) double d[tile];
            if (guarded)
                for (std::size_t c = 0; c < tile; ++c) d[c] = D[c];
            alpha = scalars<guarded>(f, D, alpha, block);
            if (guarded && any_lost(factors, row, (J - 1) * tile, f, d, block.before, noise))
                lost = true;
            D += tile;
        }
        for (std::size_t c = 0; c < tile; ++c) sum[c] = zero();
        if (J < blocks) {
            if (J >= 2) advance<true>(columns, gain, J - 2, v, factor, next, row, sum);
            const double* last = next + J * tile * tile;
            if (J >= 1) dot_tile<false>(last - tile * tile, row + (J - 1) * tile, sum);
            dot_tile<true>(last, row + J * tile, sum);
            next = last + tile * tile;
        } else if (J >= 2) {
            advance<false>(columns, gain, J - 2, v, factor, next, row, sum);
        }
        if (J >= 2) columns += (J - 1) * tile * tile;
    }
    return alpha[width - 1];
}

// The guard's full test costs another pass over a column; a variance below alpha / noise cannot
// need it, and alpha never falls below r.
inline double noise_of(double largest_row) {
    const double root = 1024.0 * epsilon * largest_row;
    return root * root;
}
inline bool may_be_lost(double largest_row, double largest_d, double r) {
    return largest_d * noise_of(largest_row) > r;
}

inline bool measure_by_tiles(const UdFactors& factors, const double* RCAC_RESTRICT phi,
                             double scale, double rhs, double r, double* RCAC_RESTRICT row,
                             double* RCAC_RESTRICT gain, double* RCAC_RESTRICT theta, bool& lost) {
    // Everything that is proportional to n takes two passes, one before and one after.
    const std::size_t n = factors.n, whole = n / width * width;
    Vec size = zero(), spread = zero(), sum = zero();
    for (std::size_t j = 0; j < whole; j += width) {
        const Vec scaled = load(phi + j) * all(scale);
        store(row + j, scaled);
        store(gain + j, zero());
        size = larger(larger(scaled, -scaled), size);
        spread = larger(load(factors.D + j), spread);
        sum = sum + scaled * load(theta + j);
    }
    double innovation = rhs + sum_of(sum), largest = largest_of(size), widest = largest_of(spread);
    for (std::size_t j = whole; j < n; ++j) {
        row[j] = phi[j] * scale;
        innovation += row[j] * theta[j];
        largest = magnitude(row[j]) > largest ? magnitude(row[j]) : largest;
        widest = factors.D[j] > widest ? factors.D[j] : widest;
    }
    for (std::size_t j = whole; j < padded_to_tiles(n); j += width) store(gain + j, zero());
    const double alpha =
        may_be_lost(largest, widest, r)
            ? rank_one_loop<true>(factors, row, r, gain, noise_of(largest), lost)
            : rank_one_loop<false>(factors, row, r, gain, 0.0, lost);
    const double step = innovation / alpha;
    // x * 0 is 0 for every finite x and not a number for the others.
    Vec check = zero();
    for (std::size_t j = 0; j < whole; j += width) {
        const Vec moved = load(theta + j) - load(gain + j) * all(step);
        store(theta + j, moved);
        check = check + moved * zero() + load(factors.D + j) * zero();
    }
    double rest = sum_of(check) + alpha * 0.0;
    for (std::size_t j = whole; j < n; ++j) {
        theta[j] -= gain[j] * step;
        rest += theta[j] * 0.0 + factors.D[j] * 0.0;
    }
    return rest == 0.0;
}

// The same with the number of blocks known to the compiler, for regressors so short that filling tiles of 8 up and
// waiting for the memory between the stages is most of the time: row, gain and theta stay in
// registers, a block has as many columns as a vector lanes, and its dots stand before the columns of
// the block before it. Every number is made by the operations of the tiles in their order, so both
// give the same bits.

template <std::size_t J>
RCAC_INLINE Vec block_dots(const double* U, const Vec* row) {
    Vec sum[width];
    RCAC_UNROLL for (std::size_t c = 0; c < width; ++c) {
        sum[c] = zero();
        RCAC_UNROLL for (std::size_t I = 0; I <= J; ++I)
            sum[c] = sum[c] + load(U + place_in_tiles(I * width, J * width + c)) * row[I];
    }
    return sums_of(sum);
}

template <std::size_t J>
RCAC_INLINE void block_columns(double* RCAC_RESTRICT U, Vec* gain, Vec v, Vec factor) {
    gain[J] = zero();
    RCAC_UNROLL for (std::size_t c = 0; c < width; ++c) {
        const Vec v_c = spread_lane(v, c), factor_c = spread_lane(factor, c);
        RCAC_UNROLL for (std::size_t I = 0; I <= J; ++I) {
            double* place = U + place_in_tiles(I * width, J * width + c);
            const Vec old = load(place);
            store(place, old - factor_c * gain[I]);
            gain[I] = gain[I] + v_c * old;
        }
    }
}

// Blocks J, ..., B - 1; f are the dots of block J. The last lane of the result is alpha.
template <std::size_t J, std::size_t B>
RCAC_INLINE Vec block_steps(double* RCAC_RESTRICT U, double* RCAC_RESTRICT D, const Vec* row,
                            Vec* gain, Vec alpha, Vec f) {
    const Vec d = load(D + J * width), v = d * f;
    const Vec grown = all(alpha[width - 1]) + running_sums(v * f);
    const Vec previous = moved_up(grown, alpha), factor = f / previous;
    store(D + J * width, where_zero(f, d, d * (previous / grown)));
    if constexpr (J + 1 < B) {
        const Vec next = block_dots<J + 1>(U, row);
        block_columns<J>(U, gain, v, factor);
        return block_steps<J + 1, B>(U, D, row, gain, grown, next);
    } else {
        block_columns<J>(U, gain, v, factor);
        return grown;
    }
}

// The first `count` of a vector's numbers, and zeros.
RCAC_INLINE Vec load_first(const double* p, std::size_t count) {
    if (count == width) return load(p);
    Vec a = zero();
    RCAC_UNROLL for (std::size_t c = 0; c < width; ++c)
        if (c < count) a[c] = p[c];
    return a;
}
RCAC_INLINE void store_first(double* p, std::size_t count, Vec a) {
    if (count == width) return store(p, a);
    RCAC_UNROLL for (std::size_t c = 0; c < width; ++c)
        if (c < count) p[c] = a[c];
}

// For n in the last block of B.
template <std::size_t B>
inline bool measure_by_blocks(const UdFactors& factors, const double* RCAC_RESTRICT phi,
                              double scale, double rhs, double r, double* row_room,
                              double* gain_room, double* RCAC_RESTRICT theta, bool& lost) {
    constexpr std::size_t last = (B - 1) * width;
    const std::size_t tail = factors.n - last;
    double* RCAC_RESTRICT D = factors.D;
    Vec row[B], gain[B], moved[B], size = zero(), spread = zero(), sum = zero();
    RCAC_UNROLL for (std::size_t I = 0; I < B; ++I) {
        const bool whole = I * width < last;
        row[I] = (whole ? load(phi + I * width) : load_first(phi + last, tail)) * all(scale);
        moved[I] = whole ? load(theta + I * width) : load_first(theta + last, tail);
        size = larger(larger(row[I], -row[I]), size);
        spread = larger(load(D + I * width), spread);
        if (whole || tail == width) sum = sum + row[I] * moved[I];
    }
    double innovation = rhs + sum_of(sum);
    RCAC_UNROLL for (std::size_t c = 0; c + 1 < width; ++c)
        if (c < tail && tail < width) innovation += row[B - 1][c] * moved[B - 1][c];
    if (may_be_lost(largest_of(size), largest_of(spread), r))
        return measure_by_tiles(factors, phi, scale, rhs, r, row_room, gain_room, theta, lost);
    const double alpha =
        block_steps<0, B>(factors.U, D, row, gain, all(r), block_dots<0>(factors.U, row))[width - 1];
    const double step = innovation / alpha;
    Vec check = zero();
    RCAC_UNROLL for (std::size_t I = 0; I < B; ++I) {
        moved[I] = moved[I] - gain[I] * all(step);
        if (I * width < last)
            store(theta + I * width, moved[I]);
        else
            store_first(theta + last, tail, moved[I]);
        check = check + moved[I] * zero() + load(D + I * width) * zero();
    }
    return sum_of(check) + alpha * 0.0 == 0.0;
}

// Beyond this a size of its own gains nothing: with vectors of 2 the registers do not hold it, with
// vectors of 8 nobody has measured.
#if defined(__GNUC__) || defined(__clang__)
constexpr std::size_t most_blocks = width == 2 ? 10 : width == 4 ? 6 : 0;
#else
constexpr std::size_t most_blocks = 0;
#endif

template <std::size_t B>
UdMeasure* measure_with(std::size_t blocks) {
    if constexpr (B == 0)
        return &measure_by_tiles;
    else
        return blocks == B ? &measure_by_blocks<B> : measure_with<B - 1>(blocks);
}

inline UdMeasure* ud_measure(std::size_t n) {
    return measure_with<most_blocks>((n + width - 1) / width);
}

inline bool finite(const double* values, std::size_t count) {
    const std::size_t whole = count / width * width;
    Vec sum = zero();
    for (std::size_t j = 0; j < whole; j += width) sum = sum + load(values + j) * zero();
    double rest = sum_of(sum);
    for (std::size_t j = whole; j < count; ++j) rest += values[j] * 0.0;
    return rest == 0.0;
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
