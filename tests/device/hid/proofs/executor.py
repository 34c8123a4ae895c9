"""Executes functions of the IR on unknown inputs. At a branch that can go either way both are followed and made one again where they meet, if
their memory differs in a few numbers only. Every trap of the sanitizer, every access to memory and every cast that could lose bits is an
obligation for the prover; what was shown is assumed afterwards."""
import arithmetic
from ir import Type
from state import Pointer, State, Unsupported, cells_that_differ
from terms import Cond, Int, Raw, all_of, both, choose, compare, either, exact, expr_of, is_exact, negate, same
import z3

TRAPS = {0: "sum", 3: "division", 7: "conversion", 12: "product", 18: "index", 20: "shift", 21: "difference"}


class Frame:
    def __init__(self, function, depth, apart):
        self.function, self.depth, self.apart, self.returns, self.allocated = function, depth, apart, [], []


def find_exits(function):
    """For every block the nearest that each way to the end goes through; traps end nothing."""
    blocks = [label for label in function.blocks if not function.traps(label)]
    after = {label: [target for target in function.successors(label) if not function.traps(target)] for label in blocks}
    behind = {label: set(blocks) for label in blocks}
    changed = True
    while changed:
        changed = False
        for label in reversed(blocks):
            common = set.intersection(*(behind[target] for target in after[label])) if after[label] else set()
            if behind[label] != common | {label}:
                behind[label], changed = common | {label}, True
    for label in blocks:
        strict = behind[label] - {label}
        function.exits[label] = next((one for one in strict if behind[one] == strict), None)


class Executor:
    """contracts: {function: (executor, state, arguments) -> [(state, result)]}, instead of its body. cuts: {(function, block): a loop's
    handler, (executor, frame, state) -> state or None}. wraps: {(function, kind)} of what may wrap on purpose. apart:
    functions whose ways are not made one again, where a cut bounds their number; ends_apart: those whose returns are not."""

    def __init__(self, module, prover, contracts, cuts, wraps):
        self.module, self.prover, self.contracts, self.cuts, self.wraps = module, prover, contracts, cuts, wraps
        self.activations, self.apart, self.ends_apart, self.gone_on = 0, set(), set(), set()
        for function in module.functions.values():
            find_exits(function)

    # Values.

    def value(self, state, operand, kind):
        if isinstance(operand, int):
            return Pointer("null", 0) if kind.kind == "pointer" else exact(operand, kind.width)
        if isinstance(operand, tuple):
            _, base, typed = operand
            return self.address(state, base, typed)
        if operand.startswith("@"):
            name = operand[1:]
            if name not in state.memory:
                data = self.module.constants[name]
                state.add(name, len(data), data)
            return Pointer(name, 0)
        return state.registers[operand]

    def number(self, state, operand, kind, signed=True):
        value = self.value(state, operand, kind)
        return state.narrowed((self.prover.signed if signed else self.prover.unsigned)(value))

    def condition(self, state, operand):
        if isinstance(operand, int):
            return bool(operand)
        value = state.registers[operand]
        return state.decided(value if isinstance(value, (bool, Cond)) else self.prover.truth(value))

    # Memory.

    def address(self, state, base, typed):
        (_, start), *indices = typed
        pointer = self.value(state, start, typed[0][0])
        offset, index, kind = pointer.offset, pointer.index, Type("array", 0, base)
        for index_type, operand in indices:
            if kind.kind == "struct":
                offset += kind.offset(operand)
                kind = kind.fields[operand]
                continue
            kind = kind.of
            number = self.number(state, operand, index_type)
            if is_exact(number):
                offset += number.term * kind.size()
                continue
            summary = state.memory[pointer.object].summary
            if index is not None or summary is None or (offset, kind.size()) != (summary.start, summary.stride):
                raise Unsupported(f"an unknown index into {pointer.object}")
            self.prover.prove(state, both(negate(compare("lt", number, exact(0, 64))), compare("lt", number, exact(summary.count, 64))),
                              f"index into {pointer.object}")
            offset, index = 0, number
        return Pointer(pointer.object, offset, index)

    def check_access(self, state, pointer, size, where):
        held = state.memory[pointer.object]
        if pointer.index is None and held.summary and isinstance(size, int) and where != "memset":
            first, last = held.summary.start, held.summary.start + held.summary.stride * held.summary.count
            if pointer.offset < last and first < pointer.offset + size:
                raise Unsupported(f"{where}: an element of {pointer.object} by a known index")
        if pointer.index is not None:
            if not 0 <= pointer.offset <= held.summary.stride - size:
                raise Unsupported(f"{where}: an access beyond an element")
            return
        end = exact(pointer.offset + size, 64) if isinstance(size, int) else size
        room = held.size if isinstance(held.size, Int) else exact(held.size, 64)
        inside = negate(compare("lt", room, end)) if pointer.offset >= 0 else False
        if not self.prover.prove(state, inside, f"{where}: access to {pointer.object} at {pointer.offset}"):
            raise Unsupported(f"{where}: an access beyond {pointer.object}")

    def load(self, state, pointer, size, where="load"):
        self.check_access(state, pointer, size, where)
        held = state.memory[pointer.object]
        if pointer.index is not None:
            self.activations += 1
            return held.load_layer("element", (self.activations, held.summary.bounds), pointer.offset, size)
        return held.load(pointer.offset, size)

    def store(self, state, pointer, size, value, where="store"):
        self.check_access(state, pointer, size, where)
        held = state.memory[pointer.object]
        if pointer.index is None:
            state.writable(pointer.object).store(pointer.offset, size, value)
        elif pointer.offset in held.summary.bounds:
            _, lo, hi = held.summary.bounds[pointer.offset]
            number = state.narrowed(self.prover.signed(value))
            self.prover.prove(state, both(negate(compare("lt", number, exact(lo, 64))), negate(compare("lt", exact(hi, 64), number))),
                              f"{where}: what {pointer.object} remembers")

    def fill(self, state, pointer, byte, count):
        self.check_access(state, pointer, count, "memset")
        if state.memory[pointer.object].summary and byte:
            raise Unsupported("memset of a summary to what is not 0")
        state.writable(pointer.object).cover(pointer.offset, pointer.offset + count, "fill", byte & 0xFF)

    def copy_bytes(self, state, target, source, count):
        self.check_access(state, target, count, "memcpy")
        self.check_access(state, source, count, "memcpy")
        held = state.memory[source.object]
        if source.index is not None:
            self.activations += 1
            layer = ("element", (self.activations, held.summary.bounds))
        else:
            layer = ("copy", (held, source.offset))
        state.writable(target.object).cover(target.offset, target.offset + count, *layer)

    # Functions.

    def call(self, state, name, arguments, merge=True):
        if name in self.contracts:
            return self.contracts[name](self, state, arguments)
        return self.execute(state, name, arguments, merge)

    def execute(self, state, name, arguments, merge=True):
        """[(state, result)], with more than one where they cannot be made one."""
        function, merge = self.module.functions[name], merge and name not in self.ends_apart
        self.activations += 1
        frame, outer = Frame(function, self.activations, not merge), state.registers
        state.registers = dict(zip((parameter for _, parameter in function.parameters), arguments))
        self.run(frame, state, "%entry", None, None)
        returns = frame.returns
        for one, _ in returns:
            one.registers = outer
            one.last_frame = {local: one.memory.pop(local) for local in frame.allocated if local in one.memory}
        return self.merge_returns(returns) if merge and len(returns) > 1 else returns

    def merge_returns(self, returns):
        states = [state for state, _ in returns]
        for state, result in returns:
            state.registers = {**state.registers, "result": result}
        merged = self.merge(states, ["result"])
        for state in merged:
            state.registers = dict(state.registers)
        return [(state, state.registers.pop("result")) for state in merged]

    def run(self, frame, state, label, previous, stop, start=0):
        """[(state, the block it comes from)] of those that reach the block stop; those that return are in the frame."""
        function = frame.function
        while label != stop:
            if start == 0 and (function.name, label) in self.cuts:
                state = self.cuts[function.name, label](self, frame, state)
                if state is None:
                    return []
            if start == 0:
                self.phis(function, state, label, previous)
            instructions = function.blocks[label]
            for number, instruction in enumerate(instructions[start:-1], start):
                if instruction.op == "call" and not instruction.name.startswith("llvm.") or instruction.name and "memcpy" in instruction.name:
                    results = self.do_call(frame, state, instruction)
                    if len(results) != 1:
                        return [end for one in results for end in self.run(frame, one, label, previous, stop, number + 1)]
                    state = results[0]
                elif instruction.op != "phi":
                    arithmetic.step(self, frame, state, instruction)
            start, last = 0, instructions[-1]
            if last.op == "ret":
                result = self.value(state, last.args[0], last.type) if last.args else None
                frame.returns.append((state, result))
                return []
            if last.op == "unreachable":
                raise Unsupported(f"{function.name} reaches {label}")
            target = self.decide(frame, state, last)
            if isinstance(target, list):
                return self.fork(frame, state, label, target, stop)
            label, previous = target, label
        return [(state, previous)]

    def phis(self, function, state, label, previous):
        made = {}
        for instruction in function.blocks[label]:
            if instruction.op != "phi":
                break
            (operand,) = [value for value, source in instruction.args if source == previous]
            if instruction.type.width == 1:
                made[instruction.result] = self.condition(state, operand)
            else:
                made[instruction.result] = self.value(state, operand, instruction.type)
        state.registers.update(made)

    def decide(self, frame, state, last):
        """The next block, or [(block, condition)] where there are several."""
        function = frame.function
        if last.op == "switch":
            value, cases, targets = last.args
            number = self.number(state, value, last.type)
            met = [compare("eq", number, exact(case, last.type.width)) for case in cases]
            ways = list(zip(targets[1:], met)) + [(targets[0], all_of(negate(cond) for cond in met))]
        elif last.args[0] is None:
            return last.args[1][0]
        else:
            cond, (yes, no) = self.condition(state, last.args[0]), last.args[1]
            if function.traps(yes) or function.traps(no):
                return self.pass_trap(frame, state, cond, (yes, no))
            ways = [(yes, cond), (no, negate(cond))]
        open_ways = [way for way in ways if way[1] is not False]
        return open_ways[0][0] if len(open_ways) == 1 or open_ways[0][1] is True else open_ways

    def pass_trap(self, frame, state, cond, targets):
        yes, no = targets
        trap, good, goal = (no, yes, cond) if frame.function.traps(no) else (yes, no, negate(cond))
        code = next(one.args[0][1] if one.args else None for one in frame.function.blocks[trap] if one.op == "call")
        kind = TRAPS.get(code, "other")
        if (frame.function.name, kind) in self.wraps:
            return good
        self.prover.prove(state, goal, f"{frame.function.name}: {kind} in {trap[1:]}")
        state.assume(goal)
        return good

    def fork(self, frame, state, label, ways, stop):
        meet = frame.function.exits[label]
        inner = meet if meet is not None and meet != stop else stop
        ends = []
        for target, cond in ways:
            one = state.copy()
            if one.assume(cond):
                ends += self.run(frame, one, target, label, inner)
        if inner == stop:
            return ends
        for one, previous in ends:
            self.phis(frame.function, one, meet, previous)
        results = [instruction.result for instruction in frame.function.blocks[meet] if instruction.op == "phi"]
        merged = [one for one, _ in ends]
        at_end = frame.function.blocks[meet][-1].op == "ret" and frame.apart
        if len(merged) > 1 and not at_end and frame.function.name not in self.apart:
            merged = self.merge(merged, results)
        start = len(results)
        return [end for one in merged for end in self.run(frame, one, meet, None, stop, start)]

    def merge(self, states, results):
        """One state, where memory differs in a few numbers only, else these states."""
        different = cells_that_differ(states)
        outcomes = [[state.registers.get(result) for state in states] for result in results]
        if different is None or any(isinstance(value, Pointer) and not same(value, values[0]) for values in outcomes for value in values):
            return states
        shared = 0
        while all(len(state.path) > shared and state.path[shared] is states[0].path[shared] for state in states):
            shared += 1
        guards = [all_of(state.path[shared:]) for state in states]
        made = states[0].copy()
        made.path = states[0].path[:shared]
        made.known = {cond.expr.get_id(): cond.expr for cond in made.path}
        made.bounds = self.merge_bounds(states)
        for name, offset, size, values in different:
            if values is None:
                made.writable(name).cells.pop(offset, None)
            else:
                made.writable(name).cells[offset] = (size, self.merge_values(states, guards, values))
        for result, values in zip(results, outcomes):
            made.registers[result] = self.merge_values(states, guards, values)
        return [made]

    def merge_bounds(self, states):
        found = {}
        for number, (term, lo, hi) in states[0].bounds.items():
            others = [state.bounds.get(number) for state in states]
            if all(others):
                los, his = [one[1] for one in others], [one[2] for one in others]
                found[number] = (term, None if None in los else min(los), None if None in his else max(his))
        return found

    def merge_values(self, states, guards, values):
        if all(same(value, values[0]) for value in values):
            return values[0]
        if any(isinstance(value, (bool, Cond)) for value in values):
            conds = [value if isinstance(value, (bool, Cond)) else self.prover.truth(value) for value in values]
            made = conds[-1]
            for guard, cond in zip(guards[-2::-1], conds[-2::-1]):
                made = both(guard, cond) if made is False else either(negate(guard), cond) if made is True else choose_cond(guard, cond, made)
            return made
        if all(isinstance(value, Int) and (value.cond is not None or is_exact(value) and value.term in (0, 1)) for value in values):
            conds = self.merge_values(states, guards, [value.cond if value.cond is not None else bool(value.term) for value in values])
            return arithmetic.number_of(conds, values[0].width)
        signed = any(isinstance(value, Int) and value.lo < 0 or isinstance(value, Raw) and value.bounds for value in values)
        numbers = [state.narrowed((self.prover.signed if signed else self.prover.unsigned)(value)) for state, value in zip(states, values)]
        term = z3.IntVal(numbers[-1].term) if is_exact(numbers[-1]) else numbers[-1].term
        for guard, number in zip(guards[-2::-1], numbers[-2::-1]):
            term = z3.If(expr_of(guard), number.term, term)
        return Int(term, min(one.lo for one in numbers), max(one.hi for one in numbers), numbers[0].width,
                   min(one.align for one in numbers))

    # Calls.

    def do_call(self, frame, state, instruction):
        arguments = [self.value(state, operand, kind) for kind, operand in instruction.args]
        if "memcpy" in instruction.name:
            results = [(one, arguments[0]) for one in self.copy_any(state, arguments)]
        elif instruction.name == "memset":
            self.fill(state, arguments[0], arguments[1].term, arguments[2].term)
            results = [(state, arguments[0])]
        else:
            results = self.call(state, instruction.name, arguments)
        for one, result in results:
            if instruction.result:
                one.registers = {**one.registers, instruction.result: result}
        return [one for one, _ in results]

    def copy_any(self, state, arguments):
        """memcpy; where the count is unknown, of so much the contents are unknown."""
        target, source, count = arguments[:3]
        count = state.narrowed(self.prover.unsigned(count))
        state.marks = {**state.marks, "copied": (target.object, target.offset, count)}
        if is_exact(count):
            self.copy_bytes(state, target, source, count.term)
            return [state]
        values = self.values_of(state, count)
        if values is None:
            self.check_access(state, target, Int(count.term + target.offset, count.lo + target.offset, count.hi + target.offset, 64), "memcpy")
            self.check_access(state, source, Int(count.term + source.offset, count.lo + source.offset, count.hi + source.offset, 64), "memcpy")
            self.activations += 1
            end = state.memory[target.object].size
            state.writable(target.object).cover(target.offset, end, "element", (self.activations, {}))
            return [state]
        found = []
        for number in values:
            one = state.copy()
            one.assume(compare("eq", count, exact(number, 64)))
            self.copy_bytes(one, target, source, number)
            found.append(one)
        return found

    def values_of(self, state, number, most=4):
        """All values it can have here, if they are few."""
        solver, found = z3.Solver(), []
        solver.set("rlimit", 2_000_000)
        path = [expr_of(cond) for cond in state.path if self.prover.is_linear(expr_of(cond))]
        path += [number.term >= number.lo, number.term <= number.hi]
        solver.add(*path, *self.prover.facts_of(path)[0])
        while solver.check() != z3.unsat:
            if len(found) == most or solver.check() != z3.sat:
                return None
            found.append(solver.model().eval(number.term, model_completion=True).as_long())
            solver.add(number.term != found[-1])
        return found


def choose_cond(guard, yes, no):
    return choose(guard, yes, no) if not isinstance(yes, bool) else (either(guard, no) if yes else both(negate(guard), no))


def new_state():
    return State()
