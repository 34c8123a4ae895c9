// See hidraw_handles.h.
#include "device/report_io/hidraw_handles.h"

#include <fcntl.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/rt/monotonic_clock.h"

namespace hapticd {
namespace {

constexpr const char* kPlugAgain = "Unplug it, plug it in again, and restart.";

hid_device* handle_of(void* pointer) noexcept { return static_cast<hid_device*>(pointer); }

int file_of(void* pointer) noexcept { return *static_cast<const int*>(pointer); }

int read_report(void* input, std::uint8_t* bytes, std::size_t room) noexcept {
  const ssize_t length = read(file_of(input), bytes, room);
  if (length >= 0) return static_cast<int>(length);
  return errno == EAGAIN || errno == EINTR ? 0 : -1;
}

int wait_for_report(void* input, std::int64_t until_ns) noexcept {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const std::int64_t left_ns = std::max<std::int64_t>(until_ns - monotonic_now_ns(), 0);
  const timespec left{left_ns / kSecond_ns, left_ns % kSecond_ns};
  pollfd waiting{file_of(input), POLLIN, 0};
  if (ppoll(&waiting, 1, &left, nullptr) <= 0) return 0;
  return (waiting.revents & POLLIN) != 0 ? 1 : -1;
}

int write_report(void* output, const std::uint8_t* bytes, std::size_t length) noexcept {
  return hid_write(handle_of(output), bytes, length);
}

int get_feature(void* output, std::uint8_t* bytes, std::size_t room) noexcept {
  return hid_get_feature_report(handle_of(output), bytes, room);
}

int set_feature(void* output, const std::uint8_t* bytes, std::size_t length) noexcept {
  return hid_send_feature_report(handle_of(output), bytes, length);
}

int open_locked(const HidrawNode& node) {
  const int file = open(node.path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (file < 0 && (errno == EACCES || errno == EPERM)) {
    throw DeviceError(node, "no permission to read and write it",
                      "Install deploy/udev/70-hapticd.rules, join its group with 'sudo usermod -aG "
                      "hapticd $USER', and log in again.");
  }
  if (file < 0) throw DeviceError(node, std::generic_category().message(errno), kPlugAgain);
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    close(file);
    throw DeviceError(node, "another hapticd uses it", "End that one: two would mix their forces.");
  }
  return file;
}

/// USB devices fall asleep when nothing reads; the switch for that is that of the nearest parent
/// which is a USB device. Most users may not, and most devices do not need it.
void keep_awake(const HidrawNode& node) {
  namespace fs = std::filesystem;
  std::error_code error;
  const std::string name = fs::path(node.path).filename();
  fs::path place = fs::canonical("/sys/class/hidraw/" + name + "/device", error);
  for (; !error && place.has_relative_path(); place = place.parent_path()) {
    if (!fs::exists(place / "idVendor", error)) continue;
    std::ofstream(place / "power/control") << "on";
    return;
  }
}

}  // namespace

void HidrawHandles::Close::operator()(hid_device_* handle) const noexcept { hid_close(handle); }

HidrawHandles::File::~File() { close(number); }

HidrawHandles::HidrawHandles(const HidrawNode& node)
    : node_(node), input_{open_locked(node)}, output_(hid_open_path(node.path.c_str())) {
  if (output_ == nullptr) throw DeviceError(node, "it cannot be opened", kPlugAgain);
  keep_awake(node);
}

HidrawHandles::~HidrawHandles() = default;

ReportChannel HidrawHandles::channel() noexcept {
  return {&input_.number, output_.get(), read_report,    write_report,
          get_feature,    set_feature,   wait_for_report};
}

ReportChannel HidrawHandles::features() {
  if (features_ == nullptr) features_.reset(hid_open_path(node_.path.c_str()));
  if (features_ == nullptr) throw DeviceError(node_, "it cannot be opened", kPlugAgain);
  return {nullptr, features_.get(), nullptr, write_report, get_feature, set_feature};
}

}  // namespace hapticd
