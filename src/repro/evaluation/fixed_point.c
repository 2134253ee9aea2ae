/* Implicit steps around `better_guess`: each is iterated until it changes no more. */

static int solve(const double *x, const double *move, const double *parameters, double h, double tolerance,
                 int64_t most, double *next) {
    double better[N_X], size = 1.0;
    for (int i = 0; i < N_X; i++) next[i] = x[i] + move[i], size = fmax(size, 1.0 + fabs(x[i]));
    for (int64_t k = 0; k < most; k++) {
        double change = 0.0;
        better_guess(x, next, parameters, &h, better);
        for (int i = 0; i < N_X; i++) {
            const double difference = fabs(better[i] - next[i]);
            if (!isfinite(difference)) return 0;
            change = fmax(change, difference);
            next[i] = better[i];
        }
        if (change <= tolerance * size) return 1;
    }
    return 0;
}

void integrate(int64_t batch, int64_t steps, double h, double tolerance, int64_t most, const double *parameters,
               int64_t n_parameters, double *states) {
    for (int64_t b = 0; b < batch; b++) {
        double move[N_X] = {0};
        for (int64_t k = 0; k < steps; k++) {
            double *x = states + (b * (steps + 1) + k) * N_X, *next = x + N_X;
            if (!solve(x, move, parameters + b * n_parameters, h, tolerance, most, next)) {
                for (int64_t i = 0; i < (steps - k) * N_X; i++) next[i] = nan;
                break;
            }
            for (int i = 0; i < N_X; i++) move[i] = next[i] - x[i];
        }
    }
}
