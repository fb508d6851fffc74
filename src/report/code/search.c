    static const double start[COUNT] = {START};
    static const int which[COUNT] = {WHICH};
    double f[COUNT], h[COUNT*COUNT];
    int i, k, last = 0;
    for (i = 0; i < COUNT; i++) q[which[i]] = start[i];
    for (k = 0; k < 100; k++) {
        double step = 0.0, scale = 0.0;
        BODY
        librate_solve(COUNT, h, f);
        for (i = 0; i < COUNT; i++) {
            q[which[i]] -= f[i];
            step = fmax(step, fabs(f[i]));
            scale = fmax(scale, fabs(q[which[i]]));
        }
        if (last) break;
        last = step <= 1e-9*scale;
    }
    if (!last) for (i = 0; i < COUNT; i++) q[which[i]] = NAN;
