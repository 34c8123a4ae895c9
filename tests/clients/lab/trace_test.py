"""A trace on disk: the table is read back by a reader that knows nothing of it, and has the same numbers."""
import csv
import pathlib
import tempfile
import unittest

import numpy
from lab_support import make_trace

COUNT = 50


class Csv(unittest.TestCase):
    def setUp(self):
        random = numpy.random.default_rng(5)
        self.force = random.normal(size=(COUNT, 3)) * 10.0 ** random.integers(-12, 3, size=(COUNT, 3))
        self.string = random.normal(size=(COUNT, 3))
        self.trace = make_trace(
            COUNT,
            force_n=self.force,
            p_wg_m=random.normal(size=(COUNT, 3)),
            q_wh=random.normal(size=(COUNT, 4)),
            cpu_us=numpy.where(numpy.arange(COUNT) % 7, random.uniform(5, 50, COUNT), numpy.nan),
            tick=numpy.arange(COUNT) + 12_345_678,
            object_force_n={"C2": self.string},
            regions={"C2": numpy.arange(COUNT) % 3},
        )
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "trace.csv"
            self.trace.write_csv(path)
            with open(path, newline="", encoding="utf-8") as file:
                rows = list(csv.reader(file))
        self.columns = {name: numpy.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}
        self.widths = {len(row) for row in rows}

    def same(self, name, expected):
        numpy.testing.assert_allclose(self.columns[name], expected, rtol=1e-8, atol=0.0, err_msg=name)

    def test_numbers_come_back_to_eight_digits(self):
        for i, axis in enumerate("xyz"):
            self.same(f"force_{axis}_n", self.force[:, i])
            self.same(f"p_wg_{axis}_m", self.trace.p_wg_m[:, i])
            self.same(f"force_of_C2_{axis}_n", self.string[:, i])
        for i, part in enumerate("wxyz"):
            self.same(f"q_wh_{part}", self.trace.q_wh[:, i])
        self.same("t_s", self.trace.t_s)
        self.same("regions_of_C2", self.trace.regions["C2"])

    def test_ticks_come_back_exactly(self):
        self.assertEqual(self.columns["tick"].tolist(), self.trace.tick.tolist())

    def test_what_was_not_measured_stays_not_a_number(self):
        self.same("cpu_us", self.trace.cpu_us)
        self.assertEqual(int(numpy.isnan(self.columns["cpu_us"]).sum()), len(range(0, COUNT, 7)))

    def test_every_row_has_every_column(self):
        self.assertEqual(len(self.widths), 1)
        self.assertEqual(len(self.columns["tick"]), COUNT)


class Touched(unittest.TestCase):
    def test_is_where_an_object_bears_force(self):
        force = numpy.zeros((4, 3))
        force[2, 1] = -0.1
        trace = make_trace(4, object_force_n={"C2": force})
        self.assertEqual(trace.touched("C2").tolist(), [False, False, True, False])
        self.assertEqual(trace.touched("nobody").tolist(), [False] * 4)


if __name__ == "__main__":
    unittest.main()
