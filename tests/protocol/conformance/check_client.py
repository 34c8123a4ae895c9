#!/usr/bin/python3
"""Checks a client against proto/PROTOCOL.md, and against nothing else. The client is a command that connects to an address and stays for
five seconds or more; it is started once for each check, against a server that follows a script.

usage: check_client.py [--only WORD] [--list] [--json] -- COMMAND...

{} in COMMAND is replaced by HOST:PORT; without it the address is appended. A client that ends where the document lets it end (after a
Reset, a Bye) passes. Exit code 0 if nothing failed."""
import argparse
import json
import random
import subprocess
import sys
import time

from peer import Failed, expect, header
from schema import control, stream
from scripted_server import ScriptedServer, scene_info

CHECKS = []
OF_MILLISECONDS = {"a_new_item_is_acknowledged_within_10_ms", "the_client_keeps_its_session_alive", "items_are_repeated_until_acknowledged"}
ATTEMPTS = 3
"""Rules of milliseconds are tried so often: a loaded machine is late now and then, a client that breaks the rule always."""
PROTOCOL_ERROR = control.BYE_REASON_PROTOCOL_ERROR
TONE = stream.Item(tone={"t_ns": 1, "frequency_hz": 440, "amplitude_m": 0.001, "level": 1, "decay_s": 1})
SLACK_S = 0.1
"""A loaded machine may be late by this much."""


def check(section):
    def register(function):
        CHECKS.append((section, function))
        return function
    return register


def tones(count):
    return [TONE] * count


@check(3)
def the_first_datagram_opens_a_session(server):
    """The first datagram has counter 0, first = 1, ack = 0 and a session number other than 0."""
    server.open()
    said = server.said[0]
    expect((said.counter, said.packet.first, said.packet.ack) == (0, 1, 0), f"counter {said.counter} first {said.packet.first} ack {said.packet.ack}")


@check(2)
def counters_grow_by_one(server):
    """The counter grows by 1 with every datagram, and no value is used twice."""
    server.open()
    server.serve(1.0)
    counters = [said.counter for said in server.of_session()]
    expect(counters == list(range(len(counters))), f"counters {counters[:30]}")


@check(3)
def the_client_keeps_its_session_alive(server):
    """A Packet comes at least every 100 ms."""
    server.open()
    begin = len(server.said)
    server.serve(1.5)
    instants = [said.at for said in server.said[begin:]]
    expect(len(instants) >= 13, f"{len(instants)} datagrams in 1.5 s")
    gap = max(b - a for a, b in zip(instants, instants[1:]))
    expect(gap <= 0.1 + SLACK_S, f"a gap of {gap * 1e3:.0f} ms")


@check(4)
def a_new_item_is_acknowledged_within_10_ms(server):
    """Who has received a new Item sends an ack within 10 ms."""
    server.open()
    delays = []
    for _ in range(15):
        server.serve(0.03)
        number = server.put(TONE)
        begin = time.monotonic()
        server.send()
        expect(server.acknowledged(number), "a Tone was not acknowledged in 1 s")
        delays.append(time.monotonic() - begin)
    middle = sorted(delays)[len(delays) // 2]
    expect(middle <= 0.010, f"half of the acks took more than {middle * 1e3:.1f} ms")


@check(4)
def items_count_once_over_a_bad_road(server):
    """Items that come twice, late or out of order are applied once: ack is the highest id up to which all have come."""
    server.open().hush()
    chance = random.Random(1)
    sent = []
    for _ in range(60):
        server.put(*tones(2))
        counter, server.counter = server.counter, server.counter + 1
        packet = stream.Packet(ack=server.applied, first=server.acked + 1, items=server.items[server.acked:][:16], boot_id=server.boot_id)
        sent.append((counter, packet))
        if chance.random() < 0.6:
            server.left = max(server.left, server.acked + len(packet.items))
            server.send(counter, packet)
        if chance.random() < 0.5:  # one of the last few, once more
            counter, packet = chance.choice(sent[-4:])
            server.left = max(server.left, packet.first + len(packet.items) - 1)
            server.send(counter, packet)
        server.serve(0.01)
    server.repeat = True
    expect(server.acknowledged(len(server.items), 5), f"ack {server.acked} of {len(server.items)}")
    expect(server.bye() is None, "the client said Bye")


@check(4)
def a_gap_ends_the_session_unless_ahead_was_announced(server):
    """first beyond the next Item is answered Bye PROTOCOL_ERROR; by who has announced `ahead` it is skipped, acknowledged as what was applied,
    and what comes in its turn counts."""
    server.open().hush()
    announced = server.of_session()[0].packet.ahead
    applied = server.acked
    server.left = applied + 20
    for first in (applied + 3, applied + 2, 2**64 - 1):
        begin = len(server.said)
        server.send(first=first, items=tones(3))
        server.serve(0.1, lambda: server.bye() is not None)
        if announced:
            expect(len(server.said) > begin, "Items that came early were not acknowledged")
    if not announced:
        expect(server.bye() == PROTOCOL_ERROR, f"Bye {server.bye()}")
        return
    expect(server.bye() is None, f"announced {announced} Packets ahead, and ended with Bye {server.bye()}")
    expect(server.acked == applied, f"Items that came early were applied: ack {server.acked}")
    for first, count in ((applied + 1, 1), (applied + 3, 2), (applied + 2, 1), (applied + 3, 2)):
        server.send(first=first, items=tones(count))
    expect(server.serve(1.0, lambda: server.acked == applied + 4), f"ack {server.acked} of {applied + 4}")
    expect(server.bye() is None, f"Bye {server.bye()}")


@check(4)
def ahead_is_announced_until_the_server_is_heard(server):
    """`ahead` is in every Packet of a client, or in none, until it has heard the server; and what is announced is 32 at most."""
    server.repeat = False
    taking, server.take = server.take, lambda *_: None
    expect(server.serve(10, lambda: len(server.said) >= 5), "the client does not repeat its first datagram")
    server.take = taking
    told = {said.packet.ahead for said in server.said}
    expect(len(told) == 1 and max(told) <= 32, f"ahead = {told} before the server was heard")


@check(4)
def an_ack_from_nowhere_ends_the_session(server):
    """An ack beyond the last Item sent is answered Bye PROTOCOL_ERROR."""
    server.open()
    server.send(ack=server.applied + 1000)
    server.serve(0.5, lambda: server.bye() is not None)
    expect(server.bye() == PROTOCOL_ERROR, f"Bye {server.bye()}")


@check(4)
def items_are_repeated_until_acknowledged(server):
    """An Item is repeated, in Packets that begin with the oldest, every 50 ms at the latest until it is acknowledged."""
    expect(server.serve(10, lambda: server.session), "no datagram from the client")
    server.serve(2, lambda: server.received)
    server.answering = False
    begin = len(server.said)
    server.serve(2.0, lambda: any(said.packet.items and said.packet.first > server.applied for said in server.said[begin:]))
    server.serve(0.6)
    waiting = [said for said in server.of_session(begin) if said.packet.items]
    expect(waiting, "the client has nothing to say: give it a command that keeps asking")
    firsts = {said.packet.first for said in waiting if said.at > waiting[0].at + 0.1}
    expect(firsts == {server.applied + 1}, f"Packets began with {firsts}, the oldest is {server.applied + 1}")
    gap = max((b.at - a.at for a, b in zip(waiting, waiting[1:])), default=1.0)
    expect(gap <= 0.05 + SLACK_S, f"{gap * 1e3:.0f} ms without a repeat")
    server.answering = True
    server.serve(1.0, lambda: server.applied >= waiting[0].packet.first)
    expect(server.applied >= waiting[0].packet.first, "the Items never came through")


@check(3)
def a_reset_begins_anew(server):
    """After a Reset the session is forgotten: only a new number, counter 0 and first = 1 may follow. The Reset counts from 0."""
    server.open()
    old = server.session
    reset = stream.Packet(first=1, boot_id=99, reset={"reason": stream.RESET_REASON_UNKNOWN_SESSION})
    server.raw(header(old, 0) + reset.SerializeToString())
    server.forgotten.add(old)
    server.repeat = False  # until the new session is there
    server.serve(0.05)
    begin, server.boot_id = len(server.said), 99
    server.serve(1.5, lambda: server.session != old)
    server.serve(0.3)
    late = [said for said in server.said[begin:] if said.session == old]
    expect(not late, f"{len(late)} datagrams of the old session after the Reset")
    if server.session != old:
        server.open()


@check(3)
def another_boot_id_begins_anew(server):
    """A boot_id other than before ends the session as a Reset does."""
    server.open()
    old = server.session
    server.boot_id = 77
    server.send()
    server.forgotten.add(old)
    server.repeat = False
    server.serve(0.05)
    begin = len(server.said)
    server.serve(1.5, lambda: server.session != old)
    late = [said for said in server.said[begin:] if said.session == old]
    expect(not late, f"{len(late)} datagrams of the old session")


@check(4)
def unknown_items_are_acknowledged_and_skipped(server):
    """Items and fields of a later version are acknowledged and skipped."""
    server.open()
    number = server.put(stream.Item.FromString(b"\xa2\x1f\x03abc"), stream.Item(), TONE)
    expect(server.acknowledged(number), "unknown Items were not acknowledged")
    packet = stream.Packet(ack=server.applied, first=server.acked + 1, boot_id=server.boot_id)
    packet.MergeFromString(b"\xa2\x1f\x03abc")
    server.send(packet=packet)
    number = server.put(TONE)
    expect(server.acknowledged(number) and server.bye() is None, "the session ended after a field nobody knows")


@check(3)
def the_servers_bye_ends_the_session(server):
    """A Bye is acknowledged, and 1 s later the session is forgotten."""
    server.open()
    number = server.put(stream.Item(bye={"reason": "BYE_REASON_SHUTDOWN"}))
    expect(server.acknowledged(number), "Bye was not acknowledged")
    server.repeat = False
    old = server.session
    server.serve(1.5)
    begin = len(server.said)
    server.serve(0.5)
    expect(not [said for said in server.said[begin:] if said.session == old], "the session goes on 1.5 s after Bye")


@check(2)
def what_does_not_open_is_dropped(server):
    """Datagrams with a wrong header, another session's number, or a body that does not open do nothing, and block no counter."""
    server.open().hush()
    number = server.acked + 1
    good = stream.Packet(ack=server.applied, first=number, items=tones(1), boot_id=server.boot_id).SerializeToString()
    many = stream.Packet(ack=server.applied, first=number, items=tones(17), boot_id=server.boot_id).SerializeToString()
    no_first = stream.Packet(ack=server.applied, items=tones(1), boot_id=server.boot_id).SerializeToString()
    counter = server.counter
    server.left = server.acked + 10
    for data in (header(server.session, counter, magic=0x49) + good, header(server.session, counter, major=2) + good,
                 header(server.session, counter, kind=4) + good + bytes(16), header(server.session, counter, reserved=1) + good,
                 header(server.session ^ 1, counter) + good, header(server.session, counter) + b"\xff\xff", header(server.session, counter)[:15],
                 header(server.session, counter) + no_first, header(server.session, counter) + many, header(server.session, counter) + good + b"\xa2\x7d\xff\x08" + bytes(1151 + 128)):
        server.raw(data)
    server.serve(0.2)
    expect(server.acked < number, "an Item in a broken datagram was applied")
    server.items.append(TONE)
    server.send(counter)
    server.counter = counter + 1
    expect(server.acknowledged(number), "the counter of a broken datagram was blocked")


@check(2)
def a_counter_is_taken_once(server):
    """A datagram whose counter was received already, or lies below the window of 2048, is dropped."""
    server.open().hush()
    server.left = server.acked + 10
    server.counter = 5000
    server.send()
    server.serve(0.05)
    number = server.acked + 1
    for counter in (5000, 5000 - 2048, 0):
        server.send(counter, first=number, items=tones(1))
    server.serve(0.2)
    expect(server.acked < number, "a datagram with an old counter was taken")
    server.items.append(TONE)
    server.send(5000 - 2047)
    expect(server.acknowledged(number), "the oldest counter of the window was not taken")


@check(5)
def a_blob_is_put_together(server):
    """Chunks in order, other Items between them, are one Item."""
    server.open()
    blob = scene_info(1, 3000).SerializeToString()
    pieces = [stream.Item(chunk={"blob": 1, "kind": 1, "offset": offset, "total": len(blob), "bytes": blob[offset:offset + 900]})
              for offset in range(0, len(blob), 900)]
    number = server.put(*(each for piece in pieces for each in (piece, TONE)))
    expect(server.acknowledged(number, 2) and server.bye() is None, f"ack {server.acked} of {number}")


@check(5)
def a_piece_out_of_place_ends_the_session(server):
    """A piece that breaks the rules of Chunks is answered Bye PROTOCOL_ERROR."""
    server.open()
    server.put(stream.Item(chunk={"blob": 1, "kind": 1, "offset": 900, "total": 1000, "bytes": bytes(100)}))
    server.serve(0.5, lambda: server.bye() is not None)
    expect(server.bye() == PROTOCOL_ERROR, f"Bye {server.bye()}")


@check(6)
def states_are_counted(server):
    """seen is the number of datagrams with a State, newest the largest tick among those of the highest scene_id."""
    server.open().hush()
    places = [(1, 10), (1, 30), (1, 20), (2, 5), (1, 40), (2, 7)]
    for scene_id, tick in places:
        server.send(state={"scene_id": scene_id, "tick": tick, "t_ns": tick * 1000000, "loop_state": 4})
    server.serve(0.5)
    packet = server.of_session()[-1].packet
    expect((packet.seen, packet.newest) == (len(places), 7), f"seen {packet.seen} newest {packet.newest}, not {len(places)} and 7")


def run(function, command):
    """(outcome, text) of one check: a server, a client, the script."""
    server = ScriptedServer()
    words = [word.replace("{}", server.address) for word in command]
    words = words if any("{}" in word for word in command) else words + [server.address]
    client = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    outcome, text = "passed", ""
    try:
        function(server)
    except Failed as failure:
        outcome, text = "FAILED", str(failure)
    client.kill()
    error = client.communicate()[1].strip().splitlines()
    server.socket.close()
    return outcome, text + (f" (the client: {error[-1]})" if outcome == "FAILED" and error else "")


def main():
    parser = argparse.ArgumentParser(description="Checks a client against PROTOCOL.md.")
    parser.add_argument("--only", default="")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("command", nargs="*")
    options = parser.parse_args()
    if not options.list and not options.command:
        parser.error("which client? check_client.py -- COMMAND...")
    results = []
    for section, function in sorted(CHECKS, key=lambda each: each[0]):
        rule = " ".join(function.__doc__.split())
        if options.only not in function.__name__:
            continue
        if options.list:
            print(f"{section:2} {function.__name__}: {rule}")
            continue
        for _ in range(ATTEMPTS if function.__name__ in OF_MILLISECONDS else 1):
            outcome, text = run(function, options.command)
            if outcome == "passed":
                break
        results.append({"name": function.__name__, "section": section, "rule": rule, "outcome": outcome, "text": text})
        if not options.json:
            print(f"{outcome:7} section {section} {function.__name__}{': ' + text if text else ''}", flush=True)
    failed = sum(result["outcome"] == "FAILED" for result in results)
    if options.json:
        print(json.dumps({"checks": results, "passed": len(results) - failed, "failed": failed}, indent=1))
    elif not options.list:
        print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
