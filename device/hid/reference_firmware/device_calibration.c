// Calibration of the reference core; see hapticd_device.h. Forces are off while it runs; what the
// sensors need is the maker's, who learns from hap_take_calibration what the host wants.
#include <string.h>

#include "hapticd_device.h"

enum { kPercent = 100, kPoseAxes = 0x3F, kGripAxis = 0x40, kGripSensed = 1 << 12 };

/// All the device needs is calibrated.
static bool is_complete(const HapDevice* device) {
  const uint16_t needed = device->settings.calibration_axes;
  return (device->calibrated_axes & needed) == needed;
}

bool hap_is_calibrated(const HapDevice* device) {
  if (device->calibration.state == kHapRunning) return false;
  return (device->settings.capabilities.caps & kHapNeedsCalibration) == 0 || is_complete(device);
}

/// Those of `mask` that are sensed; of 0, all.
static uint16_t axes_of(const HapDevice* device, uint16_t mask) {
  const uint16_t dof = device->settings.capabilities.dof;
  const int sensed = (dof & kPoseAxes) | ((dof & kGripSensed) != 0 ? kGripAxis : 0);
  return (uint16_t)(mask == 0 ? sensed : sensed & mask);
}

static void set_state(HapDevice* device, uint8_t state) {
  device->calibration.state = state;
  device->calibration.progress = state == kHapCalibrationOk ? kPercent : 0;
  device->calibration.axis_mask = device->calibrated_axes;
}

static void settle(HapDevice* device) {
  const bool ok = device->calibrated_axes != 0 && is_complete(device);
  set_state(device, ok ? kHapCalibrationOk : kHapNotCalibrated);
}

bool hap_set_calibration(HapDevice* device, const uint8_t* report) {
  HapCalibration wanted;
  memcpy(&wanted, report, sizeof wanted);
  const uint16_t axes = axes_of(device, wanted.axis_mask);
  const bool running = device->calibration.state == kHapRunning;
  switch (wanted.op) {
    case kHapStart:
      hap_disable(device);
      device->running_axes = axes;
      set_state(device, kHapRunning);
      break;
    case kHapZeroHere:
      if (running) return false;
      hap_disable(device);
      device->calibrated_axes |= axes;
      settle(device);
      break;
    case kHapAbort:
      if (running) settle(device);
      break;
    case kHapStore:
      if (device->calibration.state != kHapCalibrationOk) return false;
      break;
    default:
      return false;
  }
  device->calibration.op = wanted.op;
  device->calibration_asked = wanted.op;
  device->calibration_about = axes;
  return true;
}

uint8_t hap_take_calibration(HapDevice* device, uint16_t* axes) {
  const uint8_t op = device->calibration_asked;
  *axes = device->calibration_about;
  device->calibration_asked = 0;
  return op;
}

void hap_calibration_progress(HapDevice* device, uint8_t percent) {
  if (device->calibration.state != kHapRunning) return;
  device->calibration.progress = percent < kPercent ? percent : kPercent;
}

void hap_calibration_end(HapDevice* device, bool ok) {
  if (device->calibration.state != kHapRunning) return;
  if (ok) {
    device->calibrated_axes |= device->running_axes;
    settle(device);
    return;
  }
  device->calibrated_axes &= (uint16_t)~device->running_axes;
  set_state(device, kHapCalibrationFailed);
}
