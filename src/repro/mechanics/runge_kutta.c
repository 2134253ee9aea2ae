/* Fourth-order Runge-Kutta steps around `accelerate`, the more the faster an angle turns. */

#define N_X (2 * N_Q)

static void derivative(const double *x, const double *u, const double *parameters, double *slope) {
    memcpy(slope, x + N_Q, N_Q * sizeof(double));
    accelerate(x, x + N_Q, u, parameters, slope + N_Q);
}

static void rk4(double *x, const double *u, const double *parameters, double h) {
    double k1[N_X], k2[N_X], k3[N_X], k4[N_X], at[N_X];
    derivative(x, u, parameters, k1);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + 0.5 * h * k1[i];
    derivative(at, u, parameters, k2);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + 0.5 * h * k2[i];
    derivative(at, u, parameters, k3);
    for (int i = 0; i < N_X; i++) at[i] = x[i] + h * k3[i];
    derivative(at, u, parameters, k4);
    for (int i = 0; i < N_X; i++) x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
}

static int all_finite(const double *x) {
    for (int i = 0; i < N_X; i++) if (!isfinite(x[i])) return 0;
    return 1;
}

static double substeps(const double *x, const int64_t *angles, int64_t n_angles, double least, double per_rate) {
    double fastest = 0.0;
    for (int64_t i = 0; i < n_angles; i++) fastest = fmax(fastest, fabs(x[N_Q + angles[i]]));
    return fmax(least, ceil(per_rate * fastest));
}

static int step(const double *x, double *next, const double *u, const double *parameters, double time_step,
                double n) {
    memcpy(next, x, N_X * sizeof(double));
    for (int64_t s = 0; s < (int64_t)n; s++) rk4(next, u, parameters, time_step / n);
    return all_finite(next);
}

void simulate(int64_t batch, int64_t steps, double time_step, const double *u, const double *parameters,
              int64_t parameters_stride, const int64_t *angles, int64_t n_angles, double least, double most,
              double per_rate, double *states) {
    for (int64_t b = 0; b < batch; b++) {
        for (int64_t k = 0; k < steps; k++) {
            const double *held = u + (b * steps + k) * N_U, *own = parameters + b * parameters_stride;
            double *x = states + (b * (steps + 1) + k) * N_X, *next = x + N_X;
            double n = all_finite(x) ? substeps(x, angles, n_angles, least, per_rate) : inf;
            if (n > most || !step(x, next, held, own, time_step, n)) {
                for (int64_t i = 0; i < (steps - k) * N_X; i++) next[i] = nan;
                break;
            }
        }
    }
}
