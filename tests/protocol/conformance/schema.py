"""The wire types for the conformance checkers: those of the package hapticd if they are built and found, else made here by protoc from
proto/hapticd/v1, so that the checkers run from a bare clone."""
import os
import subprocess
import sys
import tempfile

PROTO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "proto")


def _generate():
    """Makes the modules in a folder that lasts as long as this process."""
    folder = tempfile.TemporaryDirectory(prefix="hapticd_proto_")
    files = sorted(name for name in os.listdir(os.path.join(PROTO, "hapticd", "v1")) if name.endswith(".proto"))
    subprocess.run(["protoc", f"--proto_path={PROTO}", f"--python_out={folder.name}", *(f"hapticd/v1/{name}" for name in files)], check=True)
    sys.path.insert(0, folder.name)
    return folder


try:
    import hapticd.v1.stream_pb2  # noqa: F401
except ImportError:
    _FOLDER = _generate()

from hapticd.v1 import answer_pb2 as answer  # noqa: E402
from hapticd.v1 import config_pb2 as config  # noqa: E402
from hapticd.v1 import control_pb2 as control  # noqa: E402
from hapticd.v1 import event_pb2 as event  # noqa: E402
from hapticd.v1 import state_pb2 as state  # noqa: E402
from hapticd.v1 import stream_pb2 as stream  # noqa: E402

__all__ = ["answer", "config", "control", "event", "state", "stream"]


def code(result):
    """Name of a Result's code, such as NOT_OWNER."""
    return answer.ResultCode.Name(result.code)[len("RESULT_CODE_"):]


def item(kind, **fields):
    """An Item of that kind: item("acquire", holder="me")."""
    made = stream.Item()
    getattr(made, kind).SetInParent()
    getattr(made, kind).MergeFrom(type(getattr(made, kind))(**fields))
    return made
