#!/usr/bin/python3
"""Holds every bit of what a build computes against tests/realtime/kept_bits.txt: forces, poses, events and States may not change unnoticed.

usage: kept_bits_test.py FOLDER_OF_RECORDING_READER [--write] [--only REGEX] PROBE...
Plays sessions against the daemon under the virtual clock and hashes, of each: of its recording what every tick was given and gave, the
events, and the chained hash of all States. Then runs the determinism probes. --write prints the lines of kept_bits.txt; a change that is
meant to change forces raises the number `physics` of recordings and writes the file anew, with the reason for every line.
"""
import argparse
import concurrent.futures
import hashlib
import math
import os
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(ROOT / "tests/system"), sys.argv[1]]

import daemon
import hapticd
import read_recording
from hapticd.v1 import recording_pb2, stream_pb2

KEPT = HERE / "kept_bits.txt"
# Fields that came later, and those that no promise is about: a time, and the hash of a layout that is the program's own.
LEFT_OUT = {"hapticd.v1.TickRecord.cpu_ns", "hapticd.v1.TickRecord.state_hash", "hapticd.v1.TickRecord.shown"}
FINGER = 'tools { name: "finger" parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } %s } pose_wg { p_m: [0, 0.0155, 0] } %s }\n'
STRINGS = "".join(f'strings {{ name: "s{k}" p_wa_m: [-0.55, {0.002 * (k % 2)}, {0.006 * k}] p_wb_m: [0.55, 0, {0.006 * k}] frequency_hz: {65.4 + 20 * k} }}\n' for k in range(5))


# What is hashed.

def feed(message, digest):
    """Every field that is set, by number, with the bits of its numbers."""
    for field, value in message.ListFields():
        if field.full_name in LEFT_OUT:
            continue
        digest.update(struct.pack("<I", field.number))
        # isinstance: the name of the property that tells repeated fields apart differs between versions of the library.
        values = [value] if isinstance(value, (int, float, str, bytes)) or hasattr(value, "ListFields") else list(value)
        digest.update(struct.pack("<I", len(values)))
        for each in values:
            if hasattr(each, "ListFields"):
                feed(each, digest)
            elif isinstance(each, float):
                digest.update(struct.pack("<d", each))
            elif isinstance(each, int):
                digest.update(each.to_bytes(16, "little", signed=True))
            else:
                digest.update(each.encode() if isinstance(each, str) else each)
    digest.update(b"|")


def hashes_of(recording):
    """(ticks, ticks with force, hash of the ticks, hash of the events)."""
    data = pathlib.Path(recording).read_bytes()
    reader = read_recording.Recording()
    for _, opcode, content in read_recording.records(data, 8):
        if opcode == 0x0F:
            break
        reader.take(opcode, content)
    kinds = {"/hapticd/tick": recording_pb2.TickRecord, "/hapticd/event": recording_pb2.EventRecord}
    digests = {topic: hashlib.blake2b(digest_size=12) for topic in kinds}
    ticks, pushed = 0, 0
    for channel, _, content in reader.messages:
        topic = reader.channels[channel][0]
        if topic in kinds:
            message = kinds[topic].FromString(content)
            feed(message, digests[topic])
            if topic == "/hapticd/tick":
                ticks += 1
                pushed += any(any(output.wrench_h_w.f_n) for output in message.outputs)
    return ticks, pushed, digests["/hapticd/tick"].hexdigest(), digests["/hapticd/event"].hexdigest()


# What is played.

def request(session, kind, **fields):
    item = stream_pb2.Item()
    body = getattr(item, kind)
    body.SetInParent()
    for name, value in fields.items():
        setattr(body, name, value)
    try:
        session.request(item)
        return True
    except hapticd.RequestError:
        return False


class Session:
    """One session; the States of all its runs chain into one hash."""

    def __init__(self, session, seed):
        self.session, self.random = session, random.Random(seed)
        self.chain = hashlib.blake2b(digest_size=12)
        self.tick = 0

    def load(self, text):
        self.session.load_scene(text)
        self.tick = 0

    def run(self, steps):
        """As far as it goes: a fault ends a run early."""
        result = self.session.run(steps=steps, collect=False)
        self.chain.update(result.state_hash)
        self.tick += result.steps
        return result.steps

    def push(self, rows, tool=0, twists=False, buttons=None):
        """Poses of the ticks that come, with velocities and buttons where they are asked for."""
        for first in range(0, len(rows), 14):
            item = stream_pb2.Item()
            item.pose_batch.first_tick = self.tick + first
            for k in range(first, min(first + 14, len(rows))):
                sample = item.pose_batch.poses.add(tool_id=tool)
                sample.pose_dh.p_m.extend(rows[k][:3])
                sample.pose_dh.q.extend(rows[k][3:] or (1.0, 0.0, 0.0, 0.0))
                if twists:
                    before = rows[max(0, k - 1)]
                    sample.twist_dh_d.v_m_per_s.extend((a - b) * 1000 for a, b in zip(rows[k][:3], before[:3]))
                    sample.twist_dh_d.w_rad_per_s.extend((0.0, 0.0, 0.0))
                sample.buttons = buttons(self.tick + k) if buttons else 0
            self.session._connection.submit(item)  # a good batch is not answered

    def play(self, rows, **options):
        self.push(rows, **options)
        return self.run(len(rows))


def gestures(steps):
    def play(session):
        while session.tick < steps:
            before = session.tick
            session.run(steps - session.tick)
            request(session.session, "clear")
            if session.tick == before:
                session.run(1)
    return play


def drags(session, ticks, tool=0, depth=0.0145, top=0.0155):
    """A finger that comes down from `top`, wanders over and between the strings, presses, slips and turns; rows of 7."""
    pick = session.random
    rows, phases = [], [pick.uniform(0, 6) for _ in range(6)]
    for k in range(ticks):
        t = 1e-3 * k
        ease = min(1.0, k / 250)
        y = top - depth * ease * (0.72 + 0.28 * math.sin(9 * t + phases[0]))
        z = 0.012 + 0.016 * math.sin(5.3 * t + phases[1])
        x = 0.08 * tool + 0.03 * math.sin(2.1 * t + phases[2])
        angle = 0.3 * math.sin(3 * t + phases[3])
        axis = [math.sin(phases[4]), math.cos(phases[4]) * math.cos(phases[5]), math.cos(phases[4]) * math.sin(phases[5])]
        rows.append((x, y, z, math.cos(angle / 2), *(math.sin(angle / 2) * a for a in axis)))
    return rows


def scene(features, part="", tool="", strings=STRINGS, solver=""):
    return 'name: "kept"\n' + FINGER % (part, tool) + strings + features + "\ntones {}\n" + solver


def scripted(text, ticks=900, depth=0.0145, top=0.0155, turned=False, **options):
    """A scene by name or text under a finger that drags; turned: down is -z."""
    def play(session):
        session.load(text)
        rows = drags(session, ticks, depth=depth, top=top)
        session.play([(x, z, y, *q) for x, y, z, *q in rows] if turned else rows, **options)
    return play


def five_tools(session):
    text = 'name: "five"\n' + "".join(
        f'tools {{ tool_id: {3 * k} name: "finger_{k}" parts {{ name: "tip" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: 0.005 }} }} }} '
        f'pose_wg {{ p_m: [{0.1 * k}, 0.0155, 0] }} }}\n' for k in range(5)) + STRINGS + "vibration {}\nfriction { coefficient: 0.3 }\ntorque {}\ntones {}\n"
    session.load(text)
    for k in range(5):
        session.push(drags(session, 600, tool=k), tool=3 * k)
    session.run(600)


def clutch_and_recentre(session):
    """By button, by request, in touch and free; and a map with a scale."""
    session.load(scene("vibration {}", tool="workspace { scale: 1.2 clutch_button: 0 recentre_button: 1 }"))
    session.play(drags(session, 500, depth=0.013, top=0.0129), buttons=lambda tick: (tick // 90 % 4 == 3) + 2 * (tick == 460))
    request(session.session, "recentre", tool_id=0)
    session.play(drags(session, 200, depth=0.012, top=0.0129))
    request(session.session, "clutch", tool_id=0, open=True)
    session.play(drags(session, 100, depth=0.013, top=0.0129))
    request(session.session, "clutch", tool_id=0, open=False)
    session.play(drags(session, 300, depth=0.013, top=0.0129))


def orders(session):
    """Disengage, Engage, Stop, Clear and a push of the guided check between ramps of live parameters."""
    session.load(scene("vibration {}\ntorque {}\nfriction { coefficient: 0.2 }", tool="coupling { kt_n_per_m: 900 damping_n_s_per_m: 1 }"))
    rows = drags(session, 1400)
    steps = [("disengage", {}), ("engage", {}), ("stop", {}), ("clear", {}), ("engage", {}), ("calibrate", {"step": 1}), ("calibrate", {"step": 3})]
    for k in range(14):
        session.play(rows[100 * k:100 * (k + 1)])
        if k % 3 == 1:
            session.session.set({"tools[0].force_gain": 0.4 + 0.03 * k, "strings[2].tension_n": 25.0 + k, "friction.coefficient": 0.02 * k})
        elif k // 2 < len(steps):
            kind, fields = steps[k // 2]
            request(session.session, kind, **fields)


def scenes_exchanged(session):
    """In flight, under force, onto the tool, with all that rings."""
    text = scene("vibration {}\nmodes { count: 12 }")
    session.load(text)
    rows = drags(session, 400)
    session.play(rows)
    session.load(scene("vibration {}\nlateral_force {}", strings=STRINGS + 'bodies { name: "ball" shape { spheres { centre_m: [0, -0.01, 0.01] radius_m: 0.012 } } }\n'))
    session.play(rows[::-1])
    session.load(text)
    session.play(rows)


def strange_poses(session):
    """What no device should say: NaN, infinite, far, quaternions of no length and almost unit ones, jumps, repeated poses; then Clear."""
    session.load(scene("vibration {}\ntorque {}"))
    rows = drags(session, 1600)
    nan, far = math.nan, 2e6
    for k in range(1600):
        x, y, z, *q = rows[k]
        if k % 160 == 150:
            kind = k // 160
            x = nan if kind == 0 else math.inf if kind == 1 else far if kind == 2 else x + 0.3 if kind == 3 else x
            q = [0.0] * 4 if kind == 4 else [1.2 * a for a in q] if kind == 5 else [-a for a in q] if kind == 6 else q
        q = [a * (1 + 1e-7 * math.sin(k)) for a in q]
        rows[k] = (x, y, z, *q)
    rows[900:1000] = [rows[900]] * 100
    at = 0
    while at < len(rows):
        part = rows[at:at + 40]
        try:
            at += session.play(part)
        except hapticd.RequestError:
            # Refused where it was decoded: nothing of the batch is queued, and these ticks hold the last pose.
            at += session.run(len(part)) or 1
        at += 0 if request(session.session, "clear") else 1


def injected(session):
    session.load(scene("vibration {}"))
    path = list(drags(session, 2600))
    while session.tick < 2600:
        # A run ends at a fault, and what is queued is dropped with it.
        session.push(path[session.tick:])
        session.run(2600 - session.tick)
        while session.tick < 2600 and not request(session.session, "clear"):
            session.run(min(20, 2600 - session.tick))


PLAYS = {}


def add(name, play, *options):
    PLAYS[name] = (play, options)


for shipped, gesture, steps in (
        ("guqin", "demonstration", 2500), ("guqin", "sweep", 1500), ("guqin", "slide_along", 1200), ("guqin_coarse", "strum", 1500),
        ("guqin_coarse", "press_and_hold", 1200), ("guqin_coarse", "gou", 1000), ("guqin_coarse", "hybrid_contact", 1200), ("bunny", "bunny_two_lines", 900), ("bunny_coarse", "touch_every_part", 1500),
        ("bunny", "bunny_line_and_pillar", 1500), ("cabin", "reach_through_cabin", 1200), ("five_fingers", "roll", 1500), ("guqin", "static_then_vibrating", 1200), ("guqin_coarse", "press", 1200), ("bunny_fine", "touch_every_part", 1200), ("guqin", "contact_switch", 900)):
    add(f"{shipped}/{gesture}", gestures(steps), "--scene", shipped, "--gesture", gesture)
for arm in ("firm", "adversarial"):
    add(f"guqin/arm_{arm}", gestures(900), "--scene", "guqin", "--gesture", "sweep", "--arm", arm, "--seed", "7")
for level in range(5):
    add(f"guqin/quality_{level}", gestures(700), "--scene", "guqin_coarse", "--gesture", "strum", "--quality", str(level))
add("guqin/quality_auto", gestures(1500), "--scene", "guqin", "--gesture", "sweep", "--quality", "auto", "--budget-us", "40")
for budget in (0, 5, 20, 80):
    add(f"stress/budget_{budget}", scripted("stress", 500, top=0.1, depth=0.13), "--device", "scripted", "--scene", "stress", "--budget-us", str(budget))
SCRIPTED = ("--device", "scripted", "--scene", "single_string")
add("scripted/plain", scripted(scene("")), *SCRIPTED)
add("scripted/vibration", scripted(scene("vibration {}")), *SCRIPTED)
add("scripted/friction", scripted(scene("vibration {}\nfriction { coefficient: 0.4 }")), *SCRIPTED)
add("scripted/friction_torque", scripted(scene("vibration {}\ntorque {}\nfriction { coefficient: 1 anchor_stiffness_n_per_m: 4000 }")), *SCRIPTED)
add("scripted/modes", scripted(scene("vibration {}\nmodes { count: 24 }")), *SCRIPTED)
add("scripted/modes_glide", scripted(scene("vibration { pitch_glide {} }\nmodes {}\nlateral_force {}")), *SCRIPTED)
add("scripted/lateral", scripted(scene("vibration {}\nlateral_force {}\ntorque {}")), *SCRIPTED)
add("scripted/damped", scripted(scene("vibration {}\ntorque {}", tool="coupling { kt_n_per_m: 1200 damping_n_s_per_m: 2 }")), *SCRIPTED)
add("scripted/velocities", scripted(scene("vibration {}\ntorque {}", tool="coupling { kt_n_per_m: 1200 damping_n_s_per_m: 2 }"), twists=True), *SCRIPTED)
add("scripted/fingertip", scripted(scene("vibration {}\ntorque {}", part="fingertip { stiffness_n_per_m: 2000 damping_n_s_per_m: 0.5 }")), *SCRIPTED)
add("scripted/stiff_contact", scripted(scene("vibration {}", strings=STRINGS.replace("frequency_hz", "contact_stiffness_n_per_m: 3000 frequency_hz"))), *SCRIPTED)
add("scripted/few_substeps", scripted(scene("vibration {}\ntorque {}", solver="solver { max_substeps: 1 max_rows: 4 }")), *SCRIPTED)
add("scripted/sagging", scripted(scene("", strings='strings { name: "cable" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0.02] tension_n: 30 sag_m: 0.004 }\n'), depth=0.024), *SCRIPTED)
add("scripted/wall", scripted("wall", turned=True, top=0.025, depth=0.03), *SCRIPTED)
add("scripted/sphere", scripted("sphere", top=0.07, depth=0.022), *SCRIPTED)
add("scripted/strings_100", scripted("strings_100"), *SCRIPTED)
add("scripted/five_tools", five_tools, *SCRIPTED)
add("scripted/clutch", clutch_and_recentre, *SCRIPTED)
add("scripted/orders", orders, *SCRIPTED)
add("scripted/scenes", scenes_exchanged, *SCRIPTED)
add("scripted/strange_poses", strange_poses, *SCRIPTED)
for fault in ("lost", "nan", "inf", "quaternion", "flip", "frozen", "jump", "delay", "write", "detach"):
    add(f"inject/{fault}", injected, *SCRIPTED, "--inject", f"{fault}:3")


def line_of(name):
    play, options = PLAYS[name]
    with tempfile.TemporaryDirectory() as folder:
        file = f"{folder}/kept.mcap"
        with daemon.Daemon("--clock", "virtual", "--record", file, *options, state=folder) as played:
            with hapticd.Session(played.address, reconnect=False) as session:
                session.acquire("kept")
                kept = Session(session, name)
                play(kept)
            played.end()
        ticks, pushed, records, events = hashes_of(file)
    return f"{name} {ticks} ticks {pushed} with force {records} events {events} states {kept.chain.hexdigest()}"


def lines_of_probe(path):
    said = subprocess.run([path], check=True, capture_output=True, text=True).stdout
    return [f"{pathlib.Path(path).name}: {line}" for line in said.splitlines()]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("reader")
    parser.add_argument("probes", nargs="*")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = [pool.submit(lines_of_probe, probe) for probe in options.probes]
        lines = [future.result() for future in [pool.submit(line_of, name) for name in PLAYS if re.search(options.only, name)]]
        lines += [line for future in said for line in future.result()]
    if options.write:
        print("\n".join(lines))
        return 0
    kept = [line for line in KEPT.read_text().splitlines() if line and not line.startswith("#")]
    for line in lines:
        if line not in kept:
            print(f"not as kept: {line}")
    for line in kept:
        if line not in lines:
            print(f"kept:        {line}")
    print(f"{len(set(lines) & set(kept))} of {len(kept)} lines as kept")
    return 0 if sorted(lines) == sorted(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
