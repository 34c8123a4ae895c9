// See check_record.h.
#include "device/attach/check_record.h"

#include <sodium.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "device/attach/record_file.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHead =
    "# hapticd: this device has passed the guided check. Without this file it gets 0.3 N at "
    "most.\n";
/// Letters of a serial that a file's name shows; the hash behind them tells longer ones apart.
constexpr std::size_t kShownSerial = 40;
/// Bytes of that hash.
constexpr std::size_t kNameHash = 8;

/// Bytes that a hash is taken of; each part with its length, so that no two lists are the same.
class Hashed {
 public:
  void add(std::span<const std::uint8_t> part) {
    const std::uint64_t size = part.size();
    add_raw(&size, sizeof size);
    bytes_.insert(bytes_.end(), part.begin(), part.end());
  }
  void add(std::string_view part) {
    add(std::span(reinterpret_cast<const std::uint8_t*>(part.data()), part.size()));
  }
  void add(double number) { add_raw(&number, sizeof number); }
  [[nodiscard]] Fingerprint hash() const {
    Fingerprint hash{};
    if (sodium_init() < 0 || crypto_generichash(hash.data(), hash.size(), bytes_.data(),
                                                bytes_.size(), nullptr, 0) != 0) {
      throw std::runtime_error("the hash of libsodium does not work on this machine");
    }
    return hash;
  }

 private:
  void add_raw(const void* from, std::size_t size) {
    const auto* const first = static_cast<const std::uint8_t*>(from);
    bytes_.insert(bytes_.end(), first, first + size);
  }
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

CheckedDevice checked_device(const HidrawNode& node, std::span<const std::uint8_t> stated,
                             const AxisMapping& axes) {
  const auto& [raw_axis, sign, position_scale, rotation_scale, force_scale, force_sign, dead_zone] =
      axes;
  Hashed all;
  all.add("guided check 1");
  all.add(node.serial);
  all.add(node.product);
  all.add(node.vendor_id);
  all.add(node.product_id);
  all.add(stated);
  all.add(raw_axis);
  for (const Array3& three : {sign, position_scale, rotation_scale, force_scale, force_sign}) {
    for (const double number : three) all.add(number);
  }
  all.add(dead_zone);
  return {node.serial, node.product, all.hash()};
}

fs::path record_file(const fs::path& folder, const CheckedDevice& device, std::string_view kind) {
  Hashed serial;
  serial.add(device.serial);
  const Fingerprint hash = serial.hash();
  std::string name = plain(device.serial.substr(0, kShownSerial));
  std::replace(name.begin(), name.end(), ' ', '_');
  return folder / (name + "_" + hex(std::span(hash).first(kNameHash)) + std::string(kind));
}

std::string record_head(const CheckedDevice& device, std::string_view says) {
  return std::string(says) + "serial: \"" + plain(device.serial) + "\"\n";
}

std::string record_start(const CheckedDevice& device, std::string_view says) {
  return record_head(device, says) + "product: \"" + plain(device.product) + "\"\nfingerprint: \"" +
         hex(device.fingerprint) + "\"\n";
}

fs::path check_file(const fs::path& folder, const CheckedDevice& device) {
  return record_file(folder, device, ".check");
}

bool is_remembered(const fs::path& folder, const CheckedDevice& device) {
  const fs::path file = check_file(folder, device);
  if (device.serial.empty() || !is_there(file)) return false;
  const std::string whole = record_start(device, kHead);
  std::string text;
  std::string wrong = read_record(file, text);
  if (wrong.empty()) {
    if (text == whole) return true;
    wrong = text.starts_with(record_head(device, kHead)) && text.size() == whole.size()
                ? "it was checked with another firmware, product or axis_map"
                : "not a record of hapticd";
  }
  spdlog::warn(
      "{}: {}; the device counts as not checked. Check it again: hapticctl device "
      "check.",
      file.string(), wrong);
  return false;
}

void remember_check(const fs::path& folder, const CheckedDevice& device) {
  write_record(check_file(folder, device), record_start(device, kHead));
}

void forget_check(const fs::path& folder, const CheckedDevice& device) {
  remove_record(check_file(folder, device));
}

}  // namespace hapticd
