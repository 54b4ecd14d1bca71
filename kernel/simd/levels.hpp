// What costs time, once for each instruction set; one binary runs on every processor.
#pragma once

#include <cstddef>

namespace rcac {

// U of P = U D U' and the triangle of a symmetric P are cut into tiles of 8 x 8: block column by
// block column, inside a block column from the top down to the tile on the diagonal, inside a tile
// column by column. A column of a tile is one AVX-512 vector or two AVX ones, so 8 rows of an
// update are a load, fused multiply-adds and a store. The tile on the diagonal is stored in full.
// The last block is filled up with columns of the unit matrix (U) or zeros (P). These functions
// are static because the level_*.cpp files include them: see vectors.hpp.
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

// A symmetric P whose last rank-one update waits for the pass that reads P next:
// P = scale * (tiles) + coefficient * gain * gain'.
struct SymmetricTiles {
    std::size_t n;
    double* P;
    double* gain;  // of the last measurement
    double* next;  // as long as gain; the two change places at every measurement
    double scale, coefficient;
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

struct LaneArrays;

struct Level {
    const char* name;
    // One measurement of regressor `row` and variance r by Bierman's recursion: updates U and D,
    // leaves the unscaled gain in `gain` and returns alpha = r + row P row'. `lost` is set where
    // some direction's excitation was lost in rounding while its variance is so large that the
    // answer matters.
    double (*ud_rank_one)(const UdFactors& factors, const double* row, double r, double* gain,
                          bool& lost);
    // The same for the measurement  scale phi theta + rhs = 0  with theta; phi has n entries and
    // scale phi is left in `row`. False where alpha, theta or D left the range of float64.
    bool (*ud_measure)(const UdFactors& factors, const double* phi, double scale, double rhs,
                       double r, double* row, double* gain, double* theta, bool& lost);
    // The same measurement on a symmetric P; returns alpha.
    double (*symmetric_measure)(SymmetricTiles& tiles, const double* phi, double scale, double rhs,
                                double r, double* row, double* theta);
    // One measurement on each lane: r and alpha per lane, bit k of the result tells whether
    // lane k was lost. A lane whose row is zero keeps its factors to the bit.
    unsigned (*lanes_rank_one)(const UdLaneFactors& factors, const double* row, const double* r,
                               double* gain, double* alpha);
    // The same with theta, for the measurements  row theta + rhs = 0.
    unsigned (*lanes_measure)(const UdLaneFactors& factors, const double* row, const double* rhs,
                              const double* r, double* gain, double* theta, double* alpha);
    // Steps of whole closed loops in lock step, see lane_arrays.hpp.
    std::size_t (*lane_steps)(LaneArrays& arrays, std::size_t count);
    bool (*finite)(const double* values, std::size_t count);
};

// The levels that this processor runs, the one meant for it first and "plain" last.
struct Levels {
    const Level* const* first;
    std::size_t count;
};
Levels levels();

// The level of that name, or for "" the first; throws std::invalid_argument for one that this
// processor does not run. Tests ask for each in turn.
const Level& level(const char* name = "");

}  // namespace rcac
