// What costs time, once for each instruction set; one binary runs on every processor.
#pragma once

#include "simd/layout.hpp"

namespace rcac {

struct LaneArrays;

// One measurement  scale phi theta + rhs = 0  of variance r by Bierman's recursion: updates U, D and
// theta; phi has n entries, and `row` and `gain` are room to work in. False where
// alpha = r + row P row', theta or D left the range of float64. `lost` is set where some direction's
// excitation was lost in rounding while its variance is so large that the answer matters.
using UdMeasure = bool(const UdFactors& factors, const double* phi, double scale, double rhs, double r,
                       double* row, double* gain, double* theta, bool& lost);

// The functions that one of the files beside this one compiles.
struct InstructionSet {
    const char* name;
    // What takes one measurement of n coefficients, see UdMeasure.
    UdMeasure* (*ud_measure)(std::size_t n);
    // One measurement on each lane: r and alpha per lane, bit k of the result tells whether
    // lane k was lost. A lane whose row is zero keeps its factors to the bit.
    unsigned (*lanes_rank_one)(const UdLaneFactors& factors, const double* row, const double* r,
                               double* gain, double* alpha);
    // The same with theta, for the measurements  row theta + rhs = 0.
    unsigned (*lanes_measure)(const UdLaneFactors& factors, const double* row, const double* rhs,
                              const double* r, double* gain, double* theta, double* alpha);
    // Steps of whole closed loops in lock step, see lanes/arrays.hpp.
    std::size_t (*lane_steps)(LaneArrays& arrays, std::size_t count);
    bool (*finite)(const double* values, std::size_t count);
    // With U upper triangular in tiles, see triangular.inl.hpp: y = U'x, which answers |y|^2; y = U x
    // in place; x'y; and by how much |v|^2 grows at most from y to x.
    double (*transposed_times)(std::size_t n, const double* U, const double* x, double* y);
    void (*times)(std::size_t n, const double* U, const double* x, double* y);
    double (*dot)(std::size_t n, const double* x, const double* y);
    double (*growth)(std::size_t size, const double* reach, const double* n, const double* x,
                     const double* y, double margin);
};

// Those that this processor runs, the one meant for it first and "plain" last.
struct InstructionSets {
    const InstructionSet* const* first;
    std::size_t count;
};
InstructionSets instruction_sets();

// The one of that name, or for "" the first; throws std::invalid_argument for one that this
// processor does not run. Tests ask for each in turn.
const InstructionSet& instruction_set(const char* name = "");

}  // namespace rcac
