// State, feature reports and calibration of the reference core; see hapticd_device.h.
#include <string.h>

#include "hapticd_device.h"

enum { kShortestWatchdog = 2, kAgeUnit = 10 };

static const uint8_t kDescriptorHead[] = {
    0x06, 0x48, 0xFF,                                       // usage page FF48
    0x09, 0x01, 0xA1, 0x01,                                 // usage 1, application
    0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,               // 0..255, 8 bits
    0x85, 0x01, 0x09, 0x01, 0x95, 0x3F, 0x81, 0x02,         // input 0x01, 63 bytes
    0x85, 0x02, 0x09, 0x02, 0x95, 0x1F, 0x91, 0x02,         // output 0x02, 31 bytes
    0x85, 0x10, 0x09, 0x10, 0x95, 0x3F, 0xB1, 0x02,         // feature 0x10, 63 bytes
    0x85, 0x11, 0x09, 0x11, 0x95, 0x0F, 0xB1, 0x02,         // feature 0x11, 15 bytes
    0x85, 0x12, 0x09, 0x12, 0x95, 0x07, 0xB1, 0x02, 0xC0};  // feature 0x12, 7 bytes; end

static const uint8_t kDescriptorAffine[] = {0x06, 0x48, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00,
                                            0x26, 0xFF, 0x00, 0x75, 0x08, 0x85, 0x01, 0x09, 0x01,
                                            0x95, 0x3F, 0x81, 0x02, 0x85, 0x02, 0x09, 0x02, 0x95,
                                            0x1F, 0x91, 0x02, 0x85, 0x03, 0x09, 0x03, 0x95, 0x3F,
                                            0x91, 0x02,  // output 0x03, 63 bytes
                                            0x85, 0x10, 0x09, 0x10, 0x95, 0x3F, 0xB1, 0x02, 0x85,
                                            0x11, 0x09, 0x11, 0x95, 0x0F, 0xB1, 0x02, 0x85, 0x12,
                                            0x09, 0x12, 0x95, 0x07, 0xB1, 0x02, 0xC0};

const uint8_t* hap_report_descriptor(bool affine, uint16_t* length) {
  *length = (uint16_t)(affine ? sizeof kDescriptorAffine : sizeof kDescriptorHead);
  return affine ? kDescriptorAffine : kDescriptorHead;
}

static uint8_t status_of(const HapDevice* device) {
  int status = 0;
  if (device->enabled) status |= kHapEnabled;
  if (hap_is_calibrated(device)) status |= kHapCalibrated;
  if (device->active) status |= kHapActive;
  if ((device->settings.capabilities.caps & kHapHasDeadMan) != 0 && device->now.dead_man_held) {
    status |= kHapDeadManHeld;
  }
  if (device->watchdog) status |= kHapWatchdog;
  if (device->saturated) status |= kHapSaturated;
  if (device->now.emergency_stop) status |= kHapEmergencyStop;
  if ((device->faults & ~kHapBadCommand) != 0) status |= kHapFault;
  return (uint8_t)status;
}

static uint16_t age_of(const HapDevice* device) {
  if (!device->command_seen || device->command_old) return kHapOldest;
  // A command that came after the measurement is 0 old.
  const int32_t age_us = (int32_t)(device->now.t_us - device->command_us);
  if (age_us < 0) return 0;
  const int32_t age = age_us / kAgeUnit;
  return (uint16_t)(age < kHapOldest ? age : kHapOldest);
}

void hap_sample(HapDevice* device) {
  const HapMeasurement* now = &device->now;
  const uint32_t caps = device->settings.capabilities.caps;
  HapState* state = &device->waiting;
  memset(state, 0, sizeof *state);
  state->id = kHapStateId;
  state->status = status_of(device);
  state->seq = device->seq;
  state->t_us = now->t_us;
  HapPose* pose = &device->history[device->seq & (kHapHistory - 1)];
  for (int i = 0; i < 3; ++i) {
    state->pos_nm[i] = pose->pos_nm[i] = now->pos_nm[i];
    state->vel[i] = (caps & kHapHasVelocity) != 0 ? now->vel[i] : 0;
    state->avel[i] = (caps & kHapHasVelocity) != 0 ? now->avel[i] : 0;
  }
  for (int i = 0; i < 4; ++i) state->quat_q30[i] = pose->quat_q30[i] = now->quat_q30[i];
  pose->seq = device->seq;
  pose->valid = true;
  state->grip = now->grip;
  state->grip_vel = now->grip_vel;
  state->buttons = now->buttons;
  state->cmd_seq = device->command_seen ? device->command.base.seq : 0;
  state->cmd_age = age_of(device);
  state->fault = device->faults;
  state->temp_c = (caps & kHapHasTemperature) != 0 ? now->temp_c : 0xFF;
  state->load = now->load;
  ++device->seq;
  device->has_waiting = true;
}

bool hap_take_report(HapDevice* device, HapState* report) {
  if (!device->has_waiting) return false;
  *report = device->waiting;
  device->has_waiting = false;
  return true;
}

static uint32_t length_of(const HapDevice* device, uint8_t id) {
  switch (id) {
    case kHapCommandId:
      return sizeof(HapCommand);
    case kHapAffineId:
      return (device->settings.capabilities.caps & kHapCanAffine) != 0 ? sizeof(HapAffine) : 0;
    case kHapConfigId:
      return sizeof(HapConfig);
    case kHapCalibrationId:
      return sizeof(HapCalibration);
    default:
      return 0;
  }
}

bool hap_receive(HapDevice* device, uint32_t now_us, const uint8_t* report, uint32_t length) {
  bool taken = false;
  if (length != 0 && length == length_of(device, report[0])) {
    if (report[0] == kHapConfigId) {
      taken = hap_set_config(device, report);
    } else if (report[0] == kHapCalibrationId) {
      taken = hap_set_calibration(device, report);
    } else {
      taken = hap_take_command(device, now_us, report, length);
    }
  }
  if (!taken) device->faults |= kHapBadCommand;
  return taken;
}

bool hap_receive_split(HapDevice* device, uint32_t now_us, uint8_t id, const uint8_t* bytes,
                       uint32_t length) {
  // ID in front: from the OUT endpoint, or from a stack that left it there.
  if (id == 0 || (length == length_of(device, id) && length != 0 && bytes[0] == id)) {
    return hap_receive(device, now_us, bytes, length);
  }
  uint8_t whole[kHapReportBytes];
  if (length >= sizeof whole) {
    device->faults |= kHapBadCommand;
    return false;
  }
  whole[0] = id;
  memcpy(whole + 1, bytes, length);
  return hap_receive(device, now_us, whole, length + 1);
}

uint32_t hap_get_feature(const HapDevice* device, uint8_t id, uint8_t* report, uint32_t room) {
  const void* from;
  uint32_t length;
  if (id == kHapCapabilitiesId) {
    from = &device->settings.capabilities;
    length = sizeof(HapCapabilities);
  } else if (id == kHapConfigId) {
    from = &device->config;
    length = sizeof(HapConfig);
  } else if (id == kHapCalibrationId) {
    from = &device->calibration;
    length = sizeof(HapCalibration);
  } else {
    return 0;
  }
  if (room < length) return 0;
  memcpy(report, from, length);
  return length;
}

void hap_default_config(HapDevice* device) {
  const HapCapabilities* caps = &device->settings.capabilities;
  memset(&device->config, 0, sizeof device->config);
  device->config.id = kHapConfigId;
  device->config.wd_ms = caps->wd_default_ms;
  device->config.f_cap_cn = caps->f_peak_cn;
  device->config.tau_cap_mnm = caps->tau_peak_mnm;
  device->config.v_cap_mmps = kHapResetSpeedCap;
}

static uint16_t at_most(uint16_t value, uint16_t most) { return value < most ? value : most; }

bool hap_set_config(HapDevice* device, const uint8_t* report) {
  const HapCapabilities* caps = &device->settings.capabilities;
  HapConfig wanted;
  memcpy(&wanted, report, sizeof wanted);
  HapConfig* config = &device->config;
  if (device->enabled) {
    // Under a hand nothing is let loose.
    wanted.wd_ms = at_most(wanted.wd_ms, config->wd_ms);
    wanted.f_cap_cn = at_most(wanted.f_cap_cn, config->f_cap_cn);
    wanted.tau_cap_mnm = at_most(wanted.tau_cap_mnm, config->tau_cap_mnm);
    wanted.v_cap_mmps = at_most(wanted.v_cap_mmps, config->v_cap_mmps);
  }
  config->wd_ms = at_most(wanted.wd_ms, caps->wd_max_ms);
  if (config->wd_ms < kShortestWatchdog) config->wd_ms = kShortestWatchdog;
  config->f_cap_cn = at_most(wanted.f_cap_cn, caps->f_peak_cn);
  config->tau_cap_mnm = at_most(wanted.tau_cap_mnm, caps->tau_peak_mnm);
  config->v_cap_mmps = wanted.v_cap_mmps;
  config->grav_comp = (caps->caps & kHapCanGravity) != 0 && wanted.grav_comp != 0;
  return true;
}
