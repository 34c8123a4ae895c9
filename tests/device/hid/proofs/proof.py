"""Puts a proof together: the firmware of a folder, the contracts, and the claims of one function."""
import copy
import pathlib
import shutil
import sys
import tempfile

import contracts
import device_claims
import firmware
import lemmas
import numeric_claims
from executor import Executor
from prover import Prover

# What wraps on purpose: clocks, the counter of reports, and a mask that is inverted and cast.
WRAPS = {("watch_time", "difference"), ("age_of", "difference"), ("hap_sample", "conversion"), ("hap_calibration_end", "conversion")}
CHECKS = {**numeric_claims.CHECKS, **device_claims.CHECKS}
# Each function is followed branch by branch in Python's own stack.
DEEPEST = 20_000


class Firmware:
    """device/hid/reference_firmware, or what folder has in its place."""

    def __init__(self, folder):
        sys.setrecursionlimit(DEEPEST)
        self.folder = pathlib.Path(folder)
        with tempfile.TemporaryDirectory() as scratch:
            self.files = {name: firmware.read_file(folder, name, scratch) for name in firmware.SOURCES}
            self.layout = firmware.Layout(folder, scratch, device_claims.FIELDS)
        self.module = firmware.joined(self.files.values())

    def changed(self, name, old, new):
        """The same with one change in one file, made in a copy."""
        text = (self.folder / name).read_text(encoding="utf-8")
        if text.count(old) != 1:
            raise ValueError(f"{name} has {text.count(old)} times: {old}")
        made = copy.copy(self)
        with tempfile.TemporaryDirectory() as scratch:
            for header in self.folder.glob("*.h"):
                shutil.copy(header, scratch)
            pathlib.Path(scratch, name).write_text(text.replace(old, new), encoding="utf-8")
            made.files = {**self.files, name: firmware.read_file(scratch, name, scratch)}
        made.module = firmware.joined(made.files.values())
        return made

    def prove(self, name, prover=None):
        """The prover, with its counts and failures, after all claims of one function."""
        prover = prover or Prover()
        held = {"root_up": contracts.root_up, "clamp": contracts.clamp,
                "hap_affine_is_sound": contracts.affine_is_sound(lambda executor, state, pointer: numeric_claims.GainsView(
                    executor, state, self.layout, pointer))}
        held["hap_evaluate"] = device_claims.evaluate(self.layout)
        if name == "hap_receive_split":
            held["hap_receive"] = device_claims.receive(self.layout)
        # A function is not shown by what it is to show.
        held.pop(name, None)
        executor = Executor(self.module, prover, held, contracts.CUTS, WRAPS)
        CHECKS[name](executor, self.layout)
        return prover


def failed_lemmas():
    return [name for name, shown in lemmas.all_valid().items() if not shown]
