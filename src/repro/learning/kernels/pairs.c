/* Layers of the network's passes in C: every array holds two quantities, forwards and backwards through the activation.

   Constants: LAYERS, INPUTS, WIDTHS. */

static const int64_t sizes[LAYERS + 1] = {INPUTS, WIDTHS};

typedef struct {
  vec *values;       /* after the activation: value, tangent along zdot */
  vec *slope;        /* first derivative of the activation, and the tangent before it */
  vec *backward;     /* cotangents before the activation: of the tangent along s, of the second-order term */
  vec *before;       /* before the activation: tangent along s, second-order term */
  vec *seconds;      /* after it */
  vec *cotangents;   /* before the activation: of the value, of the tangent along zdot */
  vec *along;        /* forward rows: before the activation, the tangents along u_1, u_2, ... two by two */
  vec *along_back;   /* and what `backward` would be for each of them */
  Weights own;
} Layer;

/* value and tangent before the activation, in place -> after it; its slope and the tangent before it are kept */
static void activate(int64_t units, vec *values, vec *slope, int wants_value) {
  for (int64_t u = 0; u < units; u++) {
    vec *value = values + u * UNIT, *first = slope + u * UNIT;
    curve((real *)value, (real *)first, wants_value);
    for (int v = 0; v < VECTORS; v++) {
      first[VECTORS + v] = value[VECTORS + v];
      value[VECTORS + v] *= first[v];
    }
  }
}

/* cotangents after the activation [of the tangent along s, of the second-order term], in place -> before it */
static void activate_backward(const Layer *layer, int64_t units) {
  for (int64_t u = 0; u < units; u++) {
    const vec *value = layer->values + u * UNIT, *slope = layer->slope + u * UNIT;
    vec *cotangent = layer->backward + u * UNIT;
    for (int v = 0; v < VECTORS; v++) {
      const vec first = slope[v], after = cotangent[VECTORS + v];
      cotangent[v] = first * (cotangent[v] + SECOND(value[v], first) * slope[VECTORS + v] * after);
      cotangent[VECTORS + v] = first * after;
    }
  }
}

static void activate_seconds(const Layer *layer, int64_t units) {
  for (int64_t u = 0; u < units; u++) {
    const vec *value = layer->values + u * UNIT, *slope = layer->slope + u * UNIT, *before = layer->before + u * UNIT;
    vec *after = layer->seconds + u * UNIT;
    for (int v = 0; v < VECTORS; v++) {
      const vec first = slope[v];
      after[v] = first * before[v];
      after[VECTORS + v] = first * (before[VECTORS + v] + SECOND(value[v], first) * slope[VECTORS + v] * before[v]);
    }
  }
}

/* cotangents after the activation [of the value, of the tangent along zdot], in place -> before it */
static void activate_seconds_backward(const Layer *layer, int64_t units) {
  for (int64_t u = 0; u < units; u++) {
    const vec *value = layer->values + u * UNIT, *slope = layer->slope + u * UNIT, *before = layer->before + u * UNIT;
    const vec *backward = layer->backward + u * UNIT;
    vec *cotangent = layer->cotangents + u * UNIT;
    real total = 0;
    for (int v = 0; v < VECTORS; v++) {
      const vec first = slope[v], tangent = slope[VECTORS + v], along = before[v];
      const vec second = SECOND(value[v], first), third = THIRD(value[v], first), p = backward[VECTORS + v];
      /* backward holds the cotangents before the activation, first (cot_s + second tangent cot_p) and first cot_p */
      const vec s = backward[v] - second * tangent * p;
      cotangent[v] = first * cotangent[v]
        + second * (first * cotangent[VECTORS + v] * tangent + s * along + p * before[VECTORS + v])
        + third * tangent * along * p;
      cotangent[VECTORS + v] = first * cotangent[VECTORS + v] + second * along * p;
    }
    for (int v = 0; v < VECTORS; v++) total += lanes_sum(cotangent[v]);
    layer->own.bias_total[u] += total;
  }
}
