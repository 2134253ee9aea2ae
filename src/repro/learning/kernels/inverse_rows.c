/* Residual rows of a block of samples in C, and their gradients with respect to what the network makes.

   A row is r = a N + b.g + c.gdot + d.beta - y with the network's N, g = DN, gdot = D^2 N[zdot]. Most b, c and d are the
   same for all samples: only the entries that vary are read, the others are 0 or 1. */

#define ROW_SIZE (1 + 2 * INPUTS + POTENTIAL + 1)  /* a, b, c, d, y */

typedef struct {
  int64_t rows, bends;       /* residual rows, and pairs of coordinates whose v = d2z / dqd_c dqd_d is needed */
  int64_t solved;            /* the first rows are M e = -r: their residual is e */
  int64_t valued;            /* some row needs N itself */
  int64_t varying;           /* entries read from a sample, of [weight, rows, bends] */
  const int32_t *places;     /* where they belong */
  const real *fixed;       /* all entries, for those that are not read */
} Form;

static int64_t entries_of(const Form *form) {
  return 1 + form->rows * ROW_SIZE + form->bends * INPUTS;
}

static void load_fixed(const Form *form, vec *entries) {
  for (int64_t k = 0; k < entries_of(form); k++)
    for (int v = 0; v < VECTORS; v++) entries[k * VECTORS + v] = (vec){0} + form->fixed[k];
}

/* samples into lanes; a lane without a sample repeats another one with weight 0 */
static void load_block(const Form *form, const real *data, const int32_t *order, int64_t first, int64_t count,
                       vec *inputs, vec *entries) {
  const int64_t size = 2 * INPUTS + form->varying;
  real *in = (real *)inputs, *entry = (real *)entries;
  for (int s = 0; s < BLOCK; s++) {
    const int64_t at = first + s < count ? first + s : first;
    const real *sample = data + size * (order ? order[at] : at);
    if (order && first + s + BLOCK < count)
      for (int64_t k = 0; k < size; k += 8) __builtin_prefetch(data + size * order[first + s + BLOCK] + k, 0, 2);
    for (int i = 0; i < INPUTS; i++) {
      in[2 * i * BLOCK + s] = sample[i];
      in[(2 * i + 1) * BLOCK + s] = sample[INPUTS + i];
    }
    for (int64_t k = 0; k < form->varying; k++) entry[form->places[k] * BLOCK + s] = sample[2 * INPUTS + k];
  }
  if (first + BLOCK > count)
    for (int64_t s = count - first; s < BLOCK; s++) entry[s] = 0;
}

/* r of every row, (row, sample); slopes: pairs [gdot, g] of the inputs */
static void evaluate_rows(const Form *form, const vec *entries, const vec *slopes, const vec *value,
                          const real *potential, vec *residual) {
  for (int64_t r = 0; r < form->rows; r++)
    for (int v = 0; v < VECTORS; v++) {
      const vec *a = entries + (1 + r * ROW_SIZE) * VECTORS + v, *b = a + VECTORS, *d = b + 2 * INPUTS * VECTORS;
      vec sum = a[0] * value[v] - d[POTENTIAL * VECTORS];
      for (int i = 0; i < INPUTS; i++) {
        sum += b[i * VECTORS] * slopes[i * UNIT + VECTORS + v];
        sum += b[(INPUTS + i) * VECTORS] * slopes[i * UNIT + v];
      }
      for (int k = 0; k < POTENTIAL; k++) sum += potential[k] * d[k * VECTORS];
      residual[r * VECTORS + v] = sum;
    }
}

/* sum lambda r = alpha N + t.g + s.gdot + ...: directions are the pairs [s, t] of the inputs */
static void pull_rows(const Form *form, const vec *entries, const vec *lambda, vec *directions, vec *alpha,
                      real *potential_total) {
  vec potential[POTENTIAL + 1];
  memset(potential, 0, sizeof potential);
  memset(directions, 0, INPUTS * UNIT * sizeof(vec));
  memset(alpha, 0, VECTORS * sizeof(vec));
  for (int64_t r = 0; r < form->rows; r++)
    for (int v = 0; v < VECTORS; v++) {
      const vec *a = entries + (1 + r * ROW_SIZE) * VECTORS + v, *b = a + VECTORS, *d = b + 2 * INPUTS * VECTORS;
      const vec l = lambda[r * VECTORS + v];
      alpha[v] += l * a[0];
      for (int i = 0; i < INPUTS; i++) {
        directions[i * UNIT + VECTORS + v] += l * b[i * VECTORS];
        directions[i * UNIT + v] += l * b[(INPUTS + i) * VECTORS];
      }
      for (int k = 0; k < POTENTIAL; k++) potential[k] += l * d[k * VECTORS];
    }
  for (int k = 0; k < POTENTIAL; k++) potential_total[k] += lanes_sum(potential[k]);
}
