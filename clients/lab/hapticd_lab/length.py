"""Lengths on a command line."""
import argparse
import re

METRES = {"": 1.0, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}


def length(text: str) -> float:
    """A length in m, as 0.34mm, or a plain number of metres."""
    found = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)", text)
    if found and found[2] in METRES:
        return float(found[1]) * METRES[found[2]]
    if re.fullmatch(r"[-+]?\d+,\d+\s*[a-z]*", text):
        raise argparse.ArgumentTypeError(f"{text} has a decimal comma; write {text.replace(',', '.')}")
    raise argparse.ArgumentTypeError(f"{text} is no length; write 0.34mm, or metres without a unit")
