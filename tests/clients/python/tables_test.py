"""Tables of States and events, with numpy and without: numbers are written out here, units are read from the comments of the .proto files, and
files are read by the csv module. What pandas and xarray make is tried where they are."""
import csv
import importlib.util
import math
import os
import pathlib
import random
import re
import struct
import tempfile
import unittest
from unittest import mock

import support
import hapticd
from hapticd import tables, values
from hapticd.v1 import event_pb2, state_pb2

PROTOS = pathlib.Path(support.ROOT) / "proto" / "hapticd" / "v1"
SYMBOLS = {"m": "m", "1": "1", "N": "N", "Hz": "Hz", "s": "s", "m/s": "m/s", "cents": "cents", "ns": "ns", "index": "1", "id": "1", "tick": "1",
           "N and N m": "N, N m"}


def plain(column):
    return column.tolist() if hasattr(column, "tolist") else column


def units_of(message, file):
    """{field: unit} of a message, as the comments of its .proto file say."""
    text = (PROTOS / file).read_text(encoding="utf-8")
    body = re.search(rf"^message {message} \{{\n(.*?)^\}}", text, re.DOTALL | re.MULTILINE)[1]
    body = re.sub(r"\n *// ", " ", body)
    return {name: SYMBOLS[unit] for unit, name in re.findall(r"\[([^;\]]+);[^\n]*\]\n *(?:repeated |optional )?\w+ (\w+) = \d+;", body)
            if unit in SYMBOLS}


def states(count=3):
    made = [state_pb2.State(tick=tick, t_ns=tick * 10**9, tools=[dict(
        tool_id=3, p_wh_m=[tick, 0.5, -1], q_wh=[1, 0, 0, 0], p_wg_m=[tick, 0.25, -1], q_wg=[1, 0, 0, 0], wrench_h_w=[0, tick, 0, 0, 0, 0.5],
        minimum_gap_m=0.125)]) for tick in range(count)]
    return [*made, state_pb2.State(tick=9, tools=[dict(tool_id=1)])]


def events():
    tone = event_pb2.Tone(t_ns=1_500_000_000, string_index=2, frequency_hz=65.5, level=0.5, partials=[1, 0.5])
    touch = event_pb2.Contact(t_ns=10**9, phase=1, tool_id=1, string_index=0, p_wc_m=[1, 2, 3], nhat_og_w=[0, 1, 0], force_n=0.25, ringing=True)
    other = event_pb2.Contact(t_ns=2 * 10**9, phase=2, body_index=4, p_wc_m=[4, 5], nhat_og_w=[0, 1, 0])
    return [hapticd.Event("contact", touch), hapticd.Event("tone", tone), hapticd.Event("contact", other)]


class WithAndWithoutNumpy(unittest.TestCase):
    def both(self, check):
        check()
        if values.numpy is not None:
            with mock.patch.object(values, "numpy", None):
                check()

    def test_a_table_has_a_row_per_state_with_the_tool(self):
        def check():
            table = hapticd.table(states(), tool_id=3)
            self.assertEqual(table.rows, 3)
            self.assertEqual(plain(table["tick"]), [0, 1, 2])
            self.assertEqual(plain(table["t_s"]), [0.0, 1.0, 2.0])
            self.assertEqual(plain(table["p_wh_m"]), [[0, 0.5, -1], [1, 0.5, -1], [2, 0.5, -1]])
            self.assertEqual(plain(table["p_wg_m"])[1], [1, 0.25, -1])
            self.assertEqual(plain(table["wrench_h_w"])[2], [0, 2, 0, 0, 0, 0.5])
            self.assertEqual(plain(table["minimum_gap_m"]), [0.125] * 3)
            with self.assertRaises(KeyError):
                table["nothing"]
        self.both(check)

    def test_what_is_no_tool_or_kind_is_refused_with_those_there_are(self):
        for bad in ("hnd", None, 3.0):
            with self.assertRaisesRegex(ValueError, "is no tool_id: .*there are 1, 3"):
                hapticd.table(states(), bad)
        with self.assertRaisesRegex(ValueError, r"Did you mean event_table\('tone'\)\?"):
            hapticd.table(states(), "tones")
        with self.assertRaisesRegex(ValueError, r"tone, contact.*Did you mean contact\?"):
            hapticd.event_table(events(), "contct")
        self.assertEqual(hapticd.table(states(), 7).rows, 0)

    def test_a_row_of_the_wrong_length_is_not_a_number(self):
        def check():
            broken = states()
            del broken[1].tools[0].p_wh_m[2]
            rows = plain(hapticd.table(broken, 3)["p_wh_m"])
            self.assertEqual(rows[0], [0, 0.5, -1])
            self.assertTrue(all(math.isnan(number) for number in rows[1]) and len(rows[1]) == 3)
        self.both(check)

    def test_events_of_one_kind_are_a_table_too(self):
        def check():
            touches = hapticd.event_table(events(), "contact")
            self.assertEqual(plain(touches["t_s"]), [1.0, 2.0])
            self.assertEqual(plain(touches["phase"]), ["BEGIN", "END"])
            self.assertEqual(plain(touches["string_index"]), [0, -1])
            self.assertEqual(plain(touches["body_index"]), [-1, 4])
            self.assertEqual(plain(touches["p_wc_m"])[0], [1, 2, 3])
            self.assertTrue(math.isnan(plain(touches["p_wc_m"])[1][0]))
            self.assertEqual(plain(touches["ringing"]), [True, False])
            tones = hapticd.event_table(events())
            self.assertEqual((plain(tones["frequency_hz"]), plain(tones["string_index"])), ([65.5], [2]))
            self.assertNotIn("partials", tones)
            self.assertEqual(hapticd.event_table(events(), "fault").rows, 0)
            for kind in ("lease_info", "Tone", "", None):
                with self.assertRaisesRegex(ValueError, "is none of tone, contact, string_radius, string_sounding, fault"):
                    hapticd.event_table(events(), kind)
        self.both(check)

    def test_units_are_those_of_the_wire_format(self):
        wanted = units_of("ToolState", "state.proto")
        units = hapticd.table(states(), 3).units
        self.assertEqual({name: unit for name, unit in units.items() if name not in ("tick", "t_s")},
                         {name: wanted[name] for name in units if name not in ("tick", "t_s")})
        self.assertEqual((units["tick"], units["t_s"]), ("1", "s"))
        for kind, message in (("tone", "Tone"), ("contact", "Contact"), ("string_radius", "StringRadius"), ("fault", "Fault")):
            wanted = units_of(message, "event.proto")
            self.assertGreaterEqual(len(wanted), 3, message)
            units = hapticd.event_table([], kind).units
            self.assertEqual(units.pop("t_s"), "s")
            self.assertLessEqual(set(wanted) - {"t_ns", "partials"}, set(units))
            for name, unit in units.items():
                if name in wanted:
                    self.assertEqual(unit, wanted[name], f"{kind}.{name}")
                else:
                    self.assertIn(unit, ("", "1"), f"{kind}.{name}")

    def test_a_file_has_names_units_and_the_same_bits(self):
        draw = random.Random(20261126)
        numbers = [struct.unpack("<d", struct.pack("<Q", draw.getrandbits(64)))[0] for _ in range(3 * support.scaled(2000))]
        numbers += [0.1, -0.0, 5e-324, 1.7976931348623157e308, math.inf, -math.inf]
        made = [state_pb2.State(tick=2**53 + row, tools=[dict(p_wh_m=numbers[row:row + 3])]) for row in range(0, len(numbers), 3)]

        def check():
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "table.csv"
                hapticd.table(made).to_csv(path)
                with open(path, newline="", encoding="utf-8") as file:
                    header, *rows = csv.reader(file)
            self.assertEqual(header[:7], ["tick [1]", "t_s [s]", "minimum_gap_m [m]", "p_wh_m_x [m]", "p_wh_m_y [m]", "p_wh_m_z [m]", "q_wh_w [1]"])
            self.assertEqual(header[-6:], [f"wrench_h_w_{each}" for each in ("fx [N]", "fy [N]", "fz [N]", "tx [N m]", "ty [N m]", "tz [N m]")])
            read = [float(text) for row in rows for text in row[3:6]]
            for got, wanted in zip(read, numbers, strict=True):
                self.assertTrue(struct.pack("<d", got) == struct.pack("<d", wanted) or math.isnan(got) and math.isnan(wanted), wanted)
            self.assertEqual([int(row[0]) for row in rows], [state.tick for state in made])
        self.both(check)

    def test_a_table_without_rows_has_its_columns(self):
        def check():
            table = hapticd.table([])
            self.assertEqual((table.rows, len(table)), (0, 8))
            with tempfile.TemporaryDirectory() as folder:
                table.to_csv(os.path.join(folder, "empty.csv"))
                self.assertEqual(pathlib.Path(folder, "empty.csv").read_text(encoding="utf-8").count("\n"), 1)
        self.both(check)


class FieldOf7:
    """A field as protobuf 7 describes it: `is_repeated`, and no `label`."""

    def __init__(self, field):
        self._field, self.is_repeated = field, field.name in ("p_wc_m", "nhat_og_w")

    def __getattr__(self, name):
        if name == "label":
            raise AttributeError(name)
        return getattr(self._field, name)


class Protobuf7(unittest.TestCase):
    def test_a_table_of_contacts_has_its_vectors(self):
        described = mock.Mock()
        fields = [FieldOf7(field) for field in event_pb2.DESCRIPTOR.message_types_by_name["Contact"].fields]
        described.DESCRIPTOR.message_types_by_name = {"Contact": mock.Mock(fields=fields)}
        with mock.patch.object(tables, "event_pb2", described):
            table = hapticd.event_table(events(), "contact")
        self.assertEqual(plain(table["p_wc_m"])[0], [1, 2, 3])
        self.assertEqual(plain(table["nhat_og_w"]), [[0, 1, 0], [0, 1, 0]])
        self.assertEqual(plain(table["force_n"]), [0.25, 0])
        self.assertEqual(plain(table["string_index"]), [0, -1])


class Numpy(unittest.TestCase):
    def test_a_structured_array_has_a_field_per_column(self):
        made = hapticd.table(states(), 3).to_numpy()
        self.assertEqual(made.shape, (3,))
        self.assertEqual(made["wrench_h_w"].shape, (3, 6))
        self.assertEqual(made[2]["p_wh_m"].tolist(), [2, 0.5, -1])
        self.assertEqual(hapticd.table([]).to_numpy()["p_wh_m"].shape, (0, 3))
        self.assertEqual(hapticd.event_table(events(), "contact").to_numpy()["phase"].tolist(), ["BEGIN", "END"])


class Missing(unittest.TestCase):
    def test_what_is_not_installed_is_named_with_its_package(self):
        table = hapticd.table(states(), 3)
        for name, call in (("pandas", table.to_pandas), ("xarray", table.to_xarray), ("numpy", table.to_numpy)):
            with mock.patch.dict("sys.modules", {name: None}), self.assertRaisesRegex(ModuleNotFoundError, f"^{name} is not installed.*python3-{name}$"):
                call()


@unittest.skipUnless(importlib.util.find_spec("pandas") and importlib.util.find_spec("xarray"), "needs python3-pandas and python3-xarray")
class Peers(unittest.TestCase):
    def test_pandas_has_a_column_per_number_and_their_units(self):
        frame = hapticd.table(states(), 3).to_pandas()
        self.assertEqual(frame.shape, (3, 23))
        self.assertEqual(frame["wrench_h_w_fy"].tolist(), [0, 1, 2])
        self.assertEqual(frame.attrs["units"]["wrench_h_w_tz"], "N m")
        self.assertEqual(frame.attrs["units"]["p_wg_m_x"], "m")

    def test_xarray_has_variables_along_time_with_their_units(self):
        for made, rows in ((hapticd.table(states(), 3), 3), (hapticd.table([]), 0)):
            found = made.to_xarray()
            self.assertEqual(found.sizes["t_s"], rows)
            self.assertEqual(found["p_wh_m"].attrs["units"], "m")
            self.assertEqual(list(found["p_wh_m_component"].values), ["x", "y", "z"])
        found = hapticd.table(states(), 3).to_xarray()
        self.assertEqual(float(found["wrench_h_w"].sel(t_s=2.0, wrench_h_w_component="fy")), 2.0)


if __name__ == "__main__":
    unittest.main()
