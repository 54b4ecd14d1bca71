// The retrospective cost update with P = U D U' factorised (Bierman 1977, Thornton 1976).
#pragma once

#include <stdexcept>

#include "ud_rank_one.hpp"
#include "update.hpp"

namespace rcac {

// U is unit upper triangular, its columns above the diagonal packed one after another; D > 0.
// d_j is multiplied by ratios alpha_{j-1}/alpha_j and never reduced by a subtraction, so P stays
// positive definite for R_theta = 1e-40 where (2.43) as printed does not.
class UdUpdate final : public Update {
public:
    UdUpdate(const double* P0, std::size_t l_theta)
        : n_(l_theta),
          P_0_(P0, P0 + l_theta * l_theta),
          U_(l_theta * (l_theta - 1) / 2),
          D_(l_theta),
          gain_(l_theta),
          row_(l_theta) {
        reset();
    }

    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        if (!measure(data, step, theta)) return false;
        if (data.lambda != 1.0)
            for (double& d : D_) d /= data.lambda;
        return finite(theta, n_) && finite(D_.data(), n_);
    }

    // The update without the division of P by lambda: rows of variance lambda.
    bool measure(const Data& data, std::int64_t step, double* theta) {
        // With W = R_z + R_u = L L', the rows of L' Phi_f carry uncorrelated noise of variance
        // lambda, so l_z scalar updates do what (2.42)-(2.44) do with one l_z x l_z inverse.
        const std::size_t m = data.l_z;
        L_.resize(m * m);
        rhs_.assign(m, 0.0);
        for (std::size_t i = 0; i < m * m; ++i) L_[i] = data.R_z[i] + data.R_u[i];
        if (!cholesky(L_.data(), m)) return false;  // a weight that is a function may do that
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = 0; j < m; ++j) rhs_[i] += data.R_z[i * m + j] * data.target[j];
        for (std::size_t i = 0; i < m; ++i) {  // rhs <- L^{-1} R_z (z - u_f) = L' W^{-1} R_z (..)
            for (std::size_t j = 0; j < i; ++j) rhs_[i] -= L_[i * m + j] * rhs_[j];
            rhs_[i] /= L_[i * m + i];
        }
        for (std::size_t r = 0; r < m; ++r) {
            for (std::size_t j = 0; j < n_; ++j) row_[j] = L_[r * m + r] * data.Phi_f[r * n_ + j];
            for (std::size_t i = r + 1; i < m; ++i)
                for (std::size_t j = 0; j < n_; ++j)
                    row_[j] += L_[i * m + r] * data.Phi_f[i * n_ + j];
            if (!scalar_update(row_.data(), rhs_[r], data.lambda, step, theta)) return false;
        }
        return true;
    }

    void covariance(double* P) const override {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = i; j < n_; ++j) {
                double sum = (i == j ? 1.0 : column(j)[i]) * D_[j];
                for (std::size_t m = j + 1; m < n_; ++m) sum += column(m)[i] * D_[m] * column(m)[j];
                P[i * n_ + j] = P[j * n_ + i] = sum;
            }
    }

    void reset() override { factorise(P_0_.data()); }

    // One rank-one update for each row of `noise` (Agee and Turner 1972). Only sums of positive
    // terms and ratios below one occur, so P stays positive definite here too.
    void inflate(const double* noise, std::size_t count) override {
        for (std::size_t m = 0; m < count; ++m, noise += n_) {
            std::copy_n(noise, n_, row_.data());
            double weight = 1.0;
            for (std::size_t j = n_; j-- > 0 && weight > 0.0;) {
                const double a = row_[j], old = D_[j];
                if (a == 0.0) continue;
                D_[j] = old + weight * a * a;
                const double gain = weight * a / D_[j];
                weight *= old / D_[j];
                for (std::size_t i = 0; i < j; ++i) {
                    row_[i] -= a * column(j)[i];
                    column(j)[i] += gain * row_[i];
                }
            }
        }
    }

    double trace() const override {
        double sum = 0.0;
        for (std::size_t j = 0; j < n_; ++j) {
            sum += D_[j];
            for (std::size_t i = 0; i < j; ++i) sum += D_[j] * column(j)[i] * column(j)[i];
        }
        return sum;
    }

    void visit(Archive& archive) override {
        Update::visit(archive);
        archive(U_);
        archive(D_);
    }

private:
    double* column(std::size_t j) { return U_.data() + j * (j - 1) / 2; }
    const double* column(std::size_t j) const { return U_.data() + j * (j - 1) / 2; }

    // P(0) = U D U'; a diagonal P(0) costs nothing.
    void factorise(const double* P0) {
        std::vector<double> P(P0, P0 + n_ * n_);
        for (std::size_t j = n_; j-- > 0;) {
            D_[j] = P[j * n_ + j];
            if (!(D_[j] > 0.0)) throw std::domain_error("P(0) is not positive definite");
            for (std::size_t i = 0; i < j; ++i) column(j)[i] = P[i * n_ + j] / D_[j];
            for (std::size_t i = 0; i < j; ++i)
                for (std::size_t m = 0; m <= i; ++m)
                    P[m * n_ + i] -= column(j)[m] * D_[j] * column(j)[i];
        }
    }

    // One measurement  row * theta + rhs = 0  of variance r; false where alpha overflows.
    bool scalar_update(const double* row, double rhs, double r, std::int64_t step, double* theta) {
        double innovation = rhs;
        for (std::size_t j = 0; j < n_; ++j) innovation += row[j] * theta[j];
        bool lost = false;
        const double alpha =
            ud_rank_one({n_, U_.data(), D_.data()}, row, r, gain_.data(), lost);
        if (lost) guard_.raise(step);
        if (!std::isfinite(alpha)) return false;
        const double scaled = innovation / alpha;
        for (std::size_t j = 0; j < n_; ++j) theta[j] -= gain_[j] * scaled;
        return true;
    }

    std::size_t n_;
    std::vector<double> P_0_, U_, D_, gain_, row_, L_, rhs_;
};

}  // namespace rcac
