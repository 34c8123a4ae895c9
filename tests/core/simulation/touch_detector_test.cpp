// Touches of bodies and lines: one beginning and one end each, at the right instant.
#include "core/simulation/touch_detector.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

ContactTick contact_of(std::int32_t part, ObstacleKind kind, std::int32_t obstacle, double force) {
  ContactTick contact;
  contact.part = part;
  contact.key.kind = kind;
  contact.key.obstacle = obstacle;
  contact.nhat_OG_W = {0.0, 1.0, 0.0};
  contact.force = force;
  return contact;
}

ContactReport report_of(std::initializer_list<ContactTick> contacts) {
  ContactReport report;
  report.contacts.clear();
  for (const ContactTick& contact : contacts) report.contacts.push_back(contact);
  report.total = static_cast<std::int32_t>(contacts.size());
  return report;
}

/// A tick of 1 ms that ends at `ms`, the hand going down at 0.5 m/s and along at 0.2 m/s.
TouchTick tick_at(std::int64_t ms, std::int32_t strings = 0) {
  TouchTick tick;
  tick.t_ns = ms * 1'000'000;
  tick.dt_ns = 1'000'000;
  tick.p_WG = Vector3::Zero();
  tick.V_WH.v = Vector3(0.2, -0.5, 0.0);
  tick.stiffness.kt = 1000.0;
  tick.strings = strings;
  return tick;
}

TouchEvents detect(const ContactReport& report, const TouchTick& tick, TouchDetector& detector) {
  TouchEvents events;
  events.clear();
  detect_touches(report, tick, detector, events);
  return events;
}

}  // namespace

TEST_CASE("a touch begins with force, once, and ends when the pair is no longer near") {
  TouchDetector detector;
  const auto near = report_of({contact_of(0, ObstacleKind::kBody, 2, 0.0)});
  const auto pressed = report_of({contact_of(0, ObstacleKind::kBody, 2, 1.5)});
  const auto light = report_of({contact_of(0, ObstacleKind::kBody, 2, 0.5)});
  CHECK(detect(near, tick_at(1), detector).empty());
  const TouchEvents begun = detect(pressed, tick_at(2), detector);
  REQUIRE(begun.size() == 1);
  CHECK(begun[0].begins);
  CHECK(begun[0].obstacle == 2);
  CHECK(begun[0].force == 1.5);
  CHECK(detect(light, tick_at(3), detector).empty());
  CHECK(detect(near, tick_at(4), detector).empty());
  const TouchEvents ended = detect(report_of({}), tick_at(5), detector);
  REQUIRE(ended.size() == 1);
  CHECK_FALSE(ended[0].begins);
  CHECK(ended[0].t_ns == 5'000'000);
  CHECK(ended[0].force == 1.5);
  CHECK(detect(report_of({}), tick_at(6), detector).empty());
}

TEST_CASE("the instant of a beginning is when the hand passed the surface at its speed") {
  TouchDetector detector;
  // 0.2 N are 0.2 mm of 1000 N/m, which 0.5 m/s go in 0.4 ms.
  const auto report = report_of({contact_of(0, ObstacleKind::kBody, 0, 0.2)});
  const TouchEvents events = detect(report, tick_at(10), detector);
  REQUIRE(events.size() == 1);
  CHECK(events[0].t_ns == 9'600'000);
  CHECK(events[0].normal_speed == doctest::Approx(0.5));
  CHECK(events[0].tangential_speed == doctest::Approx(0.2));
}

TEST_CASE("that instant lies within the tick, whatever the force") {
  TouchDetector detector;
  const auto report = report_of({contact_of(0, ObstacleKind::kBody, 0, 20.0)});
  CHECK(detect(report, tick_at(10), detector)[0].t_ns == 9'000'000);
}

TEST_CASE("contacts of one part with one object are one touch, and their forces add up") {
  TouchDetector detector;
  const auto report = report_of({contact_of(1, ObstacleKind::kCapsule, 9, 1.0),
                                 contact_of(1, ObstacleKind::kCapsule, 9, 2.0),
                                 contact_of(2, ObstacleKind::kCapsule, 9, 4.0)});
  const TouchEvents events = detect(report, tick_at(1), detector);
  REQUIRE(events.size() == 2);
  CHECK(events[0].force == 3.0);
  CHECK(events[1].force == 4.0);
}

TEST_CASE("strings are left to their own detector") {
  TouchDetector detector;
  const auto report = report_of({contact_of(0, ObstacleKind::kCapsule, 6, 1.0),
                                 contact_of(0, ObstacleKind::kCapsule, 7, 1.0)});
  const TouchEvents events = detect(report, tick_at(1, 7), detector);
  REQUIRE(events.size() == 1);
  CHECK(events[0].obstacle == 7);
}

}  // namespace hapticd::test
