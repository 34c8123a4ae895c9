// See shipped_play.h.
#include "tests/benchmark/shipped_play.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "core/collision/query.h"
#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "core/scene/quality.h"
#include "device/simulated/gesture.h"
#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/gesture_motion.h"
#include "server/scene_io/scene_loader.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
/// Ticks of the motions that are not gestures.
constexpr int kPeriodTicks = 2000;

constexpr ShippedPlayName kPlays[] = {
    {"guqin/pluck_each", kMillisecond, "guqin as shipped, every string plucked", 20.0},
    {"guqin/strum", kMillisecond, "guqin as shipped, strummed", 20.0},
    {"guqin/slide_on_body", kMillisecond, "guqin as shipped, a finger slides on the body", 20.0},
    {"guqin/pluck_each_10kHz", kMillisecond / 10, "guqin as shipped at 10 kHz", 20.0},
    {"guqin/idle", kMillisecond, "guqin as shipped, hand 0.3 m above", 1.0},
    {"guqin/extreme_presses", kMillisecond, "guqin as shipped, 20 mm through strings", 0.0},
    {"hand36/press", kMillisecond, "hand of 36, 7 strings, body of 2000: pressed", 15.0},
    {"hand36/sweep", kMillisecond, "hand of 36, 7 strings, body of 2000: swept", 15.0},
    {"stress/press", kMillisecond, "stress: bunny of 1000 pressed onto strings and body", 100.0},
    {"stress/sweep", kMillisecond, "stress: bunny of 1000 swept over strings and body", 100.0},
    {"stress/crush", kMillisecond, "stress: bunny of 1000 pressed 15 mm deep", 0.0},
    {"stress/idle", kMillisecond, "stress, bunny 0.3 m above", 1.0},
    {"bunny/bunny_two_lines", kMillisecond, "bunny of 250 on two lines", 0.0},
    {"bunny/bunny_line_and_pillar", kMillisecond, "bunny of 250 on a line and a pillar", 0.0},
};

std::string part_of_name(const ShippedPlayName& name, bool scene) {
  const std::string text = name.name;
  const std::size_t slash = text.find('/');
  return scene ? text.substr(0, slash) : text.substr(slash + 1);
}

[[noreturn]] void refuse(const std::string& what, const SceneProblems& problems) {
  std::string text = what + ":";
  for (const SceneProblem& problem : problems) text += "\n" + to_text(problem);
  throw std::runtime_error(text);
}

std::shared_ptr<const Scene> shipped_scene(const std::string& name, int quality) {
  LoadOptions options;
  options.paths = {{HAPTICD_SOURCE_DIR "/deploy/scenes"}, {HAPTICD_MODELS_DIR}};
  options.quality.quality = v1::Quality();
  options.quality.quality->set_level(static_cast<std::uint32_t>(quality));
  LoadResult result = load_scene(name, options);
  if (result.loaded == nullptr) refuse(name, result.problems);
  return std::move(result.loaded->scene);
}

/// 36 spheres of a hand, seven yielding strings, a body of 2000.
std::shared_ptr<const Scene> hand36_scene(int quality) {
  SceneDescription scene = finger_scene({0.0, 0.1, 0.0});
  scene.name = "hand36";
  scene.tools[0].parts = {part_of(hand_spheres())};
  BodyDescription body;
  body.name = "slab";
  body.shape = shape_of(slab_spheres(80, 25));
  scene.bodies.push_back(body);
  constexpr double kTuning[] = {65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8};
  std::size_t tuned = 0;
  for (const Capsule& capsule : seven_strings()) {
    StringDescription string = string_between(capsule.p_A, capsule.p_B);
    string.parameters.radius = capsule.r;
    string.parameters.frequency = kTuning[tuned++];
    scene.strings.push_back(string);
  }
  scene.contact = quality_of(quality).options;
  scene.torque = true;
  return std::make_shared<const Scene>(std::move(scene));
}

std::vector<Pose> gesture_poses(const std::string& name, const SceneDescription& scene,
                                std::int64_t period_ns) {
  const GestureResult gesture = load_gesture(name, {HAPTICD_SOURCE_DIR "/deploy/gestures"});
  if (!gesture.gesture) refuse(name, gesture.problems);
  const MotionResult motion =
      resolve_gesture(*gesture.gesture, 0, scene, [](const Pose& X_WH) { return X_WH; });
  if (!motion.motion) refuse(name, motion.problems);
  GesturePlayer player(scene.tools[0].X_WG);
  player.play(motion.motion->track(), 1);
  std::vector<Pose> poses;
  while (player.progress().playing) poses.push_back(player.advance(period_ns));
  return poses;
}

/// Height at which the tool, lowered from 0.5 m, first touches straight strings or bodies.
double touching_height(const ToolScene& scene, Pose X_WG) {
  constexpr double kTolerance = 1e-6;
  const auto contacts = std::make_unique<ContactSet>();
  X_WG.p.y() = 0.5;
  for (;;) {
    find_contacts({scene.tool, X_WG}, scene.obstacles, {}, *contacts);
    if (contacts->minimum_gap < kTolerance) return X_WG.p.y();
    X_WG.p.y() -= contacts->minimum_gap;
  }
}

Pose turned(const Vector3& p, const Vector3& phi) {
  return moved({{1, 0, 0, 0}, p}, {{0, 0, 0}, phi});
}

/// Lowered within a tenth of a second, then pressed with `deep` m more or less and turned, or swept
/// that deep across and along the strings.
std::vector<Pose> pressed(const ToolScene& scene, bool sweep, double deep) {
  std::vector<Pose> poses;
  for (int k = 0; k < kPeriodTicks; ++k) {
    const double phase = 4.0 * kPi * k / kPeriodTicks;
    const SinCos once = sin_cos(phase);
    const SinCos twice = sin_cos(2.0 * phase);
    Pose X = sweep ? turned({0.025 * twice.sin, 0.0, 0.05 * once.sin}, {0.0, 0.15 * once.sin, 0.0})
                   : turned({0.005 * once.sin, 0.0, 0.003 * twice.sin},
                            {0.1 * once.sin, 0.15 * once.sin, 0.1 * twice.sin});
    X.p.y() = touching_height(scene, X) - deep * (1.0 + (sweep ? 0.0 : 0.5 * twice.sin));
    X.p.y() += 0.05 * std::max(0.0, 1.0 - k / 100.0);
    poses.push_back(X);
  }
  return poses;
}

std::vector<Pose> motion_of(const ShippedPlayName& name, const Scene& scene) {
  const std::string scene_name = part_of_name(name, true);
  std::string motion = part_of_name(name, false);
  if (motion == "idle") {
    std::vector<Pose> poses(kPeriodTicks, scene.description().tools[0].X_WG);
    for (std::size_t k = 0; k < poses.size(); ++k) {
      poses[k].p.y() += 0.3;
      poses[k].p.x() += 0.01 * sin_cos(2.0 * kPi * static_cast<double>(k) / kPeriodTicks).sin;
    }
    return poses;
  }
  if (motion == "crush") return pressed(scene.tool_scene(0), false, 15e-3);
  if (motion == "press" || motion == "sweep") {
    return pressed(scene.tool_scene(0), motion == "sweep", scene_name == "stress" ? 8e-3 : 4e-3);
  }
  if (const std::size_t rate = motion.find("_10kHz"); rate != std::string::npos) {
    motion.resize(rate);
  }
  return gesture_poses(motion, scene.description(), name.period_ns);
}

}  // namespace

std::span<const ShippedPlayName> shipped_plays() { return kPlays; }

ShippedPlay::ShippedPlay(const ShippedPlayName& name, int quality)
    : scene_(part_of_name(name, true) == "hand36"
                 ? hand36_scene(quality)
                 : shipped_scene(part_of_name(name, true), quality)),
      X_WH_(motion_of(name, *scene_)) {
  std::int64_t t_ns = 0;
  hands_.reserve(X_WH_.size());
  for (const Pose& X_WH : X_WH_) {
    t_ns += name.period_ns;
    hands_.push_back({t_ns, to_array(X_WH.p), to_array(X_WH.q)});
  }
  restart();
}

void ShippedPlay::restart() {
  play_ = scene_->simulate(0);
  next_ = 0;
}

PlayWork ShippedPlay::work() const {
  const ContactResult& result = output_.tool(0).contact;
  const auto& contacts = play_.tools[0].problem.candidates().contacts().contacts;
  return {result.tests, result.sub_steps, static_cast<int>(contacts.size()), result.active_count};
}

}  // namespace hapticd::test
