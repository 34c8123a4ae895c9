#!/usr/bin/python3
"""The reference firmware is proved: from the integer code of its source, as clang 14 compiles it with every check of its sanitizer for integers,
no check fails on any input, no access leaves its object, no cast loses bits, and the claims of README.md hold.

usage: firmware_proof_test.py FIRMWARE-FOLDER [FUNCTION...]
"""
import sys
import time

import proof


def main():
    folder, names = sys.argv[1], sys.argv[2:] or list(proof.CHECKS)
    failures = [f"the lemma {name} is not valid" for name in proof.failed_lemmas()]
    firmware = proof.Firmware(folder)
    total = 0
    for name in names:
        start = time.process_time()
        prover = firmware.prove(name)
        total += sum(prover.counts.values())
        failures += prover.failures
        print(f"{name}: {', '.join(f'{count} {how}' for how, count in sorted(prover.counts.items()))}; {time.process_time() - start:.1f} s", flush=True)
    print(f"{total} obligations")
    print("\n".join(failures))
    return 1 if failures or total == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
