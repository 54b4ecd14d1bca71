// Prediction errors of a Box-Jenkins or ARMAX model of a scalar record, and their derivatives.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "identification/orthogonal_rows.hpp"
#include "identification/rational_filter.hpp"

namespace rcac {

// y = B/A u + levels (+ sinusoid) + C/(D (1 - q^-1)^i) e, or with A y for y and A in front of the
// levels where `armax` is set. B begins with q^-1.
struct BoxJenkinsRecord {
    std::vector<double> y, u;
    std::vector<double> levels;   // rows of y's length, of free size
    std::vector<double> weights;  // of the errors; empty where all are 1
    std::size_t n, m, n_C, n_D;   // coefficients of A, B, C and D
    bool differences, armax, sinusoid;
    double dependent;  // of the norm of a free row: what the others leave of it is rounding

    std::size_t coefficients() const { return n + m + n_C + n_D + sinusoid; }
};

// The errors at coefficients of A, B, C, D (and a frequency), with levels, sinusoid and initial
// state projected out (Golub and Pereyra).
class BoxJenkinsErrors {
public:
    BoxJenkinsErrors(std::shared_ptr<const BoxJenkinsRecord> record, std::vector<double> theta)
        : shared_(std::move(record)), record_(*shared_), theta_(std::move(theta)),
          steps_(record_.y.size()) {
        const std::size_t n = record_.n, m = record_.m, n_C = record_.n_C, n_D = record_.n_D;
        A_ = polynomial(1.0, 0, n);
        const std::vector<double> B = polynomial(0.0, n, m), D = polynomial(1.0, n + m + n_C, n_D);
        C_ = polynomial(1.0, n + m, n_C);
        whitener_ = record_.differences ? product(D, {1.0, -1.0}) : D;
        levels_ = record_.levels.size() / steps_;
        fixed_ = levels_ + (record_.sinusoid ? 2 : 0);
        raw_.assign((fixed_ + 2) * steps_, 0.0);
        simulate(B);
        add_free_rows();
        std::vector<double> white(raw_.size());
        RationalFilter(whitener_, C_).rows(raw_.data(), white.data(), fixed_ + 2, steps_);
        const double* response = white.data() + (fixed_ + 1) * steps_;
        is_finite_ = are_finite(white.data(), steps_) && are_finite(response, steps_);
        if (!is_finite_) return;
        e_.assign(white.begin(), white.begin() + steps_);
        std::vector<double> rows((fixed_ + n) * steps_, 0.0);
        std::copy_n(white.data() + steps_, fixed_ * steps_, rows.data());
        for (std::size_t i = 0; i < n && i < steps_; ++i)
            std::copy_n(response, steps_ - i, rows.data() + (fixed_ + i) * steps_ + i);
        weigh(e_.data(), 1);
        weigh(rows.data(), fixed_ + n);
        free_rows_ = std::make_unique<OrthogonalRows>(std::move(rows), fixed_ + n, steps_,
                                                      record_.dependent);
        free_ = free_rows_->combination(free_rows_->project_out(e_.data()));
    }

    bool is_finite() const { return is_finite_; }
    const std::vector<double>& theta() const { return theta_; }
    const std::vector<double>& e() const { return e_; }
    double square() const { return dot(e_.data(), e_.data(), steps_); }

    // What plant, levels, initial state and, where `waves` is set, the sinusoid leave of y.
    std::vector<double> remainder(bool waves) const {
        std::vector<double> v(raw_.begin(), raw_.begin() + steps_);
        const std::size_t rows = waves ? fixed_ : levels_;
        for (std::size_t i = 0; i < rows; ++i)
            subtract(v.data(), free_[i], raw_.data() + (1 + i) * steps_, steps_);
        const std::vector<double> state = free_response();
        for (std::size_t k = 0; k < steps_; ++k) v[k] -= state[k];
        return v;
    }

    // A row for each coefficient, less its projection on what is free (Kaufman).
    std::vector<double> jacobian() const {
        const std::size_t n = record_.n, m = record_.m, n_C = record_.n_C, n_D = record_.n_D;
        std::vector<double> J(theta_.size() * steps_, 0.0);
        std::vector<double> two(2 * steps_);  // y or x, and -u
        for (std::size_t k = 0; k < steps_; ++k) two[steps_ + k] = -record_.u[k];
        if (record_.armax) {
            std::copy(record_.y.begin(), record_.y.end(), two.begin());
            RationalFilter(whitener_, C_).rows(two.data(), two.data(), 2, steps_);
        } else {  // the free response has the poles of the plant
            const std::vector<double> state = free_response();
            for (std::size_t k = 0; k < steps_; ++k) two[k] = x_[k] + state[k];
            RationalFilter(whitener_, product(C_, A_)).rows(two.data(), two.data(), 2, steps_);
        }
        put(J, 0, n, two.data(), 1.0);
        put(J, n, m, two.data() + steps_, 1.0);
        const std::vector<double> v = n_C + n_D ? remainder(true) : std::vector<double>();
        std::vector<double> row(steps_);
        if (n_C) {
            if (record_.weights.empty())
                row = e_;
            else
                RationalFilter(whitener_, C_).rows(v.data(), row.data(), 1, steps_);
            RationalFilter({1.0}, C_).rows(row.data(), row.data(), 1, steps_);
            put(J, n + m, n_C, row.data(), -1.0);
        }
        if (n_D) {
            const std::vector<double> top =
                record_.differences ? std::vector<double>{1.0, -1.0} : std::vector<double>{1.0};
            RationalFilter(top, C_).rows(v.data(), row.data(), 1, steps_);
            put(J, n + m + n_C, n_D, row.data(), 1.0);
        }
        if (record_.sinusoid) {
            const double a = free_[levels_], b = free_[levels_ + 1];
            const double *cosine = raw_.data() + (1 + levels_) * steps_, *sine = cosine + steps_;
            for (std::size_t k = 0; k < steps_; ++k)
                row[k] = static_cast<double>(k) * (a * sine[k] - b * cosine[k]);
            RationalFilter(whitener_, C_)
                .rows(row.data(), J.data() + (theta_.size() - 1) * steps_, 1, steps_);
        }
        weigh(J.data(), theta_.size());
        for (std::size_t i = 0; i < theta_.size(); ++i)
            free_rows_->project_out(J.data() + i * steps_);
        return J;
    }

    static bool are_finite(const double* values, std::size_t count) {
        for (std::size_t k = 0; k < count; ++k)
            if (!std::isfinite(values[k])) return false;
        return true;
    }

private:
    std::vector<double> polynomial(double first, std::size_t from, std::size_t count) const {
        std::vector<double> p{first};
        p.insert(p.end(), theta_.begin() + from, theta_.begin() + from + count);
        return p;
    }

    static std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
        std::vector<double> p(a.size() + b.size() - 1, 0.0);
        for (std::size_t i = 0; i < a.size(); ++i)
            for (std::size_t j = 0; j < b.size(); ++j) p[i + j] += a[i] * b[j];
        return p;
    }

    // y less what u does, and the response to an initial state.
    void simulate(const std::vector<double>& B) {
        double *v = raw_.data(), *response = raw_.data() + (fixed_ + 1) * steps_;
        x_.resize(steps_);
        response[0] = 1.0;
        if (record_.armax) {
            RationalFilter(A_, {1.0}).rows(record_.y.data(), v, 1, steps_);
            RationalFilter(B, {1.0}).rows(record_.u.data(), x_.data(), 1, steps_);
            for (std::size_t k = 0; k < steps_; ++k) v[k] -= x_[k];
        } else {
            RationalFilter(B, A_).rows(record_.u.data(), x_.data(), 1, steps_);
            for (std::size_t k = 0; k < steps_; ++k) v[k] = record_.y[k] - x_[k];
            RationalFilter({1.0}, A_).rows(response, response, 1, steps_);
        }
    }

    void add_free_rows() {
        double* row = raw_.data() + steps_;
        std::copy(record_.levels.begin(), record_.levels.end(), row);
        if (!record_.sinusoid) return;
        row += levels_ * steps_;
        for (std::size_t k = 0; k < steps_; ++k) {
            const double phase = theta_.back() * static_cast<double>(k);
            row[k] = std::cos(phase);
            row[steps_ + k] = std::sin(phase);
        }
    }

    std::vector<double> free_response() const {
        std::vector<double> state(steps_, 0.0);
        const double* response = raw_.data() + (fixed_ + 1) * steps_;
        for (std::size_t i = 0; i < record_.n && i < steps_; ++i)
            subtract(state.data() + i, -free_[fixed_ + i], response, steps_ - i);
        return state;
    }

    // The derivatives by the coefficients of q^-1, q^-2, ... are one signal, later and later.
    void put(std::vector<double>& J, std::size_t first, std::size_t count, const double* signal,
             double sign) const {
        for (std::size_t i = 0; i < count; ++i) {
            double* row = J.data() + (first + i) * steps_;
            for (std::size_t k = i + 1; k < steps_; ++k) row[k] = sign * signal[k - i - 1];
        }
    }

    void weigh(double* rows, std::size_t count) const {
        if (record_.weights.empty()) return;
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < steps_; ++k) rows[i * steps_ + k] *= record_.weights[k];
    }

    std::shared_ptr<const BoxJenkinsRecord> shared_;
    const BoxJenkinsRecord& record_;
    std::vector<double> theta_;
    std::size_t steps_, levels_ = 0, fixed_ = 0;
    std::vector<double> A_, C_, whitener_, x_;
    std::vector<double> raw_;  // rows: y less what u does, levels, waves, initial response
    std::vector<double> e_, free_;
    std::unique_ptr<OrthogonalRows> free_rows_;
    bool is_finite_ = false;
};

}  // namespace rcac
