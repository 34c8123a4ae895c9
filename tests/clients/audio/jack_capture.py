#!/usr/bin/python3
"""Captures what a JACK port plays, block by block with the instant at which JACK says it began, until its input ends; then writes all of it to
its output, pickled: for jack_rig.py, which reads it. Uses JACK_DEFAULT_SERVER. usage: jack_capture.py PORT"""
import ctypes
import pickle
import sys
import time

RATE = 48000
NO_START, IS_INPUT, PLAYBACK = 0x01, 0x1, 1


def library():
    jack = ctypes.CDLL("libjack.so.0")
    pointer, unsigned = ctypes.c_void_p, ctypes.c_uint32
    for name, result, arguments in (
            ("jack_client_open", pointer, [ctypes.c_char_p, ctypes.c_int, pointer]),
            ("jack_port_register", pointer, [pointer, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_ulong, ctypes.c_ulong]),
            ("jack_port_get_buffer", pointer, [pointer, unsigned]), ("jack_port_by_name", pointer, [pointer, ctypes.c_char_p]),
            ("jack_port_get_latency_range", None, [pointer, ctypes.c_int, pointer]), ("jack_activate", ctypes.c_int, [pointer]),
            ("jack_connect", ctypes.c_int, [pointer, ctypes.c_char_p, ctypes.c_char_p]), ("jack_client_close", ctypes.c_int, [pointer]),
            ("jack_set_process_callback", ctypes.c_int, [pointer, pointer, pointer]),
            ("jack_get_time", ctypes.c_uint64, []),
            ("jack_get_cycle_times", ctypes.c_int, [pointer, pointer, pointer, pointer, pointer])):
        getattr(jack, name).restype, getattr(jack, name).argtypes = result, arguments
    return jack


class Recorder:
    """Records what `port` plays, from its construction on."""

    def __init__(self, port):
        self.port, self.blocks = port.encode(), []
        self.jack = library()
        self.client = self.jack.jack_client_open(b"capture", NO_START, None)
        if not self.client:
            sys.exit("no JACK server to capture from")
        self.input = self.jack.jack_port_register(self.client, b"in", b"32 bit float mono audio", IS_INPUT, 0)
        self.callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_uint32, ctypes.c_void_p)(self.process)
        self.jack.jack_set_process_callback(self.client, ctypes.cast(self.callback, ctypes.c_void_p), None)
        self.jack.jack_activate(self.client)
        if self.jack.jack_connect(self.client, self.port, b"capture:in") != 0:
            sys.exit(f"there is no port {port}")

    def process(self, count, _):
        frame, begin_us, next_us, period_us = ctypes.c_uint32(), ctypes.c_uint64(), ctypes.c_uint64(), ctypes.c_float()
        self.jack.jack_get_cycle_times(self.client, *(ctypes.byref(each) for each in (frame, begin_us, next_us, period_us)))
        buffer = self.jack.jack_port_get_buffer(self.input, count)
        self.blocks.append((begin_us.value, ctypes.string_at(buffer, 4 * count)))
        return 0

    def latency_s(self):
        """From the port to the ear, as JACK has it."""
        range_ = (ctypes.c_uint32 * 2)()
        self.jack.jack_port_get_latency_range(self.jack.jack_port_by_name(self.client, self.port), PLAYBACK, range_)
        return range_[1] / RATE

    def clock_s(self):
        """CLOCK_MONOTONIC minus JACK's clock, which no one disciplines."""
        looks = []
        for _ in range(50):
            before_ns, jack_us, after_ns = time.monotonic_ns(), self.jack.jack_get_time(), time.monotonic_ns()
            looks.append((after_ns - before_ns, (before_ns + after_ns) * 0.5e-9 - jack_us * 1e-6))
        return min(looks)[1]

    def end(self):
        """From the begin of a block by JACK's clock to the ear by CLOCK_MONOTONIC, s; the blocks."""
        to_ear_s = self.latency_s() + self.clock_s()
        self.jack.jack_client_close(self.client)
        return to_ear_s, self.blocks


def main():
    recorder = Recorder(sys.argv[1])
    sys.stdout.buffer.write(b"captures\n")
    sys.stdout.flush()
    sys.stdin.read()
    pickle.dump(recorder.end(), sys.stdout.buffer)


if __name__ == "__main__":
    main()
