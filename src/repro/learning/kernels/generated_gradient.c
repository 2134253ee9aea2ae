/* Loss and gradient of one task: statements over lanes, one sample per lane. */

static void gradient_${number}(const double *data, const int32_t *order, int64_t count, double factor,
                              const double *parameters, double *total) {
  vec sum[${outputs}] = {0};
  for (int64_t s = 0; s < count; s += LANES) {
    vec columns[STRIDE];
    load_samples(data, order, s, count, columns);
    vec ${arrays};
    vec ${work};
${statements}
  }
  for (int p = 0; p < ${outputs}; p++) {
    double lanes = 0;
    for (int l = 0; l < LANES; l++) lanes += sum[p][l];
    total[p] += factor * lanes;
  }
}
