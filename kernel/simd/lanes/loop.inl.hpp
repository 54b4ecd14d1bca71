// The closed loop of loop/closed_loop.hpp for eight runs at once, one to a lane of the vectors.
//
// Nothing is summed across lanes, so every lane does what its run does alone, up to the order of
// sums. Nothing is decided for a single lane either: a failed run goes on computing in its lane,
// and one sum of squares over everything that must stay within the limit tells whether a lane
// needs a closer look; lanes/loop.hpp takes it.
#pragma once

#include "simd/lanes/update.inl.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

RCAC_INLINE void lane_advance_history(LaneHistory& h) {
    if (h.now == 0) {
        h.now = h.stretch - h.depth + 1;
        for (std::size_t s = 0; s < h.signals; ++s) {
            double* values = h.values + s * h.stretch * lanes;
            for (std::size_t d = h.depth - 1; d-- > 0;)
                keep(values + (h.now + d) * lanes, lanes_of(values + d * lanes));
        }
    }
    --h.now;
    for (std::size_t s = 0; s < h.signals; ++s)
        keep(newest(h) + s * h.stretch * lanes, zeros());
}

// `count` entries of a product with [x; u; w]; without u where that is not known yet.
RCAC_INLINE void lane_outputs(const LaneArrays& a, std::size_t first, std::size_t count,
                              const double* u, const double* w, double* out) {
    const double* entry = a.plant + first * (a.n + a.l_u + a.l_w) * lanes;
    for (std::size_t i = 0; i < count; ++i, out += lanes) {
        Lanes of_x = zeros(), rest = zeros();
        for (std::size_t j = 0; j < a.n; ++j, entry += lanes)
            of_x = of_x + lanes_of(entry) * lanes_of(a.x + j * lanes);
        for (std::size_t j = 0; j < a.l_w; ++j)
            rest = rest + lanes_of(entry + (a.l_u + j) * lanes) * lanes_of(w + j * lanes);
        if (u)
            for (std::size_t j = 0; j < a.l_u; ++j)
                rest = rest + lanes_of(entry + j * lanes) * lanes_of(u + j * lanes);
        entry += (a.l_u + a.l_w) * lanes;
        keep(out, of_x + rest);
    }
}

RCAC_INLINE void lane_measure_signals(LaneArrays& a, const double* y, const double* w) {
    double* now = newest(a.signals) + a.l_u * a.signals.stretch * lanes;
    for (std::size_t i = 0; i < a.l_y; ++i, now += a.signals.stretch * lanes)
        keep(now, lanes_of(y + i * lanes));
    for (std::size_t i = 0; i < a.l_r; ++i, now += a.signals.stretch * lanes)
        keep(now, lanes_of(w + (a.r_in_w + i) * lanes));
}

// Four sums, because one would wait for each addition before the next.
RCAC_INLINE void lane_control(LaneArrays& a, double* u) {
    const double* signals = newest(a.signals);
    const std::size_t whole = a.taps / 4 * 4;
    for (std::size_t i = 0; i < a.l_u; ++i) {
        Lanes sum[4] = {zeros(), zeros(), zeros(), zeros()};
        const double* theta = a.theta + i * lanes;
        const std::size_t stride = a.l_u * lanes;
        for (std::size_t j = 0; j < whole; j += 4)
            for (std::size_t c = 0; c < 4; ++c)
                sum[c] = sum[c] + lanes_of(theta + (j + c) * stride) *
                                      lanes_of(signals + a.regressor[j + c]);
        for (std::size_t j = whole; j < a.taps; ++j)
            sum[0] = sum[0] + lanes_of(theta + j * stride) * lanes_of(signals + a.regressor[j]);
        keep(u + i * lanes, (sum[0] + sum[1]) + (sum[2] + sum[3]));
    }
}

RCAC_INLINE void lane_filter(LaneArrays& a) {
    const double* signals = newest(a.signals);
    double *in = newest(a.inputs), *out = newest(a.outputs);
    const std::size_t in_stretch = a.inputs.stretch * lanes,
                      out_stretch = a.outputs.stretch * lanes, length = a.order + 1;
    for (std::size_t c = 0; c < a.channels; ++c, in += in_stretch) {
        keep(in, lanes_of(signals + a.channel[c]));
        for (std::size_t row = 0; row < a.l_z; ++row)
            for (std::size_t column = 0; column < a.l_u; ++column) {
                const double* numerator = a.numerator + (row * a.l_u + column) * length * lanes;
                Lanes sum = zeros();
                for (std::size_t i = length; i-- > 0;)
                    sum = sum + lanes_of(numerator + i * lanes) * lanes_of(in + i * lanes);
                if (a.recursive)
                    for (std::size_t m = 0; m < a.l_z; ++m) {
                        const double* past = out + ((c * a.l_z + m) * a.l_u + column) * out_stretch;
                        const double* d = a.denominator + (row * a.l_z + m) * length * lanes;
                        for (std::size_t i = 1; i < length; ++i)
                            sum = sum - lanes_of(d + i * lanes) * lanes_of(past + i * lanes);
                    }
                keep(out + ((c * a.l_z + row) * a.l_u + column) * out_stretch, sum);
            }
    }
}

RCAC_INLINE Lanes lane_squares(const double* values, std::size_t count, Lanes sum) {
    for (std::size_t i = 0; i < count; ++i) {
        const Lanes value = lanes_of(values + i * lanes);
        sum = sum + value * value;
    }
    return sum;
}

// What every update ends with where theta is kept in an ellipsoid; it is rare that a lane needs more.
inline void lane_bounds(const LaneArrays& a) {
    Lanes sum = zeros(), along = zeros();
    for (std::size_t j = 0; j < a.factors.n; ++j) {
        const Lanes moved = lanes_of(a.theta + j * lanes) - lanes_of(a.near + j * lanes);
        sum = sum + lanes_of(a.reach + j * lanes) * larger_size(moved, zeros());
        along = along + lanes_of(a.normal + j * lanes) * moved;
    }
    alignas(64) double growth[lanes];
    keep(growth, (along + along) + sum * (sum + lanes_of(a.margin)));
    unsigned others = 0;
    for (unsigned i = 0; i < lanes; ++i)
        if (!(growth[i] <= a.slack[i])) others |= 1u << i;
    if (others) a.bound(a.owner, others);
}

// At most `count` steps, fewer where the last one raised the alarm; how many.
inline std::size_t lane_steps(LaneArrays& a, std::size_t count) {
    const double* w = a.w;
    double *u = a.u, *y = a.y, *z = a.z;
    a.alarm = false;
    for (std::size_t k = 0; k < count;) {
        a.theta_before = a.theta;
        lane_advance_history(a.signals);
        lane_advance_history(a.inputs);
        lane_advance_history(a.outputs);
        if (a.y_first) {
            lane_outputs(a, a.n, a.l_y, nullptr, w, y);
            lane_measure_signals(a, y, w);
        }
        for (std::size_t i = 0; i < a.l_u; ++i) keep(u + i * lanes, zeros());
        if (a.until_control > 0)
            --a.until_control;
        else
            lane_control(a, u);
        for (std::size_t i = 0; i < a.l_u; ++i)
            keep(newest(a.signals) + i * a.signals.stretch * lanes, lanes_of(u + i * lanes));
        if (!a.y_first) {
            lane_outputs(a, a.n, a.l_y, u, w, y);
            lane_measure_signals(a, y, w);
        }
        lane_outputs(a, a.n + a.l_y, a.l_z, u, w, z);
        lane_outputs(a, 0, a.n, u, w, a.x_next);
        lane_filter(a);

        Lanes screen = lane_squares(u, a.l_u, zeros());
        screen = lane_squares(y, a.l_y, screen);
        screen = lane_squares(z, a.l_z, screen);
        for (std::size_t j = 0; j < a.n; ++j) {
            const Lanes x = lanes_of(a.x_next + j * lanes);
            keep(a.x + j * lanes, x);
            screen = screen + x * x;
        }
        a.updated = a.until_update == 0;
        unsigned any_lost = 0;
        if (a.updated) {
            lane_update(a, z, screen);
            for (std::size_t r = 0; r < a.l_z; ++r) any_lost |= a.lost[r];
            if (a.reach) lane_bounds(a);
        } else {
            --a.until_update;
            screen = lane_squares(a.theta, a.factors.n, screen);
        }
        ++k;
        alignas(64) double sums[lanes];
        keep(sums, screen);
        int within = 1;
        for (std::size_t i = 0; i < lanes; ++i) within &= sums[i] <= a.threshold[i];
        if (!within || any_lost) {
            a.alarm = true;
            return k;
        }
        w += a.l_w * lanes;
        u += a.l_u * lanes;
        y += a.l_y * lanes;
        z += a.l_z * lanes;
    }
    return count;
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
