// See device_features.h.
#include "device/hid/device_features.h"

#include <algorithm>
#include <array>
#include <span>

#include "device/hid/profile_codec.h"

namespace hapticd::hid {
namespace {

std::string named(std::uint8_t id) { return "feature report " + std::to_string(id); }

/// Reads report `id` of `length` bytes and decodes it.
template <typename Report>
bool get(const ReportChannel& channel, std::uint8_t id, std::size_t length,
         Decoded (*decode)(std::span<const std::uint8_t>, Report&) noexcept, Report& report,
         std::string& error) {
  std::array<std::uint8_t, kMaxReport> bytes{};
  bytes[0] = id;
  const int got = channel.get_feature(channel.output, bytes.data(), length);
  if (got < 0) {
    error = "it does not give its " + named(id);
    return false;
  }
  const Decoded decoded =
      decode(std::span(bytes).first(std::min(static_cast<std::size_t>(got), bytes.size())), report);
  if (decoded == Decoded::kOk) return true;
  error = "its " + named(id) + " cannot be used: " + std::string(name_of(decoded));
  return false;
}

bool set(const ReportChannel& channel, std::span<const std::uint8_t> report, std::string& error) {
  if (channel.set_feature(channel.output, report.data(), report.size()) >= 0) return true;
  error = "it does not take its " + named(report[0]);
  return false;
}

}  // namespace

bool get_capabilities(const ReportChannel& channel, Capabilities& capabilities,
                      std::string& error) {
  return get(channel, kCapabilitiesId, kCapabilitiesBytes, decode_capabilities, capabilities,
             error);
}

bool agree(const ReportChannel& channel, Config& config, std::string& error) {
  return set(channel, encode(config), error) &&
         get(channel, kConfigId, kConfigBytes, decode_config, config, error);
}

bool get_calibration(const ReportChannel& channel, Calibration& calibration, std::string& error) {
  return get(channel, kCalibrationId, kCalibrationBytes, decode_calibration, calibration, error);
}

bool calibrate(const ReportChannel& channel, const Calibration& asked, std::string& error) {
  return set(channel, encode(asked), error);
}

}  // namespace hapticd::hid
