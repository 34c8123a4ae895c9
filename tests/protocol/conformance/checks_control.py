"""Checks of sections 8, 9 and 10: Results, who may do what, the lease, parameters and scenes."""
import hashlib
import itertools
import os
import re
import time

from peer import code, expect
from registry import check
from schema import config, control, item, state

LEASE_S = 2.0
LEASE_SLACK_S = 0.5
PAYLOADS = {"get_parameters": "parameters", "list_scenes": "listing", "list_gestures": "listing", "list_recordings": "listing",
            "get_device_info": "devices", "get_counts": "counts", "ping": None}
NEED_LEASE = ("release", "engage", "disengage", "clear", "load_scene", "set_parameter", "pose_batch", "run", "play_gesture", "replay", "record",
              "calibrate", "recentre", "clutch", "put_asset")


@check(8)
def every_request_is_answered_once_in_order(server):
    """Each request gets exactly one Result with its id, in the order of the requests."""
    peer = server.open()
    kinds = list(PAYLOADS) * 3
    ids = [peer.queue(item(kind)) for kind in kinds]
    peer.send()
    peer.result(ids[-1], 10)
    peer.pump(0.2)
    expect(list(peer.results) == ids, f"Results for {list(peer.results)}")
    for number, kind in zip(ids, kinds):
        result = peer.results[number]
        expect(code(result) == "OK", f"{kind}: {code(result)} {result.message}")
        expect(result.WhichOneof("payload") == PAYLOADS[kind], f"{kind} was answered with {result.WhichOneof('payload')}")


@check(8)
def listings_are_plausible(server):
    """ListScenes names the scenes, the loaded one among them if it is installed; descriptions are none or as many as names."""
    peer = server.open()
    listing = peer.demand(item("list_scenes")).listing
    expect(len(listing.names) >= 1 and all(listing.names), "no scenes")
    expect(len(listing.descriptions) in (0, len(listing.names)), "descriptions and names differ in number")
    devices = peer.demand(item("get_device_info")).devices.devices
    expect(len(devices) >= 1, "no device")


@check(8)
def counts_name_each_cause_once(server):
    """GetCounts tells of each cause once, and no count falls."""
    peer = server.open()
    before, after = ([(each.cause, each.count) for each in peer.demand(item("get_counts")).counts.counts] for _ in range(2))
    causes = [cause for cause, _ in before]
    expect(1 <= len(causes) <= 64 and len(set(causes)) == len(causes), f"the causes are {causes}")
    expect(all(re.fullmatch("[a-z_]{1,64}", cause) for cause in causes), f"the causes are {causes}")
    expect(all(dict(after)[cause] >= count for cause, count in before), f"{before}, then {after}")


@check(8)
def what_needs_the_lease_is_refused_without(server):
    """Every request that needs the lease is NOT_OWNER for a session that does not hold it, whether anybody does or not."""
    peer = server.open()
    for kind in NEED_LEASE:
        peer.demand(item(kind), "NOT_OWNER")
    server.holder()
    for kind in NEED_LEASE:
        peer.demand(item(kind), "NOT_OWNER")


@check(9)
def the_lease_is_granted_and_told_to_all(server):
    """Acquire answers with the lease; LeaseInfo tells every session, and yours is true for the holder alone."""
    watcher, holder = server.open(), server.open()
    lease = holder.demand(item("acquire", holder="conformance one")).lease
    expect(lease.fence > 0 and lease.yours and lease.holder == "conformance one", f"the Result's lease is {lease}")
    expect(lease.ttl_ms == 2000, f"ttl_ms {lease.ttl_ms}")
    for peer, yours in ((holder, True), (watcher, False)):
        expect(peer.pump(1.0, lambda peer=peer: peer.of_kind("lease_info")[-1].fence == lease.fence), "no LeaseInfo")
        told = peer.of_kind("lease_info")[-1]
        expect(not yours or peer.items[-1][1].HasField("lease_info"), "LeaseInfo came before the Result of Acquire")
        expect(told.yours == yours and told.holder == "conformance one", f"LeaseInfo {told}")


@check(9)
def one_session_holds_the_lease(server):
    """Acquire is BUSY while another session holds the lease; for the holder it is OK and keeps the number."""
    holder, other = server.holder(), server.open()
    fence = holder.of_kind("result")[-1].lease.fence
    other.demand(item("acquire"), "BUSY")
    again = holder.demand(item("acquire", holder="conformance")).lease
    expect(again.fence == fence, f"the number changed from {fence} to {again.fence}")


@check(9)
def a_lease_is_taken_over_with_a_reason(server):
    """Acquire with a reason takes the lease from who holds it: a new number, all are told from whom and why, and a Run of steps ends NOT_OWNER."""
    holder, other, watcher = server.holder(), server.open(), server.open()
    old = holder.of_kind("result")[-1].lease.fence
    run = None
    if server.virtual:
        run = holder.queue(item("run", mode=control.RUN_MODE_STEP, steps=100_000_000))
        holder.send()
        holder.pump(0.1)
    lease = other.demand(item("acquire", holder="other", take_over="checking")).lease
    expect(lease.fence > old and lease.yours and lease.taken_from == "conformance" and lease.reason == "checking", f"the lease is {lease}")
    for peer in (holder, other, watcher):
        expect(peer.pump(1.0, lambda peer=peer: peer.of_kind("lease_info")[-1].fence == lease.fence), "no LeaseInfo")
        told = peer.of_kind("lease_info")[-1]
        expect((told.yours, told.holder, told.taken_from, told.reason) == (peer is other, "other", "conformance", "checking"), f"LeaseInfo {told}")
    if run is not None:
        expect(code(holder.result(run)) == "NOT_OWNER", "the Run went on")
    holder.demand(item("engage"), "NOT_OWNER")


@check(9)
def fencing_numbers_grow(server):
    """Each new grant has a larger number than any before, and a request with an older number is NOT_OWNER."""
    holder = server.holder()
    old = holder.of_kind("result")[-1].lease.fence
    holder.demand(item("release"))
    expect(holder.pump(1.0, lambda: holder.of_kind("lease_info")[-1].fence == 0), "LeaseInfo does not say that nobody holds it")
    new = holder.demand(item("acquire")).lease.fence
    expect(new > old, f"{new} after {old}")
    late = item("recentre")
    late.fence = old
    expect(code(holder.request(late)) == "NOT_OWNER", "a request with an old fence was not refused")
    good = item("get_parameters")
    good.fence = new
    holder.demand(good)


@check(9, slow=True)
def the_lease_ends_after_2_s_of_silence(server):
    """2 s without a datagram of the holder end the lease, and LeaseInfo says so to all; every datagram before renews it."""
    holder, watcher = server.holder(), server.open()
    fence = watcher.of_kind("lease_info")[-1].fence
    begin = time.monotonic()
    while time.monotonic() - begin < 2.6:
        holder.pump(0.05)
        watcher.pump(0.02)
    expect(watcher.of_kind("lease_info")[-1].fence == fence, "the lease ended though the holder was not silent")
    silent = holder.sent_at
    expect(watcher.pump(LEASE_S + LEASE_SLACK_S + 0.2, lambda: watcher.of_kind("lease_info")[-1].fence == 0), "the lease did not end")
    took = time.monotonic() - silent
    expect(LEASE_S - 0.05 <= took <= LEASE_S + LEASE_SLACK_S, f"the lease ended after {took:.2f} s")
    holder.demand(item("recentre"), "NOT_OWNER")


@check(9)
def bye_gives_the_lease_back(server):
    """The end of the holder's session ends the lease."""
    holder, watcher = server.holder(), server.open()
    expect(watcher.of_kind("lease_info")[-1].fence > 0, "a joiner is not told of the lease")
    holder.bye()
    expect(watcher.pump(1.0, lambda: watcher.of_kind("lease_info")[-1].fence == 0), "Bye did not end the lease")
    watcher.demand(item("acquire"))


@check(9)
def stop_needs_no_lease_and_is_latched(server):
    """Stop of a session without the lease makes the wrench zero and latches FAULT with cause STOPPED, until Clear."""
    holder, other = server.holder(), server.open()
    server.ticking(holder)
    other.demand(item("subscribe", divisor=1, sections=[control.SECTION_TOOLS]))
    other.demand(item("stop"))
    begin = len(other.states)
    expect(other.pump(1.0, lambda: any(each.loop_state == state.LOOP_STATE_FAULT for _, each in other.states[begin:])), "no FAULT after Stop")
    other.pump(0.1)
    shown = other.states[-1][1]
    expect(shown.cause == 1, f"cause {shown.cause}")
    expect(all(abs(number) == 0 for tool in shown.tools for number in tool.wrench_h_w), "a wrench after Stop")
    other.demand(item("clear"), "NOT_OWNER")
    holder.demand(item("engage"), "WRONG_STATE")
    holder.demand(item("clear"))
    expect(other.pump(1.0, lambda: other.states[-1][1].loop_state != state.LOOP_STATE_FAULT), "still in FAULT after Clear")


@check(10)
def parameters_are_listed_with_their_ranges(server):
    """SceneInfo lists the live parameters; GetParameters gives the value of each, and for an unknown path an error that names it."""
    peer = server.open()
    info = peer.of_kind("scene_info")[0]
    expect(len(info.parameters) > 0, "no live parameters")
    for each in peer.demand(item("get_parameters")).parameters.values:
        expect(each.path and each.WhichOneof("value"), f"{each.path or 'a parameter'} without path or value")
    result = peer.request(item("get_parameters", paths=["strings[0].no_such_field"]))
    expect(code(result) == "NOT_FOUND" and result.path == "strings[0].no_such_field", f"{code(result)} path {result.path}")


def a_number(peer):
    """A live number with a range, its value, and another value within the range."""
    ranges = {each.path: each for each in peer.of_kind("scene_info")[-1].parameters if each.HasField("minimum") and each.HasField("maximum")}
    for each in peer.demand(item("get_parameters")).parameters.values:
        told = ranges.get(each.path) or ranges.get("[*]".join(part.split("]")[-1] for part in each.path.split("[")))
        if each.WhichOneof("value") == "number" and told and each.number > 0 and each.number * 1.01 < told.maximum:
            return each.path, each.number, each.number * 1.01, told
    expect(False, "no live number with a range")


@check(10)
def a_parameter_is_set_and_read(server):
    """SetParameter changes a live parameter; GetParameters gives the new value at once, ramps as if ended."""
    holder = server.holder()
    path, old, new, _ = a_number(holder)
    holder.demand(item("set_parameter", assignments=[{"path": path, "number": new}]))
    values = holder.demand(item("get_parameters", paths=[path])).parameters.values
    expect([(each.path, each.number) for each in values] == [(path, new)], f"{values} after {path} = {new}")
    holder.demand(item("set_parameter", assignments=[{"path": path, "number": old}]))


@check(10)
def set_parameter_is_all_or_none(server):
    """One bad assignment refuses all of them, and path names it: NOT_FOUND no such path, INVALID the wrong kind, OUT_OF_RANGE beyond its
    range or not finite."""
    holder = server.holder()
    path, old, new, told = a_number(holder)
    bad = {
        "OUT_OF_RANGE": {"path": path, "number": told.maximum * 2 + 1},
        "NOT_FOUND": {"path": "strings[99999].tension_n", "number": 1.0},
        "INVALID": {"path": path, "text": "much"},
    }
    for wanted, assignment in bad.items():
        result = holder.request(item("set_parameter", assignments=[{"path": path, "number": new}, assignment]))
        expect(code(result) == wanted and result.path == assignment["path"], f"{assignment}: {code(result)} path {result.path}")
        expect(result.message != "", f"{assignment}: no message for people")
        value = holder.demand(item("get_parameters", paths=[path])).parameters.values[0].number
        expect(value == old, f"{path} is {value} after a refused request, not {old}")
    result = holder.request(item("set_parameter", assignments=[{"path": path, "number": float("nan")}]))
    expect(code(result) == "OUT_OF_RANGE", f"a number that is none: {code(result)}")


@check(10)
def a_bad_scene_changes_nothing(server):
    """LoadScene of an unknown name or a bad text is refused with a message, and the scene stays."""
    holder = server.holder()
    before = holder.of_kind("scene_info")[-1].scene_id
    result = holder.request(item("load_scene", name="no_such_scene_anywhere"))
    expect(code(result) == "NOT_FOUND" and result.message, f"an unknown name: {code(result)} {result.message}")
    for text in ("name: 7 {", 'name: "x"'):
        result = holder.demand(item("load_scene", text=text), "INVALID")
        expect(result.message, "no message for people")
    late = server.open()
    expect(late.of_kind("scene_info")[0].scene_id == before, "the scene changed")


SHAPED = ('name: "brought" tools { name: "t" pose_wg { p_m: [0, 1, 0] } parts { name: "p" shape { mesh: "brought.ply" '
          'spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } }')


@check(10)
def a_file_is_brought_piece_by_piece(server):
    """PutAsset takes a file's pieces in order under the lease and says how much there is; what is whole is not asked for again."""
    holder, content = server.holder(), os.urandom(65536 + 4321)
    put = {"hash": hashlib.blake2b(content, digest_size=32).digest(), "size": len(content)}
    blobs = itertools.count(1)

    def answer_to(**more):
        request = item("put_asset", **put, **more).SerializeToString()
        last = holder.queue_blob(request, next(blobs)) if len(request) > 1000 else holder.queue(item("put_asset", **put, **more))
        holder.send()
        return holder.result(last, 20)

    def there(**more):
        result = answer_to(**more)
        expect(code(result) == "OK", f"put_asset: {code(result)} {result.path} {result.message}")
        return result.asset.received

    expect(there() == 0, "a file that nobody has brought is there")
    late = {"offset": 65536, "bytes": content[65536:]}
    expect(code(answer_to(**late)) == "OUT_OF_RANGE", "the second piece came first")
    short = answer_to(bytes=content[:800])
    expect(code(short) == "INVALID" and short.message, f"a short piece: {code(short)} {short.message}")
    expect(there(bytes=content[:65536]) == there() == 65536, "the first piece did not come")
    result = holder.request(item("load_scene", text=SHAPED, check_only=True, assets=[{"name": "brought.ply", "hash": put["hash"]}]), 20)
    expect(code(result) == "NOT_FOUND" and result.message, f"a file that is not whole: {code(result)}")
    expect(there(**late) == there() == there(bytes=b"x") == len(content), "the file is not whole")
    holder.demand(item("load_scene", text=SHAPED, check_only=True, assets=[{"name": "brought.ply", "hash": put["hash"]}]), seconds=20)
    other = item("load_scene", text=SHAPED, check_only=True, assets=[{"name": "other.ply", "hash": put["hash"]}])
    expect(code(holder.request(other, 20)) in ("INVALID", "NOT_FOUND"), "a name that nobody has brought was found")


@check(10)
def a_file_of_another_hash_is_refused(server):
    """Bytes whose hash is not the one that was said are INVALID and forgotten; a hash of another length is INVALID, a size of 0 or beyond
    64 MiB OUT_OF_RANGE."""
    holder, wrong = server.holder(), os.urandom(32)
    expect(code(holder.request(item("put_asset", hash=wrong, size=3, bytes=b"abc"))) == "INVALID", "bytes of another hash were taken")
    expect(holder.demand(item("put_asset", hash=wrong, size=3)).asset.received == 0, "they are kept")
    for short in (b"", wrong[:31], wrong + b"x"):
        expect(code(holder.request(item("put_asset", hash=short, size=3, bytes=b"abc"))) == "INVALID", f"a hash of {len(short)} bytes")
    for size in (0, (64 << 20) + 1, 2**32 - 1):
        expect(code(holder.request(item("put_asset", hash=wrong, size=size, bytes=b"abc"))) == "OUT_OF_RANGE", f"a size of {size}")


@check(10)
def a_new_scene_is_told_to_all(server):
    """LoadScene gives every session a SceneInfo with the next scene_id, and ticks start at 0."""
    holder, watcher = server.holder(), server.open()
    before = holder.of_kind("scene_info")[-1].scene_id
    after = server.reload(holder)
    expect(after == before + 1, f"scene_id {after} after {before}")
    expect(watcher.pump(2.0, lambda: watcher.of_kind("scene_info")[-1].scene_id == after), "a watcher is not told")
    server.ticking(holder)
    watcher.demand(item("subscribe", divisor=1, sections=[control.SECTION_QUALITY]))
    expect(watcher.pump(2.0, lambda: watcher.states), "no States")
    expect(watcher.states[0][1].scene_id == after and watcher.states[0][1].tick < 5000, "States of another scene, or ticks that go on")


@check(10)
def a_late_joiner_is_told_the_scene_first(server):
    """Who joins later gets the SceneInfo of the scene in force as the first Item."""
    holder = server.holder()
    after = server.reload(holder)
    late = server.open()
    expect(late.items[0][1].HasField("scene_info") and late.items[0][1].scene_info.scene_id == after, "another scene")
    expect(late.of_kind("lease_info")[0].fence > 0 and not late.of_kind("lease_info")[0].yours, "the lease is not told")


@check(11)
def steps_need_the_virtual_clock(server):
    """Run{STEP} is WRONG_STATE under the real clock, and a clock is one of the two."""
    holder = server.holder()
    expect(holder.of_kind("scene_info")[0].clock in (config.CLOCK_MODE_REALTIME, config.CLOCK_MODE_VIRTUAL), "no clock")
    if not server.virtual:
        holder.demand(item("run", mode=control.RUN_MODE_STEP, steps=10), "WRONG_STATE")
