// What the Stop road makes of a datagram: whether it is authentic, meant for this daemon and no
// repetition, what it changes, and the answer, which is never longer. Keeps nothing for peers
// without the key. Pure but for the words it shares with the loop: addresses and times come from
// the caller. No heap, no lock. Not RT. PROTOCOL.md, section 17.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/stop/stop_counters.h"
#include "proto/stop/stop_datagram.h"
#include "server/haptic_loop/stop_line.h"
#include "server/stop_road/heartbeats.h"

namespace hapticd {

/// How long a challenge is good for a STOP or a LEAVE, ns. Longer: a datagram that was withheld on
/// the way stops later; shorter: slow networks need more than one. A HEARTBEAT's challenge is good
/// for the time-out it chooses.
inline constexpr std::int64_t kChallengeLife_ns = 1'000'000'000;

/// Where a datagram came from.
struct StopPeer {
  std::array<std::uint8_t, 16> ip{};  ///< IPv4 in its IPv6-mapped form
  std::uint16_t port = 0;
  bool loopback = false;
};

struct StopRules {
  std::optional<stop::SecretKey> key;     ///< none: only loopback is heard, and no heartbeat
  std::uint16_t session_port = 0;         ///< of this daemon
  std::array<std::uint8_t, 16> secret{};  ///< random, of this start alone
};

class StopJudge {
 public:
  /// `line` must outlive this.
  StopJudge(const StopRules& rules, StopLine& line) : rules_(rules), line_(line) {}

  /// Obeys a datagram that came at `now_ns`, which never goes back; returns the answer, if it gets
  /// one. About 2 us with a tag, 0.1 us without.
  std::optional<stop::Datagram> receive(std::span<const std::uint8_t> bytes, const StopPeer& from,
                                        std::int64_t now_ns) noexcept;
  /// Time passes: heartbeats that are absent are let go where the loop has heard a Clear.
  void look(std::int64_t now_ns) noexcept;

  [[nodiscard]] const StopCounters& counters() const noexcept { return counters_; }
  /// The answer that was returned last did not leave.
  void note_unanswered() noexcept { counters_.unanswered.add(); }

 private:
  /// A request that may be obeyed, and how it came.
  struct Heard {
    stop::Request request;
    const StopPeer& from;
    std::int64_t now_ns;
    bool sealed;
  };

  [[nodiscard]] bool authentic(const stop::Datagram& datagram, const StopPeer& from) const noexcept;
  [[nodiscard]] stop::Code judge(const Heard& heard) noexcept;
  [[nodiscard]] bool fresh(const Heard& heard) const noexcept;
  [[nodiscard]] stop::Code obey(const Heard& heard) noexcept;
  [[nodiscard]] stop::Code count(Heartbeats::Verdict verdict) noexcept;
  [[nodiscard]] std::uint64_t proof_of(const Heard& heard, std::uint64_t issued_ns) const noexcept;
  [[nodiscard]] stop::Datagram answer(const Heard& heard, stop::Code code) noexcept;
  void hold() noexcept;

  StopRules rules_;
  StopLine& line_;
  Heartbeats heartbeats_;
  StopCounters counters_;
  std::uint32_t clears_seen_ = 0;
  std::uint64_t last_issued_ns_ = 0;  ///< of the newest challenge
  std::uint64_t stop_used_ns_ = 0;    ///< no challenge issued up to here stops any more
};

}  // namespace hapticd
