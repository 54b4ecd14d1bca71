// Bounds on theta: the nearest coefficients that keep them.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "updates/update.hpp"

namespace rcac {

// center + L v with |v| <= 1, L lower triangular (row-major) with a positive diagonal.
struct EllipsoidPlan {
    std::vector<double> center, L;  // empty: none
    std::vector<double> reach;      // |L^{-1} e_j|, rounded up
    bool in_metric = false;         // cuts in the metric of P, else along the radius alone
    double limit = 1.0;             // a computed radius up to it proves |v| <= 1
    double aim = 1.0;               // where a projection goes
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
        : plan_(plan), n_(plan.center.size()), columns_(n_ * n_), inverse_(n_), delta_(n_), v_(n_),
          row_(n_), moved_(n_), near_(n_) {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j <= i; ++j) columns_[j * n_ + i] = plan_.L[i * n_ + j];
        for (std::size_t i = 0; i < n_; ++i) inverse_[i] = 1.0 / plan_.L[i * n_ + i];
    }

    bool is_there() const { return n_ > 0; }

    double radius(const std::vector<double>& theta) { return std::sqrt(locate(theta)); }

    // Moves theta inside; false where it is inside already.
    bool apply(const Update& update, std::vector<double>& theta) {
        if (is_near(theta)) return false;
        double square = locate(theta);
        const double limit = plan_.limit * plan_.limit;
        if (square <= limit) {
            near_ = theta;
            // So much less that a radius within its rounding error decides the same.
            slack_ = plan_.limit - std::sqrt(square) - 2.0 * (1.0 - plan_.limit);
            return false;
        }
        slack_ = -1.0;
        if (plan_.in_metric) square = cut(update, square, limit);
        moved_ = delta_;
        if (!std::isfinite(square)) square = shrink();
        double scale = std::isfinite(square) ? std::min(plan_.aim / std::sqrt(square), 1.0) : 0.0,
               give = 1.0 - plan_.aim;
        for (int attempt = 0; attempt < attempts && scale > 0.0; ++attempt) {
            for (std::size_t i = 0; i < n_; ++i) theta[i] = plan_.center[i] + scale * moved_[i];
            if (locate(theta) <= limit) return true;  // with what rounding did to theta
            scale *= 1.0 - give;
            give += give;
        }
        theta = plan_.center;
        return true;
    }

private:
    static constexpr int cuts = 4, attempts = 8;
    static constexpr double nearly = 1e-6;  // of |v|^2, which is left to the radius

    // Whether theta has moved by less than lay between the last known radius and the limit.
    bool is_near(const std::vector<double>& theta) const {
        double moves[4] = {};
        std::size_t i = 0;
        for (; i + 4 <= n_; i += 4)
            for (std::size_t c = 0; c < 4; ++c)
                moves[c] += plan_.reach[i + c] * std::fabs(theta[i + c] - near_[i + c]);
        for (; i < n_; ++i) moves[0] += plan_.reach[i] * std::fabs(theta[i] - near_[i]);
        return moves[0] + moves[1] + (moves[2] + moves[3]) <= slack_;
    }

    double locate(const std::vector<double>& theta) {
        for (std::size_t i = 0; i < n_; ++i) delta_[i] = theta[i] - plan_.center[i];
        return substitute();
    }

    // v = L^{-1} delta; its square.
    double substitute() {
        v_ = delta_;
        for (std::size_t j = 0; j < n_; ++j) {
            const double* column = columns_.data() + j * n_;
            const double v = v_[j] * inverse_[j];
            v_[j] = v;
            for (std::size_t i = j + 1; i < n_; ++i) v_[i] -= column[i] * v;
        }
        double square = 0.0;
        for (std::size_t i = 0; i < n_; ++i) square += v_[i] * v_[i];
        return square;
    }

    // With n = M^{-1} delta the half-space n't <= (e^2 + limit) / 2 holds the ellipsoid, and the
    // nearest point of it in the metric of P is delta - P n (e^2 - limit) / (2 n'Pn).
    double cut(const Update& update, double square, double limit) {
        for (int made = 0; made < cuts && square > limit * (1.0 + nearly); ++made) {
            for (std::size_t i = n_; i-- > 0;) {
                const double* row = plan_.L.data() + i * n_;
                const double normal = v_[i] * inverse_[i];
                v_[i] = normal;
                for (std::size_t j = 0; j < i; ++j) v_[j] -= row[j] * normal;
            }
            update.covariance_times(v_.data(), row_.data());
            double size = 0.0;
            for (std::size_t i = 0; i < n_; ++i) size += v_[i] * row_[i];
            const double step = (square - limit) / (2.0 * size);
            if (!(size > 0.0) || !std::isfinite(step)) return square;  // rounding left P no metric
            for (std::size_t i = 0; i < n_; ++i) delta_[i] -= step * row_[i];
            square = substitute();
        }
        return square;
    }

    // The direction alone, where |v|^2 is beyond float64.
    double shrink() {
        double largest = 0.0;
        for (std::size_t i = 0; i < n_; ++i) largest = std::max(largest, std::fabs(moved_[i]));
        for (std::size_t i = 0; i < n_; ++i) delta_[i] = moved_[i] /= largest;
        return substitute();
    }

    EllipsoidPlan plan_;
    std::size_t n_;
    std::vector<double> columns_, inverse_, delta_, v_, row_, moved_;
    std::vector<double> near_;  // theta at the last look
    double slack_ = -1.0;       // that was left there; negative: not known
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

    // Moves theta to where it keeps the bounds; false where it did already.
    bool apply(const Update& update, std::vector<double>& theta) {
        if (ellipsoid_.is_there()) return ellipsoid_.apply(update, theta);
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
    Ellipsoid ellipsoid_;
    std::vector<double> columns_, multiplier_;
    std::vector<bool> known_;
};

}  // namespace rcac
