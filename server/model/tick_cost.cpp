// See tick_cost.h.
#include "server/model/tick_cost.h"

#include <time.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// The hand goes 1 mm a tick, 1 m/s, to each object and then a tenth of that along it.
constexpr double kStep = 1e-3;
constexpr int kTicksAlong = 200;
/// From far away it goes faster.
constexpr int kMaxTicks = 1000;

/// Processor times, us.
struct Samples {
  std::vector<double> free, contact;
  std::vector<double> work;   ///< of all ticks
  double contact_work = 0.0;  ///< of ticks in contact, together
};

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

/// Processor time of this thread, us: what else the machine does is not a cost of a tick.
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

/// Centre of the tool's leaf that is nearest to `place`, from the tool's origin, in W.
Vector3 nearest_leaf(const SphereTreeView& tool, const Pose& X_WG, const Vector3& place) {
  Vector3 nearest = Vector3::Zero();
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < tool.leaf_r.size(); ++i) {
    const Sphere leaf = tool.leaf(static_cast<std::int32_t>(i));
    const Vector3 p = X_WG.q * leaf.p;
    const double gap = (X_WG.p + p - place).norm() - leaf.r;
    if (gap >= smallest) continue;
    smallest = gap;
    nearest = p;
  }
  return nearest;
}

/// Leads a tool that begins afresh to `place` and along it.
void visit(const Scene& scene, std::size_t tool, const Vector3& place, Samples& samples) {
  const OwnedSimulation play = scene.simulate(tool);
  const auto told = std::make_unique<Tick>();
  ToolTick& hand = *told->tools.append();
  const Pose start = scene.description().tools[tool].X_WG;
  const Vector3 way = place - nearest_leaf(scene.tool_scene(tool).tool, start, place) - start.p;
  const double length = way.norm();
  const int approach = static_cast<int>(std::min(length / kStep, 1.0 * kMaxTicks)) + 1;
  for (int tick = 0; tick <= approach + kTicksAlong; ++tick) {
    const double share = std::min(1.0, static_cast<double>(tick) / approach);
    const double along = std::max(0, tick - approach) * 0.1 * kStep;
    const Vector3 p = start.p + share * way + Vector3(along, 0.0, 0.5 * along);
    hand.placed = {std::int64_t{1'000'000} * (tick + 1), to_array(p), to_array(start.q)};
    const double before = processor_time();
    play.simulation->step(*told);
    const double us = processor_time() - before;
    const bool contact = hand.contact.active_count > 0;
    const auto work = static_cast<double>(told->work.work);
    (contact ? samples.contact : samples.free).push_back(us);
    samples.work.push_back(work);
    if (contact) samples.contact_work += work;
  }
}

BoundedTicks held_against(double budget_us, const Samples& samples) {
  const double contact_us = std::accumulate(samples.contact.begin(), samples.contact.end(), 0.0);
  const double unit_us =
      samples.contact_work > 0.0 ? contact_us / samples.contact_work : 1e-3 * kNominalWork_ns;
  BoundedTicks bounded;
  bounded.budget_us = budget_us;
  bounded.ticks = static_cast<int>(samples.work.size());
  for (const double work : samples.work) {
    bounded.most_us = std::max(bounded.most_us, unit_us * work);
    if (unit_us * work > budget_us) ++bounded.beyond;
  }
  return bounded;
}

}  // namespace

TickCost measure_ticks(const Scene& scene, std::size_t tool, int objects, double budget_us) {
  const std::vector<Vector3> list = places(scene, tool);
  const std::size_t stride =
      std::max<std::size_t>(1, list.size() / static_cast<std::size_t>(std::max(1, objects)));
  Samples samples;
  for (std::size_t i = 0; i < list.size(); i += stride) visit(scene, tool, list[i], samples);
  const BoundedTicks bounded = held_against(budget_us, samples);
  return {summary(std::move(samples.free)), summary(std::move(samples.contact)), bounded};
}

}  // namespace hapticd
