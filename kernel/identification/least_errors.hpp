// The least prediction errors of a Box-Jenkins or ARMAX model, by Levenberg and Marquardt.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "identification/box_jenkins.hpp"
#include "identification/orthogonal_rows.hpp"
#include "polynomials/roots.hpp"

namespace rcac {

struct LeastErrorsRules {
    std::size_t iterations, widths;  // widths: damping factors that are tried in an iteration
    std::size_t kept;                // the first coefficients, which do not move
    double decrease;  // of N log(sum of squares): below it an iteration has settled
    double settled;   // of `decrease`: a predicted decrease below it is not tried
    double circle, of_C;  // largest modulus of a root of A and D, and of C
};

struct LeastErrors {
    std::unique_ptr<BoxJenkinsErrors> point;  // null where the errors of the start leave float64
    std::vector<double> J;
};

// A monic polynomial with its roots reflected into a circle, or pulled onto it.
inline std::vector<double> confined(std::vector<double> A, double radius) {
    if (BoxJenkinsErrors::are_finite(A.data(), A.size())) reflect(A, radius);
    return A;
}

// x of M x = right in the place of right, by Gauss with pivots; false where M is singular.
inline bool solve(std::vector<double>& M, std::vector<double>& right) {
    const std::size_t n = right.size();
    for (std::size_t j = 0; j < n; ++j) {
        std::size_t pivot = j;
        for (std::size_t i = j + 1; i < n; ++i)
            if (std::fabs(M[i * n + j]) > std::fabs(M[pivot * n + j])) pivot = i;
        if (M[pivot * n + j] == 0.0) return false;
        if (pivot != j) {
            std::swap_ranges(&M[j * n], &M[j * n] + n, &M[pivot * n]);
            std::swap(right[j], right[pivot]);
        }
        for (std::size_t i = j + 1; i < n; ++i) {
            const double factor = M[i * n + j] / M[j * n + j];
            if (factor == 0.0) continue;
            subtract(&M[i * n], factor, &M[j * n], n);
            right[i] -= factor * right[j];
        }
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t j = i + 1; j < n; ++j) right[i] -= M[i * n + j] * right[j];
        right[i] /= M[i * (n + 1)];
    }
    return true;
}

// J J' and J e over the norms of the rows of J. The rows that are kept have no slope.
struct NormalEquations {
    NormalEquations(const std::vector<double>& J, const std::vector<double>& e, std::size_t kept)
        : size(J.size() / e.size()), H(size * size), slope(size), norm(size) {
        const std::size_t n = size, steps = e.size();
        for (std::size_t i = 0; i < n; ++i) {
            slope[i] = dot(J.data() + i * steps, e.data(), steps);
            for (std::size_t j = 0; j <= i; ++j)
                H[i * n + j] = dot(J.data() + i * steps, J.data() + j * steps, steps);
            norm[i] = std::sqrt(H[i * (n + 1)]);
            if (norm[i] == 0.0) norm[i] = 1.0;
        }
        for (std::size_t i = 0; i < n; ++i) {
            slope[i] = i < kept ? 0.0 : slope[i] / norm[i];
            for (std::size_t j = 0; j <= i; ++j) {
                const double unit = i == j ? 1.0 : 0.0;
                H[i * n + j] = j < kept ? unit : H[i * n + j] / norm[j] / norm[i];
                H[j * n + i] = H[i * n + j];
            }
        }
    }

    // The step in units of the norms; false where the equations are singular.
    bool step(double damping, std::vector<double>& x) const {
        std::vector<double> M = H;
        for (std::size_t i = 0; i < size; ++i) {
            M[i * (size + 1)] += damping;
            x[i] = -slope[i];
        }
        return solve(M, x);
    }

    // By how much the sum of squares falls, to first order.
    double gain(const std::vector<double>& x) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < size; ++i)
            sum -= (2.0 * slope[i] + dot(&H[i * size], x.data(), size)) * x[i];
        return sum;
    }

    std::size_t size;
    std::vector<double> H, slope, norm;
};

// `check` is called before errors are computed, and may throw.
template <class Check>
class LevenbergMarquardt {
public:
    LevenbergMarquardt(std::shared_ptr<const BoxJenkinsRecord> record, LeastErrorsRules rules,
                       Check check)
        : record_(std::move(record)), rules_(rules), check_(std::move(check)) {}

    LeastErrors run(std::vector<double> theta) {
        LeastErrors least;
        move(least, errors(std::move(theta)));
        if (!least.point) return least;
        damping_ = 1e-3;
        for (std::size_t i = 0; i < rules_.iterations; ++i) {
            std::unique_ptr<BoxJenkinsErrors> better = improved(least);
            if (!better) break;
            const double ratio = better->square() / least.point->square();
            const bool has_settled = steps() * (1.0 - ratio) < rules_.decrease;
            if (!move(least, std::move(better)) || has_settled) break;
        }
        return least;
    }

private:
    double steps() const { return static_cast<double>(record_->y.size()); }

    // The errors with stable filters, and a frequency below the Nyquist frequency.
    std::unique_ptr<BoxJenkinsErrors> errors(std::vector<double> theta) const {
        check_();
        const BoxJenkinsRecord& r = *record_;
        if (!r.armax) confine(theta, 0, r.n, rules_.circle);
        confine(theta, r.n + r.m, r.n_C, rules_.of_C);
        confine(theta, r.n + r.m + r.n_C, r.n_D, rules_.circle);
        if (r.sinusoid) {
            constexpr double pi = 3.141592653589793;
            double turn = std::fmod(theta.back() + pi, 2.0 * pi);
            if (turn < 0.0) turn += 2.0 * pi;
            theta.back() = std::fabs(turn - pi);
        }
        auto point = std::make_unique<BoxJenkinsErrors>(record_, std::move(theta));
        return point->is_finite() ? std::move(point) : nullptr;
    }

    static void confine(std::vector<double>& theta, std::size_t first, std::size_t count,
                        double radius) {
        std::vector<double> A{1.0};
        A.insert(A.end(), theta.begin() + first, theta.begin() + first + count);
        A = confined(std::move(A), radius);
        std::copy(A.begin() + 1, A.end(), theta.begin() + first);
    }

    // False, and nothing happens, where errors or derivatives leave float64.
    static bool move(LeastErrors& least, std::unique_ptr<BoxJenkinsErrors> point) {
        if (!point) return false;
        std::vector<double> J = point->jacobian();
        if (!BoxJenkinsErrors::are_finite(J.data(), J.size())) return false;
        least.point = std::move(point);
        least.J = std::move(J);
        return true;
    }

    // A point of a smaller sum of squares; null where there is none, or none worth the step.
    std::unique_ptr<BoxJenkinsErrors> improved(const LeastErrors& least) {
        const NormalEquations equations(least.J, least.point->e(), rules_.kept);
        const double square = least.point->square();
        std::vector<double> x(equations.size);
        for (std::size_t i = 0; i < rules_.widths; ++i) {
            if (!equations.step(damping_, x)) {
                damping_ *= 10.0;
                continue;
            }
            if (steps() * equations.gain(x) < rules_.settled * rules_.decrease * square) break;
            std::vector<double> theta = least.point->theta();
            for (std::size_t k = 0; k < theta.size(); ++k) theta[k] += x[k] / equations.norm[k];
            std::unique_ptr<BoxJenkinsErrors> trial = errors(std::move(theta));
            if (trial && trial->square() < square) {
                damping_ = std::max(damping_ / 5.0, 1e-9);
                return trial;
            }
            damping_ = std::max(6.0 * damping_, 1e-6);
        }
        return nullptr;
    }

    std::shared_ptr<const BoxJenkinsRecord> record_;
    LeastErrorsRules rules_;
    Check check_;
    double damping_ = 0.0;
};

}  // namespace rcac
