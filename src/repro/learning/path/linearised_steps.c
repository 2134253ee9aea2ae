/* Runge-Kutta steps under a held force with their derivatives by state, weights and force; one step per lane.
   By a stage's acceleration a = M^-1 (tau - rest), da = M^-1 (dtau - tau_q dq - tau_v dv - tau_w dw): the Jacobians
   of the inverse model at a are enough. */

#include <stdlib.h>
#include <string.h>

#define N ${n_q}
#define W ${n_weights}
#define X (2 * N)
#define C (X + W + N) /* columns: state, weights, force */
#define J (X + W)

static void stage(const vec *x, const vec *tau, const double *parameters, vec (*S)[C], vec *k, vec (*kS)[C], vec (*jac)[J]) {
  vec at[3 * N], own[N * N + N], inverse[N][N], M[N][N], a[N];
  for (int i = 0; i < X; i++) at[i] = x[i];
  inertia(at, parameters, own);
  for (int i = 0; i < N; i++) {
    a[i] = tau[i] - own[N * N + i];
    for (int j = 0; j < N; j++) { M[i][j] = own[i * N + j]; inverse[i][j] = splat(i == j); }
  }
  for (int p = 0; p < N; p++) { /* Gauss-Jordan; without pivots, for M is definite where it means something */
    vec scale = 1.0 / M[p][p];
    for (int j = 0; j < N; j++) { M[p][j] *= scale; inverse[p][j] *= scale; }
    for (int i = 0; i < N; i++) if (i != p) {
      vec factor = M[i][p];
      for (int j = 0; j < N; j++) { M[i][j] -= factor * M[p][j]; inverse[i][j] -= factor * inverse[p][j]; }
    }
  }
  for (int i = 0; i < N; i++) {
    vec sum = splat(0);
    for (int j = 0; j < N; j++) sum += inverse[i][j] * a[j];
    at[X + i] = sum;
    k[i] = x[N + i];
    k[N + i] = sum;
  }
  jacobians(at, parameters, &jac[0][0]);
  for (int i = 0; i < N; i++) {
    vec by_state[X];
    for (int j = 0; j < X; j++) {
      by_state[j] = splat(0);
      for (int l = 0; l < N; l++) by_state[j] += inverse[i][l] * jac[l][j];
    }
    for (int c = 0; c < C; c++) {
      kS[i][c] = S[N + i][c];
      vec sum = splat(0);
      for (int j = 0; j < X; j++) sum -= by_state[j] * S[j][c];
      kS[N + i][c] = sum;
    }
    for (int c = 0; c < W; c++)
      for (int l = 0; l < N; l++) kS[N + i][X + c] -= inverse[i][l] * jac[l][X + c];
    for (int c = 0; c < N; c++) kS[N + i][X + W + c] += inverse[i][c];
  }
}

void linearised(const double *points, int64_t count, int64_t substeps, const double *parameters, double *result) {
  static const double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, ahead[4] = {0.5, 0.5, 1.0, 0.0};
  vec (*space)[C] = aligned_alloc(sizeof(vec), 4 * X * sizeof *space);
  vec (*jac)[J] = aligned_alloc(sizeof(vec), N * sizeof *jac);
  vec (*S)[C] = space, (*atS)[C] = space + X, (*kS)[C] = space + 2 * X, (*sumS)[C] = space + 3 * X;
  for (int64_t s = 0; s < count; s += LANES) {
    vec x[X], at[X], k[X], sum[X], tau[N], h;
    for (int l = 0; l < LANES; l++) {
      const double *row = points + (X + N + 1) * (s + l < count ? s + l : s);
      for (int i = 0; i < X; i++) x[i][l] = row[i];
      for (int i = 0; i < N; i++) tau[i][l] = row[X + i];
      h[l] = row[X + N] / substeps;
    }
    for (int i = 0; i < X; i++)
      for (int c = 0; c < C; c++) S[i][c] = splat(i == c);
    for (int64_t step = 0; step < substeps; step++) {
      memcpy(at, x, sizeof at);
      memcpy(sum, x, sizeof sum);
      memcpy(atS, S, X * sizeof *S);
      memcpy(sumS, S, X * sizeof *S);
      for (int r = 0; r < 4; r++) {
        stage(at, tau, parameters, atS, k, kS, jac);
        vec add = weight[r] * h, next = ahead[r] * h;
        for (int i = 0; i < X; i++) {
          sum[i] += add * k[i];
          at[i] = x[i] + next * k[i];
          for (int c = 0; c < C; c++) {
            sumS[i][c] += add * kS[i][c];
            atS[i][c] = S[i][c] + next * kS[i][c];
          }
        }
      }
      memcpy(x, sum, sizeof x);
      memcpy(S, sumS, X * sizeof *S);
    }
    for (int l = 0; l < LANES && s + l < count; l++)
      for (int i = 0; i < X; i++) {
        double *out = result + ((s + l) * X + i) * (1 + C);
        out[0] = x[i][l];
        for (int c = 0; c < C; c++) out[1 + c] = S[i][c][l];
      }
  }
  free(space);
  free(jac);
}
