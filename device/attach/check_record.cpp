// See check_record.h.
#include "device/attach/check_record.h"

#include <fcntl.h>
#include <sodium.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHead =
    "# hapticd: this device has passed the guided check. Without this file it gets 0.3 N at "
    "most.\n";
/// More than any record has, bytes.
constexpr std::size_t kMaxRecord = 4096;
/// Letters of a serial that a file's name shows; the hash behind them tells longer ones apart.
constexpr std::size_t kShownSerial = 40;
/// Bytes of that hash.
constexpr std::size_t kNameHash = 8;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_;
};

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text(2 * bytes.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

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

/// Fit for a file's name, and for text in quotes.
std::string plain(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(),
      [](char c) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !letter && !(c >= '0' && c <= '9') && c != '-' && c != ' ';
      },
      '_');
  return out;
}

std::string first_lines(const CheckedDevice& device) {
  return std::string(kHead) + "serial: \"" + plain(device.serial) + "\"\n";
}

std::string record_of(const CheckedDevice& device) {
  return first_lines(device) + "product: \"" + plain(device.product) + "\"\nfingerprint: \"" +
         hex(device.fingerprint) + "\"\n";
}

std::string reason() { return std::generic_category().message(errno); }

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why +
                           ". Give hapticd a folder it may write to, then check again.");
}

/// The start of the file, or why it cannot be read.
std::string read_record(const fs::path& file, std::string& text) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.get() < 0) return reason();
  std::array<char, kMaxRecord> bytes{};
  const ssize_t size = ::read(opened.get(), bytes.data(), bytes.size());
  if (size < 0) return reason();
  text.assign(bytes.data(), static_cast<std::size_t>(size));
  return "";
}

/// Makes the name of a file last.
bool keep_entries(const fs::path& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.get() >= 0 && ::fsync(opened.get()) == 0;
}

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

fs::path check_file(const fs::path& folder, const CheckedDevice& device) {
  Hashed serial;
  serial.add(device.serial);
  const Fingerprint hash = serial.hash();
  std::string name = plain(device.serial.substr(0, kShownSerial));
  std::replace(name.begin(), name.end(), ' ', '_');
  return folder / (name + "_" + hex(std::span(hash).first(kNameHash)) + ".check");
}

bool is_remembered(const fs::path& folder, const CheckedDevice& device) {
  std::error_code error;
  const fs::path file = check_file(folder, device);
  if (device.serial.empty() || !fs::exists(fs::symlink_status(file, error))) return false;
  std::string text;
  std::string wrong = read_record(file, text);
  if (wrong.empty()) {
    if (text == record_of(device)) return true;
    wrong = text.starts_with(first_lines(device)) && text.size() == record_of(device).size()
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
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path file = check_file(folder, device);
  const fs::path fresh = file.string() + ".new";
  const std::string text = record_of(device);
  {
    const Descriptor made(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (made.get() < 0) refuse(fresh, reason());
    if (::write(made.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
        ::fsync(made.get()) != 0) {
      const std::string why = reason();
      fs::remove(fresh, error);
      refuse(fresh, why);
    }
  }
  fs::rename(fresh, file, error);
  if (error) refuse(file, error.message());
  if (!keep_entries(folder)) refuse(folder, reason());
}

void forget_check(const fs::path& folder, const CheckedDevice& device) {
  std::error_code error;
  const fs::path file = check_file(folder, device);
  const bool removed = fs::remove(file, error);
  if (error) throw std::runtime_error(file.string() + ": " + error.message() + ". Remove it.");
  if (removed && !keep_entries(folder)) refuse(folder, reason());
}

}  // namespace hapticd
