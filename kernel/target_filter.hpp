// The target model G_f = D_f^{-1} N_f (2.38) applied to several scalar channels at once.
#pragma once

#include <algorithm>

#include "delay_line.hpp"

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
    TargetFilter(TargetModel model, std::size_t channels, std::size_t max_tap_delay)
        : model_(std::move(model)),
          block_(model_.l_z * model_.l_u),
          inputs_(channels, model_.order),
          outputs_(channels * block_, std::max(model_.order, max_tap_delay)) {}

    void advance() {
        inputs_.advance();
        outputs_.advance();
    }

    void filter(std::size_t channel, double value) {
        inputs_.now(channel) = value;
        for (std::size_t row = 0; row < model_.l_z; ++row)
            for (std::size_t column = 0; column < model_.l_u; ++column)
                outputs_.now(at(channel, row, column)) = entry(channel, row, column);
    }

    // F(k - delay)[row, column] of a channel.
    double operator()(std::size_t channel, std::size_t delay, std::size_t row,
                      std::size_t column) const {
        return outputs_(at(channel, row, column), delay);
    }

    const TargetModel& model() const { return model_; }

private:
    std::size_t at(std::size_t channel, std::size_t row, std::size_t column) const {
        return channel * block_ + row * model_.l_u + column;
    }

    double entry(std::size_t channel, std::size_t row, std::size_t column) const {
        double sum = 0.0;
        for (std::size_t i = 0; i <= model_.order; ++i)
            sum += model_.numerator[i * block_ + row * model_.l_u + column] * inputs_(channel, i);
        const std::size_t square = model_.l_z * model_.l_z;
        for (std::size_t i = 1; i <= model_.order; ++i)
            for (std::size_t m = 0; m < model_.l_z; ++m)
                sum -= model_.denominator[i * square + row * model_.l_z + m] *
                       outputs_(at(channel, m, column), i);
        return sum;
    }

    TargetModel model_;
    std::size_t block_;
    DelayLine inputs_, outputs_;
};

}  // namespace rcac
