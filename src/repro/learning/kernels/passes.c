/* Loss and gradient of a network's rows in C, at a cost that hardly depends on the number of coordinates.

   Four passes over a block of samples (the reverse of a product with the Hessian, after Pearlmutter 1994):

       1  forward    the value and the tangent along zdot
       2  backward   of the tangent: g = DN and gdot = D^2 N[zdot] at the inputs, hence the rows r
       3  forward    the tangent along s and the second-order term, for S = alpha N + DN[t] + D^2 N[s, zdot], where
                     sum lambda r = S + ..., lambda = 2 r: see `pull_rows`
       4  backward   of S to the weights; half of its cotangents are those of pass 2

   The forward objective adds n_q tangents, forward and backward, between 2 and 3. */

static void network_gradient(const real *data, const int32_t *order, int64_t count, real factor,
                             const real *parameters, real *total, const Form *form) {
  const int64_t along = form->solved ? 2 * PAIRS_OF_COORDINATES * UNIT : 0;
  int64_t units = 0, entries = 0, widest = INPUTS;
  for (int l = 0; l <= LAYERS; l++) units += sizes[l], widest = sizes[l] > widest ? sizes[l] : widest;
  for (int l = 1; l <= LAYERS; l++) entries += sizes[l - 1] * sizes[l] / LANES + 1;
  const int64_t vectors = (6 * UNIT + along) * units + (entries_of(form) + 2 * form->rows) * VECTORS + entries
    + (widest + INPUTS * (1 + PAIRS_OF_COORDINATES)) * UNIT;
  vec *allocated = aligned_alloc(sizeof(vec), vectors * sizeof(vec)), *memory = allocated;
  Layer layers[LAYERS + 1];
  const real *weights = parameters;
  for (int l = 0; l <= LAYERS; l++) {
    Layer *layer = layers + l;
    const int64_t n = sizes[l], inner = l ? sizes[l - 1] : 0;
    layer->values = take(&memory, n * UNIT);
    layer->slope = take(&memory, n * UNIT);
    layer->backward = take(&memory, n * UNIT);
    layer->before = take(&memory, n * UNIT);
    layer->seconds = take(&memory, n * UNIT);
    layer->cotangents = take(&memory, n * UNIT);
    layer->along = take(&memory, n * along / 2);
    layer->along_back = take(&memory, n * along / 2);
    if (l) layer->own = take_weights(n, inner, &weights, parameters, total, &memory);
  }
  Layer *last = layers + LAYERS;
  const int64_t width = sizes[LAYERS];
  const real *out_weight = weights, *potential = weights + width + 1;
  real *out_total = total + 1 + (weights - parameters);
  vec *row_entries = take(&memory, entries_of(form) * VECTORS), value[VECTORS], alpha[VECTORS];
  vec *residual = take(&memory, form->rows * VECTORS), *lambda = take(&memory, form->rows * VECTORS);
  vec *scratch = take(&memory, widest * UNIT), *inputs = take(&memory, INPUTS * UNIT), *slopes = memory;

  load_fixed(form, row_entries);
  for (int64_t first = 0; first < count; first += BLOCK) {
    if (first + BLOCK > count) load_fixed(form, row_entries);
    load_block(form, data, order, first, count, layers[0].values, row_entries);
    for (int l = 1; l <= LAYERS; l++) {
      product(sizes[l], sizes[l - 1], layers[l].own.weight, layers[l - 1].values, layers[l].values);
      for (int64_t u = 0; u < sizes[l]; u++)
        for (int v = 0; v < VECTORS; v++) layers[l].values[u * UNIT + v] += layers[l].own.bias[u];
      activate(sizes[l], layers[l].values, layers[l].slope, form->valued || l < LAYERS);
    }
    for (int v = 0; v < VECTORS; v++) {
      value[v] = (vec){0} + out_weight[width];
      for (int64_t u = 0; form->valued && u < width; u++) value[v] += out_weight[u] * last->values[u * UNIT + v];
    }
    for (int64_t u = 0; u < width; u++)
      for (int v = 0; v < VECTORS; v++) {
        last->backward[u * UNIT + v] = (vec){0};
        last->backward[u * UNIT + VECTORS + v] = (vec){0} + out_weight[u];
      }
    for (int l = LAYERS; l >= 1; l--) {
      activate_backward(layers + l, sizes[l]);
      product(sizes[l - 1], sizes[l], layers[l].own.transposed, layers[l].backward, layers[l - 1].backward);
    }
    evaluate_rows(form, row_entries, layers[0].backward, value, potential, residual);
    for (int64_t r = 0; r < form->rows * VECTORS; r++) lambda[r] = 2 * residual[r];
    if (form->solved) {
      coordinate_tangents(layers, row_entries, inputs, scratch, slopes);
      solve_rows(form, row_entries, layers[0].backward, slopes, residual, lambda);
      move_to_own_acceleration(layers, row_entries, residual);
    }
    vec loss = {0};
    for (int64_t r = 0; r < form->rows; r++)
      for (int v = 0; v < VECTORS; v++) {
        loss += row_entries[v] * residual[r * VECTORS + v] * residual[r * VECTORS + v];
        lambda[r * VECTORS + v] *= factor * row_entries[v];
      }
    total[0] += factor * lanes_sum(loss);
    pull_rows(form, row_entries, lambda, layers[0].seconds, alpha, total + 1 + (potential - parameters));
    if (form->solved) pull_bends(form, row_entries, lambda, residual, layers[0].seconds);
    for (int l = 1; l <= LAYERS; l++) {
      product(sizes[l], sizes[l - 1], layers[l].own.weight, layers[l - 1].seconds, layers[l].before);
      activate_seconds(layers + l, sizes[l]);
    }
    for (int64_t u = 0; u < width; u++) {
      vec sum = {0};
      for (int v = 0; v < VECTORS; v++) {
        sum += last->seconds[u * UNIT + VECTORS + v];
        if (form->valued) sum += alpha[v] * last->values[u * UNIT + v];
        last->cotangents[u * UNIT + v] = alpha[v] * out_weight[u];
        last->cotangents[u * UNIT + VECTORS + v] = (vec){0};
      }
      out_total[u] += lanes_sum(sum);
    }
    for (int v = 0; v < VECTORS; v++) out_total[width] += lanes_sum(alpha[v]);
    for (int l = LAYERS; l >= 1; l--) {
      activate_seconds_backward(layers + l, sizes[l]);
      outer_products(sizes[l], sizes[l - 1], layers[l].cotangents, layers[l - 1].values, layers[l].backward,
                     layers[l - 1].seconds, layers[l].own.weight_total);
      if (l > 1)
        product(sizes[l - 1], sizes[l], layers[l].own.transposed, layers[l].cotangents, layers[l - 1].cotangents);
    }
  }
  free(allocated);
}
