"""The notebook of the Python client, executed by Jupyter against the daemon in virtual time. Its numbers are compared with closed forms: Hooke's
law of the coupling, the statics of a string, equal temperament. It is stored without outputs.

usage: notebook_test.py [PICTURE]      also writes the notebook's plot there"""
import base64
import json
import os
import pathlib
import sys
import tempfile
import unittest

import nbclient
import nbformat

import daemon

NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "clients" / "python" / "examples" / "first_pluck.ipynb"
TOLD = """import json
print(json.dumps(dict(force_n=force_n.tolist(), stretch_m=stretch_m.tolist(), hand_m=table["p_wh_m"].tolist(), path=path.tolist(), kt=coupling.kt_n_per_m,
                      tension_n=string.tension_n, length_m=abs(string.p_wb_m[0] - string.p_wa_m[0]), hz=tone["frequency_hz"].tolist(),
                      phases=touch["phase"].tolist(), peaks_n=list(peaks_n.values()),
                      deflection_m=[sum(each**2 for each in state.strings[0].deflection_w_m) ** 0.5 if state.strings else 0 for state in result.states])))"""


def pictures(notebook):
    return [output["data"]["image/png"] for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})]


class Notebook(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stored = nbformat.read(NOTEBOOK, as_version=4)
        notebook = nbformat.from_dict(json.loads(json.dumps(cls.stored)))
        notebook.cells.append(nbformat.v4.new_code_cell(TOLD))
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        os.environ.update(IPYTHONDIR=folder, JUPYTER_RUNTIME_DIR=folder, MPLCONFIGDIR=folder)
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string") as played:
            os.environ["HAPTICD_ADDRESS"] = played.address
            cls.executed = nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": folder}}).execute()
        cls.told = json.loads(cls.executed.cells[-1].outputs[0]["text"])
        cls.files = sorted(path.name for path in pathlib.Path(folder, "first_pluck").iterdir())

    def test_it_is_stored_without_outputs_and_is_well_formed(self):
        nbformat.validate(self.stored)
        self.assertTrue(all(not cell.get("outputs") and cell.get("execution_count") is None for cell in self.stored.cells))

    def test_the_hand_goes_where_it_was_sent(self):
        for row, (hand, sent) in enumerate(zip(self.told["hand_m"], self.told["path"], strict=True)):
            self.assertTrue(all(abs(a - b) < 1e-9 for a, b in zip(hand, sent)), row)

    def test_the_force_is_that_of_the_spring_and_of_the_string(self):
        told = self.told
        peak = max(range(len(told["force_n"])), key=lambda row: told["force_n"][row])
        self.assertGreater(told["force_n"][peak], 0.1)
        self.assertEqual(max(told["force_n"][:350]), 0)
        touched = [row for row, force in enumerate(told["force_n"]) if force > 0.2 * told["force_n"][peak]]
        self.assertGreater(len(touched), 20)
        for row in touched:
            # The string swings about that: a wave of the speed v of its foot bears v sqrt(T mu).
            self.assertAlmostEqual(told["force_n"][row], told["kt"] * told["stretch_m"][row], delta=0.15 * told["force_n"][peak])
        mean = sum(told["force_n"][row] for row in touched)
        self.assertAlmostEqual(mean, sum(told["kt"] * told["stretch_m"][row] for row in touched), delta=0.01 * mean)
        self.assertAlmostEqual(mean, sum(4 * told["tension_n"] * told["deflection_m"][row] / told["length_m"] for row in touched), delta=0.01 * mean)

    def test_the_tone_is_the_string_s_note_and_one_touch_begins_and_ends(self):
        self.assertEqual(len(self.told["hz"]), 1)
        self.assertAlmostEqual(self.told["hz"][0], 440 * 2 ** (-33 / 12), delta=0.05)
        self.assertEqual(self.told["phases"], ["BEGIN", "END"])

    def test_twice_the_tension_resists_as_two_springs_in_series_do(self):
        def stiffness(tension_n):
            return 1 / (1 / self.told["kt"] + self.told["length_m"] / (4 * tension_n))
        first, second = self.told["peaks_n"]
        self.assertAlmostEqual(second / first, stiffness(60) / stiffness(30), delta=0.02)
        self.assertAlmostEqual(first, max(self.told["force_n"]), delta=1e-6)

    def test_there_is_a_plot_and_the_files_that_it_says(self):
        (picture,) = pictures(self.executed)
        self.assertGreater(len(base64.b64decode(picture)), 10000)
        if len(sys.argv) > 1:
            pathlib.Path(sys.argv[1]).write_bytes(base64.b64decode(picture))
        self.assertEqual(self.files, ["contact.csv", "fault.csv", "string_radius.csv", "string_sounding.csv", "tone.csv", "tool_0.csv"])


if __name__ == "__main__":
    sys.exit(unittest.main(argv=sys.argv[:1], verbosity=2))
