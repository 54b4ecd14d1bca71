// Bounds on theta: the nearest coefficients that keep them.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "updates/update.hpp"

namespace rcac {

struct BoundsPlan {
    std::vector<double> low, high;  // empty: no bounds
    bool in_metric = false;         // nearest in (t - theta)' P^{-1} (t - theta), else entry by entry
    std::size_t sweeps = 0;         // at most, of the search for it
};

class CoefficientBounds {
public:
    CoefficientBounds(const BoundsPlan& plan, std::size_t l_theta)
        : plan_(plan), n_(l_theta) {
        if (!plan.in_metric) return;
        columns_.resize(n_ * n_);
        known_.resize(n_);
        multiplier_.resize(n_);
    }

    bool are_there() const { return !plan_.low.empty(); }

    // Moves theta to where it keeps the bounds; false where it did already.
    bool apply(const Update& update, std::vector<double>& theta) {
        if (keeps(theta)) return false;
        if (plan_.in_metric) project(update, theta);
        // What the search leaves by rounding, or because its sweeps ran out, is cut off.
        for (std::size_t i = 0; i < n_; ++i) theta[i] = std::clamp(theta[i], plan_.low[i], plan_.high[i]);
        return true;
    }

private:
    bool keeps(const std::vector<double>& theta) const {
        bool all = true;
        for (std::size_t i = 0; i < n_; ++i)
            all = all && theta[i] >= plan_.low[i] && theta[i] <= plan_.high[i];
        return all;
    }

    // Hildreth (1957): theta <- theta - P e_i dmu for one bound after another, the multipliers mu
    // staying of their sign, until nothing moves. P is not touched.
    void project(const Update& update, std::vector<double>& theta) {
        std::fill(known_.begin(), known_.end(), false);
        std::fill(multiplier_.begin(), multiplier_.end(), 0.0);
        for (std::size_t sweep = 0; sweep < plan_.sweeps; ++sweep) {
            bool moved = false;
            for (std::size_t i = 0; i < n_; ++i) {
                const bool is_outside = theta[i] < plan_.low[i] || theta[i] > plan_.high[i];
                if (!is_outside && multiplier_[i] == 0.0) continue;
                double* column = columns_.data() + i * n_;
                if (!known_[i]) update.covariance_column(i, column);
                known_[i] = true;
                if (!(column[i] > 0.0)) return;  // rounding left P no metric
                const double free = theta[i] + column[i] * multiplier_[i],
                             place = std::clamp(free, plan_.low[i], plan_.high[i]),
                             step = (free - place) / column[i] - multiplier_[i];
                if (std::fabs(step) * column[i] <= 1e-15 * std::fabs(place)) continue;
                multiplier_[i] += step;
                for (std::size_t j = 0; j < n_; ++j) theta[j] -= step * column[j];
                moved = true;
            }
            if (!moved) return;
        }
    }

    BoundsPlan plan_;
    std::size_t n_;
    std::vector<double> columns_, multiplier_;
    std::vector<bool> known_;
};

}  // namespace rcac
