// Enabling, watchdog, latches and commands of the reference core; see hapticd_device.h.
#include <stddef.h>
#include <string.h>

#include "hapticd_device.h"

_Static_assert(sizeof(HapState) == 64, "layout");
_Static_assert(sizeof(HapCommand) == 32, "layout");
_Static_assert(sizeof(HapAffine) == 64, "layout");
_Static_assert(sizeof(HapCapabilities) == 64, "layout");
_Static_assert(sizeof(HapConfig) == 16, "layout");
_Static_assert(sizeof(HapCalibration) == 8, "layout");
_Static_assert(offsetof(HapState, grip) == 48 && offsetof(HapState, load) == 61, "layout");
_Static_assert(offsetof(HapCapabilities, pos_res_nm) == 50, "layout");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "reports are little-endian");
_Static_assert((kHapHistory & (kHapHistory - 1)) == 0, "seq modulo the history");

enum { kShortestWatchdog = 2, kLongestWatchdog = 100, kMicrosecondsPerMs = 1000 };
enum { kAgeUnit = 10, kOldAge = kHapOldest * kAgeUnit };

bool hap_init(HapDevice* device, const HapSettings* settings) {
  memset(device, 0, sizeof *device);
  device->settings = *settings;
  HapCapabilities* caps = &device->settings.capabilities;
  caps->id = kHapCapabilitiesId;
  caps->ver_major = kHapVersionMajor;
  caps->ver_minor = kHapVersionMinor;
  caps->magic = kHapMagic;
  if (device->settings.affine_k_max_npm == 0) device->settings.affine_k_max_npm = caps->k_max_npm;
  HapSettings* gains = &device->settings;
  if (gains->affine_b_max_mnspm == 0) gains->affine_b_max_mnspm = kHapMostDamping;
  if (gains->affine_kr_max_mnmprad == 0) gains->affine_kr_max_mnmprad = kHapMostTurnStiffness;
  if (gains->affine_br_max_10unmsprad == 0) gains->affine_br_max_10unmsprad = kHapMostTurnDamping;
  hap_default_config(device);
  device->calibration.id = kHapCalibrationId;
  // A report before the first measurement is one all the same.
  device->now.quat_q30[0] = 1 << 30;
  device->now.temp_c = 0xFF;
  const bool sound = caps->in_rate_hz != 0 && caps->wd_max_ms >= kShortestWatchdog &&
                     caps->wd_max_ms <= kLongestWatchdog &&
                     caps->wd_default_ms >= kShortestWatchdog &&
                     caps->wd_default_ms <= caps->wd_max_ms && caps->f_cont_cn <= caps->f_peak_cn &&
                     caps->tau_cont_mnm <= caps->tau_peak_mnm;
  device->sound = sound;
  if (!sound) device->faults = kHapInternal;
  return sound;
}

void hap_disable(HapDevice* device) {
  device->enabled = false;
  device->saturated = false;
  device->active = false;
}

/// Force was on when the bus went away: the host has to know, and to clear it.
static void lose_bus(HapDevice* device) {
  if (device->enabled) {
    device->watchdog = true;
    device->faults |= kHapUsb;
  }
  hap_disable(device);
}

void hap_bus_reset(HapDevice* device) {
  lose_bus(device);
  hap_default_config(device);
  device->enable_seen = false;
  device->command_seen = false;
  device->has_waiting = false;
}

static void watch_time(HapDevice* device, uint32_t now_us) {
  const uint32_t age = now_us - device->command_us;
  if (age > (uint32_t)kOldAge) device->command_old = true;
  const uint32_t most = (uint32_t)device->config.wd_ms * kMicrosecondsPerMs;
  if (device->enabled && (device->command_old || age >= most)) {
    device->watchdog = true;
    hap_disable(device);
  }
}

static bool is_stopped(const HapDevice* device) {
  const bool needs_hand = (device->settings.capabilities.caps & kHapHasDeadMan) != 0;
  return !device->sound || !device->bus_ready || device->watchdog ||
         (device->faults & ~kHapBadCommand) != 0 || device->now.emergency_stop ||
         (needs_hand && !device->now.dead_man_held) || !hap_is_calibrated(device);
}

static bool is_too_fast(const HapDevice* device) {
  const uint16_t cap = device->config.v_cap_mmps;
  if (cap == kHapNoSpeedCap) return false;
  int64_t square = 0;
  for (int i = 0; i < 3; ++i) square += (int64_t)device->now.vel[i] * device->now.vel[i];
  const int64_t most = 10 * (int64_t)cap;  // in units of vel
  return square > most * most;
}

/// No component of a unit quaternion is longer than 1; with this bound no product overflows.
static void check_orientation(HapMeasurement* now) {
  const int32_t most = (1 << 30) + (1 << 16);
  for (int i = 0; i < 4; ++i) {
    if (now->quat_q30[i] >= -most && now->quat_q30[i] <= most) continue;
    memset(now->quat_q30, 0, sizeof now->quat_q30);
    now->quat_q30[0] = 1 << 30;
    now->faults |= kHapEncoder;
  }
}

void hap_servo(HapDevice* device, uint32_t now_us, const HapMeasurement* measurement,
               HapOutput* output) {
  device->now = *measurement;
  device->now.faults &= (uint16_t)~kHapBadCommand;
  check_orientation(&device->now);
  if (device->bus_ready && !measurement->bus_ready) lose_bus(device);
  device->bus_ready = measurement->bus_ready;
  watch_time(device, now_us);
  device->faults |= device->now.faults;
  if (device->enabled && is_too_fast(device)) device->faults |= kHapOverSpeed;
  if (device->enabled && is_stopped(device)) hap_disable(device);
  hap_evaluate(device, output);
}

/// No force, torque, grip or gain: the only kind of command that enables.
static bool is_zero(const HapAffine* affine) {
  int64_t any = affine->base.grip_mn;
  for (int i = 0; i < 3; ++i) {
    any |= affine->base.force_un[i] | affine->base.torque_unm[i];
    any |= affine->b_mnspm[i] | affine->kr_mnmprad[i] | affine->br_10unmsprad[i];
  }
  for (int i = 0; i < 6; ++i) any |= affine->k_npm[i];
  return any == 0;
}

/// The pose of the report a command was computed from; false if it is forgotten.
static bool recall(const HapDevice* device, uint16_t seq, HapPose* pose) {
  *pose = device->history[seq & (kHapHistory - 1)];
  return pose->valid && pose->seq == seq;
}

static void obey(HapDevice* device) {
  const uint8_t flags = device->command.base.flags;
  if ((flags & kHapClearFault) != 0) {
    hap_disable(device);
    device->enable_seen = false;
    device->watchdog = false;
    device->faults = device->sound ? device->now.faults : kHapInternal;
  } else if ((flags & kHapEnable) == 0) {
    hap_disable(device);
    device->enable_seen = false;
  } else if (!device->enable_seen) {
    // Only the first ENABLE after a command without it counts: nothing starts by itself again.
    device->enable_seen = true;
    device->enabled = !is_stopped(device) && is_zero(&device->command);
  }
}

bool hap_take_command(HapDevice* device, uint32_t now_us, const uint8_t* report, uint32_t length) {
  watch_time(device, now_us);
  HapAffine next;
  memset(&next, 0, sizeof next);
  memcpy(&next, report, length);
  if (device->command_seen && next.base.seq == device->command.base.seq) return true;
  HapPose reference;
  memset(&reference, 0, sizeof reference);
  if (next.base.id == kHapAffineId) {
    if (!hap_affine_is_sound(device, &next)) return false;
    if (!recall(device, next.base.ref_seq, &reference)) return false;
  }
  device->command = next;
  device->reference = reference;
  device->command_us = now_us;
  device->command_seen = true;
  device->command_old = false;
  obey(device);
  return true;
}
