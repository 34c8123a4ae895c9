// The skin is the room that turning needs. What of it is used up comes back, and until it does the
// tool keeps moving; the rows that guard it tell exactly what a step does to a gap.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kLineRadius = 0.5e-3;

Capsule line_at(double y, double z) {
  return {Vector3(-0.5, y, z), Vector3(0.5, y, z), kLineRadius};
}

/// Distance from `p` to the segment from a to b.
long double distance_to_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  std::array<long double, 3> ab;
  std::array<long double, 3> ap;
  long double along = 0.0L;
  long double squared = 0.0L;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    ab[k] = static_cast<long double>(b[i]) - a[i];
    ap[k] = static_cast<long double>(p[i]) - a[i];
    along += ab[k] * ap[k];
    squared += ab[k] * ab[k];
  }
  const long double share = std::clamp(along / squared, 0.0L, 1.0L);
  long double sum = 0.0L;
  for (std::size_t k = 0; k < 3; ++k) {
    const long double away = ap[k] - share * ab[k];
    sum += away * away;
  }
  return std::sqrt(sum);
}

/// A bar of three spheres across a string, pressed into it and turned: several contacts, each at
/// its own height.
RenderingScene bar_on_string() {
  return scene_of({string_at()}, {{Vector3(-0.02, 0.0, 0.0), 5e-3},
                                  {Vector3(0.004, -1e-3, 2e-3), 4e-3},
                                  {Vector3(0.02, 0.0, -1e-3), 6e-3}});
}

/// A step of the tool and of the only string, its vertex across the axis by du_W and along it with
/// the contact.
ConfigurationStep step_of(const ToolRun& run, const StringBlock& model, const ToolMotion& tool,
                          const Vector3& du_W) {
  ConfigurationStep step;
  step.tool = tool;
  step.strings[0] = string_motion(model, run.state.touched[0].bend, du_W, step);
  return step;
}

/// Gap of a contact with the only string after `step`, from the definition, m.
long double gap_after(const ToolRun& run, const Contact& contact, const ConfigurationStep& step) {
  const Capsule& string = run.scene.capsules_W[0];
  const StringBend bend = moved(run.state.touched[0].bend, step.strings[0]);
  const Vector3 vertex = string.p_A + bend.lambda * (string.p_B - string.p_A) + bend.u_W;
  const Sphere& sphere = run.scene.tool_spheres[static_cast<std::size_t>(contact.key.tool_sphere)];
  const Vector3 p_WC = transform(moved(run.state.X_WG, step.tool), sphere.p);
  const Vector3& end = contact.key.obstacle_sphere == 0 ? string.p_A : string.p_B;
  return distance_to_segment(p_WC, end, vertex) - sphere.r - string.r;
}

}  // namespace

TEST_CASE("skin that is used up is won back in the next tick, from lines and from strings") {
  for (const bool yields : {false, true}) {
    CAPTURE(yields);
    RenderingScene scene = scene_of({});
    if (yields) {
      scene = scene_of({string_at()});
    } else {
      scene.capsules_W.push_back(line_at(0.0, 0.0));
    }
    const double touch = kTipRadius + scene.capsules_W[0].r;
    ToolRun run(scene, pose_at({0.1, touch + 1e-9, 0.0}));
    run.tick(pose_at({0.1, touch - 1e-3, 0.0}));
    const auto gap = static_cast<double>(scene.true_path_gap(run.state, run.state));
    CHECK(gap >= run.options.skin - 1e-9);
    CHECK(gap <= run.options.skin + 1e-9);
  }
}

TEST_CASE("between lines that leave no room for the skin the tool slides on, and enters none") {
  RenderingScene scene = scene_of({});
  const double apart = kTipRadius + kLineRadius + 5e-6;  // a quarter of the skin on both sides
  scene.capsules_W.push_back(line_at(-apart, 0.0));
  scene.capsules_W.push_back(line_at(apart, 0.0));
  ToolRun run(scene, pose_at(Vector3::Zero()));
  for (int tick = 1; tick <= 100; ++tick) {
    const double x = 1e-3 * tick;
    const long double gap = run.tick_along(pose_at({x, -2e-3, 0.0}, {0.0, 0.0, 1e-3 * tick}));
    CHECK(gap >= 0.0L);
    CHECK(std::abs(run.state.X_WG.p.x() - x) <= 1e-6);
    CHECK(run.result.status != ContactStatus::kRefused);
  }
}

TEST_CASE("the gradient of a gap is what the gap does when the tool steps and the string yields") {
  const RenderingScene scene = bar_on_string();
  SplitMix64 random(3);
  int judged = 0;
  for (int press = 0; press < 20; ++press) {
    const double x = random.uniform(0.1, 1.0);
    ToolRun run(scene, pose_at({x, 0.02, 0.0}));
    glide(run, {x, 0.007, 0.0}, {x + 1e-3, random.uniform(-0.02, 0.0), 0.0}, 30);
    const ContactInput input = run.input(run.state.X_WG);
    run.problem->begin(input, run.state, run.result);
    const ContactSet& contacts = run.problem->candidates().contacts();
    if (run.state.touched.size() != 1 || !run.state.touched[0].yields) continue;
    YieldingStrings strings;
    REQUIRE(strings.build({input, run.state}, contacts, kToolDof) == kToolDof + 2);
    const StringBlock& model = strings.block(0);
    if (!model.touched) continue;
    for (const Contact& contact : contacts.contacts) {
      if (contact.lambda <= 0.0 || contact.lambda >= 1.0) continue;
      const GapGradient gradient = strings.gradient(run.state, contact);
      const double share = deflection_share(run.state.touched[0].bend, contact.lambda);
      constexpr double kStep = 1e-6;
      const Vector3 dp = kStep * to_vector(random.direction());
      const Vector3 dtheta = 50.0 * kStep * to_vector(random.direction());
      const Vector3 any = kStep * to_vector(random.direction());
      const Vector3 du_W = any - any.dot(model.axis_W) * model.axis_W;
      const double told = gradient.linear.dot(dp) + gradient.angular.dot(dtheta) -
                          share * contact.nhat_OG_W.dot(du_W);
      const long double ahead = gap_after(run, contact, step_of(run, model, {dp, dtheta}, du_W));
      const long double behind =
          gap_after(run, contact, step_of(run, model, {-dp, -dtheta}, -du_W));
      CHECK(std::abs(static_cast<double>(0.5L * (ahead - behind)) - told) <= 1e-4 * kStep);
      ++judged;
    }
  }
  CHECK(judged > 20);
}

TEST_CASE("a wide tool held still on a string that yields comes to rest, its force and its pose") {
  const RenderingScene scene = bar_on_string();
  SplitMix64 random(11);
  int pressed = 0;
  double shaking = 0.0;
  for (int press = 0; press < 40; ++press) {
    const double x = random.uniform(0.1, 1.0);
    const Vector3 low(x, random.uniform(-0.01, 0.002), 0.0);
    const Pose X_WH = pose_at(low, {0.0, 0.0, random.uniform(-0.2, 0.2)});
    ToolRun run(scene, pose_at({x, 0.02, 0.0}));
    glide(run, {x, 0.007, 0.0}, low, 30);
    run.hold(X_WH, 200);
    const Pose rest = run.state.X_WG;
    if (run.result.active_count == 0) continue;
    ++pressed;
    for (int tick = 0; tick < 20; ++tick) {
      run.tick(X_WH);
      const ToolMotion moved = motion_between(rest, run.state.X_WG);
      shaking = std::max(shaking, displacement_bound(moved, reach(scene.tool())));
    }
  }
  CHECK(pressed > 20);
  CHECK(shaking <= 1e-7);
}

}  // namespace hapticd::test
