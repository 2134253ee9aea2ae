/* Tanh or softplus in C, and its derivatives from the value and the slope. Constant: TANH (otherwise softplus). */

/* a unit's values before the activation, in place -> after it, and the slopes there */
static void curve(real *value, real *first, int wants_value) {
#if TANH
  for (int s = 0; s < BLOCK; s++) value[s] = tanh(value[s]);
  for (int s = 0; s < BLOCK; s++) first[s] = 1 - value[s] * value[s];
#else
  for (int s = 0; s < BLOCK; s++) {
    const real e = exp(-fabs(value[s]));
    first[s] = (value[s] >= 0 ? 1 : e) / (1 + e);
  }
  if (wants_value)
    for (int s = 0; s < BLOCK; s++) value[s] = fmax(value[s], (real)0) + log1p(exp(-fabs(value[s])));
#endif
}

/* second and third derivative over the first, from the value and the slope */
#if TANH
#define SECOND(value, first) (-2 * (value))
#define THIRD(value, first) (6 * (value) * (value) - 2)
#else
#define SECOND(value, first) (1 - (first))
#define THIRD(value, first) ((1 - (first)) * (1 - 2 * (first)))
#endif
