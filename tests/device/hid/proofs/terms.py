"""Numbers and conditions of the proofs. An Int stands for w bits by a whole number, exact or a z3 term, that agrees with them modulo 2^w, and
knows an interval it lies in; so most obligations need no solver. A condition is True, False, or a Cond: a z3 formula with what follows for
single terms where it holds and where it does not."""
import z3


class Int:
    """cond: the condition this is 1 for and 0 without, if it was made of one. align: a power of two that divides it."""
    __slots__ = ("term", "lo", "hi", "width", "align", "cond")

    def __init__(self, term, lo, hi, width, align=1, cond=None):
        self.term, self.lo, self.hi, self.width, self.align, self.cond = term, lo, hi, width, align, cond


class Raw:
    """Bits nobody knows: what they are read as, signed, unsigned or a bool, is decided by who reads. bounds: of the signed number, if known."""
    __slots__ = ("name", "width", "bounds")

    def __init__(self, name, width, bounds=None):
        self.name, self.width, self.bounds = name, width, bounds


class Cond:
    """yes and no: lists of (term, lo, hi)."""
    __slots__ = ("expr", "yes", "no")

    def __init__(self, expr, yes=(), no=()):
        self.expr, self.yes, self.no = expr, tuple(yes), tuple(no)


def exact(number, width):
    return Int(number, number, number, width, number & -number if number else 1 << 80)


def is_exact(value):
    return isinstance(value, Int) and isinstance(value.term, int)


def expr_of(cond):
    return z3.BoolVal(cond) if isinstance(cond, bool) else cond.expr


def negate(cond):
    if isinstance(cond, bool):
        return not cond
    inner = cond.expr.arg(0) if z3.is_not(cond.expr) else z3.Not(cond.expr)
    return Cond(inner, cond.no, cond.yes)


def both(left, right):
    if isinstance(left, bool):
        return right if left else False
    if isinstance(right, bool):
        return left if right else False
    return Cond(z3.And(left.expr, right.expr), left.yes + right.yes)


def either(left, right):
    return negate(both(negate(left), negate(right)))


def all_of(conds):
    result = True
    for cond in conds:
        result = both(result, cond)
    return result


def implies(left, right):
    return either(negate(left), right)


def choose(cond, left, right):
    """Of two conditions."""
    if isinstance(cond, bool):
        return left if cond else right
    return both(either(negate(cond), left), either(cond, right)) if isinstance(left, bool) or isinstance(right, bool) else Cond(
        z3.If(cond.expr, left.expr, right.expr))


def holds(expr):
    """A condition of a formula written by hand."""
    return expr if isinstance(expr, bool) else Cond(expr)


def same(left, right):
    """Two values that are one and the same for sure."""
    if left is right:
        return True
    if isinstance(left, Raw) and isinstance(right, Raw):
        return (left.name, left.width) == (right.name, right.width)
    if isinstance(left, Int) and isinstance(right, Int) and left.width == right.width:
        if isinstance(left.term, int) or isinstance(right.term, int):
            return isinstance(left.term, int) and isinstance(right.term, int) and left.term == right.term
        return left.term.eq(right.term)
    return type(left) is type(right) and not isinstance(left, (Int, Raw, Cond)) and left == right


def compare(op, left, right):
    """slt and the like on numbers already read as signed or unsigned; intervals as they stand."""
    a, b = left.term, right.term
    if op == "eq":
        if left.hi < right.lo or left.lo > right.hi:
            return False
        if left.lo == left.hi == right.lo == right.hi or same(left, right):
            return True
        facts = [(a, right.lo, right.hi), (b, left.lo, left.hi)]
        return Cond(a == b, [fact for fact in facts if not isinstance(fact[0], int)])
    if op == "lt":
        if left.hi < right.lo:
            return True
        if left.lo >= right.hi:
            return False
        yes = [(a, None, right.hi - 1), (b, left.lo + 1, None)]
        no = [(a, right.lo, None), (b, None, left.hi)]
        keep = [[fact for fact in facts if not isinstance(fact[0], int)] for facts in (yes, no)]
        return Cond(a < b, *keep)
    raise ValueError(op)
