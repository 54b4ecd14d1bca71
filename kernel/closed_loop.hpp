// Plant and controller in a loop.
#pragma once

#include "controller.hpp"
#include "plant.hpp"

namespace rcac {

// Where the run is written: arrays of `steps` rows; theta has a row for every `stride` steps,
// row j holding theta(j * stride), the coefficients that made u(j * stride).
struct Record {
    double *u, *y, *z, *theta;
    std::int64_t stride;
};

inline bool within(const double* values, std::size_t count, double limit) {
    for (std::size_t i = 0; i < count; ++i)
        if (!(std::fabs(values[i]) <= limit)) return false;  // also false for a NaN
    return true;
}

// Runs up to `steps` steps and returns how many were completed; fewer only where a signal or a
// coefficient is not finite or exceeds `limit`. The rows of the failed step are not valid.
inline std::int64_t simulate(Controller& controller, Plant& plant, const double* w,
                             std::int64_t steps, double limit, const Record& record) {
    const PlantMatrices& size = plant.matrices();
    const std::size_t l_theta = controller.theta().size();
    const bool y_first = controller.measures_first();
    for (std::int64_t k = 0; k < steps; ++k) {
        const double* w_k = w + k * size.l_w;
        double* u = record.u + k * size.l_u;
        double* y = record.y + k * size.l_y;
        double* z = record.z + k * size.l_z;
        if (k % record.stride == 0)
            std::copy_n(controller.theta().data(), l_theta,
                        record.theta + k / record.stride * l_theta);
        controller.begin();
        std::fill_n(u, size.l_u, 0.0);
        if (y_first) {  // then D_0 = 0 and y does not need u
            plant.y(u, w_k, y);
            controller.measure(y);
            std::copy_n(controller.control(), size.l_u, u);
        } else {
            std::copy_n(controller.control(), size.l_u, u);
            plant.y(u, w_k, y);
            controller.measure(y);
        }
        plant.z(u, w_k, z);
        if (!within(u, size.l_u, limit) || !within(y, size.l_y, limit) ||
            !within(z, size.l_z, limit))
            return k;
        if (!controller.adapt(z)) return k;
        plant.advance(u, w_k);
        if (!within(controller.theta().data(), l_theta, limit) ||
            !within(plant.x().data(), size.n, limit))
            return k;
    }
    return steps;
}

}  // namespace rcac
