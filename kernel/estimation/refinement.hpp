// Retrospective cost model refinement (8.25)-(8.63), corrected, on the update of RCAC.
#pragma once

#include <cmath>
#include <memory>

#include "estimation/model.hpp"
#include "estimation/subsystem.hpp"
#include "updates/ud.hpp"

namespace rcac {

// The last `depth` values of a signal, each of `width` numbers; zero before the first.
class Recent {
public:
    Recent(std::size_t depth, std::size_t width)
        : depth_(depth), width_(width), values_(depth * width, 0.0) {}
    double* next() {
        head_ = (head_ + 1) % static_cast<std::int64_t>(depth_);
        return values_.data() + static_cast<std::size_t>(head_) * width_;
    }
    // The value of `age` steps ago; 0 is the last one that was put in.
    const double* operator()(std::size_t age) const {
        return values_.data() + (static_cast<std::size_t>(head_) + depth_ - age) % depth_ * width_;
    }
    void visit(Archive& archive) {
        archive(head_, 0, static_cast<std::int64_t>(depth_) - 1);
        archive(values_);
    }

private:
    std::size_t depth_, width_;
    std::int64_t head_ = 0;
    std::vector<double> values_;
};

struct RefinementPlan {
    std::size_t n, l_w, l_u, l_y;
    std::vector<double> A, D_1, B, C;
    std::vector<std::size_t> delays;  // i of the u^(k - i) in U~
    std::vector<std::size_t> stack;   // k_j
    std::vector<double> H;            // H~, (s l_y) x (m l_u)
    std::vector<double> R;            // (s l_y) x (s l_y), definite
    // H~' R H~ = V diag(lambda) V'; W = V' H~' R. Directions with lambda = 0 are left out.
    std::vector<double> lambda, V_d, W;
    std::size_t chosen;               // place of d in `delays`
    double eta_bar, forgetting;
    bool direct;                      // least squares of the retrospective performance itself
    bool change;                      // U~* nearest to U~, else U~* smallest (8.56)
    std::int64_t k_update;
};

class ModelRefinement {
public:
    ModelRefinement(RefinementPlan plan, std::unique_ptr<Subsystem> subsystem,
                    std::vector<double> P_0, std::vector<double> theta_0, std::vector<double> x_0)
        : plan_(std::move(plan)),
          subsystem_(std::move(subsystem)),
          update_(P_0.data(), theta_0.size()),
          theta_(std::move(theta_0)),
          x_(std::move(x_0)),
          Phi_(depth(plan_.delays), plan_.l_u * theta_.size()),
          u_(depth(plan_.delays), plan_.l_u),
          z_(1 + *std::max_element(plan_.stack.begin(), plan_.stack.end()), plan_.l_y),
          Z_(plan_.stack.size() * plan_.l_y),
          U_(plan_.delays.size() * plan_.l_u),
          next_(plan_.n) {
        const std::size_t rows = plan_.direct ? Z_.size() : plan_.l_u;
        psi_.assign(rows * theta_.size(), 0.0);
        target_.assign(rows, 0.0);
        R_u_.assign(rows * rows, 0.0);
        identity_.assign(rows * rows, 0.0);
        for (std::size_t i = 0; i < rows; ++i) identity_[i * rows + i] = 1.0;
    }

    // z(k), theta(k), u^(k) and the model's step to k + 1. Where `x` is given the model starts this
    // step from it, that is, it is a one-step predictor.
    void step(const double* w, const double* y, const double* x) {
        measure(y, x);
        advance(w);
    }
    // Its two halves, for a w(k) that depends on theta(k).
    void measure(const double* y, const double* x) {
        double* z = z_.next();
        for (std::size_t i = 0; i < plan_.l_y; ++i) {
            z[i] = -y[i];
            for (std::size_t j = 0; j < plan_.n; ++j) z[i] += plan_.C[i * plan_.n + j] * x_[j];
        }
        if (x) std::copy_n(x, plan_.n, x_.begin());
        if (k_ >= plan_.k_update && !frozen) adapt();
    }
    void advance(const double* w) {
        double* Phi = Phi_.next();
        subsystem_->regressor(x_.data(), w, Phi);
        double* u = u_.next();
        for (std::size_t i = 0; i < plan_.l_u; ++i) {
            u[i] = 0.0;
            for (std::size_t j = 0; j < theta_.size(); ++j) u[i] += Phi[i * theta_.size() + j] * theta_[j];
        }
        for (std::size_t i = 0; i < plan_.n; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < plan_.n; ++j) sum += plan_.A[i * plan_.n + j] * x_[j];
            for (std::size_t j = 0; j < plan_.l_w; ++j) sum += plan_.D_1[i * plan_.l_w + j] * w[j];
            for (std::size_t j = 0; j < plan_.l_u; ++j) sum += plan_.B[i * plan_.l_u + j] * u[j];
            next_[i] = sum;
        }
        x_ = next_;
        ++k_;
        if (!finite(x_.data(), x_.size()) || !finite(theta_.data(), theta_.size()))
            throw EstimationError{"range", "the refined model left the range of float64"};
    }

    void visit(Archive& archive) {
        archive(k_, 0, Archive::longest);
        archive(frozen);
        archive(x_);
        archive(theta_);
        update_.visit(archive);
        subsystem_->visit(archive);
        Phi_.visit(archive);
        u_.visit(archive);
        z_.visit(archive);
    }

    const RefinementPlan& plan() const { return plan_; }
    const std::vector<double>& theta() const { return theta_; }
    const std::vector<double>& x() const { return x_; }
    const double* z() const { return z_(0); }
    const double* u() const { return u_(0); }
    const UdUpdate& update() const { return update_; }
    std::int64_t k() const { return k_; }
    bool frozen = false;

private:
    static std::size_t depth(const std::vector<std::size_t>& delays) {
        return 1 + *std::max_element(delays.begin(), delays.end());
    }

    // Before u^(k) is there, the last one put in is u^(k - 1): it has age 0.
    void adapt() {
        const std::size_t l_y = plan_.l_y, l_u = plan_.l_u, columns = U_.size();
        double eta = 0.0;
        for (std::size_t i = 0; i < l_y; ++i) eta += z_(0)[i] * z_(0)[i];
        eta *= plan_.eta_bar;
        for (std::size_t j = 0; j < plan_.stack.size(); ++j)
            std::copy_n(z_(plan_.stack[j]), l_y, Z_.begin() + static_cast<std::ptrdiff_t>(j * l_y));
        for (std::size_t i = 0; i < plan_.delays.size(); ++i)
            std::copy_n(u_(plan_.delays[i] - 1), l_u, U_.begin() + static_cast<std::ptrdiff_t>(i * l_u));
        if (plan_.direct || !plan_.change)
            for (std::size_t i = 0; i < Z_.size(); ++i)
                for (std::size_t j = 0; j < columns; ++j) Z_[i] -= plan_.H[i * columns + j] * U_[j];
        Data data{l_u, theta_.size(), nullptr, target_.data(), identity_.data(), R_u_.data(),
                  plan_.forgetting};
        if (plan_.direct) {
            std::fill(psi_.begin(), psi_.end(), 0.0);
            for (std::size_t m = 0; m < plan_.delays.size(); ++m) {
                const double* Phi = Phi_(plan_.delays[m] - 1);
                for (std::size_t i = 0; i < Z_.size(); ++i)
                    for (std::size_t q = 0; q < l_u; ++q) {
                        const double weight = plan_.H[i * columns + m * l_u + q];
                        if (weight == 0.0) continue;
                        for (std::size_t j = 0; j < theta_.size(); ++j)
                            psi_[i * theta_.size() + j] += weight * Phi[q * theta_.size() + j];
                    }
            }
            target_ = Z_;
            data.l_z = Z_.size();
            data.Phi_f = psi_.data();
            data.target = target_.data();
            data.R_z = plan_.R.data();
        } else {
            const double* before = u_(plan_.delays[plan_.chosen] - 1);
            for (std::size_t q = 0; q < l_u; ++q) target_[q] = plan_.change ? -before[q] : 0.0;
            for (std::size_t i = 0; i < plan_.lambda.size(); ++i) {
                double sum = 0.0;
                for (std::size_t j = 0; j < Z_.size(); ++j) sum += plan_.W[i * Z_.size() + j] * Z_[j];
                sum /= plan_.lambda[i] + eta;
                for (std::size_t q = 0; q < l_u; ++q)
                    target_[q] += plan_.V_d[q * plan_.lambda.size() + i] * sum;
            }
            data.Phi_f = Phi_(plan_.delays[plan_.chosen] - 1);
        }
        if (!update_(data, k_, theta_.data()))
            throw EstimationError{"range", "the update of theta left the range of float64"};
    }

    RefinementPlan plan_;
    std::unique_ptr<Subsystem> subsystem_;
    UdUpdate update_;
    std::vector<double> theta_, x_;
    Recent Phi_, u_, z_;
    std::vector<double> Z_, U_, next_, psi_, target_, R_u_, identity_;
    std::int64_t k_ = 0;
};

}  // namespace rcac
