// Several independent UD updates in lock step, one to a lane of a vector.
#pragma once

#include "memory/aligned.hpp"
#include "simd/dispatch.hpp"
#include "updates/ud.hpp"

namespace rcac {

// The factors of `lanes` runs with equally many coefficients, interleaved entry by entry. Pays for
// l_theta up to about 40, where a single run cannot fill the processor's vectors.
class UdLanes {
public:
    explicit UdLanes(std::size_t l_theta,
                     const InstructionSet& instructions = rcac::instruction_set())
        : n_(l_theta),
          instructions_(&instructions),
          U_(n_ * (n_ - 1) / 2 * lanes, 0.0),
          D_(n_ * lanes, 1.0),
          gain_(n_ * lanes, 0.0),
          alpha_(lanes, 0.0) {}

    void load(std::size_t lane, const UdUpdate& update) {
        for (std::size_t j = 0; j < n_; ++j) {
            for (std::size_t i = 0; i < j; ++i) u(i, j, lane) = update.u(i, j);
            D_[j * lanes + lane] = update.d(j);
        }
    }
    void store(std::size_t lane, UdUpdate& update) {
        for (std::size_t j = 0; j < n_; ++j) {
            for (std::size_t i = 0; i < j; ++i) update.u(i, j) = u(i, j, lane);
            update.d(j) = D_[j * lanes + lane];
        }
    }

    // One measurement  row theta + rhs = 0  of variance r on every lane; row and theta are
    // [j * lanes + lane], rhs and r [lane]. Bit k of the result: lane k's excitation was lost in
    // rounding. A lane without a measurement gets a zero row and any finite r > 0 and is left
    // exactly as it was. A lane whose numbers left the range of float64 has an infinite or
    // undefined alpha()[lane].
    unsigned measure(const double* row, const double* rhs, const double* r, double* theta) {
        return instructions_->lanes_measure({n_, U_.data(), D_.data()}, row, rhs, r, gain_.data(),
                                            theta, alpha_.data());
    }
    // The factors alone; gain() and alpha() are what theta <- theta - gain innovation / alpha needs.
    unsigned rank_one(const double* row, const double* r) {
        return instructions_->lanes_rank_one({n_, U_.data(), D_.data()}, row, r, gain_.data(),
                                             alpha_.data());
    }
    void forget(std::size_t lane, double lambda) {
        for (std::size_t j = 0; j < n_; ++j) D_[j * lanes + lane] /= lambda;
    }

    // As a lane without a run: P = I.
    void clear(std::size_t lane) {
        for (std::size_t j = 0; j < n_; ++j) {
            for (std::size_t i = 0; i < j; ++i) u(i, j, lane) = 0.0;
            D_[j * lanes + lane] = 1.0;
        }
    }

    UdLaneFactors factors() { return {n_, U_.data(), D_.data()}; }
    std::size_t l_theta() const { return n_; }
    const double* gain() const { return gain_.data(); }
    const double* alpha() const { return alpha_.data(); }

private:
    double& u(std::size_t i, std::size_t j, std::size_t lane) {
        return U_[lane_place(n_, i, j) + lane];
    }

    std::size_t n_;
    const InstructionSet* instructions_;
    AlignedVector U_, D_, gain_, alpha_;
};

}  // namespace rcac
