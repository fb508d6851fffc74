

def _values(p):
    return [p[name] for name in PARAMETERS] if isinstance(p, dict) else p


def _solve(m, b):
    n = len(b)
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(m[i][k]))
        m[k], m[best], b[k], b[best] = m[best], m[k], b[best], b[k]
        for i in range(k + 1, n):
            factor = m[i][k]/m[k][k]
            for j in range(k, n):
                m[i][j] -= factor*m[k][j]
            b[i] -= factor*b[k]
    for k in reversed(range(n)):
        b[k] = (b[k] - sum(m[k][j]*b[j] for j in range(k + 1, n)))/m[k][k]
    return b
