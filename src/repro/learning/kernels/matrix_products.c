/* Matrix products over blocks of samples in C: samples are the lanes, and the quantities of a unit go together.

   An array is (unit, quantity, sample). Constants: VECTORS, the vectors of samples in a block, a multiple of 3;
   QUANTITIES of a unit; the type `real` of all numbers. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#ifdef __AVX512F__
#define BYTES 64
#define TILE 8                        /* units of a product whose sums stay in registers */
#else
#define BYTES 32
#define TILE 4
#endif
#define LANES ((int)(BYTES / sizeof(real)))
#define BLOCK (VECTORS * LANES)
#define UNIT (QUANTITIES * VECTORS)
#define ALWAYS static inline __attribute__((always_inline))
typedef real vec __attribute__((vector_size(BYTES)));

static vec *take(vec **memory, int64_t vectors) {
  vec *taken = *memory;
  *memory += vectors;
  return taken;
}

/* The weights of a layer, also transposed, and the places of their gradient in the total. */
typedef struct {
  const real *weight, *bias;
  real *transposed, *weight_total, *bias_total;
} Weights;

/* Those of n units with `inner` inputs, which begin at *at; moves *at behind them. */
static Weights take_weights(int64_t n, int64_t inner, const real **at, const real *parameters, real *total,
                            vec **memory) {
  const real *weight = *at, *bias = weight + n * inner;
  real *weight_total = total + 1 + (weight - parameters);
  real *transposed = (real *)take(memory, n * inner / LANES + 1);
  for (int64_t o = 0; o < n; o++)
    for (int64_t i = 0; i < inner; i++) transposed[i * n + o] = weight[o * inner + i];
  *at = bias + n;
  return (Weights){weight, bias, transposed, weight_total, weight_total + n * inner};
}

ALWAYS void product_tile(const int rows, const int64_t inner, const real *weight, const vec *in, vec *out) {
  vec sum[TILE][3];
  for (int r = 0; r < rows; r++) for (int c = 0; c < 3; c++) sum[r][c] = (vec){0};
  for (int64_t i = 0; i < inner; i++) {
    const vec x = in[i * UNIT], y = in[i * UNIT + 1], z = in[i * UNIT + 2];
#pragma GCC unroll 8
    for (int r = 0; r < rows; r++) {
      const real w = weight[r * inner + i];
      sum[r][0] += w * x; sum[r][1] += w * y; sum[r][2] += w * z;
    }
  }
  for (int r = 0; r < rows; r++) for (int c = 0; c < 3; c++) out[r * UNIT + c] = sum[r][c];
}

/* out (outer, ...) = weight (outer, inner) in (inner, ...) */
static void product(int64_t outer, int64_t inner, const real *weight, const vec *in, vec *out) {
  int64_t o = 0;
#define TILES(rows) for (; o + rows <= outer; o += rows) for (int c = 0; c < UNIT; c += 3) \
    product_tile(rows, inner, weight + o * inner, in + c, out + o * UNIT + c)
#if TILE == 8
  TILES(8);
#endif
  TILES(4);
  TILES(2);
  TILES(1);
#undef TILES
}

ALWAYS real lanes_sum(vec x) {
  real sum = 0;
  for (int l = 0; l < LANES; l++) sum += x[l];
  return sum;
}

ALWAYS void outer_tile(const int rows, const int columns, const vec *left, const vec *right, const vec *left_2,
                       const vec *right_2, real *total, const int64_t stride) {
  vec sum[4][4];
  for (int r = 0; r < rows; r++) for (int c = 0; c < columns; c++) sum[r][c] = (vec){0};
  for (int s = 0; s < UNIT; s++) {
#pragma GCC unroll 4
    for (int r = 0; r < rows; r++)
#pragma GCC unroll 4
      for (int c = 0; c < columns; c++) sum[r][c] += left[r * UNIT + s] * right[c * UNIT + s];
  }
  for (int s = 0; left_2 && s < UNIT; s++) {
#pragma GCC unroll 4
    for (int r = 0; r < rows; r++)
#pragma GCC unroll 4
      for (int c = 0; c < columns; c++) sum[r][c] += left_2[r * UNIT + s] * right_2[c * UNIT + s];
  }
  for (int r = 0; r < rows; r++) for (int c = 0; c < columns; c++) total[r * stride + c] += lanes_sum(sum[r][c]);
}

/* total (outer, inner) += left right' (+ left_2 right_2'), summed over quantities and samples */
static void outer_products(int64_t outer, int64_t inner, const vec *left, const vec *right, const vec *left_2,
                           const vec *right_2, real *total) {
  int64_t o = 0;
#define COLUMNS(rows, columns) for (; i + columns <= inner; i += columns) \
    outer_tile(rows, columns, left + o * UNIT, right + i * UNIT, left_2 ? left_2 + o * UNIT : 0, \
               right_2 + i * UNIT, total + o * inner + i, inner)
#define TILES(rows) for (; o + rows <= outer; o += rows) { int64_t i = 0; COLUMNS(rows, 4); COLUMNS(rows, 1); }
  TILES(4)
  TILES(1)
#undef TILES
#undef COLUMNS
}
