// See uhid_device.h.
#include "tests/vm/uhid_device.h"

#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/rt/monotonic_clock.h"

namespace hapticd::test {
namespace {

/// Above the loop under test, as a device is not slowed by its host.
constexpr int kPriority = 90;

/// A frame that begins so late was kept by the kernel; waking takes a tenth of it.
constexpr std::int64_t kHeldUp_ns = 200'000;

void write_all(int file, const uhid_event& event) {
  if (::write(file, &event, sizeof(event)) < 0 && errno != EAGAIN) {
    throw std::system_error(errno, std::generic_category(), "uhid");
  }
}

}  // namespace

UhidDevice::UhidDevice(const UhidOptions& options, Motion motion)
    : firmware_(options, std::move(motion)), rate_hz_(options.rate_hz) {
  uhid_ = ::open("/dev/uhid", O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (uhid_ < 0) throw std::system_error(errno, std::generic_category(), "/dev/uhid");
  create(options);
  thread_ = std::thread([this] { run(); });
  sched_param priority{};
  priority.sched_priority = kPriority;
  pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
}

UhidDevice::~UhidDevice() {
  ending_ = true;
  thread_.join();
  close(uhid_);
}

void UhidDevice::create(const UhidOptions& options) const {
  uhid_event create{};
  create.type = UHID_CREATE2;
  uhid_create2_req& c = create.u.create2;
  std::strncpy(reinterpret_cast<char*>(c.name), "hapticd reference device", sizeof(c.name) - 1);
  std::strncpy(reinterpret_cast<char*>(c.uniq), options.serial.c_str(), sizeof(c.uniq) - 1);
  const std::vector<std::uint8_t> descriptor = report_descriptor(options);
  std::memcpy(c.rd_data, descriptor.data(), descriptor.size());
  c.rd_size = static_cast<std::uint16_t>(descriptor.size());
  c.bus = BUS_USB;
  c.vendor = options.vendor_id;
  c.product = options.product_id;
  write_all(uhid_, create);
}

void UhidDevice::frame() {
  sampled_ns_ = monotonic_now_ns();
  firmware_.frame();
  HapState state{};
  if (!firmware_.take(state)) return;
  uhid_event input{};
  input.type = UHID_INPUT2;
  input.u.input2.size = sizeof(state);
  std::memcpy(input.u.input2.data, &state, sizeof(state));
  write_all(uhid_, input);
}

void UhidDevice::answer(const uhid_event& event) {
  uhid_event reply{};
  if (event.type == UHID_OUTPUT) {
    firmware_.receive(event.u.output.data, event.u.output.size);
  } else if (event.type == UHID_GET_REPORT) {
    reply.type = UHID_GET_REPORT_REPLY;
    reply.u.get_report_reply.id = event.u.get_report.id;
    std::uint8_t* data = reply.u.get_report_reply.data;
    const std::uint32_t length =
        firmware_.get_feature(event.u.get_report.rnum, data, kHapReportBytes);
    reply.u.get_report_reply.size = static_cast<std::uint16_t>(length);
    reply.u.get_report_reply.err = length > 0 ? 0 : EIO;
    write_all(uhid_, reply);
  } else if (event.type == UHID_SET_REPORT) {
    reply.type = UHID_SET_REPORT_REPLY;
    reply.u.set_report_reply.id = event.u.set_report.id;
    const bool good = firmware_.receive(event.u.set_report.data, event.u.set_report.size);
    reply.u.set_report_reply.err = good ? 0 : EIO;
    write_all(uhid_, reply);
  }
}

void UhidDevice::take_events() {
  uhid_event event{};
  while (::read(uhid_, &event, sizeof(event)) > 0) {
    answer(event);
    event = {};
  }
}

// Sleeps until the next frame, or until the host says something.
void UhidDevice::run() {
  std::int64_t due_ns = monotonic_now_ns();
  while (!ending_) {
    const std::int64_t wait_ns = due_ns - monotonic_now_ns();
    if (wait_ns > 0) {
      pollfd waiting{uhid_, POLLIN, 0};
      const timespec left{wait_ns / 1'000'000'000, wait_ns % 1'000'000'000};
      ppoll(&waiting, 1, &left, nullptr);
    }
    take_events();
    const std::int64_t late_ns = monotonic_now_ns() - due_ns;
    if (late_ns < 0) continue;
    if (late_ns > kHeldUp_ns) ++held_up_;
    frame();
    due_ns += 1'000'000'000 / std::max(1, rate_hz_.load());
  }
}

}  // namespace hapticd::test
