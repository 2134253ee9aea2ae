/* Runge-Kutta steps and their derivatives, assembled over the horizon of `shooting.py`. */

#include <string.h>

#define N_X (2 * N_Q)
#define N_W (N_X + N_U)
#define ROWS (N_X + N_START + N_MIDDLE)
#define N_VARIABLES (N * N_W + N_X)
#define N_CONSTRAINTS (N * ROWS + N_X + N_END)
#define GROUPS ((N + LANES - 1) / LANES)
#define RATES (4 * SUBSTEPS)

enum { NOTHING, VALUES, DERIVATIVES };

/* Results at one point, LANES stages per group; z = [x, u], w the stage's own variables [x_k, u_k]. */
static _Thread_local struct {
    int level;
    double x[N_VARIABLES], p[N_X + N_SHARED];
    vec shared[N_SHARED], data[GROUPS][2], reached[GROUPS][N_X], reached_jacobian[GROUPS][N_X][N_W];
    vec z[GROUPS][RATES][N_W], rate[GROUPS][RATES][N_Q + N_Q * N_W], z_jacobian[GROUPS][RATES][N_X][N_W];
    vec middle[GROUPS][N_X], middle_jacobian[GROUPS][N_X][N_W], last[N_X];
    vec at_start[GROUPS][1 + N_START + N_W + N_START * N_W];
    vec at_middle[GROUPS][1 + N_MIDDLE + N_X + N_MIDDLE * N_X];
    vec at_end[1 + N_END + N_X + N_END * N_X];
} now;

static const double step_to[4] = {0.0, 0.5, 0.5, 1.0}, step_share[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};

/* Derivatives of a rate [qd, qdd] with respect to w: [dqd/dw, dqdd/dz dz/dw], where dx are the rows dx/dw. */
static void rate_along(const vec *rate, vec dx[N_X][N_W], vec along[N_X][N_W]) {
    for (int i = 0; i < N_Q; i++) {
        const vec *row = rate + N_Q + i * N_W;
        for (int c = 0; c < N_W; c++) {
            vec sum = c >= N_X ? row[c] : splat(0.0);
            for (int j = 0; j < N_X; j++) sum += row[j] * dx[j][c];
            along[i][c] = dx[N_Q + i][c];
            along[N_Q + i][c] = sum;
        }
    }
}

static void shoot(int group, int derivatives) {
    vec x[N_X], s[N_X][N_W], h = now.data[group][0] / (double)SUBSTEPS, *first = now.z[group][0];
    const vec *weights = now.shared + N_GOAL;
    memcpy(x, first, sizeof x);
    for (int i = 0; i < N_X; i++) for (int c = 0; c < N_W; c++) s[i][c] = splat(i == c);
    for (int sub = 0; sub < SUBSTEPS; sub++) {
        vec k[4][N_X], along[4][N_X][N_W];
        for (int l = 0; l < 4; l++) {
            int at = 4 * sub + l;
            vec *z = now.z[group][at], *rate = now.rate[group][at], step = h * step_to[l];
            for (int i = 0; i < N_X; i++) z[i] = l ? x[i] + step * k[l - 1][i] : x[i];
            for (int i = N_X; i < N_W; i++) z[i] = first[i];
            if (derivatives) {
                vec (*z_jacobian)[N_W] = now.z_jacobian[group][at];
                for (int i = 0; i < N_X; i++)
                    for (int c = 0; c < N_W; c++) z_jacobian[i][c] = l ? s[i][c] + step * along[l - 1][i][c] : s[i][c];
                rate_jacobian(z, weights, rate);
                rate_along(rate, z_jacobian, along[l]);
            } else rate_value(z, weights, rate);
            memcpy(k[l], z + N_Q, N_Q * sizeof(vec));
            memcpy(k[l] + N_Q, rate, N_Q * sizeof(vec));
        }
        for (int l = 0; l < 4; l++) for (int i = 0; i < N_X; i++) {
            vec share = h * step_share[l];
            x[i] += share * k[l][i];
            if (derivatives) for (int c = 0; c < N_W; c++) s[i][c] += share * along[l][i][c];
        }
        if (sub + 1 == SUBSTEPS / 2) {
            memcpy(now.middle[group], x, sizeof x);
            if (derivatives) memcpy(now.middle_jacobian[group], s, sizeof s);
        }
    }
    memcpy(now.reached[group], x, sizeof x);
    if (derivatives) memcpy(now.reached_jacobian[group], s, sizeof s);
}

static int stage_of(int group, int lane) {
    int k = group * LANES + lane;
    return k < N ? k : N - 1;
}

static void move_to(const double *x, const double *p) {
    if (now.level && !memcmp(x, now.x, sizeof now.x) && !memcmp(p, now.p, sizeof now.p)) return;
    memcpy(now.x, x, sizeof now.x);
    memcpy(now.p, p, sizeof now.p);
    now.level = NOTHING;
    for (int i = 0; i < N_SHARED; i++) now.shared[i] = splat(p[N_X + i]);
    for (int i = 0; i < N_X; i++) now.last[i] = splat(x[N * N_W + i]);
    for (int group = 0; group < GROUPS; group++) for (int lane = 0; lane < LANES; lane++) {
        int k = stage_of(group, lane);
        now.data[group][0][lane] = lengths[k];
        now.data[group][1][lane] = counts[k];
        for (int i = 0; i < N_W; i++) now.z[group][0][i][lane] = x[k * N_W + i];
    }
}

static void evaluate(const double **arg, int level) {
    move_to(arg[0], arg[1]);
    if (now.level >= level) return;
    now.level = level;
    const vec *none = now.data[0];
    (level == DERIVATIVES ? end_jacobian : end_value)(now.last, now.shared, none, now.at_end);
    for (int group = 0; group < GROUPS; group++) {
        const vec *data = now.data[group];
        shoot(group, level == DERIVATIVES);
        const vec *start = now.z[group][0], *middle = now.middle[group];
        (level == DERIVATIVES ? start_jacobian : start_value)(start, now.shared, data, now.at_start[group]);
        (level == DERIVATIVES ? middle_jacobian : middle_value)(middle, now.shared, data, now.at_middle[group]);
    }
}

static void cost(double *f) {
    *f = now.at_end[0][0];
    for (int k = 0; k < N; k++) *f += now.at_start[k / LANES][0][k % LANES] + now.at_middle[k / LANES][0][k % LANES];
}

static int row_of(int k) { return k * ROWS + (k ? N_X : 0); }

static void constraints(double *g) {
    for (int k = 0; k < N; k++) {
        int group = k / LANES, lane = k % LANES;
        double *own = g + row_of(k);
        for (int i = 0; i < N_X; i++) own[i] = now.x[(k + 1) * N_W + i] - now.reached[group][i][lane];
        for (int i = 0; i < N_START; i++) own[N_X + i] = now.at_start[group][1 + i][lane];
        for (int i = 0; i < N_MIDDLE; i++) own[N_X + N_START + i] = now.at_middle[group][1 + i][lane];
    }
    for (int i = 0; i < N_X; i++) g[ROWS + i] = now.x[i] - now.p[i];
    for (int i = 0; i < N_END; i++) g[N * ROWS + N_X + i] = now.at_end[1 + i][0];
}

/* A derivative at the middle with respect to w: the row of derivatives with respect to x times dx/dw. */
static vec through_middle(int group, const vec *row, int c) {
    vec sum = splat(0.0);
    for (int i = 0; i < N_X; i++) sum += row[i] * now.middle_jacobian[group][i][c];
    return sum;
}

static void gradient(double *d) {
    for (int group = 0; group < GROUPS; group++) for (int c = 0; c < N_W; c++) {
        vec own = now.at_start[group][1 + N_START + c] + through_middle(group, now.at_middle[group] + 1 + N_MIDDLE, c);
        for (int lane = 0; lane < LANES && group * LANES + lane < N; lane++)
            d[(group * LANES + lane) * N_W + c] = own[lane];
    }
    for (int i = 0; i < N_X; i++) d[N * N_W + i] = now.at_end[1 + N_END + i][0];
}

/* Nonzeros column by column: the following state of the stage before, the stage's own rows, the first state's. */
static void jacobian(double *d) {
    vec own[GROUPS][ROWS][N_W];
    for (int group = 0; group < GROUPS; group++) for (int c = 0; c < N_W; c++) {
        const vec *start = now.at_start[group] + 1 + N_START + N_W, *middle = now.at_middle[group] + 1 + N_MIDDLE + N_X;
        for (int i = 0; i < N_X; i++) own[group][i][c] = -now.reached_jacobian[group][i][c];
        for (int i = 0; i < N_START; i++) own[group][N_X + i][c] = start[i * N_W + c];
        for (int i = 0; i < N_MIDDLE; i++)
            own[group][N_X + N_START + i][c] = through_middle(group, middle + i * N_X, c);
    }
    for (int k = 0; k < N; k++) for (int c = 0; c < N_W; c++) {
        if (k && c < N_X) *d++ = 1.0;
        for (int i = 0; i < ROWS; i++) *d++ = own[k / LANES][i][c][k % LANES];
        if (!k && c < N_X) *d++ = 1.0;
    }
    for (int c = 0; c < N_X; c++) {
        *d++ = 1.0;
        for (int i = 0; i < N_END; i++) *d++ = now.at_end[1 + N_END + N_X + i * N_X + c][0];
    }
}

/* h += dx' second dx, where rows of dx from N_X on, if n has them, are the inputs themselves */
static void add_second(vec h[N_W][N_W], const vec *second, int n, vec dx[N_X][N_W]) {
    vec half[N_W][N_W];
    for (int i = 0; i < n; i++) for (int c = 0; c < N_W; c++) {
        vec sum = c >= N_X && n == N_W ? second[i * n + c] : splat(0.0);
        for (int j = 0; j < N_X; j++) sum += second[i * n + j] * dx[j][c];
        half[i][c] = sum;
    }
    for (int b = 0; b < N_W; b++) for (int c = 0; c < N_W; c++) {
        vec sum = b >= N_X && n == N_W ? half[b][c] : splat(0.0);
        for (int i = 0; i < N_X; i++) sum += dx[i][b] * half[i][c];
        h[b][c] += sum;
    }
}

static void shoot_back(int group, vec lambda[N_X], const vec *of_middle, vec h[N_W][N_W]) {
    vec length = now.data[group][0] / (double)SUBSTEPS;
    for (int sub = SUBSTEPS - 1; sub >= 0; sub--) {
        if (sub + 1 == SUBSTEPS / 2) {
            vec second[N_X * N_X];
            const vec *rows = now.at_middle[group] + 1 + N_MIDDLE;
            middle_hessian(now.middle[group], now.shared, now.data[group], of_middle, second);
            add_second(h, second, N_X, now.middle_jacobian[group]);
            for (int m = 0; m <= N_MIDDLE; m++)
                for (int i = 0; i < N_X; i++) lambda[i] += of_middle[m] * rows[m * N_X + i];
        }
        vec before[N_X], of_z[N_X], of_k[N_X], second[N_W * N_W];
        memcpy(before, lambda, sizeof before);
        for (int l = 3; l >= 0; l--) {
            int at = 4 * sub + l;
            const vec *rate = now.rate[group][at];
            for (int i = 0; i < N_X; i++) {
                of_k[i] = length * step_share[l] * lambda[i];
                if (l < 3) of_k[i] += length * step_to[l + 1] * of_z[i];
            }
            rate_hessian(now.z[group][at], now.shared + N_GOAL, rate, of_k + N_Q, second);
            add_second(h, second, N_W, now.z_jacobian[group][at]);
            for (int j = 0; j < N_X; j++) {
                of_z[j] = j < N_Q ? splat(0.0) : of_k[j - N_Q];
                for (int i = 0; i < N_Q; i++) of_z[j] += rate[N_Q + i * N_W + j] * of_k[N_Q + i];
                before[j] += of_z[j];
            }
        }
        memcpy(lambda, before, sizeof before);
    }
}

static void hessian(double lam_f, const double *lam_g, double *d) {
    vec of_end[1 + N_END], end[N_X * N_X];
    for (int group = 0; group < GROUPS; group++) {
        vec lambda[N_X], of_start[1 + N_START], of_middle[1 + N_MIDDLE], h[N_W][N_W];
        of_start[0] = of_middle[0] = splat(lam_f);
        for (int lane = 0; lane < LANES; lane++) {
            const double *own = lam_g + row_of(stage_of(group, lane));
            for (int i = 0; i < N_X; i++) lambda[i][lane] = -own[i];
            for (int i = 0; i < N_START; i++) of_start[1 + i][lane] = own[N_X + i];
            for (int i = 0; i < N_MIDDLE; i++) of_middle[1 + i][lane] = own[N_X + N_START + i];
        }
        start_hessian(now.z[group][0], now.shared, now.data[group], of_start, h[0]);
        shoot_back(group, lambda, of_middle, h);
        for (int lane = 0; lane < LANES && group * LANES + lane < N; lane++)
            for (int i = 0; i < N_W * N_W; i++) *d++ = h[i / N_W][i % N_W][lane];
    }
    of_end[0] = splat(lam_f);
    for (int i = 0; i < N_END; i++) of_end[1 + i] = splat(lam_g[N * ROWS + N_X + i]);
    end_hessian(now.last, now.shared, now.data[0], of_end, end);
    for (int i = 0; i < N_X * N_X; i++) *d++ = end[i][0];
}

static void lagrangian_gradient(double lam_f, const double *lam_g, double *d) {
    static _Thread_local double nonzeros[sizeof jacobian_pattern / sizeof(casadi_int)];
    const casadi_int *column = jacobian_pattern + 2, *row = column + N_VARIABLES + 1;
    gradient(d);
    jacobian(nonzeros);
    for (int c = 0; c < N_VARIABLES; c++) {
        d[c] *= lam_f;
        for (casadi_int i = column[c]; i < column[c + 1]; i++) d[c] += nonzeros[i] * lam_g[row[i]];
    }
}
