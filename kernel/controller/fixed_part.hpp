// A compensator that does not adapt, in parallel with the one that does.
#pragma once

#include <vector>

#include "memory/history.hpp"

namespace rcac {

// v(k) = P_1 v(k-1) + ... + P_n v(k-n) + Q_0 e(k) + ... + Q_n e(k-n), e = [y; r], row-major.
struct FixedPlan {
    std::size_t order = 0;
    std::vector<double> past_v, past_e;  // empty: there is none
};

class FixedPart {
public:
    FixedPart(const FixedPlan& plan, std::size_t l_v, std::size_t l_e)
        : plan_(plan), l_v_(l_v), l_e_(l_e), signals_(is_there() ? l_v + l_e : 0, plan.order + 1) {}

    bool is_there() const { return !plan_.past_e.empty(); }
    // Whether v(k) waits for e(k).
    bool is_direct() const {
        for (std::size_t i = 0; is_there() && i < l_v_ * l_e_; ++i)
            if (plan_.past_e[i] != 0.0) return true;
        return false;
    }

    void advance() {
        if (is_there()) signals_.advance();
    }
    void measure(std::size_t component, double value) {
        if (is_there()) signals_.now(l_v_ + component) = value;
    }

    // Adds v(k) to u.
    void add_to(double* u) {
        for (std::size_t i = 0; i < l_v_; ++i) {
            double sum = 0.0;
            for (std::size_t lag = 0; lag <= plan_.order; ++lag) {
                for (std::size_t j = 0; lag > 0 && j < l_v_; ++j)
                    sum += plan_.past_v[((lag - 1) * l_v_ + i) * l_v_ + j] * signals_(j, lag);
                for (std::size_t j = 0; j < l_e_; ++j)
                    sum += plan_.past_e[(lag * l_v_ + i) * l_e_ + j] * signals_(l_v_ + j, lag);
            }
            u[i] += sum;
            signals_.now(i) = sum;
        }
    }
    // Another output took its place.
    void replace(std::size_t i, double value) {
        if (is_there()) signals_.now(i) = value;
    }
    void replace_before(std::size_t i, double value) {
        if (is_there()) signals_.before(i) = value;
    }
    void mend() {
        if (is_there()) signals_.mend();
    }
    // v(k) and v(k-1); zero where there is none.
    double now(std::size_t i) { return is_there() ? signals_.now(i) : 0.0; }
    double before(std::size_t i) { return is_there() ? signals_.before(i) : 0.0; }

    void visit(Archive& archive) { signals_.visit(archive); }

private:
    FixedPlan plan_;
    std::size_t l_v_, l_e_;
    History signals_;
};

}  // namespace rcac
