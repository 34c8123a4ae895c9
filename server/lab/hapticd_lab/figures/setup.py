"""F14: the player's device, and that the test of stability can fail."""
from __future__ import annotations

from hapticd.v1 import device_profile_pb2, scene_pb2
from hapticd_lab import stability
from hapticd_lab.figure import OURS, Figure, Spec, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.player import Hand, Setup

SCENE = "guqin"
GESTURE = "slide_on_body"
DELAY_S = 0.002
PERIOD_S = 0.001
HAND_DAMPING = 10.0
"""Of the light arm, N s/m: what holds the device beside its own damping, which the control's device does not have."""
TOO_STIFF = 4.0

def _promise(stiffness: float, profile: device_profile_pb2.DeviceProfile) -> None:
    """A device without damping or friction, whose maker promises so much that the clamp grants `stiffness`."""
    for field, value in (("delay_s", DELAY_S), ("damping_n_s_per_m", 0.0), ("rotational_damping_n_m_s_per_rad", 0.0), ("coulomb_friction_n", 0.0),
                         ("coulomb_friction_n_m", 0.0), ("stiffness_max_n_per_m", 2.0 * stiffness)):
        quantity = getattr(profile, field)
        quantity.value[:] = [value]
        quantity.source = "set by hapticd-lab"

def _play(lab: Lab, stiffness: float) -> stability.Stability:
    def coupling(scene: scene_pb2.Scene) -> None:
        scene.tools[0].coupling.kt_n_per_m = stiffness

    profile = lab.profile(f"promises_{stiffness:.0f}", lambda profile: _promise(stiffness, profile))
    return stability.measure(lab.play_hand(Setup(SCENE, "PAPER", coupling), lab.gesture(GESTURE), Hand("LIGHT", profile)), 0.0)

def f14(lab: Lab, figure: Figure) -> None:
    """A simulated hand on a simulated Phantom Premium 3.0, and one on a device that is too stiff for it."""
    clamp = 0.5 * HAND_DAMPING / (PERIOD_S / 2.0 + DELAY_S)
    figure.tables["A light hand on a device without damping, 2 ms late"] = table = [
        ["stiffness, N/m", "of the clamp's", "lasting vibration at rest, mN", "energy taken out in, ticks", "stable"]]
    found = {factor: _play(lab, factor * clamp) for factor in (0.25, 1.0, TOO_STIFF)}
    for factor, each in found.items():
        table.append([f"{factor * clamp:.0f}", f"{factor:g}", f"{each.resting_n * 1e3:.2f}", str(each.limited), "yes" if each.stable else "no"])
    figure.claims.append(is_so("At the stiffness clamp a hand and the body are stable together", found[1.0].stable and found[0.25].stable,
                               "yes" if found[1.0].stable and found[0.25].stable else "no", "yes"))
    figure.claims.append(is_so("Control: at four times the clamp the same test fails", not found[TOO_STIFF].stable,
                               "it fails" if not found[TOO_STIFF].stable else "it passes", "it fails",
                               "the clamp reckoned with the hand's damping, 10 N s/m; with hands off it is a tenth of that, which hapticd grants", OURS))
    gesture = lab.gesture(GESTURE)
    figure.runs["simulated Phantom Premium 3.0, light hand"] = lab.play_hand(Setup(SCENE, "PAPER"), gesture, Hand())
    figure.notes.append("The paper's player holds a Phantom Premium 3.0 6DoF. hapticd's simulated device has its data sheet's numbers (those that the "
                        "sheet lacks are marked as guesses in deploy/devices), held by an arm of mass, spring, damper and tremor.")

SPECS = [Spec("F14", "The player's device", "a player holds a Phantom Premium 3.0 6DoF; the interaction is stable", f14, 15.0)]
