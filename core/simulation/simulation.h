// The tick: a pose sample in; graphic tool, wrench, strings and events out. Contact problem of the
// tool (rendering), then the response of every string that is touched or rings (instrument), whose
// vibration adds to the wrench, then the limits. `step` is a pure function of state and input: no
// clock, device or random source; the same scene and inputs give the same bits everywhere. Strings
// that are untouched and silent are never looked at outside the broad phase. RT: yes.
#pragma once

#include <array>
#include <span>

#include "core/instrument/string_response.h"
#include "core/rendering/tool_renderer.h"
#include "core/simulation/contact_report.h"

namespace hapticd {

/// Strings of a scene, at most.
inline constexpr int kMaxStrings = 1024;

/// What one tick is computed from.
struct TickInput {
  PoseSample sample;
};

/// A string that is not asleep after the tick.
struct StringReading {
  std::int32_t string = 0;
  StringLevel level = StringLevel::kRigid;
  bool touched = false;
  bool armed = false;            ///< letting go plucks it
  double lambda = 0.5;           ///< of the touch, or of the release
  double radius_growth = 0.0;    ///< to draw beyond R: delta while touched, the envelope after, m
  double vibration_force = 0.0;  ///< F_v along the touch normal, N
  Vector3 deflection_W;          ///< of its vertex, m
};

/// What one tick gives.
struct TickOutput {
  ToolTick tool;
  StringEvents events;
  FixedVector<StringReading, kMaxStrings> strings;
};

/// What the simulation keeps of each string between ticks.
struct StringTrack {
  StringState state;
  double distance = 1.0;       ///< StringTouch::distance of the last tick, m; 1: not near
  Vector3 u_W{0.0, 0.0, 0.0};  ///< deflection, m
  Vector3 v_W{0.0, 0.0, 0.0};  ///< its rate over the last tick, m/s
  /// Where its vibration has pushed the tool since: the normal, and the place from G, m.
  Vector3 nhat_W{0.0, 0.0, 0.0};
  Vector3 p_GC_W{0.0, 0.0, 0.0};
};

/// One tool among the strings and bodies of a scene.
class Simulation {
 public:
  /// `scene`'s views, `tracks` (one per string) and `modes` (one per string, or none when
  /// scene.instrument.modes is 0) must outlive this; at most kMaxStrings strings.
  Simulation(const ToolScene& scene, std::span<StringTrack> tracks,
             std::span<ModalString> modes) noexcept;

  /// One tick. Cost: about 0.3 us free, 2 us on a string (tests/benchmark).
  HD_REALTIME void step(const TickInput& input, TickOutput& output) noexcept;

  /// The contacts as they are after step(), deepest first. Cost: about 40 ns per listed pair.
  HD_REALTIME void report_contacts(ContactReport& report) const noexcept;

  /// What the vibrating strings may still give to the hand, J.
  [[nodiscard]] HD_REALTIME double tank_energy() const noexcept;

  /// Clears a latched pose fault; the next good sample is accepted again.
  void clear_fault() noexcept { hapticd::clear_fault(tool_); }

  /// The scene, to change what may change between ticks.
  [[nodiscard]] ToolScene& scene() noexcept { return scene_; }
  [[nodiscard]] const ToolState& tool() const noexcept { return tool_; }
  [[nodiscard]] std::span<const StringTrack> tracks() const noexcept { return tracks_; }

 private:
  struct Way;
  struct Passage;
  struct Near;
  void find_ringing(const Way& way, std::int64_t t_ns) noexcept;
  void merge_touched(const StringContacts& touched) noexcept;
  void find_passage(const Way& way, std::int32_t string, double guess,
                    Passage& passage) const noexcept;
  void find_speeds(const Way& way, const ToolTick& tick, std::int32_t string,
                   Near& near) const noexcept;
  [[nodiscard]] Near look_at(std::int32_t string, const Way& way,
                             const ToolTick& tick) const noexcept;
  void damp_coupling(const Pose& X_WG_before, ToolTick& tick) const noexcept;
  void respond_string(std::int32_t string, const Near& near, const TickTime& time,
                      TickOutput& output) noexcept;

  OptimiserWorkspace workspace_;
  ToolScene scene_;
  ToolState tool_;
  std::span<StringTrack> tracks_;
  std::span<ModalString> modes_;
  Pose X_WH_;  ///< of the last tick in which time passed
  /// Strings to call respond() for, in ascending order.
  FixedVector<std::int32_t, kMaxStrings> awake_;
};

}  // namespace hapticd
