"""The list of systems, filled by a decorator, in the order they are written."""
SYSTEMS = {}


def system(how, error=None, name=None):
    """Register a function that returns (coordinates, equilibrium, what `squares` needs and `symmetry`).

    The name is that of the model file, with its folder below models/; the function's own unless given."""
    def keep(function):
        SYSTEMS[name or function.__name__] = (how, error, function)
        return function
    return keep


def family(*names):
    """Names of coordinates: family("x", "y"), family("x", 3), family("r", 4, 3)."""
    if len(names) == 1 or isinstance(names[1], str):
        return list(names)
    name, *ranges = names
    indices = [[]]
    for n in ranges:
        indices = [i + [k] for i in indices for k in range(1, n + 1)]
    return [f"{name}[{','.join(map(str, i))}]" for i in indices]
