// What RCMR may put in place of an unknown subsystem: u^(k) = Phi(k) theta.
#pragma once

#include <algorithm>
#include <vector>

#include "memory/archive.hpp"

namespace rcac {

class Subsystem {
public:
    Subsystem(std::size_t outputs, std::size_t parameters) : l_u(outputs), l_theta(parameters) {}
    virtual ~Subsystem() = default;
    // Phi(k), l_u x l_theta, from the model's state and the known input; called once a step.
    virtual void regressor(const double* x, const double* w, double* Phi) = 0;
    virtual void visit(Archive&) {}

    const std::size_t l_u, l_theta;
};

// u^(k) = sum of N_i y_0^(k - i), i = 1..n_c where strictly proper (8.57), else i = 0..n_c-1;
// theta holds [N_1 ... N_nc] row by row.
class FirSubsystem final : public Subsystem {
public:
    FirSubsystem(std::vector<double> E_1, std::size_t n, std::size_t l_u, std::size_t l_y0,
                 std::size_t n_c, bool strictly_proper)
        : Subsystem(l_u, l_u * n_c * l_y0),
          E_1_(std::move(E_1)),
          n_(n),
          l_y0_(l_y0),
          strictly_proper_(strictly_proper),
          phi_(n_c * l_y0, 0.0) {}

    void regressor(const double* x, const double*, double* Phi) override {
        if (!strictly_proper_) take(x);
        std::fill_n(Phi, l_u * l_theta, 0.0);
        for (std::size_t i = 0; i < l_u; ++i)
            std::copy(phi_.begin(), phi_.end(), Phi + i * l_theta + i * phi_.size());
        if (strictly_proper_) take(x);
    }
    void visit(Archive& archive) override { archive(phi_); }

private:
    void take(const double* x) {
        std::copy_backward(phi_.begin(), phi_.end() - static_cast<std::ptrdiff_t>(l_y0_),
                           phi_.end());
        for (std::size_t i = 0; i < l_y0_; ++i) {
            phi_[i] = 0.0;
            for (std::size_t j = 0; j < n_; ++j) phi_[i] += E_1_[i * n_ + j] * x[j];
        }
    }
    std::vector<double> E_1_;
    std::size_t n_, l_y0_;
    bool strictly_proper_;
    std::vector<double> phi_;
};

// Column j of Phi is A_j x + D_j w: parameters that stand in several places of A and D_1 (8.73).
class RepeatedSubsystem final : public Subsystem {
public:
    RepeatedSubsystem(std::vector<double> A, std::vector<double> D, std::size_t n, std::size_t l_w,
                      std::size_t l_theta)
        : Subsystem(n, l_theta), A_(std::move(A)), D_(std::move(D)), l_w_(l_w) {}

    void regressor(const double* x, const double* w, double* Phi) override {
        const std::size_t n = l_u;
        for (std::size_t j = 0; j < l_theta; ++j)
            for (std::size_t i = 0; i < n; ++i) {
                double sum = 0.0;
                for (std::size_t m = 0; m < n; ++m) sum += A_[(j * n + i) * n + m] * x[m];
                for (std::size_t m = 0; m < l_w_; ++m) sum += D_[(j * n + i) * l_w_ + m] * w[m];
                Phi[i * l_theta + j] = sum;
            }
    }

private:
    std::vector<double> A_, D_;
    std::size_t l_w_;
};

}  // namespace rcac
