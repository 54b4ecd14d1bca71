// z_t(k) = phi(k) theta + e(k) by recursive least squares, phi of past z and of u: ARX and mu-Markov.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "memory/history.hpp"
#include "updates/update.hpp"

namespace rcac {

// The delays of u from `first_u` on, then those of z from `first_z` on; both end at `last`. Of each
// delay there are all signals, those of u before those of z in the numbering.
inline std::vector<Tap> delayed_taps(std::size_t first_u, std::size_t first_z, std::size_t last,
                                     std::size_t inputs = 1, std::size_t outputs = 1) {
    std::vector<Tap> taps;
    for (std::size_t i = first_u; i <= last; ++i)
        for (std::size_t s = 0; s < inputs; ++s) taps.push_back({s, i});
    for (std::size_t i = first_z; i <= last; ++i)
        for (std::size_t s = 0; s < outputs; ++s) taps.push_back({inputs + s, i});
    return taps;
}

// The same update as a controller's, on the equation  phi theta - z = 0  with phi read at `taps` of
// the signals u and z. What is kept beside it says how far to believe theta: the errors of
// prediction, each divided by the root of 1 + phi P phi', over the last steps.
class RecursiveArx {
public:
    static constexpr std::size_t kept_errors = 256;

    // Its z is output `target` of `outputs`; theta begins at theta_0.
    RecursiveArx(std::vector<Tap> taps, double lambda, std::unique_ptr<Update> update,
                 std::vector<double> theta_0, std::size_t inputs = 1, std::size_t outputs = 1,
                 std::size_t target = 0)
        : taps_(std::move(taps)), first_(longest_delay(taps_)), lambda_(lambda), inputs_(inputs),
          outputs_(outputs), target_(target), update_(std::move(update)),
          signals_(inputs + outputs, first_), errors_(1, kept_errors - 1),
          theta_(std::move(theta_0)), phi_(taps_.size()) {}

    std::size_t inputs() const { return inputs_; }
    std::size_t outputs() const { return outputs_; }

    // Rows of u and of z. False where a number left the range of float64; nothing is valid
    // afterwards.
    bool take(const double* u, const double* z, std::size_t steps) {
        for (std::size_t k = 0; k < steps; ++k) {
            signals_.advance();
            for (std::size_t s = 0; s < inputs_; ++s) signals_.now(s) = u[k * inputs_ + s];
            for (std::size_t s = 0; s < outputs_; ++s)
                signals_.now(inputs_ + s) = z[k * outputs_ + s];
            if (count_ >= static_cast<std::int64_t>(first_) && !update(z[k * outputs_ + target_]))
                return false;
            ++count_;
        }
        return true;
    }

    const std::vector<double>& theta() const { return theta_; }
    const Update& update() const { return *update_; }
    std::int64_t count() const { return count_; }
    // Newest first.
    double error(std::size_t age) const { return errors_(0, age); }
    // Of the equation's error, over the steps that are remembered.
    double variance() const { return weight_ > 0.0 ? sum_ / weight_ : 0.0; }
    double weight() const { return weight_; }

    void visit(Archive& archive) {
        archive(theta_);
        archive(sum_);
        archive(weight_);
        archive(count_, 0, Archive::longest);
        signals_.visit(archive);
        errors_.visit(archive);
        update_->visit(archive);
    }

private:
    bool update(double z) {
        for (std::size_t i = 0; i < taps_.size(); ++i) phi_[i] = signals_(taps_[i]);
        const double target = -z, one = 1.0, zero = 0.0, before = z - prediction();
        const Data data{1, theta_.size(), phi_.data(), &target, &one, &zero, lambda_};
        if (!(*update_)(data, count_, theta_.data())) return false;
        // The error after the update is that before it divided by 1 + phi P phi'.
        const double square = std::max(before * (z - prediction()), 0.0);
        errors_.advance();
        errors_.now(0) = std::copysign(std::sqrt(square), before);
        sum_ = lambda_ * sum_ + square;
        weight_ = lambda_ * weight_ + 1.0;
        return std::isfinite(sum_);
    }
    double prediction() const {
        double sum = 0.0;
        for (std::size_t i = 0; i < phi_.size(); ++i) sum += phi_[i] * theta_[i];
        return sum;
    }

    std::vector<Tap> taps_;
    std::size_t first_;  // the first step at which the whole of phi is known
    double lambda_, sum_ = 0.0, weight_ = 0.0;
    std::size_t inputs_, outputs_, target_;
    std::unique_ptr<Update> update_;
    History signals_, errors_;
    std::vector<double> theta_, phi_;
    std::int64_t count_ = 0;
};

}  // namespace rcac
