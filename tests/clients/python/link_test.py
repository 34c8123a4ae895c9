"""Items exactly once and in order over a road that loses, doubles and reorders, the schedule of repeats, blobs, States and Bye. All in
virtual time; the truth is the sequence that was sent and the numbers of PROTOCOL.md."""
import unittest

import support
from hapticd import wire
from hapticd.errors import ProtocolError, SessionLost
from hapticd.items import ITEM_ROOM, BacklogFull, Inbox, Outbox
from hapticd.link import Link
from hapticd.v1 import control_pb2, stream_pb2
from support import MS, Road


def numbered(number, size=0):
    """An Item that can be told from others."""
    item = stream_pb2.Item()
    item.acquire.holder = str(number) + "x" * size
    return item


def plain(link, counter, **packet):
    packet.setdefault("first", 1)
    packet.setdefault("boot_id", 1)
    return wire.encode(wire.KIND_PLAIN, link.session, counter, stream_pb2.Packet(**packet).SerializeToString())


def shown(counter, link, **state):
    return link.receive(plain(link, counter, state=state), 0).state


class ExactlyOnce(unittest.TestCase):
    def exchange(self, seed, loss, size=0, count=40):
        """Two links talk over two roads until everything has arrived; returns what each has received, in ms of virtual time."""
        links = [Link(9, 0), Link(9, 0)]
        roads = [Road(2 * seed, loss), Road(2 * seed + 1, loss)]
        got = [[], []]
        for now in range(0, 60_000 * MS, MS):
            for side, link in enumerate(links):
                if now < count * MS and seed % 3 == 0 or now == 0:
                    for number in range(count if now == 0 and seed % 3 else 1):
                        link.submit(numbered(number if now == 0 else now // MS, size))
                for data in roads[1 - side].take(now):
                    got[side] += [item.acquire.holder for _, item in link.receive(data, now).items]
                if link.due_ns() <= now:
                    roads[side].put(link.datagram(now), now)
            if now > count * MS and not any(link.backlog for link in links):
                return got, now // MS
        self.fail(f"seed {seed}: not all acknowledged after a minute")

    def test_at_40_percent_loss_doubled_and_reordered(self):
        for seed in range(support.scaled(10000)):
            got, _ = self.exchange(seed, 0.4)
            wanted = [str(number) for number in range(40)]
            self.assertEqual(got, [wanted, wanted], f"seed {seed}")

    def test_blobs_arrive_whole_at_40_percent_loss(self):
        for seed in range(support.scaled(50)):
            got, _ = self.exchange(seed, 0.4, size=2500, count=5)
            wanted = [str(number) + "x" * 2500 for number in range(5)]
            self.assertEqual(got, [wanted, wanted], f"seed {seed}")

    def test_no_datagram_is_longer_than_1200_bytes(self):
        link = Link(9, 0)
        for size in (0, 1, 50, 100, 900, 960, 980, 990, 5000):
            link.submit(numbered(2**60, size))
        link.seen, link._newest, link._inbox.applied, link._counter = 2**64 - 1, (1, 2**64 - 1), 2**64 - 1, 2**64 - 100
        longest = 0
        while link.backlog:
            data = link.datagram(2**63)
            longest = max(longest, len(data))
            link._outbox.acknowledge(stream_pb2.Packet.FromString(data[16:]).first, 0)
        self.assertLessEqual(longest, 1200)
        self.assertGreater(longest, 1000)


class Ahead(unittest.TestCase):
    LARGE = 300_000
    CHUNKS = -(-LARGE // 900)

    def upload(self, ahead, loss=0.0, seed=1):
        """Round trips of 1 ms that an Item of 300 kB takes to a server that takes so many Packets ahead, and how many were ever under way."""
        client, server = Link(9, 0), Link(9, 0)
        server._announces = False
        lost = Road(seed, loss, doubled=0.0, most_delay_ns=1)
        client.submit(numbered(0))
        most = 0
        for now in range(MS, 20_000 * MS, MS):
            client.receive(plain(client, now // MS, ack=server._inbox.applied, ahead=ahead), now)
            arrived = []
            for number in range(32):
                if client.due_ns() > now:
                    break
                lost.put(client.datagram(now), now - 32 + number)
            for data in lost.take(now):
                arrived += server.receive(data, now).items
            most = max(most, client._outbox._left - server._inbox.applied)
            if now == 2 * MS:
                client.submit(numbered(7, self.LARGE))
            elif arrived and now > MS:
                self.assertEqual(arrived[0][1], numbered(7, self.LARGE))
                return now // MS - 2, most
        self.fail(f"seed {seed}: not there after 20 s")

    def test_a_large_item_leaves_in_as_many_packets_at_once_as_the_server_takes(self):
        for ahead in (1, 8, 32, 1000):
            trips, _ = self.upload(ahead)
            self.assertLessEqual(trips, self.CHUNKS // min(ahead, 32) + 6, ahead)
            self.assertGreaterEqual(trips, self.CHUNKS // min(ahead, 32), ahead)

    def test_to_a_server_that_takes_none_ahead_one_packet_at_a_time_leaves(self):
        trips, most = self.upload(0)
        self.assertGreaterEqual(trips, self.CHUNKS)
        self.assertLessEqual(most, 1)

    def test_what_is_lost_is_repeated_with_all_behind_it(self):
        for seed in range(1, 1 + support.scaled(50)):
            trips, _ = self.upload(32, loss=0.1, seed=seed)
            self.assertLess(trips, 2 * self.CHUNKS, f"seed {seed}")


class Schedule(unittest.TestCase):
    def test_repeats_leave_1_3_7_15_31_ms_after_the_first_and_then_every_50_ms(self):
        link = Link(9, 0)
        link.submit(numbered(0))
        left = []
        for now in range(0, 300 * MS, MS // 4):
            if link.due_ns() <= now:
                link.datagram(now)
                left.append(now // MS)
        self.assertEqual(left, [0, 1, 3, 7, 15, 31, 81, 131, 181, 231, 281])

    def test_a_new_item_leaves_at_once(self):
        link = Link(9, 0)
        link.datagram(0)
        self.assertGreater(link.due_ns(), 40 * MS)
        link.submit(numbered(0))
        self.assertEqual(link.due_ns(), 0)

    def test_an_idle_link_keeps_itself_alive(self):
        link = Link(9, 0)
        link.datagram(0)
        self.assertLessEqual(link.due_ns(), 100 * MS)

    def test_a_new_item_is_acknowledged_within_10_ms(self):
        link = Link(9, 0)
        link.datagram(0)
        link.receive(plain(link, 0, items=[numbered(0)]), 20 * MS)
        self.assertLessEqual(link.due_ns(), 30 * MS)
        self.assertEqual(stream_pb2.Packet.FromString(link.datagram(20 * MS)[16:]).ack, 1)

    def test_sixteen_items_at_most_are_in_a_packet(self):
        link = Link(9, 0)
        for number in range(20):
            link.submit(numbered(number))
        packet = stream_pb2.Packet.FromString(link.datagram(0)[16:])
        self.assertEqual((packet.first, len(packet.items)), (1, 16))
        link.receive(plain(link, 0, ack=16), MS)
        packet = stream_pb2.Packet.FromString(link.datagram(MS)[16:])
        self.assertEqual((packet.first, len(packet.items)), (17, 4))


class Rules(unittest.TestCase):
    def test_1024_items_wait_and_one_more_becomes_bye_backlog(self):
        link = Link(9, 0)
        for number in range(1024):
            link.submit(numbered(number))
        with self.assertRaises(BacklogFull):
            link.submit(numbered(1024))
        self.assertEqual(link.backlog, 1025)
        self.assertEqual(link._outbox._waiting[-1].item.bye.reason, control_pb2.BYE_REASON_BACKLOG)
        with self.assertRaises(SessionLost):
            link.submit(numbered(1025))

    def test_items_that_come_early_are_skipped_until_their_turn(self):
        link = Link(9, 0)
        self.assertEqual(link.receive(plain(link, 0, first=2, items=[numbered(1)]), 0).items, [])
        self.assertIsNone(link.ended)
        self.assertLessEqual(link.due_ns(), 10 * MS)
        self.assertEqual(stream_pb2.Packet.FromString(link.datagram(0)[16:]).ack, 0)
        self.assertEqual(len(link.receive(plain(link, 1, first=1, items=[numbered(0)]), 0).items), 1)
        self.assertEqual(len(link.receive(plain(link, 2, first=2, items=[numbered(1)]), 0).items), 1)

    def test_what_is_taken_ahead_is_announced_until_the_server_is_heard(self):
        link = Link(9, 0)
        told = [stream_pb2.Packet.FromString(link.datagram(now)[16:]).ahead for now in range(3)]
        link.receive(plain(link, 0), 4)
        self.assertEqual((told, stream_pb2.Packet.FromString(link.datagram(5)[16:]).ahead), ([32, 32, 32], 0))

    def test_an_ack_of_what_was_never_sent_ends_the_session(self):
        link = Link(9, 0)
        link.submit(numbered(0))  # queued, but not yet sent
        link.receive(plain(link, 0, ack=1), 0)
        self.assertEqual(link.ended.reason, control_pb2.BYE_REASON_PROTOCOL_ERROR)

    def test_a_smaller_ack_than_before_means_nothing(self):
        outbox = Outbox()
        for number in range(3):
            outbox.add(numbered(number))
        outbox.sent(3, 0)
        outbox.acknowledge(2, 0)
        outbox.acknowledge(1, 0)
        self.assertEqual((outbox.first, len(outbox)), (3, 1))

    def test_pieces_out_of_place_are_errors(self):
        good = dict(blob=1, kind=1, offset=0, total=950, bytes=bytes(900))
        for change in (dict(blob=2), dict(offset=1), dict(total=899), dict(total=0), dict(total=4194305), dict(bytes=b""),
                       dict(bytes=bytes(901))):
            inbox = Inbox()
            with self.assertRaises(ProtocolError, msg=str(change)):
                inbox.take(stream_pb2.Packet(first=1, items=[stream_pb2.Item(chunk={**good, **change})]))
        inbox = Inbox()
        self.assertEqual(inbox.take(stream_pb2.Packet(first=1, items=[stream_pb2.Item(chunk=good)])), [])
        with self.assertRaises(ProtocolError):
            inbox.take(stream_pb2.Packet(first=2, items=[stream_pb2.Item(chunk=dict(good, blob=2))]))

    def test_a_blob_of_an_unknown_kind_is_an_item_without_a_body(self):
        chunk = dict(blob=1, kind=0, offset=0, total=3, bytes=b"abc")
        taken = Inbox().take(stream_pb2.Packet(first=1, items=[stream_pb2.Item(chunk=chunk)]))
        self.assertEqual(taken, [(1, stream_pb2.Item())])

    def test_a_packet_of_17_items_does_not_open(self):
        link = Link(9, 0)
        self.assertEqual(link.receive(plain(link, 0, items=[numbered(0)] * 17), 0).items, [])
        self.assertEqual(len(link.receive(plain(link, 0, items=[numbered(0)] * 16), 0).items), 16)

    def test_other_items_may_come_between_pieces(self):
        blob = numbered(0, 1500).SerializeToString()
        pieces = [dict(blob=1, kind=1, offset=offset, total=len(blob), bytes=blob[offset:offset + 900]) for offset in (0, 900)]
        items = [stream_pb2.Item(chunk=pieces[0]), numbered(7), stream_pb2.Item(chunk=pieces[1])]
        taken = Inbox().take(stream_pb2.Packet(first=1, items=items))
        self.assertEqual([item_id for item_id, _ in taken], [2, 3])
        self.assertEqual(taken[1][1], numbered(0, 1500))

    def test_a_changed_boot_id_ends_the_session(self):
        link = Link(9, 0)
        link.receive(plain(link, 0), 0)
        with self.assertRaises(SessionLost):
            link.receive(plain(link, 1, boot_id=2), 0)

    def test_a_body_that_does_not_open_blocks_no_counter(self):
        link = Link(9, 0)
        link.receive(wire.encode(wire.KIND_PLAIN, 9, 0, b"\xff\xff\xff"), 0)
        link.receive(plain(link, 0, first=0, items=[numbered(0)]), 0)
        self.assertEqual(len(link.receive(plain(link, 0, items=[numbered(0)]), 0).items), 1)
        self.assertEqual(len(link.receive(plain(link, 0, first=2, items=[numbered(1)]), 0).items), 0)

    def test_other_sessions_are_not_listened_to(self):
        link = Link(9, 0)
        self.assertEqual(link.receive(plain(Link(8, 0), 0, items=[numbered(0)]), 0).items, [])
        self.assertEqual(link.boot_id, 0)


class States(unittest.TestCase):
    def test_the_newest_wins_and_all_are_counted(self):
        link = Link(9, 0)
        self.assertEqual(shown(5, link, scene_id=1, tick=50).tick, 50)
        self.assertIsNone(shown(4, link, scene_id=1, tick=40))
        self.assertEqual(shown(6, link, scene_id=2, tick=1).tick, 1)
        self.assertIsNone(shown(3, link, scene_id=1, tick=60))
        packet = stream_pb2.Packet.FromString(link.datagram(0)[16:])
        self.assertEqual((packet.seen, packet.newest), (4, 1))

    def test_one_that_is_repeated_is_shown_once(self):
        link = Link(9, 0)
        self.assertIsNotNone(shown(0, link, scene_id=1, tick=64))
        self.assertIsNone(shown(1, link, scene_id=1, tick=64))
        self.assertEqual(link.seen, 2)

    def test_one_in_parts_is_shown_whole_in_any_order(self):
        link = Link(9, 0)
        parts = [dict(scene_id=1, tick=7, loop_state=4, part_index=index, part_count=2, tools=[dict(tool_id=index)]) for index in (0, 1)]
        self.assertIsNone(shown(1, link, **parts[1]))
        whole = shown(0, link, **parts[0])
        self.assertEqual([tool.tool_id for tool in whole.tools], [0, 1])
        self.assertEqual((whole.tick, whole.part_count, whole.part_index, whole.loop_state), (7, 0, 0, 4))

    def test_parts_of_different_ticks_are_not_mixed(self):
        link = Link(9, 0)
        self.assertIsNone(shown(0, link, scene_id=1, tick=7, part_index=0, part_count=2))
        self.assertIsNone(shown(1, link, scene_id=1, tick=8, part_index=1, part_count=2))
        self.assertIsNone(shown(2, link, scene_id=1, tick=7, part_index=1, part_count=2))
        self.assertGreater(ITEM_ROOM, 1000)

    def test_parts_that_no_tick_has_are_not_kept(self):
        link = Link(9, 0)
        for index in range(33):
            self.assertIsNone(shown(index, link, scene_id=1, tick=7, part_index=index, part_count=33))
        self.assertIsNone(shown(40, link, scene_id=1, tick=8, part_index=5, part_count=2))
        self.assertIsNone(shown(41, link, scene_id=1, tick=8, part_index=0, part_count=2))
        self.assertIsNotNone(shown(42, link, scene_id=1, tick=8, part_index=1, part_count=2))


if __name__ == "__main__":
    unittest.main()
