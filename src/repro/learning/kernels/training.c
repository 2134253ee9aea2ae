/* All tasks together: loss and gradient, and an epoch of Adam (Kingma and Ba 2015). */

#include <stdlib.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

static void gradients(const real **data, const int64_t *counts, const int32_t *order, int64_t batch,
                      const real *parameters, real *total) {
  for (int p = 0; p < ${outputs}; p++) total[p] = 0;
${calls}
}

void loss_and_gradient(const real **data, const int64_t *counts, const real *parameters, real *total) {
  gradients(data, counts, 0, counts[0], parameters, total);
}

double adam_epoch(const real **data, const int64_t *counts, const int32_t *order, int64_t batch,
                  const double *rates, double beta_1, double beta_2, double epsilon, const real *l1,
                  real *parameters, real *first, real *second) {
  real *total = malloc(${outputs} * sizeof(real));
  double loss = 0;
  int64_t step = 0;
#ifdef __SSE__
  /* in single precision numbers below 1e-38 are many, slow, and nothing beside the others */
  const unsigned before = _mm_getcsr();
  if (sizeof(real) == 4) _mm_setcsr(before | 0x8040);
#endif
  for (int64_t start = 0; start < counts[0]; start += batch, step++) {
    int64_t size = counts[0] - start < batch ? counts[0] - start : batch;
    gradients(data, counts, order + start, size, parameters, total);
    for (int p = 0; p < ${n_parameters}; p++) total[0] += l1[p] * fabs(parameters[p]);
    loss += total[0] * size / counts[0];
    for (int p = 0; p < ${n_parameters}; p++) {
      real g = total[1 + p] + l1[p] * ((parameters[p] > 0) - (parameters[p] < 0));
      first[p] = beta_1 * first[p] + (1 - beta_1) * g;
      second[p] = beta_2 * second[p] + (1 - beta_2) * g * g;
      parameters[p] -= rates[step] * first[p] / (sqrt(second[p]) + epsilon);
    }
  }
#ifdef __SSE__
  _mm_setcsr(before);
#endif
  free(total);
  return loss;
}
