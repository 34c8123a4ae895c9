// What the log says of devices that give hardly a force. Truth: the rule, by hand.
#include "server/daemon/force_watch.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace hapticd::test {
namespace {

DeviceProfile stick() {
  DeviceProfile profile;
  const std::string_view name = "stick";
  std::copy(name.begin(), name.end(), profile.name.begin());
  profile.peak_force = 3.0;
  return profile;
}

/// What is said once the share has settled.
std::optional<std::string> settled(ForceWatch& watch, std::uint32_t scene_id, std::size_t k,
                                   const BorneStiffness& borne) {
  auto first = watch.look(scene_id, k, borne, stick(), 22.0);
  return first ? first : watch.look(scene_id, k, borne, stick(), 22.0);
}

bool says(const std::optional<std::string>& line, const char* words) {
  return line && line->find(words) != std::string::npos;
}

}  // namespace

TEST_CASE(
    "a bound that leaves less than a twentieth is said, with device, bound, share and remedy") {
  ForceWatch watch;
  CHECK_FALSE(settled(watch, 1, 0, {7, 0.05, 50.0, 0.0}).has_value());
  const auto line = settled(watch, 1, 0, {7, 0.034, 34.2, 0.012});
  for (const char* words :
       {"tool 7", "stick", "34.2 N/m", "12 ms", "3.4 %", "damping_n_s_per_m 1"}) {
    CAPTURE(words);
    CHECK(says(line, words));
  }
}

TEST_CASE(
    "it is said once for each scene and tool, and again when it gets half as much or returns") {
  ForceWatch watch;
  const auto look = [&](std::uint32_t scene, std::size_t k, double share) {
    return settled(watch, scene, k, {0, share, 1e3 * share, 0.0}).has_value();
  };
  CHECK(look(1, 0, 0.04));
  for (int tick = 0; tick < 1000; ++tick) REQUIRE_FALSE(look(1, 0, 0.04));
  CHECK(look(1, 1, 0.04));
  CHECK_FALSE(look(1, 0, 0.021));
  CHECK(look(1, 0, 0.019));
  CHECK_FALSE(look(1, 0, 0.03));
  CHECK_FALSE(look(1, 0, 0.5));
  CHECK(look(1, 0, 0.04));
  CHECK(look(2, 0, 0.04));
  CHECK_FALSE(look(3, 0, 0.5));
  // A ramp is another share in every tick, and said when it is over.
  for (double share = 0.5; share > 1e-6; share *= 0.99) {
    REQUIRE_FALSE(watch.look(3, 0, {0, share, 1e3 * share, 0.0}, stick(), 22.0).has_value());
  }
  CHECK(look(3, 0, 1e-6));
}

TEST_CASE("a force that a limit of 0 takes away is said once for each scene, with its name") {
  DeviceProfile profile = stick();
  ForceWatch by_hand;
  CHECK(says(by_hand.look(1, 0, {0, 1.0, 1e3, 0.0}, profile, 0.0), "--max-force is 0"));
  CHECK_FALSE(by_hand.look(1, 0, {0, 1.0, 1e3, 0.0}, profile, 0.0).has_value());
  CHECK(by_hand.look(2, 0, {0, 1.0, 1e3, 0.0}, profile, 0.0).has_value());
  profile.continuous_force = 0.0;
  ForceWatch held;
  CHECK(says(held.look(1, 0, {0, 1.0, 1e3, 0.0}, profile, 22.0), "continuous_force_n"));
  profile.peak_force = 0.0;
  ForceWatch peak;
  CHECK(says(peak.look(1, 0, {0, 1.0, 1e3, 0.0}, profile, 22.0),
             "peak_force_n of its profile stick"));
  // What has no motors is not expected to push.
  profile.actuated_axes = 0;
  ForceWatch mouse;
  CHECK_FALSE(mouse.look(1, 0, {0, 1.0, 1e3, 0.0}, profile, 22.0).has_value());
}

TEST_CASE("a damping that is a guess is said once for each scene, with the stiffness granted") {
  DeviceProfile profile = stick();
  profile.damping_guessed = true;
  ForceWatch watch;
  const BorneStiffness borne{3, 0.2, 28.57, 3e-3, true};
  const auto line = watch.look(1, 0, borne, profile, 22.0);
  for (const char* words : {"tool 3", "stick", "guess", "28.6 N/m"}) CHECK(says(line, words));
  CHECK_FALSE(watch.look(1, 0, borne, profile, 22.0).has_value());
  CHECK(watch.look(2, 0, borne, profile, 22.0).has_value());
  // Hardly any is left: that is said as well, and why.
  const BorneStiffness weak{3, 0.0286, 28.57, 3e-3, true};
  CHECK(says(watch.look(3, 0, weak, profile, 22.0), "unknown device"));
  CHECK_FALSE(watch.look(3, 0, weak, profile, 22.0).has_value());
  CHECK(says(watch.look(3, 0, weak, profile, 22.0), "hardly any force"));
  CHECK_FALSE(watch.look(3, 0, weak, profile, 22.0).has_value());
}

TEST_CASE("a device of which nothing is known is told from one that is known to bear little") {
  DeviceProfile profile = stick();
  profile.damping = 0.0;
  ForceWatch unknown;
  CHECK_FALSE(unknown.look(1, 0, {0, 0.02, 20.0, 0.002}, profile, 22.0).has_value());
  CHECK(says(unknown.look(1, 0, {0, 0.02, 20.0, 0.002}, profile, 22.0), "states neither"));
}

}  // namespace hapticd::test
