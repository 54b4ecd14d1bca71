// theta and the coefficients of D_f fitted together, with a penalty on D_f at every step.
#pragma once

#include "updates/ud.hpp"

namespace rcac {

// Least squares on  z(k) + d_1 z(k-1) + ... - N_f (u - Phi theta),  linear in theta and d. The row
// of a step is followed by sqrt(n_d rho mean z^2) d_i = 0 for one i, in turn, so that per step the
// cost gains rho mean(z^2) d'd: without it the minimiser is not unique, whatever the data.
class JointUpdate final : public Update {
public:
    JointUpdate(const double* P0, std::size_t l_theta, std::size_t n_d, double rho)
        : n_(l_theta),
          n_d_(n_d),
          rho_(rho),
          ud_(with_d(P0, l_theta, n_d).data(), l_theta + n_d),
          past_(n_d + 1, 0.0),
          both_(l_theta + n_d, 0.0),
          row_(l_theta + n_d, 0.0) {}

    std::unique_ptr<Update> copy() const override { return std::make_unique<JointUpdate>(*this); }
    void see(const double* z) override {
        for (std::size_t i = n_d_; i > 0; --i) past_[i] = past_[i - 1];
        past_[0] = z[0];
    }

    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        std::copy_n(data.Phi_f, n_, row_.begin());
        std::copy_n(past_.begin() + 1, n_d_, row_.begin() + static_cast<std::ptrdiff_t>(n_));
        std::copy_n(theta, n_, both_.begin());
        bool done = ud_.measure({1, n_ + n_d_, row_.data(), data.target, data.R_z, data.R_u, 1.0},
                                step, both_.data());
        power_ += past_[0] * past_[0];
        ++count_;
        if (done && n_d_ > 0) done = penalise(step);
        std::copy_n(both_.begin(), n_, theta);
        guard_ = ud_.guard();
        return done && power_ - power_ == 0.0;
    }

    std::vector<double> also_fitted() const override {
        return {both_.begin() + static_cast<std::ptrdiff_t>(n_), both_.end()};
    }

    void reset() override { ud_.reset(); }
    double trace() const override { return ud_.trace(); }
    double growth() const override { return ud_.growth(); }
    void bound(double growth) override { ud_.bound(growth); }

    // Of theta; that of d stays inside.
    void covariance(double* P) const override {
        const std::size_t whole = n_ + n_d_;
        std::vector<double> all(whole * whole);
        ud_.covariance(all.data());
        for (std::size_t i = 0; i < n_; ++i) std::copy_n(&all[i * whole], n_, P + i * n_);
    }

    // d would have to move with theta: a metric is refused above, and bounds are cut off.
    void covariance_column(std::size_t i, double* column) const override {
        std::fill_n(column, n_, 0.0);
        column[i] = 1.0;
    }
    void covariance_times(const double* x, double* product) const override {
        std::copy_n(x, n_, product);
    }

    void visit(Archive& archive) override {
        Update::visit(archive);
        ud_.visit(archive);
        archive(past_);
        archive(both_);
        archive(power_);
        archive(count_, 0, Archive::longest);
    }

private:
    // P(0) of d is the mean of that of theta.
    static std::vector<double> with_d(const double* P0, std::size_t n, std::size_t n_d) {
        const std::size_t whole = n + n_d;
        std::vector<double> P(whole * whole, 0.0);
        double trace = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            std::copy_n(P0 + i * n, n, &P[i * whole]);
            trace += P0[i * n + i];
        }
        for (std::size_t i = n; i < whole; ++i) P[i * whole + i] = trace / static_cast<double>(n);
        return P;
    }

    bool penalise(std::int64_t step) {
        const double mean = power_ / static_cast<double>(count_),
                     weight = static_cast<double>(n_d_) * rho_ * mean;
        if (!(weight > 0.0)) return weight == 0.0;
        const double zero = 0.0, none = 0.0;
        std::fill(row_.begin(), row_.end(), 0.0);
        row_[n_ + static_cast<std::size_t>(count_) % n_d_] = 1.0;
        return ud_.measure({1, n_ + n_d_, row_.data(), &zero, &weight, &none, 1.0}, step,
                           both_.data());
    }

    std::size_t n_, n_d_;
    double rho_;
    UdUpdate ud_;
    std::vector<double> past_, both_, row_;
    double power_ = 0.0;
    std::int64_t count_ = 0;
};

}  // namespace rcac
