"""The report: what it says of claims, verdicts and files, that it needs no other file, and that texts cannot break it."""
import csv
import html.parser
import pathlib
import re
import tempfile
import unittest

from hapticd_lab import plots, report
from hapticd_lab.figure import OURS, REPRODUCED, DEVIATES, Figure, Spec, at_least, at_most
from hapticd_lab.outcome import Outcome, write_claims, write_figure
from lab_support import make_outcome, make_trace

FACTS = {"processor": "a fine one, 2 cores", "commit": "0123456789ab"}
NASTY = 'a | b <script>alert("1")</script> & c'


class Reader(html.parser.HTMLParser):
    """Text by section, sources of pictures, links, and whether tags are closed in their order."""

    VOID = {"meta", "img", "link", "br"}

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.pictures, self.links, self.texts, self.tags = [], [], [], [], [], set()
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.tags.add(tag)
        if tag not in self.VOID:
            self.open.append(tag)
        if "id" in values:
            self.ids.append(values["id"])
        if tag == "img":
            self.pictures.append(values["src"])
        if tag == "a":
            self.links.append(values["href"])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.texts.append(data)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.texts))


def figure():
    """With a run, a picture, a table, a note and one claim of each kind."""
    made = Figure("F13", "Contact switch", "F_x goes to zero at the switch")
    made.runs["paper"] = make_trace(100)
    made.claims = [
        at_most("force after the switch", 0.0123, 0.5, "N", "from MODEL"),
        at_least("torque ratio", 2.5, 3.0, "", NASTY, OURS),
    ]
    made.pictures["extra.png"] = "An extra picture"
    made.tables["A table"] = [["speed", NASTY], ["1.2 m/s", "7"]]
    made.notes.append("A paragraph.")
    return made


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            output = pathlib.Path(folder)
            (output / "F13").mkdir()
            plots.lines("x", [plots.Panel("x", "y", [plots.Line("", [0, 1], [0, 1])])]).save(output / "F13" / "extra")
            outcome = write_figure(figure(), Spec("F13", "", "", None), output / "F13")
            cls.outcomes = [outcome, make_outcome("F16", [at_most("c", 1.0, 2.0, "N")], verdict=REPRODUCED), make_outcome("F17", error=NASTY)]
            report.write(cls.outcomes, FACTS, output, ["F13", "F16", "F17", "F18"])
            cls.html = (output / "report.html").read_text(encoding="utf-8")
            cls.markdown = (output / "report.md").read_text(encoding="utf-8")
            cls.files = {str(path.relative_to(output)) for path in output.rglob("*") if path.is_file()}
        cls.page = Reader(cls.html)

    def test_both_say_what_the_claims_say(self):
        for claim in self.outcomes[0].claims + self.outcomes[1].claims:
            for text in (claim.text, claim.measured, claim.demanded, claim.verdict, claim.note):
                printed = report._pretty(text)
                self.assertIn(re.sub(r"\s+", " ", printed).strip(), self.page.text)
                self.assertIn(report._cell(text), self.markdown)

    def test_both_have_every_figure_with_its_verdict_and_what_deviates(self):
        for outcome in self.outcomes:
            row = re.search(rf"\| \[{outcome.id}\].*", self.markdown)[0]
            self.assertIn(f"{report.MARKS[outcome.verdict]} {outcome.verdict} |", row)
            self.assertIn(outcome.id, self.page.ids)
        self.assertIn("deviates: torque ratio", re.search(r"\| \[F13\].*", self.markdown)[0])
        self.assertEqual(self.outcomes[0].verdict, DEVIATES)
        for text in (self.page.text, self.markdown):
            self.assertIn("1 reproduced, 1 deviates, 1 failed", text)

    def test_machine_notes_tables_and_what_is_missing_are_there(self):
        for text in (self.page.text, self.markdown):
            for expected in (
                "a fine one, 2 cores",
                "0123456789ab",
                "A paragraph.",
                "A table",
                "An extra picture",
                "1.2 m/s",
                "Not finished: F18",
            ):
                self.assertIn(expected, text)

    def test_both_say_that_nothing_was_read_off_images(self):
        for text in (self.page.text, self.markdown):
            self.assertRegex(text, r"figures are images: nothing was read off them")

    def test_the_page_needs_no_other_file(self):
        self.assertEqual(len(self.page.pictures), 2)
        self.assertTrue(all(each.startswith("data:image/") for each in self.page.pictures))
        self.assertFalse(self.page.tags & {"script", "link", "iframe", "object"})
        self.assertNotIn("url(", self.html.split("</style>")[0])

    def test_links_lead_to_files_that_are_there(self):
        links = [each for each in self.page.links if not each.startswith(("#", "https:"))]
        links += [each for each in re.findall(r"\]\(([^)#]+)\)", self.markdown)]
        self.assertLessEqual({"F13/paper.csv", "F13/claims.csv", "F13/plot.svg", "F13/plot.png"}, set(links))
        self.assertLessEqual({each for each in links if each.startswith("F13")}, self.files)

    def test_no_text_breaks_the_page_or_a_table(self):
        self.assertNotIn("<script", self.html)
        self.assertNotIn("<script", self.markdown.replace(NASTY, ""))
        for table in re.findall(r"(?:^\|.*\n)+", self.markdown, re.MULTILINE):
            columns = {len(re.split(r"(?<!\\)\|", line)) for line in table.splitlines()}
            self.assertEqual(len(columns), 1, table)


class ClaimsTable(unittest.TestCase):
    def test_has_a_row_a_claim_and_the_number_in_full(self):
        third = 1.0 / 3.0
        outcome = Outcome("F1", "", "", [at_most("a, b", third, 1.0, "N", "note"), at_most("c", 2.0, 1.0, "m", "why")])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "claims.csv"
            write_claims(path, [outcome, outcome])
            with open(path, newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 4)
        self.assertEqual((rows[0]["figure"], rows[0]["claim"], rows[0]["verdict"], rows[0]["unit"]), ("F1", "a, b", "reproduced", "N"))
        self.assertEqual(float(rows[0]["value"]), third)
        self.assertEqual((rows[1]["value"], rows[1]["verdict"]), ("2.0", "deviates"))


if __name__ == "__main__":
    unittest.main()
