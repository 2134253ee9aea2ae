/* A function of vectors evaluated at many points, one point per lane. */

void evaluate(const double *points, int64_t count, const double *parameters, double *result) {
  for (int64_t s = 0; s < count; s += LANES) {
    vec x[${inputs}], out[${outputs}];
    for (int l = 0; l < LANES; l++) {
      const double *row = points + ${inputs} * (s + l < count ? s + l : s);
      for (int i = 0; i < ${inputs}; i++) x[i][l] = row[i];
    }
    function(x, parameters, out);
    for (int l = 0; l < LANES && s + l < count; l++)
      for (int p = 0; p < ${outputs}; p++) result[(s + l) * ${outputs} + p] = out[p][l];
  }
}
