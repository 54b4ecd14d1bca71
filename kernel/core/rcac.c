/* See rcac.h. The sums run in the order of the kernel's instruction set "plain" and of its
 * controller, so that float64 gives the same bits. */

/* Reordered sums would take from theta what its carry keeps. GCC is told here, Clang below. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-unsafe-math-optimizations", "no-finite-math-only", "fp-contract=off")
#endif
#if defined(__clang__)
#if !defined(__wasm__) /* where Clang knows no such pragma */
#pragma float_control(precise, on)
#endif
#pragma clang fp contract(off)
#elif defined(_MSC_VER)
#pragma float_control(precise, on)
#pragma fp_contract(off)
#endif
#if defined(__FAST_MATH__) && !defined(__clang__) && !defined(__GNUC__)
#error "fast math would destroy the carry of theta; compile this file without it"
#endif

#define RCAC_TABLES
#include "rcac.h"

#if defined(RCAC_FREESTANDING) /* without a library: whoever links has these two */
#include <stddef.h>
void *memcpy(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);
#else
#include <string.h>
#endif

#if RCAC_FLOAT32
typedef uint32_t rcac_bits;
#define RCAC_DIGITS 24
#define RCAC_EXPONENT_BIAS 127
#define RCAC_EPSILON 1.1920929e-7f
#define RCAC_NUMBER(x) x##f
#else
typedef uint64_t rcac_bits;
#define RCAC_DIGITS 53
#define RCAC_EXPONENT_BIAS 1023
#define RCAC_EPSILON 2.220446049250313e-16
#define RCAC_NUMBER(x) x
#endif
/* A build for two widths at once would read past the ends of these. */
typedef char rcac_real_has_its_width[sizeof(rcac_real) == sizeof(rcac_bits) ? 1 : -1];

#define N RCAC_L_THETA

#if RCAC_ADAPTS
static rcac_real magnitude(rcac_real x) { return x < 0 ? -x : x; }
#endif

/* By the bits of the exponent, which no option of a compiler takes for granted. */
static int is_finite(rcac_real x) {
    rcac_bits bits;
    memcpy(&bits, &x, sizeof bits);
    bits >>= RCAC_DIGITS - 1;
    bits &= 2 * RCAC_EXPONENT_BIAS + 1;
    return bits != 2 * RCAC_EXPONENT_BIAS + 1;
}

static int all_finite(const rcac_real *values, int count) {
    int i;
    for (i = 0; i < count; ++i)
        if (!is_finite(values[i])) return 0;
    return 1;
}

#if RCAC_SATURATED || RCAC_BOUNDS || RCAC_DERIVED
static rcac_real held(rcac_real x, rcac_real low, rcac_real high) {
    return x < low ? low : high < x ? high : x;
}
#endif

#if RCAC_NEEDS_ROOT
/* The square root as IEEE 754 rounds it, digit by digit; x >= 0. Define RCAC_SQRT where the processor
 * has the instruction. */
#ifndef RCAC_SQRT
#define RCAC_SQRT root_of
static rcac_real root_of(rcac_real x) {
    rcac_bits bits, m, root = 0, rest = 0;
    int exponent, pair;
    const int half = RCAC_FLOAT32 ? 12 : 27, width = RCAC_FLOAT32 ? 26 : 54;
    if (!(x > 0) || !is_finite(x)) return x;
    memcpy(&bits, &x, sizeof bits);
    exponent = (int)(bits >> (RCAC_DIGITS - 1));
    m = bits & (((rcac_bits)1 << (RCAC_DIGITS - 1)) - 1);
    if (exponent == 0) {
        exponent = 1;
        while (!(m >> (RCAC_DIGITS - 1))) {
            m <<= 1;
            --exponent;
        }
    } else {
        m |= (rcac_bits)1 << (RCAC_DIGITS - 1);
    }
    exponent -= RCAC_EXPONENT_BIAS + RCAC_DIGITS - 1; /* x = m 2^exponent */
#if RCAC_FLOAT32
    m <<= 1;
    --exponent;
#endif
    if (exponent & 1) {
        m <<= 1;
        --exponent;
    }
    for (pair = 0; pair <= RCAC_DIGITS; ++pair) {
        const int at = width - 2 - 2 * pair;
        rest = rest << 2 | (at >= 0 ? m >> at & 3 : 0);
        root <<= 1;
        if (rest >= 2 * root + 1) {
            rest -= 2 * root + 1;
            ++root;
        }
    }
    root = (root + 1) >> 1;
    exponent = exponent / 2 + 1 - half + RCAC_DIGITS - 1 + RCAC_EXPONENT_BIAS;
    bits = ((rcac_bits)exponent << (RCAC_DIGITS - 1)) + (root - ((rcac_bits)1 << (RCAC_DIGITS - 1)));
    memcpy(&x, &bits, sizeof x);
    return x;
}
#endif
#endif

#if RCAC_SUPERVISED
/* ---- what a supervised controller notes */

#define RCAC_INTERVAL 16 /* steps from one look at P to the next */

static void note(rcac_state *s, int kind, int64_t step, rcac_real value) {
    rcac_trouble *t = &s->troubles[kind];
    /* What lasts from one look to the next is one trouble. */
    const int64_t gap = kind == RCAC_WINDUP ? RCAC_INTERVAL : 1;
    if (t->steps == 0 || step > t->last + gap) ++t->episodes;
    if (t->steps++ == 0) t->first = step;
    t->last = step;
    if (!(value <= t->worst)) t->worst = value;
}

/* Whether the actuator applied the u that it was asked for. */
static void see_actuator(rcac_state *s, int applied, int64_t step) {
    s->unapplied = applied ? 0 : s->unapplied + 1;
    s->heard = 1;
    if (s->unapplied >= RCAC_PATIENCE) note(s, RCAC_UNAPPLIED, step, (rcac_real)s->unapplied);
}

static int equals(const rcac_real *a, const rcac_real *b, int count) {
    int i, same = 1;
    for (i = 0; i < count; ++i) same &= a[i] <= b[i] && a[i] >= b[i];
    return same;
}

static void mend(rcac_real *values, int count) {
    int i;
    for (i = 0; i < count; ++i)
        if (!is_finite(values[i])) values[i] = 0;
}

static void reset(rcac_state *s);

/* Numbers left their range: theta of the last good look, P(0), and nothing that is no number. */
static void recover(rcac_state *s) {
    int i;
    note(s, RCAC_OVERFLOW, s->step, 0);
    s->noted |= RCAC_RESTORED;
    for (i = 0; i < N; ++i) s->theta[i] = s->good[i];
#if RCAC_CARRY
    for (i = 0; i < N; ++i) s->carry[i] = 0;
#endif
    reset(s);
    ++s->resets;
    mend(&s->signals[0][0], RCAC_SIGNALS * RCAC_DEPTH);
    mend(&s->inputs[0][0], RCAC_CHANNELS * (RCAC_ORDER + 1));
    mend(&s->outputs[0][0], RCAC_CHANNELS * RCAC_L_Z * RCAC_L_U * RCAC_OUTPUT_DEPTH);
#if RCAC_FIXED
    mend(&s->fixed[0][0], (RCAC_L_U + RCAC_L_E) * (RCAC_FIXED_ORDER + 2));
#endif
#if RCAC_LIVE
    mend(&s->past[0][0], RCAC_SOURCES * RCAC_REMEMBERED);
#endif
}

/* After a step: every 16 of them whether P has wound up; where it has not, theta is kept. */
static void look(rcac_state *s) {
    rcac_real growth = 0;
    int j;
    if (s->step % RCAC_INTERVAL != 0) return;
    for (j = 0; j < N; ++j) {
        const rcac_real grown = s->D[j] * (1 / rcac_D_0[j]);
        if (growth < grown) growth = grown;
    }
    if (growth > s->worst_growth) s->worst_growth = growth;
    s->wound_up = growth > rcac_windup[0];
    if (s->wound_up) {
        note(s, RCAC_WINDUP, s->step - 1, growth);
    } else {
        for (j = 0; j < N; ++j) s->good[j] = s->theta[j];
    }
#if RCAC_ELLIPSOID
    growth = rcac_radius(s);
    if (growth > s->worst_radius) s->worst_radius = growth;
#endif
}

/* What is given of y or r, and what was known last of the rest; 1 where something was missing. */
static int fill(const rcac_state *s, const rcac_real *given, int first, int count, rcac_real *values) {
    int i, missed = 0;
    for (i = 0; i < count; ++i) {
        const int known = given && is_finite(given[i]);
        values[i] = known ? given[i] : s->signals[first + i][1];
        missed |= !known;
    }
    return missed;
}
#endif

/* ---- what is remembered */

static void shift(rcac_real *values, int depth) {
    int i;
    for (i = depth - 1; i > 0; --i) values[i] = values[i - 1];
    values[0] = 0;
}

static void advance(rcac_state *s) {
    int i;
    for (i = 0; i < RCAC_SIGNALS; ++i) shift(s->signals[i], RCAC_DEPTH);
#if RCAC_FIXED
    for (i = 0; i < RCAC_L_U + RCAC_L_E; ++i) shift(s->fixed[i], RCAC_FIXED_ORDER + 2);
#endif
#if RCAC_ADAPTS
    for (i = 0; i < RCAC_CHANNELS; ++i) shift(s->inputs[i], RCAC_ORDER + 1);
    for (i = 0; i < RCAC_CHANNELS * RCAC_L_Z * RCAC_L_U; ++i) shift(s->outputs[i], RCAC_OUTPUT_DEPTH);
#endif
}

/* y(k) and r(k), and the derived signals that they make. */
static void measure(rcac_state *s, const rcac_real *y, const rcac_real *r) {
    int i;
#if RCAC_DERIVED
    int d;
#endif
    for (i = 0; i < RCAC_L_Y; ++i) s->signals[RCAC_L_U + i][0] = y[i];
    for (i = 0; i < RCAC_L_R; ++i) s->signals[RCAC_L_U + RCAC_L_Y + i][0] = r[i];
#if RCAC_DERIVED
    for (d = 0; d < RCAC_DERIVED; ++d) {
        rcac_real *signal = s->signals[RCAC_L_U + RCAC_L_E + d];
        rcac_real value = rcac_pole[d] * signal[1];
        for (i = 0; i < RCAC_L_E; ++i)
            value += rcac_now[d * RCAC_L_E + i] * s->signals[RCAC_L_U + i][0] +
                     rcac_before[d * RCAC_L_E + i] * s->signals[RCAC_L_U + i][1];
        signal[0] = rcac_limit[d] < 0 ? value : held(value, -rcac_limit[d], rcac_limit[d]);
    }
#endif
#if RCAC_FIXED
    for (i = 0; i < RCAC_L_E; ++i) s->fixed[RCAC_L_U + i][0] = s->signals[RCAC_L_U + i][0];
#endif
    (void)y;
    (void)r;
}

static rcac_real phi_of(const rcac_state *s, int j) {
    return s->signals[rcac_regressor[2 * j]][rcac_regressor[2 * j + 1]];
}

/* u(k) = Phi(k) theta(k), (2.29). */
static void adaptive_control(const rcac_state *s, rcac_real *u) {
    int j;
#if RCAC_L_U == 1
    /* In four sums, as the kernel does it, whose processor would wait for each addition. */
    rcac_real sum[4] = {0, 0, 0, 0};
    for (j = 0; j < RCAC_TAPS; ++j)
        sum[j < RCAC_TAPS / 4 * 4 ? j % 4 : 0] += s->theta[j] * phi_of(s, j);
    u[0] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
#else
    int i;
    for (j = 0; j < RCAC_TAPS; ++j)
        for (i = 0; i < RCAC_L_U; ++i) u[i] += s->theta[j * RCAC_L_U + i] * phi_of(s, j);
#endif
}

#if RCAC_FIXED
static void fixed_control(rcac_state *s, rcac_real *u) {
    int i, j, lag;
    for (i = 0; i < RCAC_L_U; ++i) {
        rcac_real sum = 0;
        for (lag = 0; lag <= RCAC_FIXED_ORDER; ++lag) {
            for (j = 0; lag > 0 && j < RCAC_L_U; ++j)
                sum += rcac_past_v[((lag - 1) * RCAC_L_U + i) * RCAC_L_U + j] * s->fixed[j][lag];
            for (j = 0; j < RCAC_L_E; ++j)
                sum += rcac_past_e[(lag * RCAC_L_U + i) * RCAC_L_E + j] * s->fixed[RCAC_L_U + j][lag];
        }
#if !RCAC_SUPERVISED
        if (!is_finite(sum)) {
            s->broken = 1;
            sum = 0;
        }
#endif
        u[i] += sum;
        s->fixed[i][0] = sum;
    }
}
#endif

static void apply(rcac_state *s, const rcac_real *u);

/* u(k); where it is `missed`, that of the step before. */
static void control(rcac_state *s, int missed) {
    rcac_real u[RCAC_L_U];
#if RCAC_SUPERVISED && RCAC_SATURATED
    rcac_real asked[RCAC_L_U];
#endif
    int i;
    for (i = 0; i < RCAC_L_U; ++i) u[i] = 0;
    if (s->step >= RCAC_K_W && !s->broken) adaptive_control(s, u);
#if !RCAC_SUPERVISED
    if (!all_finite(u, RCAC_L_U)) {
        s->broken = 1;
        for (i = 0; i < RCAC_L_U; ++i) u[i] = 0;
    }
#endif
    for (i = 0; i < RCAC_L_U; ++i) s->signals[i][0] = u[i];
#if RCAC_FIXED
    fixed_control(s, u);
#if !RCAC_SUPERVISED
    for (i = 0; i < RCAC_L_U; ++i)
        if (!is_finite(u[i])) {
            s->broken = 1;
            u[i] = 0;
        }
#endif
#endif
#if RCAC_SATURATED
#if RCAC_SUPERVISED
    for (i = 0; i < RCAC_L_U; ++i) asked[i] = u[i];
#endif
    for (i = 0; i < RCAC_L_U; ++i) {
        rcac_real moved = u[i];
        if (!(rcac_rate[i] < 0)) moved = held(moved, s->applied[i] - rcac_rate[i], s->applied[i] + rcac_rate[i]);
        s->applied[i] = u[i] = held(moved, rcac_low[i], rcac_high[i]);
    }
#endif
#if RCAC_SUPERVISED
    if (missed) {
        for (i = 0; i < RCAC_L_U; ++i) u[i] = s->held[i];
        apply(s, u);
    }
    if (!all_finite(u, RCAC_L_U)) {
        recover(s);
        for (i = 0; i < RCAC_L_U; ++i) u[i] = s->u[i];
        apply(s, u);
        missed = 1;
    }
#if RCAC_SATURATED
    see_actuator(s, missed || equals(u, asked, RCAC_L_U), s->step);
    apply(s, u);
#else
    for (i = 0; i < RCAC_L_U; ++i) s->held[i] = u[i];
#endif
#elif RCAC_SATURATED
    apply(s, u);
#endif
    for (i = 0; i < RCAC_L_U; ++i) s->u[i] = u[i];
    (void)missed;
}

/* What the actuator made of u(k), without the fixed part. */
static void apply(rcac_state *s, const rcac_real *u) {
    int i;
    for (i = 0; i < RCAC_L_U; ++i) {
#if RCAC_FIXED
        s->signals[i][0] = u[i] - s->fixed[i][0];
#else
        s->signals[i][0] = u[i];
#endif
#if RCAC_SATURATED
        s->applied[i] = u[i];
#endif
#if RCAC_SUPERVISED
        s->held[i] = u[i];
#endif
    }
}

#if RCAC_ADAPTS

/* ---- P = U D U' */

static rcac_real *column(rcac_state *s, int j) { return s->U + j * (j - 1) / 2 * (j > 0); }

static void reset(rcac_state *s) {
    int i;
#if RCAC_DENSE_P_0
    for (i = 0; i < RCAC_UPPER; ++i) s->U[i] = rcac_U_0[i];
#else
    for (i = 0; i < RCAC_UPPER; ++i) s->U[i] = 0;
#endif
    for (i = 0; i < N; ++i) s->D[i] = rcac_D_0[i];
}

/* Whether f is no larger than the rounding errors of its terms while d_j is so large that an f of that
 * size would decide the update: the data do not say whether this direction is excited. */
static int lost_in_rounding(const rcac_real *row, const rcac_real *U, int j, rcac_real f,
                            rcac_real d, rcac_real alpha) {
    rcac_real size = magnitude(row[j]), error;
    int i;
    for (i = 0; i < j; ++i) size += magnitude(U[i] * row[i]);
    error = RCAC_NUMBER(16.0) * RCAC_EPSILON * size;
    return magnitude(f) <= error && d * error * error > alpha;
}

/* Bierman's update for the measurement scale phi theta + rhs = 0 of variance r: with f = U' row and
 * v_j = d_j f_j over the columns j
 *   alpha_j = alpha_{j-1} + v_j f_j,   d_j <- d_j alpha_{j-1} / alpha_j,
 *   U_ij <- U_ij - (f_j / alpha_{j-1}) g_i,   g_i <- g_i + v_j U_ij (old),   g_j = v_j,
 * two columns at a time as in a vector of two. 0 where a number left its range. */
static int measure_row(rcac_state *s, const rcac_real *phi, rcac_real scale, rcac_real rhs,
                       rcac_real r, int *lost) {
    rcac_real row[N], gain[N], even = 0, odd = 0, largest = 0, widest = 0, alpha = r;
    rcac_real innovation, step, noise;
    int j, i, c;
    int guarded, fine = 1;
    for (j = 0; j < N; ++j) {
        row[j] = phi[j] * scale;
        if (magnitude(row[j]) > largest) largest = magnitude(row[j]);
        if (s->D[j] > widest) widest = s->D[j];
    }
    for (j = 0; j + 1 < N; j += 2) {
        even += row[j] * s->theta[j];
        odd += row[j + 1] * s->theta[j + 1];
    }
    innovation = rhs + (even + odd);
#if RCAC_L_THETA % 2
    innovation += row[N - 1] * s->theta[N - 1];
#endif
    noise = RCAC_NUMBER(1024.0) * RCAC_EPSILON * largest;
    noise *= noise;
    guarded = widest * noise > r;

    for (j = 0; j < N; j += 2) {
        const int pair = N - j < 2 ? N - j : 2;
        rcac_real f[2] = {0, 0}, v[2] = {0, 0}, before[2], after[2];
        for (c = 0; c < pair; ++c) {
            const rcac_real *U = column(s, j + c);
            even = odd = 0;
            for (i = 0; i + 1 < j + c; i += 2) { /* j is even */
                even += U[i] * row[i];
                odd += U[i + 1] * row[i + 1];
            }
            if (c) {
                even += U[i] * row[i];
                odd += row[j + c];
            } else {
                even += row[j];
            }
            f[c] = even + odd;
            v[c] = s->D[j + c] * f[c];
        }
        before[0] = alpha;
        before[1] = after[0] = alpha + v[0] * f[0];
        after[1] = alpha + (v[0] * f[0] + v[1] * f[1]);
        alpha = after[1];
        for (c = 0; c < pair; ++c) {
            rcac_real *U = column(s, j + c), d = s->D[j + c];
            const rcac_real factor = f[c] / before[c];
            if (guarded && d * noise > before[c] && lost_in_rounding(row, U, j + c, f[c], d, before[c]))
                *lost = 1;
            if (!(f[c] <= 0 && f[c] >= 0)) s->D[j + c] = d * (before[c] / after[c]);
            for (i = 0; i < j + c; ++i) {
                const rcac_real old = U[i];
                U[i] = old - factor * gain[i];
                gain[i] = gain[i] + v[c] * old;
            }
            gain[j + c] = 0 + v[c];
        }
    }
    step = innovation / alpha;
    for (j = 0; j < N; ++j) {
#if RCAC_CARRY
        /* Knuth's sum of two numbers, and what it rounds away. */
        const rcac_real change = s->carry[j] - gain[j] * step, old = s->theta[j], sum = old + change;
        const rcac_real part = sum - old;
        s->carry[j] = (old - (sum - part)) + (change - part);
        s->theta[j] = sum;
#else
        s->theta[j] -= gain[j] * step;
#endif
        fine &= is_finite(s->theta[j]) && is_finite(s->D[j]);
    }
    return fine && is_finite(alpha);
}

#if RCAC_NOISE
/* One rank-one update for each row of Q (Agee and Turner 1972). */
static void inflate(rcac_state *s) {
    int m, i, j;
    for (m = 0; m < RCAC_NOISE; ++m) {
        rcac_real row[N], weight = RCAC_SCALE;
        for (i = 0; i < N; ++i) row[i] = rcac_noise[m * N + i];
        for (j = N; j-- > 0 && weight > 0;) {
            rcac_real *U = column(s, j);
            const rcac_real a = row[j], old = s->D[j];
            rcac_real gain;
            if (a <= 0 && a >= 0) continue;
            s->D[j] = old + weight * a * a;
            gain = weight * a / s->D[j];
            weight *= old / s->D[j];
            for (i = 0; i < j; ++i) {
                row[i] -= a * U[i];
                U[i] += gain * row[i];
            }
        }
    }
}
#endif

#if RCAC_TRACE_BELOW_RULE
static rcac_real trace(rcac_state *s) {
    rcac_real sum = 0;
    int i, j;
    for (j = 0; j < N; ++j) {
        const rcac_real *U = column(s, j);
        for (i = 0; i < j; ++i) sum += s->D[j] * U[i] * U[i];
        sum += s->D[j];
    }
    return sum;
}
#endif

#if RCAC_BOUNDS
static int keeps_bounds(const rcac_state *s) {
    int i;
    for (i = 0; i < N; ++i)
        if (!(s->theta[i] >= rcac_least[i] && s->theta[i] <= rcac_most[i])) return 0;
    return 1;
}

#if RCAC_SWEEPS
/* Column i of P. */
static void covariance_column(rcac_state *s, int i, rcac_real *result) {
    int m, j;
    for (j = 0; j < N; ++j) result[j] = 0;
    for (m = i; m < N; ++m) {
        const rcac_real *U = column(s, m), weight = m == i ? s->D[m] : s->D[m] * U[i];
        if (weight <= 0 && weight >= 0) continue;
        for (j = 0; j < m; ++j) result[j] += weight * U[j];
        result[m] += weight;
    }
}

/* Hildreth (1957): theta <- theta - P e_i dmu for one bound after another. */
static void project(rcac_state *s) {
    rcac_real multiplier[N], P_i[N];
    int sweep, i, j;
    for (i = 0; i < N; ++i) multiplier[i] = 0;
    for (sweep = 0; sweep < RCAC_SWEEPS; ++sweep) {
        int moved = 0;
        for (i = 0; i < N; ++i) {
            const rcac_real theta = s->theta[i];
            rcac_real unbound, place, step;
            if (!(theta < rcac_least[i] || theta > rcac_most[i]) && multiplier[i] <= 0 &&
                multiplier[i] >= 0)
                continue;
            covariance_column(s, i, P_i);
            if (!(P_i[i] > 0)) return; /* rounding left P no metric */
            unbound = theta + P_i[i] * multiplier[i];
            place = held(unbound, rcac_least[i], rcac_most[i]);
            step = (unbound - place) / P_i[i] - multiplier[i];
            if (magnitude(step) * P_i[i] <= RCAC_TOLERANCE * magnitude(place)) continue;
            multiplier[i] += step;
            for (j = 0; j < N; ++j) s->theta[j] -= step * P_i[j];
            moved = 1;
        }
        if (!moved) return;
    }
}
#endif

static void bound_in_box(rcac_state *s) {
    int i;
    if (keeps_bounds(s)) return;
#if RCAC_SWEEPS
    project(s);
#endif
    for (i = 0; i < N; ++i) s->theta[i] = held(s->theta[i], rcac_least[i], rcac_most[i]);
#if RCAC_CARRY
    for (i = 0; i < N; ++i) s->carry[i] = 0;
#endif
    ++s->bounded;
}
#endif

#if RCAC_ELLIPSOID
/* theta = center + L v with |v| <= 1; L^{-1} row by row. Sums run as in vectors of two and of four. */

/* v = L^{-1} delta; its square. */
static rcac_real shares(const rcac_real *delta, rcac_real *v) {
    const rcac_real *row = rcac_inverse;
    rcac_real square[2] = {0, 0};
    int i, j;
    for (i = 0; i < N; ++i) {
        rcac_real sum[2] = {0, 0};
        for (j = 0; j <= i; ++j) sum[j % 2] += row[j] * delta[j];
        v[i] = sum[0] + sum[1];
        square[i % 2] += v[i] * v[i];
        row += i + 1;
    }
    return square[0] + square[1];
}

static rcac_real locate(const rcac_real *theta, rcac_real *delta, rcac_real *v) {
    int i;
    for (i = 0; i < N; ++i) delta[i] = theta[i] - rcac_center[i];
    return shares(delta, v);
}

/* n = L^{-T} v. */
static void normal_to(const rcac_real *v, rcac_real *n) {
    int i, j;
    for (j = 0; j < N; ++j) {
        rcac_real sum[4] = {0, 0, 0, 0};
        for (i = j; i < N; ++i) sum[i % 4] += rcac_inverse[i * (i + 1) / 2 + j] * v[i];
        n[j] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
}

/* P x with P = U D U'. */
static void covariance_times(rcac_state *s, const rcac_real *x, rcac_real *product) {
    int m, i;
    for (m = 0; m < N; ++m) {
        const rcac_real *U = column(s, m);
        rcac_real sum[2] = {0, 0};
        for (i = 0; i < m; ++i) sum[i % 2] += U[i] * x[i];
        sum[m % 2] += x[m];
        product[m] = (sum[0] + sum[1]) * s->D[m];
    }
    for (i = 0; i < N; ++i) {
        rcac_real sum[4] = {0, 0, 0, 0};
        sum[i % 4] += product[i];
        for (m = i + 1; m < N; ++m) sum[m % 4] += column(s, m)[i] * product[m];
        product[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
}

/* With n = M^{-1} delta the half-space n't <= (e^2 + limit) / 2 holds the ellipsoid, and the nearest
 * point of it in the metric of P is delta - P n (e^2 - limit) / (2 n'Pn): four times. */
static rcac_real cut(rcac_state *s, rcac_real *delta, rcac_real *v, rcac_real square, rcac_real limit) {
    rcac_real n[N], moved[N];
    int made, i;
    for (made = 0; made < 4 && square > limit * (1 + RCAC_NUMBER(1e-6)); ++made) {
        rcac_real size[2] = {0, 0}, step;
        normal_to(v, n);
        covariance_times(s, n, moved);
        for (i = 0; i < N; ++i) size[i % 2] += n[i] * moved[i];
        size[0] += size[1];
        step = (square - limit) / (2 * size[0]);
        /* Rounding left P no metric, or the numbers are beyond their range. */
        if (!(size[0] > 0) || !is_finite(size[0]) || !is_finite(step)) return square;
        for (i = 0; i < N; ++i) delta[i] -= step * moved[i];
        square = shares(delta, v);
    }
    return square;
}

static void bound_in_ellipsoid(rcac_state *s) {
    const rcac_real limit = rcac_radii[0] * rcac_radii[0];
    rcac_real delta[N], v[N], largest = 0, scale = 0;
    rcac_real square = locate(s->theta, delta, v);
    int i;
    if (square <= limit) return;
    ++s->bounded;
#if RCAC_CARRY
    for (i = 0; i < N; ++i) s->carry[i] = 0;
#endif
    if (is_finite(square)) {
        square = cut(s, delta, v, square, limit);
    } else { /* the direction alone */
        for (i = 0; i < N; ++i)
            if (magnitude(delta[i]) > largest) largest = magnitude(delta[i]);
        for (i = 0; i < N; ++i) delta[i] /= largest;
        square = shares(delta, v);
    }
    if (is_finite(square)) {
        scale = rcac_radii[1] / RCAC_SQRT(square);
        if (scale > 1) scale = 1;
    }
    for (i = 0; i < N; ++i)
        s->theta[i] = scale > 0 ? rcac_center[i] + scale * delta[i] : rcac_center[i];
}
#endif

/* ---- the rules that follow z */

#if RCAC_POWER_WINDOW
static rcac_real mean_power(const rcac_state *s, int64_t window) {
    const int64_t length = window < s->powers ? window : s->powers;
    rcac_real sum = 0;
    int64_t i;
    for (i = s->powers - length; i < s->powers; ++i) sum += s->power[i % RCAC_POWER_WINDOW];
    return length > 0 ? sum / (rcac_real)length : 0;
}

static rcac_real growth(const rcac_state *s, int64_t window, int64_t reach) {
    const rcac_real recent = mean_power(s, window), past = mean_power(s, reach);
    return past > 0 ? RCAC_SQRT(recent / past) : 1;
}
#endif

static int reset_is_due(rcac_state *s) {
    const int64_t from = s->last_reset > RCAC_K_UPDATE ? s->last_reset : RCAC_K_UPDATE;
    const int64_t age = s->step - from;
    int due = 0;
#if RCAC_RESET_EVERY
    due = due || (age > 0 && (s->step - RCAC_K_UPDATE) % RCAC_RESET_EVERY == 0);
#endif
#if RCAC_TRACE_BELOW_RULE
    due = due || trace(s) < rcac_trace_below[0] * s->initial_trace;
#endif
#if RCAC_GROWTH_RULE
    due = due || (age >= RCAC_RESET_LONG && growth(s, RCAC_RESET_SHORT, RCAC_RESET_LONG) > rcac_growth[0]);
#endif
    (void)age;
    return due;
}

static void see(rcac_state *s, const rcac_real *z) {
#if RCAC_POWER_WINDOW
    rcac_real power = 0;
    int i;
    for (i = 0; i < RCAC_L_Z; ++i) power += z[i] * z[i];
    s->power[s->powers % RCAC_POWER_WINDOW] = power;
    ++s->powers;
#endif
    (void)s;
    (void)z;
}

/* ---- the rows of the cost (2.41) */

#if RCAC_LIVE
#define NUMERATOR(s) (s)->numerator
#define DENOMINATOR(s) (s)->denominator
#else
#define NUMERATOR(s) (rcac_numerators + (s)->target * (RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_U)
#define DENOMINATOR(s) (rcac_denominators + (s)->target * (RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_Z)
#endif

/* F(k) = G_f s(k) of every channel. */
static void filter(rcac_state *s) {
    const rcac_real *numerator = NUMERATOR(s), *denominator = DENOMINATOR(s);
    int channel, row, column_, i, m;
    for (channel = 0; channel < RCAC_CHANNELS; ++channel)
        for (row = 0; row < RCAC_L_Z; ++row)
            for (column_ = 0; column_ < RCAC_L_U; ++column_) {
                rcac_real sum = 0;
                for (i = 0; i <= RCAC_ORDER; ++i)
                    sum += numerator[(i * RCAC_L_Z + row) * RCAC_L_U + column_] * s->inputs[channel][i];
                for (m = 0; RCAC_RECURSIVE && m < RCAC_L_Z; ++m)
                    for (i = 1; i <= RCAC_ORDER; ++i)
                        sum -= denominator[(i * RCAC_L_Z + row) * RCAC_L_Z + m] *
                               s->outputs[(channel * RCAC_L_Z + m) * RCAC_L_U + column_][i];
                s->outputs[(channel * RCAC_L_Z + row) * RCAC_L_U + column_][0] = sum;
            }
    (void)denominator;
    (void)m;
}

static void feed_filter(rcac_state *s) {
    int c;
    if (s->step < RCAC_K_FILTER) return;
    for (c = 0; c < RCAC_CHANNELS; ++c)
        s->inputs[c][0] = s->signals[rcac_channels[2 * c]][rcac_channels[2 * c + 1]];
}

static rcac_real normalised(rcac_real z) {
#if RCAC_NORMALIZATION == 1
    const rcac_real x = rcac_slope[0] * z;
    return x / (1 + magnitude(x) / rcac_supremum[0]);
#elif RCAC_NORMALIZATION == 2
    const rcac_real x = rcac_slope[0] * z;
    return x / RCAC_SQRT(1 + x / rcac_supremum[0] * (x / rcac_supremum[0]));
#else
    return z;
#endif
}

#if RCAC_VARYING_WEIGHTS
/* R(k) = (base + z_squared z'z I) / (1 + nu |z|)^2 into the upper left corner. */
static void weigh(const rcac_real *base, rcac_real z_squared, rcac_real nu, const rcac_real *z,
                  rcac_real *result) {
    rcac_real power = 0, root;
    int i, j;
    for (i = 0; i < RCAC_L_Z; ++i) power += z[i] * z[i];
    for (i = 0; i < RCAC_L_Z; ++i)
        for (j = 0; j < RCAC_L_Z; ++j) result[i * RCAC_ROWS + j] = base[i * RCAC_L_Z + j];
    for (i = 0; i < RCAC_L_Z; ++i) result[i * RCAC_ROWS + i] += z_squared * power;
    if (nu <= 0) return;
    root = 1 + nu * RCAC_SQRT(power);
    for (i = 0; i < RCAC_L_Z; ++i)
        for (j = 0; j < RCAC_L_Z; ++j) result[i * RCAC_ROWS + j] /= root * root;
}

/* Lower Cholesky factor in place; 0 where A is not positive definite. */
static int cholesky(rcac_real *A) {
    int i, j, m;
    for (j = 0; j < RCAC_ROWS; ++j) {
        rcac_real pivot = A[j * RCAC_ROWS + j];
        for (m = 0; m < j; ++m) pivot -= A[j * RCAC_ROWS + m] * A[j * RCAC_ROWS + m];
        if (!(pivot > 0)) return 0;
        A[j * RCAC_ROWS + j] = RCAC_SQRT(pivot);
        for (i = j + 1; i < RCAC_ROWS; ++i) {
            rcac_real sum = A[i * RCAC_ROWS + j];
            for (m = 0; m < j; ++m) sum -= A[i * RCAC_ROWS + m] * A[j * RCAC_ROWS + m];
            A[i * RCAC_ROWS + j] = sum / A[j * RCAC_ROWS + j];
        }
    }
    return 1;
}
#endif

static rcac_real entry_of(const rcac_state *s, int row, int j) {
    const int tap = j / RCAC_L_U, i = j % RCAC_L_U;
#if RCAC_PENALTY
    if (row >= RCAC_L_Z) return rcac_penalty[(row - RCAC_L_Z) * RCAC_L_U + i] * phi_of(s, tap);
#endif
    return s->outputs[(rcac_filtered[2 * tap] * RCAC_L_Z + row) * RCAC_L_U + i][rcac_filtered[2 * tap + 1]];
}

/* The measurements of this step: with W = R_z + R_u = L L' the rows of L' Phi_f carry uncorrelated
 * noise. 0 where a number left its range. */
static int take_rows(rcac_state *s, const rcac_real *z) {
    rcac_real target[RCAC_ROWS], rhs[RCAC_ROWS], phi[N];
    int r, i, j;
    int lost = 0;
#if RCAC_VARYING_WEIGHTS
    rcac_real R_z[RCAC_ROWS * RCAC_ROWS], L[RCAC_ROWS * RCAC_ROWS];
    for (i = 0; i < RCAC_ROWS * RCAC_ROWS; ++i) R_z[i] = L[i] = 0;
    for (i = RCAC_L_Z; i < RCAC_ROWS; ++i) R_z[i * RCAC_ROWS + i] = 1;
    weigh(rcac_R_z_base, rcac_R_z_varying[0], rcac_R_z_varying[1], z, R_z);
    weigh(rcac_R_u_base, rcac_R_u_varying[0], rcac_R_u_varying[1], z, L);
    for (i = 0; i < RCAC_ROWS * RCAC_ROWS; ++i) L[i] = R_z[i] + L[i];
    if (!cholesky(L)) return 0;
#else
    const rcac_real *R_z = rcac_R_z, *L = rcac_L;
#endif
    for (r = 0; r < RCAC_ROWS; ++r) target[r] = 0;
    for (r = 0; r < RCAC_L_Z; ++r) {
        target[r] = normalised(z[r]);
        for (i = 0; i < RCAC_L_U; ++i) target[r] -= s->outputs[(i * RCAC_L_Z + r) * RCAC_L_U + i][0];
    }
#if RCAC_ROWS == 1
    rhs[0] = R_z[0] * target[0] / L[0];
#else
    for (i = 0; i < RCAC_ROWS; ++i) {
        rhs[i] = 0;
        for (j = 0; j < RCAC_ROWS; ++j) rhs[i] += R_z[i * RCAC_ROWS + j] * target[j];
    }
    for (i = 0; i < RCAC_ROWS; ++i) {
        for (j = 0; j < i; ++j) rhs[i] -= L[i * RCAC_ROWS + j] * rhs[j];
        rhs[i] /= L[i * RCAC_ROWS + i];
    }
#endif
    for (r = 0; r < RCAC_ROWS; ++r) {
#if RCAC_ROWS == 1
        const rcac_real scale = L[0];
        for (j = 0; j < N; ++j) phi[j] = entry_of(s, 0, j);
#else
        const rcac_real scale = 1;
        for (j = 0; j < N; ++j) {
            phi[j] = L[r * RCAC_ROWS + r] * entry_of(s, r, j);
            for (i = r + 1; i < RCAC_ROWS; ++i) phi[j] += L[i * RCAC_ROWS + r] * entry_of(s, i, j);
        }
#endif
        lost = 0;
        i = measure_row(s, phi, scale, rhs[r], s->lambda * RCAC_SCALE, &lost);
        if (lost) {
            if (s->guard_count++ == 0) s->guard_first_step = s->step;
        }
        if (!i) return 0;
    }
    return 1;
}

/* theta(k+1) from theta(k); 0 where a number left its range. */
static int update(rcac_state *s, const rcac_real *z) {
#if RCAC_VARIABLE_RATE
    rcac_real excess;
#endif
    int j;
    feed_filter(s);
    filter(s);
    see(s, z);
    if (s->step < RCAC_K_UPDATE || s->frozen) return 1;
#if RCAC_VARIABLE_RATE
    excess = growth(s, RCAC_FORGET_SHORT, RCAC_FORGET_LONG) - 1;
    if (!(0 < excess)) excess = 0;
    s->lambda = 1 / (1 + rcac_forgetting[0] * excess);
    if (s->lambda < rcac_forgetting[1]) s->lambda = rcac_forgetting[1];
#endif
    if (reset_is_due(s)) {
        s->last_reset = s->step;
        reset(s);
        ++s->resets;
    }
    if (!take_rows(s, z)) return 0;
    if (s->lambda < 1) {
        for (j = 0; j < N; ++j) {
            s->D[j] /= s->lambda;
#if RCAC_CAP
            if (s->D[j] > rcac_D_0[j]) s->D[j] = rcac_D_0[j];
#endif
            if (!is_finite(s->D[j])) return 0;
        }
    }
#if RCAC_NOISE
    inflate(s);
#endif
#if RCAC_BOUNDS
    bound_in_box(s);
#endif
#if RCAC_ELLIPSOID
    bound_in_ellipsoid(s);
#endif
    return 1;
}

static void act_on_events(rcac_state *s) {
#if RCAC_EVENTS
    while (s->next_event < RCAC_EVENTS && rcac_event_step[s->next_event] <= s->step) {
        const int32_t event = s->next_event++;
        switch (rcac_event_kind[event]) {
            case 0: s->frozen = 1; break;
            case 1: s->frozen = 0; break;
            case 2:
                reset(s);
                ++s->resets;
                break;
            case 3: s->lambda = rcac_event_value[event]; break;
#if !RCAC_LIVE
            case 4: s->target = rcac_event_target[event]; break;
#endif
            default: break;
        }
    }
#endif
    (void)s;
}

static void remember(rcac_state *s) {
#if RCAC_LIVE
    int i;
    s->newest = s->newest == 0 ? RCAC_REMEMBERED - 1 : s->newest - 1;
    for (i = 0; i < RCAC_SOURCES; ++i) s->past[i][s->newest] = s->signals[rcac_sources[i]][0];
#endif
    (void)s;
}
#endif /* RCAC_ADAPTS */

/* ---- what others call */

void rcac_init(rcac_state *s) {
    int i;
    memset(s, 0, sizeof *s); /* which every zero of a number is, too */
    s->signature = RCAC_SIGNATURE;
    for (i = 0; i < N; ++i) s->theta[i] = rcac_theta_0[i];
#if RCAC_ADAPTS
    s->lambda = rcac_lambda[0];
    s->last_reset = s->guard_first_step = -1;
    reset(s);
#if RCAC_SUPERVISED
    for (i = 0; i < N; ++i) s->good[i] = rcac_theta_0[i];
    for (i = 0; i < RCAC_TROUBLES; ++i) s->troubles[i].first = s->troubles[i].last = -1;
#endif
#if RCAC_TRACE_BELOW_RULE
    s->initial_trace = trace(s);
#endif
#if RCAC_LIVE
    for (i = 0; i < (RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_U; ++i) s->numerator[i] = rcac_numerators[i];
    for (i = 0; i < (RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_Z; ++i) s->denominator[i] = rcac_denominators[i];
#endif
#endif
}

static int is_bad(const rcac_real *values, int count) {
    return count > 0 && (!values || !all_finite(values, count));
}

static void answer(const rcac_state *s, rcac_real *u) {
    int i;
    for (i = 0; i < RCAC_L_U; ++i) u[i] = s->u[i];
}

#if RCAC_ADAPTS
static int adapted(rcac_state *s, const rcac_real *z) {
    const int64_t guards = s->guard_count, bounded = s->bounded;
#if RCAC_SUPERVISED
    rcac_real largest = 0;
    int i;
    if (!z || !all_finite(z, RCAC_L_Z)) { /* signals move on, theta stays */
        feed_filter(s);
        filter(s);
        see(s, s->z);
        return 0;
    }
    for (i = 0; i < RCAC_L_Z; ++i) {
        s->z[i] = z[i];
        if (magnitude(z[i]) > largest) largest = magnitude(z[i]);
    }
    if (rcac_windup[1] > 0 && largest > rcac_windup[1]) {
        note(s, RCAC_LARGE, s->step, largest);
        s->noted |= RCAC_LARGE_Z;
    }
    if (!update(s, z)) recover(s);
#else
    if (s->broken) return 0;
    if (!update(s, z)) s->broken = 1;
#endif
    return (s->guard_count != guards ? RCAC_UNSUPPORTED : 0) | (s->bounded != bounded ? RCAC_BOUNDED : 0);
}
#endif

/* The step up to u(k), with y(k) and r(k) where it `measures` them now. */
static int controlled(rcac_state *s, int measures, const rcac_real *y, const rcac_real *z,
                      const rcac_real *r, rcac_real *u) {
    int status = 0, missed = 0;
#if RCAC_SUPERVISED
    rcac_real y_known[RCAC_L_Y + 1], r_known[RCAC_L_R + 1];
#endif
    if (s->phase != 0) {
        answer(s, u);
        return RCAC_OUT_OF_ORDER;
    }
#if !RCAC_SUPERVISED
    if ((measures && (is_bad(y, RCAC_L_Y) || is_bad(r, RCAC_L_R))) ||
        (RCAC_FILTER_FORM && is_bad(z, RCAC_L_Z))) {
        answer(s, u);
        return RCAC_BAD_INPUT;
    }
#endif
#if RCAC_ADAPTS
    act_on_events(s);
#endif
    advance(s);
#if RCAC_SUPERVISED
    s->noted = 0;
    if (!s->heard) s->unapplied = 0;
    s->heard = 0;
    if (measures) {
        missed = fill(s, y, RCAC_L_U, RCAC_L_Y, y_known);
        missed |= fill(s, r, RCAC_L_U + RCAC_L_Y, RCAC_L_R, r_known);
        y = y_known;
        r = r_known;
        if (missed) s->noted |= RCAC_MISSED;
    }
    if (RCAC_FILTER_FORM && is_bad(z, RCAC_L_Z)) s->noted |= RCAC_MISSED;
#endif
    if (measures) measure(s, y, r);
#if RCAC_ADAPTS && RCAC_FILTER_FORM
    status = adapted(s, z);
#endif
    control(s, missed);
    s->phase = measures ? 2 : 1;
    answer(s, u);
    (void)z;
    return status | rcac_status(s);
}

int rcac_control(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r, rcac_real *u) {
    return controlled(s, RCAC_MEASURES_FIRST || y || r, y, z, r, u);
}

int rcac_adapt(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r,
               const rcac_real *u_applied) {
    int status = 0;
    const int is_late = s->phase == 1;
#if RCAC_SUPERVISED
    rcac_real y_known[RCAC_L_Y + 1], r_known[RCAC_L_R + 1];
#else
    int i, bad;
#endif
    if (s->phase == 0) return RCAC_OUT_OF_ORDER;
#if RCAC_SUPERVISED
    if (u_applied && is_bad(u_applied, RCAC_L_U)) u_applied = NULL;
    if (is_late) {
        int missed = fill(s, y, RCAC_L_U, RCAC_L_Y, y_known);
        missed |= fill(s, r, RCAC_L_U + RCAC_L_Y, RCAC_L_R, r_known);
        if (missed) s->noted |= RCAC_MISSED;
        measure(s, y_known, r_known);
    }
    if (!RCAC_FILTER_FORM && is_bad(z, RCAC_L_Z)) s->noted |= RCAC_MISSED;
    if (s->noted & RCAC_MISSED) note(s, RCAC_MISSING, s->step, 1);
    if (u_applied) {
        see_actuator(s, equals(u_applied, s->u, RCAC_L_U), s->step);
        apply(s, u_applied);
    }
    if (!RCAC_FILTER_FORM) status = adapted(s, z);
    if (RCAC_FILTER_FORM) feed_filter(s); /* u(k) was not known to the filter yet */
    remember(s);
    s->phase = 0;
    ++s->step;
    look(s);
#else
    bad = (is_late && (is_bad(y, RCAC_L_Y) || is_bad(r, RCAC_L_R))) ||
          (RCAC_ADAPTS && !RCAC_FILTER_FORM && is_bad(z, RCAC_L_Z)) ||
          (u_applied && is_bad(u_applied, RCAC_L_U));
    if (bad) { /* u(k) is out: the step ends with what was measured before, and without an update */
        rcac_real held_y[RCAC_L_Y + 1], held_r[RCAC_L_R + 1];
        for (i = 0; i < RCAC_L_Y; ++i) held_y[i] = s->signals[RCAC_L_U + i][1];
        for (i = 0; i < RCAC_L_R; ++i) held_r[i] = s->signals[RCAC_L_U + RCAC_L_Y + i][1];
        if (is_late) measure(s, held_y, held_r);
        status = RCAC_BAD_INPUT;
    } else {
        if (is_late) measure(s, y, r);
        if (u_applied) apply(s, u_applied);
    }
#if RCAC_ADAPTS
    if (bad) {
        if (!RCAC_FILTER_FORM) {
            feed_filter(s);
            filter(s);
        }
    } else if (!RCAC_FILTER_FORM) {
        status |= adapted(s, z);
    }
    if (RCAC_FILTER_FORM) feed_filter(s); /* u(k) was not known to the filter yet */
    remember(s);
#endif
    s->phase = 0;
    ++s->step;
    for (i = 0; i < RCAC_SIGNALS; ++i)
        if (!is_finite(s->signals[i][0])) s->broken = 1;
#endif
    (void)z;
    return status | rcac_status(s);
}

int rcac_step(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r, rcac_real *u) {
    int status;
    if (s->phase != 0 || (!RCAC_SUPERVISED && (is_bad(y, RCAC_L_Y) || is_bad(r, RCAC_L_R) ||
                                               (RCAC_ADAPTS && is_bad(z, RCAC_L_Z))))) {
        answer(s, u);
        return s->phase != 0 ? RCAC_OUT_OF_ORDER : RCAC_BAD_INPUT;
    }
    status = controlled(s, 1, y, z, r, u);
    return status | rcac_adapt(s, y, z, r, NULL);
}

#if RCAC_ADAPTS && RCAC_LIVE
static int is_strict(const rcac_real *numerator) {
    int i, strict = 1;
    for (i = 0; i < RCAC_L_Z * RCAC_L_U; ++i) strict &= numerator[i] <= 0 && numerator[i] >= 0;
    return strict;
}
#endif

int rcac_correct(rcac_state *s, const rcac_real *u_applied) {
    if (s->phase != 0) return RCAC_OUT_OF_ORDER;
#if RCAC_ADAPTS && RCAC_LIVE
    if (!is_strict(s->numerator)) return RCAC_REFUSED;
#else
    if (!RCAC_STRICTLY_PROPER) return RCAC_REFUSED;
#endif
    if (s->step == 0) return RCAC_REFUSED;
    if (is_bad(u_applied, RCAC_L_U)) return RCAC_BAD_INPUT;
#if RCAC_SUPERVISED
    see_actuator(s, equals(u_applied, s->held, RCAC_L_U), s->step - 1);
#endif
    apply(s, u_applied);
#if RCAC_ADAPTS
    {
        int c;
        for (c = 0; c < RCAC_CHANNELS; ++c)
            if (rcac_channels[2 * c] < RCAC_L_U && rcac_channels[2 * c + 1] == 0 &&
                s->step > RCAC_K_FILTER)
                s->inputs[c][0] = s->signals[rcac_channels[2 * c]][0];
#if RCAC_LIVE
        for (c = 0; c < RCAC_SOURCES; ++c)
            if (rcac_sources[c] < RCAC_L_U) s->past[c][s->newest] = s->signals[rcac_sources[c]][0];
#endif
    }
#endif
    return RCAC_OK;
}

void rcac_freeze(rcac_state *s, int frozen) { s->frozen = frozen != 0; }

int rcac_reset_covariance(rcac_state *s) {
#if RCAC_ADAPTS
    reset(s);
    ++s->resets;
    return RCAC_OK;
#else
    (void)s;
    return RCAC_REFUSED;
#endif
}

int rcac_set_lambda(rcac_state *s, rcac_real lambda) {
#if RCAC_ADAPTS && !RCAC_VARIABLE_RATE
    if (!(lambda > 0 && lambda <= 1)) return RCAC_REFUSED;
    s->lambda = lambda;
    return RCAC_OK;
#else
    (void)s;
    (void)lambda;
    return RCAC_REFUSED;
#endif
}

#if RCAC_ADAPTS && RCAC_LIVE
#define PLACES (RCAC_L_Z * RCAC_L_U)

/* The newest `ages` steps of a source through a model of RCAC_ORDER; with D_f from zeros before the
 * oldest of all, in the order of the sums of the filter. */
static void filter_past(const rcac_state *s, int source, const rcac_real *numerator,
                        const rcac_real *denominator, int recursive, int ages,
                        rcac_real filtered[PLACES][RCAC_REMEMBERED]) {
    int age, i;
    int row, column_, m;
    for (age = ages; age-- > 0;)
        for (row = 0; row < RCAC_L_Z; ++row)
            for (column_ = 0; column_ < RCAC_L_U; ++column_) {
                rcac_real sum = 0;
                for (i = 0; i <= RCAC_ORDER && age + i < RCAC_REMEMBERED; ++i)
                    sum += numerator[(i * RCAC_L_Z + row) * RCAC_L_U + column_] *
                           s->past[source][(s->newest + age + i) % RCAC_REMEMBERED];
                for (m = 0; recursive && m < RCAC_L_Z; ++m)
                    for (i = 1; i <= RCAC_ORDER && age + i < ages; ++i)
                        sum -= denominator[(i * RCAC_L_Z + row) * RCAC_L_Z + m] *
                               filtered[m * RCAC_L_U + column_][age + i];
                filtered[row * RCAC_L_U + column_][age] = sum;
            }
}

static int is_recursive(const rcac_real *denominator) {
    int i;
    int any = 0;
    for (i = RCAC_L_Z * RCAC_L_Z; i < (RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_Z; ++i)
        any |= denominator[i] > 0 || denominator[i] < 0;
    return any;
}

int rcac_set_target(rcac_state *s, const rcac_real *numerator, const rcac_real *denominator, int order,
                    int past) {
    const int of_N = PLACES, of_D = RCAC_L_Z * RCAC_L_Z;
    rcac_real N_f[(RCAC_ORDER + 1) * PLACES], D_f[(RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_Z];
    rcac_real before[PLACES][RCAC_REMEMBERED], after[PLACES][RCAC_REMEMBERED], gap = 0, size = 0, rho;
    const int compared = 64;
    int age, ages, depth;
    int i, j, k, length;
    if (s->phase != 0) return RCAC_OUT_OF_ORDER;
    if (order < 0 || order > RCAC_ORDER || past < RCAC_KEEP || past > RCAC_BLEND) return RCAC_REFUSED;
    length = order + 1;
    if (is_bad(numerator, length * of_N) || is_bad(denominator, length * of_D)) return RCAC_REFUSED;
    for (i = 0; i < RCAC_L_Z; ++i)
        for (j = 0; j < RCAC_L_Z; ++j) {
            const rcac_real gap_of_I = denominator[i * RCAC_L_Z + j] - (i == j ? 1 : 0);
            if (gap_of_I < 0 || gap_of_I > 0) return RCAC_REFUSED;
        }
    if (RCAC_FILTER_FORM && !is_strict(numerator)) return RCAC_REFUSED;
    for (i = 0; i < (RCAC_ORDER + 1) * of_N; ++i) N_f[i] = i < length * of_N ? numerator[i] : 0;
    for (i = 0; i < (RCAC_ORDER + 1) * of_D; ++i) D_f[i] = i < length * of_D ? denominator[i] : 0;

    depth = RCAC_OUTPUT_DEPTH + RCAC_DEPTH - 1;
    ages = depth > compared ? depth : compared;
    if (ages > RCAC_REMEMBERED) ages = RCAC_REMEMBERED;
    for (i = 0; i < RCAC_SOURCES; ++i) {
        const int old = is_recursive(s->denominator), now = is_recursive(D_f);
        filter_past(s, i, s->numerator, s->denominator, old, old ? RCAC_REMEMBERED : ages, before);
        filter_past(s, i, N_f, D_f, now, now ? RCAC_REMEMBERED : ages, after);
        for (j = 0; j < PLACES; ++j)
            for (age = 0; age < (ages < compared ? ages : compared); ++age) {
                const rcac_real a = after[j][age], b = before[j][age];
                gap += (a - b) * (a - b);
                size += a * a;
            }
        for (k = 0; k < RCAC_CHANNELS; ++k) {
            if (rcac_channels[2 * k] != rcac_sources[i]) continue;
            for (j = 0; j < PLACES; ++j)
                for (age = 0; age < RCAC_OUTPUT_DEPTH; ++age) {
                    const int at = age + (int)rcac_channels[2 * k + 1];
                    s->outputs[k * PLACES + j][age] = at < (now ? RCAC_REMEMBERED : ages) ? after[j][at] : 0;
                }
        }
    }
    for (i = 0; i < (RCAC_ORDER + 1) * of_N; ++i) s->numerator[i] = N_f[i];
    for (i = 0; i < (RCAC_ORDER + 1) * of_D; ++i) s->denominator[i] = D_f[i];
    rho = size > 0 ? gap / size : gap > 0 ? 1 : 0;
    if (past == RCAC_RESET || (past == RCAC_BLEND && !(rho < RCAC_NUMBER(0.999)))) {
        reset(s);
        if (past == RCAC_RESET) ++s->resets;
    } else if (past == RCAC_BLEND) {
        for (i = 0; i < N; ++i) {
            rcac_real doubted = s->D[i] / (1 - rho);
            if (rcac_D_0[i] < doubted) doubted = rcac_D_0[i];
            if (s->D[i] < doubted) s->D[i] = doubted;
        }
    }
    return RCAC_OK;
}
#else
int rcac_set_target(rcac_state *s, const rcac_real *numerator, const rcac_real *denominator, int order,
                    int past) {
    (void)s;
    (void)numerator;
    (void)denominator;
    (void)order;
    (void)past;
    return RCAC_REFUSED;
}
#endif

/* FNV-1a, which finds damage. */
static uint32_t checksum(const unsigned char *bytes, size_t count) {
    uint32_t hash = 2166136261u;
    while (count-- > 0) hash = (hash ^ *bytes++) * 16777619u;
    return hash;
}

void rcac_save(const rcac_state *s, unsigned char *bytes) {
    const uint32_t size = (uint32_t)sizeof *s;
    uint32_t sum;
    memcpy(bytes, &size, 4);
    memcpy(bytes + 8, s, sizeof *s);
    sum = checksum(bytes + 8, sizeof *s);
    memcpy(bytes + 4, &sum, 4);
}

int rcac_restore(rcac_state *s, const unsigned char *bytes) {
    uint32_t size, sum, signature;
    memcpy(&size, bytes, 4);
    memcpy(&sum, bytes + 4, 4);
    memcpy(&signature, bytes + 8, 4);
    if (size != (uint32_t)sizeof *s || signature != RCAC_SIGNATURE ||
        sum != checksum(bytes + 8, sizeof *s))
        return RCAC_REFUSED;
    memcpy(s, bytes + 8, sizeof *s);
    return RCAC_OK;
}

int rcac_status(const rcac_state *s) {
#if RCAC_SUPERVISED
    return s->noted | (s->wound_up ? RCAC_WOUND_UP : 0) |
           (s->unapplied >= RCAC_PATIENCE ? RCAC_HELD_BACK : 0);
#else
    return s->broken ? RCAC_DIVERGED : RCAC_OK;
#endif
}

int64_t rcac_guard_count(const rcac_state *s) {
#if RCAC_ADAPTS
    return s->guard_count;
#else
    (void)s;
    return 0;
#endif
}

rcac_real rcac_radius(const rcac_state *s) {
#if RCAC_ELLIPSOID
    rcac_real delta[N], v[N];
    return RCAC_SQRT(locate(s->theta, delta, v));
#else
    (void)s;
    return 0;
#endif
}

/* Not static const: a compiler that sees the numbers would round them itself. */
static rcac_real product_plus(const volatile rcac_real *x) {
    const rcac_real a = x[0], b = x[1], c = x[2];
    return a * b + c;
}

static rcac_real sum_lost(const volatile rcac_real *x) {
    const rcac_real a = x[0], b = x[1], sum = a + b, part = sum - a;
    return (a - (sum - part)) + (b - part);
}

int rcac_self_check(void) {
    volatile rcac_real x[3];
    rcac_real tiny;
    int found = 0;
    x[0] = 1;
    x[1] = RCAC_EPSILON / 4;
    tiny = sum_lost(x);
    if (!(tiny <= x[1] && tiny >= x[1])) found |= 1;
    x[0] = 1 + RCAC_EPSILON;
    x[1] = 1 - RCAC_EPSILON;
    x[2] = -1; /* (1 + e)(1 - e) is 1 once it is rounded */
    if (product_plus(x) < 0) found |= 2;
    x[0] = 0;
    x[1] = x[0] / x[0];
    tiny = x[1];
    if (tiny <= 0 || tiny >= 0) found |= 4;
    x[0] = 1;
    x[1] = RCAC_EPSILON / 2 + RCAC_EPSILON * RCAC_EPSILON; /* with more digits the sum is rounded twice */
    tiny = (x[0] + x[1]) - 1;
    if (!(tiny <= RCAC_EPSILON && tiny >= RCAC_EPSILON)) found |= 8;
    x[0] = RCAC_SMALLEST_NORMAL;
    x[1] = RCAC_NUMBER(0.5);
    tiny = x[0] * x[1];
    if (!(tiny > 0)) found |= 16;
    return found;
}
