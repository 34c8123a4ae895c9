"""The reference firmware as IR, with every check of clang's sanitizer for integers, and where the fields of its structures lie."""
import pathlib
import re
import subprocess

import ir

CLANG = "clang-14"
# Not optimised: every check of the sanitizer and every cast is there as it was written. `integer` includes unsigned sums that wrap, which are no
# error of C; what wraps on purpose is listed in proof.py.
OPTIONS = ["-std=c11", "-ffreestanding", "-O0", "-Xclang", "-disable-O0-optnone", "-fno-discard-value-names", "-S", "-emit-llvm",
           "-fsanitize=integer,bounds,shift,integer-divide-by-zero", "-fsanitize-trap=all"]
SOURCES = ["device_force.c", "device_core.c", "device_reports.c", "device_calibration.c"]


def compile_file(path, out, include):
    subprocess.run([CLANG, *OPTIONS, f"-I{include}", str(path), "-o", str(out)], check=True)
    return out.read_text(encoding="utf-8")


def read_file(folder, name, scratch):
    return ir.read_module(compile_file(pathlib.Path(folder, name), pathlib.Path(scratch, f"{name}.ll"), folder))


def joined(modules):
    """One module of all files; of constants those with a name of ours."""
    whole = ir.Module({}, {}, {})
    for module in modules:
        whole.types.update(module.types)
        whole.constants.update({key: value for key, value in module.constants.items() if key[0] == "k"})
        whole.functions.update(module.functions)
    return whole


class Layout:
    """Offset and size of fields: layout["HapDevice", "config.f_cap_cn"] is (offset, size)."""

    def __init__(self, folder, scratch, fields):
        source = ['#include <stddef.h>', f'#include "{pathlib.Path(folder).resolve()}/hapticd_device.h"']
        for number, (struct, field) in enumerate(fields):
            one = f"(({struct}*)0)->{field}"
            source.append(f"const unsigned long at_{number} = offsetof({struct}, {field}), size_{number} = sizeof {one};")
        path = pathlib.Path(scratch, "layout.c")
        path.write_text("\n".join(source), encoding="utf-8")
        text = compile_file(path, path.with_suffix(".ll"), folder)
        found = {name: int(value) for name, value in re.findall(r"@(\w+) = .*constant i64 (-?\d+)", text)}
        self.fields = {key: (found[f"at_{number}"], found[f"size_{number}"]) for number, key in enumerate(fields)}

    def __getitem__(self, key):
        return self.fields[key]
