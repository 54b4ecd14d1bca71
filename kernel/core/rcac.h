/* Retrospective cost adaptive control without a library below it.
 *
 * C99 and C++17. Nothing here allocates, throws, calls libm or keeps a static variable. The sizes and
 * the constants come from rcac_config.h, which `rcac export` writes.
 *
 *   rcac_state s;
 *   rcac_init(&s);
 *   every sample: status = rcac_step(&s, y, z, r, u);
 */
#ifndef RCAC_H
#define RCAC_H

#include <stdint.h>

#include "rcac_config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a step has to say; bits. */
enum {
    RCAC_OK = 0,
    RCAC_BAD_INPUT = 1,     /* an input was NaN or infinite: nothing moved, u is that of the step before */
    RCAC_DIVERGED = 2,      /* the numbers left their range: Phi theta is 0 until rcac_init or rcac_restore */
    RCAC_OUT_OF_ORDER = 4,  /* rcac_control and rcac_adapt do not alternate */
    RCAC_REFUSED = 8,       /* an argument does not fit: nothing moved */
    RCAC_UNSUPPORTED = 16,  /* an update of this step was decided by rounding, see rcac_guard_count */
    RCAC_BOUNDED = 32,      /* theta was moved to its bounds */
    /* Where RCAC_SUPERVISED is 1; RCAC_BAD_INPUT and RCAC_DIVERGED do not occur then. */
    RCAC_MISSED = 64,       /* an entry of y, z or r was NaN or infinite: see rcac_step */
    RCAC_WOUND_UP = 128,    /* a variance is too many times that of P(0) */
    RCAC_LARGE_Z = 256,     /* |z| is beyond its limit */
    RCAC_HELD_BACK = 512,   /* the actuator has not applied u for RCAC_PATIENCE steps */
    RCAC_RESTORED = 1024    /* numbers left their range: theta is that of the last good look, P is P(0) */
};

#if RCAC_SUPERVISED
/* A trouble: its steps, how often it began, the first and the last of its steps (-1: none), and how bad it
 * was: the growth, |z|, the steps in a row; 1 for a missed sample, 0 for an overflow. */
typedef struct {
    int64_t steps, episodes, first, last;
    rcac_real worst;
} rcac_trouble;
enum { RCAC_WINDUP, RCAC_LARGE, RCAC_UNAPPLIED, RCAC_MISSING, RCAC_OVERFLOW, RCAC_TROUBLES };
#endif

/* The state is plain memory: memcpy saves it. Between two builds use rcac_save. */
typedef struct {
    uint32_t signature; /* of the settings */
    int32_t broken, frozen, phase, asked;
    int64_t step;
    rcac_real u[RCAC_L_U]; /* the last control that was returned */
    rcac_real signals[RCAC_SIGNALS][RCAC_DEPTH]; /* u, y, r and derived signals, newest first */
    rcac_real theta[RCAC_L_THETA];
#if RCAC_SATURATED
    rcac_real applied[RCAC_L_U];
#endif
#if RCAC_FIXED
    rcac_real fixed[RCAC_L_U + RCAC_L_E][RCAC_FIXED_ORDER + 2]; /* v and e = [y; r] */
#endif
#if RCAC_ADAPTS
#if RCAC_CARRY
    rcac_real carry[RCAC_L_THETA]; /* what rounding took from theta */
#endif
    rcac_real U[RCAC_UPPER]; /* above its unit diagonal, column by column; P = U D U' */
    rcac_real D[RCAC_L_THETA];
    rcac_real inputs[RCAC_CHANNELS][RCAC_ORDER + 1]; /* of the target-model filter */
    rcac_real outputs[RCAC_CHANNELS * RCAC_L_Z * RCAC_L_U][RCAC_OUTPUT_DEPTH];
    rcac_real lambda;
#if RCAC_LIVE
    rcac_real numerator[(RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_U];
    rcac_real denominator[(RCAC_ORDER + 1) * RCAC_L_Z * RCAC_L_Z];
    rcac_real past[RCAC_SOURCES][RCAC_REMEMBERED];
    int32_t newest;
#else
    int32_t target;
#endif
#if RCAC_POWER_WINDOW
    rcac_real power[RCAC_POWER_WINDOW]; /* z'z of the last steps */
    int64_t powers;
#endif
#if RCAC_TRACE_BELOW_RULE
    rcac_real initial_trace;
#endif
    int32_t next_event;
    int64_t last_reset, resets, bounded, guard_count, guard_first_step;
#endif
#if RCAC_SUPERVISED
    rcac_trouble troubles[RCAC_TROUBLES];
    int64_t unapplied; /* steps in a row */
    rcac_real worst_growth;
#if RCAC_ELLIPSOID
    rcac_real worst_radius; /* the largest share of the ellipsoid's radius at a look */
#endif
    rcac_real good[RCAC_L_THETA]; /* theta of the last look at which P was not wound up */
    rcac_real z[RCAC_L_Z];        /* of the last step */
    rcac_real held[RCAC_L_U];     /* u of the last step as it was applied */
    int32_t wound_up, heard, noted;
#endif
} rcac_state;

/* theta(0), P(0) and no past. */
void rcac_init(rcac_state *s);

/* One step: y(k) with RCAC_L_Y entries, z(k) with RCAC_L_Z, r(k) with RCAC_L_R; u(k) is written, with
 * RCAC_L_U. What has no entries may be NULL.
 *
 * With RCAC_SUPERVISED a sample that is missed (NaN, infinite or NULL) does not stop anything: k moves on,
 * u is held where y or r is not known, theta waits where z is not, and in the regressor stands what was
 * known last. Every 16 steps it looks at P and keeps theta. */
int rcac_step(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r, rcac_real *u);

/* The same in two halves, so that u(k) goes out before the update is computed. Where
 * RCAC_MEASURES_FIRST is 0, y and r of rcac_control may be NULL: u(k) uses neither. u_applied is what
 * the actuator made of u(k), or NULL where it applied it. */
int rcac_control(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r, rcac_real *u);
int rcac_adapt(rcac_state *s, const rcac_real *y, const rcac_real *z, const rcac_real *r,
               const rcac_real *u_applied);

/* What the actuator made of the last step's u, known only now; before the next step, and where the
 * target model is strictly proper. */
int rcac_correct(rcac_state *s, const rcac_real *u_applied);

void rcac_freeze(rcac_state *s, int frozen);
int rcac_reset_covariance(rcac_state *s);
int rcac_set_lambda(rcac_state *s, rcac_real lambda);

/* Another target model from the next step on, as if it had filtered what is remembered; row-major
 * coefficients of q^0, q^-1, ... q^-order with denominator[0] = I. RCAC_LIVE only. */
enum { RCAC_KEEP = 0, RCAC_RESET = 1, RCAC_BLEND = 2 }; /* what becomes of P */
int rcac_set_target(rcac_state *s, const rcac_real *numerator, const rcac_real *denominator,
                    int order, int past);

/* The state as bytes, with what tells whether they are whole and of these settings. */
#define RCAC_SAVED_SIZE (sizeof(rcac_state) + 8)
void rcac_save(const rcac_state *s, unsigned char *bytes);
int rcac_restore(rcac_state *s, const unsigned char *bytes); /* RCAC_REFUSED: nothing moved */

/* RCAC_OK or RCAC_DIVERGED, and what a supervised controller noted in the last step; what it has noted since
 * rcac_init is s->troubles. */
int rcac_status(const rcac_state *s);
int64_t rcac_guard_count(const rcac_state *s);
/* The share of its ellipsoid's radius that theta uses, at most 1; 0 where theta is kept in none. */
rcac_real rcac_radius(const rcac_state *s);

/* 0 where the compiler rounds as the language says; else bits: 1 sums are reordered, 2 products are
 * contracted, 4 NaN is not told from numbers, 8 numbers have more digits than their type, 16 what is
 * below the normal numbers is flushed to zero. */
int rcac_self_check(void);

#ifdef __cplusplus
}
#endif
#endif
