// A small instrument that owns its memory, and a hand that plays it: what the tests of the whole
// tick share.
#pragma once

#include <memory>
#include <vector>

#include "core/modeling/sphere_tree.h"
#include "core/simulation/simulation.h"

namespace hapticd::test {

/// Tunings of the seven strings, Hz.
inline constexpr double kTuning[] = {65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8};

/// A tool, strings along x in the plane y = 0, and the simulation of both.
class Instrument {
 public:
  /// `strings` parallel strings of 1.1 m from x = 0, 20 mm apart in z from z = 0, all as
  /// `prototype` but tuned to kTuning (cyclically) where it has no frequency. The tool is `spheres`
  /// in G.
  Instrument(int strings, const StringParameters& prototype, const InstrumentOptions& options,
             std::vector<Sphere> spheres = {{Vector3::Zero(), 5e-3}});

  /// One tick at 1 kHz later with the tool at `X_WH`.
  const TickOutput& tick(const Pose& X_WH);
  /// The same at position `p` without rotation.
  const TickOutput& tick(const Vector3& p) { return tick(Pose{{1, 0, 0, 0}, p}); }
  /// Ticks along a straight way at `speed` (m/s), from where the last tick ended; calls `each`
  /// after each.
  template <typename Each>
  void glide(const Vector3& to, double speed, const Each& each) {
    const Vector3 from = p_WH;
    const int ticks = std::max(1, static_cast<int>((to - from).norm() / (speed * 1e-3) + 0.5));
    for (int i = 1; i <= ticks; ++i) {
      each(tick(Vector3(from + (to - from) * (static_cast<double>(i) / ticks))));
    }
  }

  [[nodiscard]] Simulation& simulation() { return *simulation_; }
  [[nodiscard]] const TickOutput& output() const { return *output_; }
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
  std::vector<StringTrack> tracks_;
  std::vector<ModalString> modes_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<TickOutput> output_ = std::make_unique<TickOutput>();
};

/// Events of one kind.
[[nodiscard]] int count(const std::vector<StringEvent>& events, StringEventKind kind);

}  // namespace hapticd::test
