/* How the controller is called, with a plant in the place of the converters:
 * x(k+1) = 0.9 x(k) + 0.1 u(k) + w(k), y = z = x, w a pulse every 7 steps. It logs what `rcac check` reads. */
#include <stdio.h>

#include "rcac.h"

int main(void) {
    static rcac_state s;
    rcac_real x = 0, y[RCAC_L_Y + 1], z[RCAC_L_Z], r[RCAC_L_R + 1], u[RCAC_L_U];
    rcac_real theta[RCAC_L_THETA]; /* a row holds the one that made its u */
    int k, i;
    if (rcac_self_check() & ~16) return 2;
    rcac_init(&s);
    printf("k");
    for (i = 0; i < RCAC_L_U; ++i) printf(",u[%d]", i);
    for (i = 0; i < RCAC_L_Y; ++i) printf(",y[%d]", i);
    for (i = 0; i < RCAC_L_Z; ++i) printf(",z[%d]", i);
    for (i = 0; i < RCAC_L_THETA; ++i) printf(",theta[%d]", i);
    printf("\n");
    for (k = 0; k < 200; ++k) {
        int status;
        for (i = 0; i < RCAC_L_Y; ++i) y[i] = x;
        for (i = 0; i < RCAC_L_Z; ++i) z[i] = x;
        for (i = 0; i < RCAC_L_R; ++i) r[i] = 0;
        for (i = 0; i < RCAC_L_THETA; ++i) theta[i] = s.theta[i];
        printf("%d", k);
        status = rcac_step(&s, y, z, r, u);
        if (status & RCAC_DIVERGED) return 1;
        for (i = 0; i < RCAC_L_U; ++i) printf(",%.17g", (double)u[i]);
        for (i = 0; i < RCAC_L_Y; ++i) printf(",%.17g", (double)y[i]);
        for (i = 0; i < RCAC_L_Z; ++i) printf(",%.17g", (double)z[i]);
        for (i = 0; i < RCAC_L_THETA; ++i) printf(",%.17g", (double)theta[i]);
        printf("\n");
        x = (rcac_real)0.9 * x + (rcac_real)0.1 * u[0] + (rcac_real)(k % 7 == 0);
    }
    return 0;
}
