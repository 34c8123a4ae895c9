#!/usr/bin/python3
"""The messages of the protocol that programs print as JSON, as a JSON Schema: messages.schema.json, from the .proto files and their comments.

usage: messages_of_protocol.py [--write]
--write  puts it in place; without, ends with 1 where what is in place differs

The mapping is that of protobuf's JsonPrintOptions with preserve_proto_field_names and always_print_primitive_fields: integers of 64 bits are
texts, bytes are base64, numbers that are none are texts, lists are always there, and so is a field that has a default.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from google.protobuf import descriptor_pb2

HERE = pathlib.Path(__file__).resolve().parent
PROTO = HERE.parent.parent / "proto"
PRINTED = ("Result", "Listing", "ParameterValues", "RecordInfo", "RunResult", "DeviceInfoList", "LeaseInfo", "State")
Field = descriptor_pb2.FieldDescriptorProto
WHOLE = {
    **{kind: {"type": "integer", "minimum": -2**31, "maximum": 2**31 - 1} for kind in (Field.TYPE_INT32, Field.TYPE_SINT32, Field.TYPE_SFIXED32)},
    **{kind: {"type": "integer", "minimum": 0, "maximum": 2**32 - 1} for kind in (Field.TYPE_UINT32, Field.TYPE_FIXED32)},
    **{kind: {"type": "string", "pattern": "^-?[0-9]+$"} for kind in (Field.TYPE_INT64, Field.TYPE_SINT64, Field.TYPE_SFIXED64)},
    **{kind: {"type": "string", "pattern": "^[0-9]+$"} for kind in (Field.TYPE_UINT64, Field.TYPE_FIXED64)},
    Field.TYPE_BOOL: {"type": "boolean"},
    Field.TYPE_STRING: {"type": "string"},
    Field.TYPE_BYTES: {"type": "string", "contentEncoding": "base64", "pattern": "^[A-Za-z0-9+/]*={0,2}$"},
}
REAL = {"anyOf": [{"type": "number"}, {"enum": ["NaN", "Infinity", "-Infinity"]}]}


def files():
    """All .proto files, with their comments."""
    with tempfile.NamedTemporaryFile() as out:
        names = sorted(str(path.relative_to(PROTO)) for path in PROTO.glob("hapticd/v1/*.proto"))
        subprocess.run(["protoc", f"--proto_path={PROTO}", "--include_source_info", f"--descriptor_set_out={out.name}", *names], check=True)
        return descriptor_pb2.FileDescriptorSet.FromString(pathlib.Path(out.name).read_bytes()).file


class Types:
    """Messages and enums by their full name, each with its comments by the place of a field."""

    def __init__(self):
        self.messages, self.enums = {}, {}
        for file in files():
            said = {tuple(place.path): " ".join(place.leading_comments.split()) for place in file.source_code_info.location}
            for i, message in enumerate(file.message_type):
                self.add(message, (4, i), f".{file.package}.", said)
            for enum in file.enum_type:
                self.enums[f".{file.package}.{enum.name}"] = enum

    def add(self, message, place, prefix, said):
        name = prefix + message.name
        comments = [said.get(place + (2, i), "") for i in range(len(message.field))]
        self.messages[name] = (message, said.get(place, ""), comments)
        for i, inner in enumerate(message.nested_type):
            self.add(inner, place + (3, i), name + ".", said)
        for enum in message.enum_type:
            self.enums[f"{name}.{enum.name}"] = enum


def short(name):
    return name.removeprefix(".hapticd.v1.")


def one(field, types, wanted):
    """Schema of one value of a field."""
    if field.type == Field.TYPE_MESSAGE:
        wanted.append(field.type_name)
        return {"$ref": f"#/$defs/{short(field.type_name)}"}
    if field.type == Field.TYPE_ENUM:
        return {"enum": [value.name for value in types.enums[field.type_name].value]}
    return WHOLE.get(field.type, REAL)


def message_schema(name, types, wanted):
    message, comment, comments = types.messages[name]
    properties, required = {}, []
    for field, said in zip(message.field, comments):
        value = one(field, types, wanted)
        if field.label == Field.LABEL_REPEATED:
            value = {"type": "array", "items": value}
        properties[field.name] = {"description": said, **value}
        plain = field.type != Field.TYPE_MESSAGE and not field.HasField("oneof_index")
        if plain or field.label == Field.LABEL_REPEATED:
            required.append(field.name)
    return {"description": comment, "type": "object", "properties": properties, "required": required, "additionalProperties": False}


def schema():
    types = Types()
    wanted, made = [f".hapticd.v1.{name}" for name in PRINTED], {}
    while wanted:
        name = wanted.pop(0)
        if short(name) not in made:
            made[short(name)] = message_schema(name, types, wanted)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Messages of the protocol, as hapticctl prints them",
        "$comment": "Written by messages_of_protocol.py from the .proto files.",
        "$defs": dict(sorted(made.items())),
    }


def main():
    path = HERE / "messages.schema.json"
    text = json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"
    if sys.argv[1:] == ["--write"]:
        path.write_text(text, encoding="utf-8")
    elif path.read_text(encoding="utf-8") != text:
        print(f"{path}: the .proto files say something else; run {HERE.name}/{pathlib.Path(__file__).name} --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
