// Where the time of a tick goes, stage by stage. The simulation has no clock of its own: who steps
// it lends one, and nothing is computed from what it says. RT: yes; a lap costs a look at the clock
// it is given, one that was not lent a comparison.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd {

/// A part of the tick, with the number of hapticd::v1::Stage less one.
enum class Stage : std::uint8_t {
  kRead,          ///< devices read, poses judged, state of the loop advanced
  kCollision,     ///< traversals for pairs near the tools
  kOptimisation,  ///< the rest of the contact problems (v1::STAGE_SOLVER)
  kStrings,       ///< strings' response, touches and releases
  kSafety,        ///< all that limits wrenches
  kWrite,         ///< devices written
  kPublish,       ///< events, contacts and the tick told, snapshot
};

/// How many of them there are.
inline constexpr std::size_t kStages = 7;

/// Time of every stage, ns, by number.
using StageTimes = std::array<std::uint32_t, kStages>;

/// All of the simulation: collision, optimisation and strings, ns.
[[nodiscard]] constexpr std::uint32_t simulation_ns(const StageTimes& times) noexcept {
  return times[static_cast<std::size_t>(Stage::kCollision)] +
         times[static_cast<std::size_t>(Stage::kOptimisation)] +
         times[static_cast<std::size_t>(Stage::kStrings)];
}

/// Cuts the time of a tick into laps.
class StageClock {
 public:
  using Now = std::int64_t (*)() noexcept;

  /// `now`: a clock that never goes back, ns.
  explicit StageClock(Now now) noexcept : now_(now) {}

  /// Begins a tick at `now_ns`.
  void start(std::int64_t now_ns) noexcept {
    last_ns_ = now_ns;
    times_ = {};
  }
  /// All that has passed since the last call was of `stage`.
  void lap(Stage stage) noexcept {
    const std::int64_t now_ns = now_();
    times_[static_cast<std::size_t>(stage)] += static_cast<std::uint32_t>(now_ns - last_ns_);
    last_ns_ = now_ns;
  }
  /// Since start().
  [[nodiscard]] const StageTimes& times() const noexcept { return times_; }

 private:
  Now now_;
  std::int64_t last_ns_ = 0;
  StageTimes times_{};
};

/// A lap of a clock that may not have been lent.
inline void lap(StageClock* clock, Stage stage) noexcept {
  if (clock != nullptr) clock->lap(stage);
}

}  // namespace hapticd
