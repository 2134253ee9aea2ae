/* Headers, constants and comparisons that straight-line statements need. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#define inf INFINITY
#define nan NAN

static inline double less(double a, double b) { return a < b; }
static inline double less_equal(double a, double b) { return a <= b; }
static inline double equal(double a, double b) { return a == b; }
static inline double unequal(double a, double b) { return a != b; }
static inline double both(double a, double b) { return a != 0.0 && b != 0.0; }
static inline double either(double a, double b) { return a != 0.0 || b != 0.0; }
static inline double negation(double a) { return a == 0.0; }
static inline double if_else_zero(double a, double b) { return a != 0.0 ? b : 0.0; }
static inline double sign(double a) { return (a > 0.0) - (a < 0.0); }
