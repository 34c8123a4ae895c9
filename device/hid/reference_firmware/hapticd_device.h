// Reference core of a device that speaks HID profile v1 (device/hid/PROFILE.md): reports, watchdog,
// limits, enabling, calibration, the affine command. C11, also read by C++; no operating system, no
// heap, no floating point, of the C library only memcpy and memset. Little-endian controllers.
// Copy this folder into a firmware, call hap_servo from the servo loop and the rest from the USB
// callbacks. Not reentrant: all calls from one context, or with the servo interrupt masked.
// Units are those of the reports and are in the names: un = uN, unm = uN m, npm = N/m.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Report IDs.
enum {
  kHapStateId = 0x01,
  kHapCommandId = 0x02,
  kHapAffineId = 0x03,
  kHapCapabilitiesId = 0x10,
  kHapConfigId = 0x11,
  kHapCalibrationId = 0x12
};

/// "HAP1" as bytes on the wire; version 1.0.
enum { kHapMagic = 0x31504148, kHapVersionMajor = 1, kHapVersionMinor = 0 };

/// Bits of HapState.status.
enum {
  kHapEnabled = 1,
  kHapCalibrated = 2,
  kHapActive = 4,
  kHapDeadManHeld = 8,
  kHapWatchdog = 16,
  kHapSaturated = 32,
  kHapEmergencyStop = 64,
  kHapFault = 128
};

/// Bits of HapCommand.flags.
enum { kHapEnable = 1, kHapClearFault = 2, kHapBrake = 4, kHapGrip = 8 };

/// Bits of HapCapabilities.caps.
enum {
  kHapCanAffine = 1,
  kHapNeedsCalibration = 2,
  kHapHasDeadMan = 4,
  kHapHasBrake = 8,
  kHapCanGravity = 16,
  kHapHasTemperature = 32,
  kHapHasVelocity = 64
};

/// Bits of HapState.fault.
enum {
  kHapOverTemperature = 1,
  kHapOverCurrent = 2,
  kHapUnderVoltage = 4,
  kHapEncoder = 8,
  kHapRange = 16,
  kHapOverSpeed = 32,
  kHapUsb = 64,
  kHapInternal = 128,
  kHapBadCommand = 256
};

/// HapCalibration.op and HapCalibration.state.
enum { kHapStart = 1, kHapZeroHere = 2, kHapAbort = 3, kHapStore = 4 };
enum { kHapNotCalibrated = 0, kHapRunning = 1, kHapCalibrationOk = 2, kHapCalibrationFailed = 3 };

/// HapConfig.v_cap_mmps that watches no speed; HapState.cmd_age that means none, or older.
enum { kHapNoSpeedCap = 0xFFFF, kHapOldest = 0xFFFF };
/// HapConfig.v_cap_mmps after a reset: no hand that plays is faster, a handle that is thrown is.
enum { kHapResetSpeedCap = 3000 };
/// Largest gains where the maker states none: more than a host renders, less than a servo of 1 kHz
/// turns into a push. mN s/m, mN m/rad, 10 uN m s/rad.
enum { kHapMostDamping = 10000, kHapMostTurnStiffness = 5000, kHapMostTurnDamping = 5000 };

#pragma pack(push, 1)
/// Input 0x01, 64 bytes.
typedef struct HapState {
  uint8_t id, status;
  uint16_t seq;
  uint32_t t_us;
  int32_t pos_nm[3];
  int32_t quat_q30[4];  ///< w, x, y, z
  int16_t vel[3];       ///< 0.1 mm/s
  int16_t avel[3];      ///< mrad/s
  int16_t grip;         ///< 10 um
  int16_t grip_vel;     ///< mm/s
  uint16_t buttons, cmd_seq, cmd_age, fault;
  uint8_t temp_c, load;
  uint16_t reserved;
} HapState;

/// Output 0x02, 32 bytes.
typedef struct HapCommand {
  uint8_t id, flags;
  uint16_t seq;
  int32_t force_un[3];
  int32_t torque_unm[3];
  int16_t grip_mn;
  uint16_t ref_seq;
} HapCommand;

/// Output 0x03, 64 bytes.
typedef struct HapAffine {
  HapCommand base;
  int16_t k_npm[6];           ///< xx, yy, zz, xy, xz, yz
  uint16_t b_mnspm[3];        ///< mN s/m
  uint16_t kr_mnmprad[3];     ///< mN m/rad
  uint16_t br_10unmsprad[3];  ///< 10 uN m s/rad
  uint16_t reserved;
} HapAffine;

/// Feature 0x10, 64 bytes.
typedef struct HapCapabilities {
  uint8_t id, ver_major, ver_minor, n_buttons;
  uint32_t magic, caps;
  uint16_t dof, in_rate_hz, servo_rate_hz, wd_default_ms, wd_max_ms;
  uint16_t f_cont_cn, f_peak_cn, tau_cont_mnm, tau_peak_mnm, k_max_npm;
  int16_t ws_min_mm[3], ws_max_mm[3];
  uint16_t rot_range_mrad[3];
  uint32_t pos_res_nm, rot_res_urad;
  uint16_t mass_g, grip_range;
  uint8_t reserved[2];
} HapCapabilities;

/// Feature 0x11, 16 bytes.
typedef struct HapConfig {
  uint8_t id, flags;
  uint16_t wd_ms, f_cap_cn, tau_cap_mnm, v_cap_mmps;
  uint8_t grav_comp;
  uint8_t reserved[5];
} HapConfig;

/// Feature 0x12, 8 bytes.
typedef struct HapCalibration {
  uint8_t id, op, state, progress;
  uint16_t axis_mask;
  uint8_t reserved[2];
} HapCalibration;
#pragma pack(pop)

/// Longest report.
enum { kHapReportBytes = 64 };
/// Poses remembered for the affine command: a power of two, at least 8 ms and 16 reports.
enum { kHapHistory = 64 };

/// What the maker knows of the device; constant.
typedef struct HapSettings {
  HapCapabilities capabilities;       ///< id, version and magic are filled in by hap_init
  uint16_t calibration_axes;          ///< without these it is not calibrated; bits as axis_mask
  uint16_t grip_peak_mn;              ///< largest grip force, either way
  uint32_t affine_k_max_npm;          ///< largest row sum of K that the servo bears; 0: k_max_npm
  uint16_t affine_b_max_mnspm;        ///< largest entry of B; 0: kHapMostDamping
  uint16_t affine_kr_max_mnmprad;     ///< largest entry of Kr; 0: kHapMostTurnStiffness
  uint16_t affine_br_max_10unmsprad;  ///< largest entry of Br; 0: kHapMostTurnDamping
} HapSettings;

/// What the sensors say, in the units of HapState. Once per servo cycle.
typedef struct HapMeasurement {
  uint32_t t_us;
  int32_t pos_nm[3];
  int32_t quat_q30[4];
  int16_t vel[3];
  int16_t avel[3];
  int16_t grip, grip_vel;
  uint16_t buttons;
  uint16_t faults;  ///< that hold now; not kHapBadCommand
  uint8_t temp_c;   ///< 0xFF unknown
  uint8_t load;
  bool bus_ready;       ///< configured and not suspended
  bool emergency_stop;  ///< pressed
  bool dead_man_held;
} HapMeasurement;

/// What the motors are to give. All zero whenever the device is not enabled.
typedef struct HapOutput {
  int32_t force_un[3];
  int32_t torque_unm[3];
  int16_t grip_mn;
  bool motors_on;
  bool brake;
  bool gravity;  ///< add the weight of the handle; the sum stays within the peak
} HapOutput;

/// A pose by the report it was sent with.
typedef struct HapPose {
  int32_t pos_nm[3];
  int32_t quat_q30[4];
  uint16_t seq;
  bool valid;
} HapPose;

/// One device. Read it as you like, write it through the functions alone.
typedef struct HapDevice {
  HapSettings settings;
  HapConfig config;
  HapMeasurement now;  ///< newest
  HapAffine command;   ///< last accepted; base.id says which kind, the gains of 0x02 are zero
  uint32_t command_us;
  bool command_seen;  ///< one was accepted since the bus was reset
  bool command_old;   ///< cmd_age is saturated
  HapPose reference;  ///< of the affine command
  HapPose history[kHapHistory];
  HapState waiting;  ///< for the endpoint
  bool has_waiting;
  uint16_t seq;  ///< of the next report
  bool sound;    ///< the settings agree with the profile
  bool bus_ready, enabled, watchdog, saturated, active;
  bool enable_seen;  ///< ENABLE was set in the command before
  uint16_t faults;   ///< latched
  HapCalibration calibration;
  uint16_t calibrated_axes;
  uint16_t running_axes;       ///< that the running calibration is about
  uint8_t calibration_asked;   ///< op for hap_take_calibration
  uint16_t calibration_about;  ///< its axes
} HapDevice;

/// The report descriptor, and its length. `affine`: with report 0x03.
const uint8_t* hap_report_descriptor(bool affine, uint16_t* length);

/// Begins: disabled, nothing latched. False, and no command will ever be obeyed, when the
/// capabilities contradict the profile.
bool hap_init(HapDevice* device, const HapSettings* settings);

/// The bus was reset or reconfigured: disabled, Config as by default, no command seen.
void hap_bus_reset(HapDevice* device);

/// Once per servo cycle, whether there is a bus or not: takes the measurement, trips what must
/// trip, and says what the motors are to give. `now_us` is the clock of t_us; it wraps.
void hap_servo(HapDevice* device, uint32_t now_us, const HapMeasurement* measurement,
               HapOutput* output);

/// Once per USB frame, right before it: makes the newest measurement the waiting report.
void hap_sample(HapDevice* device);

/// Whenever the IN endpoint is free: true, and the waiting report, unless it was taken already.
bool hap_take_report(HapDevice* device, HapState* report);

/// Any report from the host, by OUT endpoint or SET_REPORT; byte 0 is its ID. False when it was
/// refused (BAD_CMD); a repeated seq is not an error.
bool hap_receive(HapDevice* device, uint32_t now_us, const uint8_t* report, uint32_t length);

/// The same for a stack that takes the ID off some reports: `id` 0 when it is still in front.
bool hap_receive_split(HapDevice* device, uint32_t now_us, uint8_t id, const uint8_t* bytes,
                       uint32_t length);

/// Feature report `id` into `report`, ID first. Its length, 0 when there is none or no room: stall.
uint32_t hap_get_feature(const HapDevice* device, uint8_t id, uint8_t* report, uint32_t room);

/// Which calibration the host asks for, once: an op and its axes; 0 if none. kHapStart: begin,
/// forces are off; kHapZeroHere: this pose is zero; kHapAbort: restore; kHapStore: keep it in
/// flash.
uint8_t hap_take_calibration(HapDevice* device, uint16_t* axes);

/// From a running calibration: how far, 0..100.
void hap_calibration_progress(HapDevice* device, uint8_t percent);

/// A running calibration has ended.
void hap_calibration_end(HapDevice* device, bool ok);

/// Within the core.
bool hap_is_calibrated(const HapDevice* device);
bool hap_take_command(HapDevice* device, uint32_t now_us, const uint8_t* report, uint32_t length);
bool hap_set_config(HapDevice* device, const uint8_t* report);
bool hap_set_calibration(HapDevice* device, const uint8_t* report);
void hap_default_config(HapDevice* device);
void hap_evaluate(HapDevice* device, HapOutput* output);
bool hap_affine_is_sound(const HapDevice* device, const HapAffine* affine);
void hap_disable(HapDevice* device);

#ifdef __cplusplus
}
#endif
