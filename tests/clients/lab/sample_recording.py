"""A recording for tests, written after the specification of MCAP (mcap.dev) by code that shares nothing with the recorder: a ball that
goes along a string at constant speed, a tick each ms."""
import struct

from hapticd.v1 import recording_pb2

TOPICS = ("header", "scene", "parameters", "tick", "event", "snapshot")
MAGIC = b"\x89MCAP0\r\n"
EPOCH_NS = 1_700_000_000_000_000_000
BALL_RADIUS_M = 0.03
HEIGHT_M = 0.04


def _text(text):
    return struct.pack("<I", len(text)) + text.encode()


def _record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def _message(topic, time_ns, message):
    return _record(5, struct.pack("<HIQQ", TOPICS.index(topic) + 1, 0, time_ns, time_ns) + message.SerializeToString())


def _scene():
    record = recording_pb2.SceneRecord(scene_id=1, hash=b"s" * 32)
    scene = record.scene
    scene.name = "one_string"
    scene.strings.add(name="C2", p_wa_m=[0.55, 0.0, 0.0], p_wb_m=[-0.55, 0.0, 0.0], radius_m=0.001)
    tool = scene.tools.add(name="ball")
    spheres = tool.parts.add(name="ball").shape.spheres
    spheres.centre_m.extend([0.0, 0.0, 0.0])
    spheres.radius_m.append(BALL_RADIUS_M)
    return record


def _tick(number, x_m):
    tick = recording_pb2.TickRecord(tick=number, t_ns=number * 1_000_000, scene_id=1, loop_state=4)
    tick.inputs.add(tool_id=0).pose_wh.CopyFrom(_pose(x_m))
    output = tick.outputs.add(tool_id=0)
    output.pose_wg.CopyFrom(_pose(x_m))
    output.wrench_h_w.f_n.extend([0.0, 2.0, 0.0])
    output.wrench_h_w.t_n_m.extend([0.0, 0.0, 0.01])
    return tick


def _pose(x_m):
    pose = recording_pb2.TickRecord().inputs.add().pose_wh
    pose.p_m.extend([x_m, HEIGHT_M, 0.0])
    pose.q.extend([1.0, 0.0, 0.0, 0.0])
    return pose


def write(path, duration_s, begin_m, end_m):
    """The ball goes from x = `begin_m` to `end_m` within `duration_s`."""
    parts = [MAGIC, _record(1, _text("") + _text("test"))]
    for number, topic in enumerate(TOPICS, 1):
        parts.append(_record(4, struct.pack("<HH", number, 0) + _text(f"/hapticd/{topic}") + _text("protobuf") + struct.pack("<I", 0)))
    parts.append(_message("header", EPOCH_NS, recording_pb2.RecordHeader(format_version=2, server_version="test", period_ns=1_000_000)))
    parts.append(_message("scene", EPOCH_NS, _scene()))
    ticks = round(duration_s * 1000)
    for number in range(ticks + 1):
        parts.append(_message("tick", EPOCH_NS + number * 1_000_000, _tick(number, begin_m + (end_m - begin_m) * number / ticks)))
    parts += [_record(15, struct.pack("<I", 0)), _record(2, bytes(20)), MAGIC]
    path.write_bytes(b"".join(parts))
