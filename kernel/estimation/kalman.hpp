// A Gaussian belief that is moved by a model and corrected by measurements.
#pragma once

#include <cmath>
#include <memory>

#include "estimation/model.hpp"
#include "estimation/triangular.hpp"
#include "memory/archive.hpp"

namespace rcac {

// What is believed of x at step k: the mean, and the square root S of the covariance P = S S'; and
// what the last innovation was.
struct Belief {
    std::int64_t k = 0;
    std::vector<double> x, S, innovation;
    double squared = 0.0, log_determinant = 0.0;
};

// Every step works on copies and commits at its end, so that a step that throws leaves the filter
// where it was.
class KalmanFilter {
public:
    KalmanFilter(std::shared_ptr<EstimationModel> model, std::vector<double> x_0,
                 std::vector<double> S_0, std::vector<double> Q_root, std::vector<double> R_root)
        : model_(std::move(model)),
          n_(model_->n),
          p_(model_->l_y),
          x_(std::move(x_0)),
          S_(std::move(S_0)),
          Q_root_(std::move(Q_root)),
          R_root_(std::move(R_root)),
          next_(n_),
          y_hat_(p_),
          innovation_(p_),
          given_(p_) {}
    virtual ~KalmanFilter() = default;

    // x(k|k-1) -> x(k|k) by the entries of y that are numbers; NaN is a sensor that says nothing.
    virtual void correct(const double* y, const double* u) {
        there_.clear();
        for (std::size_t i = 0; i < p_; ++i)
            if (y[i] == y[i]) there_.push_back(i);
        if (there_.empty()) {
            remember();
            corrected_ = x_;
            std::fill(innovation_.begin(), innovation_.end(), std::nan(""));
            squared_ = log_determinant_ = std::nan("");  // nothing was judged
        } else {
            correct_there(y, u);
        }
    }
    // x(k|k) -> x(k+1|k)
    virtual void predict(const double* u) = 0;
    // Both; x(k|k-1) -> x(k+1|k), or nothing where either of them throws.
    void correct_and_predict(const double* y, const double* u) {
        correct(y, u);
        try {
            predict(u);
        } catch (...) {
            go_back();
            throw;
        }
    }
    // The noises of the next steps; what is empty stays as it is.
    virtual void set_noises(std::vector<double> Q_root, std::vector<double> R_root) {
        if (!Q_root.empty()) Q_root_ = std::move(Q_root);
        if (!R_root.empty()) R_root_ = std::move(R_root);
    }
    const std::vector<double>& Q_root() const { return Q_root_; }
    const std::vector<double>& R_root() const { return R_root_; }
    virtual void covariance(double* P) const {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = 0.0;
                for (std::size_t m = 0; m <= j; ++m) sum += S_[i * n_ + m] * S_[j * n_ + m];
                P[i * n_ + j] = P[j * n_ + i] = sum;
            }
    }
    virtual double variance(std::size_t i) const {
        double sum = 0.0;
        for (std::size_t m = 0; m <= i; ++m) sum += S_[i * n_ + m] * S_[i * n_ + m];
        return sum;
    }
    // e' S_y^-1 e and log det S_y of the last correction.
    double squared_innovation() const { return squared_; }
    double log_determinant() const { return log_determinant_; }
    // Of what was measured, under the model.
    virtual double log_likelihood() const {
        return -0.5 * (squared_ + log_determinant_ +
                       static_cast<double>(there_.size()) * std::log(2.0 * 3.14159265358979323846));
    }
    // How many entries of y that correction was of.
    std::size_t measured() const { return there_.size(); }
    // L with L L' = S_y of those entries.
    const std::vector<double>& innovation_root() const { return innovation_root_; }
    // How many modes have a probability, and these; none where there is one model.
    virtual std::size_t modes() const { return 0; }
    virtual void probabilities(double*) const {}
    void keep(Belief& into) const {
        into.k = k_;
        into.x = x_;
        into.S = S_;
        into.innovation = innovation_;
        into.squared = squared_;
        into.log_determinant = log_determinant_;
    }
    void believe(const double* x, const double* S) {
        x_.assign(x, x + n_);
        S_.assign(S, S + n_ * n_);
    }
    void put_back(const Belief& belief) {
        k_ = belief.k;
        x_ = belief.x;
        S_ = belief.S;
        innovation_ = belief.innovation;
        squared_ = belief.squared;
        log_determinant_ = belief.log_determinant;
    }
    const std::vector<double>& innovation() const { return innovation_; }
    const std::vector<double>& x() const { return x_; }
    const std::vector<double>& root() const { return S_; }
    const std::vector<double>& corrected() const { return corrected_; }  // the last x(k|k)
    EstimationModel& model() { return *model_; }
    std::int64_t k() const { return k_; }

    virtual void visit(Archive& archive) {
        archive(k_, 0, Archive::longest);
        archive(x_);
        archive(S_);
        archive(innovation_);
        archive(squared_);
        archive(log_determinant_);
    }

protected:
    virtual void correct_there(const double* y, const double* u) = 0;

    // The innovation, and its measured entries in `whitened_`.
    void innovate(const double* y) {
        // A function of the user sees what was expected where nothing was measured.
        std::copy(y_hat_.begin(), y_hat_.end(), given_.begin());
        for (const std::size_t i : there_) given_[i] = y[i];
        next_innovation_.assign(p_, 0.0);
        model_->difference(given_.data(), y_hat_.data(), next_innovation_.data());
        for (std::size_t i = 0; i < there_.size(); ++i)
            whitened_[i] = next_innovation_[there_[i]];
        for (std::size_t i = 0; i < p_; ++i)
            if (y[i] != y[i]) next_innovation_[i] = y[i];
    }

    // From M = [[., .], [., .]] with M M' = [[S_y, P_yx], [P_xy, P]], triangular: L_y in the rows
    // of what was measured, then P_xy L_y'^-1 and the new S. `columns` is the length of its rows.
    void commit(const double* M, std::size_t columns, const double* y) {
        const std::size_t q = there_.size();
        innovate(y);
        if (!solve_lower(M, q, columns, whitened_.data()))
            throw EstimationError{"singular", "the covariance of the innovation is singular"};
        for (std::size_t i = 0; i < n_; ++i) {
            const double* row = M + (q + i) * columns;
            next_[i] = x_[i];
            for (std::size_t j = 0; j < q; ++j) next_[i] += row[j] * whitened_[j];
        }
        require_range(next_.data(), n_);
        require_range(M, (n_ + q) * columns);
        remember();
        for (std::size_t i = 0; i < n_; ++i)
            std::copy_n(M + (q + i) * columns + q, n_, S_.data() + i * n_);
        x_ = next_;
        accept(M, columns);
    }
    // What a correction begins with, and goes back to where the prediction after it fails.
    virtual void remember() { keep(before_); }
    virtual void go_back() { put_back(before_); }

    void accept(const double* L_y, std::size_t columns) {
        corrected_ = x_;
        innovation_ = next_innovation_;
        weigh(L_y, columns);
    }
    // The whitened innovation and its L_y in numbers.
    void weigh(const double* L_y, std::size_t columns) {
        const std::size_t q = there_.size();
        squared_ = log_determinant_ = 0.0;
        innovation_root_.resize(q * q);
        for (std::size_t i = 0; i < q; ++i) {
            squared_ += whitened_[i] * whitened_[i];
            log_determinant_ += 2.0 * std::log(L_y[i * columns + i]);
            std::fill_n(innovation_root_.data() + i * q, q, 0.0);
            std::copy_n(L_y + i * columns, i + 1, innovation_root_.data() + i * q);
        }
    }

    static void require_range(const double* values, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i)
            if (!(values[i] - values[i] == 0.0))
                throw EstimationError{"range", "the estimate left the range of float64"};
    }

    std::shared_ptr<EstimationModel> model_;
    std::size_t n_, p_;
    std::int64_t k_ = 0;
    std::vector<double> x_, S_, Q_root_, R_root_, next_, y_hat_, innovation_, given_, corrected_,
        innovation_root_;
    Belief before_;
    std::vector<std::size_t> there_;  // the entries of y that are numbers
    std::vector<double> next_innovation_ = std::vector<double>(p_), whitened_ = next_innovation_;
    double squared_ = 0.0, log_determinant_ = 0.0;
};

}  // namespace rcac
