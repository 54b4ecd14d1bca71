// Updates that keep no covariance: the cost of the present step only.
#pragma once

#include <stdexcept>

#include "updates/update.hpp"

namespace rcac {

// theta(k+1) minimises zhat' R_z zhat + (Phi_f theta)' R_u (Phi_f theta)
//   + (theta - theta(k))' R_theta (theta - theta(k)),
// which is (2.45) with P(k) = P(0) and lambda = 1 at every step.
class InstantaneousUpdate final : public Update {
public:
    InstantaneousUpdate(const double* P0, std::size_t l_theta)
        : n_(l_theta), P_(P0, P0 + l_theta * l_theta) {}

    std::unique_ptr<Update> copy() const override { return std::make_unique<InstantaneousUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t, double* theta) override {
        const std::size_t m = data.l_z;
        PPhi_.assign(n_ * m, 0.0);
        W_.resize(m * m);
        right_.assign(m * (m + 1), 0.0);
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t r = 0; r < m; ++r)
                for (std::size_t j = 0; j < n_; ++j)
                    PPhi_[i * m + r] += P_[i * n_ + j] * data.Phi_f[r * n_ + j];
        for (std::size_t i = 0; i < m * m; ++i) W_[i] = data.R_z[i] + data.R_u[i];
        for (std::size_t r = 0; r < m; ++r) {  // W^{-1} [I, R_z (z - u_f)]
            right_[r * (m + 1) + r] = 1.0;
            for (std::size_t j = 0; j < m; ++j)
                right_[r * (m + 1) + m] += data.R_z[r * m + j] * data.target[j];
        }
        solve(W_.data(), right_.data(), m, m + 1);
        Upsilon_.resize(m * m);
        innovation_.resize(m);
        for (std::size_t r = 0; r < m; ++r) {
            innovation_[r] = right_[r * (m + 1) + m];
            for (std::size_t i = 0; i < n_; ++i) innovation_[r] += data.Phi_f[r * n_ + i] * theta[i];
            for (std::size_t c = 0; c < m; ++c) {
                Upsilon_[r * m + c] = right_[r * (m + 1) + c];
                for (std::size_t i = 0; i < n_; ++i)
                    Upsilon_[r * m + c] += data.Phi_f[r * n_ + i] * PPhi_[i * m + c];
            }
        }
        solve(Upsilon_.data(), innovation_.data(), m, 1);
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t r = 0; r < m; ++r) theta[i] -= PPhi_[i * m + r] * innovation_[r];
        return finite(theta, n_);
    }

    void covariance(double* P) const override { std::copy(P_.begin(), P_.end(), P); }
    void covariance_column(std::size_t i, double* column) const override {
        for (std::size_t j = 0; j < n_; ++j) column[j] = P_[j * n_ + i];
    }
    void covariance_times(const double* x, double* product) const override {
        std::fill_n(product, n_, 0.0);
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < n_; ++j) product[i] += P_[i * n_ + j] * x[j];
    }

private:
    std::size_t n_;
    std::vector<double> P_, PPhi_, W_, right_, Upsilon_, innovation_;
};

// theta(k+1) = theta(k) - mu Phi_f' (R_z zhat + R_u Phi_f theta): half the gradient of the same
// cost without R_theta, times the step size mu.
class GradientUpdate final : public Update {
public:
    GradientUpdate(double step_size, std::size_t l_theta) : n_(l_theta), step_size_(step_size) {}

    std::unique_ptr<Update> copy() const override { return std::make_unique<GradientUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t, double* theta) override {
        const std::size_t m = data.l_z;
        answer_.assign(m, 0.0);
        slope_.assign(m, 0.0);
        for (std::size_t r = 0; r < m; ++r)
            for (std::size_t j = 0; j < n_; ++j) answer_[r] += data.Phi_f[r * n_ + j] * theta[j];
        for (std::size_t r = 0; r < m; ++r)
            for (std::size_t c = 0; c < m; ++c)
                slope_[r] += data.R_z[r * m + c] * (data.target[c] + answer_[c]) +
                             data.R_u[r * m + c] * answer_[c];
        for (std::size_t r = 0; r < m; ++r)
            for (std::size_t j = 0; j < n_; ++j)
                theta[j] -= step_size_ * data.Phi_f[r * n_ + j] * slope_[r];
        return finite(theta, n_);
    }

    void covariance(double* P) const override {
        std::fill_n(P, n_ * n_, 0.0);
        for (std::size_t j = 0; j < n_; ++j) P[j * n_ + j] = step_size_;
    }
    void covariance_column(std::size_t i, double* column) const override {
        std::fill_n(column, n_, 0.0);
        column[i] = step_size_;
    }
    void covariance_times(const double* x, double* product) const override {
        for (std::size_t i = 0; i < n_; ++i) product[i] = step_size_ * x[i];
    }

private:
    std::size_t n_;
    double step_size_;
    std::vector<double> answer_, slope_;
};

}  // namespace rcac
