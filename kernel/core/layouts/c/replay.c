/* Replays the recorded inputs of rcac_vector.h and holds u of every step, and theta at the end, against
 * what was recorded. Ends with 0 where they are the same bits. */
#include <stdio.h>
#include <string.h>

#include "rcac.h"
#include "rcac_vector.h"

/* As the README says, on every machine that aligns 64 bits to 8 bytes. */
typedef char rcac_state_has_its_size[sizeof(rcac_state) == RCAC_STATE_SIZE || sizeof(void *) * 2 == 4 ? 1 : -1];

static rcac_real distance(const rcac_real *a, const rcac_real *b, int count) {
    rcac_real largest = 0;
    int i;
    for (i = 0; i < count; ++i) {
        const rcac_real gap = a[i] < b[i] ? b[i] - a[i] : a[i] - b[i];
        if (!(gap <= largest)) largest = gap;
    }
    return largest;
}

int main(void) {
    rcac_state s;
    rcac_real u[RCAC_L_U], worst_u = 0, worst_theta;
    int k, status, same = 1;
    const int fault = rcac_self_check();
    if (fault & ~16) {
        printf("the compiler does not round as C says (self-check %d): src/rcac.c needs -ffp-contract=off "
               "and no fast math\n", fault);
        return 2;
    }
    rcac_init(&s);
    for (k = 0; k < RCAC_VECTOR_STEPS; ++k) {
        const rcac_real *expected = rcac_vector_u + k * RCAC_L_U;
        rcac_real gap;
        const rcac_real *y = rcac_vector_y + k * RCAC_L_Y, *z = rcac_vector_z + k * RCAC_L_Z;
        const rcac_real *r = rcac_vector_r + k * RCAC_L_R;
        status = rcac_step(&s, y, z, r, u);
        if (status & (RCAC_BAD_INPUT | RCAC_DIVERGED | RCAC_OUT_OF_ORDER | RCAC_MISSED | RCAC_RESTORED)) {
            printf("step %d: status %d\n", k, status);
            return 1;
        }
        same = same && memcmp(u, expected, sizeof u) == 0;
        gap = distance(u, expected, RCAC_L_U);
        if (!(gap <= worst_u)) worst_u = gap;
    }
    worst_theta = distance(s.theta, rcac_vector_theta, RCAC_L_THETA);
    same = same && memcmp(s.theta, rcac_vector_theta, sizeof s.theta) == 0;
    if (same) {
        printf("%d steps: the same bits\n", RCAC_VECTOR_STEPS);
        return 0;
    }
    printf("%d steps: u within %.3g, theta within %.3g; the same bits were expected\n", RCAC_VECTOR_STEPS,
           (double)worst_u, (double)worst_theta);
    return 1;
}
