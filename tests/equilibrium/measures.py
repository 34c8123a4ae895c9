"""What the page of contact truth measures besides the oracle's cases: loop integrals, friction that holds, cost per tick. Each gives
plain numbers for the page and its file of earlier figures. SI."""
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time

import numpy as np
import played

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ("bunny", "cabin", "guqin", "single_string", "sphere", "strings_100", "stress", "wall")
LOOPS, LOOP_TICKS, LOOP_SEED = 25, 160, 30


def forces_of(states):
    return np.array([played.computed(state.tools[0])[:3] for state in states])


def into_touch(player, start):
    """The nearest place of the hand along an axis at which it feels a force: (place, direction), or None."""
    found = None
    for step in (5e-4, 2e-3):
        for direction in np.vstack((-np.eye(3), np.eye(3))):
            player.session.load_scene(player.scene_name)
            states = player.run([start] * 3 + [start + step * k * direction for k in range(500)])
            strength = np.linalg.norm(forces_of(states), axis=1)
            hits = np.nonzero(strength > 0.1)[0]
            if len(hits) and (found is None or hits[0] < found[0]):
                found = (hits[0], start + step * (hits[0] - 3) * direction, direction)
        if found:
            return found[1:]
    return None


def loops(player, name):
    """Work on the hand of closed ways in touch: the largest gain and loss of a lap, J, over ways on which nothing slipped."""
    player.scene_name = name
    player.session.load_scene(name)
    player.session.subscribe(divisor=1, sections=["TOOLS"])
    start = np.array(player.session.scene.scene.tools[0].pose_wg.p_m or (0.0, 0.0, 0.0))
    touch = into_touch(player, start)
    if touch is None:
        return None
    place, direction = touch
    random = np.random.default_rng(LOOP_SEED)
    works, largest = [], 0.0
    player.session.load_scene(name)
    ticks = int(np.linalg.norm(place - start) / 2e-4) + 1
    player.run([start + (place - start) * k / ticks for k in range(ticks + 1)])
    for _ in range(LOOPS):
        a, b = random.normal(size=(2, 3)) * 1e-3
        turns = 2 * np.pi * np.arange(LOOP_TICKS + 1) / LOOP_TICKS
        middle = place + direction * 1e-3
        way = middle + np.sin(turns)[:, None] * a + (np.cos(turns) - 1)[:, None] * b
        to = [place + (middle - place) * k / 20 for k in range(20)] + [middle] * 40
        player.run(to)
        # A lap to settle, and one that counts.
        player.run(way)
        f = forces_of(player.run(way))
        works.append(float(np.sum(0.5 * (f[:-1] + f[1:]) * np.diff(way, axis=0))))
        largest = max(largest, float(np.linalg.norm(f, axis=1).max()))
        player.run([middle + (place - middle) * k / 20 for k in range(21)])
    return {"laps": len(works), "gain_uj": 1e6 * max(works), "loss_uj": -1e6 * min(works), "median_uj": 1e6 * float(np.median(works)),
            "largest_n": largest}


GLIDES = {"a string that yields": "", "a string that yields, with lateral_force": "lateral_force {}", "preset paper": "preset: PRESET_PAPER"}


def glide(player, extras, depth=4e-3, speed=0.3):
    """Work on the hand of a lap: press a string in its middle, glide to a twentieth of it, lift, back in the air. As loops()."""
    player.load('name: "glide" tools { name: "tool" parts { name: "part" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } '
                'pose_wg { p_m: [0, 0.0084, 0.0003] } } strings { name: "string" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] } torque {} ' + extras)
    a, b, top, z = 0.0, -0.495, 0.0064, 3e-4
    press, way = int(depth / 3e-5), int((a - b) / (speed * 1e-3))
    lap = ([(a, top - depth * k / press, z) for k in range(press)] + [(a + (b - a) * k / way, top - depth, z) for k in range(way)] +
           [(b, top - depth + depth * k / press, z) for k in range(press)] + [(b + (a - b) * k / way, top, z) for k in range(way)] + [(a, top, z)])
    player.run(lap)
    works, largest = [], 0.0
    for _ in range(3):
        f = forces_of(player.run(lap))
        works.append(float(np.sum(0.5 * (f[:-1] + f[1:]) * np.diff(np.array(lap), axis=0))))
        largest = max(largest, float(np.linalg.norm(f, axis=1).max()))
    return {"laps": 3, "gain_uj": 1e6 * max(works), "loss_uj": -1e6 * min(works), "median_uj": 1e6 * float(np.median(works)), "largest_n": largest}


HOLD = """name: "hold" tools { name: "tool" parts { name: "part" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
pose_wg { p_m: [0, 0.012, %s] } }
strings { name: "string" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] } friction { coefficient: 0.5 } torque {}"""


def hold(player, beside_mm, seconds=30):
    """For how long a finger holds a string of friction 0.5 that it presses 23 mm down, its centre so far beside the string, s."""
    z = 1e-3 * beside_mm
    player.load(HOLD % repr(float(z)))
    player.run([(0, 0.012 - 1e-4 * k, z) for k in range(300)])
    first = None
    for second in range(seconds):
        f = forces_of(player.run([(0, -0.018, z)] * 1000))
        first = f[50] if first is None else first
        lost = np.nonzero(np.linalg.norm(f[50 if second == 0 else 0:] - first, axis=1) > 0.01 * np.linalg.norm(first))[0]
        if len(lost):
            return {"held_s": second + 1e-3 * float(lost[0] + (50 if second == 0 else 0)), "force_n": float(np.linalg.norm(first)), "limit_s": seconds}
    return {"held_s": float(seconds), "force_n": float(np.linalg.norm(first)), "limit_s": seconds}


COSTS = {
    "string, pressed and slid along": ("single_string", [(0.0, 0.0153 - 1e-4 * k, 1e-4) for k in range(125)] +
                                       [(1e-4 * k, 0.0029, 1e-4) for k in range(400)]),
    "ball, slid round": ("sphere", [(0.0, 0.07 - 1e-4 * k, 0.0) for k in range(160)] + [(1e-4 * k, 0.054, 0.0) for k in range(100)]),
    "wall, pressed": ("wall", [(0.0, 0.0, 0.025 - 1e-4 * k) for k in range(220)] + [(1e-5 * k, 0.0, 0.0031) for k in range(200)]),
    "Guqin, a hand on its strings": ("guqin", [(0.44, 0.0295 - 1e-4 * k, 0.0) for k in range(150)] + [(0.44 + 5e-5 * k, 0.0146, 0.0) for k in range(150)]),
    "hundred strings, swept": ("strings_100", [(0.0, 0.1 - 5e-4 * k, 0.0) for k in range(180)] + [(0.0, 0.01, 2e-4 * k) for k in range(100)]),
}


def cost(program, what):
    """Mean instructions of a tick, by callgrind around the loop's tick, for the way in and what follows."""
    import hapticd
    scene, rows = COSTS[what]
    with tempfile.NamedTemporaryFile("r", suffix=".log") as log:
        with open(log.name, "w", encoding="utf-8") as out:
            process = subprocess.Popen(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                                        "--toggle-collect=hapticd::HapticLoop::tick_once(*", program, "--listen", "127.0.0.1:0", "--clock",
                                        "virtual", "--device", "scripted", "--scene", scene], stdout=out, stderr=subprocess.STDOUT,
                                       env=dict(os.environ, XDG_STATE_HOME="/nonexistent"))
        try:
            address = None
            for _ in range(1200):
                said = re.search(r"listening on (\S+): ", pathlib.Path(log.name).read_text(encoding="utf-8"))
                if said:
                    address = said.group(1)
                    break
                process.poll()
                if process.returncode is not None:
                    return None
                time.sleep(0.1)
            with hapticd.Session(address) as session:
                session.acquire("cost")
                session.run(poses=rows)
            process.send_signal(signal.SIGTERM)
            process.wait(120)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
        text = pathlib.Path(log.name).read_text(encoding="utf-8")
    collected = re.search(r"Collected : (\d+)", text)
    return int(collected.group(1)) / len(rows) if collected else None
