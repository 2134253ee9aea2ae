/* Loss and gradient of a network inside any physics in C: jets forward, physics of the outputs, and back.

   A jet is the value and the tangents along some coordinates, QUANTITIES in all. Constants: INPUTS, LAYERS, WIDTHS,
   OUTPUTS, SKIP (a linear path from input to output), START (of the network's weights among the parameters), MEASURED (of
   a sample beside its jets), OWN (parameters outside the network).

   Before it stand `physics_k` for every task: loss and cotangents of the outputs from a sample's columns. */

static const int64_t sizes[LAYERS + 2] = {INPUTS, WIDTHS, OUTPUTS};

typedef void Physics(const vec *columns, const vec *outputs, const double *parameters, double factor, vec *cotangents,
                     double *total);

typedef struct {
  vec *before, *after, *slope, *cotangents;
  Weights own;
} Layer;

static void load_block(const double *data, const int32_t *order, int64_t first, int64_t count, vec *jets,
                       vec *columns) {
  const int64_t size = INPUTS * QUANTITIES + MEASURED;
  double *jet = (double *)jets, *column = (double *)columns;
  for (int s = 0; s < BLOCK; s++) {
    const int64_t at = first + s < count ? first + s : first;
    const double *sample = data + size * (order ? order[at] : at);
    if (order && first + s + BLOCK < count)
      for (int64_t k = 0; k < size; k += 8) __builtin_prefetch(data + size * order[first + s + BLOCK] + k, 0, 2);
    for (int k = 0; k < INPUTS * QUANTITIES; k++) jet[k * BLOCK + s] = sample[k];
    for (int k = 0; k < MEASURED; k++) column[k * BLOCK + s] = sample[INPUTS * QUANTITIES + k];
    if (first + s >= count) column[(MEASURED - 1) * BLOCK + s] = 0; /* the weight */
  }
}

static void forward(Layer *layers) {
  for (int l = 1; l <= LAYERS + 1; l++) {
    Layer *layer = layers + l;
    product(sizes[l], sizes[l - 1], layer->own.weight, layers[l - 1].after, layer->before);
    for (int64_t u = 0; u < sizes[l]; u++) {
      vec *before = layer->before + u * UNIT, *after = layer->after + u * UNIT, *first = layer->slope + u * VECTORS;
      for (int v = 0; v < VECTORS; v++) after[v] = before[v] += layer->own.bias[u];
      if (l <= LAYERS) curve((double *)after, (double *)first, 1);
      for (int v = VECTORS; v < UNIT; v++) after[v] = l <= LAYERS ? first[v % VECTORS] * before[v] : before[v];
    }
  }
}

static void backward(Layer *layers) {
  for (int l = LAYERS + 1; l >= 1; l--) {
    Layer *layer = layers + l;
    for (int64_t u = 0; u < sizes[l]; u++) {
      const vec *before = layer->before + u * UNIT, *after = layer->after + u * UNIT;
      vec *cotangent = layer->cotangents + u * UNIT, sum = {0};
      for (int v = 0; v < VECTORS; v++) {
        if (l <= LAYERS) {
          const vec first = layer->slope[u * VECTORS + v];
          vec bend = {0};
          for (int k = v + VECTORS; k < UNIT; k += VECTORS) {
            bend += cotangent[k] * before[k];
            cotangent[k] *= first;
          }
          cotangent[v] = first * (cotangent[v] + SECOND(after[v], first) * bend);
        }
        sum += cotangent[v];
      }
      layer->own.bias_total[u] += lanes_sum(sum);
    }
    outer_products(sizes[l], sizes[l - 1], layer->cotangents, layers[l - 1].after, 0, 0, layer->own.weight_total);
    if (l > 1) product(sizes[l - 1], sizes[l], layer->own.transposed, layer->cotangents, layers[l - 1].cotangents);
  }
}

static void jets_gradient(const double *data, const int32_t *order, int64_t count, double factor,
                          const double *parameters, double *total, Physics *physics) {
  int64_t units = 0, entries = 0;
  for (int l = 0; l <= LAYERS + 1; l++) units += sizes[l];
  for (int l = 1; l <= LAYERS + 1; l++) entries += sizes[l - 1] * sizes[l] / LANES + 1;
  const int64_t vectors = units * (3 * UNIT + VECTORS) + entries + MEASURED * VECTORS + OUTPUTS * UNIT;
  vec *allocated = aligned_alloc(sizeof(vec), vectors * sizeof(vec)), *memory = allocated;
  Layer layers[LAYERS + 2];
  const double *weights = parameters + START;
  for (int l = 0; l <= LAYERS + 1; l++) {
    Layer *layer = layers + l;
    const int64_t n = sizes[l], inner = l ? sizes[l - 1] : 0;
    layer->before = take(&memory, n * UNIT);
    layer->after = take(&memory, n * UNIT);
    layer->cotangents = take(&memory, n * UNIT);
    layer->slope = take(&memory, n * VECTORS);
    if (l) layer->own = take_weights(n, inner, &weights, parameters, total, &memory);
  }
  Layer *last = layers + LAYERS + 1;
  vec *columns = take(&memory, MEASURED * VECTORS), *skipped = take(&memory, OUTPUTS * UNIT);
  for (int64_t first = 0; first < count; first += BLOCK) {
    load_block(data, order, first, count, layers[0].after, columns);
    forward(layers);
    if (SKIP) {
      product(OUTPUTS, INPUTS, weights, layers[0].after, skipped);
      for (int64_t k = 0; k < OUTPUTS * UNIT; k++) last->after[k] += skipped[k];
    }
    physics(columns, last->after, parameters, factor, last->cotangents, total);
    if (SKIP)
      outer_products(OUTPUTS, INPUTS, last->cotangents, layers[0].after, 0, 0, total + 1 + (weights - parameters));
    backward(layers);
  }
  free(allocated);
}
