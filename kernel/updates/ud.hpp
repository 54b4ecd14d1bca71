// The retrospective cost update with P = U D U' factorised (Bierman 1977, Thornton 1976).
#pragma once

#include <algorithm>
#include <stdexcept>

#include "memory/aligned.hpp"
#include "simd/dispatch.hpp"
#include "updates/update.hpp"
#include "updates/whitened_rows.hpp"

namespace rcac {

// U is unit upper triangular, in the tiles of simd/layout.hpp; D > 0. d_j is multiplied by ratios
// alpha_{j-1}/alpha_j and never reduced by a subtraction, so P stays positive definite for
// R_theta = 1e-40 where (2.43) as printed does not.
class UdUpdate final : public Update {
public:
    UdUpdate(const double* P0, std::size_t l_theta,
             const InstructionSet& instructions = rcac::instruction_set())
        : n_(l_theta),
          instructions_(&instructions),
          measure_(instructions.ud_measure(l_theta)),
          U_(tiles_size(n_), 0.0),
          D_(padded_to_tiles(n_), 0.0),
          gain_(padded_to_tiles(n_), 0.0),
          row_(padded_to_tiles(n_), 0.0) {
        begin_from(P0);
    }

    // As if made with this P(0).
    void begin_from(const double* P0) {
        std::fill(U_.begin(), U_.end(), 0.0);
        for (std::size_t j = 0; j < padded_to_tiles(n_); ++j) U_[place_in_tiles(j, j)] = 1.0;
        factorise(P0);
        U_0_ = U_;
        D_0_ = D_;
        inverse_D_0_.resize(n_);
        for (std::size_t j = 0; j < n_; ++j) inverse_D_0_[j] = 1.0 / D_0_[j];
    }

    std::unique_ptr<Update> copy() const override { return std::make_unique<UdUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        if (!measure(data, step, theta)) return false;
        if (data.lambda == 1.0) return true;
        if (capped_)  // what would grow beyond P(0) is known no less than at the beginning
            for (std::size_t j = 0; j < n_; ++j) D_[j] = std::min(D_[j] / data.lambda, D_0_[j]);
        else
            for (double& d : D_) d /= data.lambda;
        return instructions_->finite(D_.data(), n_);
    }

    // The update without the division of P by lambda: rows of variance lambda.
    bool measure(const Data& data, std::int64_t step, double* theta) {
        if (!rows_.take(data)) return false;
        for (std::size_t r = 0; r < data.l_z; ++r) {
            bool lost = false;
            const bool finite = measure_row(rows_.phi(data, r), rows_.scale(), rows_.rhs(r),
                                            data.lambda, theta, lost);
            if (lost) guard_.raise(step);
            if (!finite) return false;
        }
        return true;
    }

    // The measurement  scale phi theta + rhs = 0  of this variance.
    bool measure_row(const double* phi, double scale, double rhs, double variance, double* theta,
                     bool& lost) {
        return measure_({n_, U_.data(), D_.data()}, phi, scale, rhs, variance, row_.data(),
                        gain_.data(), theta, lost);
    }

    void reset() override {
        std::copy(U_0_.begin(), U_0_.end(), U_.begin());
        std::copy(D_0_.begin(), D_0_.end(), D_.begin());
    }

    // Every direction of U becomes as uncertain as the share of its information that is lost says,
    // up to what it was at the beginning; U stays.
    void doubt_past(double rho) override {
        if (!(rho < no_past_left)) return reset();
        for (std::size_t j = 0; j < n_; ++j)
            D_[j] = std::max(D_[j], std::min(D_[j] / (1.0 - rho), D_0_[j]));
    }

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
                    row_[i] -= a * u(i, j);
                    u(i, j) += gain * row_[i];
                }
            }
        }
    }

    // d_j is the variance of theta_j where those after it are known, and without forgetting none
    // of them grows.
    double growth() const override {
        double most = 0.0;
        for (std::size_t j = 0; j < n_; ++j) most = std::max(most, D_[j] * inverse_D_0_[j]);
        return most;
    }
    void bound(double growth) override {
        for (std::size_t j = 0; j < n_; ++j) D_[j] = std::min(D_[j], growth * D_0_[j]);
    }
    // Forgetting stops at P(0).
    void cap() { capped_ = true; }
    bool is_capped() const { return capped_; }
    double initial_d(std::size_t j) const { return D_0_[j]; }

    double trace() const override {
        double sum = 0.0;
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = 0; i <= j; ++i) sum += D_[j] * u(i, j) * u(i, j);
        return sum;
    }

    void visit(Archive& archive) override {
        Update::visit(archive);
        for (std::size_t j = 0; j < n_; ++j) {
            for (std::size_t i = 0; i < j; ++i) archive(u(i, j));
            archive(D_[j]);
        }
    }

    void covariance(double* P) const override {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = i; j < n_; ++j) {
                double sum = 0.0;
                for (std::size_t m = j; m < n_; ++m) sum += u(i, m) * D_[m] * u(j, m);
                P[i * n_ + j] = P[j * n_ + i] = sum;
            }
    }

    // U (D (U' e_i)).
    void covariance_column(std::size_t i, double* column) const override {
        std::fill_n(column, n_, 0.0);
        for (std::size_t m = i; m < n_; ++m) {
            const double weight = D_[m] * u(i, m);
            for (std::size_t j = 0; weight != 0.0 && j <= m; ++j) column[j] += weight * u(j, m);
        }
    }

    // U (D (U' x)).
    void covariance_times(const double* x, double* product) const override {
        instructions_->transposed_times(n_, U_.data(), x, product);
        for (std::size_t j = 0; j < padded_to_tiles(n_); ++j) product[j] *= D_[j];
        instructions_->times(n_, U_.data(), product, product);
    }

    // P = U D U'; a diagonal P costs nothing.
    void factorise(const double* P0) {
        std::vector<double> P(P0, P0 + n_ * n_);
        for (std::size_t j = n_; j-- > 0;) {
            D_[j] = P[j * n_ + j];
            if (!(D_[j] > 0.0)) throw std::domain_error("P(0) is not positive definite");
            bool is_diagonal = std::isfinite(D_[j]);
            for (std::size_t i = 0; i < j; ++i) {
                u(i, j) = P[i * n_ + j] / D_[j];
                is_diagonal = is_diagonal && u(i, j) == 0.0;
            }
            for (std::size_t i = 0; i < j && !is_diagonal; ++i)
                for (std::size_t m = 0; m <= i; ++m) P[m * n_ + i] -= u(m, j) * D_[j] * u(i, j);
        }
    }

    // The factors entry by entry, i <= j, to save and to restore them.
    std::size_t l_theta() const { return n_; }
    double& u(std::size_t i, std::size_t j) { return U_[place_in_tiles(i, j)]; }
    double u(std::size_t i, std::size_t j) const { return U_[place_in_tiles(i, j)]; }
    double& d(std::size_t j) { return D_[j]; }
    void doubt(std::int64_t step) { guard_.raise(step); }
    double d(std::size_t j) const { return D_[j]; }

private:
    std::size_t n_;
    const InstructionSet* instructions_;
    UdMeasure* measure_;
    AlignedVector U_, D_, U_0_, D_0_, gain_, row_;
    std::vector<double> inverse_D_0_;
    bool capped_ = false;
    WhitenedRows rows_;
};

}  // namespace rcac
