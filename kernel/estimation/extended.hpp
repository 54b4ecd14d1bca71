// The extended Kalman filter (8.5)-(8.8), in square roots and in Joseph's form.
#pragma once

#include "estimation/kalman.hpp"
#include "updates/update.hpp"

namespace rcac {

// F is taken at x(k-1|k-1) and H at x(k|k-1): (8.6) uses the Jacobian of the step that leads to
// P(k), and (8.8) as printed is one step late.
class ExtendedKalmanFilter : public KalmanFilter {
public:
    template <class... Arguments>
    explicit ExtendedKalmanFilter(Arguments&&... arguments)
        : KalmanFilter(std::forward<Arguments>(arguments)...),
          J_(std::max(n_, p_) * n_),
          M_((n_ + p_) * (2 * n_ + p_)) {}

    void predict(const double* u) override {
        model_->linear_dynamics(k_, x_.data(), u, next_.data(), J_.data());
        require_finite(next_.data(), n_, "f(k, x, u)");
        require_finite(J_.data(), n_ * n_, "the Jacobian F of f");
        const std::size_t columns = 2 * n_;
        for (std::size_t i = 0; i < n_; ++i) {
            times_S(J_.data() + i * n_, M_.data() + i * columns);
            std::copy_n(Q_root_.data() + i * n_, n_, M_.data() + i * columns + n_);
        }
        triangularise(M_.data(), n_, columns);
        require_range(M_.data(), n_ * columns);
        for (std::size_t i = 0; i < n_; ++i)
            std::copy_n(M_.data() + i * columns, n_, S_.data() + i * n_);
        x_ = next_;
        ++k_;
    }

private:
    void correct_there(const double* y, const double* u) override {
        model_->linear_output(k_, x_.data(), u, y_hat_.data(), J_.data());
        require_finite(y_hat_.data(), p_, "h(k, x, u)");
        require_finite(J_.data(), p_ * n_, "the Jacobian H of h");
        const std::size_t columns = p_ + n_, q = there_.size();
        for (std::size_t i = 0; i < q; ++i) {
            std::copy_n(R_root_.data() + there_[i] * p_, p_, M_.data() + i * columns);
            times_S(J_.data() + there_[i] * n_, M_.data() + i * columns + p_);
        }
        for (std::size_t i = 0; i < n_; ++i) {
            double* row = M_.data() + (q + i) * columns;
            std::fill_n(row, p_, 0.0);
            std::copy_n(S_.data() + i * n_, n_, row + p_);
        }
        triangularise(M_.data(), q + n_, columns);
        commit(M_.data(), columns, y);
    }
    void times_S(const double* row, double* out) const {
        std::fill_n(out, n_, 0.0);
        for (std::size_t m = 0; m < n_; ++m)
            for (std::size_t j = 0; j <= m; ++j) out[j] += row[m] * S_[m * n_ + j];
    }
    std::vector<double> J_, M_;
};

// P itself instead of S, by (I - K H) P (I - K H)' + K R K'; S_ holds P here.
class JosephKalmanFilter final : public KalmanFilter {
public:
    template <class... Arguments>
    explicit JosephKalmanFilter(Arguments&&... arguments)
        : KalmanFilter(std::forward<Arguments>(arguments)...),
          Q_(gram(Q_root_, n_)),
          R_(gram(R_root_, p_)),
          J_(std::max(n_, p_) * n_),
          a_(n_ * n_),
          K_(n_ * p_) {
        S_ = gram(S_, n_);
    }
    void set_noises(std::vector<double> Q_root, std::vector<double> R_root) override {
        KalmanFilter::set_noises(std::move(Q_root), std::move(R_root));
        Q_ = gram(Q_root_, n_);
        R_ = gram(R_root_, p_);
    }

    void predict(const double* u) override {
        model_->linear_dynamics(k_, x_.data(), u, next_.data(), J_.data());
        require_finite(next_.data(), n_, "f(k, x, u)");
        require_finite(J_.data(), n_ * n_, "the Jacobian F of f");
        std::vector<double> P = congruent(J_.data());
        for (std::size_t i = 0; i < n_ * n_; ++i) P[i] += Q_[i];
        require_range(P.data(), n_ * n_);
        S_ = std::move(P);
        x_ = next_;
        ++k_;
    }

    void covariance(double* P) const override { std::copy(S_.begin(), S_.end(), P); }
    double variance(std::size_t i) const override { return S_[i * n_ + i]; }

private:
    void correct_there(const double* y, const double* u) override {
        model_->linear_output(k_, x_.data(), u, y_hat_.data(), J_.data());
        require_finite(y_hat_.data(), p_, "h(k, x, u)");
        require_finite(J_.data(), p_ * n_, "the Jacobian H of h");
        const std::size_t q = there_.size();
        std::vector<double> PHt(n_ * q, 0.0), S_y(q * q), R(q * q);
        for (std::size_t i = 0; i < q; ++i)
            for (std::size_t j = 0; j < q; ++j)
                S_y[i * q + j] = R[i * q + j] = R_[there_[i] * p_ + there_[j]];
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < q; ++j)
                for (std::size_t m = 0; m < n_; ++m)
                    PHt[i * q + j] += S_[i * n_ + m] * J_[there_[j] * n_ + m];
        for (std::size_t i = 0; i < q; ++i)
            for (std::size_t j = 0; j < q; ++j)
                for (std::size_t m = 0; m < n_; ++m)
                    S_y[i * q + j] += J_[there_[i] * n_ + m] * PHt[m * q + j];
        if (!cholesky(S_y.data(), q))
            throw EstimationError{"singular", "the covariance of the innovation is singular"};
        innovate(y);
        solve_lower(S_y.data(), q, q, whitened_.data());
        for (std::size_t i = 0; i < n_; ++i) {  // a row of K = P H' L'^-1 L^-1
            double* row = K_.data() + i * q;
            std::copy_n(PHt.data() + i * q, q, row);
            solve_lower(S_y.data(), q, q, row);
            next_[i] = x_[i];
            for (std::size_t j = 0; j < q; ++j) next_[i] += row[j] * whitened_[j];
            for (std::size_t j = q; j-- > 0;) {
                for (std::size_t m = j + 1; m < q; ++m) row[j] -= S_y[m * q + j] * row[m];
                row[j] /= S_y[j * q + j];
            }
        }
        std::vector<double> rest(n_ * n_, 0.0);  // I - K H
        for (std::size_t i = 0; i < n_; ++i) {
            rest[i * n_ + i] = 1.0;
            for (std::size_t m = 0; m < q; ++m)
                for (std::size_t j = 0; j < n_; ++j)
                    rest[i * n_ + j] -= K_[i * q + m] * J_[there_[m] * n_ + j];
        }
        std::vector<double> P = congruent(rest.data());
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < n_; ++j)
                for (std::size_t m = 0; m < q; ++m)
                    for (std::size_t l = 0; l < q; ++l)
                        P[i * n_ + j] += K_[i * q + m] * R[m * q + l] * K_[j * q + l];
        require_range(next_.data(), n_);
        require_range(P.data(), n_ * n_);
        remember();
        S_ = std::move(P);
        x_ = next_;
        accept(S_y.data(), q);
    }

    static std::vector<double> gram(const std::vector<double>& L, std::size_t n) {
        std::vector<double> P(n * n, 0.0);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j)
                for (std::size_t m = 0; m < n; ++m) P[i * n + j] += L[i * n + m] * L[j * n + m];
        return P;
    }
    // M P M', symmetric.
    std::vector<double> congruent(const double* M) {
        std::vector<double> out(n_ * n_, 0.0);
        std::fill(a_.begin(), a_.end(), 0.0);
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t m = 0; m < n_; ++m)
                for (std::size_t j = 0; j < n_; ++j) a_[i * n_ + j] += M[i * n_ + m] * S_[m * n_ + j];
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = 0.0;
                for (std::size_t m = 0; m < n_; ++m) sum += a_[i * n_ + m] * M[j * n_ + m];
                out[i * n_ + j] = out[j * n_ + i] = sum;
            }
        return out;
    }
    std::vector<double> Q_, R_, J_, a_, K_;
};

}  // namespace rcac
