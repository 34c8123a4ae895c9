"""Checks of sections 2 and 3: what is dropped in silence, how sessions begin, live and end."""
import time

from peer import MAGIC, MAJOR, PLAIN, Peer, expect, header
from registry import check
from schema import control, item, stream

FIRST = stream.Packet(first=1).SerializeToString()
KEEP_ALIVE_S = 0.1
SLACK_S = 0.1
"""A loaded machine may be late by this much; it hides no missing keep-alive."""


def nothing_comes(peer, seconds, why):
    heard = peer.hear(seconds)
    expect(heard is None, f"{why} was answered")


def reset_of(peer, seconds=0.5):
    """The next Reset, or None."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        heard = peer.hear(end - time.monotonic())
        if heard is not None and heard.packet.HasField("reset"):
            return heard
    return None


def expect_forgotten(peer, when):
    """The server does not know the session any more: Reset, or with keys no answer at all."""
    peer.send()
    if peer.keys is not None:
        nothing_comes(peer, 0.3, f"a session that should not exist {when}")
        return
    heard = reset_of(peer)
    expect(heard is not None and heard.packet.reset.reason == stream.RESET_REASON_UNKNOWN_SESSION, f"the session still exists {when}")


@check(2, road="plain")
def broken_headers_are_dropped(server):
    """A datagram with a wrong magic, major, kind, reserved byte or length is dropped in silence."""
    peer = server.peer()
    session = peer.session
    bad = {
        "a wrong magic": header(session, 0, magic=MAGIC ^ 1) + FIRST,
        "another major": header(session, 0, major=MAJOR + 1) + FIRST,
        "a kind of 0": header(session, 0, kind=0) + FIRST,
        "an unknown kind": header(session, 0, kind=6) + FIRST,
        "a HELLO to a server without keys": header(0, 0, kind=1) + bytes(1184),
        "a DATA to a server without keys": header(session, 0, kind=4) + FIRST + bytes(16),
        "a reserved byte": header(session, 0, reserved=1) + FIRST,
        "an empty datagram": b"",
        "15 bytes": header(session, 0)[:15],
        "1201 bytes": header(session, 0) + FIRST + b"\xa2\x7d\x98\x09" + bytes(1179),
    }
    for why, data in bad.items():
        peer.send_raw(data)
        nothing_comes(peer, 0.03, why)
    nothing_comes(peer, 0.2, "one of the broken headers")


@check(2)
def bodies_that_do_not_open_are_dropped(server):
    """A body that is not a Packet, and a Packet with first = 0 or 17 Items, are dropped in silence."""
    peer = server.peer()
    seventeen = stream.Packet(first=1, items=[item("ping")] * 17).SerializeToString()
    for why, body in (("a Packet of 17 Items", seventeen), ("a body that is no Packet", b"\xff\xff\xff"), ("a Packet without first", b""), ("a truncated Packet", b"\x1a\x08\x72")):
        peer.send_body(0, body)
        nothing_comes(peer, 0.15, why)


@check(2)
def a_broken_body_blocks_no_counter(server):
    """A counter is marked only once its datagram has opened."""
    peer = server.open()
    peer.send_body(peer.counter, b"\xff\xff\xff")
    ping = peer.queue(item("ping"))
    peer.send()
    peer.result(ping)


@check(2)
def a_counter_is_taken_once(server):
    """A second datagram with a counter already received is dropped, whatever it contains."""
    peer = server.open()
    peer.demand(item("ping"))
    used = peer.counter - 1
    ping = peer.queue(item("ping"))
    for _ in range(5):
        peer.send(counter=used)
    peer.send(counter=0)
    peer.pump(0.2, acknowledge=False)
    expect(peer.acked < ping, "an Item in a datagram with a used counter was applied")
    peer.send()
    peer.result(ping)


@check(2)
def the_window_is_2048_counters_wide(server):
    """Counters up to 2047 below the largest are taken once in any order; older ones are dropped."""
    peer = server.open()
    peer.send(counter=10_000)
    peer.pump(0.05, acknowledge=False)
    ping = peer.queue(item("ping"))
    peer.send(counter=10_000 - 2048)
    peer.pump(0.15, acknowledge=False)
    expect(peer.acked < ping, "a counter below the window was taken")
    peer.send(counter=10_000 - 2047)
    peer.pump(0.15, acknowledge=False)
    expect(peer.acked >= ping, "the oldest counter of the window was not taken")
    second = peer.queue(item("ping"))
    peer.counter = 10_001
    peer.send(counter=10_000 - 2047)
    peer.pump(0.1, acknowledge=False)
    expect(peer.acked < second, "the oldest counter of the window was taken twice")
    peer.send()
    peer.result(second)


@check(3)
def a_session_begins_with_scene_lease_and_record(server):
    """The first Items are SceneInfo, LeaseInfo and RecordInfo, in this order, and no State is sent before Subscribe."""
    peer = server.open()
    kinds = [each.WhichOneof("body") for _, each in peer.items[:3]]
    expect(kinds == ["scene_info", "lease_info", "record_info"], f"the first Items are {kinds}")
    peer.pump(0.3)
    expect(not peer.states, "a State came before Subscribe")
    info = peer.of_kind("scene_info")[0]
    expect(info.scene_id >= 1 and len(info.hash) == 32 and info.scene.name and info.scene.tools, "SceneInfo is not complete")
    expect(250 <= info.rate_hz <= 10000 and info.clock and info.server_version, "SceneInfo says no rate, clock or version")
    expect(info.scene.preset != 0 and info.scene.tools[0].workspace.HasField("scale"), "SceneInfo's scene lacks its defaults")
    expect(info.quality_in_force.WhichOneof("choice") in ("level", "automatic"), "SceneInfo does not say the quality in force")
    expect(info.solver_in_force.max_substeps and info.solver_in_force.stop_step_m, "SceneInfo does not say the solver's knobs in force")


@check(3)
def the_servers_counters_and_numbers_are_right(server):
    """Datagrams of the server carry the session's number and its kind; their counter starts at 0 and grows by 1."""
    peer = server.open()
    peer.pump(0.5)
    expect(all(heard.session == peer.session for heard in peer.heard), "another session's number")
    counters = [heard.counter for heard in peer.heard]
    expect(sorted(counters) == list(range(len(counters))), f"counters {counters[:20]}")


@check(3, road="plain")
def an_unknown_session_gets_a_reset(server):
    """A datagram of an unknown session with first above 1, or ack above 0, gets a Reset UNKNOWN_SESSION with counter 0 and its number."""
    for fields in ({"first": 2}, {"first": 1, "ack": 1}, {"first": 7, "ack": 3}):
        peer = server.peer()
        time.sleep(0.12)
        peer.send(**fields)
        heard = reset_of(peer)
        expect(heard is not None, f"{fields}: no Reset")
        expect(heard.packet.reset.reason == stream.RESET_REASON_UNKNOWN_SESSION, f"reason {heard.packet.reset.reason}")
        expect(heard.counter == 0 and heard.session == peer.session and heard.packet.boot_id != 0, "the Reset's counter, session or boot_id")
        expect(not heard.packet.items and not heard.packet.HasField("state"), "a Reset with Items or a State")


@check(3, attempts=3, road="plain")
def resets_are_limited_to_one_per_100_ms(server):
    """An address gets at most one Reset per 100 ms."""
    peer = server.peer()
    time.sleep(0.12)
    begin, resets = time.monotonic(), []
    while time.monotonic() - begin < 0.55:
        peer.send(first=2)
        heard = peer.hear(0.01)
        if heard is not None and heard.packet.HasField("reset"):
            resets.append(heard.at)
    expect(2 <= len(resets) <= 6, f"{len(resets)} Resets in 550 ms")


@check(3)
def a_late_first_datagram_still_opens(server):
    """first = 1 and ack = 0 open a session whatever the counter: the first datagram may be lost."""
    peer = server.peer()
    peer.counter = 3
    peer.open()


@check(3, road="plain")
def sessions_are_told_apart_by_number_and_address(server):
    """Two numbers of one address are two sessions, and so is one number of two addresses."""
    first, second = server.open(), server.peer()
    second.session = first.session
    second.open()
    first.demand(item("ping"))
    second.demand(item("ping"))
    third = server.peer()
    third.socket.close()
    third.socket = first.socket
    third.open()
    expect(len(third.of_kind("scene_info")) == 1, "no SceneInfo of its own")
    third.bye()


@check(3)
def the_boot_id_is_one_for_all(server):
    """Every session sees the same boot_id, not 0."""
    first, second = server.open(), server.open()
    expect(first.boot_id == second.boot_id != 0, f"boot_id {first.boot_id} and {second.boot_id}")


@check(3, attempts=3)
def the_server_keeps_sessions_alive(server):
    """A Packet comes at least every 100 ms while nothing happens."""
    peer = server.open()
    peer.pump(0.3)
    begin = len(peer.heard)
    peer.pump(1.0)
    instants = [heard.at for heard in peer.heard[begin:]]
    gaps = [b - a for a, b in zip(instants, instants[1:])]
    expect(len(instants) >= 8, f"{len(instants)} datagrams in a second")
    expect(max(gaps) <= KEEP_ALIVE_S + SLACK_S, f"a gap of {max(gaps) * 1e3:.0f} ms")


@check(3)
def bye_is_acknowledged_and_forgets(server):
    """A client's Bye is acknowledged, gets no Result, and the session is forgotten 1 s later."""
    peer = server.open()
    bye = peer.queue(item("bye", reason=control.BYE_REASON_DONE))
    peer.send()
    expect(peer.pump(0.5, lambda: peer.acked >= bye), "Bye was not acknowledged")
    peer.pump(0.2)
    expect(bye not in peer.results, "Bye got a Result")
    time.sleep(1.3)
    while peer.hear(0.01):
        pass
    expect_forgotten(peer, "after Bye")


@check(3, slow=True)
def silence_slows_and_then_ends_a_session(server):
    """After 3 s without a datagram of the client its States come once per 100 ms; after 10 s the session is dropped."""
    holder = server.holder()
    server.ticking(holder)
    quiet = server.open()
    quiet.demand(item("subscribe", divisor=5))
    begin = time.monotonic()
    while time.monotonic() - begin < 11.5:
        holder.pump(0.05)
        quiet.pump(0.05, acknowledge=False)
        if holder.states:
            holder.states.clear()
    rates = [sum(1 for heard, _ in quiet.states if a <= heard.at - begin < a + 1) for a in range(11)]
    expect(rates[1] > 50, f"{rates[1]} States in the second second: too few to see anything")
    expect(5 <= rates[5] <= 15, f"{rates[5]} States a second after 5 s of silence")
    expect([bye.reason for bye in quiet.of_kind("bye")] == [control.BYE_REASON_SILENCE], "not one Bye SILENCE")
    expect(rates[10] <= 2, f"{rates[10]} States after 10 s of silence")
    expect_forgotten(quiet, "after 10 s of silence")


@check(3)
def the_33rd_session_is_refused(server):
    """With 32 sessions open that have asked for control the next one gets Reset FULL; one that ends makes room."""
    peers = []
    refused = None
    for _ in range(33):
        peer = server.peer()
        peer.send()
        peer.pump(1.0, lambda: peer.heard)
        expect(peer.heard, "no answer to a first datagram")
        if peer.heard[0].packet.HasField("reset"):
            refused = peer
            break
        peer.request(item("acquire", holder="conformance"))
        peers.append(peer)
        for each in peers:
            each.pump(0.002)
    expect(refused is not None, "33 sessions are open")
    expect(refused.heard[0].packet.reset.reason == stream.RESET_REASON_FULL, "the Reset does not say FULL")
    expect(peers[0].alive() and peers[0].request(item("ping")).code == 1, "an open session suffered")
    for each in peers[:3]:
        each.bye()
    time.sleep(1.2)
    for each in peers[3:]:
        each.pump(0.005)
    server.open()


@check(3, road="plain")
def who_never_asked_for_control_gives_way(server):
    """Of sessions that have never asked for control 24 keep their places; where 32 are open the first one beyond them gives way."""
    time.sleep(1.2)  # sessions of an earlier check are forgotten
    lookers = [server.open() for _ in range(32)]
    for each in lookers:
        each.pump(0.002)
    late = server.open()
    expect(late.request(item("ping")).code == 1, "the 33rd session is not served")
    gone = []
    for index, each in enumerate(lookers):
        each.pump(0.05)
        if any(heard.packet.HasField("reset") for heard in each.heard):
            gone.append(index)
    expect(gone == [24], f"sessions {gone} gave way, and not the 25th alone")


@check(3, road="plain")
def a_session_of_number_0_does_not_exist(server):
    """0 is no session's number."""
    peer = Peer(server.address)
    peer.session = 0
    peer.send_raw(header(0, 0, kind=PLAIN) + FIRST)
    peer.pump(0.2, acknowledge=False)
    peer.close()
    expect(not peer.items, "session 0 was opened")
