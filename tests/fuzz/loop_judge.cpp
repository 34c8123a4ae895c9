// See loop_judge.h.
#include "tests/fuzz/loop_judge.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace hapticd::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// False for NaN.
bool within(double value, double low, double high) { return value >= low && value <= high; }

template <std::size_t N>
bool is_finite(const std::array<double, N>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

/// Takes all that a ring of plain things holds.
template <typename T, std::size_t Capacity>
std::vector<T> emptied(SpscRing<T, Capacity>& ring) {
  std::vector<T> all;
  for (T each; ring.pop(each);) all.push_back(each);
  return all;
}

/// Shows `judge` what is lent, thing by thing, in order.
template <typename T, std::size_t Capacity, typename Judge>
void look_at_lent(Lending<T, Capacity>& lending, const Judge& judge) {
  std::vector<std::unique_ptr<T>> all;
  while (std::unique_ptr<T> each = lending.lent.pop()) all.push_back(std::move(each));
  for (std::unique_ptr<T>& each : all) {
    judge(*each);
    require(lending.lent.push(each), "a ring without room for what it held");
  }
}

void judge_point(const GesturePoint& point) {
  require(is_finite(point.p_DH) && is_finite(point.q_DH), "a gesture leads nowhere");
  double square = 0.0;
  for (const double x : point.q_DH) square += x * x;
  require(std::abs(square - 1.0) < 1e-9, "a gesture turns by no rotation");
}

void judge_plan(const GesturePlan& plan) {
  require(plan.motions.size() <= kMaxTools, "a gesture of more tools than there can be");
  require(plan.repeat <= 1'000'000, "a gesture repeated too often");
  require(plan.name.back() == '\0', "a name without an end");
  require(!plan.arm || (*plan.arm >= ArmKind::kOff && *plan.arm <= ArmKind::kAdversarial),
          "an arm that is none");
  for (const GestureMotion& motion : plan.motions) {
    require(motion.legs.empty() || motion.samples.empty(), "a gesture of two minds");
    require(motion.samples.empty() || within(motion.rate, 1.0, 1e5), "samples at no rate");
    for (const GesturePoint& point : motion.samples) judge_point(point);
    for (const GestureLeg& leg : motion.legs) {
      judge_point(leg.point);
      require(leg.duration_ns >= 0 && leg.hold_ns >= 0, "a gesture back in time");
    }
  }
}

void judge_piece(const StringParameters& piece) {
  require(is_finite(piece.p_WA) && is_finite(piece.p_WB), "a string that ends nowhere");
  require(within(piece.radius, 0.0, 1.0) && within(piece.tension, 0.0, 1e6), "radius or tension");
  require(within(piece.youngs_modulus, 0.0, 1e13), "youngs_modulus");
  require(within(piece.linear_density, 0.0, 100.0), "linear_density");
  require(within(piece.frequency, 0.0, 2e4), "frequency");
  require(within(piece.loss_n2, 0.0, 1e3), "loss_n2");
  require(within(piece.inharmonicity, 0.0, 0.1), "inharmonicity");
  require(within(piece.friction_coefficient, 0.0, 10.0), "friction_coefficient");
  require(within(piece.contact_stiffness, 1e-3, 1e9), "contact_stiffness");
  for (const double above : {piece.decay, piece.touch_decay}) {
    require(above > 0.0 && above <= 1000.0, "a decay");
  }
  require(piece.k_s > 0.0 && piece.k_s <= 1e6, "k_s");
}

void judge_live(const LiveSettings& live) {
  require(std::isfinite(live.coupling.kt) && live.coupling.kt > 0.0, "kt");
  require(std::isfinite(live.coupling.length) && live.coupling.length > 0.0, "length");
  require(std::isfinite(live.coupling_damping) && live.coupling_damping >= 0.0, "damping");
  require(std::isfinite(live.force_gain) && live.force_gain >= 0.0, "force_gain");
  require(std::isfinite(live.scale) && live.scale > 0.0, "scale");
  require(live.X_WD.p.allFinite() && std::abs(live.X_WD.q.norm() - 1.0) < 1e-6, "X_WD");
  require(live.quality_level <= 4, "a quality that is none");
}

void judge_change(const SettingsChange& change) {
  require(change.to.tools.size() == change.from.tools.size() &&
              change.to.pieces.size() == change.from.pieces.size(),
          "a change without room for what was");
  require(!change.to.tools.empty() && change.to.tools.size() <= kMaxTools, "a change of no tool");
  for (const LiveSettings& live : change.to.tools) judge_live(live);
  for (const StringParameters& piece : change.to.pieces) judge_piece(piece);
}

void judge_scene(const PlayedScene& scene) {
  require(!scene.tools.empty() && scene.tools.size() <= kMaxTools, "a scene of no tool");
  require(scene.scene != nullptr && scene.work_budget >= 0, "a scene that cannot be played");
  require(scene.settings.tools.size() == scene.tools.size() &&
              scene.strings.size() == scene.settings.pieces.size(),
          "a scene whose settings are another's");
  for (const PlayedTool& tool : scene.tools) {
    require(tool.device.device != nullptr, "a tool without a device");
    require(tool.limits.peak.force >= 0.0 && tool.limits.peak.torque >= 0.0, "a force below 0");
  }
  if (scene.gesture != nullptr) judge_plan(*scene.gesture);
}

}  // namespace

void LoopJudge::judge(const LoopCommand& command, const LoopPlace& place) {
  require(command.number > last_number_, "a command whose number has been used");
  last_number_ = command.number;
  require(!std::holds_alternative<std::monostate>(command.what), "a command of nothing");
  require(!std::holds_alternative<EndCommand>(command.what), "a request ended the daemon");
  if (const auto* recentre = std::get_if<RecentreCommand>(&command.what)) {
    require(recentre->tool < place.tools, "a tool that is not there");
  } else if (const auto* clutch = std::get_if<ClutchCommand>(&command.what)) {
    require(clutch->tool < place.tools, "a tool that is not there");
  } else if (const auto* push = std::get_if<PushCommand>(&command.what)) {
    require(push->tool < place.tools, "a tool that is not there");
    require(push->axis >= 1 && push->axis <= kPushAxes, "a push along no axis");
  } else if (const auto* budget = std::get_if<WorkBudgetCommand>(&command.what)) {
    require(budget->work >= 0, "less work than none");
  } else if (const auto* lost = std::get_if<LeaseLostCommand>(&command.what)) {
    require(lost->ended > lease_ends_ && lost->ended <= place.lease_ends, "a lease ended twice");
    lease_ends_ = lost->ended;
  }
}

void LoopJudge::look(LoopChannels& channels, const LoopPlace& place) {
  require(channels.commands.overflow() == 0, "a command was lost");
  for (const LoopCommand& command : emptied(channels.commands)) {
    // Those that wait from before have been judged.
    if (command.number > last_number_) judge(command, place);
    require(channels.commands.push(command), "a ring without room for what it held");
  }
  for (const TickPose& pose : emptied(channels.poses)) {
    require(pose.tool < kMaxTools && pose.lease <= place.lease_ends, "a pose of nobody");
    require(pose.tick < place.next_tick + kPoseQueue || pose.tick < place.next_tick,
            "a pose for a tick that is far away");
    require(channels.poses.push(pose), "a ring without room for what it held");
  }
  look_at_lent(channels.gestures, judge_plan);
  look_at_lent(channels.changes, judge_change);
  look_at_lent(channels.scenes, judge_scene);
}

void judge_tick(const Tick& tick, const PlayedScene& scene) {
  require(tick.tools.size() >= 1 && tick.tools.size() <= kMaxTools, "a tick of no tool");
  for (const ToolTick& tool : tick.tools) {
    const PlainWrench& F = tool.F_written_H_W;
    require(is_finite(F.f) && is_finite(F.t), "a force that is no number");
    require(is_finite(tool.X_WG.p) && is_finite(tool.X_WG.q), "a tool that is nowhere");
  }
  if (tick.scene_id != scene.scene_id) return;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    const Array3& f = tick.tools[k].F_written_H_W.f;
    const double size = std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    require(size <= scene.tools[k].limits.peak.force * (1.0 + 1e-9), "a force above its limit");
  }
}

}  // namespace hapticd::test
