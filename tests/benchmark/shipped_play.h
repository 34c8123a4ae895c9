// Scenes as they are shipped, and one of a size that is named, each led along a motion that is the
// same in every run: what tests/benchmark measures whole ticks of. The poses are those of the
// haptic tool, 1 ms apart unless told otherwise. SI, frame W. Not RT.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {

/// What is played.
struct ShippedPlayName {
  const char* name;        ///< scene/motion
  std::int64_t period_ns;  ///< of a tick
  const char* what;        ///< it is, in words
  double target_us;        ///< median time of a tick that is asked for; 0: none
};

/// All of them.
[[nodiscard]] std::span<const ShippedPlayName> shipped_plays();

/// What a tick did; the same in every run.
struct PlayWork {
  std::int64_t tests = 0;
  int sub_steps = 0;
  int contacts = 0;  ///< within the margin
  int active = 0;    ///< rows that bear force
};

/// A scene and its first tool, led along the motion.
class ShippedPlay {
 public:
  /// Throws std::runtime_error where the scene or the gesture is refused. `quality`: the level of
  /// what the scene leaves open; 3 is the default.
  explicit ShippedPlay(const ShippedPlayName& name, int quality = 3);

  [[nodiscard]] std::size_t ticks() const { return hands_.size(); }
  /// Begins anew.
  void restart();
  /// The next tick; restart() first when all are over.
  void step() { output_.step(*play_.simulation, hands_[next_++]); }
  /// Of the last tick.
  [[nodiscard]] PlayWork work() const;
  [[nodiscard]] const SimulationTick& output() const { return output_; }
  [[nodiscard]] const Scene& scene() const { return *scene_; }
  [[nodiscard]] const std::vector<Pose>& poses() const { return X_WH_; }

 private:
  std::shared_ptr<const Scene> scene_;
  std::vector<Pose> X_WH_;
  std::vector<HandPose> hands_;
  OwnedSimulation play_;
  SimulationTick output_;
  std::size_t next_ = 0;
};

}  // namespace hapticd::test
