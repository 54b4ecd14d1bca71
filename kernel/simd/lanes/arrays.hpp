// The state of eight closed loops in lock step, as every instruction set sees it.
#pragma once

#include <cstddef>

#include "simd/layout.hpp"

namespace rcac {

// Everything below holds entry i of lane k at [i * lanes + k] and starts at a cache line.

// The past of several signals, newest first; it slides down through its memory as that of
// memory/history.hpp does, by a shorter stretch, because eight of them must share the first cache.
struct LaneHistory {
    double* values;
    std::size_t signals, depth, stretch, now;
};

// What the eight loops share, and where their numbers are. Offsets of taps count doubles from the
// newest value of signal 0.
struct LaneArrays {
    std::size_t n, l_u, l_y, l_z, l_w, l_r, r_in_w, taps, channels, order;
    bool y_first;       // the regressor holds y(k), so the plant is measured before u(k)
    bool recursive;     // the target models have denominators
    bool forgets;       // lambda is not one
    bool weight_moves;  // R = base + z_squared z^2
    std::size_t until_control, until_update;  // steps before k_w and before k_update

    const std::size_t *regressor, *channel;  // offsets in `signals`
    const std::size_t* filtered;             // in `outputs`, l_z x l_theta
    LaneHistory signals, inputs, outputs;    // inputs and outputs are those of the target model

    const double* plant;                   // rows of [A B D_1; C D_0 D_2; E_1 E_2 E_0]
    double *x, *x_next;
    const double *numerator, *denominator;  // powers of q^{-1} innermost

    double *theta, *theta_next;
    const double* theta_before;  // theta(k) of the last step; one of the two above
    UdLaneFactors factors;
    double *row, *gain, *target;
    double* alpha;  // of every measurement

    // l_z = 1: the measurement  phi theta + share (z - u_f) = 0  of variance r = lambda / W with
    // share = R_z / W, W = R_z + R_u: the whitened one divided by the root of W. Where the weight
    // moves, both follow from the base and the factors of z^2.
    const double *r, *share, *lambda, *inverse_lambda;
    const double *R_z, *W, *R_z_moves, *W_moves;
    // l_z > 1: L of W = L L' and L^{-1} R_z, both l_z x l_z; the variance is lambda.
    const double *root, *whitened;

    // Every lane's theta is kept in an ellipsoid, see Ellipsoid::contains: while |v|^2 has grown by at
    // most the slack since `near` it is inside, and `bound` is called for the other lanes, bit k for
    // lane k.
    const double *reach, *near, *normal, *margin, *slack;  // null: none
    void (*bound)(void* owner, unsigned lanes);
    void* owner;

    // Sums of squares below this prove that a lane is within its limit.
    const double* threshold;

    const double* w;      // the exogenous input of the next steps
    double *u, *y, *z;    // their records
    bool updated, alarm;  // of the last step
    unsigned lost[3];     // bit k: lane k's excitation was lost in measurement number i
};

// Longest piece of w and of the records at once.
constexpr std::size_t lane_rows = 16;

}  // namespace rcac
