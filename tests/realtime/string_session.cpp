// The script of the session. See string_session.h.
#include "tests/realtime/string_session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

/// Every so many ticks the device sends garbage for a few ticks.
constexpr std::int64_t kGlitchPeriod = 997;

/// Tunings of the seven strings, Hz.
constexpr double kTuning[] = {65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8};

/// Sine of `turns` whole turns.
double wave(double turns) { return sin_cos(2.0 * kPi * (turns - std::floor(turns))).sin; }

double lowest_point(const std::vector<Sphere>& spheres) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Sphere& sphere : spheres) lowest = std::min(lowest, sphere.p.y() - sphere.r);
  return lowest;
}

InstrumentOptions options_of(StringSession::Play play) {
  InstrumentOptions options;
  if (play == StringSession::Play::kPaper) options.tones.level = ToneLevel::kForce;
  if (play == StringSession::Play::kModes) {
    options.modes = 16;
    options.friction = true;
    options.lateral_force = true;
    options.pitch_glide = true;
  }
  return options;
}

}  // namespace

StringSession::StringSession(Play play) : capsules_(seven_strings()) {
  const std::vector<Sphere> spheres =
      play == Play::kDeflecting ? hand_spheres() : std::vector<Sphere>{{Vector3::Zero(), 5e-3}};
  tool_ = build_sphere_tree(spheres);
  touch_height_ = capsules_.front().p_A.y() + capsules_.front().r - lowest_point(spheres);
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    StringParameters string;
    string.p_WA = to_array(capsules_[i].p_A);
    string.p_WB = to_array(capsules_[i].p_B);
    string.radius = capsules_[i].r;
    string.frequency = kTuning[i % std::size(kTuning)];
    string.model = play == Play::kPaper ? StringContact::kStraight : StringContact::kYielding;
    string.friction_coefficient = 0.3;
    string.inharmonicity = 1e-4;
    strings_.push_back(derive_string(string));
  }
  ToolScene scene;
  scene.tool = tool_.view();
  scene.obstacles.capsules_W = capsules_;
  scene.strings = strings_;
  scene.instrument = options_of(play);
  play_ = own_simulation({&scene, 1});
}

HandPose StringSession::sample() noexcept {
  // Mostly even ticks; now and then a repeated, a late and a long one.
  const std::int64_t turn = tick_ % 211;
  t_ns_ += turn == 50 ? 0 : turn == 51 ? -500'000 : turn == 52 ? 6'500'000 : 1'000'000;
  const double t = 1e-3 * static_cast<double>(tick_);
  // Sweeps across the strings and along them, at times pressed, at times above.
  const double height = touch_height_ - 1e-3 + 3e-3 * wave(1.7 * t) + 4e-3 * wave(0.31 * t);
  const Quaternion q =
      exp_rotation({0.1 * wave(0.7 * t), 0.2 * wave(0.13 * t), 0.1 * wave(0.5 * t)});
  HandPose out{t_ns_, {0.3 * wave(0.21 * t), height, 0.07 * wave(0.8 * t)}, to_array(q)};
  if (tick_ % kGlitchPeriod < 3) out.p_WH[1] = std::numeric_limits<double>::quiet_NaN();
  return out;
}

void StringSession::add(double number) noexcept {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  for (unsigned shift = 0; shift < 64; shift += 8) {
    hash_ = (hash_ ^ ((bits >> shift) & 0xffU)) * 0x100000001b3U;
  }
}

void StringSession::add_to_hash(const SimulationTick& output) noexcept {
  for (const double number : to_array(output.tool(0).F_H_W.f)) add(number);
  for (const double number : to_array(output.tool(0).F_H_W.t)) add(number);
  for (const double number : to_array(output.tool(0).X_WG.p)) add(number);
  for (const double number : to_array(output.tool(0).X_WG.q)) add(number);
  for (const StringTick& reading : output.strings()) {
    add(reading.string);
    add(static_cast<double>(reading.phase));
    add(reading.lambda);
    add(reading.radius_growth);
    add(reading.vibration_force);
    for (const double number : reading.deflection_W) add(number);
  }
  for (const StringEvent& event : output.events()) {
    add(static_cast<double>(event.t_ns));
    add(event.string);
    add(static_cast<double>(event.kind));
    for (const double number :
         {event.lambda, event.normal_speed, event.tangential_speed, event.force, event.deflection,
          event.amplitude, event.level, event.frequency, event.glide_cents}) {
      add(number);
    }
    for (int k = 0; k < event.partial_count; ++k) {
      add(static_cast<double>(event.partials[static_cast<std::size_t>(k)]));
    }
  }
}

void StringSession::run(std::int64_t ticks) noexcept {
  for (std::int64_t i = 0; i < ticks; ++i) {
    ++tick_;
    if (guarded_step(sample(), hand_, *play_.simulation, output_) == PoseVerdict::kFault) {
      ++faults_;
      if (tick_ % kGlitchPeriod > 3) hand_.clear();
    }
    if (output_.tool(0).F_H_W.f.norm() > 0.0) ++contact_ticks_;
    bool struck = false;
    for (const StringTick& reading : output_.strings()) {
      struck = struck || reading.vibration_force != 0.0;
    }
    if (struck) ++struck_ticks_;
    for (const StringEvent& event : output_.events()) {
      if (event.kind == StringEventKind::kTone) ++tones_;
    }
    add_to_hash(output_);
  }
}

}  // namespace hapticd::test
