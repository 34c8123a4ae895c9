"""What callers may rely on of the three functions with hard arithmetic, and the invariants of their loops. numeric_claims.py shows each; what
calls them only assumes it."""
import z3

import lemmas
from state import Unsupported
from terms import all_of, both, compare, either, exact, holds, is_exact, negate

# What clamp is called with: |v| to 2^62, most below 2^30.
WIDEST, MOST = 1 << 62, (1 << 30) - 1
LONGEST = (1 << 31) - 1


def at_most(a, b):
    return negate(compare("lt", b, a))


def within(value, lo, hi):
    return both(at_most(exact(lo, 64), value), at_most(value, exact(hi, 64)))


def term(value):
    return z3.IntVal(value.term) if isinstance(value.term, int) else value.term


def part_of(part, whole):
    return holds(lemmas.between(term(part), term(whole)))


def square_sum(values):
    return sum((term(value) * term(value) for value in values[1:]), term(values[0]) * term(values[0]))


def read_three(executor, state, pointer):
    held = state.memory[pointer.object]
    return [state.narrowed(executor.prover.signed(held.load(pointer.offset + 8 * i, 8))) for i in range(3)]


def root_up(executor, state, arguments):
    """The square root, rounded up."""
    square = state.narrowed(executor.prover.unsigned(arguments[0]))
    root = executor.prover.fresh("root_up", 64, 0, 1 << 32)
    state.assume(holds(term(root) * term(root) >= term(square)))
    state.assume(either(compare("eq", root, exact(0, 64)), holds((term(root) - 1) * (term(root) - 1) < term(square))))
    state.marks = {**state.marks, "root_up": (square, root, dict(state.memory))}
    return [(state, root)]


def clamp(executor, state, arguments):
    """v is shortened to most, along itself; False: it was within and stays."""
    prover, (pointer, most) = executor.prover, arguments
    most = state.narrowed(prover.signed(most))
    before = read_three(executor, state, pointer)
    for value in before:
        prover.prove(state, within(value, -WIDEST, WIDEST), "clamp is called with a wrench beyond 2^62")
    prover.prove(state, within(most, 0, MOST), "clamp is called with a limit of 2^30 or more")
    cut = prover.fresh_cond("cut")
    after = [prover.fresh("clamped", 64, max(-most.hi, min(value.lo, 0)), min(most.hi, max(value.hi, 0))) for value in before]
    for cell, value, old in zip(range(3), after, before):
        state.writable(pointer.object).store(pointer.offset + 8 * cell, 8, value)
        state.assume(part_of(value, old))
        state.assume(within(value, -most.hi, most.hi))
        state.assume(either(cut, compare("eq", value, old)))
    state.assume(holds(square_sum(after) <= term(most) * term(most)))
    state.marks = {**state.marks, "clamp": state.marks.get("clamp", ()) + ((before, after, most, cut),)}
    return [(state, cut)]


def sound_gains(view):
    """PROFILE.md, section 4: what an affine command must be. view: of its fields and of the limits."""
    k = [view.signed(f"k_npm[{i}]") for i in range(6)]
    conds = [at_most(exact(0, 16), entry) for entry in k[:3]]
    for name, limit in (("b_mnspm", "affine_b_max_mnspm"), ("kr_mnmprad", "affine_kr_max_mnmprad"), ("br_10unmsprad", "affine_br_max_10unmsprad")):
        conds += [at_most(view.unsigned(f"{name}[{i}]"), view.limit(limit)) for i in range(3)]
    for row in ((0, 3, 4), (3, 1, 5), (4, 5, 2)):
        total = sum(z3.If(term(k[i]) < 0, -term(k[i]), term(k[i])) for i in row)
        conds.append(holds(z3.simplify(total <= term(view.limit("affine_k_max_npm")))))
    raised = [term(entry) + (2 if number < 3 else 0) for number, entry in enumerate(k)]
    return conds + [holds(z3.simplify(minor >= 0)) for minor in lemmas.minors_of(raised)]


def affine_is_sound(view_of):
    """The contract of hap_affine_is_sound: two ways on, refused, or taken with all that PROFILE.md asks."""
    def contract(executor, state, arguments):
        refused, taken = state, state.copy()
        for cond in sound_gains(view_of(executor, taken, arguments[1])):
            if not taken.assume(cond):
                return [(refused, False)]
        return [(refused, False), (taken, True)]
    return contract


def cell(executor, frame, state, name, signed=True):
    """A local number, by its name in the source."""
    held = state.memory[f"{frame.function.name}#{frame.depth}.{name}"]
    return state.narrowed((executor.prover.signed if signed else executor.prover.unsigned)(held.load(0, held.size)))


def set_cell(frame, state, name, value):
    held = state.writable(f"{frame.function.name}#{frame.depth}.{name}")
    held.store(0, held.size, value)


def root_loop(executor, frame, state):
    """At the head of root_up's loop: root^2 <= square < (root + step)^2, root a multiple of step, which halves from 2^33 to 1.
    Of the ways that come here one goes on, from all roots for which that holds."""
    prover = executor.prover
    square, bit, root = (cell(executor, frame, state, name, False) for name in ("square.addr", "bit", "root"))
    if not is_exact(bit):
        raise Unsupported("root_up: a bit that is not known")
    step = max(2 * bit.term, 1)
    room = max((1 << 32) - step, 0)
    bounds = lambda value: holds(z3.And(term(value) * term(value) <= term(square), term(square) < (term(value) + step) * (term(value) + step)))
    prover.prove(state, bounds(root), f"root_up: the root lies within {step}")
    prover.prove(state, within(root, 0, room), f"root_up: the root is below 2^32 by {step}")
    prover.prove(state, root.align >= step, f"root_up: the root is a multiple of {step}")
    if (frame.depth, step) in executor.gone_on:
        return None
    executor.gone_on.add((frame.depth, step))
    if "root_up" not in state.marks:
        state.marks["root_up"] = len(state.path)
    state.forget_since(state.marks["root_up"])
    root = prover.fresh("root", 64, 0, room, step) if room else exact(0, 64)
    set_cell(frame, state, "root", root)
    state.assume(bounds(root))
    return state


def halving_loop(executor, frame, state):
    """At the head of clamp's `while`: v is a part of what it was, below 2^62, its first components short already; and it is as it was, or has a
    component of 2^30 or more, which is beyond any limit. Each round leaves v[i] smaller, so it ends."""
    prover = executor.prover
    pointer = state.memory[f"clamp#{frame.depth}.v.addr"].load(0, 8)
    now, done = read_three(executor, state, pointer), cell(executor, frame, state, "i").term
    before = state.marks.setdefault("clamp_entry", now)

    def invariant(v):
        untouched = all_of(compare("eq", value, old) for value, old in zip(v, before))
        large = all_of(within(value, -MOST, MOST) for value in v)
        return [part_of(value, old) for value, old in zip(v, before)] + [either(untouched, negate(large))]
    for number, cond in enumerate(invariant(now)):
        prover.prove(state, cond, f"clamp: invariant {number} of the halving")
    for value in now[:done]:
        prover.prove(state, within(value, -LONGEST, LONGEST), "clamp: what is short stays short")
    mark = state.marks.get("halving")
    if mark and mark[0] == done:
        check_only_changed(state, mark[1], (pointer.object, f"clamp#{frame.depth}.k"))
        old, new = mark[2][done], now[done]
        prover.prove(state, holds(z3.If(term(old) > 0, z3.And(term(new) < term(old), term(new) >= 0), z3.And(term(new) > term(old), term(new) <= 0))),
                     "clamp: the halving ends")
        return None
    havoc = [prover.fresh("halved", 64, *((-LONGEST, LONGEST) if i < done else (-WIDEST, WIDEST))) for i in range(3)]
    for i, value in enumerate(havoc):
        state.writable(pointer.object).store(pointer.offset + 8 * i, 8, value)
    state.writable(f"clamp#{frame.depth}.k").cells.clear()
    for cond in invariant(havoc):
        state.assume(cond)
    state.marks["halving"] = (done, state.memory.copy(), havoc)
    return state


def check_only_changed(state, before, names):
    """A loop that changes more than its invariant speaks of is not shown."""
    for name, held in state.memory.items():
        if name not in names and (held.cells != before[name].cells or held.layers != before[name].layers):
            raise Unsupported(f"a loop changes {name}")


CUTS = {("root_up", "%for.cond"): root_loop, ("clamp", "%while.cond"): halving_loop}
