// A tool of spheres against capsules and a body in MuJoCo, coupled to the hand as we couple it: a
// free body pulled to the haptic pose by a critically damped spring of given stiffness. No gravity,
// no friction. MuJoCo's broad phase knows bodies only, as boxes around the bounding spheres of
// their geoms, and tries every pair of geoms of two bodies that are near; so the tool and the body
// are cut into pieces that are bodies of their own. Not RT.
#pragma once

#include "core/contact/virtual_coupling.h"
#include "tests/benchmark/tick_scene.h"

struct mjModel_;
struct mjData_;

namespace hapticd::test {

struct MujocoSettings {
  bool body_as_boxes = false;  ///< eight long boxes instead of the spheres
  int links = 1;               ///< into which strings and boxes are cut
  /// Time constant of contacts, s. MuJoCo's default is 0.02; it accepts no less than two steps.
  double contact_time = 0.02;
  int steps_per_tick = 1;
  const char* solver = "Newton";  ///< or CG, PGS
};

class MujocoScene {
 public:
  /// Throws std::runtime_error with MuJoCo's message when the model does not compile.
  MujocoScene(const TickParts& parts, const CouplingStiffness& stiffness,
              const MujocoSettings& settings);
  ~MujocoScene();
  MujocoScene(const MujocoScene&) = delete;
  MujocoScene& operator=(const MujocoScene&) = delete;

  /// Puts the tool at rest at `X_WG`.
  void place(const Pose& X_WG);
  /// 1 ms with the hand at `X_WH`.
  void tick(const Pose& X_WH);
  [[nodiscard]] Pose X_WG() const;
  /// Force of the coupling on the hand, N.
  [[nodiscard]] Vector3 f_H_W() const { return f_H_W_; }

 private:
  void pull(const Pose& X_WH, const Twist& V_WH);

  CouplingStiffness stiffness_;
  int steps_per_tick_;
  Pose X_WH_before_;
  Vector3 f_H_W_{0.0, 0.0, 0.0};
  mjModel_* model_ = nullptr;
  mjData_* data_ = nullptr;
  int tool_;
};

}  // namespace hapticd::test
