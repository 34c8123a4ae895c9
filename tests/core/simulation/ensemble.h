// Several tools among seven strings and a body, and the truth about how near they come: every
// sphere of every tool against the strings as they are bent and against the body, by exhaustion.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/owned_simulation.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {

/// Radius of a fingertip, m.
inline constexpr double kEnsembleTip = 5e-3;
/// Length of the strings, m: along x from 0, 20 mm apart in z from 0, at y = 0.
inline constexpr double kEnsembleLength = 1.1;

/// What a scene of several tools is played with.
struct EnsembleOptions {
  int strings = 7;
  StringParameters string;
  bool tuned = true;  ///< as a Guqin, from 65.4 Hz; else every string has the frequency of `string`
  InstrumentOptions instrument;
  std::vector<Sphere> tool{{Vector3(0.0, 0.0, 0.0), kEnsembleTip}};
  double body_y = -0.02;  ///< height of the upper side of the body below the strings, m
};

/// One to five alike tools.
class Ensemble {
 public:
  Ensemble(std::size_t tools, const EnsembleOptions& options);

  /// The hands of the next tick with the tools at `p_WH`, not turned.
  [[nodiscard]] std::vector<HandPose> hands(const std::vector<Vector3>& p_WH) const;
  /// One tick of 1 ms with the tools at `p_WH`, not turned.
  const SimulationTick& tick(const std::vector<Vector3>& p_WH);

  /// The smallest gap of any tool to the strings as they are bent and to the body, m.
  [[nodiscard]] long double minimum_gap() const;
  /// The string as it is bent.
  [[nodiscard]] StringPoints shape(std::int32_t string) const;

  [[nodiscard]] Simulation& simulation() { return *play_.simulation; }
  [[nodiscard]] const SimulationTick& output() const { return output_; }
  std::vector<StringEvent> events;
  std::int64_t work_budget = 0;  ///< of every tick

 private:
  EnsembleOptions options_;
  SphereTree tool_;
  SphereTree body_;
  std::vector<Sphere> body_spheres_;
  std::vector<Capsule> capsules_W_;
  std::vector<CapsuleGroup> groups_;
  std::vector<StringConstants> strings_;
  std::vector<BodyView> bodies_;
  OwnedSimulation play_;
  SimulationTick output_;
  std::int64_t t_ns_ = 0;
};

}  // namespace hapticd::test
