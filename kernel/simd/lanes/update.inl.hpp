// The update of eight loops in lock step, with what updates/whitened_rows.hpp and updates/ud.hpp do
// for one.
#pragma once

#include "simd/lanes/arrays.hpp"
#include "simd/lanes/vectors.hpp"
#include "simd/lanes/ud.inl.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

RCAC_INLINE double* newest(const LaneHistory& h) { return h.values + h.now * lanes; }

// One measurement, the regressor in a.row unless `taps` says where to read it. theta moves from
// `from` to `to`. `size` and the innovation are taken while the row passes.
RCAC_INLINE unsigned lane_measurement(LaneArrays& a, const double* values, const std::size_t* taps,
                                      Lanes rhs, Lanes r, const double* from, double* to,
                                      double* alpha_out, bool last, Lanes& screen) {
    const std::size_t n = a.factors.n;
    Lanes size = zeros(), spread = zeros(), odd = zeros();
    for (std::size_t j = 0; j < n; ++j) {
        const Lanes phi = lanes_of(taps ? values + taps[j] : a.row + j * lanes);
        if (taps) keep(a.row + j * lanes, phi);
        size = larger_size(phi, size);
        spread = larger_of(lanes_of(a.factors.D + j * lanes), spread);
        const Lanes term = phi * lanes_of(from + j * lanes);
        if (j % 2)
            odd = odd + term;
        else
            rhs = rhs + term;
    }
    alignas(64) double noise[lanes], variance[lanes];
    for (std::size_t i = 0; i < lanes / width; ++i)
        size.part[i] = size.part[i] * all(1024.0 * lanes_epsilon);
    const Lanes squared = size * size, excess = spread * squared - r;
    keep(noise, squared);
    keep(variance, r);
    bool guarded = false;
    for (std::size_t i = 0; i < lanes / width; ++i)
        if (largest_of(larger(excess.part[i], zero())) > 0.0) guarded = true;  // NaN is another's
    const unsigned lost =
        lanes_columns(a.factors, a.row, variance, a.gain, noise, guarded, alpha_out);
    const Lanes alpha = lanes_of(alpha_out), step = (rhs + odd) / alpha;
    const bool forgets = last && a.forgets;
    const Lanes inverse = lanes_of(a.inverse_lambda);
    Lanes sum = alpha * zeros(), more = zeros();
    for (std::size_t j = 0; j < n; ++j) {
        const Lanes moved = lanes_of(from + j * lanes) - lanes_of(a.gain + j * lanes) * step;
        keep(to + j * lanes, moved);
        sum = sum + moved * moved;
        Lanes d = lanes_of(a.factors.D + j * lanes);
        if (forgets) {
            d = d * inverse;
            keep(a.factors.D + j * lanes, d);
        }
        more = more + d * zeros();
    }
    screen = screen + (sum + more);
    return lost;
}

RCAC_INLINE void lane_update(LaneArrays& a, const double* z, Lanes& screen) {
    const double* values = newest(a.outputs);
    const std::size_t n = a.factors.n, stretch = a.outputs.stretch * lanes;
    for (std::size_t r = 0; r < a.l_z; ++r) {
        Lanes target = lanes_of(z + r * lanes);
        for (std::size_t i = 0; i < a.l_u; ++i)  // channel i is u_i
            target = target - lanes_of(values + ((i * a.l_z + r) * a.l_u + i) * stretch);
        keep(a.target + r * lanes, target);
    }
    if (a.l_z == 1) {
        Lanes r = lanes_of(a.r), share = lanes_of(a.share);
        if (a.weight_moves) {
            const Lanes power = lanes_of(z) * lanes_of(z),
                        W = lanes_of(a.W) + lanes_of(a.W_moves) * power;
            share = (lanes_of(a.R_z) + lanes_of(a.R_z_moves) * power) / W;
            r = lanes_of(a.lambda) / W;
        }
        a.lost[0] = lane_measurement(a, values, a.filtered, share * lanes_of(a.target), r, a.theta,
                                     a.theta_next, a.alpha, true, screen);
    } else {
        for (std::size_t r = 0; r < a.l_z; ++r) {
            for (std::size_t j = 0; j < n; ++j) {
                Lanes sum = zeros();
                for (std::size_t i = r; i < a.l_z; ++i)
                    sum = sum + lanes_of(a.root + (i * a.l_z + r) * lanes) *
                                    lanes_of(values + a.filtered[i * n + j]);
                keep(a.row + j * lanes, sum);
            }
            Lanes rhs = zeros();
            for (std::size_t i = 0; i < a.l_z; ++i)
                rhs = rhs + lanes_of(a.whitened + (r * a.l_z + i) * lanes) *
                                lanes_of(a.target + i * lanes);
            a.lost[r] = lane_measurement(a, nullptr, nullptr, rhs, lanes_of(a.lambda),
                                         r == 0 ? a.theta : a.theta_next, a.theta_next,
                                         a.alpha + r * lanes, r + 1 == a.l_z, screen);
        }
    }
    double* const before = a.theta;
    a.theta = a.theta_next;
    a.theta_next = before;
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
