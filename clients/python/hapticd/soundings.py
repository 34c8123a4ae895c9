"""What strings sound like, from the events StringSounding and, for who came later, from the States that repeat them: the newest message of
each string, by its number. A message is right for its own instant; `sounding_at` carries it on. Units as in event.proto."""
from __future__ import annotations

import math
from typing import Dict, Mapping, Optional

from hapticd.v1 import answer_pb2, event_pb2, state_pb2

GLIDE_S = 0.1
"""A pitch glides on for so long after it was told, and then stays."""
MOST_STRINGS = 1024
MOST_PARTIALS = 12


def is_sound(sounding: event_pb2.StringSounding) -> bool:
    """Whether every number is one that event.proto lets a string have."""
    partials, decays_s = sounding.partials_m, sounding.decays_s
    return (sounding.string_index < MOST_STRINGS and abs(sounding.cents_per_s) <= 1e5
            and (0 < sounding.frequency_hz <= 2e4 or not partials and 0 <= sounding.frequency_hz <= 2e4)
            and len(partials) == len(decays_s) <= MOST_PARTIALS and all(0 <= partial <= 1 for partial in partials)
            and all(0 < decay <= 1000 for decay in decays_s))


def sounding_at(sounding: event_pb2.StringSounding, t_ns: int) -> event_pb2.StringSounding:
    """The same string at t_ns of the server's clock if nobody has told anything since: pitch and amplitudes of then. Before its own
    instant, and where its numbers are none that a string can have, it is as told."""
    now = event_pb2.StringSounding()
    now.CopyFrom(sounding)
    since_s = (t_ns - sounding.t_ns) * 1e-9
    if since_s <= 0 or not is_sound(sounding):
        return now
    now.t_ns = t_ns
    now.frequency_hz = sounding.frequency_hz * 2 ** (sounding.cents_per_s * min(since_s, GLIDE_S) / 1200)
    if since_s >= GLIDE_S:
        now.cents_per_s = 0
    now.partials_m[:] = [partial * math.exp(-since_s / decay) for partial, decay in zip(sounding.partials_m, sounding.decays_s)]
    now.ClearField("phases_rad")
    return now


class Soundings:
    """Of one session. `by_string` is replaced, not changed, so that another thread may read it at any time."""

    def __init__(self) -> None:
        self.by_string: Mapping[int, event_pb2.StringSounding] = {}
        self._scene_id = 0
        self._newest: Dict[int, event_pb2.StringSounding] = {}  # silent ones too: their numbers count

    def begin(self, scene: answer_pb2.SceneInfo) -> None:
        """Another scene: its strings number their messages anew."""
        self._scene_id = scene.scene_id
        self._newest, self.by_string = {}, {}

    def take(self, sounding: event_pb2.StringSounding) -> None:
        """A message. One that is not newer than what is known changes nothing, nor does one that no string can be meant by."""
        if not is_sound(sounding):
            return
        known: Optional[event_pb2.StringSounding] = self._newest.get(sounding.string_index)
        if known is not None and not 0 < (sounding.number - known.number) % 2**32 < 2**31:
            return
        self._newest[sounding.string_index] = sounding
        self.by_string = {index: each for index, each in self._newest.items() if each.partials_m}

    def take_state(self, state: state_pb2.State) -> None:
        """What a State repeats, if it is one of the scene that was begun."""
        if state.scene_id != self._scene_id:
            return
        for string in state.strings:
            if string.HasField("sounding"):
                self.take(string.sounding)
