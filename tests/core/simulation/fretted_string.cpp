// See fretted_string.h.
#include "tests/core/simulation/fretted_string.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/core/scene/scene_builder.h"
#include "tests/support/string_shape.h"

namespace hapticd::test {
namespace {

constexpr double kFretRadius = 1e-3;
constexpr double kStringRadius = 0.4e-3;

LineDescription fret_of(const FretTop& top, std::size_t number) {
  LineDescription fret;
  fret.name = "fret" + std::to_string(number);
  fret.radius = kFretRadius;
  const double y = -top.below - kStringRadius - kFretRadius;
  fret.points_W = {{top.x, y, -0.03}, {top.x, y, 0.03}};
  return fret;
}

/// Spheres whose tops lie in a plane, so close that it is flat within 6 um.
BodyDescription board_of(double length, double below) {
  constexpr double kRadius = 0.08;
  constexpr double kPitch = 2e-3;
  std::vector<Sphere> spheres;
  for (double x = 0.0; x <= length; x += kPitch) {
    spheres.push_back({{x, -below - kStringRadius - kRadius, 0.0}, kRadius});
  }
  BodyDescription board;
  board.name = "board";
  board.shape = shape_of(spheres);
  return board;
}

struct Point {
  double x, y;
};

/// The taut way between two points over the tops: the upper convex hull.
double taut(const std::vector<FretTop>& tops, const Point& from, const Point& to) {
  std::vector<Point> points{from};
  for (const FretTop& top : tops) {
    if (top.x > from.x && top.x < to.x) points.push_back({top.x, -top.below});
  }
  points.push_back(to);
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
  std::vector<Point> hull;
  for (const Point& p : points) {
    while (hull.size() > 1) {
      const Point& a = hull[hull.size() - 2];
      const Point& b = hull.back();
      if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) < 0.0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < hull.size(); ++k) {
    length += std::hypot(hull[k + 1].x - hull[k].x, hull[k + 1].y - hull[k].y);
  }
  return length;
}

}  // namespace

double way_over(const FrettedOptions& options, double x, double down) {
  return taut(options.frets, {0.0, 0.0}, {x, -down}) +
         taut(options.frets, {x, -down}, {options.length, 0.0});
}

double pressed_force(const FrettedOptions& options, double x, double depth, double kt) {
  const auto energy = [&](double down) {
    const double extension = way_over(options, x, down) - options.length;
    return options.tension * extension +
           0.5 * options.axial_stiffness / options.length * extension * extension +
           0.5 * kt * (depth - down) * (depth - down);
  };
  double low = 0.0;
  double high = depth;
  for (int k = 0; k < 200; ++k) {
    const double a = low + (high - low) / 3.0;
    const double b = high - (high - low) / 3.0;
    (energy(a) > energy(b) ? low : high) = energy(a) > energy(b) ? a : b;
  }
  return kt * (depth - 0.5 * (low + high));
}

SceneDescription fretted_scene(const FrettedOptions& options) {
  SceneDescription scene = finger_scene({0.3, 0.05, 0.0});
  for (std::size_t k = 1; k < options.fingers; ++k) {
    scene.tools.push_back(scene.tools.front());
    scene.tools.back().tool_id = static_cast<std::uint32_t>(k);
  }
  StringDescription string = string_between({0.0, 0.0, 0.0}, {options.length, 0.0, 0.0});
  string.parameters.radius = kStringRadius;
  string.parameters.tension = options.tension;
  string.parameters.frequency = options.frequency;
  string.parameters.axial_stiffness = options.axial_stiffness;
  string.parameters.friction_coefficient = options.friction;
  for (std::size_t k = 0; k < options.frets.size(); ++k) {
    scene.lines.push_back(fret_of(options.frets[k], k));
    string.touched_lines.push_back(k);
  }
  if (options.board_below > 0.0) {
    scene.bodies.push_back(board_of(options.length, options.board_below));
    string.touched_bodies.push_back(0);
  }
  scene.strings.push_back(string);
  scene.instrument.vibration = options.sounds;
  scene.instrument.modes = options.sounds ? 32 : 0;
  scene.instrument.tones.enabled = options.sounds;
  scene.instrument.friction = options.friction > 0.0;
  return scene;
}

FrettedString::FrettedString(const FrettedOptions& options)
    : options_(options),
      scene_(std::make_unique<Scene>(fretted_scene(options))),
      play_(scene_->simulate()) {}

const SimulationTick& FrettedString::tick(const std::vector<Vector3>& p_WH) {
  t_ns_ += 1'000'000;
  std::vector<HandPose> hands;
  hands.reserve(p_WH.size());
  for (const Vector3& p : p_WH) hands.push_back({t_ns_, to_array(p), {1.0, 0.0, 0.0, 0.0}});
  output_.step(simulation(), hands);
  return output_;
}

Vector3 FrettedString::force(std::size_t finger) const {
  return output_.tool(finger).F_computed_H_W.f;
}

bool FrettedString::recovers(std::size_t finger) const {
  return output_.tool(finger).contact.status == ContactStatus::kRecovering;
}

double FrettedString::sunk() const {
  const StringPoints way = string_shape(*play_.simulation, 0);
  double most = -1.0;
  for (const FretTop& top : options_.frets) {
    for (std::size_t k = 0; k + 1 < way.size(); ++k) {
      const Vector3& a = way[k];
      const Vector3& b = way[k + 1];
      if (top.x < a.x() || top.x > b.x() || !(b.x() > a.x())) continue;
      const double y = a.y() + (b.y() - a.y()) * (top.x - a.x()) / (b.x() - a.x());
      most = std::max(most, -top.below - y);
    }
  }
  return most;
}

double FrettedString::reach() const { return kFretFinger + kStringRadius; }

}  // namespace hapticd::test
