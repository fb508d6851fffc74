    which = [WHICH]
    for at, value in zip(which, [START]):
        q[at] = value
    last = False
    for _ in range(100):
        BODY
        for at, by in zip(which, f):
            q[at] -= by
        if last:
            break
        last = max(map(abs, f)) <= 1e-9*max(abs(q[at]) for at in which)
    if not last:
        for at in which:
            q[at] = math.nan
