/* Loss of one task and its cotangents with respect to the outputs of the network. */

static void physics_${number}(const vec *columns, const vec *jets, const double *parameters, double factor,
                             vec *cotangents, double *total) {
  for (int v = 0; v < VECTORS; v++) {
    vec ${arrays}, outputs[OUTPUTS * QUANTITIES], out[1 + OUTPUTS * QUANTITIES + OWN];
    ${load}
    for (int k = 0; k < OUTPUTS * QUANTITIES; k++) outputs[k] = jets[k * VECTORS + v];
    vec ${work};
${statements}
    total[0] += factor * lanes_sum(out[0]);
    for (int k = 0; k < OUTPUTS * QUANTITIES; k++) cotangents[k * VECTORS + v] = factor * out[1 + k];
    for (int k = 0; k < OWN; k++) total[1 + own[k]] += factor * lanes_sum(out[1 + OUTPUTS * QUANTITIES + k]);
  }
}
