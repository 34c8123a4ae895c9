// The law for strings that yield: the tool never passes through or sinks into a string that bends
// under it, judged on the way of tool AND string between committed configurations, nor does it
// change sides but by a way round the string. A control that moves the strings without looking must
// fail on the same strokes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/strokes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;
constexpr double kPi = 3.14159265358979323846;

/// Deepest point of the whole committed path of a stroke (m, negative = penetration).
long double path_gap(const Stroke& stroke) {
  ToolRun run(stroke.scene, stroke.X_WH.front());
  long double deepest = 1.0L;
  for (const Pose& X_WH : stroke.X_WH) deepest = std::min(deepest, run.tick_along(X_WH));
  return deepest;
}

/// What the control keeps of a string: its line, its law and how it was bent last.
struct NaiveString {
  Capsule line;
  LawString law;
  double lambda = 0.5;
  Vector3 u_W{0.0, 0.0, 0.0};

  [[nodiscard]] Vector3 vertex() const { return line.p_A + lambda * (line.p_B - line.p_A) + u_W; }
};

/// The control: the tool moves against the strings as they were bent last; then every string takes
/// the deflection of the force it got, or none, without being looked at. Returns the smallest gap
/// after any tick, m; none when no string was touched.
std::optional<long double> naive_gap(Stroke& stroke) {
  RenderingScene& scene = stroke.scene;
  std::vector<NaiveString> strings;
  for (std::size_t k = 0; k < scene.strings.size(); ++k) {
    const StringConstants& string = scene.strings[k];
    strings.push_back(
        {scene.capsules_W[k],
         {string.length, string.tension, string.axial_stiffness, string.contact_stiffness}});
  }
  scene.strings.clear();
  const auto place_legs = [&] {
    scene.capsules_W.clear();
    for (const NaiveString& string : strings) {
      scene.capsules_W.push_back({string.line.p_A, string.vertex(), string.line.r});
      scene.capsules_W.push_back({string.vertex(), string.line.p_B, string.line.r});
    }
  };
  place_legs();
  ToolRun run(scene, stroke.X_WH.front());
  std::optional<long double> deepest;
  for (const Pose& X_WH : stroke.X_WH) {
    run.tick(X_WH);
    bool touched = deepest.has_value();
    std::vector<Vector3> forces(strings.size(), Vector3::Zero());
    for (int i = 0; i < run.result.active_count; ++i) {
      const ActiveContact& active = run.result.active[static_cast<std::size_t>(i)];
      const Contact& contact =
          run.problem->candidates().contacts().contacts[static_cast<std::size_t>(active.contact)];
      if (contact.key.kind != ObstacleKind::kCapsule) continue;
      const auto k = static_cast<std::size_t>(contact.key.obstacle) / 2;
      forces[k] += active.multiplier * contact.nhat_OG_W;
      const Vector3 axis = strings[k].line.p_B - strings[k].line.p_A;
      const double along = (contact.p_WC - strings[k].line.p_A).dot(axis) / axis.squaredNorm();
      strings[k].lambda = std::clamp(along, 0.001, 0.999);
    }
    for (std::size_t k = 0; k < strings.size(); ++k) {
      NaiveString& string = strings[k];
      const double force = forces[k].norm();
      string.u_W = Vector3::Zero();
      if (!(force > 0.0)) continue;
      touched = true;
      const auto delta =
          static_cast<double>(law_deflection(string.law, string.lambda, force, 0.05L));
      string.u_W = -delta * forces[k] / force;
    }
    place_legs();
    if (touched) deepest = std::min(deepest.value_or(1.0L), scene.true_gap(run.state.X_WG));
  }
  return deepest;
}

/// One sphere that strokes across one string, far from its ends.
struct AcrossStroke {
  Stroke stroke;
  double r;
};

AcrossStroke across_stroke(std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    Stroke stroke = make_string_stroke(seed + (attempt << 32U));
    const bool single =
        stroke.scene.tool_spheres.size() == 1 && stroke.scene.tool_spheres.front().p.norm() == 0.0;
    const bool across = stroke.kind == StrokeKind::kAcross || stroke.kind == StrokeKind::kOblique;
    const double r = stroke.scene.tool_spheres.front().r;
    if (single && across) return {std::move(stroke), r};
  }
}

/// Tool and string 0 at one time: the tool's centre and how the string is bent.
struct Placed {
  Vector3 p_WG;
  StringBend bend;
  bool held = false;
};

Placed placed(const ContactState& state) {
  Placed out{state.X_WG.p, {}};
  for (const TouchedString& hold : state.touched) {
    if (hold.bend.capsule != 0 || !hold.yields) continue;
    out.bend = hold.bend;
    out.held = true;
  }
  return out;
}

/// At s on the way: tool and vertex go straight; a string that is not held is straight, its vertex
/// anywhere.
Placed between(const Placed& from, const Placed& to, double s) {
  const double lambda_from = from.held ? from.bend.lambda : to.bend.lambda;
  const double lambda_to = to.held ? to.bend.lambda : from.bend.lambda;
  return {from.p_WG + s * (to.p_WG - from.p_WG),
          {0, lambda_from + s * (lambda_to - lambda_from),
           from.bend.u_W + s * (to.bend.u_W - from.bend.u_W)}};
}

/// From the string's axis to the tool's centre, across the string, m.
Vector3 from_axis(const Capsule& line, const Placed& at) {
  const Vector3 axis = line.p_B - line.p_A;
  const double lambda = (at.p_WG - line.p_A).dot(axis) / axis.squaredNorm();
  const Vector3 on_axis =
      line.p_A + lambda * axis + deflection_share(at.bend, lambda) * at.bend.u_W;
  Vector3 across = at.p_WG - on_axis;
  across.x() = 0.0;
  return across;
}

struct Winding {
  double swept = 0.0;         ///< about the string, with its sign, rad
  double largest_turn = 0.0;  ///< between two places looked at, rad
  double nearest = 1.0;       ///< smallest distance from the axis, as a share of r + R
  bool crossed = false;       ///< ends on the other side in y
  bool past_end = false;      ///< came past an end of the string, where another way leads round
};

/// Follows the committed way of tool and string in pieces of an eighth of the distance they keep.
Winding wind(const AcrossStroke& across) {
  ToolRun run(across.stroke.scene, across.stroke.X_WH.front());
  const Capsule& line = run.scene.capsules_W.front();
  const double touch = across.r + kStringRadius;
  Winding winding;
  Vector3 before = from_axis(line, placed(run.state));
  const double y_start = before.y();
  const auto follow = [&](const Placed& from, const Placed& to) {
    const double way = (to.p_WG - from.p_WG).norm() + (to.bend.u_W - from.bend.u_W).norm() +
                       std::abs(to.bend.lambda - from.bend.lambda) * 1.1;
    const int pieces = 1 + static_cast<int>(8.0 * way / touch);
    for (int i = 1; i <= pieces; ++i) {
      const Vector3 now = from_axis(line, between(from, to, static_cast<double>(i) / pieces));
      const double turn = std::atan2(before.cross(now).x(), before.dot(now));
      winding.swept += turn;
      winding.largest_turn = std::max(winding.largest_turn, std::abs(turn));
      winding.nearest = std::min(winding.nearest, now.norm() / touch);
      before = now;
    }
    const double x = to.p_WG.x();
    winding.past_end = winding.past_end || x < line.p_A.x() || x > line.p_B.x();
  };
  for (const Pose& X_WH : across.stroke.X_WH) {
    const ContactInput in = run.input(X_WH);
    run.problem->begin(in, run.state, run.result);
    for (bool more = true; more && run.result.sub_steps < run.options.sub_steps;) {
      run.problem->prepare();
      const Placed from = placed(run.state);
      more = run.problem->advance();
      follow(from, placed(run.state));
    }
    run.problem->finish();
  }
  winding.crossed = before.y() * y_start < 0.0;
  return winding;
}

}  // namespace

TEST_CASE(
    "no stroke from 0.1 to 100 m/s sinks into strings that yield or passes through them by more "
    "than "
    "a micrometre") {
  const std::int64_t strokes = scaled(100'000);
  long double deepest = 1.0L;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const Stroke stroke = make_string_stroke(static_cast<std::uint64_t>(i));
    const long double gap = path_gap(stroke);
    deepest = std::min(deepest, gap);
    if (gap < -kAllowedDepth)
      FAIL_CHECK("stroke " << i << ": " << static_cast<double>(gap) << " m, " << stroke.describe());
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m");
  CHECK(deepest >= -kAllowedDepth);
}

TEST_CASE("the control, strings that move without being looked at, sinks in on the same strokes") {
  struct Decade {
    int strokes = 0;
    int sunk = 0;
    long double deepest = 0.0L;
  };
  std::map<int, Decade> decades;
  const std::int64_t strokes = std::max<std::int64_t>(scaled(20'000), 400);
  for (std::int64_t i = 0; i < strokes; ++i) {
    Stroke stroke = make_string_stroke(static_cast<std::uint64_t>(i));
    const int decade = static_cast<int>(std::floor(std::log10(stroke.speed)));
    const std::optional<long double> gap = naive_gap(stroke);
    if (!gap) continue;
    Decade& counts = decades[decade];
    ++counts.strokes;
    counts.sunk += *gap < -kAllowedDepth ? 1 : 0;
    counts.deepest = std::min(counts.deepest, *gap);
  }
  CHECK(decades.size() == 3);
  for (const auto& [decade, counts] : decades) {
    MESSAGE("from " << std::pow(10.0, decade) << " m/s: " << counts.sunk << " of " << counts.strokes
                    << " that touch sink in, " << static_cast<double>(counts.deepest)
                    << " m at most");
    CHECK(5 * counts.sunk > counts.strokes);
  }
}

TEST_CASE("a tool changes sides of a string only by a way round it") {
  const std::int64_t strokes = scaled(10'000);
  int crossed = 0;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const AcrossStroke across = across_stroke(static_cast<std::uint64_t>(i));
    const Winding winding = wind(across);
    if (winding.past_end) continue;
    CAPTURE(i);
    CAPTURE(across.stroke.describe());
    // Nearer than touching only by what the legs slope; and never by a leap past the axis.
    CHECK(winding.nearest > 0.999);
    CHECK(winding.largest_turn < 0.3);
    if (!winding.crossed) continue;
    ++crossed;
    CHECK(std::abs(winding.swept) > 0.0);
    CHECK(std::abs(winding.swept) < 1.5 * kPi);
  }
  MESSAGE(crossed << " of " << strokes << " strokes end on the other side");
  CHECK(crossed > strokes / 10);
}

}  // namespace hapticd::test
