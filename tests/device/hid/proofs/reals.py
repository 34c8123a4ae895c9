"""A query about whole numbers as one about real ones, for z3's solver for polynomials. What no real numbers satisfy no whole ones do; a < b of
whole numbers is kept as a + 1 <= b."""
import z3

PASSED = {z3.Z3_OP_AND: z3.And, z3.Z3_OP_OR: z3.Or, z3.Z3_OP_NOT: z3.Not, z3.Z3_OP_ITE: z3.If, z3.Z3_OP_LE: lambda a, b: a <= b,
          z3.Z3_OP_GE: lambda a, b: a >= b, z3.Z3_OP_LT: lambda a, b: a + 1 <= b, z3.Z3_OP_GT: lambda a, b: a >= b + 1, z3.Z3_OP_EQ: lambda a, b: a == b,
          z3.Z3_OP_UMINUS: lambda a: -a, z3.Z3_OP_ADD: lambda *terms: sum(terms[1:], terms[0]), z3.Z3_OP_SUB: lambda a, b: a - b}


class NotReal(Exception):
    """A division or remainder of whole numbers."""


def product(*factors):
    made = factors[0]
    for factor in factors[1:]:
        made = made * factor
    return made


def negation(expr, cache):
    """Of comparisons the other one, so that whole numbers stay a whole apart."""
    kind, parts = expr.decl().kind(), expr.children()
    if kind in (z3.Z3_OP_LE, z3.Z3_OP_GE, z3.Z3_OP_LT, z3.Z3_OP_GT):
        a, b = (real(part, cache) for part in parts)
        return {z3.Z3_OP_LE: lambda: a >= b + 1, z3.Z3_OP_GE: lambda: a + 1 <= b, z3.Z3_OP_LT: lambda: a >= b, z3.Z3_OP_GT: lambda: a <= b}[kind]()
    if kind in (z3.Z3_OP_AND, z3.Z3_OP_OR):
        return (z3.Or if kind == z3.Z3_OP_AND else z3.And)([negation(part, cache) for part in parts])
    if kind == z3.Z3_OP_NOT:
        return real(parts[0], cache)
    if kind == z3.Z3_OP_EQ and z3.is_int(parts[0]):
        a, b = (real(part, cache) for part in parts)
        return z3.Or(a + 1 <= b, a >= b + 1)
    return z3.Not(real(expr, cache))


def real(expr, cache):
    number = expr.get_id()
    if number not in cache:
        cache[number] = (expr, convert(expr, cache))
    return cache[number][1]


def convert(expr, cache):
    kind = expr.decl().kind()
    if z3.is_int_value(expr):
        return z3.RealVal(expr.as_long())
    if kind == z3.Z3_OP_UNINTERPRETED and expr.num_args() == 0:
        return z3.Real(expr.decl().name()) if z3.is_int(expr) else expr
    if kind == z3.Z3_OP_NOT:
        return negation(expr.arg(0), cache)
    if kind in (z3.Z3_OP_TRUE, z3.Z3_OP_FALSE):
        return expr
    parts = [real(part, cache) for part in expr.children()]
    if kind == z3.Z3_OP_MUL:
        return product(*parts)
    if kind not in PASSED:
        raise NotReal(expr.decl().name())
    return PASSED[kind](*parts)


def impossible(exprs, most_steps):
    """Whether no real numbers satisfy all of these. False says nothing."""
    cache = {}
    try:
        converted = [real(expr, cache) for expr in exprs]
    except NotReal:
        return False
    solver = z3.Tactic("qfnra-nlsat").solver()
    solver.set("rlimit", most_steps)
    solver.add(*converted)
    return solver.check() == z3.unsat


def has_product(exprs):
    """Of two unknown numbers."""
    return any(products_of(expr, first=True) for expr in exprs)


def products_of(expr, first=False):
    """Of two unknown numbers, those that are no part of others; or only whether there is one."""
    found, seen, queue = [], set(), [expr]
    while queue and not (first and found):
        part = queue.pop()
        if part.get_id() not in seen:
            seen.add(part.get_id())
            if part.decl().kind() == z3.Z3_OP_MUL and sum(not z3.is_int_value(factor) for factor in part.children()) > 1:
                found.append(part)
            else:
                queue += part.children()
    return found
