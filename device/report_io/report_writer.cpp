// See report_writer.h. RT: post, zero, stuck.
#include "device/report_io/report_writer.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace hapticd {

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
  failed_.store(false, std::memory_order_relaxed);
}

void ReportWriter::detach() {
  const std::lock_guard lock(channel_mutex_);
  channel_ = ReportChannel{};
}

// A full eventfd would block; it never is, since the thread empties it with every look.
void ReportWriter::wake() const noexcept {
  const std::uint64_t one = 1;
  static_cast<void>(::write(event_, &one, sizeof(one)));
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

void ReportWriter::send(const OutputReports& reports, std::uint32_t attachment) {
  const std::lock_guard lock(channel_mutex_);
  if (attachment != attachment_) return;
  for (const OutputReport& report : reports) {
    if (channel_.write == nullptr || failed()) return;
    if (channel_.write(channel_.output, report.bytes.data(), report.length) < 0) {
      failed_.store(true, std::memory_order_relaxed);
    }
  }
}

void ReportWriter::run() {
  std::int64_t obeyed_ns = kNever_ns;
  while (true) {
    std::uint64_t count = 0;
    if (::read(event_, &count, sizeof(count)) < 0 && errno != EINTR) return;
    if (ending_.load()) return;
    const bool fresh = slot_.update();
    const PostedCommand& command = slot_.latest();
    const std::int64_t revoked_ns = revoked_ns_.load();
    if (command.posted_ns <= revoked_ns) {
      if (fresh || obeyed_ns != revoked_ns) send(command.instead, command.attachment);
    } else if (fresh) {
      send(clock_() < command.expires_ns ? command.reports : command.instead, command.attachment);
    }
    obeyed_ns = revoked_ns;
    done_ns_.store(command.posted_ns, std::memory_order_relaxed);
  }
}

}  // namespace hapticd
