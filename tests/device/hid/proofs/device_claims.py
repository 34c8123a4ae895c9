"""The claims of the functions that a maker calls. Each keeps the invariant of the device, whatever the inputs; together with hap_init, which
makes it, it holds for ever. Beside it stand the claims of single functions: what resets, what enables, what the motors are given."""
from arithmetic import bit_and
from contracts import at_most, holds, sound_gains, square_sum, term, within
from executor import new_state
from state import Summary, Unsupported
from terms import Int, Raw, all_of, both, compare, either, exact, implies, negate

# No component of an orientation is larger, Q30: device_core.c refuses more.
ORIENTATION = (1 << 30) + (1 << 16)
# As in hapticd_device.h: kHapRunning, kHapBadCommand, kHapNoSpeedCap, kHapResetSpeedCap.
RUNNING, BAD_COMMAND, NO_SPEED_CAP, RESET_SPEED_CAP = 1, 256, 0xFFFF, 3000
# Of the reports that hap_receive takes: kHapCommandId, kHapAffineId, kHapConfigId, kHapCalibrationId.
IDS = (0x02, 0x03, 0x11, 0x12)
CAPS = ("wd_ms", "f_cap_cn", "tau_cap_mnm", "v_cap_mmps")
LIMITS = ("affine_b_max_mnspm", "affine_kr_max_mnmprad", "affine_br_max_10unmsprad", "affine_k_max_npm", "grip_peak_mn")
CAPABILITIES = ("caps", "dof", "wd_default_ms", "wd_max_ms", "f_peak_cn", "tau_peak_mnm")
GAINS = [f"{name}[{i}]" for name, count in (("k_npm", 6), ("b_mnspm", 3), ("kr_mnmprad", 3), ("br_10unmsprad", 3)) for i in range(count)]
WRENCH = [f"{name}[{i}]" for name in ("force_un", "torque_unm") for i in range(3)]
FLAGS = ("enabled", "sound", "bus_ready", "watchdog", "enable_seen", "command_seen", "command_old", "now.emergency_stop", "now.dead_man_held")
CHANGED = ("saturated", "active")
FIELDS = [("HapDevice", field) for field in [
    *FLAGS, *CHANGED, "faults", "command_us", "calibrated_axes", "settings.calibration_axes", "history", "calibration.state", "calibration.progress",
    *(f"config.{name}" for name in (*CAPS, "grav_comp")),
    *(f"settings.{name}" for name in LIMITS), *(f"settings.capabilities.{name}" for name in CAPABILITIES),
    *(f"{part}.quat_q30[{i}]" for part in ("now", "reference") for i in range(4)), *(f"now.vel[{i}]" for i in range(3)),
    *(f"command.{gain}" for gain in GAINS), *(f"command.base.{name}" for name in (*WRENCH, "grip_mn", "flags", "id"))]]
FIELDS += [("HapAffine", gain) for gain in GAINS] + [("HapOutput", field) for field in (*WRENCH, "grip_mn", "motors_on", "brake", "gravity")]
FIELDS += [("HapPose", f"quat_q30[{i}]") for i in range(4)]


class View:
    """An object of one structure, as it is in one state."""

    def __init__(self, executor, state, layout, struct="HapDevice", name="device", prefix=""):
        self.executor, self.state, self.layout, self.struct, self.name, self.prefix = executor, state, layout, struct, name, prefix

    def load(self, field):
        offset, size = self.layout[self.struct, self.prefix + field]
        return self.state.memory[self.name].load(offset, size)

    def signed(self, field):
        return self.state.narrowed(self.executor.prover.signed(self.load(field)))

    def unsigned(self, field):
        return self.state.narrowed(self.executor.prover.unsigned(self.load(field)))

    def flag(self, field):
        value = self.load(field)
        return self.executor.prover.truth(value)

    def limit(self, field):
        return View(self.executor, self.state, self.layout).unsigned(f"settings.{field}")

    def gains(self):
        return View(self.executor, self.state, self.layout, prefix="command.")


def equals(value, number):
    return compare("eq", value, exact(number, value.width))


def has_bit(value, bit):
    return holds(term(value) / (1 << bit) % 2 == 1) if not value.lo == value.hi else bool(value.lo >> bit & 1)


def invariant(view):
    """[(what, condition)] that holds between any two calls."""
    enabled, settings = view.flag("enabled"), "settings.capabilities."
    found = [("the orientation is bounded", within(view.signed(f"{part}.quat_q30[{i}]"), -ORIENTATION, ORIENTATION))
             for part in ("now", "reference") for i in range(4)]
    found += [("the force cap is within the peak", at_most(view.unsigned("config.f_cap_cn"), view.unsigned(settings + "f_peak_cn"))),
              ("the torque cap is within the peak", at_most(view.unsigned("config.tau_cap_mnm"), view.unsigned(settings + "tau_peak_mnm"))),
              ("progress is at most 100", at_most(view.unsigned("calibration.progress"), exact(100, 8)))]
    watchdog = [at_most(exact(2, 16), view.unsigned(field)) for field in ("config.wd_ms", settings + "wd_default_ms")]
    watchdog += [at_most(view.unsigned(field), view.unsigned(settings + "wd_max_ms")) for field in ("config.wd_ms", settings + "wd_default_ms")]
    watchdog.append(at_most(view.unsigned(settings + "wd_max_ms"), exact(100, 16)))
    found.append(("the watchdog is within its range", implies(view.flag("sound"), all_of(watchdog))))
    faults = view.unsigned("faults")
    free = [view.flag("sound"), view.flag("bus_ready"), negate(view.flag("watchdog")), negate(view.flag("now.emergency_stop")),
            negate(equals(view.unsigned("calibration.state"), RUNNING)), either(equals(faults, 0), equals(faults, BAD_COMMAND)),
            view.flag("enable_seen"), view.flag("command_seen")]
    found += [("nothing that prevents it holds while it is enabled", implies(enabled, cond)) for cond in free]
    gains = view.gains()
    gains.limit = view.limit
    return found + [("the gains in force are sound", cond) for cond in sound_gains(gains)]


def device_in(executor, layout, assumed=True):
    """A state with a device of which only the invariant is known."""
    state, types = new_state(), executor.module.types
    start, size = layout["HapDevice", "history"]
    stride = types["%struct.HapPose"].size()
    bounds = {layout["HapPose", f"quat_q30[{i}]"][0]: (4, -ORIENTATION, ORIENTATION) for i in range(4)}
    device = state.add("device", types["%struct.HapDevice"].size(), "raw", Summary(start, stride, size // stride, bounds))
    for _, cond in invariant(View(executor, state, layout)) if assumed else ():
        state.assume(cond)
    return state, device


def kept(executor, layout, before, after, name):
    """What holds of every call: the invariant, settings that stay, caps that only fall while enabled, and no enabling but by a command."""
    old, new = View(executor, before, layout), View(executor, after, layout)
    found = invariant(new)
    for field in [*LIMITS, *(f"capabilities.{name}" for name in CAPABILITIES)]:
        found.append(("the settings stay", compare("eq", new.unsigned(f"settings.{field}"), old.unsigned(f"settings.{field}"))))
    was, is_now = old.flag("enabled"), new.flag("enabled")
    for cap in CAPS:
        found.append((f"{cap} only falls while enabled",
                      implies(both(was, is_now), at_most(new.unsigned(f"config.{cap}"), old.unsigned(f"config.{cap}")))))
    begins = both(is_now, negate(was))
    if name not in ("hap_receive", "hap_receive_split"):
        return found + [("nothing enables but a command", negate(begins))]
    flags = new.unsigned("command.base.flags")
    zero = [equals(new.signed(f"command.base.{field}"), 0) for field in (*WRENCH, "grip_mn")]
    zero += [equals(new.signed(f"command.{gain}"), 0) for gain in GAINS]
    zero += [has_bit(flags, 0), negate(has_bit(flags, 1)), negate(old.flag("enable_seen"))]
    return found + [("only a first ENABLE with a zero command enables", implies(begins, cond)) for cond in zero]


def reset(executor, layout, after):
    """Config as by default, disabled."""
    new, caps = View(executor, after, layout), "settings.capabilities."
    return [("a reset disables", negate(new.flag("enabled"))), ("a reset watches the speed", equals(new.unsigned("config.v_cap_mmps"), RESET_SPEED_CAP)),
            ("a reset forgets commands", negate(new.flag("command_seen")))] + [
        ("a reset sets Config", compare("eq", new.unsigned(f"config.{cap}"), new.unsigned(caps + name)))
        for cap, name in (("wd_ms", "wd_default_ms"), ("f_cap_cn", "f_peak_cn"), ("tau_cap_mnm", "tau_peak_mnm"))]


def motors(executor, layout, after):
    """What the motors are given."""
    device, out = View(executor, after, layout), View(executor, after, layout, "HapOutput", "output")
    enabled, dof = device.flag("enabled"), device.unsigned("settings.capabilities.dof")
    flags, caps = device.unsigned("command.base.flags"), device.unsigned("settings.capabilities.caps")
    wrench = {name: [out.signed(f"{name}[{i}]") for i in range(3)] for name in ("force_un", "torque_unm")}
    zero = [equals(value, 0) for values in wrench.values() for value in values]
    grip = out.signed("grip_mn")
    found = [("disabled, nothing is given", either(enabled, cond)) for cond in
             (*zero, equals(grip, 0), *(negate(out.flag(name)) for name in ("motors_on", "brake", "gravity")))]
    for name, cap, unit, first in (("force_un", "f_cap_cn", 10_000, 6), ("torque_unm", "tau_cap_mnm", 1000, 9)):
        most = term(device.unsigned(f"config.{cap}")) * unit
        found.append((f"{name} is within its cap", holds(square_sum(wrench[name]) <= most * most)))
        found += [(f"{name}: an axis that is not driven gets nothing", either(has_bit(dof, first + i), equals(wrench[name][i], 0))) for i in range(3)]
    found += [("a brake leaves no force", either(negate(has_bit(flags, 2)), cond)) for cond in (*zero, equals(grip, 0))]
    most = device.unsigned("settings.grip_peak_mn")
    found += [("the grip is within its peak", both(at_most(grip, most), holds(-term(grip) <= term(most)))),
              ("no grip without GRIP", either(has_bit(flags, 3), equals(grip, 0))),
              ("a brake only where there is one", implies(out.flag("brake"), has_bit(caps, 3))),
              ("gravity only where Config asks for it", implies(out.flag("gravity"), negate(equals(device.unsigned("config.grav_comp"), 0))))]
    return found


def watched(executor, layout, after, now):
    """What a servo cycle leaves enabled is young, slow enough, held and calibrated."""
    device, prover = View(executor, after, layout), executor.prover
    command = prover.unsigned(device.load("command_us"))
    age = (term(now) - term(command)) % (1 << 32)
    young = holds(age < 1000 * term(device.unsigned("config.wd_ms")))
    cap = device.unsigned("config.v_cap_mmps")
    slow = holds(square_sum([device.signed(f"now.vel[{i}]") for i in range(3)]) <= 100 * term(cap) * term(cap))
    enabled, caps, needed = device.flag("enabled"), device.unsigned("settings.capabilities.caps"), device.unsigned("settings.calibration_axes")
    calibrated = compare("eq", bit_and(prover, device.unsigned("calibrated_axes"), needed), needed)
    return [("a dead-man let go stops it", implies(enabled, either(negate(has_bit(caps, 2)), device.flag("now.dead_man_held")))),
            ("a missing calibration stops it", implies(enabled, either(negate(has_bit(caps, 1)), calibrated))),
            ("the watchdog stops it in time", implies(enabled, young)), ("a command too old stops it", implies(enabled, negate(device.flag("command_old")))),
            ("the speed cap stops it", implies(enabled, either(equals(cap, NO_SPEED_CAP), slow)))]


def prove_all(executor, state, name, claims):
    executor.prover.prove_all(state, [(f"{name}: {label}", cond) for label, cond in claims])


def call(executor, layout, name, arguments, extra=None, begin=None):
    """Executes a function on any device; arguments: names of objects with their size, or Raw numbers. begin: what more is known of these."""
    state, device = device_in(executor, layout)
    given = [device]
    for argument in arguments:
        given.append(state.add(*argument) if isinstance(argument, tuple) else argument)
    if begin:
        begin(state)
    before = state.copy()
    for after, result in executor.execute(state, name, given, merge=False):
        prove_all(executor, after, name, kept(executor, layout, before, after, name) + (extra(after, result) if extra else []))


def check_init(executor, layout):
    state, device = device_in(executor, layout, assumed=False)
    settings = state.add("settings", executor.module.types["%struct.HapSettings"].size(), "raw")
    for after, _ in executor.execute(state, "hap_init", [device, settings], merge=False):
        prove_all(executor, after, "hap_init", invariant(View(executor, after, layout)) + reset(executor, layout, after))


def evaluate(layout):
    """The contract of hap_evaluate within hap_servo: it changes what the motors are given and two flags. The invariant that check_evaluate starts
    from is shown of hap_servo's end, and speaks of nothing that is changed here."""
    def contract(executor, state, arguments):
        executor.activations += 1
        output = state.memory[arguments[1].object]
        state.writable(output.name).cover(0, output.size, "element", (executor.activations, {}))
        for flag in CHANGED:
            state.writable("device").store(*layout["HapDevice", flag], Raw(f"{flag}{executor.activations}", 8))
        return [(state, None)]
    return contract


def check_evaluate(executor, layout):
    """What the motors are given, and that nothing else changes."""
    places = {layout["HapDevice", flag][0] for flag in CHANGED}

    def claims(after, _):
        device = after.memory["device"]
        return motors(executor, layout, after) + [("only two flags change", set(device.cells) <= places and not device.layers)]
    call(executor, layout, "hap_evaluate", [("output", executor.module.types["%struct.HapOutput"].size(), "raw")], claims)


def check_servo(executor, layout):
    now = executor.prover.named("now_us", 0, (1 << 32) - 1, 32)
    types = executor.module.types
    call(executor, layout, "hap_servo", [now, ("measurement", types["%struct.HapMeasurement"].size(), "raw"),
                                         ("output", types["%struct.HapOutput"].size(), "raw")],
         lambda after, _: watched(executor, layout, after, now))


def check_receive(executor, layout):
    """Each kind of report by itself, by its ID."""
    length = executor.prover.named("length", 0, (1 << 32) - 1, 32)
    report = Raw("report+0:1", 8)

    def begin(state, number):
        if number is not None:
            state.writable("report").store(0, 1, exact(number, 8))
        else:
            state.assume(all_of(negate(equals(executor.prover.unsigned(report), other)) for other in IDS))
    for number in (*IDS, None):
        call(executor, layout, "hap_receive", [Raw("now_us", 32), ("report", length, "raw"), length],
             begin=lambda state, number=number: begin(state, number))


def receive(layout):
    """The contract of hap_receive within hap_receive_split: called on a device that nothing has changed, with a report whose bytes are all there,
    it does what check_receive shows. So there is nothing left to show of what it returns with."""
    def contract(executor, state, arguments):
        prover, pointer, length = executor.prover, arguments[2], state.narrowed(executor.prover.unsigned(arguments[3]))
        held, device = state.memory[pointer.object], state.memory["device"]
        if pointer.offset or device.cells or device.layers:
            raise Unsupported("hap_receive: called in the midst of something")
        there = held.size if held.base else written(held, state.marks.get("copied"))
        there = there if isinstance(there, Int) else exact(there, 64)
        prover.prove(state, at_most(length, there), "hap_receive is called with bytes that are not there")
        return []
    return contract


def written(held, copied):
    """How many bytes from the first on were written: byte 0, and then what was copied."""
    if copied is None or copied[:2] != (held.name, 1) or 0 not in held.cells:
        return 0
    return Int(copied[2].term + 1, copied[2].lo + 1, copied[2].hi + 1, 64)


def check_split(executor, layout):
    length = executor.prover.named("length", 0, (1 << 32) - 1, 32)
    call(executor, layout, "hap_receive_split", [Raw("now_us", 32), Raw("id", 8), ("report", length, "raw"), length])


def check_feature(executor, layout):
    room = executor.prover.named("room", 0, (1 << 32) - 1, 32)
    call(executor, layout, "hap_get_feature", [Raw("id", 8), ("report", room, "raw"), room])


CHECKS = {
    "hap_init": check_init, "hap_evaluate": check_evaluate, "hap_servo": check_servo, "hap_receive": check_receive, "hap_get_feature": check_feature,
    "hap_receive_split": check_split,
    "hap_bus_reset": lambda executor, layout: call(executor, layout, "hap_bus_reset", [], lambda after, _: reset(executor, layout, after)),
    "hap_sample": lambda executor, layout: call(executor, layout, "hap_sample", []),
    "hap_take_report": lambda executor, layout: call(executor, layout, "hap_take_report", [("report", 64, "raw")]),
    "hap_take_calibration": lambda executor, layout: call(executor, layout, "hap_take_calibration", [("axes", 2, "raw")]),
    "hap_calibration_progress": lambda executor, layout: call(executor, layout, "hap_calibration_progress", [Raw("percent", 8)]),
    "hap_calibration_end": lambda executor, layout: call(executor, layout, "hap_calibration_end", [Raw("ok", 1)])}
