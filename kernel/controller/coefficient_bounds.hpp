// Bounds on theta: the nearest coefficients that keep them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "memory/aligned.hpp"
#include "simd/dispatch.hpp"
#include "updates/update.hpp"

namespace rcac {

// center + L v with |v| <= 1, L lower triangular with a positive diagonal.
struct EllipsoidPlan {
    std::vector<double> center, inverse;  // L^{-1}, row-major, to the nearest numbers; empty: none
    bool in_metric = false;               // cuts in the metric of P, else along the radius alone
    double limit = 1.0;                   // a computed radius up to it proves |v| <= 1
    double aim = 1.0;                     // where a projection goes; it is computed below the limit
    const InstructionSet* instructions = nullptr;
};

struct BoundsPlan {
    std::vector<double> low, high;  // empty: no box
    bool in_metric = false;         // nearest in (t - theta)' P^{-1} (t - theta), else entry by entry
    std::size_t sweeps = 0;         // at most, of the search for it
    EllipsoidPlan ellipsoid;

    bool are_there() const { return !low.empty() || !ellipsoid.center.empty(); }
};

class Ellipsoid {
public:
    explicit Ellipsoid(const EllipsoidPlan& plan)
        : plan_(plan), n_(plan.center.size()), limit_(plan.limit * plan.limit),
          margin_(8.0 * (1.0 - plan.limit)), R_(tiles_size(n_), 0.0),
          delta_(padded_to_tiles(n_), 0.0), v_(delta_), normal_(delta_), moved_(delta_), reach_(n_),
          near_(n_) {
        for (std::size_t j = 0; j < n_; ++j) {
            double square = 0.0;
            for (std::size_t i = j; i < n_; ++i) {
                const double entry = plan_.inverse[i * n_ + j];
                R_[place_in_tiles(j, i)] = entry;
                square += entry * entry;
            }
            reach_[j] = std::sqrt(square) * (1.0 + 1e-9 + 2.0 * (1.0 - plan_.limit));
        }
    }

    bool is_there() const { return n_ > 0; }

    double radius(const std::vector<double>& theta) { return std::sqrt(locate(theta)); }

    // Whether theta is inside. From a theta of which |v|^2 = e^2 and n = M^{-1} delta are known,
    // |v|^2 grows by 2 n'd + |L^{-1} d|^2 over a move d, and |L^{-1} d| is at most the sum s of
    // reach_j |d_j|: most steps need no more than that. What rounding may do to n'd is at most margin s.
    bool contains(const std::vector<double>& theta) {
        const InstructionSet& set = *plan_.instructions;
        if (!std::isnan(slack_) && set.growth(n_, reach_.data(), normal_.data(), theta.data(),
                                              near_.data(), margin_) <= slack_)
            return true;
        square_ = locate(theta);
        slack_ = unknown;
        if (!(square_ <= limit_)) return false;
        near_ = theta;
        set.times(n_, R_.data(), v_.data(), normal_.data());
        // A true radius up to `surely` has a computed one within the limit.
        const double error = 1.0 - plan_.limit, surely = plan_.limit - error,
                     radius = std::sqrt(square_) + error;
        slack_ = surely * surely - radius * radius;
        return true;
    }

    // Moves theta, which `contains` has just found outside, inside.
    void project(const Update& update, std::vector<double>& theta) {
        double square = square_;
        if (!std::isfinite(square))
            square = shrink();
        else if (plan_.in_metric)
            square = cut(update, square);
        const double scale = std::min(plan_.aim / std::sqrt(square), 1.0);
        if (std::isfinite(square) && scale > 0.0)
            for (std::size_t i = 0; i < n_; ++i) theta[i] = plan_.center[i] + scale * delta_[i];
        else
            theta = plan_.center;
    }

    // For whoever looks at theta elsewhere (lanes/state.hpp).
    const std::vector<double>& reach() const { return reach_; }
    const std::vector<double>& near() const { return near_; }
    const double* normal() const { return normal_.data(); }
    double margin() const { return margin_; }
    double slack() const { return slack_; }

private:
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    static constexpr int cuts = 4;
    static constexpr double nearly = 1e-6;  // of |v|^2, which is left to the radius

    double locate(const std::vector<double>& theta) {
        for (std::size_t i = 0; i < n_; ++i) delta_[i] = theta[i] - plan_.center[i];
        return locate();
    }
    // v = L^{-1} delta; its square.
    double locate() {
        return plan_.instructions->transposed_times(n_, R_.data(), delta_.data(), v_.data());
    }

    // With n = M^{-1} delta the half-space n't <= (e^2 + limit) / 2 holds the ellipsoid, and the
    // nearest point of it in the metric of P is delta - P n (e^2 - limit) / (2 n'Pn).
    double cut(const Update& update, double square) {
        for (int made = 0; made < cuts && square > limit_ * (1.0 + nearly); ++made) {
            plan_.instructions->times(n_, R_.data(), v_.data(), normal_.data());
            update.covariance_times(normal_.data(), moved_.data());
            const double size = plan_.instructions->dot(n_, normal_.data(), moved_.data()),
                         step = (square - limit_) / (2.0 * size);
            // Rounding left P no metric, or the numbers are beyond float64.
            if (!(size > 0.0) || !std::isfinite(size) || !std::isfinite(step)) return square;
            for (std::size_t i = 0; i < n_; ++i) delta_[i] -= step * moved_[i];
            square = locate();
        }
        return square;
    }

    // The direction alone, where |v|^2 is beyond float64.
    double shrink() {
        double largest = 0.0;
        for (std::size_t i = 0; i < n_; ++i) largest = std::max(largest, std::fabs(delta_[i]));
        for (std::size_t i = 0; i < n_; ++i) delta_[i] /= largest;
        return locate();
    }

    EllipsoidPlan plan_;
    std::size_t n_;
    double limit_, square_ = 0.0;  // of |v|^2
    double margin_;
    // The transpose of L^{-1} is upper triangular and lies in tiles.
    AlignedVector R_, delta_, v_, normal_, moved_;
    std::vector<double> reach_;  // |L^{-1} e_j|, rounded up
    std::vector<double> near_;   // theta at the last look
    double slack_ = unknown;     // of |v|^2 there
};

class CoefficientBounds {
public:
    CoefficientBounds(const BoundsPlan& plan, std::size_t l_theta)
        : plan_(plan), n_(l_theta), ellipsoid_(plan.ellipsoid) {
        if (!plan.in_metric) return;
        columns_.resize(n_ * n_);
        known_.resize(n_);
        multiplier_.resize(n_);
    }

    bool are_there() const { return plan_.are_there(); }
    Ellipsoid& ellipsoid() { return ellipsoid_; }

    // Whether theta keeps the bounds.
    bool contain(const std::vector<double>& theta) {
        if (ellipsoid_.is_there()) return ellipsoid_.contains(theta);
        bool all = true;
        for (std::size_t i = 0; i < n_; ++i)
            all = all && theta[i] >= plan_.low[i] && theta[i] <= plan_.high[i];
        return all;
    }

    // Moves a theta that has just been found outside to where it keeps them.
    void apply(const Update& update, std::vector<double>& theta) {
        if (ellipsoid_.is_there()) return ellipsoid_.project(update, theta);
        if (plan_.in_metric) project(update, theta);
        // What the search leaves by rounding, or because its sweeps ran out, is cut off.
        for (std::size_t i = 0; i < n_; ++i) theta[i] = std::clamp(theta[i], plan_.low[i], plan_.high[i]);
    }

private:
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
    Ellipsoid ellipsoid_;
    std::vector<double> columns_, multiplier_;
    std::vector<bool> known_;
};

}  // namespace rcac
