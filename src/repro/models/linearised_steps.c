/* Runge-Kutta steps under a held force with their derivatives by state, weights and force; one step per lane.
   By a stage's acceleration a = M^-1 (tau - rest), da = M^-1 (dtau - tau_q dq - tau_v dv - tau_w dw): the Jacobians
   of the inverse model at a are enough. A sub-step is linear in its start and in an error of each stage's acceleration;
   its map of these few numbers is found first, and then applied to the many columns once. */

#include <stdlib.h>
#include <string.h>

#define N ${n_q}
#define W ${n_weights}
#define X (2 * N)
#define C (X + 1 + W + N) /* columns of the result: by state, the next state, by weights, by force */
#define E (4 * N)         /* errors of the four stages' accelerations */
#define P (X + E)

typedef struct {
  vec inverse[N][N], jac[N][X + W], by_state[N][X];
} Stage;

static void stage(const vec *x, const vec *tau, const double *parameters, vec *rate, Stage *s) {
  vec at[3 * N], own[N * N + N], M[N][N], a[N];
  for (int i = 0; i < X; i++) at[i] = x[i];
  inertia(at, parameters, own);
  for (int i = 0; i < N; i++) {
    a[i] = tau[i] - own[N * N + i];
    for (int j = 0; j < N; j++) { M[i][j] = own[i * N + j]; s->inverse[i][j] = splat(i == j); }
  }
  for (int p = 0; p < N; p++) { /* Gauss-Jordan; without pivots, for M is definite where it means something */
    vec scale = 1.0 / M[p][p];
    for (int j = 0; j < N; j++) { M[p][j] *= scale; s->inverse[p][j] *= scale; }
    for (int i = 0; i < N; i++) if (i != p) {
      vec factor = M[i][p];
      for (int j = 0; j < N; j++) { M[i][j] -= factor * M[p][j]; s->inverse[i][j] -= factor * s->inverse[p][j]; }
    }
  }
  for (int i = 0; i < N; i++) {
    vec sum = splat(0);
    for (int j = 0; j < N; j++) sum += s->inverse[i][j] * a[j];
    rate[i] = x[N + i];
    rate[N + i] = at[X + i] = sum;
  }
  jacobians(at, parameters, &s->jac[0][0]);
  for (int i = 0; i < N; i++)
    for (int j = 0; j < X; j++) {
      s->by_state[i][j] = splat(0);
      for (int l = 0; l < N; l++) s->by_state[i][j] -= s->inverse[i][l] * s->jac[l][j];
    }
}

/* Advances x by a sub-step of h and returns its map (X, P) of [start | errors]. */
static void substep(vec *x, const vec *tau, vec h, const double *parameters, vec (*map)[P], Stage *stages) {
  static const double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, ahead[4] = {0.5, 0.5, 1.0, 0.0};
  vec at[X], rate[X], start[X], here[X][P], slope[X][P];
  memcpy(at, x, sizeof at);
  memcpy(start, x, sizeof start);
  for (int i = 0; i < X; i++)
    for (int c = 0; c < P; c++) here[i][c] = map[i][c] = splat(i == c);
  for (int r = 0; r < 4; r++) {
    Stage *s = stages + r;
    stage(at, tau, parameters, rate, s);
    for (int i = 0; i < N; i++)
      for (int c = 0; c < P; c++) {
        slope[i][c] = here[N + i][c];
        slope[N + i][c] = splat(c == X + r * N + i);
        for (int j = 0; j < X; j++) slope[N + i][c] += s->by_state[i][j] * here[j][c];
      }
    vec add = weight[r] * h, next = ahead[r] * h;
    for (int i = 0; i < X; i++) {
      x[i] += add * rate[i];
      at[i] = start[i] + next * rate[i];
      for (int c = 0; c < P; c++) {
        map[i][c] += add * slope[i][c];
        here[i][c] = splat(i == c) + next * slope[i][c];
      }
    }
  }
}

/* S[c] <- A S[c] + what the stages add, for all columns; map is changed. */
static void advance(vec (*S)[X], vec (*map)[P], const Stage *stages) {
  vec by_force[X][E];
  for (int i = 0; i < X; i++)
    for (int r = 0; r < 4; r++)
      for (int j = 0; j < N; j++) {
        by_force[i][r * N + j] = splat(0);
        for (int l = 0; l < N; l++) by_force[i][r * N + j] += map[i][X + r * N + l] * stages[r].inverse[l][j];
      }
  for (int c = 0; c < C; c++) {
    vec old[X];
    memcpy(old, S[c], sizeof old);
    for (int i = 0; i < X; i++) {
      vec sum = splat(0);
      for (int j = 0; j < X; j++) sum += map[i][j] * old[j];
      S[c][i] = sum;
    }
  }
  for (int w = 0; w < W; w++)
    for (int r = 0; r < 4; r++)
      for (int j = 0; j < N; j++)
        for (int i = 0; i < X; i++) S[X + 1 + w][i] -= by_force[i][r * N + j] * stages[r].jac[j][X + w];
  for (int j = 0; j < N; j++)
    for (int r = 0; r < 4; r++)
      for (int i = 0; i < X; i++) S[X + 1 + W + j][i] += by_force[i][r * N + j];
}

/* result[places[s]] (X, C) of every step s. */
void linearised(const double *points, const int64_t *places, int64_t count, int64_t substeps, const double *parameters,
                double *result) {
  vec (*S)[X] = aligned_alloc(sizeof(vec), C * sizeof *S);
  Stage *stages = aligned_alloc(sizeof(vec), 4 * sizeof *stages);
  for (int64_t s = 0; s < count; s += LANES) {
    vec x[X], tau[N], h, map[X][P];
    for (int l = 0; l < LANES; l++) {
      const double *row = points + (X + N + 1) * (s + l < count ? s + l : s);
      for (int i = 0; i < X; i++) x[i][l] = row[i];
      for (int i = 0; i < N; i++) tau[i][l] = row[X + i];
      h[l] = row[X + N] / substeps;
    }
    for (int c = 0; c < C; c++)
      for (int i = 0; i < X; i++) S[c][i] = splat(i == c);
    for (int64_t step = 0; step < substeps; step++) {
      substep(x, tau, h, parameters, map, stages);
      advance(S, map, stages);
    }
    memcpy(S[X], x, sizeof x);
    for (int l = 0; l < LANES && s + l < count; l++) {
      double *out = result + places[s + l] * X * C;
      for (int i = 0; i < X; i++)
        for (int c = 0; c < C; c++) out[i * C + c] = S[c][i][l];
    }
  }
  free(S);
  free(stages);
}
