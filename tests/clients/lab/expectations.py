"""Which claims may deviate: read from expected_deviations.txt, and held against what a run found."""
import csv
import pathlib
from collections import namedtuple

Expected = namedtuple("Expected", "figure claim reason")


def read(path):
    """Lines FIGURE | BEGINNING OF THE CLAIM | REASON; # begins a comment. ValueError for a line without a reason, or one that comes twice."""
    found = []
    for number, line in enumerate(pathlib.Path(path).read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        words = [word.strip() for word in line.split(" | ")]
        if len(words) != 3 or not all(words) or any((each.figure, each.claim) == tuple(words[:2]) for each in found):
            raise ValueError(f"{path}:{number}: wants FIGURE | BEGINNING OF THE CLAIM | REASON, once")
        found.append(Expected(*words))
    return found


def read_claims(path):
    """Rows of a claims.csv."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def differences(claims, expected, figures=None):
    """What is not as expected, a sentence each. `figures`: ids that were made, where not all were."""
    matched = {each: 0 for each in expected if figures is None or each.figure in figures}
    found = []
    for row in claims:
        if row["verdict"] != "deviates":
            continue
        of_row = [each for each in matched if each.figure == row["figure"] and row["claim"].startswith(each.claim)]
        for each in of_row:
            matched[each] += 1
        if not of_row:
            found.append(f"{row['figure']}: deviates unexpectedly: {row['claim']}: {row['measured']}, wants {row['demanded']}. {row['note']}")
    found += [f"{each.figure}: no longer deviates: {each.claim}" for each, count in matched.items() if count == 0]
    return found
