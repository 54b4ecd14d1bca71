// What a controller has seen and done, and the control law on it.
#pragma once

#include "controller/plan.hpp"

namespace rcac {

// The past of u, y, r and the derived signals, and phi(k) as taps on it. Refers to `structure`.
class Regressor {
public:
    // Holds the signals for so many steps more than the regressor and the filter read them.
    explicit Regressor(const Structure& structure, std::size_t more_steps = 0)
        : structure_(structure),
          reach_(std::max<std::size_t>({longest_delay(structure.regressor),
                                        longest_delay(structure.channels), 1})),
          signals_(structure.signals(), reach_ + more_steps) {
        std::vector<std::size_t> places;
        for (const Tap& tap : structure.regressor)
            places.push_back(signals_.offset(tap.source, tap.delay));
        taps_ = TapReader(std::move(places));
        phi_.resize(taps_.size());
    }

    void measure(const double* y, const double* r) {
        const std::size_t first = structure_.l_u, l_y = structure_.l_y, l_r = structure_.l_r;
        for (std::size_t i = 0; i < l_y; ++i) signals_.now(first + i) = y[i];
        for (std::size_t i = 0; i < l_r; ++i) signals_.now(first + l_y + i) = r[i];
        std::size_t number = first + l_y + l_r;
        for (const DerivedSignal& signal : structure_.derived) {
            double value = signal.pole * signals_.before(number);
            for (std::size_t i = 0; i < l_y + l_r; ++i)
                value += signal.now[i] * signals_.now(first + i) +
                         signal.before[i] * signals_.before(first + i);
            signals_.now(number++) = std::clamp(value, -signal.limit, signal.limit);
        }
    }

    // Adds Phi(k) theta to u, (2.29).
    void control(const std::vector<double>& theta, std::vector<double>& u) {
        taps_.read(signals_.values(), phi_.data());
        if (u.size() == 1)
            u[0] = product(theta.data());
        else
            for (std::size_t j = 0; j < phi_.size(); ++j)
                for (std::size_t i = 0; i < u.size(); ++i) u[i] += theta[j * u.size() + i] * phi_[j];
    }

    // phi(k) of so many steps ago.
    const double* at_age(std::size_t age) {
        past_phi_.resize(taps_.size());
        taps_.read(signals_.values() + age, past_phi_.data());
        return past_phi_.data();
    }

    std::size_t size() const { return taps_.size(); }
    std::size_t reach() const { return reach_; }  // the longest delay that is read
    History& signals() { return signals_; }
    const History& signals() const { return signals_; }

private:
    // phi(k)' theta, in four sums, because one would wait for each addition before the next.
    double product(const double* theta) const {
        const double* phi = phi_.data();
        double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
        std::size_t j = 0;
        for (; j + 4 <= phi_.size(); j += 4) {
            a += theta[j] * phi[j];
            b += theta[j + 1] * phi[j + 1];
            c += theta[j + 2] * phi[j + 2];
            d += theta[j + 3] * phi[j + 3];
        }
        for (; j < phi_.size(); ++j) a += theta[j] * phi[j];
        return (a + b) + (c + d);
    }

    const Structure& structure_;
    std::size_t reach_;
    History signals_;
    TapReader taps_;
    std::vector<double> phi_, past_phi_;
};

}  // namespace rcac
