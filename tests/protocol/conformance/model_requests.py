"""The requests of the model server, a function each: (server, session, item id, request) to a code and the fields of the Result, or to
None where the Result comes later or never."""
import hashlib
import time

from google.protobuf import text_format

import model_world
from schema import answer, control, state

OK, UNSUPPORTED, NOT_OWNER, INVALID, OUT_OF_RANGE, NOT_FOUND, WRONG_STATE, BUSY = (
    answer.RESULT_CODE_OK, answer.RESULT_CODE_UNSUPPORTED, answer.RESULT_CODE_NOT_OWNER, answer.RESULT_CODE_INVALID,
    answer.RESULT_CODE_OUT_OF_RANGE, answer.RESULT_CODE_NOT_FOUND, answer.RESULT_CODE_WRONG_STATE, answer.RESULT_CODE_BUSY)
NEEDS_LEASE = {"release", "engage", "disengage", "clear", "load_scene", "set_parameter", "pose_batch", "run", "play_gesture", "replay", "record",
               "calibrate", "recentre", "clutch", "put_asset"}


def do_subscribe(server, remote, _, subscribe):
    if subscribe.divisor > 1_000_000 or subscribe.max_contacts > 256:
        return OUT_OF_RANGE, {"path": "divisor" if subscribe.divisor > 1_000_000 else "max_contacts"}
    remote.subscription, remote.state = (subscribe if subscribe.divisor else None), None
    remote.unseen.clear()
    return OK, {}


def do_acquire(server, remote, _, acquire):
    if server.owner not in (None, remote) and not acquire.take_over:
        return BUSY, {"message": f"{server.holder} holds the lease"}
    server.taken_from, server.reason = (server.holder, acquire.take_over) if server.owner and acquire.take_over else ("", "")
    if server.reason:
        if server.running and server.running[0] is server.owner is not remote:
            server.result(server.owner, server.running[1], NOT_OWNER, message="the lease was taken over")
            server.running = None
        server.lose_lease(server.owner)
    if server.owner is None:
        server.grants += 1
        server.fence, server.owner, server.holder = server.grants, remote, acquire.holder
        server.lease_news = True
    return OK, {"lease": server.lease_info(remote)}


def do_release(server, remote, *_):
    server.lose_lease(remote)
    return OK, {}


def do_stop(server, *_):
    server.world.loop_state, server.world.cause = state.LOOP_STATE_FAULT, 1
    server.end_run()
    return OK, {}


def do_clear(server, *_):
    server.world.loop_state, server.world.cause = state.LOOP_STATE_READY, 0
    return OK, {}


def do_engage(server, *_):
    if server.world.loop_state == state.LOOP_STATE_FAULT:
        return WRONG_STATE, {"message": "clear the fault first"}
    server.world.loop_state = state.LOOP_STATE_ENGAGED
    return OK, {}


def do_get_parameters(server, _, __, get):
    missing = [path for path in get.paths if path.replace("*", "0") not in server.world.parameters]
    if missing:
        return NOT_FOUND, {"path": missing[0]}
    wanted = [path.replace("*", "0") for path in get.paths] or list(server.world.parameters)
    return OK, {"parameters": {"values": [{"path": path, "number": server.world.parameters[path]} for path in wanted]}}


def do_set_parameter(server, _, __, change):
    for each in change.assignments:
        if each.path not in server.world.parameters:
            return NOT_FOUND, {"path": each.path, "message": "no such live parameter"}
        if each.WhichOneof("value") != "number":
            return INVALID, {"path": each.path}
        low, high = model_world.LIVE[each.path]
        if not low <= each.number <= high:
            return OUT_OF_RANGE, {"path": each.path}
    if change.HasField("at_tick") and not 0 <= change.at_tick - server.world.tick <= 1_000_000:
        return OUT_OF_RANGE, {"path": "at_tick"}
    server.world.parameters.update({each.path: each.number for each in change.assignments})
    return OK, {}


def do_put_asset(server, _, __, put):
    if len(put.hash) != 32:
        return INVALID, {"path": "hash"}
    if not 0 < put.size <= 64 << 20:
        return OUT_OF_RANGE, {"path": "size"}
    there = server.files.get(put.hash, b"")
    if put.bytes and len(there) < put.size:
        if put.offset != len(there):
            return OUT_OF_RANGE, {"path": "offset"}
        if len(put.bytes) != min(65536, put.size - len(there)):
            return INVALID, {"path": "bytes"}
        there += put.bytes
        if len(there) == put.size and hashlib.blake2b(there, digest_size=32).digest() != put.hash:
            return INVALID, {"path": "hash"}
        server.files[put.hash] = there
    return OK, {"asset": {"received": len(there)}}


def is_brought(server, asset):
    return hashlib.blake2b(server.files.get(asset.hash, b""), digest_size=32).digest() == asset.hash


def do_load_scene(server, _, __, load):
    if not all(is_brought(server, asset) for asset in load.assets):
        return NOT_FOUND, {"path": "assets"}
    brought = {asset.name for asset in load.assets}
    if load.WhichOneof("source") == "name" and load.name not in model_world.SCENES:
        return NOT_FOUND, {"path": "name", "message": f"there is no scene {load.name}"}
    try:
        text = load.text or model_world.SCENES[load.name]
        checked = model_world.World(True)
        checked.load(text)
    except text_format.ParseError as error:
        return INVALID, {"path": "text", "message": str(error)[:300]}
    if not brought.issuperset(part.shape.mesh for tool in checked.scene.tools for part in tool.parts if part.shape.mesh):
        return INVALID, {"path": "mesh"}
    if not load.check_only:
        server.world.load(text)
        for each in server.remotes.values():
            each.newest, each.state = 0, None
            each.unseen.clear()
            server.tell(each, scene_info=server.scene_info())
    return OK, {}


def do_pose_batch(server, _, __, batch):
    if not server.world.virtual:
        return WRONG_STATE, {"path": "poses", "message": "the device is not scripted"}
    return (None, {}) if server.world.queue(batch) else (BUSY, {})


def do_run(server, remote, item_id, run):
    if run.mode == control.RUN_MODE_STEP:
        if not server.world.virtual or run.steps == 0 or server.world.live:
            return (WRONG_STATE if not server.world.virtual or run.steps else OUT_OF_RANGE), {"path": "steps"}
        server.running = [remote, item_id, run.steps, 0, 0]
        return None, {}
    server.end_run()
    server.world.live = run.mode == control.RUN_MODE_LIVE
    server.world.began_ns = time.monotonic_ns() - server.world.tick * model_world.PERIOD_NS
    return OK, {}


def do_list_scenes(server, *_):
    return OK, {"listing": {"names": list(model_world.SCENES)}}


def do_list_gestures(*_):
    return OK, {"listing": {}}


do_list_recordings = do_list_gestures


def do_get_counts(*_):
    return OK, {"counts": {"counts": [{"cause": "received", "count": 1}]}}


def do_get_device_info(server, *_):
    return OK, {"devices": {"devices": [{"stiffness_bound_n_per_m": 1000}]}}
