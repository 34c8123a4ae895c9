// See tick_cost.h.
#include "server/model/tick_cost.h"

#include <time.h>

#include <algorithm>

namespace hapticd {
namespace {

constexpr int kTicksPerObject = 200;
/// How far the hand goes beyond the place where the tool's middle would meet the object, m.
constexpr double kDepth = 5e-3;

/// The place of a sphere's surface that faces `from`.
Vector3 facing(const Sphere& sphere_W, const Vector3& from) {
  const Vector3 way = from - sphere_W.p;
  const double length = way.norm();
  return length > 0.0 ? Vector3(sphere_W.p + way * (sphere_W.r / length)) : sphere_W.p;
}

/// A place on or in each object of the scene.
std::vector<Vector3> places(const Scene& scene, std::size_t tool) {
  std::vector<Vector3> list;
  const ToolScene view = scene.tool_scene(tool);
  const Vector3 start = scene.description().tools[tool].X_WG.p;
  for (const Capsule& capsule : view.obstacles.capsules_W) {
    list.push_back(0.5 * (capsule.p_A + capsule.p_B));
  }
  for (const BodyView& body : view.obstacles.bodies) {
    const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(body.tree.leaf_r.size() / 2));
    list.push_back(facing({transform(body.X_WB, leaf.p), leaf.r}, start));
  }
  return list;
}

/// Processor time of this thread, us: what else the machine does is no cost of a tick.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

TickTimes summary(std::vector<double> times) {
  TickTimes result;
  result.ticks = static_cast<int>(times.size());
  if (times.empty()) return result;
  std::sort(times.begin(), times.end());
  result.median = times[times.size() / 2];
  result.p99 = times[times.size() * 99 / 100];
  result.worst = times.back();
  return result;
}

/// The hand on its way to an object and a little along it.
PoseSample sample_at(const Pose& start, const Vector3& place, const Vector3& nearest_G, int step) {
  const double share = std::min(1.0, 2.0 * step / kTicksPerObject);
  const double along = std::max(0.0, 2.0 * step / kTicksPerObject - 1.0);
  const Vector3 goal = place - start.q * nearest_G;
  const Vector3 way = goal - start.p;
  const double length = way.norm();
  const Vector3 deeper = length > 0.0 ? Vector3(way * (kDepth / length)) : Vector3::Zero();
  const Vector3 p = start.p + share * (way + deeper) + Vector3(0.01 * along, 0.0, 0.005 * along);
  return {0, to_array(p), to_array(start.q)};
}

}  // namespace

TickCost measure_ticks(const Scene& scene, std::size_t tool, int objects) {
  const ToolSimulation play = scene.simulate(tool);
  const auto output = std::make_unique<TickOutput>();
  const Pose start = scene.description().tools[tool].X_WG;
  const Vector3 tip_G = scene.tool_scene(tool).tool.leaf(0).p;
  const std::vector<Vector3> list = places(scene, tool);
  const std::size_t stride =
      std::max<std::size_t>(1, list.size() / static_cast<std::size_t>(std::max(1, objects)));
  std::vector<double> free;
  std::vector<double> contact;
  std::int64_t t_ns = 0;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, list.size()); i += stride) {
    const Vector3 place = list.empty() ? start.p : list[i];
    for (int step = 0; step < kTicksPerObject; ++step) {
      PoseSample sample = sample_at(start, place, tip_G, step);
      sample.t_ns = t_ns += 1'000'000;
      const double before = processor_time();
      play.simulation->step({sample}, *output);
      const double us = processor_time() - before;
      (output->tool.optimiser.active_count > 0 ? contact : free).push_back(us);
    }
  }
  return {summary(std::move(free)), summary(std::move(contact))};
}

}  // namespace hapticd
