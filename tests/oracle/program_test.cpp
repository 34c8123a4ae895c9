// hapticd-oracle run as a user runs it: what it says when it is asked nonsense, and that the pages'
// numbers are there. Truth: closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/support/shell_run.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// Runs hapticd-oracle with these arguments of the shell; what it prints and its complaints.
ShellOutcome run(const std::string& arguments) {
  return run_in_shell(std::string("'") + HAPTICD_ORACLE_PROGRAM + "' " + arguments + " 2>&1");
}

/// The number behind `key` where it stands first after `behind`.
double number(const std::string& text, const std::string& behind, const std::string& key) {
  const std::size_t place = text.find("\"" + key + "\":", text.find(behind));
  REQUIRE(place != std::string::npos);
  return std::strtod(text.c_str() + place + key.size() + 3, nullptr);
}

}  // namespace

TEST_CASE("a command line that makes no sense ends with 2 and says what to do") {
  CHECK(run("").code == 2);
  const ShellOutcome neither = run("baseline --method paper");
  CHECK(neither.code == 2);
  CHECK(neither.says("give a RECORDING, or --scene and --poses together"));
  CHECK(run("baseline --method magic x.mcap").code == 2);
  const ShellOutcome missing = run("path /nowhere.mcap");
  CHECK(missing.code == 1);
  CHECK(missing.says("/nowhere.mcap"));
  CHECK(run("triangle --tension -1").code == 2);
}

TEST_CASE("beyond a string's end ours measures to its cap, and the paper to its line") {
  const ShellOutcome outcome = run("cases");
  REQUIRE(outcome.code == 0);
  // 3 mm beyond the end and 3.34 mm above the axis; radii 5 and 0.34 mm.
  CHECK(number(outcome.text, "\"beyond_the_end\"", "distance_m") ==
        doctest::Approx(std::hypot(3e-3, 3.34e-3)));
  CHECK(number(outcome.text, "\"beyond_the_end\"", "d_m") == doctest::Approx(3.34e-3));
  CHECK(number(outcome.text, "\"beyond_the_end\"", "gap_m") ==
        doctest::Approx(std::hypot(3e-3, 3.34e-3) - 5.34e-3));
}

TEST_CASE("the force triangle has Pythagoras' sides") {
  const ShellOutcome outcome = run("triangle --length 2");
  REQUIRE(outcome.code == 0);
  const std::string row = "{\"lambda\":0.25,\"delta_m\":0.02";
  CHECK(number(outcome.text, row, "l1_m") == doctest::Approx(std::hypot(0.5, 0.02)));
  CHECK(number(outcome.text, row, "l2_m") == doctest::Approx(std::hypot(1.5, 0.02)));
  CHECK(number(outcome.text, row, "theta_1_rad") == doctest::Approx(std::atan(0.04)));
}

TEST_CASE("more modes bring a string's force to the truth, and glide its pitch near it") {
  const ShellOutcome outcome = run("strings");
  REQUIRE(outcome.code == 0);
  const auto error = [&](const std::string& name) {
    return number(outcome.text, "\"name\":\"" + name + "\"", "model_error");
  };
  CHECK(error("fundamental") > 1.0);
  CHECK(error("8 modes") < 0.5 * error("4 modes"));
  CHECK(error("32 modes") < 2e-2);
  // Half the energy's stretch, EA E / (2 L T^2), decaying; the truth adds what swings with it.
  const std::string pluck = "\"pluck_lambda\":0.1,\"deflection_m\":0.005";
  const double cents = number(outcome.text, pluck, "truth_cents");
  CHECK(cents > 80.0);
  CHECK(cents < 120.0);
  CHECK(number(outcome.text, pluck, "error_cents") == within(-cents, 1e-3));
  CHECK(std::fabs(number(outcome.text, pluck, "error_with_glide_cents")) < 0.06 * cents);
  // One string is in series with the coupling; two share it, so that each by itself gives too much.
  const auto press = [&](int strings, const std::string& solved) {
    return number(outcome.text,
                  "\"strings\":" + std::to_string(strings) + ",\"solved\":\"" + solved + "\"",
                  "error");
  };
  CHECK(press(1, "series") < 1e-12);
  CHECK(press(1, "coupled") < 5e-3);
  CHECK(press(2, "series") > 0.2);
  CHECK(press(2, "coupled") < 5e-3);
}

}  // namespace hapticd::test
