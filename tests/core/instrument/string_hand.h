// A hand that presses one string: moves it from distance to distance, with the static force that
// the string has in series with the hand's spring, and keeps what respond() reports. For tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/instrument/deflection.h"
#include "core/instrument/string_model.h"
#include "tests/core/instrument/strings.h"

namespace hapticd::test {

inline constexpr std::int64_t kTick_ns = 1'000'000;

/// The hand, the string and all that has happened to them.
struct StringHand {
  StringConstants string = guqin_string();
  InstrumentOptions options;
  StringState state;
  StringEvents events;           ///< of the last tick
  std::vector<StringEvent> log;  ///< of all ticks
  StringTouch touch;             ///< of the last tick
  StringResponse response;
  double distance = 1e-3;  ///< of the tool from the string, m
  double lambda = 0.5;
  double tangential_speed = 0.0;
};

/// The string of a Guqin, tuned to f_1 (Hz).
inline StringConstants sounding_string(double frequency) {
  StringParameters parameters = string_parameters(1.1, 30.0, 1.9e11, 0.34e-3);
  parameters.frequency = frequency;
  return derive_string(parameters);
}

/// One tick in which the tool moves evenly to `distance` (m, negative: into the string).
inline void move_to(StringHand& hand, double distance, std::int64_t dt_ns = kTick_ns) {
  const double pressed = std::fmax(-distance, 0.0);
  const SeriesDeflection bent =
      deflect_in_series(hand.string, hand.lambda, pressed, hand.string.contact_stiffness);
  const std::int64_t t_ns = hand.touch.time.t_ns + dt_ns;
  hand.touch = StringTouch{};
  hand.touch.time = {t_ns, dt_ns};
  hand.touch.distance_before = hand.distance;
  hand.touch.distance = distance;
  hand.touch.force = bent.force;
  hand.touch.deflection = bent.delta;
  hand.touch.lambda = hand.lambda;
  hand.touch.stiffness = hand.string.contact_stiffness;
  if (dt_ns > 0) {
    hand.touch.normal_speed = (hand.distance - distance) / (static_cast<double>(dt_ns) * 1e-9);
  }
  hand.touch.tangential_speed = hand.tangential_speed;
  hand.distance = distance;
  hand.events.clear();
  hand.response = respond({7, hand.string, hand.options, hand.state}, hand.touch, hand.events);
  hand.log.insert(hand.log.end(), hand.events.begin(), hand.events.end());
}

/// Moves evenly to `distance` in so many ticks.
inline void glide_to(StringHand& hand, double distance, int ticks, std::int64_t dt_ns = kTick_ns) {
  const double start = hand.distance;
  for (int i = 1; i <= ticks; ++i) move_to(hand, start + (distance - start) * i / ticks, dt_ns);
}

/// Presses to the deflection (m), waits until its onset is forgotten, slips off to a gap of 2 mm,
/// and takes the tool away.
inline void pluck(StringHand& hand, double deflection) {
  const double force = deflection_force(hand.string, hand.lambda, deflection);
  glide_to(hand, -deflection - force / hand.string.contact_stiffness, 100);
  for (int i = 0; i < 400; ++i) move_to(hand, hand.distance);
  move_to(hand, 2e-3);
  glide_to(hand, 0.05, 20);
}

/// How many events of a kind there have been.
inline int count_events(const StringHand& hand, StringEventKind kind) {
  int count = 0;
  for (const StringEvent& event : hand.log) count += event.kind == kind ? 1 : 0;
  return count;
}

/// The last event of a kind; one of index -1 where there was none.
inline StringEvent last_event(const StringHand& hand, StringEventKind kind) {
  for (auto event = hand.log.rbegin(); event != hand.log.rend(); ++event) {
    if (event->kind == kind) return *event;
  }
  StringEvent none;
  none.string = -1;
  return none;
}

}  // namespace hapticd::test
