// The Guqin: dimensions, places of strings and markers, and that strings clear the wood. Distances
// by exhaustive search.
#include "server/model/shapes/guqin_model.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "tests/server/model/packing/test_meshes.h"
#include "tests/server/model/shapes/guqin_strings.h"
#include "tests/server/model/shapes/mesh_measures.h"
#include "tests/server/model/shapes/relative.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

Vector3 point_at(const GuqinString& string, double lambda) {
  return string.p_WA + lambda * (string.p_WB - string.p_WA);
}

/// Least distance between the surfaces of a string and a mesh at `count` places from begin to end.
double clearance(const GuqinString& string, const TriangleMesh& mesh, double begin, double end,
                 int count) {
  long double least = 1.0L;
  for (int k = 0; k <= count; ++k) {
    const Vector3 p = point_at(string, begin + (end - begin) * k / count);
    least = std::min(least, exhaustive_distance(mesh, p));
  }
  return static_cast<double>(least) - string.radius;
}

std::string complaint(const GuqinParameters& parameters) {
  try {
    static_cast<void>(make_guqin_body(parameters));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// All parameters up to `share` of their default away from it.
GuqinParameters varied(SplitMix64& random, double share) {
  GuqinParameters parameters;
  for (const auto& field : kGuqinFields) {
    double& value = parameters.*field.member;
    value = std::clamp(value * random.uniform(1.0 - share, 1.0 + share), field.range.low,
                       field.range.high);
  }
  return parameters;
}

}  // namespace

TEST_CASE("the body has the length, width and thickness it is given, its crown at y = 0") {
  GuqinParameters p;
  for (const double scale : {1.0, 1.04}) {
    p.length = 1.22 * scale;
    p.shoulder_width = 0.2 * scale;
    const TriangleMesh mesh = make_guqin_body(p);
    const MeshMeasures measures = measure(mesh);
    CHECK(measures.closed);
    CHECK(measures.euler == 2);
    CHECK(mesh.triangles.size() <= 12'000);
    const Vector3 size = measures.high - measures.low;
    CHECK(size.x() == relative(p.length, 1e-9));
    CHECK(size.z() == relative(p.shoulder_width, 0.002));
    CHECK(measures.high.y() == 0.0);
    CHECK(-measures.low.y() == relative(p.thickness, 0.01));
    CHECK(measures.high.x() == relative(0.5 * p.string_length + p.head, 1e-9));
  }
}

TEST_CASE("the body is the same on both sides of the middle, to the bit") {
  const TriangleMesh mesh = make_guqin_body({});
  std::set<std::tuple<double, double, double>> places;
  for (const Vector3& p : mesh.vertices) places.emplace(p.x(), p.y(), p.z());
  for (const Vector3& p : mesh.vertices) REQUIRE(places.count({p.x(), p.y(), -p.z()}) == 1);
}

TEST_CASE("the outline is drawn in at neck and waist by the depths given") {
  GuqinParameters with;
  GuqinParameters without = with;
  without.neck = without.waist = 0.0;
  double neck = 0.0;
  double waist = 0.0;
  for (int k = 0; k <= 1000; ++k) {
    const double x = -0.5 + k * 1e-3;
    const double depth = guqin_half_width(without, x) - guqin_half_width(with, x);
    CHECK(depth >= 0.0);
    (x > 0.3 ? neck : waist) = std::max(x > 0.3 ? neck : waist, depth);
    // Marker 7 and the shoulder at marker 3 are outside both.
    if (std::fabs(x) < 0.01 || std::fabs(x - 0.33) < 0.01) CHECK(depth < 1e-12);
  }
  CHECK(neck == relative(with.neck, 1e-9));
  CHECK(waist == relative(with.waist, 1e-9));
  // Markers 8 to 11 are at 3/5 to 4/5.
  CHECK(guqin_half_width(without, 1.1 * (0.5 - 0.7)) - guqin_half_width(with, 1.1 * (0.5 - 0.7)) ==
        relative(with.waist, 1e-9));
}

TEST_CASE("head and tail have the widths given, just inside their round corners") {
  const GuqinParameters p;
  const double head_end = 0.5 * p.string_length + p.head;
  CHECK(guqin_half_width(p, head_end - 0.015) == relative(0.5 * p.head_width, 0.01));
  const double tail_end = head_end - p.length;
  CHECK(guqin_half_width(p, tail_end + 0.015) == relative(0.5 * p.tail_width, 0.01));
  CHECK(guqin_half_width(p, tail_end) < 0.5 * p.tail_width - 0.005);
}

TEST_CASE("vertices of the top lie on the height that guqin_top states") {
  const GuqinParameters p;
  int checked = 0;
  for (const Vector3& q : make_guqin_body(p).vertices) {
    const bool on_top = q.y() > -0.012 && std::fabs(q.x()) < 0.5 * p.string_length &&
                        std::fabs(q.z()) < guqin_half_width(p, q.x()) - 1.5 * p.edge;
    if (!on_top) continue;
    ++checked;
    // A circle of the given radius across.
    const double fall = p.crown_radius - std::sqrt(p.crown_radius * p.crown_radius - q.z() * q.z());
    REQUIRE(std::fabs(q.y() + fall) < 1e-12);
    REQUIRE(std::fabs(guqin_top(p, q.x(), q.z()) - q.y()) < 1e-12);
  }
  CHECK(checked > 500);
}

TEST_CASE("seven strings, thick to thin and far to near, spread from gum to bridge") {
  const GuqinParameters p;
  const auto strings = guqin_strings(p);
  for (std::size_t i = 0; i < strings.size(); ++i) {
    CHECK(strings[i].p_WA.x() == 0.55);
    CHECK(strings[i].p_WB.x() == -0.55);
    const double order = static_cast<double>(i) - 3.0;
    CHECK(std::fabs(strings[i].p_WA.z() - order * p.bridge_spacing) < 1e-15);
    CHECK(std::fabs(strings[i].p_WB.z() - order * p.gum_spacing) < 1e-15);
    if (i == 0) continue;
    CHECK(strings[i].radius < strings[i - 1].radius);
    CHECK(strings[i].frequency > strings[i - 1].frequency);
  }
  CHECK(strings[6].radius == p.string_radius);
  CHECK(strings[0].frequency == 65.4);
  CHECK(strings[6].frequency == 146.8);
  // Equal tension T = pi r^2 rho (2 L f)^2.
  CHECK(strings[0].radius * 65.4 == relative(strings[6].radius * 146.8, 1e-9));
}

TEST_CASE(
    "strings keep clear of the body: a finger's thickness at the bridge, 2 to 4 mm at the gum") {
  const TriangleMesh body = make_guqin_body({});
  for (const GuqinString& string : guqin_strings({})) {
    const double at_bridge = clearance(string, body, 0.02, 0.1, 3);
    CHECK(at_bridge > 0.008);
    CHECK(at_bridge < 0.011);
    const double at_gum = clearance(string, body, 0.9, 0.98, 3);
    CHECK(at_gum > 0.002);
    CHECK(at_gum < 0.004);
    CHECK(clearance(string, body, 0.0, 1.0, 30) > 0.002);
  }
}

TEST_CASE("strings rest on bridge and gum with the gap given, and touch neither") {
  const GuqinParameters p;
  const TriangleMesh bridge = make_guqin_bridge(p);
  const TriangleMesh gum = make_guqin_gum(p);
  for (const GuqinString& string : guqin_strings(p)) {
    // The crest's facets lie a little inside it.
    const double on_bridge = clearance(string, bridge, 0.0, 0.01, 50);
    CHECK(on_bridge > 0.98 * p.rest_gap);
    CHECK(on_bridge < p.rest_gap + 3e-5);
    const double on_gum = clearance(string, gum, 0.99, 1.0, 50);
    CHECK(on_gum > 0.98 * p.rest_gap);
    CHECK(on_gum < p.rest_gap + 3e-5);
    CHECK(winding_number(bridge, string.p_WA) < 0.5L);
    CHECK(winding_number(gum, string.p_WB) < 0.5L);
  }
}

TEST_CASE("bridge and gum stand in the top and under all strings") {
  const GuqinParameters p;
  for (const bool at_bridge : {true, false}) {
    const MeshMeasures measures = measure(at_bridge ? make_guqin_bridge(p) : make_guqin_gum(p));
    const double spacing = at_bridge ? p.bridge_spacing : p.gum_spacing;
    CHECK(measures.high.z() > 3.0 * spacing + 0.005);
    CHECK(measures.high.z() < guqin_half_width(p, at_bridge ? 0.55 : -0.55));
    CHECK(measures.high.y() == relative(at_bridge ? p.bridge_height : p.gum_height, 1e-9));
  }
}

TEST_CASE("thirteen markers lie beyond string 1 at their shares of the string, half in the top") {
  const GuqinParameters p;
  const TriangleMesh all = make_guqin_hui(p);
  CHECK(measure(all).pieces == 13);
  const auto per_marker = all.vertices.size() / 13;
  const std::array<double, 13> shares{1. / 8, 1. / 6, 1. / 5, 1. / 4, 1. / 3, 2. / 5, 1. / 2,
                                      3. / 5, 2. / 3, 3. / 4, 4. / 5, 5. / 6, 7. / 8};
  const GuqinString lowest = guqin_strings(p)[0];
  for (std::size_t m = 0; m < 13; ++m) {
    Vector3 low = all.vertices[m * per_marker];
    Vector3 high = low;
    double above = -1.0;
    double below = 1.0;
    for (std::size_t i = m * per_marker; i < (m + 1) * per_marker; ++i) {
      const Vector3& q = all.vertices[i];
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
      const double height = q.y() - guqin_top(p, q.x(), q.z());
      above = std::max(above, height);
      below = std::min(below, height);
    }
    CHECK(std::fabs(0.5 * (low.x() + high.x()) - 1.1 * (0.5 - shares[m])) < 1e-12);
    CHECK(high.z() < point_at(lowest, shares[m]).z() - 0.002);
    CHECK(low.z() > -guqin_half_width(p, low.x()) + 0.002);
    CHECK(above > 1e-4);
    CHECK(above < 5e-4);
    CHECK(below < -5e-4);
  }
}

TEST_CASE("seven pegs and two feet hang below the body") {
  const GuqinParameters p;
  const double underside = measure(make_guqin_body(p)).low.y();
  for (const bool pegs : {true, false}) {
    const MeshMeasures measures = measure(pegs ? make_guqin_pegs(p) : make_guqin_feet(p));
    CHECK(measures.closed);
    CHECK(measures.pieces == (pegs ? 7 : 2));
    CHECK(measures.euler == 2 * measures.pieces);
    CHECK(measures.low.y() < underside - 0.01);
    // Pegs are under the head, beyond the bridge.
    if (pegs) CHECK(measures.low.x() > 0.55);
  }
}

TEST_CASE("a Guqin of other measures is sound, with its strings clear, or refused with a reason") {
  SplitMix64 random(1);
  for (std::int64_t k = 0; k < scaled(150); ++k) {
    const GuqinParameters p = varied(random, k == 0 ? 0.0 : 0.03 + 0.1 * random.uniform());
    const std::string reason = complaint(p);
    if (k > 0 && !reason.empty()) {
      CHECK(reason.find("guqin: ") == 0);
      continue;
    }
    const TriangleMesh body = make_guqin_body(p);
    const MeshMeasures measures = measure(body);
    REQUIRE(measures.closed);
    REQUIRE(measures.euler == 2);
    REQUIRE(measures.volume > 0.0L);
    REQUIRE(measures.flattest > 1e-4L);
    const auto strings = guqin_strings(p);
    const GuqinString& string = strings[static_cast<std::size_t>(random.below(7))];
    REQUIRE(clearance(string, body, 0.0, 1.0, 4) > 0.5 * p.gum_height);
  }
}

TEST_CASE("measures that do not go together are refused by name") {
  GuqinParameters p;
  p.length = 3.0;
  CHECK(complaint(p) == "guqin: length is 3, must be from 0.6 to 2 m");
  p = {};
  p.string_length = 1.15;
  CHECK(complaint(p).find("string_length") != std::string::npos);
  p = {};
  p.bridge_spacing = 0.035;
  CHECK(complaint(p).find("bridge_spacing") != std::string::npos);
  p = {};
  p.shoulder_width = 0.15;
  CHECK(complaint(p).find("shoulder_width") != std::string::npos);
  p = {};
  p.thickness = p.end_thickness = 0.03;
  CHECK(complaint(p).find("thickness") != std::string::npos);
  p = {};
  p.neck = std::nan("");
  CHECK(complaint(p).find("neck") != std::string::npos);
}

}  // namespace hapticd::test
