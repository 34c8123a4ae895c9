// See wave_path.h.
#include "tests/core/simulation/wave_path.h"

#include <cmath>

namespace hapticd::test {
namespace {

constexpr double kTick = 1e-3;

/// Where the hand is by what ticks see of it: straight on from each to the next.
FingerPlace seen(const HandPath& path, double time) {
  const double tick = std::floor(time / kTick);
  const FingerPlace from = path.at(tick * kTick);
  const FingerPlace to = path.at((tick + 1.0) * kTick);
  const double share = time / kTick - tick;
  return {from.lambda + share * (to.lambda - from.lambda), from.d + share * (to.d - from.d)};
}

}  // namespace

HandPath& HandPath::go(const FingerPlace& place, double speed) {
  const Point& last = points_.back();
  const double way =
      std::hypot((place.d - last.place.d).norm(), kWaveLength * (place.lambda - last.place.lambda));
  points_.push_back({last.time + way / speed, place});
  return *this;
}

HandPath& HandPath::stay(double seconds) {
  points_.push_back({points_.back().time + seconds, points_.back().place});
  return *this;
}

FingerPlace HandPath::at(double time) const {
  std::size_t next = 1;
  while (next < points_.size() && points_[next].time < time) ++next;
  if (next == points_.size()) return points_.back().place;
  const Point& from = points_[next - 1];
  const Point& to = points_[next];
  const double share = to.time > from.time ? (time - from.time) / (to.time - from.time) : 1.0;
  return {from.place.lambda + share * (to.place.lambda - from.place.lambda),
          from.place.d + share * (to.place.d - from.place.d)};
}

Vector3 in_world(const FingerPlace& place) {
  return {kWaveLength * place.lambda, place.d.x(), place.d.y()};
}

FeltForces feel(Instrument& instrument, const HandPath& path) {
  FeltForces felt;
  instrument.tick(in_world(path.at(0.0)));
  for (int k = 1; k * kTick <= path.end(); ++k) {
    instrument.tick(in_world(path.at(k * kTick)));
    const Vector3 all = felt_force(instrument);
    Vector3 law = Vector3::Zero();
    for (const PressedString& pressed : instrument.output().tool(0).strings) law += pressed.F_W;
    felt.all.emplace_back(all.y(), all.z());
    felt.law.emplace_back(law.y(), law.z());
    const StringTick* row = instrument.reading(0);
    felt.energy.push_back(row == nullptr ? 0.0 : row->energy);
  }
  return felt;
}

GridString grid_of(const WaveScene& scene) {
  GridString grid;
  grid.length = kWaveLength;
  grid.tension = scene.tension;
  grid.frequency = scene.frequency;
  grid.loss = 1.0 / scene.decay;
  grid.loss_n2 = 0.002;
  grid.axial_stiffness = scene.axial_stiffness;
  return grid;
}

FeltForces feel(const WaveScene& scene, const HandPath& path, int cells) {
  StringGrid grid(grid_of(scene), cells);
  GridFinger finger;
  finger.radius = scene.reach();
  finger.stiffness = scene.kt;
  finger.friction = scene.friction;
  grid.add(finger);
  FeltForces felt;
  Across sum = Across::Zero();
  int steps = 0;
  for (int k = 1; k * kTick <= path.end();) {
    grid.step({seen(path, grid.time() + grid.step_s())});
    sum -= grid.finger(0).force;
    ++steps;
    if (grid.time() < k * kTick) continue;
    felt.all.push_back(sum / steps);
    felt.energy.push_back(grid.energy());
    sum = Across::Zero();
    steps = 0;
    ++k;
  }
  return felt;
}

}  // namespace hapticd::test
