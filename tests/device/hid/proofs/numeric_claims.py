"""The claims of the functions with hard arithmetic: the root, the shortening of a wrench, and which gains a device takes."""
import contracts
import lemmas
from contracts import MOST, WIDEST, at_most, holds, part_of, read_three, square_sum, term
from executor import new_state
from state import Pointer
from terms import Int, all_of, compare, either, exact, negate


def apply(prover, state, lemma, label):
    """Shows the premises of a lemma here, then its conclusion may be used."""
    premises, conclusion = lemma
    for premise in premises:
        prover.prove(state, holds(premise), label)
    state.assume(holds(conclusion))


def check_root(executor, _layout):
    """root_up: the smallest whole number whose square is not below."""
    prover = executor.prover
    executor.apart.add("root_up")
    square = prover.named("square", 0, (1 << 64) - 1, 64)
    for state, root in executor.execute(new_state(), "root_up", [square], merge=False):
        root = prover.signed(root)
        prover.prove(state, holds(term(root) * term(root) >= term(square)), "root_up: no less than the root")
        above = state.copy()
        if above.assume(holds(term(root) >= 1)):
            prover.prove(above, holds((term(root) - 1) * (term(root) - 1) < term(square)), "root_up: no more than it has to be")
        prover.prove(state, at_most(root, exact(1 << 32, 64)), "root_up: at most 2^32")


def check_clamp(executor, _layout):
    """clamp: never longer than most, the same direction, and as it was where it was short enough."""
    prover, state = executor.prover, new_state()
    pointer = state.add("v", 24, "raw")
    before = [prover.named(f"v{i}", -WIDEST, WIDEST, 64) for i in range(3)]
    for i in range(3):
        state.writable("v").store(8 * i, 8, before[i])
    most = prover.named("most", 0, MOST, 64)
    for one, cut in executor.execute(state, "clamp", [pointer, most], merge=False):
        after = read_three(executor, one, pointer)
        if cut is not True:
            prover.prove(one, cut is False, "clamp: says whether it cut")
            check_left(prover, one, before, after, most)
        else:
            check_cut(executor, one, before, after, most)


def check_left(prover, state, before, after, most):
    for axis in "xyz":
        i = "xyz".index(axis)
        far = either(compare("lt", exact(MOST, 64), after[i]), compare("lt", after[i], exact(-MOST, 64)))
        beyond = state.copy()
        if beyond.assume(far):
            apply(prover, beyond, lemmas.long_component(term(after[i]), term(after[(i + 1) % 3]), term(after[(i + 2) % 3]), term(most)),
                  "clamp: a component beyond the limit")
            prover.prove(beyond, False, "clamp: what was halved is cut")
        state.assume(negate(far))
    for old, new in zip(before, after):
        prover.prove(state, compare("eq", old, new), "clamp: what is short enough stays")
    prover.prove(state, holds(square_sum(after) <= term(most) * term(most)), "clamp: what stays is short enough")


def check_cut(executor, state, before, after, most):
    prover = executor.prover
    square, length, memory = state.marks["root_up"]
    held = state.copy()
    held.memory = memory
    whole = read_three(executor, held, Pointer("v", 0))
    prover.prove(state, compare("lt", exact(0, 64), length), "clamp: the length is above 0")
    for new, old in zip(after, whole):
        back, product = term(new) * term(length), term(old) * term(most)
        apply(prover, state, lemmas.square_of_part(back, product), "clamp: each component is its share or less")
    prover.prove(state, holds(square_sum(whole) == term(square)), "clamp: the square is that of v")
    apply(prover, state, lemmas.shortened([term(v) for v in after], [term(v) for v in whole], term(length), term(most)), "clamp: v is shortened")
    prover.prove(state, holds(square_sum(after) <= term(most) * term(most)), "clamp: no longer than the limit")
    parts = []
    for new, half, old in zip(after, whole, before):
        apply(prover, state, lemmas.square_of_part(term(half), term(old)), "clamp: halving lengthens nothing")
        parts.append(holds(term(half) * term(half) <= term(old) * term(old)))
        apply(prover, state, lemmas.share(term(new), term(half), term(length), term(most)), "clamp: the direction stays")
        apply(prover, state, lemmas.part_of_part(term(new), term(half), term(old)), "clamp: the direction stays, whatever was halved")
        prover.prove(state, part_of(new, old), "clamp: the direction stays, whatever was halved")
    too_long = compare("lt", exact(0, 64), Int(square_sum(whole) - term(most) * term(most), -1 << 128, 1 << 128, 64))
    prover.prove(state, too_long, "clamp: what is cut was too long when it was halved")
    prover.prove(state, holds(square_sum(before) > term(most) * term(most)), "clamp: only what is too long is cut", [*parts, too_long])
    for number in range(3):
        a, b, c = (term(after[(number + i) % 3]) for i in range(3))
        apply(prover, state, lemmas.component(a, b, c, term(most)), "clamp: each component")
        prover.prove(state, contracts.within(after[number], -MOST, MOST), "clamp: each component is within the limit")


HOW = ("by intervals", "by integers", "by real algebra")


class GainsView:
    """The fields of an affine command at a pointer, and the limits of the device's settings."""

    def __init__(self, executor, state, layout, pointer, device="device"):
        self.executor, self.state, self.layout, self.pointer, self.device = executor, state, layout, pointer, device

    def load(self, object_name, start, key):
        offset, size = self.layout[key]
        return self.state.memory[object_name].load(start + offset, size)

    def signed(self, field):
        return self.state.narrowed(self.executor.prover.signed(self.load(self.pointer.object, self.pointer.offset, ("HapAffine", field))))

    def unsigned(self, field):
        return self.state.narrowed(self.executor.prover.unsigned(self.load(self.pointer.object, self.pointer.offset, ("HapAffine", field))))

    def limit(self, field):
        return self.state.narrowed(self.executor.prover.unsigned(self.load(self.device, 0, ("HapDevice", f"settings.{field}"))))


def check_gains(executor, layout):
    """hap_affine_is_sound says yes exactly where PROFILE.md does; and then K + 2 N/m gives nothing along any displacement."""
    prover, state = executor.prover, new_state()
    device = state.add("device", executor.module.types["%struct.HapDevice"].size(), "raw")
    affine = state.add("affine", executor.module.types["%struct.HapAffine"].size(), "raw")
    executor.ends_apart.add("gives_nothing")
    rules = contracts.sound_gains(GainsView(executor, state, layout, affine))
    for one, taken in executor.execute(state, "hap_affine_is_sound", [device, affine], merge=False):
        yes, no = one.copy(), one
        if yes.assume(taken):
            for rule in rules:
                prover.prove(yes, rule, "hap_affine_is_sound: what is taken breaks no rule")
        if no.assume(negate(taken)):
            broken = first_broken(prover, no, rules)
            prover.prove(no, negate(all_of(rules) if broken is None else broken), "hap_affine_is_sound: what is refused breaks a rule")


def first_broken(prover, state, rules):
    """The rule that the last condition of the path breaks, and that speaks of the same numbers; it is looked for, since to refute all together takes
    long."""
    names = prover.names_in(state.path[-1].expr)
    for rule in rules:
        if not isinstance(rule, bool) and prover.names_in(rule.expr) == names and prover.try_to(state, negate(rule), state.path[-1:], 200_000) in HOW:
            return rule
    return None


CHECKS = {"root_up": check_root, "clamp": check_clamp, "hap_affine_is_sound": check_gains}
