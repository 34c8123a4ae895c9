// See session_run.h.
#include "tests/core/contact/session_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/contact/tick_work.h"
#include "tests/core/contact/rendering_fixture.h"

namespace hapticd::test {

SessionRun play(const ContactSession& session, const ContactOptions& options, double rate_hz,
                const SessionStrings* lines, std::int64_t work_budget) {
  using Clock = std::chrono::steady_clock;
  RenderingScene scene(session.tool_G);
  scene.capsules_W = session.capsules_W;
  if (lines != nullptr) {
    scene.instrument = lines->instrument;
    for (const Capsule& line : session.capsules_W) {
      StringParameters string = lines->parameters;
      string.p_WA = to_array(line.p_A);
      string.p_WB = to_array(line.p_B);
      string.radius = line.r;
      scene.strings.push_back(derive_string(string));
    }
  }
  for (const SessionBody& body : session.bodies) scene.add_body(body.spheres_B, pose_at(body.p_WB));
  const auto pose = [&](int tick) {
    const SessionPose X_WH = session.X_WH(tick / rate_hz);
    return pose_at(X_WH.p_WH, X_WH.phi_WH);
  };

  ToolRun tool(scene, pose(0));
  tool.options = options;
  tool.work_budget = work_budget;
  SessionRun run;
  for (int tick = 0; tick < static_cast<int>(session.seconds * rate_hz); ++tick) {
    const Pose X_WH = pose(tick);
    const auto start = Clock::now();
    tool.tick(X_WH);
    const auto stop = Clock::now();
    run.f_H_W.push_back(tool.result.F_H_W.f);
    run.microseconds.push_back(std::chrono::duration<double, std::micro>(stop - start).count());
    run.work.push_back(tick_work(tool.result));
    run.most_sub_steps = std::max(run.most_sub_steps, tool.result.sub_steps);
  }
  return run;
}

ForceError force_error(std::span<const Vector3> f_H_W, std::span<const Vector3> reference) {
  ForceError out;
  double error_squared = 0.0;
  double force_squared = 0.0;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    const double error = (f_H_W[k] - reference[k]).norm();
    const double force = reference[k].norm();
    error_squared += error * error;
    force_squared += force * force;
    out.max_newton = std::max(out.max_newton, error);
    out.largest_force = std::max(out.largest_force, force);
  }
  out.rms_percent = 100.0 * std::sqrt(error_squared / force_squared);
  return out;
}

}  // namespace hapticd::test
