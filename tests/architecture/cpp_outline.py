"""The outline of a C++ file, read without a compiler: its classes with their members, and the functions it defines, each with the number
of its parameters. It knows the C++ that this project writes; bodies of functions are passed over.

Names are tuples of scopes; what stands in an anonymous namespace is named as if that were not there."""
import re
from typing import NamedTuple

TOKEN = re.compile(r"""operator\s*(?:\(\s*\)|\[\s*\]|""\s*\w+|[-+*/%^&|~!=<>,]+|[\w:]+(?:\s*[*&])?)|\w+|::|->|<=>|<<|<=|>=|==|&&|\|\||""|\S""")
STRIPPED = re.compile(r"""R"(?P<end>[^\s()\\]{0,16})\(.*?\)(?P=end)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'""",
                      re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.MULTILINE)
PAIRS = {"(": ")", "[": "]", "{": "}"}
WORDS_WITH_BRACKETS = {"alignas", "decltype", "__attribute__", "explicit", "noexcept", "requires"}
ACCESS = {"public", "private", "protected"}
NO_MEMBER = {"using", "typedef", "friend", "static_assert", "enum"}


class Member(NamedTuple):
    name: str
    access: str
    is_function: bool
    is_special: bool  # a constructor, destructor or assignment


class Class(NamedTuple):
    name: tuple
    keyword: str  # class, struct or union
    line: int
    members: list


class Function(NamedTuple):
    name: tuple  # with the scopes it is written in, and those it is qualified with
    scope: tuple  # those it is written in
    parameters: int
    line: int
    is_member: bool  # written inside its class


class Outline(NamedTuple):
    classes: list
    functions: list  # those defined here, `= default` included
    aliases: dict  # {name: tokens of what it means}
    own: set  # names that stand in anonymous namespaces, without scopes


def without_text(source: str) -> str:
    """The source without comments, literals and directives; every line keeps its number."""
    def blank(match):
        found = match.group()
        filler = "\n" * found.count("\n")
        return '""' + filler if found.endswith('"') else " " + filler if found.startswith("/") else "0" + filler
    return DIRECTIVE.sub(lambda match: "\n" * match.group().count("\n"), STRIPPED.sub(blank, source))


class Reader:
    def __init__(self, source: str):
        text = without_text(source)
        self.tokens, self.lines = [], []
        line, last = 1, 0
        for match in TOKEN.finditer(text):
            line += text.count("\n", last, match.start())
            last = match.start()
            self.tokens.append(re.sub(r"\s", "", match.group()))
            self.lines.append(line)
        self.outline = Outline([], [], {}, set())
        self.anonymous = 0  # how many of the open namespaces are
        self.first_access = ""

    def closing(self, start: int) -> int:
        """The place of the bracket that closes the one at start, or the end."""
        depth = 0
        for place in range(start, len(self.tokens)):
            depth += (self.tokens[place] in PAIRS) - (self.tokens[place] in PAIRS.values())
            if depth == 0:
                return place
        return len(self.tokens)

    def read_scope(self, place: int, scope: tuple, members) -> int:
        """All declarations up to the brace that closes the scope; members is a list inside of a class, else None."""
        access = self.first_access if members is not None else ""
        while place < len(self.tokens) and self.tokens[place] != "}":
            token = self.tokens[place]
            if token in ACCESS and self.tokens[place + 1] == ":":
                access, place = token, place + 2
            elif token == ";":
                place += 1
            else:
                place = self.read_declaration(place, scope, members, access)
        return place + 1

    def read_declaration(self, start: int, scope: tuple, members, access: str) -> int:
        head = []  # tokens without what stands in brackets after words like alignas, and without attributes
        place, braced = start, False
        while place < len(self.tokens):
            token = self.tokens[place]
            if token == ";" or token == "}":
                break
            if token == "[" and self.tokens[place + 1] == "[":
                place = self.closing(place)
            elif token in WORDS_WITH_BRACKETS and self.tokens[place + 1] == "(":
                place = self.closing(place + 1)
            elif token in ("(", "["):
                end = self.closing(place)
                head += self.tokens[place:end + 1]
                place = end
            elif token == "{":
                inner = self.inner_scope(head, scope)
                if inner is not None:
                    return self.read_inner(place + 1, inner, head)
                place = self.closing(place)
                following = self.tokens[place + 1] if place + 1 < len(self.tokens) else ""
                braced = True
                if self.is_function(head) and following not in (",", "{"):
                    break
            else:
                head.append(token)
            place += 1
        self.record(head, start, scope, members, access, braced)
        return place if place < len(self.tokens) and self.tokens[place] == "}" and not braced else place + 1

    @staticmethod
    def without_template(head: list) -> list:
        while head and head[0] == "template":
            depth, nested = 0, 0
            for place, token in enumerate(head[1:], 1):
                nested += (token in PAIRS) - (token in PAIRS.values())
                if nested == 0:
                    depth += (token == "<") - (token == ">")
                if nested == depth == 0:
                    break
            head = head[place + 1:]
        return head

    @staticmethod
    def bracket(head: list):
        """The place of the first round bracket outside of template arguments, before which nothing is assigned; or None."""
        depth = 0
        for place, token in enumerate(head):
            if depth == 0 and token == "(":
                return place
            if depth == 0 and token == "=":
                return None
            if token == "<" and place and re.match(r"\w", head[place - 1]):
                depth += 1
            elif token == ">" and depth:
                depth -= 1
        return None

    def is_function(self, head: list) -> bool:
        return self.bracket(self.without_template(head)) is not None

    def inner_scope(self, head: list, scope: tuple):
        """The keyword and the name of the scope that a brace after head opens, or None if it opens none."""
        plain = [token for token in self.without_template(head) if token not in ("inline", "typedef", "static", "const")]
        if plain[:1] == ["namespace"]:
            return "namespace", scope + tuple(token for token in plain[1:] if token not in ("::", "inline"))
        if plain[:1] == ["extern"] and plain[1:] == ['""']:
            return "namespace", scope
        if plain[:1] and plain[0] in ("class", "struct", "union") and not self.is_function(plain) and "=" not in plain:
            written = plain[1:plain.index(":")] if ":" in plain else plain[1:]
            name = []
            for token in written:
                if token == "<":
                    break
                if token not in ("::", "final"):
                    name.append(token)
            return plain[0], scope + tuple(name or [""])
        return None

    def read_inner(self, place: int, inner: tuple, head: list) -> int:
        keyword, name = inner
        if keyword == "namespace":
            is_anonymous = head == ["namespace"]
            self.anonymous += is_anonymous
            place = self.read_scope(place, name, None)
            self.anonymous -= is_anonymous
            return place
        if self.anonymous:
            self.outline.own.add(name[-1])
        found = Class(name, keyword, self.lines[place - 1], [])
        self.outline.classes.append(found)
        self.first_access = "private" if keyword == "class" else "public"
        place = self.read_scope(place, name, found.members)
        while place < len(self.tokens) and self.tokens[place] != ";":
            place += 1
        return place + 1

    def record(self, head: list, start: int, scope: tuple, members, access: str, braced: bool) -> None:
        head = self.without_template(head)
        if self.anonymous and head[:1] == ["enum"]:
            self.outline.own.add(head[2 if head[1] == "class" else 1])
        if head[:1] == ["using"] and head[2:3] == ["="]:
            self.outline.aliases[head[1]] = head[3:]
            if self.anonymous and members is None:
                self.outline.own.add(head[1])
        if not head or head[0] in NO_MEMBER or head[0] in ("class", "struct", "union", "namespace") and self.bracket(head) is None:
            return
        opening = self.bracket(head)
        if opening is not None and opening > 0:
            self.record_function(head, opening, start, scope, members, access, braced)
        elif members is not None:
            for name in self.declared(head):
                members.append(Member(name, access, False, False))
        else:
            if self.anonymous:
                self.outline.own.update(self.declared(head))
            name = self.qualified(head[:self.end_of_name(head)])
            if len(name) > 1:  # a static member
                self.outline.functions.append(Function(scope + name, scope, 0, self.lines[start], False))

    def record_function(self, head, opening, start, scope, members, access, braced) -> None:
        name = self.qualified(head[:opening])
        if not name or name[-1].isupper() and "_" in name[-1]:
            return  # a macro
        closed = self.closing_in(head, opening)
        is_defined = braced or head[-1:] == ["default"]
        if members is not None:
            own = name[-1] == scope[-1] or name[-1] == "~" + scope[-1] or name[-1] == "operator="
            members.append(Member(name[-1], access, True, own))
        if self.anonymous and members is None and len(name) == 1:
            self.outline.own.add(name[-1])
        if is_defined:
            count = self.count_parameters(head[opening + 1:closed])
            self.outline.functions.append(Function(scope + name, scope, count, self.lines[start], members is not None))

    @staticmethod
    def closing_in(head: list, opening: int) -> int:
        depth = 0
        for place in range(opening, len(head)):
            depth += (head[place] in PAIRS) - (head[place] in PAIRS.values())
            if depth == 0:
                return place
        return len(head)

    @staticmethod
    def qualified(head: list) -> tuple:
        """The name at the end of the tokens with what qualifies it, without template arguments."""
        name, place = [], len(head) - 1
        while place >= 0:
            if head[place] == ">":
                depth = 0
                while place >= 0:
                    depth += (head[place] == ">") - (head[place] == "<")
                    if depth == 0:
                        break
                    place -= 1
                place -= 1
                continue
            if not re.match(r"\w", head[place]):
                break
            name.insert(0, head[place])
            if place and head[place - 1] == "~":
                name[0] = "~" + name[0]
                place -= 1
            if place == 0 or head[place - 1] != "::":
                break
            place -= 2
        return tuple(name)

    @staticmethod
    def end_of_name(head: list) -> int:
        for place, token in enumerate(head):
            if token in ("=", "["):
                return place
        return len(head)

    def declared(self, head: list) -> list:
        """The names of the data that one declaration declares."""
        parts, depth, angle = [[]], 0, 0
        for place, token in enumerate(head):
            depth += (token in PAIRS) - (token in PAIRS.values())
            if token == "<" and place and re.match(r"\w", head[place - 1]) and "=" not in parts[-1]:
                angle += 1
            elif token == ">" and angle:
                angle -= 1
            if token == "," and depth == 0 and angle == 0:
                parts.append([])
            else:
                parts[-1].append(token)
        names = [self.qualified([token for token in part[:self.end_of_name(part)] if token != ":"]) for part in parts]
        return [name[-1] for name in names if name]

    @staticmethod
    def count_parameters(tokens: list) -> int:
        if not tokens or tokens == ["void"]:
            return 0
        count, depth, angle = 1, 0, 0
        for place, token in enumerate(tokens):
            depth += (token in PAIRS) - (token in PAIRS.values())
            if token == "<" and place and re.match(r"\w", tokens[place - 1]):
                angle += 1
            elif token == ">" and angle:
                angle -= 1
            count += token == "," and depth == 0 and angle == 0
        return count


def read(source: str) -> Outline:
    """The outline of the source of a .h or .cpp file."""
    reader = Reader(source)
    place = 0
    while place < len(reader.tokens):
        place = reader.read_scope(place, (), None)
    return reader.outline
