// See force_watch.h.
#include "tests/core/simulation/force_watch.h"

#include <algorithm>
#include <cmath>

#include "tests/core/contact/string_law_truth.h"

namespace hapticd::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTick = 1e-3;
constexpr double kKt = 1000.0;
/// Change of force per tick that is always allowed, N.
constexpr double kFreeChange = 0.15;
/// Share by which the change may exceed that of the hand's motion and of the string's.
constexpr double kExcess = 1.1;
/// Of the hand's way in a tick.
constexpr int kSamples = 4;

double lambda_at(const Instrument& guqin, std::size_t string) {
  const Capsule& axis = guqin.capsules_W[string];
  const Vector3 way = axis.p_B - axis.p_A;
  return std::clamp((guqin.p_WH - axis.p_A).dot(way) / way.squaredNorm(), 0.0, 1.0);
}

}  // namespace

SwingBound::SwingBound(const StringParameters& string) : string_(string) {}

StaticPress static_press(const StringParameters& string, const Vector3& p_WH) {
  const Vector3 p_WA = to_vector(string.p_WA);
  const Vector3 way = to_vector(string.p_WB) - p_WA;
  const double lambda = std::clamp((p_WH - p_WA).dot(way) / way.squaredNorm(), 0.0, 1.0);
  const Vector3 offset = p_WH - p_WA - lambda * way;
  const double overlap = kFingertip + string.radius - offset.norm();
  if (!(overlap > 0)) return {};
  const LawString law = law_string(string);
  StaticPress press;
  if (string.model == StringContact::kStraight) {
    press.delta = overlap / string.k_s;
    press.energy = string.k_s * static_cast<double>(law_energy(law, lambda, press.delta));
    press.f_H_W = static_cast<double>(law_force(law, lambda, press.delta)) * offset.normalized();
    return press;
  }
  const double stiffness = std::min(string.contact_stiffness, kKt);
  press.delta = static_cast<double>(law_series(law, lambda, overlap, stiffness));
  const double force = stiffness * (overlap - press.delta);
  press.energy =
      static_cast<double>(law_energy(law, lambda, press.delta)) + 0.5 * force * force / stiffness;
  press.f_H_W = force * offset.normalized();
  return press;
}

void SwingBound::look(const Vector3& from, const Vector3& to, double dt) {
  for (int i = 1; i <= kSamples; ++i) {
    sample(from + (to - from) * (static_cast<double>(i) / kSamples), dt / kSamples);
  }
}

void SwingBound::sample(const Vector3& p, double dt) {
  const StaticPress press = static_press(string_, p);
  ringing_ *= std::exp(-dt / std::max(string_.decay, string_.touch_decay));
  largest_ = std::max(largest_, press.delta);
  if (delta_ > 0 && press.delta == 0) {
    ringing_ += largest_;
    largest_ = 0.0;
  }
  delta_ = press.delta;
}

ForceWatch::ForceWatch(Instrument& guqin, const Preset& preset)
    : guqin_(guqin), preset_(preset), tool_{{Vector3::Zero(), kFingertip}}, p_(guqin.p_WH) {
  const bool straight = preset.string.model == StringContact::kStraight;
  for (std::size_t s = 0; s < guqin.strings.size(); ++s) {
    StringParameters string = preset.string;
    string.p_WA = to_array(guqin.capsules_W[s].p_A);
    string.p_WB = to_array(guqin.capsules_W[s].p_B);
    if (string.frequency == 0.0) string.frequency = kTuning[s % std::size(kTuning)];
    swings_.emplace_back(string);
    if (straight) {
      rigid_.push_back(guqin.capsules_W[s]);
    } else {
      yielding_.push_back({guqin.capsules_W[s], string.tension,
                           static_cast<double>(law_string(string).axial), 0.0});
    }
  }
  scene_.tool_G = tool_;
  scene_.lines_W = rigid_;
  scene_.strings = yielding_;
  scene_.kt = kKt;
  place_ = place();
}

StaticPlace ForceWatch::place() const {
  const ContactState& state = guqin_.simulation().memory().tools[0].state.contact;
  StaticPlace place = free_place(scene_, state.X_WG);
  for (const TouchedString& hold : state.touched) {
    const auto s = static_cast<std::size_t>(hold.bend.capsule);
    if (s >= place.vertices_W.size()) continue;
    const Capsule& axis = guqin_.capsules_W[s];
    place.vertices_W[s] = axis.p_A + hold.bend.lambda * (axis.p_B - axis.p_A) + hold.bend.u_W;
  }
  return place;
}

Vector3 ForceWatch::exact_force() const {
  Vector3 f = rest_from(scene_, {{1, 0, 0, 0}, guqin_.p_WH}, place_).F_H_W.f;
  if (preset_.string.model != StringContact::kStraight || f.norm() == 0.0) return f;
  // A rigid string is one line; what the hand gets is Eq. 10 to 12 of how far it is pressed in.
  std::size_t nearest = 0;
  for (std::size_t s = 1; s < rigid_.size(); ++s) {
    const double z = guqin_.p_WH.z();
    if (std::abs(z - rigid_[s].p_A.z()) < std::abs(z - rigid_[nearest].p_A.z())) nearest = s;
  }
  StringParameters string = preset_.string;
  string.p_WA = to_array(rigid_[nearest].p_A);
  string.p_WB = to_array(rigid_[nearest].p_B);
  const double delta = f.norm() / (kKt * string.k_s);
  const long double force = law_force(law_string(string), lambda_at(guqin_, nearest), delta);
  return std::min(static_cast<double>(force), f.norm()) * f.normalized();
}

double ForceWatch::swing(std::size_t s) {
  const Capsule& axis = guqin_.capsules_W[s];
  const double lambda = lambda_at(guqin_, s);
  const Vector3 way = axis.p_B - axis.p_A;
  swings_[s].look(p_, guqin_.p_WH, kTick);
  const StringConstants& string = guqin_.strings[s];
  // A wave meets the finger itself, the fundamental alone is a force on what presses the string.
  const double at_rest = preset_.string.tension / (way.norm() * lambda * (1 - lambda));
  const double k_v = preset_.options.modes > 0
                         ? preset_.string.contact_stiffness
                         : std::min(preset_.string.contact_stiffness, at_rest);
  return k_v * swings_[s].amplitude() * 2.0 * kPi * string.frequency;
}

bool ForceWatch::lost_one() {
  const auto& strings = guqin_.output().tool(0).strings;
  bool lost = false;
  for (const std::int32_t string : pressed_) {
    lost = lost || std::none_of(strings.begin(), strings.end(),
                                [&](const PressedString& c) { return c.string == string; });
  }
  pressed_.clear();
  for (const PressedString& contact : strings) pressed_.push_back(contact.string);
  return lost;
}

double ForceWatch::look() {
  const Vector3& f = guqin_.output().tool(0).F_computed_H_W.f;
  const double way = (guqin_.p_WH - p_).norm();
  double most_swing = 0.0;
  for (std::size_t s = 0; s < swings_.size(); ++s) most_swing = std::max(most_swing, swing(s));
  const double allowed = std::max(kFreeChange, kExcess * kKt * way) + kExcess * most_swing * kTick;
  Vector3 from = f_;
  if (lost_one()) {
    ++lost_;
    from = exact_force();
  }
  const double ratio = (f - from).norm() / allowed;
  f_ = f;
  p_ = guqin_.p_WH;
  place_ = place();
  return ratio;
}

}  // namespace hapticd::test
