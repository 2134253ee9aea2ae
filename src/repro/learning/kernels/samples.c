/* Samples into lanes: rows of STRIDE numbers, whole vectors, become columns with one sample per lane. */

/* samples fetched in advance: their order is random; into the second cache, for which more requests can wait */
#define AHEAD (4 * LANES)
typedef int64_t places __attribute__((vector_size(8 * LANES)));

#define EXCHANGED(j, d, own, other) ((j) & (d) ? LANES + (own) : (other))
#define PLACES(d, own, other) (places){EXCHANGED(0, d, 0 own, 0 other), EXCHANGED(1, d, 1 own, 1 other), \
  EXCHANGED(2, d, 2 own, 2 other), EXCHANGED(3, d, 3 own, 3 other), EXCHANGED(4, d, 4 own, 4 other), \
  EXCHANGED(5, d, 5 own, 5 other), EXCHANGED(6, d, 6 own, 6 other), EXCHANGED(7, d, 7 own, 7 other)}
/* of a matrix of blocks of d, the two off the diagonal change places */
#define EXCHANGE(d) for (int i = 0; i < LANES; i++) if (!(i & d)) { \
    const vec low = rows[i], high = rows[i + d]; \
    rows[i] = __builtin_shuffle(low, high, PLACES(d, - d, )); \
    rows[i + d] = __builtin_shuffle(low, high, PLACES(d, , + d)); }

static inline __attribute__((always_inline)) void load_samples(const double *data, const int32_t *order, int64_t first,
                                                               int64_t count, vec *columns) {
  const double *sample[LANES];
  for (int l = 0; l < LANES; l++) {
    const int64_t at = first + l < count ? first + l : first;
    sample[l] = data + STRIDE * (order ? order[at] : at);
    if (order && first + l + AHEAD < count)
      for (int k = 0; k < STRIDE; k += 8) __builtin_prefetch(data + STRIDE * (int64_t)order[first + l + AHEAD] + k, 0, 2);
  }
  for (int k = 0; k < STRIDE; k += LANES) {
    vec *rows = columns + k;
    for (int l = 0; l < LANES; l++) memcpy(rows + l, sample[l] + k, sizeof(vec));
    EXCHANGE(1)
    EXCHANGE(2)
    EXCHANGE(4)
  }
  for (int64_t l = count - first; l < LANES; l++) columns[WEIGHT][l] = 0;
}
