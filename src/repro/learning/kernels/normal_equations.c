/* Of one task: the squared residual rows, and the products of [rows | Jacobian] with itself.

   A block of columns, one for each row of each vector of samples, stays in the second cache until it is multiplied. */

#define WIDTH ${width}                        /* 1 + weights */
#define PADDED ((WIDTH + 3) / 4 * 4)
#define ROWS ${rows}                          /* that depend on weights, of ${all_rows} */
#define FITTING (384 * 1024 / (PADDED * 8 * LANES) / ${all_rows})
#define COLUMNS (ROWS * (FITTING > 1 ? FITTING : 1))

/* upper tiles of products (PADDED, PADDED) += block block', summed over columns and lanes */
static void add_products(const vec *block, int64_t filled, double *products) {
  for (int64_t p = 0; p < PADDED; p += 4)
    for (int64_t k = p; k < PADDED; k += 4) {
      const vec *left = block + p * COLUMNS, *right = block + k * COLUMNS;
      vec sum[4][4];
      for (int i = 0; i < 4; i++) for (int j = 0; j < 4; j++) sum[i][j] = (vec){0};
      for (int64_t c = 0; c < filled; c++) {
#pragma GCC unroll 4
        for (int i = 0; i < 4; i++)
#pragma GCC unroll 4
          for (int j = 0; j < 4; j++) sum[i][j] += left[i * COLUMNS + c] * right[j * COLUMNS + c];
      }
      for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
          for (int l = 0; l < LANES; l++) products[(p + i) * PADDED + k + j] += sum[i][j][l];
    }
}

void products(const double *data, int64_t count, const double *parameters, double *result) {
  vec *block = aligned_alloc(sizeof(vec), PADDED * COLUMNS * sizeof(vec));
  int64_t column = 0;
  memset(block, 0, PADDED * COLUMNS * sizeof(vec));
  for (int64_t s = 0; s < count; s += LANES) {
    vec columns[STRIDE], out[WIDTH * ROWS];
    load_samples(data, 0, s, count, columns);
    vec ${arrays};
    vec ${work};
${statements}
    for (int r = 0; r < ROWS; r++, column++)
      for (int p = 0; p < WIDTH; p++) block[p * COLUMNS + column] = out[r * WIDTH + p];
    if (column == COLUMNS || s + LANES >= count) {
      add_products(block, column, result);
      column = 0;
    }
  }
  free(block);
}

double squares(const double *data, int64_t count, const double *parameters) {
  vec sum[1] = {{0}};
  for (int64_t s = 0; s < count; s += LANES) {
    vec columns[STRIDE];
    load_samples(data, 0, s, count, columns);
    vec ${arrays};
    vec ${work_of_rows};
${statements_of_rows}
  }
  double total = 0;
  for (int l = 0; l < LANES; l++) total += sum[0][l];
  return total;
}
