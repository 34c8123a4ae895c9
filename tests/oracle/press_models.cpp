// See press_models.h.
#include "tests/oracle/press_models.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "core/instrument/deflection.h"
#include "core/scene/quality.h"
#include "tests/oracle/study_run.h"

namespace hapticd {
namespace {

constexpr double kLambdas[] = {0.1, 0.5};
constexpr double kDepths[] = {1e-3, 5e-3, 15e-3};
constexpr double kFinger = 5e-3;
constexpr double kLength = 1.1;
/// Between two strings, m.
constexpr double kApart = 0.03;
/// The string lies between two spheres so far to its sides, m: from one alone it would slip.
constexpr double kBeside = 4e-3;
/// Of a gesture at 1 kHz.
constexpr int kTicks = static_cast<int>(1e3 * kStudyGesture_s);
/// Calls that one reading of the clock is for.
constexpr int kCalls = 100;

/// Of number `k` of `count` things in a row across the strings, m: the tool turns about their
/// middle.
double place(int k, int count) { return kApart * (k - 0.5 * (count - 1)); }

ShapeDescription fingers(int count) {
  std::vector<Sphere> spheres;
  spheres.reserve(2 * static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    for (const double side : {-kBeside, kBeside}) {
      spheres.push_back({{0.0, 0.0, place(k, count) + side}, kFinger});
    }
  }
  MeasuredTree file;
  file.tree = build_sphere_tree(spheres);
  ShapeDescription shape;
  shape.exact = true;
  shape.tree = std::make_shared<const MeasuredTree>(std::move(file));
  return shape;
}

/// As many fingers in a row as strings, each of two spheres, one string below each.
SceneDescription scene_of(int strings) {
  SceneDescription scene;
  scene.name = "press";
  ToolDescription tool;
  tool.name = "fingers";
  PartDescription part;
  part.name = "fingers";
  part.shape = fingers(strings);
  tool.parts.push_back(std::move(part));
  tool.X_WG.p = Vector3(0.0, 0.1, 0.0);
  scene.tools.push_back(std::move(tool));
  for (int k = 0; k < strings; ++k) {
    StringDescription string;
    string.name = "string " + std::to_string(k);
    string.parameters.p_WA = {0.0, 0.0, place(k, strings)};
    string.parameters.p_WB = {kLength, 0.0, place(k, strings)};
    scene.strings.push_back(std::move(string));
  }
  scene.quality_level = kDefaultQuality;
  scene.contact = quality_of(kDefaultQuality).options;
  return scene;
}

/// Height of the tool above a string that its spheres are `clearance` away from, m.
double height(const SceneDescription& scene, double clearance) {
  const double apart = kFinger + scene.strings.front().parameters.radius + clearance;
  return std::sqrt(apart * apart - kBeside * kBeside);
}

/// Straight down on the strings at lambda.
StudyGesture press_at(const SceneDescription& scene, double lambda, double depth) {
  StudyGesture gesture;
  gesture.X_WH_touch.p = Vector3(lambda * kLength, height(scene, 0.0), 0.0);
  gesture.depth = depth;
  return gesture;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Sums over presses.
struct Sum {
  double square = 0.0, truth_square = 0.0, largest = 0.0;
  std::vector<double> nanoseconds;

  void add(double force, double truth) {
    square += (force - truth) * (force - truth);
    truth_square += truth * truth;
    largest = std::max(largest, std::abs(force - truth));
  }
  PressModel result(int strings, bool coupled) {
    return {strings, coupled, std::sqrt(square / truth_square), largest, median(nanoseconds)};
  }
};

/// Equal strings, pressed at once by a coupling.
struct EqualStrings {
  const StringConstants& string;
  double lambda;
  double stiffness;  ///< of the coupling, N/m
  int count;
};

/// Their force on a coupling displaced by `displacement` (m), N: bisection in long double.
double force_of_strings(const EqualStrings& pressed, double displacement) {
  if (!(displacement > 0.0)) return 0.0;
  const StringConstants& string = pressed.string;
  const long double L = string.length;
  const long double share = pressed.lambda;
  const auto force = [&](long double delta) {
    const long double L1 = std::hypot(share * L, delta);
    const long double L2 = std::hypot((1.0L - share) * L, delta);
    const long double tension = string.tension + string.axial_stiffness * (L1 + L2 - L) / L;
    return tension * (delta / L1 + delta / L2);
  };
  long double low = 0.0L;
  long double high = displacement;
  for (int k = 0; k < 80; ++k) {
    const long double delta = 0.5L * (low + high);
    const bool deeper = pressed.count * force(delta) < pressed.stiffness * (displacement - delta);
    (deeper ? low : high) = delta;
  }
  return static_cast<double>(pressed.stiffness * (displacement - low));
}

/// Adds what the tool with its strings does, tick by tick.
void play_coupled(const SceneDescription& description, const Scene& scene,
                  const StudyGesture& gesture, const std::vector<double>& truth, Sum& sum) {
  StudySetting setting;
  setting.options = description.contact;
  const std::vector<StudyTick> ticks = play_study(scene, 0, setting, gesture, nullptr);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    sum.add(ticks[k].felt_W.y(), truth[k]);
    if (ticks[k].touches) sum.nanoseconds.push_back(1e3 * ticks[k].cpu_us);
  }
}

/// Adds what each string does by itself, pressed so deep in every tick.
void play_series(const EqualStrings& pressed, const std::vector<double>& depths,
                 const std::vector<double>& truth, Sum& sum) {
  for (std::size_t k = 0; k < depths.size(); ++k) {
    double force = 0.0;
    const double before = processor_time();
    for (int call = 0; call < kCalls * pressed.count; ++call) {
      force +=
          deflect_in_series(pressed.string, pressed.lambda, depths[k], pressed.stiffness).force;
    }
    if (depths[k] > 0.0) sum.nanoseconds.push_back(1e3 * (processor_time() - before) / kCalls);
    sum.add(force / kCalls, truth[k]);
  }
}

}  // namespace

std::vector<PressModel> compare_press_models() {
  std::vector<PressModel> models;
  for (const int strings : {1, 2}) {
    const SceneDescription description = scene_of(strings);
    const Scene scene(description);
    const StringConstants string = derive_string(description.strings.front().parameters);
    const double kt = description.tools.front().coupling.kt;
    Sum series, coupled;
    for (const double lambda : kLambdas) {
      for (const double depth : kDepths) {
        const EqualStrings pressed{string, lambda, kt, strings};
        const StudyGesture gesture = press_at(description, lambda, depth);
        std::vector<double> depths, truth;
        for (int tick = 0; tick < kTicks; ++tick) {
          depths.push_back(height(description, 0.0) - gesture.at(1e-3 * tick).p.y());
          truth.push_back(force_of_strings(pressed, depths.back()));
        }
        play_series(pressed, depths, truth, series);
        play_coupled(description, scene, gesture, truth, coupled);
      }
    }
    models.push_back(series.result(strings, false));
    models.push_back(coupled.result(strings, true));
  }
  return models;
}

}  // namespace hapticd
