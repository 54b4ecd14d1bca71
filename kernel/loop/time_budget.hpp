// How long the kernel may work before it answers, and how often it looks at the clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace rcac {

class TimeBudget {
public:
    using Clock = std::chrono::steady_clock;
    explicit TimeBudget(double seconds)
        : end_(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e8)))) {}

    Clock::time_point end() const { return end_; }
    bool is_over() const { return Clock::now() >= end_; }

private:
    Clock::time_point end_;
};

// A look at the clock costs 25 ns and a step from 0.1 us to 10 ms. So many steps pass between two
// looks as take some 20 us, but never so many that steps which become a thousand times as long, as
// where the update begins, could hold up an answer.
class Watch {
public:
    explicit Watch(const TimeBudget& budget)
        : end_(budget.end()), last_(TimeBudget::Clock::now()) {}

    std::int64_t steps_to_next_look() const { return left_; }

    // To be asked after so many steps.
    bool time_is_up(std::int64_t steps = 1) {
        left_ -= steps;
        return left_ <= 0 && look();
    }

private:
    bool look() {
        using namespace std::chrono_literals;
        constexpr TimeBudget::Clock::duration wanted = 20us;
        const TimeBudget::Clock::time_point now = TimeBudget::Clock::now();
        const TimeBudget::Clock::duration spent = now - last_;
        if (2 * spent < wanted)
            every_ = std::min<std::int64_t>(2 * every_, 64);
        else if (spent > 2 * wanted)
            every_ = std::max<std::int64_t>(every_ * wanted.count() / spent.count(), 1);
        left_ = every_;
        last_ = now;
        return now >= end_;
    }

    TimeBudget::Clock::time_point end_, last_;
    std::int64_t every_ = 1, left_ = 1;
};

}  // namespace rcac
