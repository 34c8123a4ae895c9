// Tools, obstacles and periodic motions on which whole contact ticks are timed. One period is 1000
// ticks of 1 ms; the poses are scripted, smooth and the same in every run. SI, frame W: y up,
// strings along x. Not RT.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/simulation/tool_renderer.h"
#include "tests/core/contact/rendering_fixture.h"

namespace hapticd::test {

inline constexpr int kPeriodTicks = 1000;

enum class Motion {
  kFree,   ///< 0.2 m above everything
  kPress,  ///< 1 to 5 mm deep, turning by up to 0.15 rad
  kMove,   ///< level, 4 mm deep, swept 0.1 m across and 0.05 m along the strings, up to 0.35 m/s
};

/// Plain spheres and capsules of a scene.
struct TickParts {
  std::vector<Sphere> tool_G;
  std::vector<Capsule> capsules_W;
  std::vector<Sphere> body_W;  ///< may be empty
};

/// The scenes that are timed: a sphere on a string; a hand of 36 spheres on seven strings over a
/// Guqin-like body of 4000; a blob of 1000 spheres, as large as a hand, on the strings over bodies
/// of 4000 and 10 000, and on the bodies alone.
struct NamedParts {
  const char* name;
  TickParts (*parts)();
};
[[nodiscard]] std::span<const NamedParts> timed_scenes();

struct NamedMotion {
  const char* name;
  Motion motion;
};
[[nodiscard]] std::span<const NamedMotion> timed_motions();

/// Height of the tool's origin at which `X_WG`, lowered from 0.5 m, comes nearer to the obstacles
/// than `gap` (m); -0.5 if it never does.
[[nodiscard]] double contact_height(const RenderingScene& scene, Pose X_WG, double gap);

/// The poses of one period. Depth is counted from the height of first contact: of each pose for a
/// press, of the highest for a sweep.
[[nodiscard]] std::vector<Pose> periodic_motion(const RenderingScene& scene, Motion motion);

/// A tool that is played the same period again and again.
class TickScene {
 public:
  /// Lowers the tool from free space and plays one period.
  TickScene(const TickParts& parts, Motion motion, const CouplingStiffness& stiffness = {});

  /// The next tick of the motion.
  const RenderedTool& tick();

  [[nodiscard]] const RenderingScene& scene() const { return scene_; }
  [[nodiscard]] const std::vector<Pose>& X_WH() const { return X_WH_; }
  [[nodiscard]] int contacts() const {
    return static_cast<int>(problem_->candidates().contacts().contacts.size());
  }

 private:
  void render(const Pose& X_WH);

  RenderingScene scene_;
  std::vector<Pose> X_WH_;
  ToolScene tool_;
  ToolState state_;
  RenderedTool tick_;
  std::unique_ptr<ContactProblem> problem_ = std::make_unique<ContactProblem>();
  std::size_t next_ = 0;
  std::int64_t t_ns_ = 0;
};

}  // namespace hapticd::test
