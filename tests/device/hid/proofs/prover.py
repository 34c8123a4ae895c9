"""The solver, and the count of what was to be shown and how. Every variable comes with facts that hold of it wherever it occurs: the interval
it was made with, or what a division means."""
import collections
import itertools

import z3

import reals
from terms import Cond, Int, Raw, expr_of, is_exact, negate

# Steps of the solver, not seconds: the same on any machine. About ten seconds.
MOST_STEPS = 20_000_000
FEW_STEPS = 300_000
STEPS_TOGETHER = 3_000_000


class NotProved(Exception):
    """Where one failure is enough."""


class Prover:
    """steps: how long to try; patient: whether what is not shown is only noted, and not the end."""

    def __init__(self, steps=MOST_STEPS, patient=True):
        self.steps, self.patient, self.occurring, self.linear, self.reached = steps, patient, {}, {}, {}
        self.facts, self.made, self.counter = collections.defaultdict(list), {}, itertools.count()
        self.counts, self.failures, self.products, self.without = collections.Counter(), [], {}, {}

    def fresh(self, name, width, lo, hi, align=1):
        """A number of which only the interval is known; a multiple of align."""
        variable = z3.Int(f"{name}!{next(self.counter)}")
        if align > 1:
            self.fact(variable, variable * align >= lo, variable * align <= hi)
            return Int(variable * align, lo, hi, width, align)
        self.fact(variable, variable >= lo, variable <= hi)
        return Int(variable, lo, hi, width)

    def fresh_cond(self, name):
        return Cond(z3.Bool(f"{name}!{next(self.counter)}"))

    def fact(self, variable, *facts):
        self.facts[variable.decl().name()] += facts

    def once(self, key, make):
        """What make() gives, the same again for the same key; the terms of a key stay alive in it."""
        number = tuple(part.get_id() if z3.is_expr(part) else part for part in key)
        if number not in self.made:
            self.made[number] = (key, make())
        return self.made[number][1]

    def signed(self, value):
        if isinstance(value, Raw):
            lo, hi = value.bounds or (-(1 << value.width - 1), (1 << value.width - 1) - 1)
            return self.once(("signed", value.name), lambda: self.link(value, self.named(f"{value.name}.s", lo, hi, value.width)))
        half, whole = 1 << value.width - 1, 1 << value.width
        if -half <= value.lo and value.hi < half:
            return value
        value = self.unsigned(value)
        if is_exact(value):
            return Int(value.term - whole, value.term - whole, value.term - whole, value.width)
        return Int(z3.If(value.term >= half, value.term - whole, value.term), -half, half - 1, value.width)

    def unsigned(self, value):
        if isinstance(value, Raw):
            return self.once(("unsigned", value.name), lambda: self.link(value, self.named(f"{value.name}.u", 0, (1 << value.width) - 1, value.width)))
        whole = 1 << value.width
        if 0 <= value.lo and value.hi < whole:
            return value
        if is_exact(value):
            return Int(value.term % whole, value.term % whole, value.term % whole, value.width)
        if -whole <= value.lo and value.hi < whole:
            return Int(z3.If(value.term < 0, value.term + whole, value.term), 0, whole - 1, value.width)
        return Int(value.term % whole, 0, whole - 1, value.width)

    def named(self, name, lo, hi, width):
        variable = z3.Int(name)
        self.fact(variable, variable >= lo, variable <= hi)
        return Int(variable, lo, hi, width)

    def link(self, value, made):
        """The signed and the unsigned reading of the same bits."""
        signed, unsigned = z3.Int(f"{value.name}.s"), z3.Int(f"{value.name}.u")
        if value.width > 1:
            self.fact(made.term, unsigned == z3.If(signed < 0, signed + (1 << value.width), signed))
            half = 1 << value.width - 1
            self.fact(made.term, signed >= -half, signed < half, unsigned >= 0, unsigned < 2 * half)
        return made

    def truth(self, value):
        """The condition in a bool, which C says is 0 or 1."""
        if isinstance(value, Raw):
            return self.once(("truth", value.name), lambda: self.truth_of(value))
        if value.cond is not None:
            return value.cond
        if is_exact(value):
            return bool(value.term & 1)
        return Cond(value.term % 2 == 1)

    def truth_of(self, value):
        made, number = z3.Bool(f"{value.name}.b"), z3.Int(f"{value.name}.u")
        self.fact(made, number == z3.If(made, 1, 0))
        self.fact(number, number == z3.If(made, 1, 0))
        return Cond(made)

    def names_in(self, expr):
        """The variables that occur in it."""
        number = expr.get_id()
        if number not in self.occurring:
            seen, names, queue = set(), set(), [expr]
            while queue:
                part = queue.pop()
                if part.get_id() not in seen:
                    seen.add(part.get_id())
                    if z3.is_const(part) and part.decl().kind() == z3.Z3_OP_UNINTERPRETED:
                        names.add(part.decl().name())
                    queue += part.children()
            self.occurring[number] = (expr, frozenset(names))
        return self.occurring[number][1]

    def facts_of(self, exprs):
        """All facts of the variables that occur, and of those in these facts; and the names of all."""
        names, found, queue = set(), [], [name for expr in exprs for name in self.names_in(expr)]
        while queue:
            name = queue.pop()
            if name not in names:
                names.add(name)
                found += self.facts[name]
                queue += [other for fact in self.facts[name] for other in self.names_in(fact)]
        return found, names

    def spoken_of(self, expr):
        """The names of facts_of, remembered: what comes to be known later changes what is tried first, and nothing that is shown."""
        number = expr.get_id()
        if number not in self.reached:
            self.reached[number] = (expr, self.facts_of([expr])[1])
        return self.reached[number][1]

    def is_linear(self, expr):
        number = expr.get_id()
        if number not in self.linear:
            self.linear[number] = (expr, not reals.has_product([expr]))
        return self.linear[number][1]

    def prove(self, state, goal, label, using=None):
        """Whether goal follows from the path; what does not is a failure. using: only these conditions of the path."""
        how = self.try_to(state, goal, using)
        self.counts[how] += 1
        if how in ("refuted", "not shown"):
            self.failures.append(f"{label}: {how}")
            if not self.patient:
                raise NotProved(self.failures[-1])
            return False
        return True

    def prove_all(self, state, goals):
        """goals: [(label, condition)]. What is shown of all at once, since the path is the same, is not shown one by one."""
        left = [(label, goal) for label, goal in goals if state.decided(goal) is not True]
        shown = self.together(state, [goal for _, goal in left if isinstance(goal, Cond)])
        self.counts["by intervals"] += len(goals) - len(left)
        self.counts["by integers"] += len(shown)
        for label, goal in left:
            if not any(goal is one for one in shown):
                self.prove(state, goal, label)

    def together(self, state, goals):
        """Those of the goals that follow from the path whatever the products are. The solver is asked for all; then without those that its answer
        breaks."""
        path = [expr_of(cond) for cond in state.path]
        while goals:
            exprs = [z3.Or([negate(goal).expr for goal in goals]), *path]
            solver = z3.Solver()
            solver.set("rlimit", STEPS_TOGETHER)
            solver.add(*(self.linearised(expr) for expr in [*exprs, *self.facts_of(exprs)[0]]))
            found = solver.check()
            if found == z3.unsat:
                return goals
            model = solver.model() if found == z3.sat else None
            kept = [goal for goal in goals if model is not None and z3.is_true(model.eval(self.linearised(goal.expr), model_completion=True))]
            if len(kept) == len(goals):
                return []
            goals = kept
        return []

    def linearised(self, expr):
        """The same with a number of its own in place of each product."""
        number = expr.get_id()
        if number not in self.without:
            products = reals.products_of(expr)
            for product in products:
                self.products.setdefault(product.get_id(), (product, z3.Int(f"product!{len(self.products)}")))
            made = z3.substitute(expr, *(self.products[product.get_id()] for product in products)) if products else expr
            self.without[number] = (expr, made)
        return self.without[number][1]

    def try_to(self, state, goal, using=None, steps=None):
        """How it is shown: by intervals, integers or real algebra; or not shown, or refuted."""
        goal = state.decided(goal)
        if goal is True:
            return "by intervals"
        wanted = z3.BoolVal(True) if goal is False else negate(goal).expr
        path = [expr_of(cond) for cond in (state.path if using is None else using)]
        attempts, most = self.attempts(wanted, path), steps or self.steps
        whole = attempts[-1]
        # What is easy is not to wait for what is hard: all are tried for a little, then for long.
        for budget in sorted({min(FEW_STEPS, most), most}):
            left = []
            for premises in attempts:
                how, found = self.attempt([wanted, *premises], budget)
                if found == z3.unsat:
                    return how
                if found == z3.sat and premises is whole:
                    return "refuted"
                if found == z3.unknown:
                    left.append(premises)
            attempts = left
        return "not shown"

    def attempt(self, exprs, steps):
        """(how, what the solver found) of these and all facts of what occurs in them."""
        query = [*exprs, *self.facts_of(exprs)[0]]
        if reals.has_product(query) and reals.impossible(query, steps):
            return "by real algebra", z3.unsat
        solver = z3.Solver()
        solver.set("rlimit", steps)
        solver.add(*query)
        return "by integers", solver.check()

    def attempts(self, wanted, path):
        """First what speaks of just what the goal speaks of, as a comparison of the code's that the goal says in other words; then of no more;
        then the whole path. Without products first."""
        names = self.facts_of([wanted])[1]
        near = [expr for expr in path if self.spoken_of(expr) <= names]
        found = {}
        for premises in ([expr for expr in near if self.names_in(expr) == self.names_in(wanted)], near, path):
            for some in ([expr for expr in premises if self.is_linear(expr)], premises) if self.is_linear(wanted) else (premises,):
                key = tuple(expr.get_id() for expr in some)
                found.pop(key, None)
                found[key] = some
        return list(found.values())
