"""Pages of the message types, from the comments of the .proto files: a page a file, a table a message. A comment ends in brackets that give
unit, range and default; these are the last column."""
import re
import subprocess
import tempfile

from google.protobuf import descriptor_pb2

Field = descriptor_pb2.FieldDescriptorProto
MESSAGE, ENUM, EXTENSION, NESTED_FIELD, NESTED_MESSAGE, NESTED_ENUM, VALUE = 4, 5, 7, 2, 3, 4, 2  # numbers in descriptor.proto
SYNTAX = 12
SCALARS = {value: name.removeprefix("TYPE_").lower() for name, value in Field.Type.items()}


def descriptors(protoc, folder, files):
    """The FileDescriptorProto of each file, with its comments."""
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run([protoc, f"--proto_path={folder}", "--include_source_info", f"--descriptor_set_out={out.name}", *files], check=True)
        return descriptor_pb2.FileDescriptorSet.FromString(out.read()).file


def slug(name):
    """The anchor of the heading of a type."""
    return re.sub(r"[^\w-]", "", name.lower())


def plain(comment):
    """A comment as Markdown on one line; what would be read as markup is kept as it is."""
    text = " ".join(comment.split())
    return re.sub(r"([|<>*\[\]_`\\])", r"\\\1", text)


def split_brackets(comment):
    """(what it says, what stands in its last brackets)"""
    text = " ".join(comment.split())
    match = re.search(r"\[([^][]*(?:\[[^][]*\][^][]*)*)\]\.?$", text)
    return (text[:match.start()].strip(), match.group(1)) if match else (text, "")


def opening(comment):
    """The lines of a file's opening comment: prose, but a table in its columns."""
    lines = [line.removeprefix(" ") for line in comment.rstrip().splitlines()]
    if any(re.search(r"\S {2,}\S", line) for line in lines):
        return ["```text", *lines, "```", ""]
    return [plain(comment), ""]


class Pages:
    """Where each type is explained, and the text of each page."""

    def __init__(self, files):
        self.files = files
        self.page_of = {}
        for file in files:
            for message in file.message_type:
                self._place(file, f".{file.package}.{message.name}", message)
            for enum in file.enum_type:
                self.page_of[f".{file.package}.{enum.name}"] = (file, enum.name)

    def _place(self, file, full, message):
        self.page_of[full] = (file, full.removeprefix(f".{file.package}."))
        for nested in message.nested_type:
            self._place(file, f"{full}.{nested.name}", nested)
        for enum in message.enum_type:
            self.page_of[f"{full}.{enum.name}"] = (file, f"{full}.{enum.name}".removeprefix(f".{file.package}."))

    @staticmethod
    def page_name(file):
        return file.name.rsplit("/", 1)[1].replace(".proto", ".md")

    def type_of(self, here, field):
        if field.type_name in self.page_of:
            file, name = self.page_of[field.type_name]
            page = "" if file.name == here.name else self.page_name(file)
            text = f"[{name}]({page}#{slug(name)})"
        else:
            text = SCALARS[field.type]
        return f"{text}, repeated" if field.label == Field.LABEL_REPEATED else text

    def page(self, file):
        comments = {tuple(location.path): location.leading_comments for location in file.source_code_info.location}
        syntax = [location for location in file.source_code_info.location if tuple(location.path) == (SYNTAX,)]
        lines = [f"# {file.name.rsplit('/', 1)[1]}", ""]
        for block in [*syntax[0].leading_detached_comments, syntax[0].leading_comments]:
            lines += opening(block)
        for index, message in enumerate(file.message_type):
            lines += self._message(file, comments, message, (MESSAGE, index), message.name)
        for index, enum in enumerate(file.enum_type):
            lines += self._enum(comments, enum, (ENUM, index), enum.name)
        if file.extension:
            lines += ["## Options of fields", "", *self._fields(file, comments, file.extension, (EXTENSION,))]
        return "\n".join(lines) + "\n"

    def _message(self, file, comments, message, path, name):
        lines = [f"## {name}", "", plain(comments.get(path, "")), ""]
        groups = [group.name for group in message.oneof_decl]
        lines += self._fields(file, comments, message.field, (*path, NESTED_FIELD), groups)
        for index, nested in enumerate(message.nested_type):
            lines += self._message(file, comments, nested, (*path, NESTED_MESSAGE, index), f"{name}.{nested.name}")
        for index, enum in enumerate(message.enum_type):
            lines += self._enum(comments, enum, (*path, NESTED_ENUM, index), f"{name}.{enum.name}")
        return lines

    def _fields(self, file, comments, fields, path, groups=()):
        """A table of fields. groups: names of the message's oneofs."""
        if not fields:
            return []
        lines = ["| field | type | what | unit, range, default |", "|---|---|---|---|"]
        for index, field in enumerate(fields):
            what, limits = split_brackets(comments.get((*path, index), ""))
            if field.HasField("oneof_index") and not field.proto3_optional:
                group = groups[field.oneof_index]
                limits = f"one of {group}" + (f"; {limits}" if limits else "")
            lines.append(f"| `{field.name}` = {field.number} | {self.type_of(file, field)} | {plain(what)} | {plain(limits)} |")
        return [*lines, ""]

    @staticmethod
    def _enum(comments, enum, path, name):
        lines = [f"## {name}", "", plain(comments.get(path, "")), "", "| value | number | what |", "|---|---:|---|"]
        for index, value in enumerate(enum.value):
            lines.append(f"| `{value.name}` | {value.number} | {plain(comments.get((*path, VALUE, index), ''))} |")
        return [*lines, ""]


def pages(protoc, folder, files):
    """{name of a page: its text}"""
    made = Pages(descriptors(protoc, folder, files))
    return {made.page_name(file): made.page(file) for file in made.files}
