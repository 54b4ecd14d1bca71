// The recent past of several scalar signals.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "memory/archive.hpp"

namespace rcac {

// For a handful of numbers, where a call of the library's copy costs more than the copy.
inline void copy_few(const double* from, std::size_t count, double* to) {
    for (std::size_t i = 0; i < count; ++i) {
        to[i] = from[i];
#if defined(__GNUC__)
        asm volatile("" ::: "memory");  // else the compiler makes the call itself
#endif
    }
}

// One entry of a regressor: signal `source`, `delay` steps back.
struct Tap {
    std::size_t source;
    std::size_t delay;
};

// Each signal's values lie newest first in one piece of memory, so that neighbouring delays are
// neighbours and a tap is a fixed offset. The pieces are longer than the history, and it slides
// down in them; only when it reaches the start is it moved back up.
class History {
public:
    History(std::size_t signals, std::size_t max_delay)
        : signals_(signals), depth_(max_delay + 1), stretch_(depth_ + std::max<std::size_t>(depth_, 63)),
          now_(stretch_ - depth_), values_(stretch_ * signals) {}

    // Begin a new step; its values are zero until they are set.
    void advance() {
        if (now_ == 0) {
            now_ = stretch_ - depth_ + 1;
            for (std::size_t s = 0; s < signals_; ++s)
                std::copy_n(values_.data() + s * stretch_, depth_ - 1,
                            values_.data() + s * stretch_ + now_);
        }
        --now_;
        for (std::size_t s = 0; s < signals_; ++s) values_[s * stretch_ + now_] = 0.0;
    }

    double& now(std::size_t signal) { return values_[signal * stretch_ + now_]; }
    double& before(std::size_t signal) { return values_[signal * stretch_ + now_ + 1]; }
    double operator()(std::size_t signal, std::size_t delay) const {
        return values_[signal * stretch_ + now_ + delay];
    }
    double& at(std::size_t signal, std::size_t delay) {
        return values_[signal * stretch_ + now_ + delay];
    }
    std::size_t signals() const { return signals_; }
    std::size_t depth() const { return depth_; }
    double operator()(Tap tap) const { return (*this)(tap.source, tap.delay); }

    // For loops over many taps: values()[offset(tap)].
    const double* values() const { return values_.data() + now_; }
    std::size_t offset(std::size_t signal, std::size_t delay) const {
        return signal * stretch_ + delay;
    }
    // The past of one signal, newest first.
    const double* past(std::size_t signal) const { return values() + signal * stretch_; }

    // What has left float64 is forgotten.
    void mend() {
        for (double& value : values_)
            if (!std::isfinite(value)) value = 0.0;
    }

    void visit(Archive& archive) {
        if (archive.reading()) now_ = stretch_ - depth_;
        for (std::size_t s = 0; s < signals_; ++s)
            archive(values_.data() + s * stretch_ + now_, depth_);
    }

private:
    std::size_t signals_, depth_, stretch_, now_;
    std::vector<double> values_;
};

// Reads many taps at once. Where neighbours in the list are neighbours in memory, as in every
// regressor of past values of one signal, they are copied as one piece.
class TapReader {
public:
    TapReader() = default;
    explicit TapReader(std::vector<std::size_t> offsets) : offsets_(std::move(offsets)) {
        for (std::size_t i = 0; i < offsets_.size(); ++i)
            if (i > 0 && offsets_[i] == offsets_[i - 1] + 1)
                ++pieces_.back().second;
            else
                pieces_.emplace_back(offsets_[i], 1);
        in_pieces_ = 4 * pieces_.size() <= offsets_.size();
    }

    std::size_t size() const { return offsets_.size(); }

    void read(const double* values, double* result) const {
        if (in_pieces_) {
            for (const auto& [offset, length] : pieces_)
                result = std::copy_n(values + offset, length, result);
        } else {
            for (std::size_t i = 0; i < offsets_.size(); ++i) result[i] = values[offsets_[i]];
        }
    }

private:
    std::vector<std::size_t> offsets_;
    std::vector<std::pair<std::size_t, std::size_t>> pieces_;
    bool in_pieces_ = false;
};

inline std::size_t longest_delay(const std::vector<Tap>& taps) {
    std::size_t longest = 0;
    for (const Tap& tap : taps) longest = std::max(longest, tap.delay);
    return longest;
}

}  // namespace rcac
