/* Loss and gradient of one task: statements over lanes, one sample per lane. */

static void gradient_${number}(const double *data, const int64_t *order, int64_t count, double factor,
                              const double *parameters, double *total) {
  vec sum[${outputs}] = {0};
  for (int64_t s = 0; s < count; s += LANES) {
    vec ${arrays};
    for (int l = 0; l < LANES; l++) {
      int64_t inside = s + l < count;
      const double *row = data + ${columns} * (order ? order[inside ? s + l : s] : (inside ? s + l : s));
      if (order && s + l + AHEAD < count)
        for (int k = 0; k < ${columns}; k += 8) __builtin_prefetch(data + ${columns} * order[s + l + AHEAD] + k);
      ${load}
      weight[0][l] *= inside;
    }
    vec ${work};
${statements}
  }
  for (int p = 0; p < ${outputs}; p++) {
    double lanes = 0;
    for (int l = 0; l < LANES; l++) lanes += sum[p][l];
    total[p] += factor * lanes;
  }
}
