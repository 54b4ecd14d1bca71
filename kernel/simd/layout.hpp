// How the numbers of an update lie in memory, the same for every instruction set.
#pragma once

#include <cstddef>

namespace rcac {

// U of P = U D U' is cut into tiles of 8 x 8: block column by block column, inside a block column
// from the top down to the tile on the diagonal, inside a tile column by column. A column of a tile
// is one AVX-512 vector or two AVX ones, so 8 rows of an update are a load, fused multiply-adds and
// a store. The tile on the diagonal is stored in full. The last block is filled up with columns of
// the unit matrix. These functions are static because every instruction set's file includes them:
// see vectors.hpp.
constexpr std::size_t tile_size = 8;
static inline std::size_t padded_to_tiles(std::size_t n) {
    return (n + tile_size - 1) / tile_size * tile_size;
}
static inline std::size_t tiles_size(std::size_t n) {
    const std::size_t blocks = padded_to_tiles(n) / tile_size;
    return blocks * (blocks + 1) / 2 * tile_size * tile_size;
}
// Place of entry (i, j), i <= j; on the diagonal tile also i > j.
static inline std::size_t place_in_tiles(std::size_t i, std::size_t j) {
    const std::size_t I = i / tile_size, J = j / tile_size;
    return ((J * (J + 1) / 2 + I) * tile_size + j % tile_size) * tile_size + i % tile_size;
}

// Every array below starts at a multiple of 64 bytes; `row`, `gain` and D have padded_to_tiles(n)
// entries, `row` and D with zeros behind n. phi and theta may lie anywhere and have n.
struct UdFactors {
    std::size_t n;
    double* U;  // unit upper triangular, tiles_size(n)
    double* D;
};

// Lanes of independent runs in lock step: D, row, gain and theta hold entry i of lane k at
// [i * lanes + k]. U is cut into blocks of 4 columns, in a block row by row the entries above its
// triangle and then the triangle column by column, so that one pointer walks through all of it.
constexpr std::size_t lanes = 8;
constexpr std::size_t lane_block = 4;
// Place of U_ij, i < j, of lane 0; lane k is k further.
static inline std::size_t lane_place(std::size_t n, std::size_t i, std::size_t j) {
    const std::size_t first = j / lane_block * lane_block, c = j - first;
    const std::size_t columns = n - first < lane_block ? n - first : lane_block;
    const std::size_t inside = i < first ? i * columns + c
                                         : first * columns + c * (c - (c > 0)) / 2 + (i - first);
    return (first * (first - (first > 0)) / 2 + inside) * lanes;
}
struct UdLaneFactors {
    std::size_t n;
    double* U;
    double* D;
};

}  // namespace rcac
