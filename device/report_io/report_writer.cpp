// See report_writer.h. RT: post, zero, stuck.
#include "device/report_io/report_writer.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/rt/thread_role.h"

namespace hapticd {
namespace {

constexpr unsigned kNumberBits = 16;
constexpr unsigned kByteBits = 8;
/// Tag of a number with which no command, or only a stand-in for one, has gone out.
constexpr std::uint64_t kNoTag = ~std::uint64_t{0} >> kNumberBits;

}  // namespace

ReportWriter::ReportWriter(Clock clock) : clock_(clock), event_(eventfd(0, EFD_CLOEXEC)) {
  if (event_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  thread_ = std::thread([this] { run(); });
}

ReportWriter::~ReportWriter() {
  ending_.store(true);
  wake();
  thread_.join();
  close(event_);
}

void ReportWriter::attach(const ReportChannel& channel, std::uint32_t attachment) {
  const std::lock_guard lock(channel_mutex_);
  channel_ = channel;
  attachment_ = attachment;
  for (auto& sent : sent_) sent.store(kNoTag << kNumberBits, std::memory_order_relaxed);
  failed_.store(false, std::memory_order_relaxed);
}

void ReportWriter::detach() {
  const std::lock_guard lock(channel_mutex_);
  channel_ = ReportChannel{};
}

// A full eventfd would block; it never is, since the thread empties it with every look.
void ReportWriter::wake() const noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(event_, &one, sizeof(one));
}

void ReportWriter::post(const PostedCommand& command) noexcept {
  slot_.write(command);
  posted_ns_ = command.posted_ns;
  wake();
}

void ReportWriter::revoke(std::int64_t now_ns) noexcept {
  std::int64_t before = revoked_ns_.load(std::memory_order_relaxed);
  while (before < now_ns && !revoked_ns_.compare_exchange_weak(before, now_ns)) {
  }
  wake();
}

bool ReportWriter::stuck(std::int64_t now_ns) noexcept {
  const std::int64_t done_ns = done_ns_.load(std::memory_order_relaxed);
  if (done_ns != done_seen_ns_ || done_ns == posted_ns_) {
    done_seen_ns_ = done_ns;
    waiting_since_ns_ = now_ns;
  }
  return now_ns - waiting_since_ns_ > kStuckAfter_ns;
}

std::optional<std::uint64_t> ReportWriter::sent(std::uint16_t number) const noexcept {
  const std::uint64_t entry = sent_[number % kNumberedCommands].load(std::memory_order_relaxed);
  const bool same = static_cast<std::uint16_t>(entry) == number;
  if (!same || entry >> kNumberBits == kNoTag) return std::nullopt;
  return entry >> kNumberBits;
}

/// Puts the next number into `reports`, and remembers it before the device can report it.
void ReportWriter::number(const PostedCommand& command, bool instead, OutputReports& reports) {
  const std::uint16_t number = next_number_++;
  for (OutputReport& report : reports) {
    report.bytes[command.number_at] = static_cast<std::uint8_t>(number);
    report.bytes[command.number_at + 1U] = static_cast<std::uint8_t>(number >> kByteBits);
  }
  const std::uint64_t tag = instead ? kNoTag : command.tag;
  sent_[number % kNumberedCommands].store(tag << kNumberBits | number, std::memory_order_relaxed);
}

void ReportWriter::send(const PostedCommand& command, bool instead) {
  const std::lock_guard lock(channel_mutex_);
  if (command.attachment != attachment_ || channel_.write == nullptr || failed()) return;
  OutputReports reports = instead ? command.instead : command.reports;
  if (command.number_at != 0) number(command, instead, reports);
  for (const OutputReport& report : reports) {
    if (failed()) return;
    if (channel_.write(channel_.output, report.bytes.data(), report.length) < 0) {
      failed_.store(true, std::memory_order_relaxed);
    }
  }
}

void ReportWriter::run() {
  begin_role(ThreadRole::kWriter);
  std::int64_t obeyed_ns = kNever_ns;
  while (true) {
    std::uint64_t count = 0;
    if (::read(event_, &count, sizeof(count)) < 0 && errno != EINTR) return;
    if (ending_.load()) return;
    const bool fresh = slot_.update();
    const PostedCommand& command = slot_.latest();
    const std::int64_t revoked_ns = revoked_ns_.load();
    if (command.posted_ns <= revoked_ns) {
      if (fresh || obeyed_ns != revoked_ns) send(command, true);
    } else if (fresh) {
      send(command, clock_() >= command.expires_ns);
    }
    obeyed_ns = revoked_ns;
    done_ns_.store(command.posted_ns, std::memory_order_relaxed);
  }
}

}  // namespace hapticd
