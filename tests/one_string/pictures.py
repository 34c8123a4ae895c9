"""The pictures of the page, for people who play. Colours are those of Okabe and Ito, which colour-blind eyes tell apart; lines differ in their
strokes too."""
import io

import matplotlib
import numpy as np
from PIL import Image

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

COLOURS = 160
BLUE, RED, GREEN, ORANGE, SKY, GREY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#777777"
plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e4e4e4",
                     "grid.linewidth": 0.6, "legend.frameon": False, "figure.dpi": 90, "axes.titlesize": 11, "axes.titlelocation": "left"})


def page(rows=1, columns=1, size=(8.0, 4.2)):
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False, constrained_layout=True)
    return figure, list(axes.flat)


def save(figure, path):
    """In few colours, which halves the file, and without anything that differs from run to run."""
    data = io.BytesIO()
    figure.savefig(data, format="png", metadata={"Software": None})
    plt.close(figure)
    Image.open(data).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def draw_sound(axis, sound):
    """`sound`: least and most of blocks, {"begins_s", "block_s", "least", "most"}"""
    t = sound["begins_s"] + sound["block_s"] * np.arange(len(sound["least"]))
    axis.fill_between(t, sound["least"], sound["most"], color=BLUE, linewidth=0)


def loudness(found, path):
    figure, axes = page(1, 2)
    for axis, hz, title in zip(axes, (65.4, 146.8), ("Low string (C2, 65.4 Hz)", "High string (D3, 146.8 Hz)")):
        for place, colour, dash, mark in ((0.1, BLUE, "-", "o"), (0.25, RED, "--", "s"), (0.5, GREEN, ":", "^")):
            rows = [row for row in found["rows"] if row["hz"] == hz and row["place"] == place and row["tones"] == 1]
            axis.plot([row["speed"] for row in rows], [row["mode_mm"] for row in rows], dash, color=colour, label=f"plucked at {place:g} of the length")
            axis.plot([row["speed"] for row in rows], [row["tone_mm"] for row in rows], dash, color=colour, linewidth=0.9, alpha=0.6)
            known = [row for row in rows if row["truth_mm"]]
            axis.plot([row["speed"] for row in known], [row["truth_mm"] for row in known], mark, color=colour, fillstyle="none", markersize=6)
        axis.set(title=title, xlabel="speed of the finger, m/s", ylim=(0, 5.0))
    axes[0].set_ylabel("swing, mm")
    axes[1].plot([], [], color=GREY, linewidth=1.8, label="fundamental")
    axes[1].plot([], [], color=GREY, linewidth=0.9, alpha=0.6, label="all partials together: the Tone")
    axes[1].legend(loc="lower right", fontsize=8.5)
    axes[0].plot([], [], "o", color=GREY, fillstyle="none", label="fundamental, independently computed")
    axes[0].legend(loc="lower right", fontsize=8.5)
    figure.suptitle("How loud is a pluck? Lines: hapticd. Open marks: finite differences", fontsize=11)
    save(figure, path)


def glide(found, path):
    figure, axes = page()
    axis = axes[0]
    for name, colour in (("glide up", BLUE), ("glide down", RED)):
        of = found[name]["0"]
        axis.plot(1e-3 * np.arange(len(of["due"])), of["due"], color="black", linewidth=0.9)
        axis.plot(1e-3 * np.arange(len(of["told"])), of["told"], "--", color=colour, linewidth=2.4, alpha=0.8, label=f"{name}: told by hapticd")
        axis.plot(1e-3 * np.array(of["heard_ms"])[::2], of["heard"][::2], "o", color=colour, markersize=4, fillstyle="none", label=f"{name}: heard in the sound")
    axis.plot([], [], color="black", linewidth=0.9, label="pitch of the part beyond the finger, f / (1 - place)")
    axis.set(title="A finger that stops the string glides 80 mm in 0.6 s, up and down", xlabel="seconds", ylabel="pitch, Hz")
    semitones(axis, found["glide up"]["0"]["due"][0])
    axis.legend(fontsize=8.5, loc="center right")
    save(figure, path)


def semitones(axis, base_hz):
    """A second scale in semitones from `base_hz`."""
    right = axis.secondary_yaxis("right", functions=(lambda hz: 12 * np.log2(np.maximum(hz, 1.0) / base_hz), lambda n: base_hz * 2 ** (n / 12)))
    right.set_ylabel("semitones from where it began")


def vibrato(found, path):
    figure, axes = page(2, 1, (8.0, 4.8))
    of = found["vibrato"]["0"]
    t = 1e-3 * np.arange(len(of["due"]))
    heard_t = 1e-3 * np.array(of["heard_ms"])
    axes[0].plot(t, of["due"], color="black", linewidth=0.9, label="pitch of the part beyond the finger")
    axes[0].plot(t, of["told"], "--", color=BLUE, linewidth=2.4, alpha=0.8, label="told by hapticd")
    axes[0].plot(heard_t[::2], of["heard"][::2], "o", color=RED, markersize=4, fillstyle="none", label="heard in the sound")
    axes[0].set(title="Vibrato: the finger rocks 6 mm to each side, five times a second", ylabel="pitch, Hz", ylim=(107.0, 112.6))
    axes[0].legend(fontsize=8.5, ncol=3, loc="upper center")
    due = np.array(of["due"])
    axes[1].plot(t, 1200 * np.log2(np.array(of["told"]) / due), "-", color=BLUE, linewidth=0.9)
    axes[1].plot(heard_t, 1200 * np.log2(np.array(of["heard"]) / due[of["heard_ms"]]), "o-", color=RED, markersize=3, fillstyle="none", linewidth=0.8)
    axes[1].axhspan(-5, 5, color="#eeeeee")
    axes[1].set(xlabel="seconds", ylabel="out of tune by, cents", ylim=(-12, 12), title="What is left between them. Grey: 5 cents, about as little as an ear notices")
    save(figure, path)


def harmonics(found, path):
    figure, axes = page(2, 2, (8.0, 5.6))
    names = {2: "one half", 3: "one third", 4: "one quarter", 5: "one fifth"}
    for axis, part in zip(axes, (2, 3, 4, 5)):
        of = next(each for each in found if each["part"] == part and each["force"] > 0.02)
        axis.plot(of["hz"], of["db"], color=SKY, linewidth=1.0)
        n = np.arange(1, len(of["told"]) + 1)
        told = 20 * np.log10(np.maximum(of["told"], 1e-12) / max(of["told"]))
        kept = told > -50
        axis.vlines(65.4 * n[kept], -60, told[kept], color=RED, linewidth=2.2)
        axis.plot(65.4 * n[kept], told[kept], "o", color=RED, markersize=4)
        for k in range(part, 13, part):
            axis.annotate("", (65.4 * k, 3), (65.4 * k, 9), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 0.8})
        axis.set(title=f"Touched at {names[part]}", xlim=(0, 800), ylim=(-60, 10))
    for axis in axes[2:]:
        axis.set_xlabel("Hz")
    for axis in axes[::2]:
        axis.set_ylabel("dB below the loudest")
    axes[0].plot([], [], "o-", color=RED, markersize=4, label="told by hapticd")
    axes[0].plot([], [], color=SKY, label="sound of haptic-audio")
    axes[0].legend(fontsize=8.5, loc="upper right", bbox_to_anchor=(1.0, 0.93), facecolor="white", framealpha=1.0, frameon=True, edgecolor="none")
    figure.suptitle("Harmonics: a node touched lightly (25 mN), plucked, lifted. Arrows: partials of the harmonic", fontsize=11)
    save(figure, path)


def ringing(found, path):
    figure, axes = page(1, 2)
    draw_sound(axes[0], found["sound"])
    axes[0].set(title="A silk string, plucked: its sound", xlabel="seconds", ylabel="sound pressure, of full scale")
    heard = np.array(found["heard"])
    for k, (colour, dash) in enumerate(((BLUE, "-"), (RED, "--"), (GREEN, "-."), (ORANGE, ":"))):
        axes[1].plot(found["times"], 20 * np.log10(heard[k] / heard[0, 0]), dash, color=colour, label=("fundamental", "2nd partial", "3rd", "4th")[k])
        due = 20 * np.log10(heard[k, 0] / heard[0, 0]) - 8.686 * (np.array(found["times"]) - found["times"][0]) / found["decays"][k]["told_s"]
        axes[1].plot(found["times"][::4], due[::4], "o", color=colour, fillstyle="none", markersize=4)
    axes[1].plot([], [], "o", color=GREY, fillstyle="none", label="as hapticd tells it to decay")
    axes[1].set(title="Its partials die away", xlabel="seconds", ylabel="dB below the fundamental at its onset")
    axes[1].set(ylim=(-25, 9), yticks=range(-25, 1, 5))
    axes[1].legend(fontsize=8, ncol=2, loc="upper right", borderaxespad=0.0)
    save(figure, path)


def felt(found, path):
    figure, axes = page(2, 1, (8.0, 5.2))
    for axis, depth, words in ((axes[0], 0.3, "Light touch: the finger stays 0.3 mm below where it meets the string at rest"),
                               (axes[1], 3.0, "Firm touch: 3 mm below")):
        of = next(each for each in found if each["depth_mm"] == depth)
        t = np.arange(len(of["force"])) - 20
        axis.axvspan(0, 100, color="#f0f0f0")
        axis.plot(t, 1e3 * np.array(of["force"]), color=BLUE, linewidth=1.0, label="the string rings")
        axis.plot(t, 1e3 * np.array(of["rest"]), "--", color=RED, label="the same string at rest")
        axis.set(title=words, ylabel="force on the finger, mN", xlim=(-20, 300))
    axes[0].legend(fontsize=8.5, loc="upper right")
    axes[1].set_xlabel("milliseconds since the first touch; grey: the first 100")
    save(figure, path)


def shape(found, path):
    figure, axes = page()
    axis, x = axes[0], np.linspace(0, 1, 400)
    bent = [each for each in found["held"] if each["y"] < 0]
    deepest = min(range(len(bent)), key=lambda k: bent[k]["y"])
    for k, colour in zip((max(0, deepest - 3), max(0, deepest - 2), deepest), ("#bbbbbb", "#888888", "black")):
        each = bent[k]
        axis.plot([0, 1.1 * each["place"], 1.1], [0, 1e3 * each["y"], 0], color=colour, linewidth=1.6,
                  label=f"{-each['ms']:.1f} ms before the finger is off")
    for ms, colour, dash in ((found["told_ms"], BLUE, "-"), (4.0, RED, "--"), (7.0, GREEN, "-."), (10.0, ORANGE, ":")):
        u = sum(a * np.sin(n * np.pi * x) * np.cos(phase + 2e-3 * np.pi * n * found["hz"] * (ms - found["told_ms"]))
                for n, (a, phase) in enumerate(zip(found["partials_mm"], found["phases"]), 1))
        axis.plot(1.1 * x, u, dash, color=colour, linewidth=1.8, label=f"{ms:.1f} ms after")
    axis.axvline(1.1 * found["place"], color=GREY, linewidth=0.8, linestyle=":")
    axis.annotate("finger", (1.1 * found["place"] + 0.01, 3.0), fontsize=9, color=GREY)
    axis.set(title="A pluck at a quarter of the string: bent by the finger (grey to black), then free (colours)",
             xlabel="place along the string, m", ylabel="displacement, mm", ylim=(-4.4, 3.4))
    axis.legend(fontsize=8.5, ncol=2, loc="lower right", bbox_to_anchor=(1.0, -0.02))
    save(figure, path)


def phrase(found, path):
    figure, axes = page(2, 1, (8.0, 5.2))
    t = np.array(found["times"])
    told, heard = (np.array([np.nan if each is None else each for each in found[name]], float) for name in ("told", "heard"))
    axes[0].plot(t, heard, "o", color=RED, markersize=3.2, fillstyle="none", label="pitch heard in the sound")
    axes[0].plot(t, told, "-", color=BLUE, linewidth=1.6, alpha=0.9, label="pitch told by hapticd")
    axes[0].set_yscale("log")
    ticks = {"C3": 130.8, "F3": 174.6, "A3": 220.0, "C4": 261.6}
    axes[0].set_yticks(list(ticks.values()), list(ticks))
    axes[0].minorticks_off()
    axes[0].set(ylabel="note", ylim=(118, 480), title="A phrase: what the string does, and what is heard")
    for k, (at, word) in enumerate(found["words"]):
        axes[0].axvline(max(at, 0), color=GREY, linewidth=0.7)
        axes[0].annotate(word, (max(at, 0) + 0.03, (465, 400)[k % 2]), fontsize=8, va="top", color="#444444")
    axes[0].legend(fontsize=8.5, loc="lower right")
    draw_sound(axes[1], found["sound"])
    axes[1].set(xlabel="seconds", ylabel="sound")
    axes[1].set_xlim(axes[0].get_xlim())
    save(figure, path)


# In the order of the page.
ALL = {"loudness": (loudness, "loudness"), "glide": (glide, "pitch"), "vibrato": (vibrato, "pitch"), "harmonics": (harmonics, "harmonics"),
       "ringing": (ringing, "ringing"), "felt": (felt, "felt"), "shape": (shape, "shape"), "phrase": (phrase, "phrase")}


def draw(figures, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, (make, part) in ALL.items():
        make(figures[part], folder / f"{name}.png")
