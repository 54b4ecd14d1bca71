// The target model G_f = D_f^{-1} N_f (2.38) applied to several scalar channels at once.
#pragma once

#include "memory/history.hpp"

namespace rcac {

// Coefficients in powers of q^{-1}, row-major: numerator[i] is l_z x l_u, denominator[i] is
// l_z x l_z with denominator[0] = I.
struct TargetModel {
    std::size_t l_z, l_u, order;
    std::vector<double> numerator, denominator;
};

// G_f is linear and time-invariant, so it commutes with the delays of the regressor: a channel s
// is filtered once, F(k) = G_f(q) s(k) (l_z x l_u), and every filtered tap reads a delayed F.
class TargetFilter {
public:
    TargetFilter(const TargetModel& model, std::size_t channels, std::size_t max_tap_delay)
        : l_z_(model.l_z),
          l_u_(model.l_u),
          order_(model.order),
          channels_(channels),
          inputs_(channels, order_),
          outputs_(channels * l_z_ * l_u_, std::max(order_, max_tap_delay)) {
        replace(model);
    }

    // Another model of this order at most; past inputs and outputs stay.
    void replace(const TargetModel& model) {
        const std::size_t block = l_z_ * l_u_, length = order_ + 1;
        numerator_.assign(block * length, 0.0);
        for (std::size_t i = 0; i <= model.order; ++i)
            for (std::size_t b = 0; b < block; ++b)
                numerator_[b * length + i] = model.numerator[i * block + b];
        recursive_ = false;
        denominator_.assign(l_z_ * l_z_ * length, 0.0);
        std::copy(model.denominator.begin(), model.denominator.end(), denominator_.begin());
        for (std::size_t i = l_z_ * l_z_; i < denominator_.size(); ++i)
            if (denominator_[i] != 0.0) recursive_ = true;
        scalar_ = block == 1;
    }

    void advance() {
        inputs_.advance();
        outputs_.advance();
    }

    double& input(std::size_t channel) { return inputs_.now(channel); }
    void correct_previous_input(std::size_t channel, double value) {
        if (order_ > 0) inputs_.before(channel) = value;  // else nothing remembers it
    }

    // F(k) of every channel from the inputs up to now.
    void run() {
        for (std::size_t c = 0; c < channels_; ++c)
            for (std::size_t row = 0; row < l_z_; ++row)
                for (std::size_t column = 0; column < l_u_; ++column)
                    outputs_.now(index(c, row, column)) =
                        scalar_ ? scalar_entry(c) : entry(c, row, column);
    }

    // The number of F[row, column] of a channel among the filtered signals.
    std::size_t index(std::size_t channel, std::size_t row, std::size_t column) const {
        return (channel * l_z_ + row) * l_u_ + column;
    }
    const History& outputs() const { return outputs_; }
    History& outputs() { return outputs_; }
    History& inputs() { return inputs_; }
    std::size_t l_z() const { return l_z_; }
    std::size_t order() const { return order_; }

    void mend() {
        inputs_.mend();
        outputs_.mend();
    }

    void visit(Archive& archive) {
        inputs_.visit(archive);
        outputs_.visit(archive);
    }

private:
    double scalar_entry(std::size_t channel) const {
        const double *in = inputs_.past(channel), *out = outputs_.past(channel);
        double sum = 0.0;
        for (std::size_t i = 0; i <= order_; ++i) sum += numerator_[i] * in[i];
        if (recursive_)
            for (std::size_t i = 1; i <= order_; ++i) sum -= denominator_[i] * out[i];
        return sum;
    }

    double entry(std::size_t channel, std::size_t row, std::size_t column) const {
        const double *in = inputs_.past(channel),
                     *numerator = numerator_.data() + (row * l_u_ + column) * (order_ + 1);
        double sum = 0.0;
        for (std::size_t i = 0; i <= order_; ++i) sum += numerator[i] * in[i];
        if (recursive_)
            for (std::size_t m = 0; m < l_z_; ++m) {
                const double* out = outputs_.past(index(channel, m, column));
                for (std::size_t i = 1; i <= order_; ++i)
                    sum -= denominator_[(i * l_z_ + row) * l_z_ + m] * out[i];
            }
        return sum;
    }

    std::size_t l_z_, l_u_, order_, channels_;
    bool recursive_ = false, scalar_ = false;
    std::vector<double> numerator_, denominator_;  // numerator_ with the powers innermost
    History inputs_, outputs_;
};

}  // namespace rcac
