// See damping_record.h.
#include "device/attach/damping_record.h"

#include <spdlog/spdlog.h>

#include <charconv>
#include <string>
#include <string_view>

#include "device/attach/record_file.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDampingHead =
    "# hapticd: what was measured of this device's damping. Without this file it is a guess.\n"
    "# Each axis: at least, at most (N s/m), mass that rang (kg).\n";
/// More than any damping or mass of a handle, N s/m and kg.
constexpr double kMaxNumber = 1e3;

std::string exact_text(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end.ptr};
}

std::string record_of(const CheckedDevice& device, const MeasuredDamping& measured) {
  std::string text = record_start(device, kDampingHead);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i]) continue;
    text += std::string(1, "xyz"[i]) + ": " + exact_text(measured[i]->lower) + " " +
            exact_text(measured[i]->upper) + " " + exact_text(measured[i]->mass) + "\n";
  }
  return text + seal_of(text);
}

/// The number that `text` begins with, which is taken off it; 0: none.
double take_number(std::string_view& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty()) text.remove_prefix(1);
  return error == std::errc() ? number : 0.0;
}

bool is_sound(const DampingBounds& bounds) {
  return bounds.lower > 0.0 && bounds.lower <= bounds.upper && bounds.upper <= kMaxNumber &&
         bounds.mass > 0.0 && bounds.mass <= kMaxNumber;
}

/// What the lines of the axes say, as far as they can be read.
MeasuredDamping axes_of(std::string_view text) {
  MeasuredDamping measured;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (text.size() < 3 || text.substr(0, 3) != std::string(1, "xyz"[i]) + ": ") continue;
    text.remove_prefix(3);
    DampingBounds bounds;
    bounds.lower = take_number(text);
    bounds.upper = take_number(text);
    bounds.mass = take_number(text);
    if (is_sound(bounds)) measured[i] = bounds;
  }
  return measured;
}

}  // namespace

fs::path damping_file(const fs::path& folder, const CheckedDevice& device) {
  return record_file(folder, device, ".damping");
}

MeasuredDamping read_damping(const fs::path& folder, const CheckedDevice& device) {
  const fs::path file = damping_file(folder, device);
  if (device.serial.empty() || !is_there(file)) return {};
  const std::string start = record_start(device, kDampingHead);
  std::string text;
  std::string wrong = read_record(file, text);
  if (wrong.empty()) {
    wrong = "not what hapticd has measured of this device with this firmware and axis_map";
    if (text.starts_with(start)) {
      const MeasuredDamping measured = axes_of(std::string_view(text).substr(start.size()));
      if (text == record_of(device, measured)) return measured;
    }
  }
  spdlog::warn(
      "{}: {}; its damping counts as not measured. Measure it again: hapticctl device "
      "check.",
      file.string(), wrong);
  return {};
}

void keep_damping(const fs::path& folder, const CheckedDevice& device,
                  const MeasuredDamping& measured) {
  write_record(damping_file(folder, device), record_of(device, measured));
}

}  // namespace hapticd
