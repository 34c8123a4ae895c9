"""Where an execution stands: objects of memory, what was assumed on the way, and what follows for single terms. Objects are read and written
at known offsets; an array with an unknown index is a summary, whose elements keep to stated intervals and are otherwise unknown."""
import itertools

from terms import Int, Raw, exact, negate, same


class Unsupported(Exception):
    """The program does what these proofs cannot follow: nothing is proved."""


class Pointer:
    """index: None, or the Int that chooses an element of a summary; offset then counts from that element's start."""
    __slots__ = ("object", "offset", "index")

    def __init__(self, name, offset, index=None):
        self.object, self.offset, self.index = name, offset, index

    def __eq__(self, other):
        return (self.object, self.offset, self.index) == (other.object, other.offset, other.index)


class Summary:
    """count elements of stride bytes at start; bounds: {offset in the element: (size, lo, hi)}."""

    def __init__(self, start, stride, count, bounds):
        self.start, self.stride, self.count, self.bounds = start, stride, count, bounds


class Object:
    """Cells are the newest, then layers from the last to the first, then the base: raw (unknown), constant bytes, or nothing (never written).
    size: a number, or an Int."""
    fresh = itertools.count()

    def __init__(self, name, size, base, summary=None):
        self.name, self.size, self.base, self.summary = name, size, base, summary
        self.cells, self.layers = {}, ()

    def copy(self):
        made = Object(self.name, self.size, self.base, self.summary)
        made.cells, made.layers = dict(self.cells), self.layers
        return made

    def load(self, offset, size):
        cell = self.cells.get(offset)
        if cell is not None and cell[0] == size:
            return cell[1]
        if any(at < offset + size and offset < at + held for at, (held, _) in self.cells.items()):
            raise Unsupported(f"{self.name} is read at {offset} in another size than it was written")
        for start, end, kind, data in reversed(self.layers):
            if start <= offset and offset + size <= end:
                return self.load_layer(kind, data, offset - start, size)
            if start < offset + size and offset < end:
                raise Unsupported(f"{self.name} is read at {offset} across what was copied")
        if self.base == "raw":
            return Raw(f"{self.name}+{offset}:{size}", 8 * size)
        if isinstance(self.base, list):
            return exact(int.from_bytes(bytes(self.base[offset:offset + size]), "little"), 8 * size)
        raise Unsupported(f"{self.name} is read at {offset} before it is written")

    def load_layer(self, kind, data, offset, size):
        if kind == "fill":
            return exact(int.from_bytes(bytes([data] * size), "little"), 8 * size)
        if kind == "copy":
            source, start = data
            return source.load(start + offset, size)
        number, bounds = data
        if offset in bounds and bounds[offset][0] == size:
            return Raw(f"element{number}+{offset}:{size}", 8 * size, bounds[offset][1:])
        return Raw(f"element{number}+{offset}:{size}", 8 * size)

    def forget(self, start, end):
        for at, (held, _) in list(self.cells.items()):
            if start <= at and at + held <= end:
                del self.cells[at]
            elif at < end and start < at + held:
                raise Unsupported(f"{self.name} is overwritten in part at {at}")

    def cover(self, start, end, kind, data):
        self.forget(start, end)
        kept = tuple(layer for layer in self.layers if not (start <= layer[0] and layer[1] <= end))
        self.layers = kept + ((start, end, kind, data),)

    def store(self, offset, size, value):
        self.forget(offset, offset + size)
        self.cells[offset] = (size, value)


class State:
    def __init__(self):
        self.memory, self.path, self.known, self.bounds, self.registers, self.marks = {}, [], {}, {}, {}, {}

    def copy(self):
        made = State()
        made.memory, made.path, made.known = dict(self.memory), list(self.path), dict(self.known)
        made.bounds, made.registers, made.marks = dict(self.bounds), dict(self.registers), dict(self.marks)
        return made

    def writable(self, name):
        made = self.memory[name] = self.memory[name].copy()
        return made

    def add(self, name, size, base, summary=None):
        self.memory[name] = Object(name, size, base, summary)
        return Pointer(name, 0)

    def interval(self, value):
        lo, hi = value.lo, value.hi
        if not isinstance(value.term, int):
            found = self.bounds.get(value.term.get_id())
            if found:
                lo = lo if found[1] is None else max(lo, found[1])
                hi = hi if found[2] is None else min(hi, found[2])
        return lo, hi

    def narrowed(self, value):
        """The same number with the interval that holds here."""
        lo, hi = self.interval(value)
        if lo == value.lo and hi == value.hi:
            return value
        return exact(lo, value.width) if lo == hi else Int(value.term, lo, hi, value.width, value.align, value.cond)

    def assume(self, cond):
        """False where that cannot be."""
        cond = self.decided(cond)
        if isinstance(cond, bool):
            return cond
        self.path.append(cond)
        self.known[cond.expr.get_id()] = cond.expr
        for term, lo, hi in cond.yes:
            old = self.bounds.get(term.get_id(), (term, None, None))
            lo = old[1] if lo is None else lo if old[1] is None else max(lo, old[1])
            hi = old[2] if hi is None else hi if old[2] is None else min(hi, old[2])
            if lo is not None and hi is not None and lo > hi:
                return False
            self.bounds[term.get_id()] = (term, lo, hi)
        return True

    def forget_since(self, count):
        """Only the first conditions of the path stay; what follows of the others is forgotten too."""
        kept, self.path, self.known, self.bounds = self.path[:count], [], {}, {}
        for cond in kept:
            self.assume(cond)

    def decided(self, cond):
        """True or False where the path has said so already."""
        if isinstance(cond, bool):
            return cond
        if cond.expr.get_id() in self.known:
            return True
        return False if negate(cond).expr.get_id() in self.known else cond


MOST_DIFFERENT = 12


def cells_that_differ(states):
    """[(object, offset, size, values)] of states whose memory is otherwise the same; None where they cannot be made one."""
    found, first = [], states[0].memory
    if any(state.memory.keys() != first.keys() for state in states):
        return None
    for name, held in first.items():
        objects = [state.memory[name] for state in states]
        if all(one is held for one in objects):
            continue
        if any(one.layers != held.layers for one in objects):
            return None
        for offset in sorted(set().union(*(one.cells for one in objects))):
            sizes = {one.cells[offset][0] for one in objects if offset in one.cells}
            try:
                values = [one.load(offset, max(sizes)) for one in objects]
            except Unsupported:
                found.append((name, offset, None, None))
                continue
            if len(sizes) > 1 or any(isinstance(value, Pointer) for value in values):
                if not all(same(value, values[0]) for value in values):
                    return None
            elif not all(same(value, values[0]) for value in values):
                found.append((name, offset, max(sizes), values))
    return found if sum(values is not None for *_, values in found) <= MOST_DIFFERENT else None
