// When to tell a person that nobody answers: once, and not before an answer may be expected. Pure.
// Not RT.
#pragma once

#include <cstdint>

namespace hapticd::client {

/// Time that a daemon or a broker gets to answer at first, ns: a handshake is repeated every
/// 250 ms, and a broker is tried every 500 ms. Longer: a person wonders longer.
inline constexpr std::int64_t kPatience_ns = 3'000'000'000;

class Patience {
 public:
  explicit Patience(std::int64_t began_ns) noexcept : began_ns_(began_ns) {}

  /// True once: when kPatience_ns have passed and nobody has ever answered.
  [[nodiscard]] bool ends(bool answered, std::int64_t now_ns) noexcept {
    if (over_ || answered) {
      over_ = true;
      return false;
    }
    over_ = now_ns - began_ns_ >= kPatience_ns;
    return over_;
  }

 private:
  std::int64_t began_ns_;
  bool over_ = false;
};

}  // namespace hapticd::client
