// The rows of the retrospective cost (2.41) that one step gives the update.
#pragma once

#include <stdexcept>

#include "controller/adaptation_rules.hpp"
#include "controller/plan.hpp"
#include "controller/regressor.hpp"
#include "updates/update.hpp"

namespace rcac {

// l_z rows Phi_f theta + (z - u_f) with R_z and R_u; where control is penalised without the filter
// too, l_u rows S Phi(k) theta + 0 of weight one below them, S' S = R_u_unfiltered. For every update
// these are rows like the others.
class CostRows {
public:
    CostRows(const ControllerPlan& plan, std::size_t l_z, std::size_t l_theta)
        : plan_(&plan),
          l_z_(l_z),
          l_u_(plan.structure.l_u),
          l_theta_(l_theta),
          Phi_((l_z + l_u_) * l_theta),
          target_(l_z + l_u_),
          R_z_(plan.R_z),
          R_u_(plan.R_u),
          S_(plan.penalty),
          normalizes_(plan.normalization.function != Normalization::none) {
        find_penalty();
    }

    double* Phi_f() { return Phi_.data(); }
    std::size_t size_of_Phi_f() const { return l_z_ * l_theta_; }

    // z - u_f, and z through the function that stands between it and the cost.
    void set_target(std::size_t row, double z) {
        target_[row] = normalizes_ ? plan_->normalization(z) : z;
    }
    double* target() { return target_.data(); }

    // The rows of control of so many steps ago.
    void penalise(Regressor& regressor, std::size_t age) {
        const double* phi = regressor.at_age(age);
        double* row = Phi_.data() + l_z_ * l_theta_;
        for (std::size_t a = 0; a < l_u_; ++a)
            for (std::size_t j = 0; j < regressor.size(); ++j)
                for (std::size_t i = 0; i < l_u_; ++i) *row++ = S_.value()[a * l_u_ + i] * phi[j];
    }

    // R_z and R_u of `age` steps ago, where they are not constant.
    void weigh(const double* z, const History& signals, std::int64_t step, std::size_t age) {
        if (R_z_.is_constant() && R_u_.is_constant()) return;
        u_.resize(l_u_);
        for (std::size_t i = 0; i < l_u_; ++i)
            u_[i] = signals(i, age + (plan_->filter_form ? 1 : 0));
        y_.resize(plan_->structure.l_y);
        for (std::size_t i = 0; i < y_.size(); ++i) y_[i] = signals(l_u_ + i, age);
        const double* y = y_.empty() ? z : y_.data();
        const std::int64_t k = step - static_cast<std::int64_t>(age);
        R_z_.evaluate(k, y, z, u_.data(), l_z_);
        R_u_.evaluate(k, y, z, u_.data(), l_z_);
    }

    Data data(double lambda) {
        if (!penalises_)
            return {l_z_, l_theta_, Phi_.data(), target_.data(), R_z_.value(), R_u_.value(), lambda};
        const std::size_t m = l_z_ + l_u_;
        both_z_.assign(m * m, 0.0);
        both_u_.assign(m * m, 0.0);
        for (std::size_t i = 0; i < l_z_; ++i)
            for (std::size_t j = 0; j < l_z_; ++j) {
                both_z_[i * m + j] = R_z_.value()[i * l_z_ + j];
                both_u_[i * m + j] = R_u_.value()[i * l_z_ + j];
            }
        for (std::size_t i = l_z_; i < m; ++i) both_z_[i * m + i] = 1.0;
        return {m, l_theta_, Phi_.data(), target_.data(), both_z_.data(), both_u_.data(), lambda};
    }

    void set_R_z(const Weight& weight) { R_z_.set(weight); }
    void set_R_u(const Weight& weight) { R_u_.set(weight); }
    // Refuses, before anything is changed, rows that the update has no room for.
    void set_penalty(const Weight& S) {
        const CurrentWeight before = S_;
        S_.set(S);
        try {
            find_penalty();
        } catch (...) {
            S_ = before;
            throw;
        }
    }
    bool penalises() const { return penalises_; }
    bool has_left_its_plan() const { return R_z_.is_own() || R_u_.is_own() || S_.is_own(); }

    void visit(Archive& archive) {
        R_z_.visit(archive);
        R_u_.visit(archive);
        S_.visit(archive);
        find_penalty();
    }

private:
    // A window keeps its rows: their number does not fall while a penalty is planned.
    void find_penalty() {
        penalises_ = false;
        for (const double s : plan_->penalty.base) penalises_ = penalises_ || s != 0.0;
        bool is_new = false;
        for (std::size_t i = 0; i < l_u_ * l_u_; ++i) is_new = is_new || S_.value()[i] != 0.0;
        if (is_new && !penalises_ && plan_->keeps_rows)
            throw std::invalid_argument("this update has no room for the rows of a penalty");
        penalises_ = penalises_ || is_new;
    }

    const ControllerPlan* plan_;
    std::size_t l_z_, l_u_, l_theta_;
    std::vector<double> Phi_, target_, u_, y_, both_z_, both_u_;
    CurrentWeight R_z_, R_u_, S_;
    bool normalizes_, penalises_ = false;
};

}  // namespace rcac
