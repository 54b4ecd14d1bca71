/* One controller for a page: numbers are written to and read from the memory at these addresses. */
#include <stddef.h>

#include "rcac.h"

#define EXPORT(name) __attribute__((export_name(#name)))

static rcac_state s;
static rcac_real y_[RCAC_L_Y + 1], z_[RCAC_L_Z], r_[RCAC_L_R + 1], u_[RCAC_L_U];
static unsigned char saved[RCAC_SAVED_SIZE];

EXPORT(y) rcac_real *y(void) { return y_; }
EXPORT(z) rcac_real *z(void) { return z_; }
EXPORT(r) rcac_real *r(void) { return r_; }
EXPORT(u) rcac_real *u(void) { return u_; }
EXPORT(theta) rcac_real *theta(void) { return s.theta; }
EXPORT(size) int size(int which) { /* of y, z, r, u, theta and a number */
    static const int sizes[6] = {RCAC_L_Y, RCAC_L_Z, RCAC_L_R, RCAC_L_U, RCAC_L_THETA, sizeof(rcac_real)};
    return which >= 0 && which < 6 ? sizes[which] : 0;
}
EXPORT(init) void init(void) { rcac_init(&s); }
EXPORT(step) int step(void) { return rcac_step(&s, y_, z_, r_, u_); }
EXPORT(freeze) void freeze(int frozen) { rcac_freeze(&s, frozen); }
EXPORT(save) void save(void) { rcac_save(&s, saved); }
EXPORT(restore) int restore(void) { return rcac_restore(&s, saved); }
EXPORT(self_check) int self_check(void) { return rcac_self_check(); }

/* What a compiler calls of its own accord; volatile, or it would make calls of these loops. */
void *memcpy(void *to, const void *from, size_t count) {
    volatile unsigned char *a = (volatile unsigned char *)to;
    const unsigned char *b = (const unsigned char *)from;
    while (count-- > 0) *a++ = *b++;
    return to;
}
void *memset(void *to, int value, size_t count) {
    volatile unsigned char *a = (volatile unsigned char *)to;
    while (count-- > 0) *a++ = (unsigned char)value;
    return to;
}
void *memmove(void *to, const void *from, size_t count) {
    volatile unsigned char *a = (volatile unsigned char *)to;
    const unsigned char *b = (const unsigned char *)from;
    if (a <= b) return memcpy(to, from, count);
    while (count-- > 0) a[count] = b[count];
    return to;
}
