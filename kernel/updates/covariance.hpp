// The retrospective cost update exactly as (2.42)-(2.45) print it.
#pragma once

#include <utility>

#include "simd/dispatch.hpp"
#include "updates/ud.hpp"

namespace rcac {

// Kept under its own name because published plots were computed this way. P is stored full and
// is not symmetrised: for R_theta <= 1e-14 the subtraction in (2.43) loses positive definiteness
// and the rounding errors act as a covariance reset. The guard counts the steps at which
// Upsilon(k) is visibly not positive definite.
class CovarianceUpdate final : public Update {
public:
    CovarianceUpdate(const double* P0, std::size_t l_theta)
        : n_(l_theta), P_0_(P0, P0 + l_theta * l_theta), P_(P_0_) {}

    std::unique_ptr<Update> copy() const override { return std::make_unique<CovarianceUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        const std::size_t m = data.l_z;
        PPhi_.assign(n_ * m, 0.0);  // P Phi_f'
        right_.assign(m * (n_ + 1), 0.0);  // [Phi_f P, innovation], the right sides of Upsilon
        for (std::size_t r = 0; r < m; ++r) {
            // Eight rows side by side: every sum still runs over j = 0, 1, ..., but a processor
            // need not wait for one addition before it starts the next.
            std::size_t i = 0;
            for (; i + 8 <= n_; i += 8) rows_times<8>(i, r, data);
            for (; i < n_; ++i) rows_times<1>(i, r, data);
        }
        for (std::size_t r = 0; r < m; ++r)
            for (std::size_t i = 0; i < n_; ++i) {
                const double phi = data.Phi_f[r * n_ + i];
                for (std::size_t j = 0; j < n_; ++j)
                    right_[r * (n_ + 1) + j] += phi * P_[i * n_ + j];
            }

        // (R_z + R_u)^{-1} [lambda I, R_z (z - u_f)]
        W_.resize(m * m);
        scaled_.assign(m * (m + 1), 0.0);
        for (std::size_t i = 0; i < m * m; ++i) W_[i] = data.R_z[i] + data.R_u[i];
        for (std::size_t r = 0; r < m; ++r) {
            scaled_[r * (m + 1) + r] = data.lambda;
            for (std::size_t j = 0; j < m; ++j)
                scaled_[r * (m + 1) + m] += data.R_z[r * m + j] * data.target[j];
        }
        solve(W_.data(), scaled_.data(), m, m + 1);

        Upsilon_.resize(m * m);
        for (std::size_t r = 0; r < m; ++r)
            for (std::size_t c = 0; c < m; ++c) {
                double sum = scaled_[r * (m + 1) + c];
                for (std::size_t i = 0; i < n_; ++i)
                    sum += data.Phi_f[r * n_ + i] * PPhi_[i * m + c];
                Upsilon_[r * m + c] = sum;
            }
        for (std::size_t r = 0; r < m; ++r)
            if (!(Upsilon_[r * m + r] > 0.0)) {
                guard_.raise(step);
                break;
            }
        for (std::size_t r = 0; r < m; ++r) {
            double innovation = scaled_[r * (m + 1) + m];
            for (std::size_t j = 0; j < n_; ++j) innovation += data.Phi_f[r * n_ + j] * theta[j];
            right_[r * (n_ + 1) + n_] = innovation;
        }
        solve(Upsilon_.data(), right_.data(), m, n_ + 1);

        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t r = 0; r < m; ++r) {
                const double gain = PPhi_[i * m + r];
                const double* row = right_.data() + r * (n_ + 1);
                theta[i] -= gain * row[n_];
                for (std::size_t j = 0; j < n_; ++j) P_[i * n_ + j] -= gain * row[j];
            }
        if (data.lambda != 1.0)
            for (double& p : P_) p /= data.lambda;
        return finite(theta, n_) && instructions_.finite(P_.data(), n_ * n_);
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

    void reset() override { P_ = P_0_; }

    // As UdUpdate does on the factors; where rounding left P none, it starts anew.
    void doubt_past(double rho) override {
        if (!(rho > 0.0)) return;
        try {
            UdUpdate factors(P_0_.data(), n_);
            factors.factorise(P_.data());
            factors.doubt_past(rho);
            factors.covariance(P_.data());
        } catch (const std::domain_error&) {
            reset();
        }
    }

    void inflate(const double* noise, std::size_t count) override {
        for (std::size_t a = 0; a < count; ++a, noise += n_)
            for (std::size_t i = 0; i < n_; ++i)
                for (std::size_t j = 0; j < n_; ++j) P_[i * n_ + j] += noise[i] * noise[j];
    }

    double growth() const override {
        double most = 0.0;
        for (std::size_t i = 0; i < n_; ++i) most = std::max(most, P_[i * n_ + i] / P_0_[i * n_ + i]);
        return most;
    }
    // S P S with a diagonal S, which leaves P as definite as it was.
    void bound(double growth) override {
        std::vector<double> S(n_, 1.0);
        for (std::size_t i = 0; i < n_; ++i) {
            const double most = growth * P_0_[i * n_ + i];
            if (P_[i * n_ + i] > most) S[i] = std::sqrt(most / P_[i * n_ + i]);
        }
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < n_; ++j) P_[i * n_ + j] *= S[i] * S[j];
    }

    double trace() const override {
        double sum = 0.0;
        for (std::size_t i = 0; i < n_; ++i) sum += P_[i * n_ + i];
        return sum;
    }

    void visit(Archive& archive) override {
        Update::visit(archive);
        archive(P_);
    }

private:
    const InstructionSet& instructions_ = instruction_set();
    // Entries i, ..., i + rows - 1 of column r of P Phi_f'.
    template <std::size_t rows>
    void rows_times(std::size_t i, std::size_t r, const Data& data) {
        double sum[rows] = {};
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t q = 0; q < rows; ++q)
                sum[q] += P_[(i + q) * n_ + j] * data.Phi_f[r * n_ + j];
        for (std::size_t q = 0; q < rows; ++q) PPhi_[(i + q) * data.l_z + r] = sum[q];
    }

    std::size_t n_;
    std::vector<double> P_0_, P_, PPhi_, right_, W_, scaled_, Upsilon_;
};

}  // namespace rcac
