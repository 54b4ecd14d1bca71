/* The controller as a process: bytes of y, z and r in, bytes of u and the status out, a step at a time.
 * With it the export closes a loop around the compiled code. */
#include <stdint.h>
#include <stdio.h>

#include "rcac.h"

static int take(rcac_real *values, int count) {
    return count == 0 || fread(values, sizeof *values, (size_t)count, stdin) == (size_t)count;
}

static void give(const rcac_real *values, int count) {
    fwrite(values, sizeof *values, (size_t)count, stdout);
    fflush(stdout);
}

int main(void) {
    rcac_state s;
    rcac_real y[RCAC_L_Y + 1], z[RCAC_L_Z], r[RCAC_L_R + 1], u[RCAC_L_U];
    rcac_init(&s);
    for (;;) {
        int32_t status;
        if (RCAC_MEASURES_FIRST && !(take(y, RCAC_L_Y) && take(z, RCAC_L_Z) && take(r, RCAC_L_R))) break;
        status = RCAC_MEASURES_FIRST ? rcac_control(&s, y, z, r, u) : rcac_control(&s, NULL, NULL, NULL, u);
        give(u, RCAC_L_U);
        if (!(take(y, RCAC_L_Y) && take(z, RCAC_L_Z) && take(r, RCAC_L_R))) break;
        status |= rcac_adapt(&s, y, z, r, NULL);
        fwrite(&status, sizeof status, 1, stdout);
        give(s.theta, RCAC_L_THETA);
    }
    return 0;
}
