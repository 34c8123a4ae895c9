// One question to a daemon over its Stop road: what to send next, and what the answers mean. Pure:
// no socket, no clock. Not RT. PROTOCOL.md, section 17.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "proto/stop/stop_datagram.h"

namespace hapticd::stop {

/// Who is meant, and by what right.
struct StopTarget {
  std::uint16_t session_port = 0;  ///< of the daemon's sessions; 0: whoever answers
  std::optional<SecretKey> key;    ///< none: in the clear, which loopback alone hears
};

class StopCall {
 public:
  enum class State : std::uint8_t {
    kAsking,       ///< send on
    kDone,         ///< of a STOP: the loop has latched it
    kOtherDaemon,  ///< another daemon is there
    kRefused,      ///< answer().code says why
  };

  /// `client`: random, not 0.
  StopCall(Kind kind, const StopTarget& target, std::uint64_t client);

  /// What leaves now; once more until an answer ends it.
  [[nodiscard]] Datagram next();
  /// Takes a datagram; true when it is an authentic answer.
  bool receive(std::span<const std::uint8_t> bytes);

  [[nodiscard]] State state() const noexcept { return state_; }
  /// The daemon has taken the Stop, and its loop will with its next tick.
  [[nodiscard]] bool asked() const noexcept { return asked_; }
  /// The newest answer; none: nobody has answered.
  [[nodiscard]] const std::optional<Answer>& answer() const noexcept { return answer_; }

 private:
  StopTarget target_;
  Request request_;
  Kind kind_;  ///< of the first question
  std::optional<Answer> answer_;
  State state_ = State::kAsking;
  bool asked_ = false;
};

}  // namespace hapticd::stop
