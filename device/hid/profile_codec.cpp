// See profile_codec.h. Fields are in the order of the tables of PROFILE.md.
#include "device/hid/profile_codec.h"

#include "device/hid/report_bytes.h"

namespace hapticd::hid {
namespace {

using Bytes = std::span<const std::uint8_t>;

Decoded check(Bytes bytes, std::size_t length, std::uint8_t id) noexcept {
  if (bytes.size() != length) return Decoded::kWrongLength;
  return bytes[0] == id ? Decoded::kOk : Decoded::kWrongId;
}

bool is_orientation(const std::array<std::int32_t, 4>& quat_q30) noexcept {
  double square = 0.0;
  for (const std::int32_t component : quat_q30) {
    const double value = static_cast<double>(component) / kOneQ30;
    square += value * value;
  }
  return square >= 1.0 - kOrientationTolerance && square <= 1.0 + kOrientationTolerance;
}

void put_command(FieldWriter& writer, const CommandReport& command) noexcept {
  writer.put(command.flags);
  writer.put(command.seq);
  writer.put(command.force_un);
  writer.put(command.torque_unm);
  writer.put(command.grip_mn);
  writer.put(command.ref_seq);
}

bool is_consistent(const Capabilities& c) noexcept {
  bool ok = c.n_buttons <= kMaxButtons && c.in_rate_hz != 0 && c.wd_default_ms >= kMinWatchdog_ms &&
            c.wd_default_ms <= c.wd_max_ms && c.wd_max_ms <= kMaxWatchdog_ms &&
            c.f_cont_cn <= c.f_peak_cn && c.tau_cont_mnm <= c.tau_peak_mnm;
  for (std::size_t i = 0; i < 3; ++i) ok = ok && c.ws_min_mm[i] <= c.ws_max_mm[i];
  return ok;
}

}  // namespace

std::string_view name_of(Decoded decoded) noexcept {
  switch (decoded) {
    case Decoded::kOk:
      return "ok";
    case Decoded::kWrongLength:
      return "wrong length";
    case Decoded::kWrongId:
      return "wrong report ID";
    case Decoded::kWrongMagic:
      return "wrong magic: not a device of this profile";
    case Decoded::kWrongVersion:
      return "wrong major version of the profile";
    case Decoded::kOutOfRange:
      return "a value that the profile excludes";
  }
  return "unknown";
}

Decoded decode_state(Bytes bytes, StateReport& state) noexcept {
  if (const Decoded found = check(bytes, kStateBytes, kStateId); found != Decoded::kOk) {
    return found;
  }
  StateReport next;
  FieldReader reader(bytes.subspan(1));
  reader.take(next.status);
  reader.take(next.seq);
  reader.take(next.t_us);
  reader.take(next.pos_nm);
  reader.take(next.quat_q30);
  reader.take(next.vel_100ums);
  reader.take(next.avel_mradps);
  reader.take(next.grip_10um);
  reader.take(next.grip_vel_mmps);
  reader.take(next.buttons);
  reader.take(next.cmd_seq);
  reader.take(next.cmd_age);
  reader.take(next.fault);
  reader.take(next.temp_deg_c);
  reader.take(next.load);
  if (!is_orientation(next.quat_q30)) return Decoded::kOutOfRange;
  state = next;
  return Decoded::kOk;
}

Decoded decode_capabilities(Bytes bytes, Capabilities& capabilities) noexcept {
  if (const Decoded found = check(bytes, kCapabilitiesBytes, kCapabilitiesId);
      found != Decoded::kOk) {
    return found;
  }
  Capabilities next;
  std::uint32_t magic = 0;
  FieldReader reader(bytes.subspan(1));
  reader.take(next.ver_major);
  reader.take(next.ver_minor);
  reader.take(next.n_buttons);
  reader.take(magic);
  if (magic != kMagic) return Decoded::kWrongMagic;
  if (next.ver_major != kVersionMajor) return Decoded::kWrongVersion;
  reader.take(next.caps);
  reader.take(next.dof);
  reader.take(next.in_rate_hz);
  reader.take(next.servo_rate_hz);
  reader.take(next.wd_default_ms);
  reader.take(next.wd_max_ms);
  reader.take(next.f_cont_cn);
  reader.take(next.f_peak_cn);
  reader.take(next.tau_cont_mnm);
  reader.take(next.tau_peak_mnm);
  reader.take(next.k_max_npm);
  reader.take(next.ws_min_mm);
  reader.take(next.ws_max_mm);
  reader.take(next.rot_range_mrad);
  reader.take(next.pos_res_nm);
  reader.take(next.rot_res_urad);
  reader.take(next.mass_g);
  reader.take(next.grip_range);
  if (!is_consistent(next)) return Decoded::kOutOfRange;
  capabilities = next;
  return Decoded::kOk;
}

Decoded decode_config(Bytes bytes, Config& config) noexcept {
  if (const Decoded found = check(bytes, kConfigBytes, kConfigId); found != Decoded::kOk) {
    return found;
  }
  FieldReader reader(bytes.subspan(2));
  reader.take(config.wd_ms);
  reader.take(config.f_cap_cn);
  reader.take(config.tau_cap_mnm);
  reader.take(config.v_cap_mmps);
  reader.take(config.grav_comp);
  return Decoded::kOk;
}

Decoded decode_calibration(Bytes bytes, Calibration& calibration) noexcept {
  if (const Decoded found = check(bytes, kCalibrationBytes, kCalibrationId);
      found != Decoded::kOk) {
    return found;
  }
  constexpr std::uint8_t kPercent = 100;
  std::uint8_t op = 0;
  std::uint8_t state = 0;
  Calibration next;
  FieldReader reader(bytes.subspan(1));
  reader.take(op);
  reader.take(state);
  reader.take(next.progress);
  reader.take(next.axis_mask);
  if (op > static_cast<std::uint8_t>(CalibrationOp::kStore) ||
      state > static_cast<std::uint8_t>(CalibrationState::kFailed) || next.progress > kPercent) {
    return Decoded::kOutOfRange;
  }
  next.op = static_cast<CalibrationOp>(op);
  next.state = static_cast<CalibrationState>(state);
  calibration = next;
  return Decoded::kOk;
}

std::array<std::uint8_t, kStateBytes> encode(const StateReport& state) noexcept {
  std::array<std::uint8_t, kStateBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kStateId);
  writer.put(state.status);
  writer.put(state.seq);
  writer.put(state.t_us);
  writer.put(state.pos_nm);
  writer.put(state.quat_q30);
  writer.put(state.vel_100ums);
  writer.put(state.avel_mradps);
  writer.put(state.grip_10um);
  writer.put(state.grip_vel_mmps);
  writer.put(state.buttons);
  writer.put(state.cmd_seq);
  writer.put(state.cmd_age);
  writer.put(state.fault);
  writer.put(state.temp_deg_c);
  writer.put(state.load);
  return bytes;
}

std::array<std::uint8_t, kCommandBytes> encode(const CommandReport& command) noexcept {
  std::array<std::uint8_t, kCommandBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kCommandId);
  put_command(writer, command);
  return bytes;
}

std::array<std::uint8_t, kAffineBytes> encode(const AffineReport& affine) noexcept {
  std::array<std::uint8_t, kAffineBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kAffineId);
  put_command(writer, affine.base);
  writer.put(affine.k_npm);
  writer.put(affine.b_mnspm);
  writer.put(affine.kr_mnmprad);
  writer.put(affine.br_10unmsprad);
  return bytes;
}

std::array<std::uint8_t, kCapabilitiesBytes> encode(const Capabilities& capabilities) noexcept {
  std::array<std::uint8_t, kCapabilitiesBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kCapabilitiesId);
  writer.put(capabilities.ver_major);
  writer.put(capabilities.ver_minor);
  writer.put(capabilities.n_buttons);
  writer.put(kMagic);
  writer.put(capabilities.caps);
  writer.put(capabilities.dof);
  writer.put(capabilities.in_rate_hz);
  writer.put(capabilities.servo_rate_hz);
  writer.put(capabilities.wd_default_ms);
  writer.put(capabilities.wd_max_ms);
  writer.put(capabilities.f_cont_cn);
  writer.put(capabilities.f_peak_cn);
  writer.put(capabilities.tau_cont_mnm);
  writer.put(capabilities.tau_peak_mnm);
  writer.put(capabilities.k_max_npm);
  writer.put(capabilities.ws_min_mm);
  writer.put(capabilities.ws_max_mm);
  writer.put(capabilities.rot_range_mrad);
  writer.put(capabilities.pos_res_nm);
  writer.put(capabilities.rot_res_urad);
  writer.put(capabilities.mass_g);
  writer.put(capabilities.grip_range);
  return bytes;
}

std::array<std::uint8_t, kConfigBytes> encode(const Config& config) noexcept {
  std::array<std::uint8_t, kConfigBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kConfigId);
  writer.put(std::uint8_t{0});
  writer.put(config.wd_ms);
  writer.put(config.f_cap_cn);
  writer.put(config.tau_cap_mnm);
  writer.put(config.v_cap_mmps);
  writer.put(config.grav_comp);
  return bytes;
}

std::array<std::uint8_t, kCalibrationBytes> encode(const Calibration& calibration) noexcept {
  std::array<std::uint8_t, kCalibrationBytes> bytes{};
  FieldWriter writer(bytes);
  writer.put(kCalibrationId);
  writer.put(static_cast<std::uint8_t>(calibration.op));
  writer.put(static_cast<std::uint8_t>(calibration.state));
  writer.put(calibration.progress);
  writer.put(calibration.axis_mask);
  return bytes;
}

}  // namespace hapticd::hid
