"""Checks of section 12: keyed sessions. All other sections are checked with keys too."""
import time

import keyed
from checks_session import nothing_comes
from peer import MAGIC, MAJOR, Peer, expect, header
from registry import check
from schema import code, item, stream

FIRST = stream.Packet(first=1).SerializeToString()
NEED_CONTROL = ("acquire", "stop", "release", "engage", "disengage", "clear", "load_scene", "set_parameter", "pose_batch", "run", "play_gesture",
                "replay", "record", "calibrate", "recentre", "clutch")
WITH_RIGHTS = ("ping", "get_counts", "get_parameters", "list_scenes", "get_device_info", "subscribe")


def silent(peer, data, why):
    expect(peer.answer_to(data, range(256), 0.15) is None, f"{why} was answered")


@check(12, road="keyed")
def a_server_with_keys_speaks_no_plain(server):
    """A server with keys speaks no PLAIN, and drops an unknown session without an answer."""
    peer = server.peer()
    silent(peer, header(5, 0) + FIRST, "a PLAIN datagram")
    silent(peer, header(5, 0) + stream.Packet(first=2).SerializeToString(), "a PLAIN datagram of an unknown session")
    silent(peer, header(5, 0, kind=keyed.DATA) + bytes(64), "a DATA of an unknown session")


@check(12, road="keyed")
def the_view_key_leaves_places_for_the_control_key(server):
    """24 sessions of the view key may be open; the next one gets Reset FULL, and the control key gets in."""
    viewers = []
    refused = None
    for _ in range(33):
        peer = server.peer(keyed.VIEW)
        peer.send()
        peer.pump(3.0, lambda: peer.heard)
        expect(peer.heard, "no answer to a first datagram")
        if peer.heard[0].packet.HasField("reset"):
            refused = peer
            break
        viewers.append(peer)
        for each in viewers:
            each.pump(0.002)
    expect(refused is not None and len(viewers) == 24, f"{len(viewers)} sessions of the view key are open")
    expect(refused.heard[0].packet.reset.reason == stream.RESET_REASON_FULL, "the Reset does not say FULL")
    expect(server.open().request(item("ping")).code == 1, "the control key is not served")


@check(12, road="keyed")
def only_a_hello_under_the_roles_key_is_answered(server):
    """The server answers only a HELLO whose message 1 verifies under the role's key."""
    peer = server.peer()
    good = peer.keys.hello()

    def changed(offset):
        return good[:offset] + bytes([good[offset] ^ 1]) + good[offset + 1:]
    bad = {
        "a HELLO under no key of the server": keyed.Handshake((bytes(32), server.keys[keyed.VIEW][1]), keyed.CONTROL).hello(),
        "control under the view key": keyed.Handshake(server.keys[keyed.VIEW], keyed.CONTROL).hello(),
        "view under the control key": keyed.Handshake(server.keys[keyed.CONTROL], keyed.VIEW).hello(),
        "an unknown role": keyed.Handshake(server.keys[keyed.CONTROL], 5).hello(),
        "a changed key id": changed(18),
        "a changed ephemeral key": changed(26),
        "a changed tag of message 1": changed(26 + 47),
        "a changed tag": changed(26 + 48),
        "a HELLO of 1199 bytes": good[:-1],
        "a HELLO without zeros": good[:26 + 48 + 16],
        "a cookie of 65 bytes": good[:17] + bytes([65]) + good[18:],
    }
    for why, data in bad.items():
        silent(server.peer(), data, why)
    expect(server.peer().answer_to(good, (keyed.RETRY,), 1.0) is not None, "a good HELLO got no RETRY")


@check(12, road="keyed")
def hello_retry_hello_welcome(server):
    """A HELLO gets a RETRY of session 0 with 1 to 64 bytes; with this cookie it gets a WELCOME that opens, and again the same one."""
    peer = server.peer()
    retry = peer.answer_to(peer.keys.hello(), range(256), 1.0)
    expect(retry is not None and retry[:16] == header(0, 0, kind=keyed.RETRY), "no RETRY")
    expect(1 <= len(retry) - 16 <= 64, f"a cookie of {len(retry) - 16} bytes")
    wrong = bytes([retry[16] ^ 1]) + retry[17:]
    again = peer.answer_to(peer.keys.hello(wrong), range(256), 1.0)
    expect(again is not None and again[2] == keyed.RETRY, "a wrong cookie was not answered with RETRY")
    hello = peer.keys.hello(retry[16:])
    welcome = peer.answer_to(hello, range(256), 1.0)
    expect(welcome is not None and len(welcome) == 64 and welcome[:4] == bytes([MAGIC, MAJOR, keyed.WELCOME, 0]), "no WELCOME")
    expect(welcome[4:8] != bytes(4) and welcome[8:16] == bytes(8), "the WELCOME's session or counter")
    expect(peer.answer_to(hello, range(256), 1.0) == welcome, "a repeated HELLO got another WELCOME")
    peer.keys.welcome(welcome)
    elsewhere = server.peer()
    answer = elsewhere.answer_to(hello, range(256), 1.0)
    expect(answer is not None and answer[2] == keyed.RETRY, "the cookie is good for another address")


@check(12, road="keyed")
def a_client_of_before_is_told_so(server):
    """A HELLO of NNpsk0 is served, or its first DATA is answered by Reset OLD_KEY."""
    peer = server.peer(keyed.OLD_CONTROL)
    peer.send()
    peer.pump(3.0, lambda: peer.heard)
    expect(peer.heard, "no answer to the first datagram of an old client")
    first = peer.heard[0].packet
    expect(not first.HasField("reset") or first.reset.reason == stream.RESET_REASON_OLD_KEY, "another Reset than OLD_KEY")
    expect(not first.HasField("reset") or first.reset.message, "the Reset does not say what to do")


@check(12, road="keyed")
def the_server_has_its_private_key(server):
    """Message 1 to another server key than the server's is not answered with WELCOME."""
    other = keyed.Handshake((server.keys[keyed.CONTROL][0], bytes([9]) + bytes(31)), keyed.CONTROL)
    peer = server.peer()
    retry = peer.answer_to(other.hello(), range(256), 1.0)
    expect(retry is not None and retry[2] == keyed.RETRY, "no RETRY")
    silent(peer, other.hello(retry[16:]), "a HELLO to another server")


@check(12, road="keyed")
def nothing_but_answers_before_the_first_data(server):
    """Until the first DATA of the client opens, the server sends no more bytes than it received, and nothing by itself."""
    peer = server.peer()
    peer.shake_hands()
    forged = bytearray(peer.keys.seal(0, FIRST))
    forged[-1] ^= 1
    peer.send_raw(bytes(forged))
    expect(peer.hear_raw(0.5) is None, "a DATA that does not open was answered, or the server spoke by itself")
    peer.open()


@check(12, road="keyed")
def a_repeated_hello_does_not_end_the_session(server):
    """A HELLO sent again while its session lives gets the same WELCOME, and the session goes on."""
    peer = server.open()
    peer.send_raw(peer.hello)
    peer.pump(0.2)
    peer.demand(item("ping"))


@check(12, road="keyed")
def a_tampered_data_is_dropped_and_blocks_no_counter(server):
    """DATA opens only with its header as associated data; what does not open marks no counter."""
    peer = server.open()
    ping = peer.queue(item("ping"))
    body = stream.Packet(first=1, ack=peer.applied, items=[item("ping")]).SerializeToString()
    good = peer.keys.seal(peer.counter, body)
    for offset in (4, 8, 16, len(good) // 2, len(good) - 1):
        bad = bytearray(good)
        bad[offset] ^= 1
        peer.send_raw(bytes(bad))
    peer.pump(0.1, acknowledge=False)
    expect(peer.acked < ping, "a tampered DATA was taken")
    peer.send_raw(good)
    peer.counter += 1
    peer.result(ping)


@check(12, road="keyed")
def a_session_belongs_to_its_address(server):
    """DATA from another address or port is of an unknown session."""
    peer, other = server.open(), server.peer()
    ping = peer.queue(item("ping"))
    data = peer.keys.seal(peer.counter, stream.Packet(first=1, ack=peer.applied, items=[item("ping")]).SerializeToString())
    silent(other, data, "DATA from another address")
    peer.pump(0.1, acknowledge=False)
    expect(peer.acked < ping, "DATA from another address was taken")
    peer.send()
    peer.result(ping)


@check(12, road="keyed")
def the_view_key_does_not_control(server):
    """A session of the view key gets NOT_PERMITTED wherever a request needs control or the lease, and may do everything else."""
    viewer = server.peer(keyed.VIEW).open()
    for kind in NEED_CONTROL:
        result = viewer.request(item(kind))
        expect(code(result) == "NOT_PERMITTED", f"{kind} of the view key: {code(result)}")
    for kind in WITH_RIGHTS:
        viewer.demand(item(kind))


@check(12, road="keyed", attempts=3)
def hellos_are_limited(server):
    """5 HELLOs at once and 20 a second are looked at per IPv4 address."""
    peer = Peer(server.address, server.keys[keyed.CONTROL])
    server.peers.append(peer)
    hello, begin, answers, sent = peer.keys.hello(), time.monotonic(), 0, 0
    while time.monotonic() - begin < 1.0:
        peer.send_raw(hello)
        sent += 1
        answers += peer.hear_raw(0.005) is not None
    while peer.hear_raw(0.1) is not None:
        answers += 1
    elapsed = time.monotonic() - begin
    expect(sent > 60, f"only {sent} HELLOs were sent: too slow to see anything")
    expect(15 <= answers <= 5 + 20 * elapsed + 1, f"{answers} answers to {sent} HELLOs in {elapsed:.2f} s")
    nothing_comes(peer, 0.1, "nothing")
