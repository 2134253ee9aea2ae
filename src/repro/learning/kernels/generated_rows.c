/* Residual rows of one task and their Jacobian. */

void rows_${number}(const double *data, int64_t count, const double *parameters, double *result) {
  for (int64_t s = 0; s < count; s += LANES) {
    vec ${arrays}, out[${outputs}];
    for (int l = 0; l < LANES; l++) {
      const double *row = data + ${columns} * (s + l < count ? s + l : s);
      ${load}
    }
    vec ${work};
${statements}
    for (int l = 0; l < LANES && s + l < count; l++)
      for (int p = 0; p < ${outputs}; p++) result[(s + l) * ${outputs} + p] = out[p][l];
  }
}
