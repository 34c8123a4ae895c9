// See tick_scene.h.
#include "tests/benchmark/tick_scene.h"

#include <algorithm>

#include "core/math/elementary.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/guarded_step.h"

namespace hapticd::test {
namespace {

RenderingScene make_scene(const TickParts& parts) {
  RenderingScene scene(parts.tool_G);
  scene.capsules_W = parts.capsules_W;
  if (!parts.body_W.empty()) scene.add_body(parts.body_W, Pose{});
  return scene;
}

/// The motion without its height; `phase` in radians, 2 pi to a period.
Pose pose_in_plane(Motion motion, double phase) {
  const SinCos once = sin_cos(phase);
  const SinCos twice = sin_cos(2.0 * phase);
  if (motion == Motion::kPress) {
    return pose_at({0.005 * once.sin, 0.0, 0.003 * twice.sin},
                   {0.1 * once.sin, 0.15 * once.sin, 0.1 * twice.sin});
  }
  return pose_at({0.025 * twice.sin, 0.0, 0.05 * once.sin}, {0.0, 0.15 * once.sin, 0.0});
}

TickParts sphere_on_string() { return {{{{0, 0, 0}, 5e-3}}, {seven_strings()[3]}, {}}; }
TickParts hand_on_strings() { return {hand_spheres(), seven_strings(), slab_spheres(160, 25)}; }
TickParts bunny_on_strings() {
  return {blob_spheres(1000), seven_strings(), slab_spheres(160, 25)};
}
TickParts bunny_on_strings_10000() {
  return {blob_spheres(1000), seven_strings(), slab_spheres(250, 40)};
}
TickParts bunny_on_body() { return {blob_spheres(1000), {}, slab_spheres(160, 25)}; }
TickParts bunny_on_body_10000() { return {blob_spheres(1000), {}, slab_spheres(250, 40)}; }

constexpr NamedParts kScenes[] = {
    {"sphere_string", sphere_on_string},
    {"hand_strings_body4000", hand_on_strings},
    {"bunny_strings_body4000", bunny_on_strings},
    {"bunny_strings_body10000", bunny_on_strings_10000},
    {"bunny_body4000", bunny_on_body},
    {"bunny_body10000", bunny_on_body_10000},
};

constexpr NamedMotion kMotions[] = {
    {"free", Motion::kFree}, {"press", Motion::kPress}, {"move", Motion::kMove}};

}  // namespace

std::span<const NamedParts> timed_scenes() { return kScenes; }
std::span<const NamedMotion> timed_motions() { return kMotions; }

double contact_height(const RenderingScene& scene, Pose X_WG, double gap) {
  constexpr double kTolerance = 1e-6;
  const auto contacts = std::make_unique<ContactSet>();
  X_WG.p.y() = 0.5;
  while (X_WG.p.y() > -0.5) {
    find_contacts({scene.tool(), X_WG}, scene.obstacles(), {}, *contacts);
    const double way = contacts->minimum_gap - gap;
    if (way < kTolerance) break;
    X_WG.p.y() -= way;
  }
  return X_WG.p.y();
}

std::vector<Pose> periodic_motion(const RenderingScene& scene, Motion motion) {
  constexpr double kPhaseStep = 2.0 * kPi / kPeriodTicks;
  constexpr double kFreeHeight = 0.2;
  constexpr double kMoveDepth = 4e-3;
  std::vector<Pose> poses;
  double highest = -1.0;
  for (int k = 0; k < kPeriodTicks; ++k) {
    Pose X_WH = pose_in_plane(motion, kPhaseStep * k);
    X_WH.p.y() = contact_height(scene, X_WH, 0.0);
    highest = std::max(highest, X_WH.p.y());
    poses.push_back(X_WH);
  }
  for (int k = 0; k < kPeriodTicks; ++k) {
    double& y = poses[static_cast<std::size_t>(k)].p.y();
    if (motion == Motion::kPress) y -= 3e-3 + 2e-3 * sin_cos(3.0 * kPhaseStep * k).sin;
    if (motion == Motion::kMove) y = highest - kMoveDepth;
    if (motion == Motion::kFree) y = highest + kFreeHeight;
  }
  return poses;
}

TickScene::TickScene(const TickParts& parts, Motion motion, const CouplingStiffness& stiffness)
    : scene_(make_scene(parts)),
      X_WH_(periodic_motion(scene_, motion)),
      tool_{scene_.tool(), scene_.obstacles(), stiffness, {}, {}} {
  Pose above = X_WH_.front();
  above.p.y() += 0.5;
  render(above);
  for (int k = 0; k < kPeriodTicks; ++k) tick();
}

const RenderedTool& TickScene::tick() {
  render(X_WH_[next_]);
  next_ = (next_ + 1) % X_WH_.size();
  return tick_;
}

void TickScene::render(const Pose& X_WH) {
  t_ns_ += 1'000'000;
  const HandPose sample{t_ns_,
                        {X_WH.p.x(), X_WH.p.y(), X_WH.p.z()},
                        {X_WH.q.w(), X_WH.q.x(), X_WH.q.y(), X_WH.q.z()}};
  render_tool(tool_, sample, state_, *problem_, tick_);
}

}  // namespace hapticd::test
