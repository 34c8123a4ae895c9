"""What single instructions of the IR do to numbers, see executor.py."""
import z3

from state import Unsupported
from terms import Int, Raw, both, choose, compare, either, exact, is_exact, negate, same


def number_of(cond, width):
    """1 or 0."""
    if isinstance(cond, bool):
        return exact(int(cond), width)
    return Int(z3.If(cond.expr, 1, 0), 0, 1, width, cond=cond)


def add(a, b):
    align = min(a.align, b.align)
    term = a.term + b.term
    return exact(term, a.width) if isinstance(term, int) else Int(term, a.lo + b.lo, a.hi + b.hi, a.width, align)


def subtract(a, b):
    term = a.term - b.term
    return exact(term, a.width) if isinstance(term, int) else Int(term, a.lo - b.hi, a.hi - b.lo, a.width, min(a.align, b.align))


def multiply(a, b):
    term = a.term * b.term
    if isinstance(term, int):
        return exact(term, a.width)
    ends = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    lo = max(0, min(ends)) if same(a, b) else min(ends)
    return Int(term, 0 if same(a, b) and lo > 0 and a.lo <= 0 <= a.hi else lo, max(ends), a.width)


def wrap(prover, value, width):
    """The number of these bits, as they are where that is a number of this width."""
    if -(1 << width - 1) <= value.lo and value.hi < 1 << width:
        made = Int(value.term, value.lo, value.hi, width, value.align, value.cond)
        return made
    return prover.unsigned(Int(value.term, value.lo, value.hi, width))


def divide(prover, a, b):
    """Toward zero; b is not 0."""
    if is_exact(a) and is_exact(b):
        quotient = abs(a.term) // abs(b.term)
        return exact(quotient if (a.term < 0) == (b.term < 0) else -quotient, a.width)
    if b.lo < 1:
        raise Unsupported("division by what may be negative")
    lo = -(-a.lo // b.lo) if a.lo < 0 else a.lo // b.hi
    hi = a.hi // b.lo if a.hi >= 0 else -(-a.hi // b.hi)

    def make():
        quotient = prover.fresh("quotient", a.width, lo, hi)
        back = quotient.term * b.term
        prover.fact(quotient.term, z3.If(a.term >= 0, z3.And(quotient.term >= 0, back <= a.term, a.term < back + b.term),
                                         z3.And(quotient.term <= 0, back >= a.term, a.term > back - b.term)))
        return quotient
    return prover.once(("sdiv", a.term, b.term), make)


def bits_of(value, mask):
    """value & mask for a known mask of few bits, value >= 0."""
    mask &= (1 << max(value.hi, 0).bit_length()) - 1
    if mask == 0:
        return exact(0, value.width)
    if mask & (mask + 1) == 0:
        return value if value.hi <= mask else Int(value.term % (mask + 1), 0, mask, value.width)
    bits = [bit for bit in range(mask.bit_length()) if mask >> bit & 1]
    terms = [(value.term / (1 << bit)) % 2 * (1 << bit) if bit else value.term % 2 for bit in bits]
    return Int(sum(terms[1:], terms[0]), 0, mask, value.width)


def bit_and(prover, a, b):
    if a.cond is not None and b.cond is not None:
        return number_of(both(a.cond, b.cond), a.width)
    if is_exact(a):
        a, b = b, a
    if is_exact(a):
        return exact(a.term & b.term, a.width)
    a = prover.unsigned(a)
    if is_exact(b):
        mask = b.term % (1 << b.width)
        held = (1 << a.hi.bit_length()) - 1
        if bin(held & ~mask).count("1") < bin(held & mask).count("1") and mask & (mask + 1):
            return subtract_bits(a, bits_of(a, held & ~mask))
        return bits_of(a, mask)
    b = prover.unsigned(b)
    return prover.once(("and", a.term, b.term), lambda: prover.fresh("and", a.width, 0, min(a.hi, b.hi)))


def subtract_bits(a, bits):
    made = subtract(a, bits)
    return made if is_exact(made) else Int(made.term, max(0, made.lo), min(made.hi, a.hi), a.width)


def bit_or(prover, a, b):
    if a.cond is not None and b.cond is not None:
        return number_of(either(a.cond, b.cond), a.width)
    if is_exact(a):
        a, b = b, a
    if is_exact(a):
        return exact(a.term | b.term, a.width)
    if is_exact(b) and b.term >= 0 and (a.align > b.term or b.term == 0):
        return add(a, b)
    if is_exact(b) and a.lo >= 0 and b.term >= 0:
        return add(subtract_bits(a, bits_of(a, b.term)), b)

    def make():
        top = max(abs(a.lo), abs(a.hi) + 1, abs(b.lo), abs(b.hi) + 1, 2)
        top = 1 << (top - 1).bit_length()
        made = prover.fresh("or", a.width, 0 if a.lo >= 0 and b.lo >= 0 else -top, top - 1)
        prover.fact(made.term, (made.term == 0) == z3.And(a.term == 0, b.term == 0))
        if a.lo >= 0 and b.lo >= 0:
            prover.fact(made.term, made.term >= a.term, made.term >= b.term, made.term <= a.term + b.term)
        return made
    return prover.once(("or", a.term, b.term), make)


def shift(prover, op, a, b):
    if not is_exact(b):
        raise Unsupported("a shift by an unknown count")
    if op == "shl":
        return wrap(prover, multiply(a, exact(1 << b.term, a.width)), a.width)
    if is_exact(a):
        return exact(a.term >> b.term, a.width)
    return Int(a.term / (1 << b.term), a.lo >> b.term, a.hi >> b.term, a.width)


def step(executor, frame, state, instruction):
    HANDLERS[instruction.op](executor, frame, state, instruction)


def do_binary(executor, frame, state, instruction):
    prover, op, kind = executor.prover, instruction.op, instruction.type
    if kind.width == 1:
        a, b = (executor.condition(state, operand) for operand in instruction.args)
        made = {"and": lambda: both(a, b), "or": lambda: either(a, b), "xor": lambda: choose(a, negate(b), b) if not isinstance(b, bool) else
                negate(a) if b else a}[op]()
        state.registers[instruction.result] = made
        return
    bits = op in ("lshr", "and", "or")
    a, b = (executor.number(state, operand, kind, not (bits and (op == "lshr" or isinstance(executor.value(state, operand, kind), Raw))))
            for operand in instruction.args)
    if op in ("add", "sub", "mul"):
        made = wrap(prover, {"add": add, "sub": subtract, "mul": multiply}[op](a, b), kind.width)
    elif op == "sdiv":
        if b.lo < 1 and prover.prove(state, compare("lt", exact(0, b.width), b), f"{frame.function.name}: the divisor is above 0"):
            b = Int(b.term, 1, b.hi, b.width)
        made = divide(prover, a, b)
    elif op == "and":
        made = bit_and(prover, a, b)
    elif op == "or":
        made = bit_or(prover, a, b)
    elif op == "xor" and is_exact(b) and b.term == -1:
        made = subtract(exact(-1, kind.width), a)
    elif op in ("shl", "lshr", "ashr"):
        made = shift(prover, op, a, b)
    else:
        raise Unsupported(f"{frame.function.name}: {instruction.text}")
    state.registers[instruction.result] = made


def do_icmp(executor, _frame, state, instruction):
    name, kind = instruction.name, instruction.type
    if kind.kind == "pointer":
        raise Unsupported("pointers are compared")
    if kind.width == 1:
        a, b = (executor.condition(state, operand) for operand in instruction.args)
        equal = choose(a, b, negate(b)) if not isinstance(b, bool) else a if b else negate(a)
        state.registers[instruction.result] = equal if name == "eq" else negate(equal)
        return
    a, b = (executor.number(state, operand, kind, name[0] != "u") for operand in instruction.args)
    if name in ("eq", "ne"):
        if is_exact(b) and b.term in (0, 1) and a.cond is not None:
            made = a.cond if b.term else negate(a.cond)
        else:
            made = compare("eq", a, b)
        made = made if name == "eq" else negate(made)
    else:
        made = {"lt": lambda: compare("lt", a, b), "gt": lambda: compare("lt", b, a), "le": lambda: negate(compare("lt", b, a)),
                "ge": lambda: negate(compare("lt", a, b))}[name[1:]]()
    state.registers[instruction.result] = state.decided(made)


def do_trunc(executor, frame, state, instruction):
    prover, (operand, source), width = executor.prover, instruction.args, instruction.type.width
    value = executor.value(state, operand, source)
    if width == 1:
        state.registers[instruction.result] = state.decided(prover.truth(value if isinstance(value, Raw) else prover.unsigned(value)))
        return
    number = executor.number(state, operand, source)
    if number.lo < -(1 << width - 1) or number.hi >= 1 << width:
        if (frame.function.name, "conversion") not in executor.wraps:
            fits = both(negate(compare("lt", number, exact(-(1 << width - 1), source.width))), compare("lt", number, exact(1 << width, source.width)))
            prover.prove(state, fits, f"{frame.function.name}: a cast loses bits, {instruction.text}")
            state.assume(fits)
            number = Int(number.term, max(number.lo, -(1 << width - 1)), min(number.hi, (1 << width) - 1), width)
    state.registers[instruction.result] = wrap(prover, number, width)


def do_extend(executor, _frame, state, instruction):
    (operand, source), width = instruction.args, instruction.type.width
    if source.width == 1:
        cond = executor.condition(state, operand)
        state.registers[instruction.result] = number_of(cond, width)
        return
    value = executor.number(state, operand, source, instruction.op == "sext")
    state.registers[instruction.result] = Int(value.term, value.lo, value.hi, width, value.align, value.cond)


def do_intrinsic(executor, frame, state, instruction):
    parts = instruction.name.split(".")
    if parts[-1][0] != "i" or parts[1] not in ("sadd", "ssub", "smul", "uadd", "usub", "umul"):
        raise Unsupported(instruction.text)
    signed, width = parts[1][0] == "s", int(parts[-1][1:])
    a, b = (executor.number(state, operand, kind, signed) for kind, operand in instruction.args)
    made = {"add": add, "sub": subtract, "mul": multiply}[parts[1][1:]](a, b)
    lo, hi = (-(1 << width - 1), (1 << width - 1) - 1) if signed else (0, (1 << width) - 1)
    kind = {"add": "sum", "sub": "difference", "mul": "product"}[parts[1][1:]]
    if (frame.function.name, kind) in executor.wraps:
        state.registers[instruction.result] = (wrap(executor.prover, made, width), False)
        return
    inside = both(negate(compare("lt", made, exact(lo, width))), negate(compare("lt", exact(hi, width), made)))
    clipped = made if is_exact(made) else Int(made.term, max(made.lo, lo), min(made.hi, hi), width, made.align)
    state.registers[instruction.result] = (clipped, negate(inside))


def do_extract(_executor, _frame, state, instruction):
    pair, index = instruction.args
    state.registers[instruction.result] = state.registers[pair][index]


def do_alloca(_executor, frame, state, instruction):
    name = f"{frame.function.name}#{frame.depth}.{instruction.result[1:]}"
    frame.allocated.append(name)
    state.registers[instruction.result] = state.add(name, instruction.type.size(), None)


def do_load(executor, frame, state, instruction):
    pointer = executor.value(state, instruction.args[0], POINTER)
    state.registers[instruction.result] = executor.load(state, pointer, instruction.type.size(), frame.function.name)


def do_store(executor, frame, state, instruction):
    kind = instruction.type
    if kind.kind == "int" and kind.width == 1:
        value = executor.condition(state, instruction.args[0])
    else:
        value = executor.value(state, instruction.args[0], kind)
    executor.store(state, executor.value(state, instruction.args[1], POINTER), kind.size(), value, frame.function.name)


def do_address(executor, _frame, state, instruction):
    state.registers[instruction.result] = executor.address(state, instruction.type, instruction.args)


def do_bitcast(executor, _frame, state, instruction):
    operand, source = instruction.args
    state.registers[instruction.result] = executor.value(state, operand, source)


def do_select(executor, _frame, state, instruction):
    cond = executor.condition(state, instruction.args[0])
    kind = instruction.type
    if isinstance(cond, bool):
        state.registers[instruction.result] = executor.value(state, instruction.args[1 if cond else 2], kind)
        return
    if kind.kind == "pointer" or kind.width == 1:
        raise Unsupported(instruction.text)
    yes, no = state.copy(), state.copy()
    yes.assume(cond)
    no.assume(negate(cond))
    values = [executor.value(state, operand, kind) for operand in instruction.args[1:]]
    state.registers[instruction.result] = executor.merge_values([yes, no], [cond, negate(cond)], values)


class _AnyPointer:
    kind, width = "pointer", 0


POINTER = _AnyPointer()
BINARY = ("add", "sub", "mul", "sdiv", "and", "or", "xor", "shl", "lshr", "ashr")
HANDLERS = {**{op: do_binary for op in BINARY}, "icmp": do_icmp, "trunc": do_trunc, "sext": do_extend, "zext": do_extend, "call": do_intrinsic,
            "extractvalue": do_extract, "alloca": do_alloca, "load": do_load, "store": do_store, "getelementptr": do_address,
            "bitcast": do_bitcast, "select": do_select}
