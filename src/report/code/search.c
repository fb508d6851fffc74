    static const double start[COUNT] = {START};
    static const int which[COUNT] = {WHICH};
    double f[COUNT], h[COUNT*COUNT], largest = 0.0, before = HUGE_VAL;
    int i, k, last = 0;
    for (i = 0; i < COUNT; i++) {
        q[which[i]] = start[i];
        largest = fmax(largest, fabs(start[i]));
    }
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
        /* Or no shorter any more, beside 0. */
        largest = fmax(largest, fmax(step, scale));
        last = step <= 1e-9*scale || (step >= before && step <= 4e-15*largest);
        before = step;
    }
    if (!last) for (i = 0; i < COUNT; i++) q[which[i]] = NAN;
