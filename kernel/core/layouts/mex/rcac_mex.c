/* A gateway for MATLAB and Octave; the state is a column of bytes that the caller keeps.
 *   s = rcac_mex();                         theta(0), P(0) and no past
 *   [u, s, theta, status] = rcac_mex(s, y, z, r);
 * Build: mkoctfile --mex -Isrc mex/rcac_mex.c src/rcac.c, or mex with the same arguments. */
#include <string.h>

#include "mex.h"
#include "rcac.h"

static void take(const mxArray *from, rcac_real *to, size_t count, const char *name) {
    size_t i;
    if (!from || !mxIsDouble(from) || mxIsComplex(from) || mxGetNumberOfElements(from) != count)
        mexErrMsgIdAndTxt("rcac:size", "%s: %d real numbers are needed.", name, (int)count);
    for (i = 0; i < count; ++i) to[i] = (rcac_real)mxGetPr(from)[i];
}

static mxArray *column(const rcac_real *values, size_t count) {
    mxArray *out = mxCreateDoubleMatrix(count, 1, mxREAL);
    size_t i;
    for (i = 0; i < count; ++i) mxGetPr(out)[i] = (double)values[i];
    return out;
}

static mxArray *saved(const rcac_state *s) {
    mxArray *out = mxCreateNumericMatrix(RCAC_SAVED_SIZE, 1, mxUINT8_CLASS, mxREAL);
    rcac_save(s, (unsigned char *)mxGetData(out));
    return out;
}

void mexFunction(int outputs, mxArray *out[], int inputs, const mxArray *in[]) {
    rcac_state s;
    rcac_real y[RCAC_L_Y + 1], z[RCAC_L_Z], r[RCAC_L_R + 1], u[RCAC_L_U];
    int status;
    if (rcac_self_check() & ~16) mexErrMsgIdAndTxt("rcac:compiler", "compiled with fast math.");
    if (inputs == 0) {
        rcac_init(&s);
        out[0] = saved(&s);
        return;
    }
    if (inputs < 3) mexErrMsgIdAndTxt("rcac:arguments", "s, y and z are needed, and r where there is one.");
    if (!mxIsUint8(in[0]) || mxGetNumberOfElements(in[0]) != RCAC_SAVED_SIZE ||
        rcac_restore(&s, (const unsigned char *)mxGetData(in[0])) != RCAC_OK)
        mexErrMsgIdAndTxt("rcac:state", "s is not the state of this controller.");
    take(in[1], y, RCAC_L_Y, "y");
    take(in[2], z, RCAC_L_Z, "z");
    if (RCAC_L_R) take(inputs > 3 ? in[3] : NULL, r, RCAC_L_R, "r");
    status = rcac_step(&s, y, z, r, u);
    out[0] = column(u, RCAC_L_U);
    if (outputs > 1) out[1] = saved(&s);
    if (outputs > 2) out[2] = column(s.theta, RCAC_L_THETA);
    if (outputs > 3) out[3] = mxCreateDoubleScalar(status);
}
