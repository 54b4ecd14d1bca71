// The scale of Student's t that errors show.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace rcac {

// The maximum of the likelihood of Student's t of some degrees, by a number of passes of reweighted
// squares from the median of the squares; not below `least`. NaN where an error is.
inline double student_scale(const double* e, std::size_t count, double degrees, double least,
                            std::size_t passes) {
    std::vector<double> squares(count);
    for (std::size_t k = 0; k < count; ++k) {
        squares[k] = e[k] * e[k];
        if (std::isnan(squares[k])) return std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<double> sorted = squares;
    const auto middle = sorted.begin() + count / 2;
    std::nth_element(sorted.begin(), middle, sorted.end());
    double median = *middle;
    if (count % 2 == 0) median = (median + *std::max_element(sorted.begin(), middle)) / 2.0;
    double scale = std::max(std::sqrt(median), least);
    for (std::size_t pass = 0; pass < passes; ++pass) {
        const double variance = scale * scale;
        double sums[4] = {};  // written out, so that no instruction set changes the order
        std::size_t k = 0;
        for (; k + 4 <= count; k += 4)
            for (std::size_t j = 0; j < 4; ++j)
                sums[j] += (degrees + 1.0) / (degrees + squares[k + j] / variance) * squares[k + j];
        for (; k < count; ++k)
            sums[0] += (degrees + 1.0) / (degrees + squares[k] / variance) * squares[k];
        const double sum = (sums[0] + sums[2]) + (sums[1] + sums[3]);
        const double next = std::max(std::sqrt(sum / static_cast<double>(count)), least);
        if (next == scale) break;  // and so it stays
        scale = next;
    }
    return scale;
}

}  // namespace rcac
