// See session_statics.h.
#include "tests/core/contact/session_statics.h"

#include <algorithm>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/string_law_truth.h"
#include "tests/truth/exact_statics.h"

namespace hapticd::test {
namespace {

/// An error of less is no reason to look for another rest, N.
constexpr double kSame = 5e-3;
/// The exact force jumps where a tick changes it by more than this and twice the hand's way, N.
constexpr double kJump = 0.1;

/// A session as the product and as the statics sees it.
struct BothScenes {
  RenderingScene played;
  std::vector<Sphere> bodies;
  std::vector<Capsule> lines;
  std::vector<StaticString> strings;

  BothScenes(const ContactSession& session, const SessionStrings* as_strings)
      : played(session.tool_G) {
    played.capsules_W = session.capsules_W;
    for (const SessionBody& body : session.bodies) {
      played.add_body(body.spheres_B, pose_at(body.p_WB));
      for (const Sphere& sphere : body.spheres_B)
        bodies.push_back({body.p_WB + sphere.p, sphere.r});
    }
    if (as_strings == nullptr) {
      lines = session.capsules_W;
      return;
    }
    played.instrument = as_strings->instrument;
    for (const Capsule& line : session.capsules_W) {
      StringParameters string = as_strings->parameters;
      string.p_WA = to_array(line.p_A);
      string.p_WB = to_array(line.p_B);
      string.radius = line.r;
      played.strings.push_back(derive_string(string));
      const LawString law = law_string(string);
      const double series = 1.0 / string.contact_stiffness - 1.0 / CouplingStiffness{}.kt;
      strings.push_back(
          {line, string.tension, static_cast<double>(law.axial), std::max(0.0, series)});
    }
  }

  [[nodiscard]] StaticScene truth(double fattening) const {
    StaticScene scene{played.tool_spheres, bodies, lines, strings};
    scene.kt = CouplingStiffness{}.kt;
    scene.length = CouplingStiffness{}.length;
    scene.fattening = fattening;
    return scene;
  }
};

/// Where the product says that tool and strings are.
StaticPlace place_of(const ContactState& state, const StaticScene& scene) {
  StaticPlace place = free_place(scene, state.X_WG);
  for (const TouchedString& hold : state.touched) {
    const auto k = static_cast<std::size_t>(hold.bend.capsule);
    const Capsule& string = scene.strings[k].straight_W;
    place.vertices_W[k] = string.p_A + hold.bend.lambda * (string.p_B - string.p_A) + hold.bend.u_W;
  }
  return place;
}

/// A slip may come a tick sooner or later than that of the statics: where it jumps, puts the force
/// beside the jump that is nearer. Returns how often.
int shift_slips(const std::vector<Vector3>& felt, const std::vector<char>& jumps,
                std::vector<Vector3>& exact) {
  const std::vector<Vector3> all = exact;
  int shifted = 0;
  const auto try_with = [&](std::size_t k, const Vector3& other) {
    if ((felt[k] - other).norm() >= (felt[k] - exact[k]).norm()) return;
    exact[k] = other;
    ++shifted;
  };
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (jumps[k] == 0) continue;
    try_with(k, all[k - 1]);
    try_with(k - 1, all[k]);
  }
  return shifted;
}

}  // namespace

StaticsError compare_with_statics(const ContactSession& session, double rate_hz,
                                  const SessionStrings* lines, double fattening) {
  const BothScenes both(session, lines);
  const StaticScene truth = both.truth(fattening);
  const auto pose = [&](int tick) {
    const SessionPose X_WH = session.X_WH(tick / rate_hz);
    return pose_at(X_WH.p_WH, X_WH.phi_WH);
  };
  ToolRun tool(both.played, pose(0));
  StaticRest rest;
  rest.place = free_place(truth, pose(0));
  Vector3 before = Vector3::Zero();
  StaticsError out;
  std::vector<Vector3> felt;
  std::vector<Vector3> exact;
  std::vector<char> jumps;
  for (int tick = 0; tick < static_cast<int>(session.seconds * rate_hz); ++tick) {
    const Pose X_WH = pose(tick);
    tool.tick(X_WH);
    rest = rest_from(truth, X_WH, rest.place);
    const double way = (X_WH.p - pose(std::max(0, tick - 1)).p).norm();
    jumps.push_back((rest.F_H_W.f - before).norm() > kJump + 2.0 * truth.kt * way ? 1 : 0);
    out.slips += jumps.back();
    const Vector3 f = tool.result.F_H_W.f;
    if ((f - rest.F_H_W.f).norm() > kSame) {
      StaticRest other = rest_from(truth, X_WH, place_of(tool.state, truth));
      if ((f - other.F_H_W.f).norm() < (f - rest.F_H_W.f).norm()) {
        if ((other.F_H_W.f - rest.F_H_W.f).norm() > kSame) ++out.others;
        rest = other;
      }
    }
    out.converged = out.converged && converged(rest);
    before = rest.F_H_W.f;
    felt.push_back(f);
    exact.push_back(rest.F_H_W.f);
    ++out.ticks;
  }
  out.others += shift_slips(felt, jumps, exact);
  out.force = force_error(felt, exact);
  return out;
}

}  // namespace hapticd::test
