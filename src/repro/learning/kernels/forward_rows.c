/* The forward objective in C: n_q more products with vectors, and the gradient of the inverse rows.

   With M e = tau - tau_hat the error of the acceleration is e, and d(e'e) = 2 e'de with de = -M^-1 d(tau_hat at qdd + e):
   the gradient is that of the inverse rows at the model's own acceleration, for lambda = -2 M^-1 e. */

#define UPPER(c, d) ((c) * COORDINATES - (c) * ((c) - 1) / 2 + (d) - (c)) /* of a symmetric matrix, c <= d */
#define PAIRS_OF_COORDINATES ((COORDINATES + 1) / 2)

static const vec *row_curvature(const vec *entries, int64_t row) {
  return entries + (1 + row * ROW_SIZE + 1 + INPUTS) * VECTORS;
}

/* the tangents along every u_c through all layers and back, two by two; slopes are D^2 N[u_c] at the inputs */
static void coordinate_tangents(Layer *layers, const vec *entries, vec *inputs, vec *scratch, vec *slopes) {
  for (int c = 0; c < COORDINATES; c += 2) {
    const int both = c + 1 < COORDINATES;
    for (int i = 0; i < INPUTS; i++)
      for (int v = 0; v < VECTORS; v++) {
        inputs[i * UNIT + v] = row_curvature(entries, c)[i * VECTORS + v];
        inputs[i * UNIT + VECTORS + v] = both ? row_curvature(entries, c + 1)[i * VECTORS + v] : (vec){0};
      }
    vec *from = inputs;
    for (int l = 1; l <= LAYERS; l++) {
      const int64_t units = sizes[l];
      vec *along = layers[l].along + c / 2 * units * UNIT;
      product(units, sizes[l - 1], layers[l].own.weight, from, along);
      for (int64_t u = 0; u < units; u++)
        for (int v = 0; v < UNIT; v++)
          scratch[u * UNIT + v] = layers[l].slope[u * UNIT + v % VECTORS] * along[u * UNIT + v];
      from = scratch;
    }
    for (int l = LAYERS; l >= 1; l--) {
      const int64_t units = sizes[l];
      vec *along = layers[l].along + c / 2 * units * UNIT, *back = layers[l].along_back + c / 2 * units * UNIT;
      for (int64_t u = 0; u < units; u++)
        for (int v = 0; v < UNIT; v++) {
          const vec first = layers[l].slope[u * UNIT + v % VECTORS], value = layers[l].values[u * UNIT + v % VECTORS];
          const vec after = layers[l].backward[u * UNIT + VECTORS + v % VECTORS];
          const vec own = SECOND(value, first) * along[u * UNIT + v] * after;
          back[u * UNIT + v] = l < LAYERS ? first * scratch[u * UNIT + v] + own : own;
        }
      product(sizes[l - 1], units, layers[l].own.transposed, back, l > 1 ? scratch : slopes + c / 2 * INPUTS * UNIT);
    }
  }
}

/* x -> M^-1 x in every lane, by the factors L D L' without pivots, so that an indefinite M is solved too */
static void factorise(vec *mass) {
  for (int c = 0; c < COORDINATES; c++)
    for (int r = c + 1; r < COORDINATES; r++) {
      const vec ratio = mass[UPPER(c, r)] / mass[UPPER(c, c)];
      for (int d = r; d < COORDINATES; d++) mass[UPPER(r, d)] -= ratio * mass[UPPER(c, d)];
    }
}

static void solve(const vec *mass, vec *x) {
  for (int c = 0; c < COORDINATES; c++)
    for (int r = c + 1; r < COORDINATES; r++) x[r] -= mass[UPPER(c, r)] / mass[UPPER(c, c)] * x[c];
  for (int c = COORDINATES - 1; c >= 0; c--) {
    for (int r = c + 1; r < COORDINATES; r++) x[c] -= mass[UPPER(c, r)] * x[r];
    x[c] /= mass[UPPER(c, c)];
  }
}

/* residuals r of the inverse rows -> e, and lambda = -2 M^-1 e over the weight */
static void solve_rows(const Form *form, const vec *entries, const vec *gradient, const vec *slopes, vec *residual,
                       vec *lambda) {
  const vec *bends = entries + (1 + form->rows * ROW_SIZE) * VECTORS;
  for (int v = 0; v < VECTORS; v++) {
    vec mass[COORDINATES * (COORDINATES + 1) / 2], x[COORDINATES];
    for (int c = 0; c < COORDINATES; c++)
      for (int d = c; d < COORDINATES; d++) {
        const vec *bend = bends + UPPER(c, d) * INPUTS * VECTORS + v, *u = row_curvature(entries, d) + v;
        const vec *slope = slopes + c / 2 * INPUTS * UNIT + c % 2 * VECTORS + v;
        vec sum = {0};
        for (int i = 0; i < INPUTS; i++)
          sum += slope[i * UNIT] * u[i * VECTORS] + gradient[i * UNIT + VECTORS + v] * bend[i * VECTORS];
        mass[UPPER(c, d)] = sum;
      }
    factorise(mass);
    for (int c = 0; c < COORDINATES; c++) x[c] = -residual[c * VECTORS + v];
    solve(mass, x);
    for (int c = 0; c < COORDINATES; c++) residual[c * VECTORS + v] = x[c];
    solve(mass, x);
    for (int c = 0; c < COORDINATES; c++) lambda[c * VECTORS + v] = -2 * x[c];
  }
}

/* zdot -> zdot + sum e_c u_c in all that was computed with it */
static void move_to_own_acceleration(Layer *layers, const vec *entries, const vec *error) {
  for (int c = 0; c < COORDINATES; c++) {
    const vec *e = error + c * VECTORS;
    for (int i = 0; i < INPUTS; i++)
      for (int v = 0; v < VECTORS; v++)
        layers[0].values[i * UNIT + VECTORS + v] += e[v] * row_curvature(entries, c)[i * VECTORS + v];
    for (int l = 1; l <= LAYERS; l++)
      for (int64_t u = 0; u < sizes[l]; u++)
        for (int v = 0; v < VECTORS; v++) {
          const int64_t at = (c / 2 * sizes[l] + u) * UNIT + c % 2 * VECTORS + v;
          layers[l].slope[u * UNIT + VECTORS + v] += e[v] * layers[l].along[at];
          layers[l].values[u * UNIT + VECTORS + v] += e[v] * layers[l].slope[u * UNIT + v] * layers[l].along[at];
          layers[l].backward[u * UNIT + v] += e[v] * layers[l].along_back[at];
        }
  }
}

/* t = sum lambda w, at the model's own acceleration: adds sum_cd lambda_c e_d v_cd */
static void pull_bends(const Form *form, const vec *entries, const vec *lambda, const vec *error, vec *directions) {
  const vec *bends = entries + (1 + form->rows * ROW_SIZE) * VECTORS;
  for (int c = 0; c < COORDINATES; c++)
    for (int d = 0; d < COORDINATES; d++) {
      const vec *bend = bends + (c < d ? UPPER(c, d) : UPPER(d, c)) * INPUTS * VECTORS;
      for (int i = 0; i < INPUTS; i++)
        for (int v = 0; v < VECTORS; v++) {
          const vec both = lambda[c * VECTORS + v] * error[d * VECTORS + v];
          directions[i * UNIT + VECTORS + v] += both * bend[i * VECTORS + v];
        }
    }
}
