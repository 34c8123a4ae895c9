// The codec of HID profile v1 against reports put together by hand from the tables of PROFILE.md,
// and against the C structs of the reference firmware, which share no line with it.
#include "device/hid/profile_codec.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "device/hid/reference_firmware/hapticd_device.h"
#include "tests/device/hid/sent_reports.h"
#include "tests/device/hid/worked_reports.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using hid::Decoded;
using Bytes = std::vector<std::uint8_t>;

template <std::size_t Count>
Bytes vector_of(const std::array<std::uint8_t, Count>& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// `decode` takes exactly `bytes`, and names the mistake in every other length and ID.
template <typename Report, typename Decode>
void check_refusals(const Bytes& bytes, Decode decode) {
  const Report untouched;
  for (std::size_t length = 0; length <= 2 * hid::kStateBytes; ++length) {
    CAPTURE(length);
    Bytes other = bytes;
    other.resize(length);
    Report report;
    const Decoded found = decode(other, report);
    CHECK(found == (length == bytes.size() ? Decoded::kOk : Decoded::kWrongLength));
    if (found != Decoded::kOk) CHECK(report == untouched);
  }
  for (unsigned id = 0; id < 256; ++id) {
    CAPTURE(id);
    Bytes other = bytes;
    other[0] = static_cast<std::uint8_t>(id);
    Report report;
    const Decoded found = decode(other, report);
    CHECK(found == (id == bytes[0] ? Decoded::kOk : Decoded::kWrongId));
    if (found != Decoded::kOk) CHECK(report == untouched);
  }
}

/// Bytes and struct are each other's, in both directions.
template <typename Report, typename Decode, std::size_t Count>
void check_worked(const std::array<std::uint8_t, Count>& bytes, const Report& meaning,
                  Decode decode) {
  Report report;
  CHECK(decode(bytes, report) == Decoded::kOk);
  CHECK(report == meaning);
  CHECK(hid::encode(meaning) == bytes);
  check_refusals<Report>(vector_of(bytes), decode);
}

TEST_CASE("a state report is read and written as specified, byte for byte") {
  check_worked(kStateBytes, kState, hid::decode_state);
}

TEST_CASE("a command is read and written as specified, byte for byte") {
  check_worked(kCommandBytes, kCommand, decode_command);
}

TEST_CASE("an affine command is read and written as specified, byte for byte") {
  check_worked(kAffineBytes, kAffine, decode_affine);
}

TEST_CASE("capabilities are read and written as specified, byte for byte") {
  check_worked(kCapabilitiesBytes, kCapabilities, hid::decode_capabilities);
}

TEST_CASE("a config is read and written as specified, byte for byte") {
  check_worked(kConfigBytes, kConfig, hid::decode_config);
}

TEST_CASE("a calibration report is read and written as specified, byte for byte") {
  check_worked(kCalibrationBytes, kCalibration, hid::decode_calibration);
}

/// Result of `decode` with byte `at` of `bytes` made `value`.
template <typename Report, typename Decode, std::size_t Count>
Decoded with_byte(std::array<std::uint8_t, Count> bytes, std::size_t at, std::uint8_t value,
                  Decode decode) {
  bytes[at] = value;
  Report report;
  return decode(bytes, report);
}

TEST_CASE("capabilities of another magic or major version are refused by name") {
  const auto changed = [](std::size_t at, std::uint8_t value) {
    return with_byte<hid::Capabilities>(kCapabilitiesBytes, at, value, hid::decode_capabilities);
  };
  for (std::size_t at = 4; at < 8; ++at) CHECK(changed(at, 0x00) == Decoded::kWrongMagic);
  CHECK(changed(1, 0) == Decoded::kWrongVersion);
  CHECK(changed(1, 2) == Decoded::kWrongVersion);
  // Minor versions add what older hosts need not know.
  CHECK(changed(2, 9) == Decoded::kOk);
  CHECK(changed(62, 9) == Decoded::kOk);
}

TEST_CASE("capabilities that contradict themselves are refused") {
  using Change = void (*)(hid::Capabilities&);
  constexpr std::array<Change, 9> kChanges{[](hid::Capabilities& c) { c.in_rate_hz = 0; },
                                           [](hid::Capabilities& c) { c.wd_default_ms = 1; },
                                           [](hid::Capabilities& c) { c.wd_default_ms = 101; },
                                           [](hid::Capabilities& c) { c.wd_max_ms = 101; },
                                           [](hid::Capabilities& c) { c.wd_max_ms = 19; },
                                           [](hid::Capabilities& c) { c.f_cont_cn = 901; },
                                           [](hid::Capabilities& c) { c.tau_cont_mnm = 301; },
                                           [](hid::Capabilities& c) { c.ws_min_mm[0] = 101; },
                                           [](hid::Capabilities& c) { c.ws_max_mm[2] = -61; }};
  for (const Change change : kChanges) {
    hid::Capabilities capabilities = kCapabilities;
    change(capabilities);
    hid::Capabilities read;
    CHECK(hid::decode_capabilities(hid::encode(capabilities), read) == Decoded::kOutOfRange);
    CHECK(read == hid::Capabilities{});
  }
}

TEST_CASE("a state whose orientation is no unit quaternion is refused") {
  hid::StateReport state = kState;
  const auto read = [&state] {
    hid::StateReport out;
    return hid::decode_state(hid::encode(state), out);
  };
  state.quat_q30 = {0, 0, 0, 0};
  CHECK(read() == Decoded::kOutOfRange);
  state.quat_q30 = {hid::kOneQ30, 100'000'000, 0, 0};
  CHECK(read() == Decoded::kOutOfRange);
  state.quat_q30 = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
  CHECK(read() == Decoded::kOutOfRange);
  state.quat_q30 = {-hid::kOneQ30, 0, 0, 0};
  CHECK(read() == Decoded::kOk);
  state.quat_q30 = {hid::kOneQ30 / 2, -hid::kOneQ30 / 2, hid::kOneQ30 / 2, hid::kOneQ30 / 2};
  CHECK(read() == Decoded::kOk);
}

TEST_CASE("an affine command that pushes away along an axis is refused") {
  for (std::size_t i = 0; i < 6; ++i) {
    CAPTURE(i);
    hid::AffineReport affine = kAffine;
    affine.k_npm[i] = -1;
    hid::AffineReport out;
    const Decoded found = decode_affine(hid::encode(affine), out);
    CHECK(found == (i < 3 ? Decoded::kOutOfRange : Decoded::kOk));
  }
}

TEST_CASE("a calibration report with an unknown op, state or progress is refused") {
  const auto changed = [](std::size_t at, std::uint8_t value) {
    return with_byte<hid::Calibration>(kCalibrationBytes, at, value, hid::decode_calibration);
  };
  CHECK(changed(1, 4) == Decoded::kOk);
  CHECK(changed(1, 5) == Decoded::kOutOfRange);
  CHECK(changed(2, 3) == Decoded::kOk);
  CHECK(changed(2, 4) == Decoded::kOutOfRange);
  CHECK(changed(3, 101) == Decoded::kOutOfRange);
}

TEST_CASE("every result of a decoder has a name of its own") {
  std::vector<std::string_view> names;
  for (const Decoded found : {Decoded::kOk, Decoded::kWrongLength, Decoded::kWrongId,
                              Decoded::kWrongMagic, Decoded::kWrongVersion, Decoded::kOutOfRange}) {
    names.push_back(hid::name_of(found));
  }
  std::sort(names.begin(), names.end());
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
}

/// Random bytes laid over a C struct of the firmware.
template <typename Struct>
Struct random_struct(SplitMix64& random, std::uint8_t id) {
  std::array<std::uint8_t, sizeof(Struct)> bytes{};
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
  bytes[0] = id;
  Struct result;
  std::memcpy(&result, bytes.data(), sizeof result);
  return result;
}

template <typename Struct>
std::array<std::uint8_t, sizeof(Struct)> bytes_of(const Struct& report) {
  std::array<std::uint8_t, sizeof(Struct)> bytes{};
  std::memcpy(bytes.data(), &report, sizeof report);
  return bytes;
}

bool same(const HapState& a, const hid::StateReport& b) {
  bool same = a.status == b.status && a.seq == b.seq && a.t_us == b.t_us && a.grip == b.grip_10um &&
              a.grip_vel == b.grip_vel_mmps && a.buttons == b.buttons && a.cmd_seq == b.cmd_seq &&
              a.cmd_age == b.cmd_age && a.fault == b.fault && a.temp_c == b.temp_deg_c &&
              a.load == b.load;
  for (std::size_t i = 0; i < 3; ++i) {
    same = same && a.pos_nm[i] == b.pos_nm[i] && a.vel[i] == b.vel_100ums[i] &&
           a.avel[i] == b.avel_mradps[i];
  }
  for (std::size_t i = 0; i < 4; ++i) same = same && a.quat_q30[i] == b.quat_q30[i];
  return same;
}

bool same(const HapCommand& a, const hid::CommandReport& b) {
  bool same =
      a.flags == b.flags && a.seq == b.seq && a.grip_mn == b.grip_mn && a.ref_seq == b.ref_seq;
  for (std::size_t i = 0; i < 3; ++i) {
    same = same && a.force_un[i] == b.force_un[i] && a.torque_unm[i] == b.torque_unm[i];
  }
  return same;
}

bool same(const HapAffine& a, const hid::AffineReport& b) {
  bool all = same(a.base, b.base);
  for (std::size_t i = 0; i < 3; ++i) {
    all = all && a.b_mnspm[i] == b.b_mnspm[i] && a.kr_mnmprad[i] == b.kr_mnmprad[i] &&
          a.br_10unmsprad[i] == b.br_10unmsprad[i];
  }
  for (std::size_t i = 0; i < 6; ++i) all = all && a.k_npm[i] == b.k_npm[i];
  return all;
}

TEST_CASE("the host reads what the firmware's structs say, and writes what they read") {
  SplitMix64 random(3);
  std::int64_t wrong = 0;
  for (std::int64_t k = 0; k < scaled(200'000); ++k) {
    HapState state = random_struct<HapState>(random, kHapStateId);
    state.quat_q30[random.below(4)] = 1 << 30;
    for (auto& component : state.quat_q30) component = component == 1 << 30 ? component : 0;
    hid::StateReport read;
    wrong += hid::decode_state(bytes_of(state), read) == Decoded::kOk && same(state, read) ? 0 : 1;
    HapState again;
    const auto written = hid::encode(read);
    std::memcpy(&again, written.data(), sizeof again);
    wrong += same(again, read) && again.id == kHapStateId && again.reserved == 0 ? 0 : 1;

    HapAffine affine = random_struct<HapAffine>(random, kHapAffineId);
    for (std::size_t i = 0; i < 3; ++i)
      affine.k_npm[i] = static_cast<std::int16_t>(random.below(32'768));
    hid::AffineReport gains;
    wrong += decode_affine(bytes_of(affine), gains) == Decoded::kOk && same(affine, gains) ? 0 : 1;
    affine.reserved = 0;
    wrong += hid::encode(gains) == bytes_of(affine) ? 0 : 1;

    const HapCommand command = random_struct<HapCommand>(random, kHapCommandId);
    hid::CommandReport wrench;
    wrong +=
        decode_command(bytes_of(command), wrench) == Decoded::kOk && same(command, wrench) ? 0 : 1;
    wrong += hid::encode(wrench) == bytes_of(command) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("the firmware's capabilities, config and calibration are those the host reads") {
  // By value: fields of packed structs are not aligned.
  const auto equal = [](auto a, auto b) { return a == b; };
  HapCapabilities caps;
  std::memcpy(&caps, kCapabilitiesBytes.data(), sizeof caps);
  CHECK(equal(caps.magic, hid::kMagic));
  CHECK(equal(caps.pos_res_nm, kCapabilities.pos_res_nm));
  CHECK(equal(caps.grip_range, kCapabilities.grip_range));
  CHECK(equal(caps.ws_max_mm[2], kCapabilities.ws_max_mm[2]));
  CHECK(equal(caps.k_max_npm, kCapabilities.k_max_npm));
  HapConfig config;
  std::memcpy(&config, kConfigBytes.data(), sizeof config);
  CHECK(equal(config.v_cap_mmps, kConfig.v_cap_mmps));
  CHECK(equal(config.wd_ms, kConfig.wd_ms));
  HapCalibration calibration;
  std::memcpy(&calibration, kCalibrationBytes.data(), sizeof calibration);
  CHECK(equal(calibration.axis_mask, kCalibration.axis_mask));
  CHECK(equal(calibration.progress, kCalibration.progress));
}

}  // namespace
}  // namespace hapticd::test
