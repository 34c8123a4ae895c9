"""libhapticd-client as a user has it: both of its components installed into a folder; and what the same touch is for the Python client,
which shares no code with it."""
import os
import pathlib
import subprocess

import daemon
import hapticd

SOURCE = pathlib.Path(__file__).resolve().parents[3]
EXAMPLES = SOURCE / "clients" / "examples"
COMPONENTS = ("libhapticd-client0", "libhapticd-client-dev")
SCRIPTED = ("--clock", "virtual", "--device", "scripted", "--scene", "single_string")


def checked(*command, **options):
    """What a command prints; fails with all that it wrote."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=240, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def install(prefix):
    """Installs both components; returns the folder of the libraries."""
    for component in COMPONENTS:
        checked(os.environ["CMAKE"], "--install", os.environ["HAPTICD_BUILD"], "--component", component, "--prefix", str(prefix))
    return next(prefix.rglob("libhapticd-client.so.0")).parent


def path():
    """Poses of the examples called press: beside the string, down, across it, which plucks it, and up again."""
    for tick in range(600):
        s = tick / 599
        yield [0.0, 0.0153 - 0.0113 * min(1.0, 4.0 * min(s, 1.0 - s)), -0.012 + 0.024 * min(1.0, max(0.0, 2.0 * s - 0.5))]


def check_press(test, *program, **options):
    """A program called press, in whatever language, says what the Python client finds when it plays the same poses."""
    with daemon.Daemon(*SCRIPTED) as played:
        printed = checked(*program, played.address, **options)
    with daemon.Daemon(*SCRIPTED) as played, hapticd.Session(played.address) as session:
        session.acquire("test")
        session.load_scene("single_string")
        session.subscribe(divisor=1)
        result = session.run(poses=list(path()))
        tones = [event.body for event in session.events(timeout=0) if event.kind == "tone"]
    largest = max(sum(float(f) ** 2 for f in state.tools[0].wrench_h_w[:3]) ** 0.5 for state in result.states)
    test.assertGreater(largest, 0.05)
    test.assertGreater(len(tones), 0)
    expected = [f"string {tone.string_index} sounds at {tone.frequency_hz:.2f} Hz after {tone.t_ns * 1e-6:.3f} ms" for tone in tones]
    expected.append(f"600 ticks, largest force {largest:.4f} N, state hash {result.state_hash.hex()}")
    test.assertEqual(printed.splitlines(), expected)
