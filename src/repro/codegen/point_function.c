/* A function at many points: statements over lanes, one point per lane. */

void at_points(const double *const *given, int64_t points, double *result) {
  ${constants}
  for (int64_t s = 0; s < points; s += LANES) {
    vec ${arrays}out[${outputs}];
    for (int l = 0; l < LANES; l++) {
      const int64_t at = s + l < points ? s + l : s;
      ${load}
    }
    vec ${work};
${statements}
    for (int l = 0; l < LANES && s + l < points; l++)
      for (int p = 0; p < ${outputs}; p++) result[(s + l) * ${outputs} + p] = out[p][l];
  }
}
