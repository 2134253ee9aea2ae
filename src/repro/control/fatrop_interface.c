/* The interface that fatrop expects of a library: functions with their names, shapes and sparsity. */

static const casadi_int one[] = {1, 1, 1}, variables[] = {N_VARIABLES, 1, 1}, parameters[] = {N_X + N_SHARED, 1, 1},
                        rows[] = {N_CONSTRAINTS, 1, 1};

#define ARGUMENTS const double **arg, double **res, casadi_int *iw, double *w, int mem
#define DESCRIBE(name, n_in, n_out, names_in, names_out, ...)                                                     \
    casadi_int name##_n_in(void) { return n_in; }                                                                 \
    casadi_int name##_n_out(void) { return n_out; }                                                               \
    const char *name##_name_in(casadi_int i) { static const char *all[] = names_in; return all[i]; }              \
    const char *name##_name_out(casadi_int i) { static const char *all[] = names_out; return all[i]; }            \
    const casadi_int *name##_sparsity_in(casadi_int i) {                                                          \
        static const casadi_int *all[] = {variables, parameters, one, rows}; return all[i]; }                     \
    const casadi_int *name##_sparsity_out(casadi_int i) {                                                         \
        static const casadi_int *all[] = {__VA_ARGS__}; return all[i]; }                                          \
    int name##_work(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *d) {                                 \
        if (a) *a = n_in; if (r) *r = n_out; if (i) *i = 0; if (d) *d = 0; return 0; }
#define LIST(...) {__VA_ARGS__}
#define PRIMAL LIST("x", "p")
#define PRIMAL_DUAL LIST("x", "p", "lam_f", "lam_g")

DESCRIBE(nlp, 2, 2, PRIMAL, LIST("f", "g"), one, rows)
int nlp(ARGUMENTS) {
    evaluate(arg, VALUES);
    if (res[0]) cost(res[0]);
    if (res[1]) constraints(res[1]);
    return 0;
}

DESCRIBE(nlp_f, 2, 1, PRIMAL, LIST("f"), one)
int nlp_f(ARGUMENTS) {
    evaluate(arg, VALUES);
    if (res[0]) cost(res[0]);
    return 0;
}

DESCRIBE(nlp_g, 2, 1, PRIMAL, LIST("g"), rows)
int nlp_g(ARGUMENTS) {
    evaluate(arg, VALUES);
    if (res[0]) constraints(res[0]);
    return 0;
}

DESCRIBE(nlp_grad_f, 2, 1, PRIMAL, LIST("grad_f_x"), variables)
int nlp_grad_f(ARGUMENTS) {
    evaluate(arg, DERIVATIVES);
    if (res[0]) gradient(res[0]);
    return 0;
}

DESCRIBE(nlp_jac_g, 2, 2, PRIMAL, LIST("g", "jac_g_x"), rows, jacobian_pattern)
int nlp_jac_g(ARGUMENTS) {
    evaluate(arg, DERIVATIVES);
    if (res[0]) constraints(res[0]);
    if (res[1]) jacobian(res[1]);
    return 0;
}

DESCRIBE(nlp_hess_l, 4, 2, PRIMAL_DUAL, LIST("grad_gamma_x", "hess_gamma_x_x"), variables, hessian_pattern)
int nlp_hess_l(ARGUMENTS) {
    evaluate(arg, DERIVATIVES);
    if (res[0]) lagrangian_gradient(arg[2][0], arg[3], res[0]);
    if (res[1]) hessian(arg[2][0], arg[3], res[1]);
    return 0;
}

DESCRIBE(nlp_grad, 4, 4, PRIMAL_DUAL, LIST("f", "g", "grad_gamma_x", "grad_gamma_p"), one, rows, variables, parameters)
int nlp_grad(ARGUMENTS) {
    evaluate(arg, DERIVATIVES);
    if (res[0]) cost(res[0]);
    if (res[1]) constraints(res[1]);
    if (res[2]) lagrangian_gradient(arg[2][0], arg[3], res[2]);
    if (res[3]) memset(res[3], 0, (N_X + N_SHARED) * sizeof(double)); /* fatrop does not use it */
    return 0;
}
