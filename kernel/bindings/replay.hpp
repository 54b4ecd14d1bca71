// Recorded measurements given to an update again, without a loop around it.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "updates/covariance.hpp"
#include "lanes/ud_lanes.hpp"
#include "updates/subspace.hpp"

namespace rcac {

inline std::unique_ptr<Update> make_update(const std::string& name, const double* P0,
                                           std::size_t l_theta,
                                           const InstructionSet& instructions) {
    if (name == "ud") return std::make_unique<UdUpdate>(P0, l_theta, instructions);
    if (name == "ud, subspace") return std::make_unique<SubspaceUpdate>(P0, l_theta);
    if (name == "covariance") return std::make_unique<CovarianceUpdate>(P0, l_theta);
    throw std::invalid_argument("no update named " + name);
}

// `steps` measurements one after another, the whole record `repeat` times; `first` holds the data
// of step 0. False, and no further step, where the update left the range of float64.
inline bool replay(Update& update, Data first, std::size_t steps, std::size_t repeat,
                   double* theta) {
    std::int64_t step = 0;
    for (std::size_t pass = 0; pass < repeat; ++pass)
        for (std::size_t k = 0; k < steps; ++k, ++step) {
            Data data = first;
            data.Phi_f += k * first.l_z * first.l_theta;
            data.target += k * first.l_z;
            if (!update(data, step, theta)) return false;
        }
    return true;
}

// The same on lanes, with R_z = 1 and R_u = 0: Phi_f is steps x l_theta x lanes, target
// steps x lanes, theta l_theta x lanes. Counts in `lost` how often each lane's guard spoke.
inline bool replay_lanes(UdLanes& runs, const double* Phi_f, const double* target, double lambda,
                         std::size_t steps, std::size_t repeat, double* theta,
                         std::int64_t* lost) {
    const std::size_t size = runs.l_theta() * lanes;
    double r[lanes];
    std::fill(r, r + lanes, lambda);
    for (std::size_t pass = 0; pass < repeat; ++pass)
        for (std::size_t k = 0; k < steps; ++k) {
            const unsigned bits = runs.measure(Phi_f + k * size, target + k * lanes, r, theta);
            for (std::size_t lane = 0; bits != 0 && lane < lanes; ++lane)
                lost[lane] += bits >> lane & 1u;
            if (lambda != 1.0)
                for (std::size_t lane = 0; lane < lanes; ++lane) runs.forget(lane, lambda);
            if (!finite(runs.alpha(), lanes)) return false;
        }
    return finite(theta, size);
}

}  // namespace rcac
