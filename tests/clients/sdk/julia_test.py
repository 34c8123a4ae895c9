"""What the README shows in Julia. Debian has no Julia, so its calls are read: each has the types that hapticd_client.h declares, and made by
ctypes with the types that they name, in their order, they do what they say. In a network of its own, where the default port is free."""
import ctypes
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

from installed_library import SOURCE, install

import daemon
import hapticd

# What a type of Julia is to C, and to ctypes.
TYPES = {
    "Cvoid": (r"void", None), "Cint": (r"int|int32_t", ctypes.c_int), "Cuint": (r"uint32_t", ctypes.c_uint32), "Csize_t": (r"size_t", ctypes.c_size_t),
    "Cstring": (r"const char\*", ctypes.c_char_p), "Ptr{Cvoid}": (r"(const )?\w+\*", ctypes.c_void_p),
    "Ref{Ptr{Cvoid}}": (r"\w+\*\*", ctypes.POINTER(ctypes.c_void_p)), "Ref{Cdouble}": (r"(const )?double\*", ctypes.POINTER(ctypes.c_double)),
}
CALL = re.compile(r"^(@assert )?ccall\(\(:(\w+), lib\), (\w+), \((.*?),?\), (.*?)\)( == 0)?$", re.MULTILINE)


def shown():
    """The block, and its calls: (name, what they return, the types of what they take, what they are given)."""
    text = (SOURCE / "clients/sdk/README.md").read_text(encoding="utf-8")
    block = re.search(r"^```julia\n(.*?)^```$", text, re.MULTILINE | re.DOTALL).group(1)
    return block, [(name, returned, types.split(", "), given.split(", ")) for _, name, returned, types, given, _ in CALL.findall(block)]


def declared():
    """Return type and parameter types of each function of the header."""
    text = re.sub(r"//.*", "", (SOURCE / "clients/sdk/include/hapticd_client.h").read_text(encoding="utf-8"))
    functions = re.findall(r"^([\w ]+\**) ?(hapticd_\w+)\(([^)]*)\);", text, re.MULTILINE)
    return {name: (kind.strip(), [re.sub(r"\s*\w+$", "", each.strip()) for each in re.split(r",\s*", given)]) for kind, name, given in functions}


class Julia(unittest.TestCase):
    def test_its_calls_are_those_of_the_header(self):
        block, calls = shown()
        header = declared()
        self.assertEqual(len(calls), block.count("ccall("))
        self.assertEqual(["hapticd_open", "hapticd_acquire", "hapticd_set", "hapticd_close"], [name for name, *_ in calls])
        for name, returned, types, given in calls:
            kind, parameters = header[name]
            self.assertRegex(kind, f"^({TYPES[returned][0]})$", name)
            self.assertEqual((len(parameters), len(parameters)), (len(types), len(given)), name)
            for parameter, told in zip(parameters, types):
                self.assertRegex(parameter, f"^({TYPES[told][0]})$", name)

    def test_made_in_their_order_they_set_what_they_say(self):
        block, calls = shown()
        with tempfile.TemporaryDirectory() as prefix:
            library = ctypes.CDLL(str(install(pathlib.Path(prefix)) / re.search(r'lib = "(.*?)"', block).group(1)))
            session = ctypes.c_void_p()
            with daemon.Daemon("--scene", "sphere", "--clock", "virtual", "--device", "scripted", port=47800):
                with hapticd.Session("127.0.0.1:47800") as other:
                    self.assertEqual(1.0, other.get("tools[0].force_gain"))
                for name, returned, types, given in calls:
                    function = library[name]
                    function.restype, function.argtypes = TYPES[returned][1], [TYPES[told][1] for told in types]
                    code = function(*(self.value(told, text, session) for told, text in zip(types, given)))
                    self.assertIn(code, (0, None), name)
                    if name == "hapticd_set":
                        with hapticd.Session("127.0.0.1:47800") as other:
                            self.assertEqual(0.5, other.get("tools[0].force_gain"))

    def value(self, told, text, session):
        """As Julia would pass it."""
        if text == "C_NULL":
            return None
        if text in ("session", "session[]"):
            return ctypes.byref(session) if text == "session" else session
        if text.startswith('"'):
            return text.strip('"').encode()
        return ctypes.byref(ctypes.c_double(float(text))) if told == "Ref{Cdouble}" else int(text)


if __name__ == "__main__":
    if "HAPTICD_ALONE" not in os.environ:
        unshare = ["unshare", "--net", *([] if os.geteuid() == 0 else ["--map-root-user"])]
        if subprocess.run([*unshare, "true"], check=False, capture_output=True).returncode:
            print("SKIPPED: this kernel gives no network of its own")
            sys.exit(77)
        inside = f"ip link set lo up && exec {shlex.join([sys.executable, '-B', __file__])}"
        sys.exit(subprocess.run([*unshare, "bash", "-c", inside], env={**os.environ, "HAPTICD_ALONE": "1"}, check=False).returncode)
    unittest.main(verbosity=2)
