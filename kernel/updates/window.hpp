// The batch minimiser over a sliding window of steps.
#pragma once

#include "updates/ud.hpp"

namespace rcac {

// theta(k+1) minimises the cost of the last `window` steps, weighted by lambda^(k-i), plus
// (theta - theta(0))' R_theta (theta - theta(0)). The factors are built anew from P(0) at every
// step: window times the work of a recursive update, and no downdate that could lose a digit.
class WindowUpdate final : public Update {
public:
    WindowUpdate(const double* P0, const double* theta_0, std::size_t l_theta, std::size_t l_z,
                 std::size_t window)
        : n_(l_theta),
          window_(window),
          item_(l_z * l_theta + l_z + 2 * l_z * l_z),
          theta_0_(theta_0, theta_0 + l_theta),
          kept_(window * item_),
          arithmetic_(P0, l_theta) {}

    std::unique_ptr<Update> copy() const override { return std::make_unique<WindowUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        const std::size_t m = data.l_z;
        double* slot = kept_.data() + static_cast<std::size_t>(count_ % window()) * item_;
        slot = std::copy_n(data.Phi_f, m * n_, slot);
        slot = std::copy_n(data.target, m, slot);
        slot = std::copy_n(data.R_z, m * m, slot);
        std::copy_n(data.R_u, m * m, slot);
        ++count_;

        const std::int64_t doubts = arithmetic_.guard().count;
        arithmetic_.reset();
        std::copy(theta_0_.begin(), theta_0_.end(), theta);
        // Oldest first. R_theta must not be forgotten with the data, so that age is put into the
        // variance of each step instead of into P.
        const std::int64_t first = std::max<std::int64_t>(count_ - window(), 0);
        for (std::int64_t i = first; i < count_; ++i) {
            const double* item = kept_.data() + static_cast<std::size_t>(i % window()) * item_;
            const double variance = std::pow(data.lambda, -static_cast<double>(count_ - 1 - i));
            if (!std::isfinite(variance)) continue;  // forgotten beyond the range of float64
            const Data past{m, n_, item, item + m * n_, item + m * n_ + m,
                            item + m * n_ + m + m * m, variance};
            if (!arithmetic_.measure(past, step, theta)) return false;
        }
        if (arithmetic_.guard().count > doubts) guard_.raise(step);
        return true;
    }

    // An empty window.
    void reset() override { count_ = 0; }

    void covariance(double* P) const override { arithmetic_.covariance(P); }
    void covariance_column(std::size_t i, double* column) const override {
        arithmetic_.covariance_column(i, column);
    }
    void covariance_times(const double* x, double* product) const override {
        arithmetic_.covariance_times(x, product);
    }

    void visit(Archive& archive) override {
        Update::visit(archive);
        archive(count_, 0, Archive::longest);
        archive(kept_);
        arithmetic_.visit(archive);
    }

private:
    std::int64_t window() const { return static_cast<std::int64_t>(window_); }

    std::size_t n_, window_, item_;
    std::vector<double> theta_0_, kept_;
    UdUpdate arithmetic_;
    std::int64_t count_ = 0;
};

}  // namespace rcac
