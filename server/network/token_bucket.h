// A bucket of tokens that come evenly. Pure. Times are ns, never going back. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>

namespace hapticd {

/// How fast tokens come, and how many there are after a rest.
struct TokenRate {
  std::int64_t period_ns = 1;  ///< between two tokens, > 0
  std::int64_t burst = 1;      ///< > 0
};

/// Kept as the instant when the bucket was empty: it is full when that is a whole burst ago.
class TokenBucket {
 public:
  /// Whether there is a token; if so it is taken.
  bool take(const TokenRate& rate, std::int64_t now_ns) noexcept {
    const std::int64_t begin_ns = std::max(empty_ns_, now_ns - rate.burst * rate.period_ns);
    if (begin_ns + rate.period_ns > now_ns) return false;
    empty_ns_ = begin_ns + rate.period_ns;
    return true;
  }

 private:
  std::int64_t empty_ns_ = 0;
};

}  // namespace hapticd
