// The covariance recursion on the tiles of one triangle, written once for every vector width.
//
// The pass that computes P phi also carries out the rank-one update of the measurement before:
// every tile is loaded and stored once per measurement, three multiply-adds to an entry. This is
// the least that a covariance form can do and therefore the yardstick of the factorised one.
#pragma once

#include "simd/levels.hpp"
#include "simd/vectors.hpp"

namespace rcac::RCAC_LEVEL {

// Left and right multiplication of one tile above the diagonal, or of the symmetric tile on it.
template <bool scaled, bool diagonal>
RCAC_INLINE void symmetric_tile(double* RCAC_RESTRICT P, const double* RCAC_RESTRICT gain,
                                const double* RCAC_RESTRICT row, double* RCAC_RESTRICT y, Vec scale,
                                Vec coefficient, const Vec* right_gain, const Vec* right_row, Vec* sum) {
    for (std::size_t p = 0; p < parts; ++p) {
        const Vec g = load(gain + p * width), phi = load(row + p * width);
        Vec even = load(y + p * width), odd = zero();  // two sums wait half as long
        for (std::size_t c = 0; c < tile; ++c) {
            double* place = P + c * tile + p * width;
            Vec entry = load(place);
            if (scaled) entry = entry * scale;
            // On the diagonal (g_i g_c) times the coefficient, the same for (i, c) and (c, i).
            entry = entry + (diagonal ? (g * right_gain[c]) * coefficient : g * right_gain[c]);
            store(place, entry);
            if (c % 2 == 0) even = even + entry * right_row[c];
            else odd = odd + entry * right_row[c];
            if (!diagonal) sum[c] = sum[c] + entry * phi;
        }
        store(y + p * width, even + odd);
    }
}

// P <- scale P + coefficient gain gain', then y = P row.
template <bool scaled>
inline void symmetric_pass(const SymmetricTiles& tiles, const double* RCAC_RESTRICT row,
                           double* RCAC_RESTRICT y) {
    const std::size_t blocks = padded_to_tiles(tiles.n) / tile;
    const double* RCAC_RESTRICT gain = tiles.gain;
    const Vec scale = all(tiles.scale), coefficient = all(tiles.coefficient);
    double* P = tiles.P;
    for (std::size_t j = 0; j < blocks * tile; j += width) store(y + j, zero());
    for (std::size_t J = 0; J < blocks; ++J) {
        Vec right_gain[tile], right_row[tile], sum[tile];
        for (std::size_t c = 0; c < tile; ++c) {
            right_gain[c] = all(tiles.coefficient * gain[J * tile + c]);
            right_row[c] = all(row[J * tile + c]);
            sum[c] = zero();
        }
        for (std::size_t I = 0; I < J; ++I, P += tile * tile)
            symmetric_tile<scaled, false>(P, gain + I * tile, row + I * tile, y + I * tile, scale,
                                          coefficient, right_gain, right_row, sum);
        for (std::size_t c = 0; c < tile; ++c) right_gain[c] = all(gain[J * tile + c]);
        symmetric_tile<scaled, true>(P, gain + J * tile, row + J * tile, y + J * tile, scale,
                                     coefficient, right_gain, right_row, sum);
        P += tile * tile;
        for (std::size_t p = 0; p < parts; ++p) {
            double* place = y + J * tile + p * width;
            store(place, load(place) + sums_of(sum + p * width));
        }
    }
}

inline double symmetric_measure(SymmetricTiles& tiles, const double* RCAC_RESTRICT phi,
                                double scale, double rhs, double r, double* RCAC_RESTRICT row,
                                double* RCAC_RESTRICT theta) {
    const std::size_t n = tiles.n, whole = n / width * width;
    double* y = tiles.next;
    Vec innovations = zero(), alphas = zero();
    for (std::size_t j = 0; j < whole; j += width) {
        const Vec scaled = load(phi + j) * all(scale);
        store(row + j, scaled);
        innovations = innovations + scaled * load(theta + j);
    }
    double innovation = rhs + sum_of(innovations);
    for (std::size_t j = whole; j < n; ++j) {
        row[j] = phi[j] * scale;
        innovation += row[j] * theta[j];
    }
    if (tiles.scale == 1.0)
        symmetric_pass<false>(tiles, row, y);
    else
        symmetric_pass<true>(tiles, row, y);
    for (std::size_t j = 0; j < padded_to_tiles(n); j += width)
        alphas = alphas + load(row + j) * load(y + j);
    const double alpha = r + sum_of(alphas), step = innovation / alpha;
    for (std::size_t j = 0; j < whole; j += width)
        store(theta + j, load(theta + j) - load(y + j) * all(step));
    for (std::size_t j = whole; j < n; ++j) theta[j] -= y[j] * step;
    tiles.next = tiles.gain;
    tiles.gain = y;
    tiles.scale = 1.0;
    tiles.coefficient = -1.0 / alpha;
    return alpha;
}

}  // namespace rcac::RCAC_LEVEL
