// A small instrument that owns its memory, and a hand that plays it: what the tests of the whole
// tick share.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "core/scene/owned_simulation.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/guarded_step.h"

namespace hapticd::test {

/// Tunings of the seven strings, Hz.
inline constexpr double kTuning[] = {65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8};

/// Radius of the finger of a default Instrument, m.
inline constexpr double kFingertip = 5e-3;

/// A tool, strings along x in the plane y = 0, and the simulation of both.
class Instrument {
 public:
  /// `strings` parallel strings of 1.1 m from x = 0, 20 mm apart in z from z = 0, all as
  /// `prototype` but tuned to kTuning (cyclically) where it has no frequency. The tool is `spheres`
  /// in G.
  Instrument(int strings, const StringParameters& prototype, const InstrumentOptions& options,
             std::vector<Sphere> spheres = {{Vector3::Zero(), kFingertip}});

  /// One tick at 1 kHz later with the tool at `X_WH`.
  const SimulationTick& tick(const Pose& X_WH);
  /// One tick with any sample, sound or not.
  const SimulationTick& tick_sample(const HandPose& sample);
  /// The same at position `p` without rotation.
  const SimulationTick& tick(const Vector3& p) { return tick(Pose{{1, 0, 0, 0}, p}); }
  /// Ticks along a straight way at `speed` (m/s), from where the last tick ended; calls `each`
  /// after each.
  template <typename Each>
  void glide(const Vector3& to, double speed, const Each& each) {
    const Vector3 from = p_WH;
    const int ticks =
        std::max(1, static_cast<int>(std::lround((to - from).norm() / (speed * 1e-3))));
    for (int i = 1; i <= ticks; ++i) {
      each(tick(Vector3(from + (to - from) * (static_cast<double>(i) / ticks))));
    }
  }

  [[nodiscard]] Simulation& simulation() { return *simulation_.simulation; }
  [[nodiscard]] ToolScene& scene() { return simulation().scene(0); }
  [[nodiscard]] const StringState& state(int string) const {
    return simulation_.tracks[static_cast<std::size_t>(string)].state;
  }
  /// Of string number `string` in the last tick, null when it is asleep.
  [[nodiscard]] const StringTick* reading(int string) const;
  /// What it rings with, J.
  [[nodiscard]] double energy(int string) const;
  /// Force of string number `string` on the tool along the touch normal in the last tick, its
  /// vibration included, N.
  [[nodiscard]] double normal_force(int string) const;
  [[nodiscard]] const SimulationTick& output() const { return output_; }
  /// What the guard made of the last sample.
  [[nodiscard]] PoseVerdict verdict() const { return verdict_; }
  /// Ends a fault.
  void clear() { hand_.clear(); }
  /// Events so far, in order.
  std::vector<StringEvent> events;
  /// Time stamp of the last sample, ns; tick() adds dt_ns first.
  std::int64_t t_ns = 0;
  std::int64_t dt_ns = 1'000'000;
  Vector3 p_WH{0.0, 0.0, 0.0};

  std::vector<Capsule> capsules_W;
  std::vector<CapsuleGroup> groups;
  std::vector<StringConstants> strings;

 private:
  SphereTree tree_;
  GuardedHand hand_;
  PoseVerdict verdict_ = PoseVerdict::kGood;
  OwnedSimulation simulation_;
  SimulationTick output_;
};

/// How many events of one kind there are.
[[nodiscard]] int count(const std::vector<StringEvent>& events, StringEventKind kind);
/// The events of one kind, in order.
[[nodiscard]] std::vector<StringEvent> of_kind(const std::vector<StringEvent>& events,
                                               StringEventKind kind);

/// What strings and options a test plays with.
struct Preset {
  const char* name;
  StringParameters string;
  InstrumentOptions options;
};
/// `paper`: rigid strings, level by force, T_d in touch.
[[nodiscard]] Preset paper_preset();
/// `deflecting`: the default.
[[nodiscard]] Preset deflecting_preset();
/// `sounding`: the same, a wave of 16 modes.
[[nodiscard]] Preset sounding_preset();
/// All of them, plain and with friction.
[[nodiscard]] std::vector<Preset> all_presets();
/// Those whose strings ring with their fundamental.
[[nodiscard]] std::vector<Preset> fundamental_presets();
/// True where the strings are waves.
[[nodiscard]] inline bool sounds(const Preset& preset) { return preset.options.modes > 0; }
/// Events that tell what a hand did: all but those of what is drawn and heard.
[[nodiscard]] int count_played(const std::vector<StringEvent>& events);

/// Distance of its centre from the axis of a string when it begins to press, m: both radii.
[[nodiscard]] double felt_distance(const Instrument& instrument);

}  // namespace hapticd::test
