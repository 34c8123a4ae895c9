// The thread that sends commands to a device, so that the loop never waits for USB: a slot that
// holds the newest command, and an eventfd that says there is one. A device that takes no reports
// blocks this thread for seconds and no other. A command that is no longer true when its turn
// comes is replaced by what it names instead. Where a device counts its commands, the number is put
// in when one goes out: those that were overtaken in the slot leave no gap, and a zero that takes
// force back later has its own number. RT: post, revoke, stuck and sent; the thread is not.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>

#include "core/math/fixed_vector.h"
#include "core/math/realtime.h"
#include "core/rt/triple_buffer.h"
#include "device/api/report_channel.h"

namespace hapticd {

/// If a command is not taken for this long, forces no longer reach the device, ns.
inline constexpr std::int64_t kStuckAfter_ns = 5'000'000;
/// Before every instant.
inline constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::min();
/// Output reports that make one command, at most: one for each axis of a device of the PID class.
inline constexpr std::size_t kMaxReportsPerCommand = 3;

/// Commands whose number is remembered: a device's echo is at most this many commands old.
inline constexpr std::size_t kNumberedCommands = 256;

/// One output report, ID first.
struct OutputReport {
  std::array<std::uint8_t, kMaxReport> bytes{};
  std::uint8_t length = 0;
};
using OutputReports = FixedVector<OutputReport, kMaxReportsPerCommand>;

/// A command and its times, by the monotonic clock.
struct PostedCommand {
  OutputReports reports;
  OutputReports instead;  ///< sent when it has expired or was revoked: no force
  std::int64_t posted_ns = kNever_ns;
  std::int64_t expires_ns = std::numeric_limits<std::int64_t>::max();
  std::uint32_t attachment = 0;  ///< it was made for, as the reader's gate counts them
  /// Place in every report of the command's number, 16 bits, least first; 0: there is none.
  std::uint8_t number_at = 0;
  std::uint64_t tag = 0;  ///< what sent() says of it, below 2^48 - 1
};

class ReportWriter {
 public:
  using Clock = std::int64_t (*)() noexcept;

  /// Starts the thread. `clock`: the clock of all times here. Throws std::system_error when the
  /// system has no eventfd or thread left.
  explicit ReportWriter(Clock clock);
  /// Ends it; waits for a write that is under way.
  ~ReportWriter();
  ReportWriter(const ReportWriter&) = delete;
  ReportWriter& operator=(const ReportWriter&) = delete;

  /// What commands for this attachment go to from here on. Those for another are not sent: a device
  /// plugged in again gets nothing that was meant before. Not RT.
  void attach(const ReportChannel& channel, std::uint32_t attachment);
  /// Nothing is sent from here on; waits for a write that is under way. Not RT.
  void detach();

  /// Makes this the command to send. Loop's thread.
  HD_REALTIME void post(const PostedCommand& command) noexcept;
  /// Every command posted at `now_ns` or before is replaced by its `instead`, sent or not. Any
  /// thread.
  HD_REALTIME void revoke(std::int64_t now_ns) noexcept;
  /// Commands were posted and for kStuckAfter_ns none was sent. Loop's thread, once
  /// per tick before post().
  [[nodiscard]] HD_REALTIME bool stuck(std::int64_t now_ns) noexcept;
  /// The device refused a command, or is gone. False again after attach().
  [[nodiscard]] HD_REALTIME bool failed() const noexcept {
    return failed_.load(std::memory_order_relaxed);
  }
  /// The tag of the command that went out with this number since attach(), itself and not what it
  /// names instead. Any thread.
  [[nodiscard]] HD_REALTIME std::optional<std::uint64_t> sent(std::uint16_t number) const noexcept;
  /// For its policy.
  [[nodiscard]] std::thread& thread() noexcept { return thread_; }

 private:
  void run();
  void send(const PostedCommand& command, bool instead);
  void number(const PostedCommand& command, bool instead, OutputReports& reports);
  HD_REALTIME void wake() const noexcept;

  TripleBuffer<PostedCommand> slot_;  ///< first, for its cache lines
  Clock clock_;
  int event_ = -1;
  std::atomic<std::int64_t> revoked_ns_{kNever_ns};
  std::atomic<std::int64_t> done_ns_{kNever_ns};  ///< posted_ns of the last that was dealt with
  std::atomic<bool> failed_{false};
  std::atomic<bool> ending_{false};
  std::int64_t posted_ns_ = kNever_ns;     ///< loop's: of the last command
  std::int64_t done_seen_ns_ = kNever_ns;  ///< loop's
  std::int64_t waiting_since_ns_ = 0;      ///< loop's
  std::mutex channel_mutex_;               ///< not the loop's
  ReportChannel channel_;
  std::uint32_t attachment_ = 0;  ///< what channel_ is for
  std::uint16_t next_number_ = 1;
  /// By number, modulo: its tag, and below it in 16 bits the number.
  std::array<std::atomic<std::uint64_t>, kNumberedCommands> sent_{};
  std::thread thread_;
};

}  // namespace hapticd
