// Many runs over several threads.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "loop/closed_loop.hpp"
#include "loop/time_budget.hpp"

namespace rcac {

// A loop, its exogenous input, where it writes, and how far it has come.
struct Job {
    Loop* loop;
    const double* w;
    std::size_t l_w;
    Record record;
    std::int64_t steps;  // it goes up to there
    std::int64_t done = 0;
    Outcome outcome = Outcome::completed;

    bool finished() const { return done >= steps || outcome != Outcome::completed; }

    // Until it has ended or the time is up, and at least one step. A function of the user that
    // throws leaves its step half done, so the run cannot go on.
    void run(const TimeBudget& budget) {
        Watch watch(budget);
        try {
            while (done < steps && step()) {
                ++done;
                if (watch.time_is_up()) return;
            }
        } catch (...) {
            outcome = Outcome::plant_failed;
            throw;
        }
    }

private:
    // One step; false where it failed, and then its rows are not valid.
    bool step() {
        const double* row = w + done * static_cast<std::int64_t>(l_w);
        outcome = loop->move(done, row, record);
        if (outcome == Outcome::completed) outcome = loop->adapt();
        if (outcome == Outcome::completed) outcome = loop->finish();
        return outcome == Outcome::completed;
    }
};

// Calls work(i) for i = 0, ..., count-1 on so many threads; the first exception is passed on.
template <class Work>
void in_threads(std::size_t count, std::size_t threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex guard;
    const auto loop = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < count;) try {
                work(i);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(guard);
                if (!failure) failure = std::current_exception();
                next = count;
            }
    };
    std::vector<std::thread> helpers;
    try {
        for (std::size_t t = 1; t < std::min(threads, count); ++t) helpers.emplace_back(loop);
    } catch (const std::system_error&) {
        // The system gives no more threads; those that there are do the work.
    }
    loop();
    for (std::thread& helper : helpers) helper.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace rcac
