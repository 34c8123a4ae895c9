"""What a check is: a function with a sentence and the section of PROTOCOL.md it comes from. It gets a Server, and raises Failed or Skipped."""
from typing import Callable, NamedTuple

import keyed
from peer import Peer, Skipped, code, expect
from schema import config, control, item, state


class Check(NamedTuple):
    name: str
    section: int
    sentence: str
    run: Callable
    slow: bool
    attempts: int
    road: str


CHECKS = []


def check(section, slow=False, attempts=1, road="both"):
    """Registers a function whose docstring is the rule. `slow`: takes more than 4 s; left out with --quick. `attempts`: a rule of
    milliseconds may be tried so often, since a loaded machine is late now and then; a server that breaks it is late always. `road`: "plain" or "keyed" where the rule is of one
    kind of session only."""
    def register(function):
        CHECKS.append(Check(function.__name__, section, " ".join(function.__doc__.split()), function, slow, attempts, road))
        return function
    return register


class Server:
    """The server under test. Peers opened through it are closed after each check, with Bye if they still live."""

    def __init__(self, address, keys=None):
        self.address = address
        self.keys = keys  # role to key; None: PLAIN
        self.peers = []
        probe = self.peer().open()
        info = probe.of_kind("scene_info")[0]
        self.virtual = info.clock == config.CLOCK_MODE_VIRTUAL
        self.scene = info.scene
        self.rate_hz = info.rate_hz
        probe.bye()
        self.peers = []

    def peer(self, role=keyed.CONTROL):
        """A socket whose session is not open yet."""
        self.peers.append(Peer(self.address) if self.keys is None else Peer(self.address, self.keys[role], role))
        return self.peers[-1]

    def open(self):
        return self.peer().open()

    def holder(self):
        """An open session that holds the lease."""
        peer = self.open()
        for _ in range(60):
            result = peer.request(item("acquire", holder="conformance"))
            if code(result) != "BUSY":
                break
            peer.pump(0.1)  # a session of an earlier check, or somebody else
        expect(code(result) == "OK", f"acquire: {code(result)} {result.message}")
        return peer

    def ticking(self, holder):
        """Lets time run, whatever the clock."""
        if self.virtual:
            holder.demand(item("run", mode=control.RUN_MODE_LIVE))

    def needs_virtual(self):
        if not self.virtual:
            raise Skipped("needs the virtual clock")

    def needs_realtime(self):
        if self.virtual:
            raise Skipped("needs the real clock")

    def reload(self, holder):
        """Loads the scene anew: tick 0. Returns the new scene_id."""
        before = holder.of_kind("scene_info")[-1].scene_id
        holder.demand(item("load_scene", name=self.scene.name), seconds=60)
        expect(holder.pump(10, lambda: holder.of_kind("scene_info")[-1].scene_id != before), "no SceneInfo after LoadScene")
        return holder.of_kind("scene_info")[-1].scene_id

    def clean(self):
        """Leaves the server as a check found it: no fault, time as it was, no session of ours."""
        holder = next((peer for peer in self.peers if peer.alive() and peer.lease()), None)
        if holder is not None:
            holder.lossy = None
            if self.virtual:
                holder.request(item("run", mode=control.RUN_MODE_STOP))
            if holder.states and holder.states[-1][1].loop_state == state.LOOP_STATE_FAULT:
                holder.request(item("clear"))
        for peer in self.peers:
            if peer.alive():
                peer.bye()
            else:
                peer.close()
        self.peers = []
