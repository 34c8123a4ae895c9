// One direction of a network that loses, repeats, delays, reorders and damages datagrams, under a
// virtual clock and a seed: the same seed gives the same fate to every datagram. For tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::test {

/// What happens to each datagram, independently.
struct LinkConditions {
  double loss = 0.0;         ///< probability, of each copy
  double duplication = 0.0;  ///< probability of a second copy
  double damage = 0.0;       ///< probability that some bits change or the end is cut off
  std::int64_t delay_ns = 0;
  std::int64_t jitter_ns = 0;  ///< added uniformly: datagrams overtake each other by as much
};

using Datagram = std::vector<std::uint8_t>;

class LossyLink {
 public:
  LossyLink(const LinkConditions& conditions, std::uint64_t seed)
      : conditions_(conditions), random_(seed) {}

  /// Everything sent while it is on is lost.
  void set_blackhole(bool on) { blackhole_ = on; }
  void set_conditions(const LinkConditions& conditions) { conditions_ = conditions; }

  void send(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
    const int copies = random_.chance(conditions_.duplication) ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      const bool lost = random_.chance(conditions_.loss) || blackhole_;
      const double jitter = random_.uniform() * static_cast<double>(conditions_.jitter_ns);
      Datagram bytes(datagram.begin(), datagram.end());
      if (random_.chance(conditions_.damage)) damage(bytes);
      if (lost) continue;
      const auto at = now_ns + conditions_.delay_ns + static_cast<std::int64_t>(jitter);
      under_way_.emplace(at, std::move(bytes));
    }
  }

  /// When the next datagram arrives; `never` if none is under way.
  [[nodiscard]] std::int64_t next_ns(std::int64_t never) const {
    return under_way_.empty() ? never : under_way_.begin()->first;
  }

  /// What has arrived by now, in the order of arrival.
  std::vector<Datagram> arrived(std::int64_t now_ns) {
    std::vector<Datagram> all;
    while (!under_way_.empty() && under_way_.begin()->first <= now_ns) {
      all.push_back(std::move(under_way_.begin()->second));
      under_way_.erase(under_way_.begin());
    }
    return all;
  }

 private:
  void damage(Datagram& bytes) {
    if (bytes.empty()) return;
    if (random_.chance(0.3)) {
      bytes.resize(random_.below(bytes.size()));
      return;
    }
    for (std::uint64_t n = 1 + random_.below(4); n > 0; --n) {
      bytes[random_.below(bytes.size())] ^= static_cast<std::uint8_t>(1U << random_.below(8));
    }
  }

  LinkConditions conditions_;
  SplitMix64 random_;
  bool blackhole_ = false;
  std::multimap<std::int64_t, Datagram> under_way_;
};

}  // namespace hapticd::test
