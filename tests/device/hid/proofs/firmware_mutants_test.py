#!/usr/bin/python3
"""The proof of the firmware can fail: each of these changes of its source, in a copy, is refuted by the claims of the function named.

usage: firmware_mutants_test.py FIRMWARE-FOLDER [--further]
"""
import sys
import time

import proof
from prover import NotProved, Prover
from state import Unsupported

# What holds is shown with these; no need to search long for what does not.
FEWER_STEPS = 1_000_000
# (file, what stands there, what is put there, the function whose claims must fail)
MUTANTS = [
    ("device_force.c", "next <= UINT32_MAX && next * next", "next * next", "root_up"),
    ("device_force.c", "root * root < square ? root + 1 : root", "root", "root_up"),
    ("device_force.c", "const int64_t xx = (int64_t)k_npm[0] + kRoundedNpm;", "const int64_t xx = (int64_t)k_npm[0] + 3;", "hap_affine_is_sound"),
    ("device_force.c", "enum { kRoundedNpm = 2 };", "enum { kRoundedNpm = 0 };", "hap_affine_is_sound"),
    ("device_force.c", "- xy * (xy * zz - yz * xz)", "+ xy * (xy * zz - yz * xz)", "hap_affine_is_sound"),
    ("device_force.c", "if (affine->b_mnspm[row] > most->affine_b_max_mnspm) return false;", "", "hap_affine_is_sound"),
    ("device_force.c", "sum += entry < 0 ? -entry : entry;", "sum += entry;", "hap_affine_is_sound"),
    ("device_force.c", "if (!device->enabled) return;", "", "hap_evaluate"),
    ("device_core.c", "if (device->enabled && is_stopped(device)) hap_disable(device);", "", "hap_servo"),
    ("device_core.c", "age >= most)", "age > most)", "hap_servo"),
    ("device_core.c", "device->enabled = !is_stopped(device) && is_zero(&device->command);", "device->enabled = !is_stopped(device);",
     "hap_receive"),
    ("device_core.c", "if (!hap_affine_is_sound(device, &next)) return false;", "", "hap_receive"),
    ("device_core.c", "device->history[seq & (kHapHistory - 1)]", "device->history[seq & kHapHistory]", "hap_receive"),
    ("device_reports.c", "wanted.v_cap_mmps = at_most(wanted.v_cap_mmps, config->v_cap_mmps);", "", "hap_receive"),
    ("device_reports.c", "device->config.v_cap_mmps = kHapResetSpeedCap;", "device->config.v_cap_mmps = kHapNoSpeedCap;", "hap_bus_reset"),
    ("device_calibration.c", "hap_disable(device);\n      device->running_axes", "device->running_axes", "hap_receive"),
    ("device_core.c", "caps->wd_default_ms <= caps->wd_max_ms && ", "", "hap_init"),
    ("device_reports.c", "device->history[device->seq & (kHapHistory - 1)]", "device->history[device->seq & kHapHistory]", "hap_sample"),
    ("device_reports.c", "if (length >= sizeof whole) {", "if (length > sizeof whole) {", "hap_receive_split"),
    ("device_reports.c", "memcpy(whole + 1, bytes, length);", "", "hap_receive_split"),
    ("device_reports.c", "if (room < length) return 0;", "", "hap_get_feature"),
    ("device_calibration.c", "percent < kPercent ? percent : kPercent", "percent", "hap_calibration_progress"),
    ("device_calibration.c", "kHapCalibrationOk ? kPercent : 0;", "kHapCalibrationOk ? 101 : 0;", "hap_calibration_end"),
]
# Those that take longer, or are much like one above: run by hand.
FURTHER = [
    ("device_force.c", "v[i] > INT32_MAX || v[i] < -INT32_MAX", "v[i] > INT32_MAX", "clamp"),
    ("device_force.c", "v[i] = v[i] * most / length;", "v[i] = -v[i] * most / length;", "clamp"),
    # Of the three with a diagonal above zero any two are enough, so that only without two of them too much is taken.
    ("device_force.c", "|| xx * zz < xz * xz || yy * zz < yz * yz) return false;", ") return false;", "hap_affine_is_sound"),
    ("device_force.c", "grip = grip > 0 ? most : -most;", "grip = grip > 0 ? most : grip;", "hap_evaluate"),
    ("device_force.c", "(int64_t)device->config.tau_cap_mnm * kMicroPerMilli", "(int64_t)device->config.tau_cap_mnm * 1001", "hap_evaluate"),
    ("device_core.c", "const int32_t most = (1 << 30) + (1 << 16);", "const int32_t most = (1 << 30) + (1 << 17);", "hap_servo"),
    ("device_core.c", "return square > most * most;", "return square > most * most + 1;", "hap_servo"),
    ("device_reports.c", "config->f_cap_cn = at_most(wanted.f_cap_cn, caps->f_peak_cn);", "config->f_cap_cn = wanted.f_cap_cn;", "hap_receive"),
]


def survives(firmware, file, old, new, name):
    """Whether the claims hold with this change; where the proof cannot follow, it does not claim to hold."""
    start = time.process_time()
    try:
        firmware.changed(file, old, new).prove(name, Prover(FEWER_STEPS, patient=False))
        found = None
    except (NotProved, Unsupported) as reason:
        found = reason
    print(f"{file}: {new or 'without ' + old}: {found or 'HOLDS'}; {time.process_time() - start:.1f} s", flush=True)
    return found is None


def main():
    firmware, tried = proof.Firmware(sys.argv[1]), FURTHER if sys.argv[2:] == ["--further"] else MUTANTS
    alive = [mutant for mutant in tried if survives(firmware, *mutant)]
    print(f"{len(tried)} changes, {len(alive)} of them not refuted")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
