    which = [WHICH]
    for at, value in zip(which, [START]):
        q[at] = value
    last = False
    largest = max(map(abs, [START]))
    before = math.inf
    for _ in range(100):
        BODY
        for at, by in zip(which, f):
            q[at] -= by
        if last:
            break
        # Or no shorter any more, beside 0.
        step = max(map(abs, f))
        scale = max(abs(q[at]) for at in which)
        largest = max(largest, step, scale)
        last = step <= 1e-9*scale or before <= step <= 4e-15*largest
        before = step
    if not last:
        for at in which:
            q[at] = math.nan
