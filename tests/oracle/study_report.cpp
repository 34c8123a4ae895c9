// See study_report.h.
#include "tests/oracle/study_report.h"

#include <algorithm>
#include <cmath>

#include "core/contact/tick_work.h"
#include "core/math/rotation.h"
#include "tests/oracle/json.h"

namespace hapticd {
namespace {

constexpr double kMinValue = 1e-3;

double shape_error(const ShapeDescription& shape, int level) {
  if (shape.exact) return 0.0;
  const std::vector<TreeLevel>& levels = shape.tree->levels;
  const auto coarse = static_cast<std::size_t>(level) - 1;
  return level != kLeafLevel && coarse < levels.size() ? levels[coarse].outer : shape.tree->outer;
}

Json bins_json(const Histogram& histogram) {
  Json bins = Json::array();
  for (const auto& [bin, count] : histogram) {
    bins.push_back(Json::array({bin, count}));
  }
  return bins;
}

/// Means of what was counted, per tick that touches.
struct Counts {
  std::size_t touching = 0;
  std::size_t lagging = 0;
  double work = 0.0, work_max = 0.0, tests = 0.0, iterations = 0.0, sub_steps = 0.0;
  double time_max = 0.0, time = 0.0;
  Histogram work_bins, time_bins;
};

Counts counts_of(const std::vector<StudyTick>& run) {
  Counts c;
  for (const StudyTick& tick : run) {
    if (!tick.touches) continue;
    ++c.touching;
    c.lagging += tick.counts.status == OptimiserStatus::kLagging ? 1 : 0;
    const auto work = static_cast<double>(tick_work(tick.counts));
    c.work += work;
    c.work_max = std::max(c.work_max, work);
    c.tests += static_cast<double>(tick.counts.tests);
    c.iterations += tick.counts.qp_iterations;
    c.sub_steps += tick.counts.sub_steps;
    c.time += tick.cpu_us;
    c.time_max = std::max(c.time_max, tick.cpu_us);
    count_value(work, c.work_bins);
    count_value(tick.cpu_us, c.time_bins);
  }
  return c;
}

}  // namespace

void count_value(double value, Histogram& histogram) {
  const double octaves = std::log2(std::max(value, kMinValue));
  ++histogram[static_cast<int>(std::floor(kBinsPerOctave * octaves))];
}

double quantile(const Histogram& histogram, double q) {
  std::size_t total = 0;
  for (const auto& [bin, count] : histogram) total += count;
  std::size_t seen = 0;
  for (const auto& [bin, count] : histogram) {
    seen += count;
    if (static_cast<double>(seen) >= q * static_cast<double>(total)) {
      return std::exp2(static_cast<double>(bin + 1) / kBinsPerOctave);
    }
  }
  return 0.0;
}

StudyErrors compare(const std::vector<StudyTick>& run, const std::vector<StudyTick>& truth,
                    double per_tick) {
  StudyErrors e;
  for (std::size_t j = 0; j < truth.size(); ++j) {
    const auto k = std::min(run.size() - 1,
                            static_cast<std::size_t>(static_cast<double>(j) / per_tick + 1e-9));
    const StudyTick& a = run[k];
    const StudyTick& b = truth[j];
    const double felt = (a.felt_W - b.felt_W).norm();
    const double contact = (a.contact_W - b.contact_W).norm();
    const double pose = (a.X_WG.p - b.X_WG.p).norm();
    ++e.ticks;
    e.felt_square += felt * felt;
    e.truth_square += b.felt_W.squaredNorm();
    e.felt_max = std::max(e.felt_max, felt);
    e.contact_square += contact * contact;
    e.contact_truth_square += b.contact_W.squaredNorm();
    e.contact_max = std::max(e.contact_max, contact);
    e.torque_square += (a.torque_W - b.torque_W).squaredNorm();
    e.torque_truth_square += b.torque_W.squaredNorm();
    e.pose_square += pose * pose;
    e.pose_max = std::max(e.pose_max, pose);
    e.turn_max = std::max(e.turn_max, log_rotation(a.X_WG.q * b.X_WG.q.conjugate()).norm());
  }
  return e;
}

std::string study_line(const std::string& name, const std::vector<StudyTick>& run,
                       const StudyErrors& e, double surface_m) {
  const Counts c = counts_of(run);
  double gap = run.front().path_gap_m;
  for (const StudyTick& tick : run) gap = std::fmin(gap, tick.path_gap_m);
  const double n = std::max<double>(1.0, static_cast<double>(c.touching));
  return text_of({{"name", name},
                  {"ticks", e.ticks},
                  {"touching", c.touching},
                  {"lagging", c.lagging},
                  {"felt_square", e.felt_square},
                  {"truth_square", e.truth_square},
                  {"felt_max_n", e.felt_max},
                  {"contact_square", e.contact_square},
                  {"contact_truth_square", e.contact_truth_square},
                  {"contact_max_n", e.contact_max},
                  {"torque_square", e.torque_square},
                  {"torque_truth_square", e.torque_truth_square},
                  {"pose_square", e.pose_square},
                  {"pose_max_m", e.pose_max},
                  {"turn_max_rad", e.turn_max},
                  {"path_gap_m", gap},
                  {"surface_m", surface_m},
                  {"work_mean", c.work / n},
                  {"work_p50", quantile(c.work_bins, 0.5)},
                  {"work_p99", quantile(c.work_bins, 0.99)},
                  {"work_max", c.work_max},
                  {"tests_mean", c.tests / n},
                  {"iterations_mean", c.iterations / n},
                  {"sub_steps_mean", c.sub_steps / n},
                  {"work_bins", bins_json(c.work_bins)},
                  {"timing",
                   {{"mean_us", c.time / n},
                    {"p50_us", quantile(c.time_bins, 0.5)},
                    {"p99_us", quantile(c.time_bins, 0.99)},
                    {"max_us", c.time_max},
                    {"bins", bins_json(c.time_bins)}}}});
}

double surface_error(const SceneDescription& scene, std::size_t tool,
                     const OptimiserOptions& options) {
  double of_tool = 0.0;
  double of_bodies = 0.0;
  for (const PartDescription& part : scene.tools[tool].parts) {
    of_tool = std::max(of_tool, shape_error(part.shape, options.tool_level));
  }
  for (const BodyDescription& body : scene.bodies) {
    of_bodies = std::max(of_bodies, shape_error(body.shape, options.body_level));
  }
  return of_tool + of_bodies;
}

}  // namespace hapticd
