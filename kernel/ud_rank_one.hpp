// The inner loop of the factorised update, compiled once for each instruction set.
#pragma once

#include <cstddef>

namespace rcac {

struct UdFactors {
    std::size_t n;
    double* U;  // columns above the diagonal, packed one after another
    double* D;
};

// One measurement of regressor `row` and variance r: updates U and D, leaves the unscaled gain in
// `gain` and returns alpha = r + row P row'. `lost` tells whether some direction's excitation was
// lost in rounding while its variance is so large that the answer matters.
double ud_rank_one(const UdFactors& factors, const double* row, double r, double* gain, bool& lost);

}  // namespace rcac
