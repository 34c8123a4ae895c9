"""Checks of sections 4, 5 and 7: Items exactly once and in order, acknowledgements, repeats, the backlog, Chunks and the clock."""
import random
import time

from peer import Skipped, code, expect
from registry import check
from schema import control, item, stream

PROTOCOL_ERROR = control.BYE_REASON_PROTOCOL_ERROR


def expect_bye(peer, reason, seconds=3.0):
    expect(peer.pump(seconds, lambda: peer.of_kind("bye")), "no Bye")
    bye = peer.of_kind("bye")[-1]
    expect(bye.reason == reason, f"Bye {control.ByeReason.Name(bye.reason)} {bye.message}")
    expect(peer.items[-1][1].HasField("bye"), "an Item after Bye")


@check(4)
def items_arrive_once_and_in_order_over_a_bad_road(server):
    """With 40 % loss both ways and datagrams doubled every request is carried out once and answered once, in order."""
    for seed in range(3):
        peer = server.open()
        peer.lossy = random.Random(seed)
        first = len(peer.sent_items) + 1
        for _ in range(60):
            peer.queue(item("ping"))
            peer.pump(0.004)
        last = len(peer.sent_items)
        expect(peer.pump(20, lambda: last in peer.results), f"seed {seed}: {len(peer.results)} Results")
        expect([number for number in peer.results] == list(range(first, last + 1)), f"seed {seed}: Results for {list(peer.results)}")
        peer.lossy = None


@check(4)
def an_old_item_is_ignored(server):
    """Items with an id already applied do nothing."""
    peer = server.open()
    peer.demand(item("ping"))
    for _ in range(3):
        peer.send(first=1, items=[item("ping")])
    peer.pump(0.2)
    expect(peer.acked == 1 and len(peer.results) == 1, "an Item was applied twice")


@check(4)
def a_gap_ends_the_session(server):
    """first beyond the next Item is Bye PROTOCOL_ERROR, and nothing of that Packet is applied."""
    peer = server.open()
    peer.demand(item("ping"))
    peer.send(first=3, items=[item("ping")])
    expect_bye(peer, PROTOCOL_ERROR)
    expect(len(peer.results) == 1, "an Item after the gap was answered")


@check(4)
def an_ack_from_nowhere_ends_the_session(server):
    """An ack beyond the last Item sent is Bye PROTOCOL_ERROR."""
    peer = server.open()
    peer.send(ack=peer.applied + 100)
    expect_bye(peer, PROTOCOL_ERROR)


@check(4)
def a_smaller_ack_is_harmless(server):
    """Of the acks that arrive the largest counts."""
    peer = server.open()
    peer.demand(item("ping"))
    peer.send(ack=0)
    peer.send(ack=1)
    begin = len(peer.heard)
    peer.demand(item("ping"))
    expect(all(heard.packet.first >= peer.applied - 1 for heard in peer.heard[begin:]), "Items that were acknowledged came again")
    expect(not peer.of_kind("bye"), "the session was ended")


@check(4)
def unacknowledged_items_lead_every_packet(server):
    """Every Packet carries the oldest unacknowledged Items from the oldest on, first is its id, and 16 are the most."""
    peer = server.peer()
    peer.send()
    peer.pump(0.4, acknowledge=False)
    with_items = [heard.packet for heard in peer.heard if heard.packet.items]
    expect(with_items and all(packet.first == 1 for packet in with_items), "a Packet began with another Item than the oldest")
    expect(len(with_items) == len(peer.heard), "a Packet without the unacknowledged Items")
    peer.send()
    for _ in range(20):
        peer.queue(item("ping"))
    for _ in range(2):
        peer.send(ack=0)
        peer.pump(0.05, acknowledge=False)
    expect(max(len(heard.packet.items) for heard in peer.heard) <= 16, "more than 16 Items in a Packet")
    peer.pump(1.0, lambda: len(peer.results) == 20)
    expect(len(peer.results) == 20, "not all Results came once they were acknowledged")
    peer.pump(0.1)
    begin = len(peer.heard)
    peer.pump(0.3)
    expect(all(not heard.packet.items and heard.packet.first == peer.applied + 1 for heard in peer.heard[begin:]),
           "with nothing unacknowledged first is not the next id")


@check(4, attempts=3)
def repeats_follow_the_schedule(server):
    """An Item is sent again 1, 3, 7, 15 and 31 ms after it first left, then every 50 ms, until it is acknowledged."""
    best = None
    for _ in range(4):
        peer = server.open()
        peer.pump(0.15)
        begin = len(peer.heard)
        peer.queue(item("ping"))
        peer.send()
        peer.pump(0.45, acknowledge=False)
        instants = [heard.at for heard in peer.heard[begin:] if heard.packet.items]
        expect(instants, "no Result")
        offsets = [(at - instants[0]) * 1e3 for at in instants]
        wanted = (0, 1, 3, 7, 15, 31, 81, 131, 181, 231, 281, 331, 381)
        error = max((min(abs(offset - at) for offset in offsets) for at in wanted), default=1e9)
        best = min(error, best or 1e9)
        expect(6 <= len(offsets) <= 20, f"{len(offsets)} datagrams with the Item in 450 ms, at {[round(each) for each in offsets]} ms")
        if best < 6:
            return
    expect(best < 15, f"a repeat is {best:.1f} ms from its time, at {[round(each, 1) for each in offsets]} ms")


@check(4, attempts=3)
def a_new_item_is_acknowledged_within_10_ms(server):
    """Who has received a new Item sends an ack within 10 ms."""
    delays = []
    peer = server.open()
    for _ in range(8):
        peer.pump(0.06)
        number = peer.queue(item("ping"))
        begin = time.monotonic()
        peer.send()
        expect(peer.pump(1.0, lambda: peer.acked >= number, acknowledge=False), "a new Item was not acknowledged in 1 s")
        delays.append(time.monotonic() - begin)
    expect(sorted(delays)[len(delays) // 2] <= 0.010, f"acknowledged after {[round(each * 1e3, 1) for each in delays]} ms")


@check(4)
def unknown_items_are_answered_unsupported(server):
    """An Item whose body is not set, of a kind nobody knows, or of one that servers send, is acknowledged and answered UNSUPPORTED."""
    peer = server.open()
    unknown = stream.Item.FromString(b"\xa2\x1f\x03abc")  # field 500, 3 bytes
    for each in (stream.Item(), stream.Item(fence=7), unknown, item("tone"), item("scene_info"), item("result")):
        result = peer.request(each)
        expect(code(result) == "UNSUPPORTED", f"{code(result)}")
    peer.demand(item("ping"))


@check(4)
def a_full_backlog_ends_with_bye(server):
    """When more than 1024 Items are not acknowledged, Bye BACKLOG takes the place of the next, and none before it is lost."""
    peer = server.open()
    begin = peer.applied
    for _ in range(1030):
        peer.queue(item("ping"))
    end = time.monotonic() + 10
    while peer.acked < 1024 and time.monotonic() < end and not peer.of_kind("bye"):
        peer.send(ack=begin)
        peer.pump(0.01, acknowledge=False)
    for _ in range(3):  # the Items that are too many
        peer.send(ack=begin)
        peer.pump(0.01, acknowledge=False)
    expect(peer.pump(10, lambda: peer.of_kind("bye")), "no Bye after 1030 unacknowledged Results")
    expect_bye(peer, control.BYE_REASON_BACKLOG)
    expect(peer.applied - begin == 1025, f"Bye is the {peer.applied - begin}th Item, not the 1025th")
    expect(list(peer.results) == list(range(1, 1025)), "a Result before Bye is missing")


def behind(server, ahead):
    """A session that announces so many Packets ahead, has 100 Results to hear, and acknowledges none; and the Packets with them."""
    peer = server.peer()
    peer.ahead = ahead
    peer.open()
    peer.send()
    expect(peer.pump(1.0, lambda: not peer.heard[-1].packet.items), "Items that were acknowledged came again")
    for _ in range(100):
        peer.queue(item("ping"))
    begin, acknowledged = len(peer.heard), peer.applied
    end = time.monotonic() + 5
    while peer.acked < 100 and time.monotonic() < end:
        peer.send(ack=acknowledged)
        peer.pump(0.005, acknowledge=False)
    peer.pump(0.3, acknowledge=False)
    expect(peer.acked == 100, "100 requests were not acknowledged in 5 s")
    return peer, acknowledged, [heard.packet for heard in peer.heard[begin:] if heard.packet.items]


def takes_ahead(peer):
    """Skips the check where the server has never heard of it."""
    announced = [heard.packet.ahead for heard in peer.heard]
    if not any(announced):
        raise Skipped("the server takes no Packets ahead")
    return announced


@check(4)
def packets_ahead_go_to_who_takes_them(server):
    """Who has announced `ahead` is sent new Items in further Packets before the oldest is acknowledged, and no more Packets than announced."""
    for _ in range(5):
        peer, acknowledged, packets = behind(server, 32)
        takes_ahead(peer)
        highest = max(packet.first + len(packet.items) - 1 for packet in packets)
        # A server whose Items wait for longer than a round trip has taken the first Packet for lost, and sends nothing ahead of it.
        if highest > acknowledged + 16:
            break
    expect(highest > acknowledged + 16, f"of 100 Items {highest - acknowledged} left before the first was acknowledged")
    peer.pump(2.0, lambda: len(peer.results) == 100)
    expect(list(peer.results) == list(range(1, 101)), "Results are missing, or out of order")
    few = server.peer()
    few.ahead = 2
    few.open()
    few.send()
    few.pump(0.1)
    for _ in range(100):
        few.queue(item("ping"))
    begin, acknowledged = len(few.heard), few.applied
    for _ in range(10):
        few.send(ack=acknowledged)
        few.pump(0.02, acknowledge=False)
    highest = max(heard.packet.first + len(heard.packet.items) - 1 for heard in few.heard[begin:] if heard.packet.items)
    expect(highest <= acknowledged + 2 * 16, f"2 Packets were announced, and {highest - acknowledged} Items left")


@check(4)
def packets_ahead_go_to_nobody_else(server):
    """Who has announced nothing is sent Packets that begin with the oldest Item, and no `ahead`."""
    peer, acknowledged, packets = behind(server, 0)
    firsts = {packet.first for packet in packets}
    expect(firsts == {acknowledged + 1}, f"Packets began with {sorted(firsts)}, the oldest is {acknowledged + 1}")
    expect(not any(heard.packet.ahead for heard in peer.heard), "ahead was announced to a client that had not done so")


@check(4)
def ahead_is_announced_in_return(server):
    """A server that takes Packets ahead says so in its Packets to who has announced it, until that has acknowledged an Item; 32 at most."""
    peer = server.peer()
    peer.ahead = 32
    peer.send()
    peer.pump(0.3, acknowledge=False)
    announced = takes_ahead(peer)
    expect(len(set(announced)) == 1 and max(announced) <= 32, f"ahead = {set(announced)} before anything was acknowledged")
    peer.send()
    peer.pump(0.2)
    begin = len(peer.heard)
    peer.pump(0.3)
    expect(not any(heard.packet.ahead for heard in peer.heard[begin:]), "ahead is announced to a client that has heard it")


@check(4)
def items_that_come_early_are_skipped(server):
    """A server that has announced `ahead` skips Items beyond the next, acknowledges what it has applied, and takes them in their turn."""
    peer = server.peer()
    peer.ahead = 32
    peer.open()
    takes_ahead(peer)
    peer.demand(item("ping"))
    pings = [item("ping") for _ in range(3)]
    begin = time.monotonic()
    for first in (4, 3, 2**64 - 1):
        peer.send(first=first, items=pings[:1])
    expect(peer.pump(1.0, lambda: peer.heard[-1].at > begin), "Items that came early were not acknowledged")
    peer.pump(0.1)
    expect(not peer.of_kind("bye"), "the session was ended")
    expect(peer.acked == 1, f"ack {peer.acked} after Items that came early")
    for _ in pings:
        peer.queue(item("ping"))
    for first in (2, 4, 3, 4):
        peer.send(first=first, items=pings[:1])
    expect(peer.pump(1.0, lambda: len(peer.results) == 4, acknowledge=False), f"{len(peer.results)} Results of 4")
    expect(list(peer.results) == [1, 2, 3, 4], f"Results for {list(peer.results)}")


@check(4)
def packets_ahead_survive_a_bad_road(server):
    """With 40 % loss both ways and datagrams doubled, many Items in several Packets arrive once, in order."""
    for seed in range(2):
        peer = server.peer()
        peer.ahead = 32
        peer.open()
        peer.lossy = random.Random(seed)
        last = 0
        for _ in range(200):
            last = peer.queue(item("ping"))
        expect(peer.pump(20, lambda: last in peer.results), f"seed {seed}: {len(peer.results)} Results")
        expect(list(peer.results) == list(range(1, last + 1)), f"seed {seed}: Results for {list(peer.results)}")
        peer.lossy = None


@check(5)
def a_blob_is_one_item(server):
    """A request in Chunks, other Items between them, is answered once, with the id of its last Chunk."""
    peer = server.holder()
    text = 'name: "blob"\n' + "# a long comment\n" * 200 + 'tools { name: "t" parts { name: "p" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } }'
    blob = item("load_scene", text=text, check_only=True).SerializeToString()
    chunks = [stream.Chunk(blob=1, kind=stream.CHUNK_KIND_ITEM, offset=offset, total=len(blob), bytes=blob[offset:offset + 900])
              for offset in range(0, len(blob), 900)]
    pings = []
    for chunk in chunks:
        pings.append(peer.queue(item("ping")))
        last = peer.queue(stream.Item(chunk=chunk))
    peer.send()
    result = peer.result(last, 20)
    expect(code(result) == "OK", f"{code(result)} {result.path} {result.message}")
    peer.pump(0.1)
    expect(sorted(peer.results) == [1] + pings + [last], f"Results for {sorted(peer.results)}")


@check(5)
def a_blob_that_does_not_decode_is_invalid(server):
    """A blob that is no Item is answered INVALID, and the session goes on."""
    peer = server.open()
    last = peer.queue_blob(b"\xff" * 1500)
    peer.send()
    expect(code(peer.result(last)) == "INVALID", "not INVALID")
    peer.demand(item("ping"))


@check(5)
def a_blob_of_an_unknown_kind_is_unsupported(server):
    """A blob of a kind that the receiver does not know is taken like an Item without a body."""
    peer = server.open()
    last = peer.queue(stream.Item(chunk={"blob": 1, "kind": 9, "offset": 0, "total": 3, "bytes": b"abc"}))
    peer.send()
    expect(code(peer.result(last)) == "UNSUPPORTED", "not UNSUPPORTED")


@check(5)
def pieces_out_of_place_end_the_session(server):
    """A piece that breaks the rules of Chunks ends the session with Bye PROTOCOL_ERROR."""
    good = dict(blob=1, kind=stream.CHUNK_KIND_ITEM, offset=0, total=1000, bytes=bytes(900))
    wrong = {"blob 2 first": dict(blob=2), "an offset of 1": dict(offset=1), "no bytes": dict(bytes=b""), "901 bytes": dict(bytes=bytes(901)),
             "a total of 0": dict(total=0), "a total beyond 4 MiB": dict(total=4194305), "a total below the bytes": dict(total=10)}
    for why, change in wrong.items():
        peer = server.open()
        peer.queue(stream.Item(chunk={**good, **change}))
        peer.send()
        expect(peer.pump(2.0, lambda: peer.of_kind("bye")), f"{why}: no Bye")
        expect_bye(peer, PROTOCOL_ERROR)
    peer = server.open()
    peer.queue(stream.Item(chunk=good))
    peer.queue(stream.Item(chunk={**good, "blob": 2}))
    peer.send()
    expect_bye(peer, PROTOCOL_ERROR)
    peer = server.open()
    inner = stream.Item(chunk={**good, "bytes": b"x"}).SerializeToString()
    peer.queue_blob(inner)
    peer.send()
    expect_bye(peer, PROTOCOL_ERROR)


@check(7)
def the_clock_is_echoed(server):
    """The next Packet echoes the client's sent_ns with the instants of arrival and answer, in this order and within the round trip."""
    peer = server.open()
    for _ in range(5):
        begin, sent = len(peer.heard), time.monotonic_ns()
        peer.send(clock={"sent_ns": sent})
        expect(peer.pump(1.0, lambda: any(each.packet.clock.echoed_ns == sent for each in peer.heard[begin:])), "no echo in 1 s")
        heard = next(each for each in peer.heard[begin:] if each.packet.clock.echoed_ns == sent)
        clock = heard.packet.clock
        inside, outside = clock.sent_ns - clock.received_ns, heard.at * 1e9 - sent
        expect(0 <= inside <= outside + 1e3, f"{inside} ns in the server, but {outside:.0f} ns from question to answer")
