#!/usr/bin/python3
"""Five minutes with hapticd: steps a lockstep session of the scene single_string, drags a finger over the string, and writes what was felt
to pluck.csv; with matplotlib also a picture, pluck.png. Start the daemon first, in another terminal:

    hapticd --clock virtual --device scripted --scene single_string

usage: pluck.py [HOST:PORT] [FOLDER]"""
import os
import sys

import hapticd

TICKS_PER_METRE = 5000  # 1 kHz and 0.2 m/s
# Above the string, to its side, down until the finger would overlap the string by 1.3 mm, across it, and up again.
CORNERS = [(0, 0.0153, 0), (0, 0.0153, -0.012), (0, 0.004, -0.012), (0, 0.004, 0.012), (0, 0.0153, 0.012)]


def path():
    """Positions p_DH of the handle, one per tick, along the corners at constant speed."""
    for begin, end in zip(CORNERS, CORNERS[1:]):
        length = sum((b - a) ** 2 for a, b in zip(begin, end)) ** 0.5
        ticks = round(length * TICKS_PER_METRE)
        for tick in range(ticks):
            yield [a + (b - a) * tick / ticks for a, b in zip(begin, end)]
    yield CORNERS[-1]


def pluck(session):
    """Plays the path; returns the table of all States, and the tones."""
    session.acquire("pluck.py")
    session.load_scene("single_string")
    session.subscribe(divisor=1, sections=["TOOLS", "STRINGS"])
    result = session.run(poses=list(path()))
    print(f"{result.steps} ticks, state hash {result.state_hash.hex()[:16]}")
    tones = [event.body for event in result.events if event.kind == "tone"]
    return result.table(), tones


def main():
    address = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:47800"
    folder = sys.argv[2] if len(sys.argv) > 2 else "."
    with hapticd.Session(address) as session:
        table, tones = pluck(session)
    force_n = [sum(each**2 for each in wrench[:3]) ** 0.5 for wrench in table["wrench_h_w"]]
    for tone in tones:
        print(f"string {tone.string_index} sounds at {tone.frequency_hz:.1f} Hz, level {tone.level:.2f}, after {tone.t_ns * 1e-6:.3f} ms")
    print(f"largest force {max(force_n):.3f} N; the tool entered the string nowhere: smallest gap {min(table['minimum_gap_m']) * 1e6:.1f} um")

    table.to_csv(os.path.join(folder, "pluck.csv"))
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        print("wrote pluck.csv; with python3-matplotlib there would be a picture too")
        return
    pyplot.plot(table["t_s"], force_n)
    pyplot.xlabel("time, s")
    pyplot.ylabel("force on the hand, N")
    pyplot.savefig(os.path.join(folder, "pluck.png"))
    print("wrote pluck.csv and pluck.png")


if __name__ == "__main__":
    main()
