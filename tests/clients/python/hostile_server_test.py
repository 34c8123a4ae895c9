"""What a server may send, right or wrong: packets that are damaged at random, in a fixed order, bring up nothing but the exceptions that the
package documents, and are not hoarded."""
import random
import unittest

import hapticd
import support
from hapticd import wire
from hapticd.conversation import Conversation, Peer
from hapticd.errors import RequestError, ServerFull, SessionEnded, SessionLost, shown_text
from hapticd.link import Link
from hapticd.tables import EVENT_KINDS
from hapticd.v1 import answer_pb2, config_pb2, scene_pb2, state_pb2, stream_pb2

EDGES = (0x00, 0x01, 0x7F, 0x80, 0xFE, 0xFF)


def scene_info():
    scene = scene_pb2.Scene(name="strings", strings=[dict(name="C2"), dict(name="G2")])
    return answer_pb2.SceneInfo(scene_id=1, scene=scene, rate_hz=1000, clock=config_pb2.CLOCK_MODE_REALTIME)


def good_packets():
    """Of every kind, such as a server sends them."""
    state = dict(scene_id=1, tick=7, tools=[dict(tool_id=3, p_wh_m=[0.1, 0.2, 0.3], wrench_h_w=[1] * 6)], contacts=[dict(tool_id=3, gap_nanometres=[5])],
                 strings=[dict(string_index=1)])
    blob = stream_pb2.Item(scene_info=scene_info()).SerializeToString()
    items = [
        [dict(scene_info=scene_info()), dict(lease_info=dict(fence=1, holder="me", yours=True)), dict(record_info=dict(state=1))],
        [dict(result=dict(item_id=1, code=1)), dict(result=dict(item_id=2, code=5, path="x", message="no\nand why"))],
        [dict(tone=dict(string_index=1, t_ns=5, frequency_hz=65, level=0.5)), dict(contact={}),
         dict(string_sounding=dict(string_index=1, number=1, t_ns=9, frequency_hz=65, partials_m=[1e-3], decays_s=[0.5]))],
        [dict(chunk=dict(blob=1, kind=1, offset=offset, total=len(blob), bytes=piece)) for offset, piece in ((0, blob[:9]), (9, blob[9:]))],
        [dict(fault=dict(cause=3, latched=True)), dict(bye=dict(reason=2, message="hapticd ends."))],
    ]
    packets = [stream_pb2.Packet(first=1, boot_id=5, ack=1, items=[stream_pb2.Item(**item) for item in each]) for each in items]
    packets += [stream_pb2.Packet(first=1, boot_id=5, state=state_pb2.State(**state), clock=dict(echoed_ns=1, received_ns=2, sent_ns=3), ahead=32),
                stream_pb2.Packet(first=1, boot_id=5, state=state_pb2.State(**state, part_index=0, part_count=2)),
                stream_pb2.Packet(first=1, boot_id=5, state=state_pb2.State(**state, part_index=1, part_count=2)),
                stream_pb2.Packet(first=1, boot_id=5, reset=dict(reason=2, message="32 sessions are open"))]
    return [packet.SerializeToString() for packet in packets]


def damaged(chance, data, other):
    data = bytearray(data)
    for _ in range(chance.randrange(1, 4)):
        place = chance.randrange(len(data) + 1)
        what = chance.randrange(5)
        if what == 0 and data:
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        elif what == 1 and data:
            data[chance.randrange(len(data))] = chance.choice(EDGES)
        elif what == 2:
            del data[place:place + chance.randrange(16)]
        elif what == 3:
            begin = chance.randrange(len(other) + 1)
            data[place:place] = other[begin:begin + chance.randrange(32)]
        else:
            begin = chance.randrange(len(other) + 1)
            piece = other[begin:begin + chance.randrange(32)]
            data[place:place + len(piece)] = piece
    return bytes(data[:1184])


def asked(make, *arguments):
    """An Item for which `make` has been called on its kind."""
    item = stream_pb2.Item()
    getattr(item, make).SetInParent()
    for name, value in arguments:
        setattr(getattr(item, make), name, value)
    return item


class Damage(unittest.TestCase):
    def hear(self, chance, seeds):
        """One conversation that hears a dozen packets."""
        conversation = Conversation(Peer("127.0.0.1:1", reconnect=chance.random() < 0.5, keep_states=8))
        ids = [conversation.put(asked("subscribe", ("divisor", 1)), awaited=True), conversation.put(asked("ping"), awaited=True)]
        list(conversation.due_datagrams())
        counter, first = 0, 1
        for _ in range(12):
            packet = damaged(chance, chance.choice(seeds), chance.choice(seeds)) if chance.random() < 0.8 else chance.choice(seeds)
            try:  # as a server does that counts rightly, now and then
                right = stream_pb2.Packet.FromString(packet)
                if chance.random() < 0.7:
                    right.first, right.boot_id = first, 5
                    first += len(right.items)
                    packet = right.SerializeToString()[:1184]
            except Exception:  # pylint: disable=broad-except
                pass  # It is sent as it is.
            session = conversation.link.session
            conversation.take(wire.encode(wire.KIND_PLAIN, session, counter, packet), 1_000_000 * counter)
            counter += 1
            if conversation.link.session != session:
                first = 1
            list(conversation.due_datagrams())
        return conversation, ids

    def look(self, conversation, ids):
        """All that a caller may ask of what was heard."""
        try:
            conversation.check()
        except (SessionEnded, SessionLost, ServerFull) as error:
            self.assertEqual(str(error), shown_text(str(error), kept="\n"))
        for item_id in ids:
            result = conversation.results.get(item_id)
            try:
                if result is not None:
                    conversation.settle(asked("ping"), result)
            except RequestError as error:
                self.assertEqual(str(error), shown_text(str(error), kept="\n"))
        conversation.present(0)
        self.assertLessEqual(len(conversation.states), 8)
        hapticd.table(conversation.states, 3)
        for state in conversation.states:
            for patch in state.contacts:
                hapticd.contacts(patch)
        for event in conversation.events:
            if event.kind in EVENT_KINDS:
                hapticd.event_table([event], event.kind)
            if event.kind == "string_sounding":
                hapticd.sounding_at(event.body, 10**12)

    def test_nothing_that_a_server_sends_raises_what_is_not_documented(self):
        seeds = good_packets()
        for seed in range(support.scaled(20_000)):
            with self.subTest(seed=seed):
                self.look(*self.hear(random.Random(seed), seeds))

    def test_a_link_is_lost_in_two_ways_alone(self):
        seeds = good_packets()
        for seed in range(support.scaled(50_000)):
            chance = random.Random(seed)
            link = Link(9, 0)
            try:
                for counter in range(3):
                    body = damaged(chance, chance.choice(seeds), chance.choice(seeds))
                    link.receive(wire.encode(wire.KIND_PLAIN, 9, counter, body), counter)
            except (SessionLost, ServerFull):
                pass

    def test_the_packets_themselves_are_taken(self):
        for packet in good_packets()[:-1]:
            conversation = Conversation(Peer("127.0.0.1:1"))
            conversation.put(asked("ping"))
            list(conversation.due_datagrams())
            conversation.take(wire.encode(wire.KIND_PLAIN, conversation.link.session, 0, packet), 0)
            arrived = stream_pb2.Packet.FromString(packet)
            kinds = {item.WhichOneof("body") for item in arrived.items}
            self.assertEqual(conversation.link.seen, arrived.HasField("state"))
            self.assertEqual(conversation.over is not None, "bye" in kinds)
            self.assertEqual(bool(conversation.events), bool(kinds - {"result", "bye"}))


if __name__ == "__main__":
    unittest.main()
