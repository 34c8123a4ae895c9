// The fields of each kind of event. RT: yes.
#include "core/instrument/string_report.h"

#include <algorithm>

#include "core/instrument/deflection.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// 1200 / log 2: cents per unit of the natural logarithm of a ratio of frequencies.
constexpr double kCentsPerNeper = 1731.2340490667561;

/// Largest glide an event can hold, cents.
constexpr double kMaxGlide = 1200.0;

/// A new event, all other fields 0; null when there is no room.
StringEvent* append(const StringReport& report, StringEventKind kind, std::int64_t t_ns) noexcept {
  StringEvent* const event = report.events.append();
  if (event == nullptr) return nullptr;
  *event = StringEvent{};
  event->t_ns = t_ns;
  event->string = report.sounding.index;
  event->kind = kind;
  return event;
}

double tone_level(const ToneOptions& options, const ReleaseDetector& detector,
                  double amplitude) noexcept {
  const double level = options.level == ToneLevel::kForce ? detector.force / options.reference_force
                                                          : amplitude / options.reference_amplitude;
  return std::clamp(options.gain * level, 0.0, 1.0);
}

}  // namespace

void report_touch(const StringReport& report, const StringTouch& touch, bool ringing,
                  std::int64_t t_ns) noexcept {
  StringEvent* const event = append(report, StringEventKind::kTouch, t_ns);
  if (event == nullptr) return;
  event->ringing = ringing;
  event->lambda = touch.lambda;
  event->normal_speed = touch.normal_speed;
  event->tangential_speed = touch.tangential_speed;
  event->force = touch.force;
}

void report_armed(const StringReport& report, const StringTouch& touch, double deflection,
                  std::int64_t t_ns) noexcept {
  StringEvent* const event = append(report, StringEventKind::kPress, t_ns);
  if (event == nullptr) return;
  event->lambda = touch.lambda;
  event->force = touch.force;
  event->deflection = deflection;
}

void report_end(const StringReport& report, StringEventKind kind, std::int64_t t_ns) noexcept {
  StringEvent* const event = append(report, kind, t_ns);
  if (event == nullptr) return;
  const ReleaseDetector& detector = report.sounding.state.detector;
  event->lambda = detector.lambda;
  event->normal_speed = detector.normal_speed;
  event->tangential_speed = detector.tangential_speed;
  event->force = detector.largest_force;
  if (kind == StringEventKind::kRelease) event->deflection = detector.lost_deflection;
}

void report_tone(const StringReport& report, double amplitude) noexcept {
  const auto& [index, string, options, state] = report.sounding;
  const ReleaseDetector& detector = state.detector;
  StringEvent* const event = append(report, StringEventKind::kTone, detector.lost_ns);
  if (event == nullptr) return;
  event->lambda = detector.lambda;
  event->normal_speed = detector.normal_speed;
  event->tangential_speed = detector.tangential_speed;
  event->amplitude = amplitude;
  event->level = tone_level(options.tones, detector, amplitude);
  event->frequency = string.frequency;
  event->decay = string.decay;
  if (options.pitch_glide) {
    const Vibration& vibration = state.vibration;
    const double onset = fundamental_amplitude(string, energy_at(vibration, detector.lost_ns));
    const double cents = kCentsPerNeper * logarithm(pitch_factor(string, vibration.lambda, onset));
    event->glide_cents = std::clamp(cents, 0.0, kMaxGlide);
    // The extension, and with it the cents, goes with the square of the amplitude.
    event->glide_decay = 0.5 * string.decay;
  }
}

void report_press_radius(const StringReport& report, double deflection,
                         std::int64_t t_ns) noexcept {
  StringEvent* const event = append(report, StringEventKind::kRadius, t_ns);
  if (event == nullptr) return;
  event->radius_phase = RadiusPhase::kPress;
  event->deflection = deflection;
}

void report_ringing_radius(const StringReport& report, RadiusPhase phase,
                           const Envelope& envelope) noexcept {
  StringEvent* const event = append(report, StringEventKind::kRadius, envelope.t_ns);
  if (event == nullptr) return;
  event->radius_phase = phase;
  event->amplitude = envelope.amplitude;
  event->decay = envelope.decay;
  if (envelope.amplitude > 0.0) event->frequency = report.sounding.string.frequency;
}

}  // namespace hapticd
