/* A closed loop for a page: the core whose tables the page writes, around a linear plant of one input.
 *
 * The sums run in the order of the kernel's plant, so that float64 gives the bits of `simulate` under the
 * instruction set "plain". */
#include "rcac.c"
#include "rcac_wasm.c"

#ifndef EXPLORER_STEPS
#define EXPLORER_STEPS 5000
#endif
#define STATES 32    /* of the plant, at most */
#define CHANNELS 3   /* of the exogenous input, at most */
#define WIDTH (STATES + 1 + CHANNELS)

static double rows[(STATES + 2) * WIDTH]; /* [A B D_1; C D_0 D_2; E_1 E_2 E_0], n + 1 + l_w wide */
static double w[EXPLORER_STEPS * CHANNELS], u_of[EXPLORER_STEPS], z_of[EXPLORER_STEPS];
static double y_of[EXPLORER_STEPS], theta_of[(EXPLORER_STEPS + 1) * RCAC_L_THETA];

EXPORT(plant_rows) double *plant_rows(void) { return rows; }
EXPORT(exogenous) double *exogenous(void) { return w; }
EXPORT(recorded) double *recorded(int which) {
    return which == 0 ? z_of : which == 1 ? u_of : which == 2 ? y_of : theta_of;
}
EXPORT(table) rcac_real *table(int which) {
    return which == 0   ? rcac_D_0
           : which == 1 ? rcac_numerators
           : which == 2 ? rcac_denominators
           : which == 3 ? rcac_lambda
                        : rcac_theta_0;
}
#if RCAC_ELLIPSOID
static double radius_of[EXPLORER_STEPS + 1];
static unsigned char is_moved[EXPLORER_STEPS + 1]; /* theta of a step is projected */
EXPORT(ellipsoid) rcac_real *ellipsoid(int which) {
    return which == 0 ? rcac_center : which == 1 ? rcac_inverse : rcac_radii;
}
EXPORT(moved) unsigned char *moved(void) { return is_moved; }
/* The share of the radius of each theta in the record, whichever module made it. */
EXPORT(radii) double *radii(int count) {
    int k, i;
    for (k = 0; k < count; ++k) {
        for (i = 0; i < RCAC_L_THETA; ++i) s.theta[i] = theta_of[k * RCAC_L_THETA + i];
        radius_of[k] = rcac_radius(&s);
    }
    return radius_of;
}
#endif
static double bound; /* of abs(u) as it is applied; infinite where nothing saturates */
EXPORT(saturate_at) void saturate_at(double largest) { bound = largest; }
EXPORT(start_at) void start_at(int k_w) { rcac_K_W = rcac_K_UPDATE = k_w; }
EXPORT(room) int room(int which) { /* for steps, states, the order of the target model */
    return which == 0 ? EXPLORER_STEPS : which == 1 ? STATES : RCAC_ORDER;
}

static int is_within(const double *values, int count, double limit) {
    int i, all = 1;
    for (i = 0; i < count; ++i) all &= magnitude(values[i]) <= limit;
    return all;
}

static void products(const double *row, int count, int width, const double *input, double *out) {
    int i, j;
    for (i = 0; i < count; ++i, row += width) {
        double sum = 0;
        for (j = 0; j < width; ++j) sum += row[j] * input[j];
        out[i] = sum;
    }
}

/* A run from rest, and how many steps it made: where that is less than `steps`, the step of that number left
 * the limit, and what was recorded of it stands behind the others; theta is then that of its beginning. */
EXPORT(run) int run(int steps, int n, int l_w, double limit) {
    double input[WIDTH], next[STATES], applied[1];
    const int width = n + 1 + l_w;
    int k, i;
    for (i = 0; i < WIDTH; ++i) input[i] = 0;
    rcac_init(&s);
    for (k = 0; k < steps; ++k) {
        int status;
        for (i = 0; i < RCAC_L_THETA; ++i) theta_of[k * RCAC_L_THETA + i] = s.theta[i];
        for (i = 0; i < l_w; ++i) input[n + 1 + i] = w[k * l_w + i];
        status = rcac_control(&s, NULL, NULL, NULL, u_);
        u_of[k] = u_[0];
        applied[0] = u_[0] > bound ? bound : u_[0] < -bound ? -bound : u_[0];
        input[n] = applied[0];
        products(rows + n * width, 1, width, input, y_);
        products(rows + (n + 1) * width, 1, width, input, z_);
        y_of[k] = y_[0];
        z_of[k] = z_[0];
        if (!is_within(u_, 1, limit) || !is_within(y_, 1, limit) || !is_within(z_, 1, limit)) break;
        status |= rcac_adapt(&s, y_, z_, NULL, applied);
#if RCAC_ELLIPSOID
        is_moved[k + 1] = (status & RCAC_BOUNDED) != 0;
#endif
        if (status & RCAC_DIVERGED || !is_within(s.theta, RCAC_L_THETA, limit)) break;
        products(rows, n, width, input, next);
        for (i = 0; i < n; ++i) input[i] = next[i];
        if (!is_within(input, n, limit)) break;
    }
    for (i = 0; k == steps && i < RCAC_L_THETA; ++i) theta_of[k * RCAC_L_THETA + i] = s.theta[i];
    return k;
}
