// Products with a triangular matrix in tiles, written once for every vector width.
//
// U is upper triangular, laid out as in layout.hpp, its diagonal stored and zeros below. x has zeros
// behind its n numbers, and every vector padded_to_tiles(n) entries.
#pragma once

#include "simd/ud_rank_one.inl.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

// y = U' x; |y|^2.
inline double transposed_times(std::size_t n, const double* RCAC_RESTRICT U,
                               const double* RCAC_RESTRICT x, double* RCAC_RESTRICT y) {
    const std::size_t blocks = padded_to_tiles(n) / tile;
    Vec square = zero();
    for (std::size_t J = 0; J < blocks; ++J, y += tile) {
        Vec sum[tile];
        for (std::size_t c = 0; c < tile; ++c) sum[c] = zero();
        for (std::size_t I = 0; I < J; ++I, U += tile * tile) dot_tile<false>(U, x + I * tile, sum);
        dot_tile<true>(U, x + J * tile, sum);
        U += tile * tile;
        for (std::size_t p = 0; p < parts; ++p) {
            const Vec total = sums_of(sum + p * width);
            store(y + p * width, total);
            square = square + total * total;
        }
    }
    return sum_of(square);
}

// Eight rows of y = U x from one tile: four sums a row, because one would wait for each addition
// before the next.
template <bool diagonal>
RCAC_INLINE void times_tile(const double* U, const double* x, Vec (*sum)[4]) {
    for (std::size_t c = 0; c < tile; ++c) {
        const Vec weight = all(x[c]);
        for (std::size_t p = 0; p < parts; ++p)
            if (occupied<diagonal>(p, c))
                sum[p][c % 4] = sum[p][c % 4] + load(U + c * tile + p * width) * weight;
    }
}

// y = U x; y may be x.
inline void times(std::size_t n, const double* U, const double* x, double* y) {
    const std::size_t blocks = padded_to_tiles(n) / tile;
    for (std::size_t I = 0; I < blocks; ++I) {
        Vec sum[parts][4];
        for (std::size_t p = 0; p < parts; ++p)
            for (std::size_t c = 0; c < 4; ++c) sum[p][c] = zero();
        const double* place = U + (I * (I + 1) / 2 + I) * tile * tile;
        times_tile<true>(place, x + I * tile, sum);
        for (std::size_t J = I + 1; J < blocks; ++J) {
            place += J * tile * tile;
            times_tile<false>(place, x + J * tile, sum);
        }
        for (std::size_t p = 0; p < parts; ++p)
            store(y + I * tile + p * width, (sum[p][0] + sum[p][1]) + (sum[p][2] + sum[p][3]));
    }
}

inline double dot(std::size_t n, const double* RCAC_RESTRICT x, const double* RCAC_RESTRICT y) {
    Vec sum = zero();
    for (std::size_t j = 0; j < padded_to_tiles(n); j += width) sum = sum + load(x + j) * load(y + j);
    return sum_of(sum);
}

// 2 n'd + s (s + margin) with d = x - y and s the sum of reach_j |d_j|; nothing need be padded.
inline double growth(std::size_t size, const double* RCAC_RESTRICT reach,
                     const double* RCAC_RESTRICT n, const double* RCAC_RESTRICT x,
                     const double* RCAC_RESTRICT y, double margin) {
    Vec sum = zero(), inner = zero();
    std::size_t j = 0;
    for (; j + width <= size; j += width) {
        const Vec moved = load(x + j) - load(y + j);
        sum = sum + load(reach + j) * larger(moved, -moved);
        inner = inner + load(n + j) * moved;
    }
    double s = sum_of(sum), along = sum_of(inner);
    for (; j < size; ++j) {
        const double moved = x[j] - y[j];
        s += reach[j] * magnitude(moved);
        along += n[j] * moved;
    }
    return 2.0 * along + s * (s + margin);
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
