// Prediction errors of signals with noise C/W where some steps are missing, by the Kalman filter.
#include <algorithm>
#include <cmath>

#include "bindings/bindings.hpp"
#include "bindings/numpy_arrays.hpp"

namespace rcac {
namespace {

// s(k+1) = F s(k) + K e(k), v(k) = s_1(k) + e(k), F the companion of W with -w_i in its first column
// and K_i = c_i - w_i. P is the covariance of s less its prediction, over that of e: 0 as long as
// nothing was missing, so that the errors are those of the filter W/C there.
class Predictor {
public:
    Predictor(const std::vector<double>& W, const std::vector<double>& C)
        : n_(std::max(W.size(), C.size()) - 1), w_(n_), K_(n_), P_(n_ * n_), next_(n_ * n_), L_(n_) {
        for (std::size_t i = 0; i < n_; ++i) {
            w_[i] = i + 1 < W.size() ? W[i + 1] : 0.0;
            K_[i] = (i + 1 < C.size() ? C[i + 1] : 0.0) - w_[i];
        }
    }

    // The variance of the prediction error of the step over that of e; the gain is in L.
    double observe() {
        const double f = 1.0 + (n_ && uncertain_ ? P_[0] : 0.0);
        for (std::size_t i = 0; i < n_; ++i) L_[i] = K_[i];
        if (!uncertain_ || !n_) return f;
        for (std::size_t i = 0; i < n_; ++i) L_[i] = (shifted(i) + K_[i]) / f;
        advance();
        double largest = 0.0;
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < n_; ++j) {
                next_[i * n_ + j] -= L_[i] * L_[j] * f;
                largest = std::max(largest, std::fabs(next_[i * n_ + j]));
            }
        P_.swap(next_);
        uncertain_ = largest > 1e-14;
        if (!uncertain_) std::fill(P_.begin(), P_.end(), 0.0);
        return f;
    }

    void miss() {
        if (!n_) return;
        advance();
        P_.swap(next_);
        uncertain_ = true;
        std::fill(L_.begin(), L_.end(), 0.0);
    }

    // The state of one signal, from its prediction error; 0 where it is missing.
    void move(double* s, double error) const {
        const double first = n_ ? s[0] : 0.0;
        for (std::size_t i = 0; i < n_; ++i)
            s[i] = (i + 1 < n_ ? s[i + 1] : 0.0) - w_[i] * first + L_[i] * error;
    }

    std::size_t size() const { return n_; }

private:
    double shifted(std::size_t i) const {  // of F P H'
        return (i + 1 < n_ ? P_[(i + 1) * n_] : 0.0) - w_[i] * P_[0];
    }
    void advance() {  // F P F' + K K'
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < n_; ++j) {
                const bool a = i + 1 < n_, b = j + 1 < n_;
                const double corner = a && b ? P_[(i + 1) * n_ + j + 1] : 0.0;
                const double left = a ? P_[(i + 1) * n_] : 0.0, right = b ? P_[j + 1] : 0.0;
                next_[i * n_ + j] = corner - left * w_[j] - w_[i] * right +
                                    w_[i] * w_[j] * P_[0] + K_[i] * K_[j];
            }
    }

    std::size_t n_;
    std::vector<double> w_, K_, P_, next_, L_;
    bool uncertain_ = false;
};

// Errors over the roots of their variances, 0 where a step is missing, and the sum of the logarithms
// of these variances.
nb::tuple errors_with_gaps(const Array& signals, const Array& whitener, const Array& C,
                           const Array& observed) {
    const std::size_t steps = observed.size();
    refuse_unless(steps > 0 && signals.size() % steps == 0, "signals are not rows of `observed`");
    require_range<std::size_t>(whitener.size(), 1, 64, "the length of the whitener");
    require_range<std::size_t>(C.size(), 1, 64, "the length of C");
    const std::size_t count = signals.size() / steps;
    Predictor predictor(copied(whitener, whitener.size(), "whitener"), copied(C, C.size(), "C"));
    const std::size_t n = predictor.size();
    std::vector<double> errors(length_of({count, steps}, "errors"), 0.0), states(count * n, 0.0);
    double logarithms = 0.0;
    for (std::size_t k = 0; k < steps; ++k) {
        const bool is_observed = observed.data()[k] != 0.0;
        double root = 1.0;
        if (is_observed) {
            const double f = predictor.observe();
            root = std::sqrt(f);
            logarithms += std::log(f);
        } else {
            predictor.miss();
        }
        for (std::size_t m = 0; m < count; ++m) {
            double* s = states.data() + m * n;
            const double predicted = n ? s[0] : 0.0;
            const double error = is_observed ? signals.data()[m * steps + k] - predicted : 0.0;
            predictor.move(s, error);
            errors[m * steps + k] = error / root;
        }
    }
    return nb::make_tuple(to_numpy(std::move(errors), {count, steps}), logarithms);
}

}  // namespace

void bind_gaps(nb::module_& m) {
    m.def("errors_with_gaps", &errors_with_gaps, nb::kw_only(), nb::arg("signals"),
          nb::arg("whitener"), nb::arg("C"), nb::arg("observed"));
}

}  // namespace rcac
