// Q and R from measurements: expectation maximisation (Shumway and Stoffer 1982) in square roots.
#pragma once

#include "estimation/extended.hpp"

namespace rcac {

// What of the noises is learned.
struct LearnedNoises {
    bool Q, R;
    bool diagonal;  // whether entries beside the diagonal are taken as zero
};

// One iteration over a block of steps: Q becomes the mean of E[w w' | all y of the block], R that of
// E[v v' | ...]. Both are sums of squares, never differences, and stay semidefinite as roots.
class NoiseLearning {
public:
    NoiseLearning(std::shared_ptr<EstimationModel> model, LearnedNoises learned)
        : model_(std::move(model)),
          learned_(learned),
          n_(model_->n),
          p_(model_->l_y),
          F_(std::max(n_, p_) * n_),
          next_(n_),
          y_hat_(p_),
          given_(p_),
          innovation_(p_),
          joint_(3 * n_ * 2 * n_),
          back_(n_ * (n_ + 1)),
          next_x_(n_),
          next_S_(n_ * 3 * n_),
          residual_(p_ * (n_ + 1)),
          known_(p_ * p_),
          order_(n_) {}

    // From what is believed before the first step. The new roots replace Q and R; returned is the
    // logarithm of the likelihood under the old ones.
    double iterate(const Belief& start, const double* y, const double* u, std::size_t steps,
                   std::vector<double>& Q, std::vector<double>& R) {
        const double likelihood = forward(start, y, u, steps, Q, R);
        sum_Q_.assign(n_ * (4 * n_ + 1), 0.0);
        sum_R_.assign(p_ * (2 * p_ + n_ + 1), 0.0);
        std::size_t measured = 0;
        x_.assign(filtered_x_.end() - static_cast<std::ptrdiff_t>(n_), filtered_x_.end());
        S_.assign(filtered_S_.end() - static_cast<std::ptrdiff_t>(n_ * n_), filtered_S_.end());
        for (std::size_t k = steps; k-- > 0;) {
            const std::int64_t now = start.k + static_cast<std::int64_t>(k);
            if (k + 1 < steps) go_back(now, k, u + k * model_->l_u, Q);
            if (learned_.R) measured += observe(now, y + k * p_, u + k * model_->l_u, R);
        }
        if (learned_.Q && steps > 1) take(sum_Q_, n_, 4 * n_ + 1, steps - 1, Q);
        if (measured) take(sum_R_, p_, 2 * p_ + n_ + 1, measured, R);
        return likelihood;
    }

private:
    double forward(const Belief& start, const double* y, const double* u, std::size_t steps,
                   const std::vector<double>& Q, const std::vector<double>& R) {
        ExtendedKalmanFilter filter(model_, start.x, start.S, Q, R);
        filter.put_back(start);  // with its k
        filtered_x_.resize(steps * n_);
        filtered_S_.resize(steps * n_ * n_);
        predicted_.resize(steps * n_);
        double likelihood = 0.0;
        for (std::size_t k = 0; k < steps; ++k) {
            filter.correct(y + k * p_, u + k * model_->l_u);
            if (filter.measured()) likelihood += filter.log_likelihood();
            std::copy_n(filter.x().data(), n_, filtered_x_.data() + k * n_);
            std::copy_n(filter.root().data(), n_ * n_, filtered_S_.data() + k * n_ * n_);
            filter.predict(u + k * model_->l_u);
            std::copy_n(filter.x().data(), n_, predicted_.data() + k * n_);
        }
        return likelihood;
    }

    // x(k+1|N) -> x(k|N), and what it says of w(k). With [F S, Q^1/2; S, 0; 0, Q^1/2] = [L, 0; G, M]
    // the mean of each is G L^-1 (x(k+1|N) - x(k+1|k)), its covariance M M' + (G L^-1) P (G L^-1)'.
    void go_back(std::int64_t now, std::size_t k, const double* u, const std::vector<double>& Q) {
        const double *x = filtered_x_.data() + k * n_, *S = filtered_S_.data() + k * n_ * n_;
        const std::size_t columns = 2 * n_;
        model_->linear_dynamics(now, x, u, next_.data(), F_.data());
        std::fill(joint_.begin(), joint_.end(), 0.0);
        for (std::size_t i = 0; i < n_; ++i) {
            double* row = joint_.data() + i * columns;
            for (std::size_t m = 0; m < n_; ++m)
                for (std::size_t j = 0; j <= m; ++j) row[j] += F_[i * n_ + m] * S[m * n_ + j];
            std::copy_n(Q.data() + i * n_, n_, row + n_);
            std::copy_n(S + i * n_, n_, joint_.data() + (n_ + i) * columns);
            std::copy_n(Q.data() + i * n_, n_, joint_.data() + (2 * n_ + i) * columns + n_);
        }
        const std::size_t rank = eliminate(joint_.data(), n_, 3 * n_, columns, order_.data());
        for (std::size_t i = 0; i < rank; ++i) {  // L^-1 of the mean and of the root
            const double* row = joint_.data() + i * columns;
            double* solved = back_.data() + i * (n_ + 1);
            solved[0] = x_[order_[i]] - predicted_[k * n_ + order_[i]];
            std::copy_n(S_.data() + order_[i] * n_, n_, solved + 1);
            for (std::size_t m = 0; m < i; ++m)
                for (std::size_t j = 0; j <= n_; ++j)
                    solved[j] -= row[m] * back_[m * (n_ + 1) + j];
            for (std::size_t j = 0; j <= n_; ++j) solved[j] /= row[i];
        }
        for (std::size_t i = 0; i < n_; ++i) {
            next_x_[i] = x[i] + given_next(n_ + i, rank, next_S_.data() + i * 3 * n_);
            if (learned_.Q) {
                double* row = sum_Q_.data() + i * (4 * n_ + 1) + n_;
                row[0] = given_next(2 * n_ + i, rank, row + 1);
            }
        }
        triangularise(next_S_.data(), n_, 3 * n_);
        for (std::size_t i = 0; i < n_; ++i)
            std::copy_n(next_S_.data() + i * 3 * n_, n_, S_.data() + i * n_);
        x_ = next_x_;
        if (learned_.Q) triangularise(sum_Q_.data(), n_, 4 * n_ + 1);
    }
    // Row i of G L^-1 times the mean, and [M, G L^-1 S] in `root`, 3 n numbers.
    double given_next(std::size_t i, std::size_t rank, double* root) const {
        const double* row = joint_.data() + i * 2 * n_;
        double mean = 0.0;
        std::fill_n(root, 3 * n_, 0.0);
        std::copy(row + rank, row + 2 * n_, root + rank);
        for (std::size_t m = 0; m < rank; ++m) {
            const double* solved = back_.data() + m * (n_ + 1);
            mean += row[m] * solved[0];
            for (std::size_t j = 0; j < n_; ++j) root[2 * n_ + j] += row[m] * solved[1 + j];
        }
        return mean;
    }

    // What x(k|N) says of v(k); an entry that was not measured follows from the others by R.
    std::size_t observe(std::int64_t now, const double* y, const double* u,
                        const std::vector<double>& R) {
        there_.clear();
        for (std::size_t i = 0; i < p_; ++i)
            if (y[i] == y[i]) there_.push_back(i);
        const std::size_t q = there_.size(), wide = n_ + 1, columns = 2 * p_ + wide;
        if (q == 0) return 0;
        for (std::size_t i = 0; i < p_; ++i)
            if (y[i] != y[i]) there_.push_back(i);  // what is missing comes last
        model_->linear_output(now, x_.data(), u, y_hat_.data(), F_.data());
        for (std::size_t i = 0; i < p_; ++i) given_[i] = y[i] == y[i] ? y[i] : y_hat_[i];
        model_->difference(given_.data(), y_hat_.data(), innovation_.data());
        std::fill(residual_.begin(), residual_.end(), 0.0);
        for (std::size_t i = 0; i < q; ++i) {
            double* row = residual_.data() + i * wide;
            row[0] = innovation_[there_[i]];
            for (std::size_t m = 0; m < n_; ++m)
                for (std::size_t j = 0; j <= m; ++j)
                    row[1 + j] += F_[there_[i] * n_ + m] * S_[m * n_ + j];
        }
        for (std::size_t i = 0; i < p_; ++i)
            std::fill_n(sum_R_.data() + i * columns + p_, wide + p_, 0.0);
        for (std::size_t i = 0; i < q; ++i)
            std::copy_n(residual_.data() + i * wide, wide,
                        sum_R_.data() + there_[i] * columns + p_);
        if (q < p_) {
            for (std::size_t i = 0; i < p_; ++i)
                std::copy_n(R.data() + there_[i] * p_, p_, known_.data() + i * p_);
            triangularise(known_.data(), p_, p_);
            for (std::size_t i = 0; i < q; ++i) {
                const double pivot = known_[i * p_ + i];
                double* row = residual_.data() + i * wide;
                for (std::size_t m = 0; m < i; ++m)
                    for (std::size_t j = 0; j < wide; ++j)
                        row[j] -= known_[i * p_ + m] * residual_[m * wide + j];
                for (std::size_t j = 0; j < wide; ++j) row[j] = pivot > 0.0 ? row[j] / pivot : 0.0;
            }
            for (std::size_t i = q; i < p_; ++i) {
                double* row = sum_R_.data() + there_[i] * columns + p_;
                for (std::size_t m = 0; m < q; ++m)
                    for (std::size_t j = 0; j < wide; ++j)
                        row[j] += known_[i * p_ + m] * residual_[m * wide + j];
                for (std::size_t m = q; m <= i; ++m) row[wide + m] = known_[i * p_ + m];
            }
        }
        triangularise(sum_R_.data(), p_, columns);
        return 1;
    }

    // The root of a mean, from the root of a sum in the first columns.
    void take(const std::vector<double>& sum, std::size_t size, std::size_t columns,
              std::size_t count, std::vector<double>& root) const {
        const double share = 1.0 / std::sqrt(static_cast<double>(count));
        root.assign(size * size, 0.0);
        for (std::size_t i = 0; i < size; ++i) {
            double square = 0.0;
            for (std::size_t j = 0; j <= i; ++j) {
                const double entry = share * sum[i * columns + j];
                square += entry * entry;
                if (!learned_.diagonal) root[i * size + j] = entry;
            }
            if (learned_.diagonal) root[i * size + i] = std::sqrt(square);
        }
        for (const double entry : root)
            if (!(entry - entry == 0.0))
                throw EstimationError{"range", "a learned covariance left the range of float64"};
    }

    std::shared_ptr<EstimationModel> model_;
    LearnedNoises learned_;
    std::size_t n_, p_;
    std::vector<double> F_, next_, y_hat_, given_, innovation_, joint_, back_, next_x_, next_S_,
        residual_, known_, x_, S_, sum_Q_, sum_R_, filtered_x_, filtered_S_, predicted_;
    std::vector<std::size_t> order_, there_;
};

// An extended Kalman filter whose noises are learned from every `window` steps and used from then on
// (block-wise on-line expectation maximisation: Le Corff and Fort 2013).
class AdaptiveKalmanFilter final : public ExtendedKalmanFilter {
public:
    AdaptiveKalmanFilter(std::size_t window, std::int64_t iterations, LearnedNoises learned,
                         std::shared_ptr<EstimationModel> model, std::vector<double> x_0,
                         std::vector<double> S_0, std::vector<double> Q_root,
                         std::vector<double> R_root)
        : ExtendedKalmanFilter(model, std::move(x_0), std::move(S_0), std::move(Q_root),
                               std::move(R_root)),
          learning_(model, learned),
          window_(window),
          iterations_(iterations),
          l_u_(model->l_u),
          y_(window * p_),
          u_(window * l_u_),
          pending_(p_, std::nan("")) {
        KalmanFilter::keep(start_);
    }

    void correct(const double* y, const double* u) override {
        ExtendedKalmanFilter::correct(y, u);
        pending_.assign(y, y + p_);
    }
    void predict(const double* u) override {
        const auto filled = static_cast<std::size_t>(filled_);
        std::copy(pending_.begin(), pending_.end(),
                  y_.begin() + static_cast<std::ptrdiff_t>(filled * p_));
        std::copy_n(u, l_u_, u_.data() + filled * l_u_);
        std::vector<double> Q, R;
        const bool whole = filled + 1 == window_;
        if (whole) {
            Q = Q_root_;
            R = R_root_;
            for (std::int64_t i = 0; i < iterations_; ++i)
                learning_.iterate(start_, y_.data(), u_.data(), window_, Q, R);
            Q.swap(Q_root_);
            R.swap(R_root_);
        }
        try {
            ExtendedKalmanFilter::predict(u);
        } catch (...) {
            if (whole) {
                Q.swap(Q_root_);
                R.swap(R_root_);
            }
            throw;
        }
        filled_ = whole ? 0 : filled_ + 1;
        if (whole) KalmanFilter::keep(start_);
        pending_.assign(p_, std::nan(""));
    }

    void visit(Archive& archive) override {
        ExtendedKalmanFilter::visit(archive);
        archive(filled_, 0, static_cast<std::int64_t>(window_) - 1);
        archive(start_.k, 0, Archive::longest);
        archive(start_.x);
        archive(start_.S);
        archive(Q_root_);
        archive(R_root_);
        archive(y_);
        archive(u_);
        archive(pending_);
    }

protected:
    void go_back() override {
        ExtendedKalmanFilter::go_back();
        pending_.assign(p_, std::nan(""));
    }

private:
    NoiseLearning learning_;
    std::size_t window_;
    std::int64_t iterations_, filled_ = 0;
    std::size_t l_u_;
    Belief start_;  // before the first step of the block
    std::vector<double> y_, u_, pending_;
};

}  // namespace rcac
