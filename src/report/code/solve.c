
/* Solves m x = b by elimination; x is in b then. */
static void librate_solve(int n, double *m, double *b) {
    int i, j, k;
    for (k = 0; k < n; k++) {
        int best = k;
        double swap;
        for (i = k + 1; i < n; i++) if (fabs(m[n*i + k]) > fabs(m[n*best + k])) best = i;
        for (j = 0; j < n; j++) { swap = m[n*k + j]; m[n*k + j] = m[n*best + j]; m[n*best + j] = swap; }
        swap = b[k]; b[k] = b[best]; b[best] = swap;
        for (i = k + 1; i < n; i++) {
            double factor = m[n*i + k]/m[n*k + k];
            for (j = k; j < n; j++) m[n*i + j] -= factor*m[n*k + j];
            b[i] -= factor*b[k];
        }
    }
    for (k = n - 1; k >= 0; k--) {
        for (j = k + 1; j < n; j++) b[k] -= m[n*k + j]*b[j];
        b[k] /= m[n*k + k];
    }
}
