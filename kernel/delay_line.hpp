// The recent past of several scalar signals.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <vector>

namespace rcac {

// One entry of a regressor: signal `source`, `delay` steps back.
struct Tap {
    std::size_t source;
    std::size_t delay;
};

// Ring buffer; before the first step every signal is zero.
class DelayLine {
public:
    DelayLine(std::size_t signals, std::size_t max_delay) : signals_(signals) {
        std::size_t length = 1;
        while (length < max_delay + 1) length *= 2;
        mask_ = length - 1;
        values_.assign(length * signals_, 0.0);
    }

    // Begin a new step; its values are zero until they are set.
    void advance() {
        now_ = (now_ + 1) & mask_;
        for (std::size_t s = 0; s < signals_; ++s) values_[now_ * signals_ + s] = 0.0;
    }

    double& now(std::size_t signal) { return values_[now_ * signals_ + signal]; }

    double operator()(std::size_t signal, std::size_t delay) const {
        return values_[((now_ - delay) & mask_) * signals_ + signal];
    }
    double operator()(Tap tap) const { return (*this)(tap.source, tap.delay); }

private:
    std::size_t signals_;
    std::size_t mask_ = 0;
    std::size_t now_ = 0;
    std::vector<double> values_;
};

inline std::size_t longest_delay(const std::vector<Tap>& taps) {
    std::size_t longest = 0;
    for (const Tap& tap : taps) longest = tap.delay > longest ? tap.delay : longest;
    return longest;
}

}  // namespace rcac
