"""Headers, the window of counters and the worked datagrams of PROTOCOL.md section 16, which are the truth here."""
import random
import unittest

from google.protobuf import text_format

import support
from hapticd import wire
from hapticd.errors import SessionLost
from hapticd.link import Link
from hapticd.v1 import control_pb2, stream_pb2


class WorkedDatagrams(unittest.TestCase):
    def test_all_three_are_found(self):
        self.assertEqual(len(support.worked_datagrams()), 3)

    def test_they_are_read_as_the_document_says(self):
        for session, counter, text, data in support.worked_datagrams():
            datagram = wire.decode(data)
            self.assertEqual((datagram.kind, datagram.session, datagram.counter), (wire.KIND_PLAIN, session, counter))
            self.assertEqual(stream_pb2.Packet.FromString(datagram.body), text_format.Parse(text, stream_pb2.Packet()))

    def test_they_are_written_byte_for_byte(self):
        for session, counter, text, data in support.worked_datagrams():
            packet = text_format.Parse(text, stream_pb2.Packet())
            self.assertEqual(wire.encode(wire.KIND_PLAIN, session, counter, packet.SerializeToString()), data)

    def test_a_new_link_says_the_first_of_them_byte_for_byte_and_what_it_takes_ahead(self):
        session, _, _, data = support.worked_datagrams()[0]
        link = Link(session, 1_000_000)
        subscribe, acquire = stream_pb2.Item(), stream_pb2.Item()
        subscribe.subscribe.divisor = 10
        subscribe.subscribe.sections.extend([control_pb2.SECTION_TOOLS, control_pb2.SECTION_CONTACTS])
        acquire.acquire.holder = "demo"
        self.assertEqual([link.submit(subscribe), link.submit(acquire)], [1, 2])
        self.assertLessEqual(link.due_ns(), 1_000_000)
        ahead = stream_pb2.Packet(ahead=32).SerializeToString()
        self.assertEqual(link.datagram(1_000_000), data + ahead)

    def test_a_link_applies_the_second_once_its_items_are_due(self):
        session, _, text, data = support.worked_datagrams()[1]
        link = Link(session, 0)
        for _ in range(2):
            ping = stream_pb2.Item()
            ping.ping.SetInParent()
            link.submit(ping)
        link.datagram(0)
        before = stream_pb2.Packet(first=1, boot_id=0xC0FFEE11)
        for _ in range(6):
            before.items.add().result.item_id = 1
        link.receive(wire.encode(wire.KIND_PLAIN, session, 0, before.SerializeToString()), 0)
        arrived = link.receive(data, 21_000_000)
        whole = text_format.Parse(text, stream_pb2.Packet())
        self.assertEqual(arrived.items, [(7, whole.items[0])])
        self.assertEqual(arrived.state, whole.state)
        self.assertEqual(link.backlog, 0)
        # Round trip (21 - 1) - (20.5 - 5) = 4.5 ms, offset ((5 - 1) + (20.5 - 21)) / 2 = 1.75 ms. Its error is half the round trip, and the
        # 500 ppm that no skew exceeds of the 10 ms since the middle of the exchange.
        self.assertEqual(link.clock.estimate()[:3], (1_750_000, 2_250_000 + 5_000 + 1, 4_500_000))

    def test_the_third_ends_a_session_whatever_its_counter(self):
        session, _, _, data = support.worked_datagrams()[2]
        link = Link(session, 0)
        link.receive(wire.encode(wire.KIND_PLAIN, session, 0, stream_pb2.Packet(first=1, boot_id=1).SerializeToString()), 0)
        with self.assertRaises(SessionLost):
            link.receive(data, 1)


class Header(unittest.TestCase):
    def test_every_broken_header_is_dropped(self):
        good = wire.encode(wire.KIND_PLAIN, 7, 3, b"\x10\x01")
        self.assertIsNotNone(wire.decode(good))
        for place in range(4):
            for bit in range(8):
                bad = bytearray(good)
                bad[place] ^= 1 << bit
                self.assertIsNone(wire.decode(bytes(bad)), f"byte {place} bit {bit}")

    def test_lengths_are_16_to_1200(self):
        self.assertIsNone(wire.decode(wire.encode(wire.KIND_PLAIN, 7, 3, b"")[:15]))
        self.assertIsNotNone(wire.decode(wire.encode(wire.KIND_PLAIN, 7, 3, b"")))
        full = wire.encode(wire.KIND_PLAIN, 7, 3, bytes(1184))
        self.assertIsNotNone(wire.decode(full))
        self.assertIsNone(wire.decode(full + b"\0"))
        with self.assertRaises(ValueError):
            wire.encode(wire.KIND_PLAIN, 7, 3, bytes(1185))


class Counters(unittest.TestCase):
    def test_the_window_agrees_with_a_set_of_all_that_came(self):
        for seed in range(support.scaled(200)):
            chance = random.Random(seed)
            window, came, largest = wire.CounterWindow(), set(), -1
            counter = 0
            for _ in range(400):
                counter = max(0, counter + chance.choice((1, 1, 1, -1, -30, 40, 2047, -2047, 2048, -2048, 5000)))
                expected = counter not in came and counter > largest - 2048
                self.assertEqual(window.is_new(counter), expected, f"seed {seed} counter {counter}")
                if expected and chance.random() < 0.8:  # a datagram that does not open marks nothing
                    window.mark(counter)
                    came.add(counter)
                    largest = max(largest, counter)


if __name__ == "__main__":
    unittest.main()
