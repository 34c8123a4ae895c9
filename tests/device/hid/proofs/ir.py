"""Reads what the proofs need of the LLVM IR that clang 14 writes at -O0: types with their layout, constants, and functions as blocks
of instructions. What is not understood is an error: a proof never skips over an instruction."""
import dataclasses
import re

TOKEN = re.compile(r'%"[^"]*"|@"[^"]*"|c"[^"]*"|[%@][-\w.$]+|-?\d+|[\w.]+|<\{|\}>|[\[\]{}()*,=]|\.\.\.|![\w.]*')


@dataclasses.dataclass(frozen=True)
class Type:
    """kind: int, pointer, array, struct, void. An int has a width, a pointer and an array what they are of, a struct its fields."""
    kind: str
    width: int = 0
    of: "Type" = None
    fields: tuple = ()
    packed: bool = False

    def size(self):
        if self.kind == "int":
            return (self.width + 7) // 8
        if self.kind == "pointer":
            return 8
        if self.kind == "array":
            return self.width * self.of.size()
        offset = self.offset(len(self.fields))
        return -(-offset // self.align()) * self.align()

    def align(self):
        if self.kind == "array":
            return self.of.align()
        if self.kind == "struct":
            return 1 if self.packed else max((field.align() for field in self.fields), default=1)
        return self.size()

    def offset(self, index):
        """Of a field; of the one past the last, the end."""
        at = 0
        for number, field in enumerate(self.fields):
            if not self.packed:
                at = -(-at // field.align()) * field.align()
            if number == index:
                return at
            at += field.size()
        return at


VOID = Type("void")


class Reader:
    """Tokens of one line, with the named types."""

    def __init__(self, text, types):
        self.tokens, self.at, self.types = TOKEN.findall(text), 0, types

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def take(self, *words):
        """Skips any of the words that come next."""
        while self.peek() in words:
            self.at += 1

    def expect(self, word):
        found = self.next()
        if found != word:
            raise ValueError(f"{word} expected, not {found}: {' '.join(self.tokens)}")

    def type(self):
        word = self.next()
        if word == "void":
            made = VOID
        elif re.fullmatch(r"i\d+", word):
            made = Type("int", int(word[1:]))
        elif word == "[":
            count = int(self.next())
            self.expect("x")
            made = Type("array", count, self.type())
            self.expect("]")
        elif word in ("{", "<{"):
            fields = []
            while self.peek() not in ("}", "}>"):
                fields.append(self.type())
                self.take(",")
            self.next()
            made = Type("struct", fields=tuple(fields), packed=word == "<{")
        elif word.startswith("%"):
            made = self.types[word]
        else:
            raise ValueError(f"no type: {word} in {' '.join(self.tokens)}")
        while self.peek() == "*":
            self.next()
            made = Type("pointer", of=made)
        return made

    def operand(self):
        """A register or global by name, a number, or a constant expression as a tuple."""
        word = self.next()
        if word in ("true", "false"):
            return int(word == "true")
        if word in ("null", "undef"):
            return 0
        if re.fullmatch(r"-?\d+", word):
            return int(word)
        if word in ("getelementptr", "bitcast"):
            return self.constant_expression(word)
        if word[0] not in "%@":
            raise ValueError(f"no operand: {word} in {' '.join(self.tokens)}")
        return word

    def constant_expression(self, word):
        self.take("inbounds")
        self.expect("(")
        if word == "bitcast":
            self.type()
            inner = self.operand()
            self.expect("to")
            self.type()
            self.expect(")")
            return inner
        base = self.type()
        self.take(",")
        typed = []
        while self.peek() != ")":
            typed.append((self.type(), self.operand()))
            self.take(",")
        self.next()
        return ("getelementptr", base, typed)


@dataclasses.dataclass
class Instruction:
    op: str
    result: str = None
    type: Type = None
    args: list = dataclasses.field(default_factory=list)
    flags: tuple = ()
    name: str = None
    text: str = ""


@dataclasses.dataclass
class Function:
    name: str
    result: Type
    parameters: list
    blocks: dict
    exits: dict = dataclasses.field(default_factory=dict)

    def successors(self, label):
        last = self.blocks[label][-1]
        return [target for target in last.args[-1]] if last.op in ("br", "switch") else []

    def traps(self, label):
        return self.blocks[label][-1].op == "unreachable"


PARAMETER_WORDS = ("noundef", "zeroext", "signext", "nonnull", "nocapture", "readonly", "align", "immarg")


def read_parameters(reader):
    parameters = []
    reader.expect("(")
    while reader.peek() != ")":
        kind = reader.type()
        while reader.peek() in PARAMETER_WORDS:
            if reader.next() == "align":
                reader.next()
        parameters.append((kind, reader.operand()))
        reader.take(",")
    reader.next()
    return parameters


def read_instruction(line, types):
    match = re.match(r"\s*(?:(%[-\w.$]+) = )?(.*)$", re.sub(r", ![\w.]+ !\d+|, align \d+| #\d+", "", line))
    made = Instruction("", match[1], text=line.strip())
    reader = Reader(match[2], types)
    made.op = reader.next()
    if made.op == "tail":
        made.op = reader.next()
    reader.take("inbounds")
    READERS.get(made.op, read_binary)(reader, made)
    return made


def read_binary(reader, made):
    if made.op not in ("add", "sub", "mul", "sdiv", "udiv", "srem", "urem", "shl", "lshr", "ashr", "and", "or", "xor"):
        raise ValueError(f"instruction not understood: {made.text}")
    while reader.peek() in ("nsw", "nuw", "exact"):
        made.flags += (reader.next(),)
    made.type = reader.type()
    made.args.append(reader.operand())
    reader.take(",")
    made.args.append(reader.operand())


def read_alloca(reader, made):
    made.type = reader.type()


def read_load(reader, made):
    made.type = reader.type()
    reader.take(",")
    reader.type()
    made.args = [reader.operand()]


def read_store(reader, made):
    made.type = reader.type()
    made.args = [reader.operand()]
    reader.take(",")
    reader.type()
    made.args.append(reader.operand())


def read_gep(reader, made):
    made.type = reader.type()
    while reader.peek() == ",":
        reader.next()
        made.args.append((reader.type(), reader.operand()))


def read_cast(reader, made):
    source = reader.type()
    made.args = [reader.operand(), source]
    reader.expect("to")
    made.type = reader.type()


def read_icmp(reader, made):
    made.name = reader.next()
    made.type = reader.type()
    made.args = [reader.operand()]
    reader.take(",")
    made.args.append(reader.operand())


def read_select(reader, made):
    for _ in range(3):
        made.type = reader.type()
        made.args.append(reader.operand())
        reader.take(",")


def read_phi(reader, made):
    made.type = reader.type()
    while reader.peek() in ("[", ","):
        reader.take(",")
        reader.expect("[")
        value = reader.operand()
        reader.expect(",")
        made.args.append((value, reader.next()))
        reader.expect("]")


def read_branch(reader, made):
    if reader.peek() == "label":
        reader.next()
        made.args = [None, [reader.next()]]
        return
    reader.type()
    condition = reader.operand()
    targets = []
    while reader.peek() == ",":
        reader.next()
        reader.expect("label")
        targets.append(reader.next())
    made.args = [condition, targets]


def read_switch(reader, made):
    made.type = reader.type()
    value = reader.operand()
    reader.expect(",")
    reader.expect("label")
    targets, cases = [reader.next()], []
    reader.expect("[")
    while reader.peek() != "]":
        reader.type()
        cases.append(reader.operand())
        reader.expect(",")
        reader.expect("label")
        targets.append(reader.next())
    made.args = [value, cases, targets]


def read_call(reader, made):
    reader.take(*PARAMETER_WORDS)
    made.type = reader.type()
    made.name = reader.next()[1:]
    made.args = read_parameters(reader)


def read_return(reader, made):
    made.type = reader.type()
    made.args = [] if made.type.kind == "void" else [reader.operand()]


def read_extract(reader, made):
    reader.type()
    value = reader.operand()
    reader.expect(",")
    made.args = [value, int(reader.next())]


READERS = {"alloca": read_alloca, "load": read_load, "store": read_store, "getelementptr": read_gep, "icmp": read_icmp, "phi": read_phi,
           "select": read_select, "br": read_branch, "switch": read_switch, "call": read_call, "ret": read_return,
           "extractvalue": read_extract, "unreachable": lambda reader, made: None,
           **{word: read_cast for word in ("trunc", "zext", "sext", "bitcast")}}


def read_function(lines, types):
    head = re.match(r"define (?:dso_local |internal )*(.*?)@([\w.]+)(\(.*)$", lines[0])
    reader = Reader(head[1], types)
    reader.take(*PARAMETER_WORDS)
    result = reader.type()
    parameters = read_parameters(Reader(head[3], types))
    blocks, label = {}, "%entry"
    # A switch stands on several lines.
    text = re.sub(r"\[\n[^]]*\]", lambda found: " ".join(found[0].split()), "\n".join(lines[1:-1]))
    for line in text.split("\n"):
        line = line.split("; preds")[0].rstrip()
        if not line:
            continue
        named = re.match(r"([-\w.$]+):", line)
        if named:
            label = f"%{named[1]}"
            continue
        blocks.setdefault(label, []).append(read_instruction(line, types))
    return Function(head[2], result, parameters, blocks)


def read_constant(text):
    """The bytes of a constant array of bytes, or the number of a constant."""
    strings = re.findall(r'c"((?:[^"\\]|\\[0-9A-F]{2})*)"', text)
    if strings:
        whole = "".join(strings)
        return [int(m[1], 16) if m[1] else ord(m[0]) for m in re.finditer(r"\\([0-9A-F]{2})|.", whole)]
    number = re.search(r"constant i\d+ (-?\d+|true|false)", text)
    return int(number[1]) if number else None


@dataclasses.dataclass
class Module:
    types: dict
    constants: dict
    functions: dict


def read_module(text):
    lines = text.split("\n")
    module = Module({}, {}, {})
    pending = [re.match(r"(%[\w.]+) = type (.*)$", line) for line in lines]
    pending = [match for match in pending if match]
    while pending:
        left = []
        for match in pending:
            try:
                module.types[match[1]] = Reader(match[2], module.types).type()
            except KeyError:
                left.append(match)
        if len(left) == len(pending):
            raise ValueError(f"types that name each other: {left}")
        pending = left
    for number, line in enumerate(lines):
        constant = re.match(r"@([\w.]+) = .*constant (.*)$", line)
        if constant:
            module.constants[constant[1]] = read_constant(line)
        if line.startswith("define "):
            end = lines.index("}", number)
            made = read_function(lines[number:end + 1], module.types)
            module.functions[made.name] = made
    return module
