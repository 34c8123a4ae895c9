"""What the model server serves: one tool over one string, no haptics, plausible numbers. Time, scene, loop state, parameters and poses;
nothing of the network. Deterministic, so that lockstep can be checked with it."""
import hashlib
import time

from google.protobuf import text_format

from schema import config, state

PERIOD_NS = 1_000_000
TEXT = 'name: "{}" tools {{ name: "finger" parts {{ name: "tip" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: 0.005 }} }} }} }}'
SCENES = {"single_string": TEXT.format("single_string"), "wall": TEXT.format("wall")}
LIVE = {"strings[0].tension_n": (0.0, 1e6), "tools[0].coupling.kt_n_per_m": (1e-3, 1e9)}
QUEUE = 4096


class World:
    """`virtual`: time stands still until it is run."""

    def __init__(self, virtual):
        self.virtual = virtual
        self.clock = config.CLOCK_MODE_VIRTUAL if virtual else config.CLOCK_MODE_REALTIME
        self.parameters = {path: 30.0 for path in LIVE}
        self.scene_id = 0
        self.live = not virtual
        self.cause = 0
        self.load(SCENES["single_string"])

    def load(self, text):
        """text_format.ParseError if the text is no scene."""
        from hapticd.v1 import scene_pb2
        scene = text_format.Parse(text, scene_pb2.Scene())
        if not scene.name or not scene.tools:
            raise text_format.ParseError("name and tools are required")
        scene.preset = scene.preset or scene_pb2.PRESET_DEFLECTING
        scene.tools[0].workspace.scale = 1
        self.scene, self.scene_id = scene, self.scene_id + 1
        self.tick, self.hash, self.queued, self.last_tick = 0, bytes(32), {}, -1
        self.pose, self.began_ns = (0.0, 0.01, 0.0), time.monotonic_ns()
        self.loop_state, self.cause = state.LOOP_STATE_ENGAGED, 0
        self.newest = self._state()

    def queue(self, batch):
        """False if the queue is full."""
        first = batch.first_tick if batch.HasField("first_tick") else max(self.last_tick + 1, self.tick)
        if first + len(batch.poses) > self.tick + QUEUE:
            return False
        for tick, sample in enumerate(batch.poses, first):
            if tick >= self.tick:
                self.queued[tick] = tuple(sample.pose_dh.p_m)
                self.last_tick = max(self.last_tick, tick)
        return True

    def step(self):
        """One tick; returns whether its pose was missing."""
        held = self.tick not in self.queued
        self.pose = self.queued.pop(self.tick, self.pose)
        self.newest = self._state()
        if self.virtual:
            self.hash = hashlib.blake2b(self.hash + canonical(self.newest), digest_size=32).digest()
        self.tick += 1
        return held

    def due_ticks(self):
        """Ticks that a running clock has to make up for; a late one is skipped beyond 100."""
        if not self.live:
            return 0
        return min(100, (time.monotonic_ns() - self.began_ns) // PERIOD_NS - self.tick)

    def _state(self):
        made = state.State(tick=self.tick, t_ns=self.tick * PERIOD_NS + (0 if self.virtual else self.began_ns), loop_state=self.loop_state,
                           cause=self.cause, scene_id=self.scene_id)
        depth = max(0.0, -self.pose[1])
        on = self.loop_state == state.LOOP_STATE_ENGAGED
        tool = made.tools.add(p_wh_m=self.pose, q_wh=(1, 0, 0, 0), q_wg=(1, 0, 0, 0), minimum_gap_m=max(self.pose[1], 2e-5))
        tool.p_wg_m.extend((self.pose[0], max(self.pose[1], 0.0), self.pose[2]))
        tool.wrench_h_w.extend((0, 1000 * depth * on, 0, 0, 0, 0))
        made.devices.add(p_dh_m=self.pose, q_dh=(1, 0, 0, 0))
        made.timing.last_ns = time.monotonic_ns() % 1000
        made.timing.stages.add(stage=state.STAGE_READ)
        made.energy.strings_j = 500 * depth * depth
        made.quality.level = 3
        made.stiffness.add(scale=1, bound_n_per_m=1000)
        if depth > 0:
            made.strings.add(phase=state.STRING_PHASE_PRESSED, radius_m=depth)
            for number in range(3):
                made.contacts.add(body_index=number, force_w_n=(0, 1, 0), tool_sphere=[number], p_wc_um=[0, 0, number],
                                  nhat_og_w_e4=[0, 10000, 0], gap_nanometres=[20000 * number], force_mn=[1000])
        return made


def canonical(full):
    """The bytes that the state hash chains."""
    made = state.State()
    made.CopyFrom(full)
    for field in ("timing", "scene_id", "contacts_total", "strings_total", "part_index", "part_count"):
        made.ClearField(field)
    return made.SerializeToString()


def section(full, subscription):
    """The State as subscribed."""
    names = {1: "tools", 2: "devices", 3: "strings", 4: "contacts", 5: "timing", 6: "timing", 7: "energy", 8: "quality", 9: "stiffness"}
    wanted = list(subscription.sections) or [1, 3, 4]
    made = state.State()
    made.CopyFrom(full)
    for number, name in names.items():
        if name not in {names.get(each) for each in wanted}:
            made.ClearField(name)
    if 6 not in wanted and made.HasField("timing"):
        made.timing.ClearField("stages")
    most = subscription.max_contacts if subscription.HasField("max_contacts") else 16
    if len(made.contacts) > most:
        made.contacts_total = len(made.contacts)
        del made.contacts[most:]
    return made
