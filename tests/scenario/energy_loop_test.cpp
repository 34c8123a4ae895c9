// Nothing makes energy: hands go slowly round closed ways in every scene that is shipped, and what
// the forces do to them over a lap is compared with nothing at all. Strings fundamental and in
// modes, tips rigid and soft, one hand and five. The work is the trapezoid of the force before and
// after each tick over the hand's displacement: what a force held for a tick leaks is the device
// loop's.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/math/rotation.h"
#include "server/scene_io/named_text.h"
#include "tests/scenario/closed_path.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

/// What a lap may give, and take where nothing was let go, J.
constexpr double kClosed = 10e-6;
/// A tool longer than kWide (m), or several tools, may press a string in several places, and the
/// string's one vertex goes between them: what that may lose of what hands and strings exchange.
constexpr double kWide = 0.02;
constexpr double kWideLoss = 0.12;
/// A tool that goes this many times as far in a tick as the hand, and this far beyond, m, has let
/// go of something: a string slips off, or the tool off an edge. What that frees is lost.
constexpr double kLeap = 4.0;
constexpr double kLeapBeyond = 20e-6;
/// Nor does a force change by more than coupling stiffness times way and this, N, where tool and
/// strings go from one stable rest to the next: they are in series with the coupling.
constexpr double kSnap_n = 2e-3;
/// Arm at which a turn of the hand counts as a way, m.
constexpr double kArm_m = 0.1;

/// What a scene is played with.
struct Variant {
  bool modes;
  bool soft;
};
constexpr std::array<Variant, 4> kVariants{
    {{false, false}, {true, false}, {false, true}, {true, true}}};

std::unique_ptr<Scene> variant_of(const Scene& scene, const Variant& variant) {
  SceneDescription description = scene.description();
  description.instrument.friction = false;
  if (variant.modes) description.instrument.modes = 32;
  for (ToolDescription& tool : description.tools) {
    for (PartDescription& part : tool.parts) {
      part.softness = {variant.soft ? 1500.0 : 0.0, 0.0};
    }
  }
  return std::make_unique<Scene>(std::move(description));
}

/// What hands got in a lap.
struct Lap {
  double gained = 0.0;     ///< J
  double moved = 0.0;      ///< sum of what went either way, J
  double tank_lost = 0.0;  ///< by the strings' tanks, J
  bool let_go = false;
  bool shared = false;  ///< a string was pressed by two tools at once
  bool recovered = false;
  double pressed = 0.0;  ///< greatest force, N
};

/// Hands in a scene, tick by tick.
class Hands {
 public:
  explicit Hands(const Scene& scene) : scene_(scene), play_(scene.simulate()) {}

  void tick(std::span<const HandPose> hands, Lap& lap) {
    Simulation& simulation = *play_.simulation;
    const double tank = simulation.strings().tank_energy();
    output_.step(simulation, hands);
    lap.tank_lost += std::max(0.0, tank - simulation.strings().tank_energy());
    for (std::size_t k = 0; k < hands.size(); ++k) book(k, lap);
    lap.shared = lap.shared || share_a_string(hands.size());
  }

 private:
  struct Before {
    Wrench F_H_W;
    Pose X_WH;
    Pose X_WG;
    bool known = false;
  };

  void book(std::size_t k, Lap& lap) {
    const RenderedTool& tool = output_.tool(k);
    Before& before = before_[k];
    const Wrench& F = tool.F_computed_H_W;
    if (before.known) {
      const Vector3 dp = tool.X_WH.p - before.X_WH.p;
      const Vector3 turn = log_rotation(tool.X_WH.q * before.X_WH.q.conjugate());
      const double work = 0.5 * ((F.f + before.F_H_W.f).dot(dp) + (F.t + before.F_H_W.t).dot(turn));
      lap.gained += work;
      lap.moved += std::abs(work);
      const double way = dp.norm() + kArm_m * turn.norm();
      const double went = (tool.X_WG.p - before.X_WG.p).norm();
      const double kt = scene_.description().tools[k].coupling.kt;
      const double changed = (F.f - before.F_H_W.f).norm();
      lap.let_go = lap.let_go || went > kLeap * way + kLeapBeyond || changed > kt * way + kSnap_n;
    }
    lap.pressed = std::max(lap.pressed, F.f.norm());
    lap.recovered = lap.recovered || tool.contact.status == ContactStatus::kRecovering;
    before = {F, tool.X_WH, tool.X_WG, true};
  }

  [[nodiscard]] bool share_a_string(std::size_t tools) const {
    std::set<std::int32_t> pressed;
    for (std::size_t k = 0; k < tools; ++k) {
      for (const PressedString& string : output_.tool(k).strings) {
        if (!pressed.insert(string.string).second) return true;
      }
    }
    return false;
  }

  const Scene& scene_;
  OwnedSimulation play_;
  SimulationTick output_;
  std::array<Before, kMaxTools> before_;
};

/// Two laps; the first one, which brings all into it, is not counted. False where the hands begin
/// in something.
bool play(const Scene& scene, std::span<const ClosedPath> paths, Lap& second) {
  Hands hands(scene);
  int ticks = 0;
  for (const ClosedPath& path : paths) ticks = std::max(ticks, path.ticks);
  std::array<HandPose, kMaxTools> placed;
  std::int64_t t_ns = 0;
  for (int lap = 0; lap < 2; ++lap) {
    Lap work;
    for (int tick = 1; tick <= ticks; ++tick) {
      t_ns += 1'000'000;
      for (std::size_t k = 0; k < paths.size(); ++k) {
        const Pose X_WH = paths[k].at(static_cast<double>(tick) / ticks);
        placed[k] = {t_ns, to_array(X_WH.p), to_array(X_WH.q)};
      }
      if (lap == 0 && tick == 1) {
        for (std::size_t k = 0; k < paths.size(); ++k) {
          placed[k] = {t_ns, to_array(paths[k].X_WH.p), to_array(paths[k].X_WH.q)};
        }
      }
      hands.tick({placed.data(), paths.size()}, work);
      if (work.recovered) return false;
    }
    second = work;
  }
  return true;
}

/// False where the hand begins in something.
bool begins_free(const Scene& scene, std::size_t tool, const ClosedPath& path) {
  const OwnedSimulation alone = scene.simulate(tool);
  SimulationTick output;
  output.step(*alone.simulation, {1'000'000, to_array(path.X_WH.p), to_array(path.X_WH.q)});
  return output.tool(0).contact.status != ContactStatus::kRecovering;
}

/// True where a wide tool may touch a string.
bool is_wide(const Scene& scene) {
  const ToolScene view = scene.tool_scene(0);
  return !view.strings.empty() && reach(view.tool) > kWide;
}

/// Of all laps in a scene.
struct Verdict {
  int laps = 0;
  int held = 0;     ///< of them nothing was let go in
  int pressed = 0;  ///< of them pressed with 0.1 N or more
  double most_gained = -1.0;
  double most_lost = -1.0;  ///< where nothing was let go, beyond what wide tools may
  double moved = 0.0;
};

void judge(const Scene& scene, std::uint64_t seed, Verdict& verdict) {
  SplitMix64 random(seed);
  for (int attempt = 0; attempt < 50; ++attempt) {
    const std::size_t tools = scene.description().tools.size();
    std::vector<ClosedPath> paths;
    for (std::size_t k = 0; k < tools; ++k) {
      const Pose& start = scene.description().tools[k].X_WG;
      paths.push_back(random_lap(scene.tool_scene(k), start, random));
      for (int more = 0; more < 20 && !begins_free(scene, k, paths.back()); ++more) {
        paths.back() = random_lap(scene.tool_scene(k), start, random);
      }
    }
    Lap lap;
    if (!play(scene, paths, lap)) continue;
    ++verdict.laps;
    verdict.moved += lap.moved;
    if (lap.pressed > 0.1) ++verdict.pressed;
    const double gained = lap.gained - lap.tank_lost;
    verdict.most_gained = std::max(verdict.most_gained, gained);
    if (!lap.let_go) {
      ++verdict.held;
      const double allowed = is_wide(scene) || lap.shared ? kWideLoss * lap.moved : 0.0;
      verdict.most_lost = std::max(verdict.most_lost, -lap.gained - allowed);
    }
    return;
  }
}

}  // namespace

TEST_CASE("over a closed way no hand gains energy, nor loses any where nothing is let go") {
  const std::uint64_t fresh = std::random_device{}();
  for (const std::string& name : list_names(shipped().paths.scenes)) {
    if (name == "guqin_fine" && !fine_models_exist()) continue;
    CAPTURE(name);
    const auto loaded = load_shipped(name);
    std::array<std::unique_ptr<Scene>, kVariants.size()> scenes;
    for (std::size_t k = 0; k < scenes.size(); ++k) {
      scenes[k] = variant_of(*loaded->scene, kVariants[k]);
    }
    const auto count = static_cast<std::uint64_t>(scaled(200));
    Verdict verdict;
    for (std::uint64_t k = 0; k < count; ++k) judge(*scenes[k % scenes.size()], k, verdict);
    judge(*scenes[fresh % scenes.size()], fresh, verdict);
    MESSAGE(name << ": " << verdict.laps << " laps, " << verdict.pressed << " pressed, "
                 << verdict.held << " held: gained " << 1e6 * verdict.most_gained << " uJ, lost "
                 << 1e6 * verdict.most_lost << " uJ at most of "
                 << 1e6 * verdict.moved / std::max(1, verdict.laps) << " uJ moved (fresh seed "
                 << fresh << ")");
    CHECK(verdict.laps > 0);
    CHECK(verdict.most_gained <= kClosed);
    CHECK(verdict.most_lost <= kClosed);
  }
}

}  // namespace hapticd::test
