// Eq. 10-12 and the series law against values computed in 120 digits: deflection_truth.csv, which
// make_deflection_truth.py writes.
#include <doctest/doctest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/instrument/deflection.h"
#include "tests/core/instrument/strings.h"

namespace hapticd::test {
namespace {

constexpr const char* kFile = HAPTICD_SOURCE_DIR "/tests/core/instrument/deflection_truth.csv";
constexpr const char* kHeader =
    "length,tension,youngs_modulus,radius,lambda,displacement,stiffness,force,slope,energy,"
    "axial_force,lateral_force,series_delta,series_force";
/// Lines the file has at least: fewer is a truncated one.
constexpr std::size_t kMinLines = 2000;

/// Relative error of every number of Deflection, 1. Reached: 9.7e-16; 1e-9 would do for touch.
constexpr long double kMaxError = 2e-15L;

struct Truth {
  StringConstants string;
  double lambda;
  double displacement;
  double stiffness;
  long double force;
  long double slope;
  long double energy;
  long double axial_force;
  long double lateral_force;
  long double series_delta;
  long double series_force;
};

Truth parse(const std::string& line) {
  std::array<std::string, 14> cells;
  std::istringstream stream(line);
  for (std::string& cell : cells) REQUIRE(std::getline(stream, cell, ','));
  REQUIRE(stream.peek() == std::istringstream::traits_type::eof());
  const auto in = [&](std::size_t i) { return std::strtod(cells.at(i).c_str(), nullptr); };
  const auto out = [&](std::size_t i) { return std::strtold(cells.at(i).c_str(), nullptr); };
  return {make_string(in(0), in(1), in(2), in(3)),
          in(4),
          in(5),
          in(6),
          out(7),
          out(8),
          out(9),
          out(10),
          out(11),
          out(12),
          out(13)};
}

std::vector<Truth> read_truth() {
  std::ifstream file(kFile);
  REQUIRE_MESSAGE(file.is_open(), "no " << kFile);
  std::string line;
  REQUIRE(std::getline(file, line));
  REQUIRE(line == kHeader);
  std::vector<Truth> all;
  while (std::getline(file, line)) all.push_back(parse(line));
  REQUIRE(all.size() >= kMinLines);
  return all;
}

/// The largest error of a column, and its line in the file.
struct Worst {
  long double error = 0.0L;
  std::size_t line = 0;

  void see(long double its_error, std::size_t index) {
    if (its_error <= error) return;  // NaN is worse than all
    error = its_error;
    line = index + 2;
  }
};

void check(const char* column, const Worst& worst) {
  CAPTURE(column);
  CAPTURE(worst.line);
  CHECK(static_cast<double>(worst.error) <= static_cast<double>(kMaxError));
}

TEST_CASE("force, slope, energy, axial and lateral force agree with 120 digits") {
  const std::vector<Truth> all = read_truth();
  Worst force, force_alone, slope, secant, energy, axial, lateral;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Truth& truth = all[i];
    const Deflection ours = deflect(truth.string, truth.lambda, truth.displacement);
    force.see(relative_error(ours.force, truth.force), i);
    force_alone.see(relative_error(deflection_force(truth.string, truth.lambda, truth.displacement),
                                   truth.force),
                    i);
    slope.see(relative_error(ours.slope, truth.slope), i);
    const auto delta = static_cast<long double>(truth.displacement);
    secant.see(relative_error(ours.secant, truth.force / delta), i);
    energy.see(relative_error(ours.energy, truth.energy), i);
    axial.see(relative_error(ours.axial_force, truth.axial_force), i);
    lateral.see(relative_error(ours.lateral_force, truth.lateral_force), i);
  }
  check("force", force);
  check("deflection_force", force_alone);
  check("slope", slope);
  check("secant", secant);
  check("energy", energy);
  check("axial force", axial);
  check("lateral force", lateral);
}

TEST_CASE("the series law agrees with 120 digits, the ends and their jump included") {
  const std::vector<Truth> all = read_truth();
  Worst force, delta;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Truth& truth = all[i];
    const SeriesDeflection ours =
        deflect_in_series(truth.string, truth.lambda, truth.displacement, truth.stiffness);
    force.see(relative_error(ours.force, truth.series_force), i);
    // Relative to D: beside the jump delta is D less nearly all of it.
    const long double off = std::fabs(static_cast<long double>(ours.delta) - truth.series_delta);
    delta.see(off / static_cast<long double>(truth.displacement), i);
  }
  check("series force", force);
  check("series delta", delta);
}

}  // namespace
}  // namespace hapticd::test
