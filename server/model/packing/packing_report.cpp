// See packing_report.h.
#include "server/model/packing/packing_report.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/collision/blended_surface.h"
#include "core/geometry/closest_point.h"
#include "server/model/packing/counter_random.h"
#include "server/model/packing/parallel_chunks.h"
#include "server/model/packing/sphere_index.h"

namespace hapticd {
namespace {

/// Samples per chunk of work.
constexpr std::int64_t kChunk = 4096;
/// Most trials per wanted sample of the union. Normal value 64: where less than 1/64 of the
/// spheres' surface is visible the report has fewer samples; more costs time.
constexpr std::int64_t kMaxTrials = 64;
/// A point this share of its sphere's radius inside another sphere is not on the union's surface.
/// Normal value 1e-9; 0 would drop by rounding points of two equal spheres.
constexpr double kDepth = 1e-9;
/// Distances below this share of the diagonal count as 0, so that surface points on a sphere's very
/// boundary are not called uncovered for rounding. Normal value 1e-13.
constexpr double kTouching = 1e-13;
/// How near a point of a blended surface is to it, m, and the steps to get there; each leaves a
/// share of what is missing, by as much as the normal turns.
constexpr double kOnSurface = 1e-9;
constexpr int kSurfaceSteps = 30;

/// Streams of random numbers, added to the seed's.
enum Stream : std::uint64_t { kMeshPlace, kMeshPoint, kSpherePlace, kSpherePoint };

std::uint64_t stream(const ReportOptions& options, Stream which) {
  return scrambled(options.seed) + which;
}

/// Sums from the first to the i-th entry.
std::vector<double> cumulated(const std::vector<double>& areas) {
  std::vector<double> sums;
  sums.reserve(areas.size());
  double sum = 0.0;
  for (const double area : areas) sums.push_back(sum += area);
  return sums;
}

/// Index whose share of the whole `place` in [0, 1) falls into.
std::int32_t pick(const std::vector<double>& sums, double place) {
  const auto it = std::upper_bound(sums.begin(), sums.end() - 1, place * sums.back());
  return static_cast<std::int32_t>(it - sums.begin());
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Value at the given share of the sorted `values`.
double percentile(const std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

DistanceStatistics statistics(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  return {values.empty() ? 0.0 : values.back(), mean_of(values), percentile(values, 0.99)};
}

std::vector<double> triangle_areas(const TriangleMesh& mesh) {
  std::vector<double> areas;
  for (const Triangle& t : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    areas.push_back(0.5 * length((b - a).cross(c - a)));
  }
  return areas;
}

/// Point `i` of the surface: first every vertex, then uniform by area.
Vector3 mesh_point(const TriangleMesh& mesh, const std::vector<double>& sums,
                   const ReportOptions& options, std::int64_t i) {
  const auto vertices = static_cast<std::int64_t>(mesh.vertices.size());
  if (i < vertices) return mesh.vertices[static_cast<std::size_t>(i)];
  const auto k = static_cast<std::uint64_t>(i - vertices);
  // Stratified over the area.
  const double place = (static_cast<double>(k) + counter_uniform(stream(options, kMeshPlace), k)) /
                       static_cast<double>(options.samples);
  const auto [a, b, c] = corners(mesh, mesh.triangles[static_cast<std::size_t>(pick(sums, place))]);
  const double root = std::sqrt(counter_uniform(stream(options, kMeshPoint), 2 * k));
  const double other = root * counter_uniform(stream(options, kMeshPoint), 2 * k + 1);
  return (1.0 - root) * a + (root - other) * b + other * c;
}

void report_inside(const TriangleMesh& mesh, const SphereIndex& index, const ReportOptions& options,
                   PackingReport& report) {
  const std::vector<double> sums = cumulated(triangle_areas(mesh));
  report.mesh_samples = static_cast<std::int64_t>(mesh.vertices.size()) + options.samples;
  std::vector<double> gaps(static_cast<std::size_t>(report.mesh_samples));
  for_chunks(report.mesh_samples, kChunk, options.threads,
             [&](std::int64_t, std::int64_t begin, std::int64_t end) {
               for (std::int64_t i = begin; i < end; ++i) {
                 const Vector3 p = mesh_point(mesh, sums, options, i);
                 const double gap = options.blend != nullptr
                                        ? place_beside_blend(*options.blend, p).distance
                                        : index.nearest(p).gap;
                 gaps[static_cast<std::size_t>(i)] = gap > kTouching * report.diagonal ? gap : 0.0;
               }
             });
  const auto covered = std::count(gaps.begin(), gaps.end(), 0.0);
  report.uncovered =
      static_cast<double>(report.mesh_samples - covered) / static_cast<double>(report.mesh_samples);
  report.inside = statistics(gaps);
}

/// The point of a blended surface that `p`, next to it, is led to along its normal.
Vector3 onto_blend(const SphereTreeView& tree, Vector3 p) {
  for (int step = 0; step < kSurfaceSteps; ++step) {
    const BlendedPlace place = place_beside_blend(tree, p);
    p -= place.distance * place.nhat_B;
    if (std::abs(place.distance) <= kOnSurface) break;
  }
  return p;
}

/// Of the trials from `begin` to `end`: signed distances to the mesh of those on the union's
/// surface.
std::vector<double> visible_distances(const MeshDistance& distance, std::span<const Sphere> spheres,
                                      const SphereIndex& index, const std::vector<double>& sums,
                                      const ReportOptions& options, std::int64_t begin,
                                      std::int64_t end) {
  std::vector<double> found;
  for (std::int64_t i = begin; i < end; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    // Stratified over the area in every round of options.samples trials.
    const double place = (static_cast<double>(i % options.samples) +
                          counter_uniform(stream(options, kSpherePlace), k)) /
                         static_cast<double>(options.samples);
    const std::int32_t s = pick(sums, place);
    const Sphere& sphere = spheres[static_cast<std::size_t>(s)];
    const Vector3 p = sphere.p + sphere.r * counter_direction(stream(options, kSpherePoint), k);
    if (index.inside_another(p, s, kDepth * sphere.r)) continue;
    const Vector3 surface = options.blend != nullptr ? onto_blend(*options.blend, p) : p;
    found.push_back(distance.signed_distance(surface));
  }
  return found;
}

void report_outside(const MeshDistance& distance, std::span<const Sphere> spheres,
                    const SphereIndex& index, const ReportOptions& options, PackingReport& report) {
  std::vector<double> areas;
  for (const Sphere& s : spheres) areas.push_back(s.r * s.r);
  const std::vector<double> sums = cumulated(areas);
  std::vector<double> outside;
  for (std::int64_t round = 0; round < kMaxTrials && report.sphere_samples < options.samples;
       ++round) {
    std::vector<std::vector<double>> found(
        static_cast<std::size_t>(chunk_count(options.samples, kChunk)));
    for_chunks(options.samples, kChunk, options.threads,
               [&](std::int64_t chunk, std::int64_t begin, std::int64_t end) {
                 const std::int64_t first = round * options.samples;
                 found[static_cast<std::size_t>(chunk)] = visible_distances(
                     distance, spheres, index, sums, options, first + begin, first + end);
               });
    for (const std::vector<double>& part : found) {
      report.sphere_samples += static_cast<std::int64_t>(part.size());
      for (const double d : part) {
        if (d > 0.0) outside.push_back(d);
      }
    }
  }
  report.outside = statistics(outside);
  report.scallop = report.outside.p99 - percentile(outside, 0.01);
}

}  // namespace

PackingReport report_packing(const TriangleMesh& mesh, const MeshDistance& distance,
                             std::span<const Sphere> spheres, const ReportOptions& options) {
  if (options.samples < 1 || options.threads < 1) {
    throw std::invalid_argument("packing report: samples and threads must be at least 1");
  }
  if (spheres.empty()) throw std::invalid_argument("packing report: no spheres");
  PackingReport report;
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  report.diagonal = length(high - low);
  const SphereIndex index(spheres);
  report_inside(mesh, index, options, report);
  report_outside(distance, spheres, index, options, report);
  return report;
}

}  // namespace hapticd
