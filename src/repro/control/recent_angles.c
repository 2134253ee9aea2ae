/* Sines and cosines of recent angles: rates, their Jacobian, their Hessian and the costs of one point need the same. */

#include <string.h>

#define RECENT 1024 /* a double pendulum over 40 intervals has 140 vectors of angles at one point */

typedef int64_t bits __attribute__((vector_size(8 * LANES)));
typedef struct { vec angle, sine, cosine; int64_t filled; } Recent;
static _Thread_local Recent recent[RECENT];

static __attribute__((noinline)) const Recent *turned(vec angle) {
    const bits all = (bits)angle;
    const uint64_t mixed = ((uint64_t)all[0] * 31 + (uint64_t)all[LANES - 1]) * 0x9E3779B97F4A7C15u;
    Recent *at = recent + (mixed >> 40 & (RECENT - 1));
    const bits differing = (bits)at->angle ^ all;
    int64_t other = !at->filled;
    for (int l = 0; l < LANES; l++) other |= differing[l];
    if (other) {
        for (int l = 0; l < LANES; l++) at->sine[l] = sin(angle[l]), at->cosine[l] = cos(angle[l]);
        at->angle = angle;
        at->filled = 1;
    }
    return at;
}

/* Followed by a branch that no optimisation removes, as a loop over lanes has one: a compiler contracts products and
   sums between branches only, so that they round as they do where such loops stand. */
static volatile int never;
static inline vec recent_sin(vec angle) {
    const Recent *at = turned(angle);
    if (never) __builtin_trap();
    return at->sine;
}
static inline vec recent_cos(vec angle) {
    const Recent *at = turned(angle);
    if (never) __builtin_trap();
    return at->cosine;
}
#define v_sin recent_sin
#define v_cos recent_cos
