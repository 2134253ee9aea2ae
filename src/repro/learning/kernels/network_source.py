"""Loss and gradient of rows that are linear in (N, DN, D^2 N[zdot]) of a network, as C over blocks of samples.

Four passes, whose cost does not depend on the number of coordinates (after Pearlmutter 1994):

    1  forward    the value and the tangent along zdot
    2  backward   of the tangent: g = DN and gdot = D^2 N[zdot] at the inputs, hence the rows
                  r = a N + b.g + c.gdot + d.beta - y
    3  forward    the tangent along s and the second-order term, for S = alpha N + DN[t] + D^2 N[s, zdot] with
                  alpha = sum lambda a, t = sum lambda b, s = sum lambda c, lambda = 2 r
    4  backward   of S to the weights; half of its cotangents are those of pass 2

Samples are the lanes: an array is (unit, pair of quantities, sample), and both quantities of a pair go through the
weights in one product. Constants: INPUTS, LAYERS, WIDTHS, POTENTIAL (coefficients in beta), TANH, VALUES (parameters of
the network). A sample is [z, zdot, then for each row: a where some a is not 0 (`valued`), b, c, d, y].
"""

SOURCE = """
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __AVX512F__
#define LANES 8
#define TILE 8                        /* units of a product whose sums stay in registers */
#else
#define LANES 4
#define TILE 4
#endif
#define VECTORS 6                     /* vectors of samples in a block */
#define BLOCK (VECTORS * LANES)
#define PAIR (2 * VECTORS)
#define ROW_SIZE(valued) ((valued) + 2 * INPUTS + POTENTIAL + 1)
#define ALWAYS static inline __attribute__((always_inline))
typedef double vec __attribute__((vector_size(8 * LANES)));

static const int64_t sizes[LAYERS + 1] = {INPUTS, WIDTHS};

typedef struct {
  vec *values;       /* after the activation: value, tangent along zdot */
  vec *slope;        /* first derivative of the activation, and the tangent before it */
  vec *backward;     /* cotangents before the activation: of the tangent along s, of the second-order term */
  vec *before;       /* before the activation: tangent along s, second-order term */
  vec *seconds;      /* after it */
  vec *cotangents;   /* before the activation: of the value, of the tangent along zdot */
  const double *weight, *bias;
  double *transposed, *weight_total, *bias_total;
} Layer;

ALWAYS void product_tile(const int rows, const int64_t inner, const double *weight, const vec *in, vec *out) {
  vec sum[TILE][3];
  for (int r = 0; r < rows; r++) for (int c = 0; c < 3; c++) sum[r][c] = (vec){0};
  for (int64_t i = 0; i < inner; i++) {
    const vec x = in[i * PAIR], y = in[i * PAIR + 1], z = in[i * PAIR + 2];
#pragma GCC unroll 8
    for (int r = 0; r < rows; r++) {
      const double w = weight[r * inner + i];
      sum[r][0] += w * x; sum[r][1] += w * y; sum[r][2] += w * z;
    }
  }
  for (int r = 0; r < rows; r++) for (int c = 0; c < 3; c++) out[r * PAIR + c] = sum[r][c];
}

/* out (outer, pair) = weight (outer, inner) in (inner, pair) */
static void product(int64_t outer, int64_t inner, const double *weight, const vec *in, vec *out) {
  int64_t o = 0;
#define TILES(rows) for (; o + rows <= outer; o += rows) for (int c = 0; c < PAIR; c += 3) \\
    product_tile(rows, inner, weight + o * inner, in + c, out + o * PAIR + c)
#if TILE == 8
  TILES(8);
#endif
  TILES(4);
  TILES(2);
  TILES(1);
#undef TILES
}

ALWAYS double lanes_sum(vec x) {
  double sum = 0;
  for (int l = 0; l < LANES; l++) sum += x[l];
  return sum;
}

ALWAYS void outer_tile(const int rows, const int columns, const vec *left, const vec *right, const vec *left_2,
                       const vec *right_2, double *total, const int64_t stride) {
  vec sum[4][4];
  for (int r = 0; r < rows; r++) for (int c = 0; c < columns; c++) sum[r][c] = (vec){0};
  for (int s = 0; s < PAIR; s++) {
#pragma GCC unroll 4
    for (int r = 0; r < rows; r++)
#pragma GCC unroll 4
      for (int c = 0; c < columns; c++) sum[r][c] += left[r * PAIR + s] * right[c * PAIR + s];
  }
  for (int s = 0; s < PAIR; s++) {
#pragma GCC unroll 4
    for (int r = 0; r < rows; r++)
#pragma GCC unroll 4
      for (int c = 0; c < columns; c++) sum[r][c] += left_2[r * PAIR + s] * right_2[c * PAIR + s];
  }
  for (int r = 0; r < rows; r++) for (int c = 0; c < columns; c++) total[r * stride + c] += lanes_sum(sum[r][c]);
}

/* total (outer, inner) += left right' + left_2 right_2', summed over both quantities and all samples */
static void outer_products(int64_t outer, int64_t inner, const vec *left, const vec *right, const vec *left_2,
                           const vec *right_2, double *total) {
  int64_t o = 0;
#define COLUMNS(rows, columns) for (; i + columns <= inner; i += columns) \\
    outer_tile(rows, columns, left + o * PAIR, right + i * PAIR, left_2 + o * PAIR, right_2 + i * PAIR, \\
               total + o * inner + i, inner)
#define TILES(rows) for (; o + rows <= outer; o += rows) { int64_t i = 0; COLUMNS(rows, 4); COLUMNS(rows, 1); }
  TILES(4)
  TILES(1)
#undef TILES
#undef COLUMNS
}

/* value and tangent before the activation, in place -> after it; its slope and the tangent before it are kept */
static void activate(int64_t units, vec *values, vec *slope, int wants_value) {
  for (int64_t u = 0; u < units; u++) {
    double *value = (double *)(values + u * PAIR), *first = (double *)(slope + u * PAIR);
#if TANH
    for (int s = 0; s < BLOCK; s++) value[s] = tanh(value[s]);
    for (int s = 0; s < BLOCK; s++) first[s] = 1 - value[s] * value[s];
#else
    for (int s = 0; s < BLOCK; s++) {
      const double e = exp(-fabs(value[s]));
      first[s] = (value[s] >= 0 ? 1 : e) / (1 + e);
    }
    if (wants_value)
      for (int s = 0; s < BLOCK; s++) value[s] = fmax(value[s], 0) + log1p(exp(-fabs(value[s])));
#endif
    for (int s = 0; s < BLOCK; s++) {
      first[BLOCK + s] = value[BLOCK + s];
      value[BLOCK + s] *= first[s];
    }
  }
}

/* second and third derivative over the first, from the value and the slope */
#if TANH
#define SECOND(value, first) (-2 * (value))
#define THIRD(value, first) (6 * (value) * (value) - 2)
#else
#define SECOND(value, first) (1 - (first))
#define THIRD(value, first) ((1 - (first)) * (1 - 2 * (first)))
#endif

/* cotangents after the activation [of the tangent along s, of the second-order term], in place -> before it */
static void activate_backward(const Layer *layer, int64_t units) {
  for (int64_t u = 0; u < units; u++) {
    const vec *value = layer->values + u * PAIR, *slope = layer->slope + u * PAIR;
    vec *cotangent = layer->backward + u * PAIR;
    for (int v = 0; v < VECTORS; v++) {
      const vec first = slope[v], after = cotangent[VECTORS + v];
      cotangent[v] = first * (cotangent[v] + SECOND(value[v], first) * slope[VECTORS + v] * after);
      cotangent[VECTORS + v] = first * after;
    }
  }
}

static void activate_seconds(const Layer *layer, int64_t units) {
  for (int64_t u = 0; u < units; u++) {
    const vec *value = layer->values + u * PAIR, *slope = layer->slope + u * PAIR, *before = layer->before + u * PAIR;
    vec *after = layer->seconds + u * PAIR;
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
    const vec *value = layer->values + u * PAIR, *slope = layer->slope + u * PAIR, *before = layer->before + u * PAIR;
    const vec *backward = layer->backward + u * PAIR;
    vec *cotangent = layer->cotangents + u * PAIR;
    double total = 0;
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
    layer->bias_total[u] += total;
  }
}

/* samples into lanes; a lane without a sample has no rows */
static void load_block(const double *data, const int64_t *order, int64_t first, int64_t count, int64_t row_entries,
                       vec *inputs, vec *rows) {
  double *in = (double *)inputs, *row = (double *)rows;
  for (int s = 0; s < BLOCK; s++) {
    const int64_t at = first + s < count ? first + s : first;
    const double *sample = data + (2 * INPUTS + row_entries) * (order ? order[at] : at);
    const double inside = first + s < count;
    for (int k = 0; k < 2 * INPUTS; k++)
      in[(k % INPUTS * 2 + k / INPUTS) * BLOCK + s] = sample[k];
    for (int k = 0; k < row_entries; k++) row[k * BLOCK + s] = inside * sample[2 * INPUTS + k];
  }
}

/* the residual rows, and from them the directions s and t; returns the sum of the squared rows */
static double residuals(const vec *rows, int64_t n_rows, int valued, const vec *slopes, const vec *value,
                        const double *potential, double factor, vec *directions, vec *alpha, double *potential_total) {
  vec loss = {0};
  vec potential_sum[POTENTIAL + 1];
  memset(potential_sum, 0, sizeof potential_sum);
  memset(directions, 0, INPUTS * PAIR * sizeof(vec));
  for (int v = 0; v < VECTORS; v++) {
    alpha[v] = (vec){0};
    for (int64_t r = 0; r < n_rows; r++) {
      const vec *row = rows + r * ROW_SIZE(valued) * VECTORS + v, *part = row + valued * VECTORS;
      const vec *last = part + 2 * INPUTS * VECTORS;
      vec sum = -last[POTENTIAL * VECTORS];
      if (valued) sum += row[0] * value[v];
      for (int i = 0; i < INPUTS; i++) {
        sum += part[i * VECTORS] * slopes[i * PAIR + VECTORS + v];
        sum += part[(INPUTS + i) * VECTORS] * slopes[i * PAIR + v];
      }
      for (int k = 0; k < POTENTIAL; k++) sum += potential[k] * last[k * VECTORS];
      loss += sum * sum;
      const vec lambda = 2 * factor * sum;
      if (valued) alpha[v] += lambda * row[0];
      for (int i = 0; i < INPUTS; i++) {
        directions[i * PAIR + VECTORS + v] += lambda * part[i * VECTORS];
        directions[i * PAIR + v] += lambda * part[(INPUTS + i) * VECTORS];
      }
      for (int k = 0; k < POTENTIAL; k++) potential_sum[k] += lambda * last[k * VECTORS];
    }
  }
  for (int k = 0; k < POTENTIAL; k++) potential_total[k] += lanes_sum(potential_sum[k]);
  return lanes_sum(loss);
}

static vec *take(vec **memory, int64_t vectors) {
  vec *taken = *memory;
  *memory += vectors;
  return taken;
}

static void network_gradient(const double *data, const int64_t *order, int64_t count, double factor,
                             const double *parameters, double *total, int64_t n_rows, int valued) {
  const int64_t row_entries = n_rows * ROW_SIZE(valued);
  int64_t units = 0, entries = 0;
  for (int l = 0; l <= LAYERS; l++) units += sizes[l];
  for (int l = 1; l <= LAYERS; l++) entries += sizes[l - 1] * sizes[l];
  const int64_t vectors = 6 * units * PAIR + (row_entries + 4) * VECTORS + entries / LANES + LAYERS;
  vec *allocated = aligned_alloc(8 * LANES, (vectors + LAYERS) * sizeof(vec)), *memory = allocated;
  Layer layers[LAYERS + 1];
  const double *weights = parameters;
  for (int l = 0; l <= LAYERS; l++) {
    Layer *layer = layers + l;
    const int64_t n = sizes[l], inner = l ? sizes[l - 1] : 0;
    layer->values = take(&memory, n * PAIR);
    layer->slope = take(&memory, n * PAIR);
    layer->backward = take(&memory, n * PAIR);
    layer->before = take(&memory, n * PAIR);
    layer->seconds = take(&memory, n * PAIR);
    layer->cotangents = take(&memory, n * PAIR);
    if (!l) continue;
    layer->weight = weights;
    layer->bias = weights + n * inner;
    layer->weight_total = total + 1 + (weights - parameters);
    layer->bias_total = layer->weight_total + n * inner;
    layer->transposed = (double *)take(&memory, (n * inner + LANES - 1) / LANES);
    for (int64_t o = 0; o < n; o++)
      for (int64_t i = 0; i < inner; i++) layer->transposed[i * n + o] = layer->weight[o * inner + i];
    weights += n * (inner + 1);
  }
  Layer *last = layers + LAYERS;
  const int64_t width = sizes[LAYERS];
  const double *out_weight = weights, out_bias = weights[width];
  double *out_total = total + 1 + (weights - parameters);
  vec *rows = take(&memory, row_entries * VECTORS), value[VECTORS], alpha[VECTORS];

  for (int64_t first = 0; first < count; first += BLOCK) {
    load_block(data, order, first, count, row_entries, layers[0].values, rows);
    for (int l = 1; l <= LAYERS; l++) {
      product(sizes[l], sizes[l - 1], layers[l].weight, layers[l - 1].values, layers[l].values);
      for (int64_t u = 0; u < sizes[l]; u++)
        for (int v = 0; v < VECTORS; v++) layers[l].values[u * PAIR + v] += layers[l].bias[u];
      activate(sizes[l], layers[l].values, layers[l].slope, valued || l < LAYERS);
    }
    for (int v = 0; v < VECTORS; v++) {
      value[v] = (vec){0} + out_bias;
      for (int64_t u = 0; valued && u < width; u++) value[v] += out_weight[u] * last->values[u * PAIR + v];
    }
    for (int64_t u = 0; u < width; u++)
      for (int v = 0; v < VECTORS; v++) {
        last->backward[u * PAIR + v] = (vec){0};
        last->backward[u * PAIR + VECTORS + v] = (vec){0} + out_weight[u];
      }
    for (int l = LAYERS; l >= 1; l--) {
      activate_backward(layers + l, sizes[l]);
      product(sizes[l - 1], sizes[l], layers[l].transposed, layers[l].backward, layers[l - 1].backward);
    }
    total[0] += factor * residuals(rows, n_rows, valued, layers[0].backward, value, parameters + VALUES, factor,
                                   layers[0].seconds, alpha, total + 1 + VALUES);
    for (int l = 1; l <= LAYERS; l++) {
      product(sizes[l], sizes[l - 1], layers[l].weight, layers[l - 1].seconds, layers[l].before);
      activate_seconds(layers + l, sizes[l]);
    }
    for (int64_t u = 0; u < width; u++) {
      vec sum = {0};
      for (int v = 0; v < VECTORS; v++) {
        sum += last->seconds[u * PAIR + VECTORS + v];
        if (valued) sum += alpha[v] * last->values[u * PAIR + v];
        last->cotangents[u * PAIR + v] = alpha[v] * out_weight[u];
        last->cotangents[u * PAIR + VECTORS + v] = (vec){0};
      }
      out_total[u] += lanes_sum(sum);
    }
    for (int v = 0; valued && v < VECTORS; v++) out_total[width] += lanes_sum(alpha[v]);
    for (int l = LAYERS; l >= 1; l--) {
      activate_seconds_backward(layers + l, sizes[l]);
      outer_products(sizes[l], sizes[l - 1], layers[l].cotangents, layers[l - 1].values, layers[l].backward,
                     layers[l - 1].seconds, layers[l].weight_total);
      if (l > 1)
        product(sizes[l - 1], sizes[l], layers[l].transposed, layers[l].cotangents, layers[l - 1].cotangents);
    }
  }
  free(allocated);
}
"""
