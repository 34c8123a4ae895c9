// The script of the session. See contact_session.h.
#include "tests/realtime/contact_session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

/// Every so many ticks the device sends garbage for a few ticks, and the string is moved onto the
/// tool.
constexpr std::int64_t kGlitchPeriod = 997;
constexpr std::int64_t kOverlapPeriod = 1499;

double lowest_point(const std::vector<Sphere>& spheres) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Sphere& sphere : spheres) lowest = std::min(lowest, sphere.p.y() - sphere.r);
  return lowest;
}

/// Sine of `turns` whole turns.
double wave(double turns) { return sin_cos(2.0 * kPi * (turns - std::floor(turns))).sin; }

}  // namespace

ContactSession::ContactSession(Tool tool) : strings_(seven_strings()) {
  const std::vector<Sphere> spheres = tool == Tool::kHand ? hand_spheres() : blob_spheres(1000);
  tool_ = build_sphere_tree(spheres);
  body_ = build_sphere_tree(slab_spheres(160, 25));
  bodies_.push_back({body_.view(), Pose{}});
  touch_height_ = strings_.front().p_A.y() + strings_.front().r - lowest_point(spheres);
  scene_ = {tool_.view(), {strings_, bodies_}, {}, {}, {}};
}

HandPose ContactSession::sample() const noexcept {
  const double t = 1e-3 * static_cast<double>(tick_);
  // Mostly pressed on strings, sometimes down on the body, sometimes lifted off.
  const double height =
      touch_height_ - 17e-3 + 7e-3 * wave(0.9 * t) + 16e-3 * std::max(0.0, wave(0.11 * t));
  const Quaternion q =
      exp_rotation({0.10 * wave(0.7 * t), 0.3 * wave(0.13 * t), 0.12 * wave(0.5 * t)});
  HandPose out{
      1'000'000 * tick_, {0.2 * wave(0.21 * t), height, 0.05 * wave(0.8 * t)}, to_array(q)};
  if (tick_ % kGlitchPeriod < 3) out.p_WH[1] = std::numeric_limits<double>::quiet_NaN();
  return out;
}

void ContactSession::add_to_hash(const RenderedTool& tick) noexcept {
  const auto add = [this](double number) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (unsigned shift = 0; shift < 64; shift += 8) {
      hash_ = (hash_ ^ ((bits >> shift) & 0xffU)) * 0x100000001b3U;
    }
  };
  for (const double number : to_array(tick.F_H_W.f)) add(number);
  for (const double number : to_array(tick.F_H_W.t)) add(number);
  for (const double number : to_array(tick.X_WG.p)) add(number);
  for (const double number : to_array(tick.X_WG.q)) add(number);
}

void ContactSession::run(std::int64_t ticks) noexcept {
  RenderedTool tick;
  for (std::int64_t i = 0; i < ticks; ++i) {
    ++tick_;
    if (tick_ % kOverlapPeriod == 0) {
      // The middle string is edited onto the tool, and back a little later.
      rest_ = strings_[3];
      const Vector3& p_WG = state_.contact.X_WG.p;
      strings_[3].p_A = {rest_.p_A.x(), p_WG.y(), p_WG.z()};
      strings_[3].p_B = {rest_.p_B.x(), p_WG.y(), p_WG.z()};
    } else if (tick_ % kOverlapPeriod == 40 && tick_ > kOverlapPeriod) {
      strings_[3] = rest_;
    }
    if (guarded_render(sample(), hand_, {scene_, state_, *problem_}, tick) == PoseVerdict::kFault) {
      ++faults_;
      if (tick_ % kGlitchPeriod > 3) hand_.clear();
    }
    if (tick.contact.status == ContactStatus::kRecovering) ++recoveries_;
    if (tick.F_H_W.f.norm() > 0.0) ++contact_ticks_;
    add_to_hash(tick);
  }
}

}  // namespace hapticd::test
