// The unscented Kalman filter (8.9)-(8.24), corrected, in square roots.
#pragma once

#include "estimation/kalman.hpp"

namespace rcac {

// Weights gamma_0 = (alpha - n)/alpha and gamma_i = 1/(2 alpha): with (8.11) as printed they do not
// add up to 1. The points are drawn again after Q was added, without which the filter is not the
// Kalman filter where the model is linear. In covariances the centre weighs beta more (Wan and van
// der Merwe). Where no weight is negative P cannot lose its definiteness; else the centre is taken
// out by a downdate, which may find that it did.
class UnscentedKalmanFilter final : public KalmanFilter {
public:
    template <class... Arguments>
    explicit UnscentedKalmanFilter(double alpha, double beta, Arguments&&... arguments)
        : KalmanFilter(std::forward<Arguments>(arguments)...),
          alpha_(alpha),
          centre_((alpha - static_cast<double>(n_)) / alpha + beta),
          points_((2 * n_ + 1) * n_),
          images_((2 * n_ + 1) * std::max(n_, p_)),
          away_((2 * n_ + 1) * std::max(n_, p_)),
          taken_(n_ + p_),
          M_((n_ + p_) * (2 * n_ + 1 + std::max(n_, p_))) {}

    void predict(const double* u) override {
        draw();
        for (std::size_t i = 0; i <= 2 * n_; ++i) {
            double* image = images_.data() + i * n_;
            model_->dynamics(k_, points_.data() + i * n_, u, image);
            require_finite(image, n_, "f(k, x, u) at a sigma point");
        }
        subtract(n_, images_.data());
        mean(n_, next_.data());
        subtract(n_, next_.data());
        const std::size_t columns = 3 * n_ + 1;
        for (std::size_t i = 0; i < n_; ++i) {
            deviations(n_, i, M_.data() + i * columns);
            std::copy_n(Q_root_.data() + i * n_, n_, M_.data() + i * columns + 2 * n_ + 1);
        }
        triangularise(M_.data(), n_, columns);
        for (std::size_t i = 0; i < n_; ++i) taken_[i] = away_[i];
        take_out_centre(n_, n_, columns);
        require_range(next_.data(), n_);
        require_range(M_.data(), n_ * columns);
        for (std::size_t i = 0; i < n_; ++i)
            std::copy_n(M_.data() + i * columns, n_, S_.data() + i * n_);
        x_ = next_;
        ++k_;
    }

private:
    void correct_there(const double* y, const double* u) override {
        draw();
        for (std::size_t i = 0; i <= 2 * n_; ++i) {
            double* image = images_.data() + i * p_;
            model_->output(k_, points_.data() + i * n_, u, image);
            require_finite(image, p_, "h(k, x, u) at a sigma point");
        }
        differences(images_.data());
        mean(p_, y_hat_.data());
        differences(y_hat_.data());
        const std::size_t columns = 2 * n_ + 1 + p_, q = there_.size();
        for (std::size_t i = 0; i < q; ++i) {
            deviations(p_, there_[i], M_.data() + i * columns);
            std::copy_n(R_root_.data() + there_[i] * p_, p_,
                        M_.data() + i * columns + 2 * n_ + 1);
        }
        const double half = std::sqrt(0.5);  // sqrt(gamma_i alpha)
        for (std::size_t i = 0; i < n_; ++i) {
            double* row = M_.data() + (q + i) * columns;
            std::fill_n(row, columns, 0.0);
            for (std::size_t j = 0; j <= i; ++j) {
                row[1 + j] = half * S_[i * n_ + j];
                row[1 + n_ + j] = -row[1 + j];
            }
        }
        triangularise(M_.data(), q + n_, columns);
        for (std::size_t i = 0; i < q; ++i) taken_[i] = away_[there_[i]];
        take_out_centre(q, q + n_, columns);
        commit(M_.data(), columns, y);
    }

    // (8.10)
    void draw() {
        const double spread = std::sqrt(alpha_);
        for (std::size_t i = 0; i <= 2 * n_; ++i)
            std::copy(x_.begin(), x_.end(), points_.begin() + static_cast<std::ptrdiff_t>(i * n_));
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = j; i < n_; ++i) {
                points_[(1 + j) * n_ + i] += spread * S_[i * n_ + j];
                points_[(1 + n_ + j) * n_ + i] -= spread * S_[i * n_ + j];
            }
    }
    // How far the images are from one of them, or from their mean: in `away_`.
    void subtract(std::size_t size, const double* of) {
        for (std::size_t j = 0; j <= 2 * n_; ++j)
            for (std::size_t i = 0; i < size; ++i)
                away_[j * size + i] = images_[j * size + i] - of[i];
    }
    // The same of measurements, among which are angles.
    void differences(const double* of) {
        for (std::size_t j = 0; j <= 2 * n_; ++j)
            model_->difference(images_.data() + j * p_, of, away_.data() + j * p_);
    }
    // The weighted mean as the centre plus weighted differences, which loses no digits where
    // gamma_0 is large and negative.
    void mean(std::size_t size, double* out) const {
        for (std::size_t i = 0; i < size; ++i) {
            double sum = 0.0;
            for (std::size_t j = 1; j <= 2 * n_; ++j) sum += away_[j * size + i];
            out[i] = images_[i] + sum / (2.0 * alpha_);
        }
    }
    // sqrt(gamma_j) (image_j - mean) of component i, j = 0..2n; no centre where gamma_0 < 0.
    void deviations(std::size_t size, std::size_t i, double* row) const {
        row[0] = centre_ > 0.0 ? std::sqrt(centre_) * away_[i] : 0.0;
        const double root = std::sqrt(0.5 / alpha_);
        for (std::size_t j = 1; j <= 2 * n_; ++j) row[j] = root * away_[j * size + i];
    }
    // What the centre adds to the first entries of `taken_`, where its weight is negative.
    void take_out_centre(std::size_t size, std::size_t rows, std::size_t columns) {
        if (!(centre_ < 0.0)) return;
        std::fill(taken_.begin() + static_cast<std::ptrdiff_t>(size), taken_.end(), 0.0);
        bool any = false;
        for (std::size_t i = 0; i < size; ++i) {
            taken_[i] *= std::sqrt(-centre_);
            any = any || taken_[i] != 0.0;
        }
        if (any && !downdate(M_.data(), rows, columns, taken_.data()))
            throw EstimationError{"indefinite", "the covariance lost its definiteness"};
    }

    double alpha_, centre_;
    std::vector<double> points_, images_, away_, taken_, M_;
};

}  // namespace rcac
