// See usbip_device.h. Section numbers are those of the USB 2.0 specification, where nothing else
// is said.
#include "tests/vm/usbip_device.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <string>
#include <string_view>
#include <system_error>

#include "core/rt/monotonic_clock.h"

namespace hapticd::test {
namespace {

/// Above the loop under test, as a device is not slowed by its host.
constexpr int kPriority = 90;
constexpr const char* kAttach = "/sys/devices/platform/vhci_hcd.0/attach";
/// Ports of the virtual hub for full and high speed.
constexpr int kPorts = 8;
/// Bus and address that we tell the host; of no meaning.
constexpr std::uint32_t kBusAndAddress = 0x0001'0002;

/// Every message begins with 48 bytes, big-endian words but for a setup packet in the last two.
constexpr std::size_t kHeadBytes = 48;
constexpr std::size_t kSetupPlace = 40;
using Head = std::array<std::uint8_t, kHeadBytes>;
enum Word : std::uint8_t { kCommand, kNumber, kDevice, kDirection, kEndpoint, kStatus, kLength };
enum Command : std::uint8_t { kSubmit = 1, kUnlink = 2, kSubmitDone = 3, kUnlinkDone = 4 };
/// In the word kStatus of kUnlink.
constexpr Word kVictim = kStatus;

/// bmRequestType, table 9-2.
constexpr std::uint8_t kToHost = 0x80;
constexpr std::uint8_t kTypeMask = 0x60;
constexpr std::uint8_t kClassRequest = 0x20;
/// bRequest: table 9-4, and HID 1.11, section 7.2.
constexpr std::uint8_t kGetStatus = 0x00;
constexpr std::uint8_t kGetDescriptor = 0x06;
constexpr std::uint8_t kGetReport = 0x01;
constexpr std::uint8_t kSetReport = 0x09;
/// Types of descriptors: table 9-5, and HID 1.11, section 7.1.
constexpr std::uint8_t kDeviceType = 1;
constexpr std::uint8_t kConfigurationType = 2;
constexpr std::uint8_t kStringType = 3;
constexpr std::uint8_t kReportType = 0x22;

std::uint32_t word(const Head& head, Word which) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8U | head[std::size_t{4} * which + k];
  return value;
}

void put(Head& head, Word which, std::uint32_t value) {
  for (std::size_t k = 0; k < 4; ++k) {
    head[std::size_t{4} * which + k] = static_cast<std::uint8_t>(value >> (24 - 8 * k));
  }
}

/// Table 9-8.
std::vector<std::uint8_t> device_descriptor(const FirmwareOptions& options) {
  const auto low = [](std::uint16_t value) { return static_cast<std::uint8_t>(value & 0xFFU); };
  const auto high = [](std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8U); };
  return {18,
          kDeviceType,
          0x00,
          0x02,
          0,
          0,
          0,
          64,
          low(options.vendor_id),
          high(options.vendor_id),
          low(options.product_id),
          high(options.product_id),
          0x00,
          0x01,
          1,
          2,
          3,
          1};
}

/// Tables 9-10, 9-12, 9-13 and HID 1.11, section 6.2.1: one interface, IN and OUT at each frame.
std::vector<std::uint8_t> configuration_descriptor(std::size_t report_bytes) {
  constexpr std::uint8_t kTotal = 9 + 9 + 9 + 7 + 7;
  return {9,
          kConfigurationType,
          kTotal,
          0,
          1,
          1,
          0,
          0x80,
          250,  //
          9,
          4,
          0,
          0,
          2,
          3,
          0,
          0,
          0,  //
          9,
          0x21,
          0x11,
          0x01,
          0,
          1,
          kReportType,
          static_cast<std::uint8_t>(report_bytes & 0xFFU),
          static_cast<std::uint8_t>(report_bytes >> 8U),  //
          7,
          5,
          0x81,
          3,
          64,
          0,
          1,  //
          7,
          5,
          0x01,
          3,
          64,
          0,
          1};
}

/// Table 9-16: UTF-16, of which ASCII is enough here.
std::vector<std::uint8_t> string_descriptor(std::string_view text) {
  std::vector<std::uint8_t> bytes(2 + 2 * text.size());
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  bytes[1] = kStringType;
  for (std::size_t k = 0; k < text.size(); ++k) {
    bytes[2 + 2 * k] = static_cast<std::uint8_t>(text[k]);
  }
  return bytes;
}

/// Gives the kernel its end of the connection, at the first port that takes it.
void attach(int kernel_end, UsbSpeed speed) {
  const int file = open(kAttach, O_WRONLY | O_CLOEXEC);
  bool attached = false;
  for (int port = 0; port < kPorts && file >= 0 && !attached; ++port) {
    const std::string text = std::to_string(port) + " " + std::to_string(kernel_end) + " " +
                             std::to_string(kBusAndAddress) + " " +
                             std::to_string(static_cast<int>(speed));
    attached = write(file, text.data(), text.size()) >= 0;
  }
  const int error = errno;
  if (file >= 0) close(file);
  if (!attached) throw std::system_error(error, std::generic_category(), kAttach);
}

}  // namespace

UsbipDevice::UsbipDevice(const FirmwareOptions& options, UsbSpeed speed)
    : firmware_(options),
      options_(options),
      frame_ns_(speed == UsbSpeed::kFull ? 1'000'000 : 125'000) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  socket_ = ends[0];
  attach(ends[1], speed);
  close(ends[1]);
  thread_ = std::thread([this] { run(); });
  sched_param priority{};
  priority.sched_priority = kPriority;
  pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
}

UsbipDevice::~UsbipDevice() {
  ending_ = true;
  shutdown(socket_, SHUT_RDWR);
  thread_.join();
  close(socket_);
}

// Sleeps until the next frame, or until the host says something.
void UsbipDevice::run() {
  std::int64_t due_ns = monotonic_now_ns();
  while (!ending_) {
    const std::int64_t wait_ns = std::max<std::int64_t>(due_ns - monotonic_now_ns(), 0);
    pollfd waiting{socket_, POLLIN, 0};
    const timespec left{wait_ns / 1'000'000'000, wait_ns % 1'000'000'000};
    if (ppoll(&waiting, 1, &left, nullptr) > 0 && !take_message()) return;
    if (monotonic_now_ns() < due_ns) continue;
    frame();
    due_ns += frame_ns_;
  }
}

void UsbipDevice::frame() {
  firmware_.frame();
  if (!outputs_.empty() && !output_hangs_) {
    const Transfer output = std::move(outputs_.front());
    outputs_.pop_front();
    firmware_.receive(output.data.data(), output.length);
    complete(output.number, 0, output.length, {});
  }
  waiting_outputs_ = outputs_.size();
  HapState state{};
  if (inputs_.empty() || !firmware_.take(state)) return;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&state);
  const Transfer input = inputs_.front();
  inputs_.pop_front();
  complete(input.number, 0, 0, {bytes, bytes + std::min<std::size_t>(sizeof(state), input.length)});
}

bool UsbipDevice::take_message() {
  Head head{};
  if (recv(socket_, head.data(), head.size(), MSG_WAITALL) != kHeadBytes) return false;
  const std::uint32_t number = word(head, kNumber);
  if (word(head, kCommand) == kUnlink) {
    unlink(number, word(head, kVictim));
    return true;
  }
  if (word(head, kCommand) != kSubmit) return false;
  Transfer transfer{number, word(head, kLength), {}, {}};
  std::copy(head.begin() + kSetupPlace, head.end(), transfer.setup.begin());
  const bool to_host = word(head, kDirection) != 0;
  if (!to_host && transfer.length > 0) {
    transfer.data.resize(transfer.length);
    const auto got = recv(socket_, transfer.data.data(), transfer.length, MSG_WAITALL);
    if (got != static_cast<ssize_t>(transfer.length)) return false;
  }
  if (word(head, kEndpoint) == 0) {
    control(transfer, to_host);
  } else if (to_host) {
    inputs_.push_back(std::move(transfer));
  } else {
    outputs_.push_back(std::move(transfer));
    waiting_outputs_ = outputs_.size();
  }
  return true;
}

void UsbipDevice::control(const Transfer& transfer, bool to_host) {
  const bool of_class = (transfer.setup[0] & kTypeMask) == kClassRequest;
  Answer answer = of_class ? hid_class(transfer) : standard(transfer);
  if (answer.data.size() > transfer.length) answer.data.resize(transfer.length);
  complete(transfer.number, answer.stall ? -EPIPE : 0,
           answer.stall || to_host ? 0 : transfer.length, answer.data);
}

UsbipDevice::Answer UsbipDevice::standard(const Transfer& transfer) const {
  const auto& setup = transfer.setup;
  if (setup[1] == kGetDescriptor) return descriptor(setup[3], setup[2]);
  if (setup[1] == kGetStatus) return {false, {0, 0}};
  return {(setup[0] & kToHost) != 0, {}};
}

UsbipDevice::Answer UsbipDevice::descriptor(std::uint8_t type, std::uint8_t index) const {
  if (type == kDeviceType) return {false, device_descriptor(options_)};
  if (type == kConfigurationType)
    return {false, configuration_descriptor(report_descriptor(options_).size())};
  if (type == kReportType) return {false, report_descriptor(options_)};
  if (type != kStringType) return {true, {}};
  if (index == 1) return {false, string_descriptor("hapticd")};
  if (index == 2) return {false, string_descriptor("reference device")};
  if (index == 3) return {false, string_descriptor(options_.serial)};
  return {index != 0, {4, kStringType, 0x09, 0x04}};
}

UsbipDevice::Answer UsbipDevice::hid_class(const Transfer& transfer) {
  const auto& setup = transfer.setup;
  const std::uint8_t id = setup[2];
  if (setup[1] == kGetReport) {
    Bytes report(kHapReportBytes);
    report.resize(firmware_.get_feature(id, report.data(), kHapReportBytes));
    return {report.empty() || id == stalled_feature_, std::move(report)};
  }
  if (setup[1] == kSetReport) {
    const bool taken =
        id != stalled_feature_ && firmware_.receive(transfer.data.data(), transfer.length);
    return {!taken, {}};
  }
  // SET_IDLE and SET_PROTOCOL: nothing that concerns this device.
  return {(setup[0] & kToHost) != 0, {}};
}

void UsbipDevice::unlink(std::uint32_t number, std::uint32_t victim) {
  const auto drop = [victim](std::deque<Transfer>& queue) {
    const auto is_it = [victim](const Transfer& transfer) { return transfer.number == victim; };
    const auto found = std::find_if(queue.begin(), queue.end(), is_it);
    if (found == queue.end()) return false;
    queue.erase(found);
    return true;
  };
  const bool dropped = drop(inputs_) || drop(outputs_);
  waiting_outputs_ = outputs_.size();
  Head head{};
  put(head, kCommand, kUnlinkDone);
  put(head, kNumber, number);
  put(head, kStatus, dropped ? static_cast<std::uint32_t>(-ECONNRESET) : 0);
  send(socket_, head.data(), head.size(), MSG_NOSIGNAL);
}

// A connection that ends meanwhile is noticed where messages are taken.
void UsbipDevice::complete(std::uint32_t number, std::int32_t status, std::uint32_t done,
                           const Bytes& data) {
  Head head{};
  put(head, kCommand, kSubmitDone);
  put(head, kNumber, number);
  put(head, kStatus, static_cast<std::uint32_t>(status));
  const Bytes none;
  const Bytes& sent = status == 0 ? data : none;
  put(head, kLength, done + static_cast<std::uint32_t>(sent.size()));
  Bytes message(head.begin(), head.end());
  message.insert(message.end(), sent.begin(), sent.end());
  send(socket_, message.data(), message.size(), MSG_NOSIGNAL);
}

}  // namespace hapticd::test
